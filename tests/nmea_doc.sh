#!/bin/sh
# proto/nmea.md is what nmea.in.md and the list of sentences say.
set -eu
cd "$(dirname "$0")/.."
bin=${PELAGOS_BIN:-build/release/bin}
bin=${bin#"$PWD/"}
[ -x "$bin/nmea_doc" ] || make --no-print-directory "$bin/nmea_doc"
if ! "$bin/nmea_doc" proto/nmea.in.md | diff -u proto/nmea.md -; then
    echo "proto/nmea.md is old: run \`make nmea\`"
    exit 1
fi
