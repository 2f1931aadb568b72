#!/bin/sh
# The quick form of `make validate-seatrace`: a flat sea reflects by Fresnel's
# equations; the rows of rough seas are shown, and too few to be judged.
set -eu
cd "$(dirname "$0")/.."
exec /usr/bin/python3 -B tests/validate/seatrace/seatrace.py --quick --assert flat
