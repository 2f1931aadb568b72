#!/bin/sh
# embedded.sh DIRECTORY OUT NAME=FILE...: what of the packages in DIRECTORY the
# page embeds. OUT gets, a line each, NAME=DIRECTORY/FILE of those packages that
# are there whole, and what they are by; it is written only where that is other
# than before. A package is the first folder of FILE.
set -eu

from=$1
out=$2
shift 2
found=
missing=
for each in "$@"; do
    file=$from/${each#*=}
    package=${each#*=}
    package=${package%%/*}
    if [ -f "$file" ]; then
        found="$found${each%%=*}=$file $(sha256sum <"$file" | cut -c 1-16)
"
    else
        case " $missing " in *" $package "*) ;; *) missing="$missing $package" ;; esac
    fi
done
for package in $missing; do
    found=$(printf '%s\n' "$found" | grep -v "=$from/$package/" || true)
done
found=$(printf '%s' "$found") # as the shell reads a file
[ "$(cat "$out" 2>/dev/null || echo none)" = "$found" ] && exit 0
for package in $missing; do
    case $package in
    uplot) lacks="the sea-state card has no diagrams" ;;
    *) lacks="views do not fall back to HLS" ;;
    esac
    echo "page: no $package in $from, so $lacks;" \
        "\`make deps-page\` fetches it from npm's registry, and" \
        "THIRD=DIRECTORY names a folder of packages fetched before" >&2
done
printf '%s\n' "$found" >"$out"
