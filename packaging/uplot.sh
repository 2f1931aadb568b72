#!/bin/sh
# uplot.sh DIRECTORY OUT: OUT says which uPlot lies in DIRECTORY, or `none`; it
# is written only where that is another than before.
set -eu

found=none
if [ -f "$1/dist/uPlot.iife.min.js" ] && [ -f "$1/dist/uPlot.min.css" ] &&
    [ -f "$1/LICENSE" ]; then
    found=$(cat "$1/dist/uPlot.iife.min.js" "$1/dist/uPlot.min.css" \
        "$1/LICENSE" | sha256sum)
fi
[ "$(cat "$2" 2>/dev/null || true)" = "$found" ] && exit 0
if [ "$found" = none ]; then
    echo "page: no uPlot in $1, so the sea-state card has no diagrams;" \
        "\`make deps-page\` fetches it from npm's registry, and" \
        "UPLOT=DIRECTORY names one that was fetched before" >&2
fi
echo "$found" >"$2"
