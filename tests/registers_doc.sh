#!/bin/sh
# proto/registers.md is what registers.def and the schema say.
set -eu
cd "$(dirname "$0")/.."
bin=${PELAGOS_BIN:-build/release/bin}
bin=${bin#"$PWD/"}
[ -x "$bin/registers_doc" ] || make --no-print-directory "$bin/registers_doc"
if ! "$bin/registers_doc" | diff -u proto/registers.md -; then
    echo "proto/registers.md is old: run \`make registers\`"
    exit 1
fi
