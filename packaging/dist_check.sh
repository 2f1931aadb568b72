#!/bin/sh
# dist_check.sh TARBALL VERSION: it unpacks to one folder, builds there without
# git, installs, and the program says its version.
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
tar -xf "$1" -C "$work"
[ "$(ls "$work")" = "pelagos-$2" ] || { echo "it has: $(ls "$work")"; exit 1; }
cd "$work/pelagos-$2"
unset MAKEFLAGS MAKELEVEL
make -s -j"$(nproc)" DEPS=skip DESTDIR="$work/root" install >/dev/null
said=$("$work/root/usr/local/bin/pelagosd" --version)
[ "$said" = "pelagosd $2" ] || { echo "it says: $said"; exit 1; }
echo "dist: builds, installs and says \`$said\`"
