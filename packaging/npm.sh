#!/bin/sh
# npm.sh DIRECTORY NAME@VERSION...: installs the npm packages into DIRECTORY,
# those and no others. Without npm or its registry it says so and goes on: tests
# that want them are skipped, the page is built without diagrams. DEPS=skip does
# nothing.
set -eu

if [ "${DEPS:-}" = skip ]; then
    exit 0
fi
cd "$(dirname "$0")/.."
into=$1
shift
missing=
for package in "$@"; do
    found=$(sed -n 's/^[[:space:]]*"version": "\([^"]*\)".*/\1/p' \
        "$into/node_modules/${package%@*}/package.json" 2>/dev/null |
        head -n 1 || true)
    [ "$found" = "${package##*@}" ] || missing="$missing $package"
done
if [ -z "$missing" ]; then
    exit 0
fi
if ! command -v npm >/dev/null; then
    packaging/deps.sh nodejs npm || true
fi
echo "deps: npm installs$missing into $into"
mkdir -p "$into"
# All of them: npm removes what it is not told of.
npm install --prefix "$into" --silent --no-audit --no-fund --no-save \
    --omit=optional --ignore-scripts "$@" </dev/null >/dev/null 2>&1 ||
    echo "deps: npm could not:$missing" >&2
