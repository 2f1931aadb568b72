#!/bin/sh
# The quick form of `make validate-lighting`: rows of the picture against brute
# force, with the bounds that so few rays allow.
set -eu
cd "$(dirname "$0")/.."
folder=build/validate/quick
mkdir -p $folder
status=0
"${PELAGOS_BIN:-build/release/bin}/lighting" $folder --quick || status=$?
cat $folder/lighting.md
[ $status -eq 0 ] || echo "FAILED: a part of the light is off (status $status)"
exit $status
