#!/bin/sh
# Makes a wheel of clients/python in the folder $1, from a copy: setuptools
# writes beside what it builds.
set -eu
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp -r clients/python "$work/python"
find "$work" -name __pycache__ -prune -exec rm -rf {} +
cp LICENSE "$work/python"
# The same file at any time.
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-315532800} /usr/bin/python3 -m pip wheel \
    --quiet --no-deps --no-index --no-build-isolation --wheel-dir "$work/out" \
    "$work/python"
mkdir -p "$1"
mv "$work"/out/*.whl "$1"
ls "$1"/pelagos-*.whl
