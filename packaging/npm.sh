#!/bin/sh
# Installs the npm packages named as arguments (NAME@VERSION) into build/npm,
# for tests only. Without npm or its registry it says so, and the tests that
# want them are skipped. DEPS=skip does nothing.
set -eu

if [ "${DEPS:-}" = skip ]; then
    exit 0
fi
cd "$(dirname "$0")/.."
missing=
for package in "$@"; do
    found=$(sed -n 's/^  "version": "\(.*\)",*$/\1/p' \
        "build/npm/node_modules/${package%@*}/package.json" 2>/dev/null ||
        true)
    [ "$found" = "${package##*@}" ] || missing="$missing $package"
done
if [ -z "$missing" ]; then
    exit 0
fi
if ! command -v npm >/dev/null; then
    packaging/deps.sh nodejs npm || true
fi
echo "deps: npm installs$missing into build/npm"
mkdir -p build/npm
npm install --prefix build/npm --silent --no-audit --no-fund --no-save \
    --omit=optional --ignore-scripts $missing </dev/null >/dev/null 2>&1 ||
    echo "deps: npm could not; tests with$missing are left out" >&2
