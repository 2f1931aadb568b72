#!/bin/sh
# Builds GLib for ThreadSanitizer into the folder OUT, of the source of the
# package that is installed: its locks are futexes, and what a thread hands to
# another by them looks like a race where the checker cannot see them. Programs of
# FLAVOR=tsan find it by their RPATH, and so do the libraries that they load.
# Three minutes of two cores; nothing where it is there already.
set -eu

out=${1:?usage: tsan_glib.sh OUT}
version=$(dpkg-query -W -f '${source:Version}' libglib2.0-0)
made="$version $(cksum <"$0")"
if [ "$(cat "$out/made" 2>/dev/null)" = "$made" ]; then
    exit 0
fi
echo "  GLIB  $out"
"$(dirname "$0")/deps.sh" meson ninja-build dpkg-dev libffi-dev libpcre2-dev \
    zlib1g-dev
rm -rf "$out"
mkdir -p "$out"
out=$(cd "$out" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

# The sources of the suites that packages come from, for this one question.
mkdir -p lists/partial parts
for list in /etc/apt/sources.list.d/*.sources; do
    if [ -e "$list" ]; then
        sed 's/^Types:.*/Types: deb-src/' "$list" >"parts/${list##*/}"
    fi
done
for list in /etc/apt/sources.list /etc/apt/sources.list.d/*.list; do
    if [ -e "$list" ]; then
        sed -n 's/^deb /deb-src /p' "$list" >>parts/own.list
    fi
done
sources() {
    apt-get -qq -o APT::Sandbox::User=root -o Dir::Etc::sourcelist=/dev/null \
        -o "Dir::Etc::sourceparts=$work/parts" \
        -o "Dir::State::lists=$work/lists" "$@"
}
sources update
sources source --download-only "glib2.0=$version"
dpkg-source --no-check -x glib2.0_*.dsc glib >/dev/null
# Locks of single bits, which it has in assembly, by atomics that are seen.
find glib -name 'gbitlock*' -exec sed -i 's/^ *#define USE_ASM_GOTO 1//' {} +

CFLAGS='-O1 -g -fsanitize=thread -w' LDFLAGS=-fsanitize=thread \
    meson setup made glib --prefix="$out" --libdir=lib -Dlibmount=disabled \
    -Dselinux=disabled -Dlibelf=disabled -Dtests=false -Dxattr=false \
    -Dnls=disabled -Dglib_debug=disabled -Db_lundef=false >meson.log ||
    { tail -n 20 meson.log; exit 1; }
ninja -C made >ninja.log || { tail -n 20 ninja.log; exit 1; }
ninja -C made install >/dev/null
echo "$made" >"$out/made"
