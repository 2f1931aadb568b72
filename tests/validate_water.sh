#!/bin/sh
# The quick form of `make validate-water`: light in the water against a Monte
# Carlo, with the bounds that so few paths allow.
set -eu
cd "$(dirname "$0")/.."
status=0
"${PELAGOS_BIN:-build/release/bin}/validate_water" --quick || status=$?
tail -n +1 build/validate/quick/water.md
[ $status -eq 0 ] || echo "FAILED: the water is off (status $status)"
exit $status
