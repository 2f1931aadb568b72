#!/bin/sh
# proto/cigi.md is what cigi.in.md and the field table say.
set -eu
cd "$(dirname "$0")/.."
bin=${PELAGOS_BIN:-build/release/bin}
bin=${bin#"$PWD/"}
[ -x "$bin/cigi_doc" ] || make --no-print-directory "$bin/cigi_doc"
if ! "$bin/cigi_doc" proto/cigi.in.md | diff -u proto/cigi.md -; then
    echo "proto/cigi.md is old: run \`make cigi\`"
    exit 1
fi
