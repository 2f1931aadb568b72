#!/bin/sh
# proto/*.md and the Python classes say what the schema and the tables say; and
# a schema that lacks a unit, or has a range that cannot be read, does not pass.
set -eu
cd "$(dirname "$0")/.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

/usr/bin/python3 proto/fields.py manual proto/pelagos.proto \
    "$folder/manual.md" proto/manual.in.md
diff -u proto/manual.md "$folder/manual.md" || {
    echo "proto/manual.md is not current: run make manual"
    exit 1
}
/usr/bin/python3 proto/fields.py python proto/pelagos.proto \
    "$folder/schema.py" "$(cat VERSION)"
diff -u clients/python/pelagos/schema.py "$folder/schema.py" || {
    echo "clients/python/pelagos/schema.py is not current: run make manual"
    exit 1
}

# The others are what their programs make of their texts.
bin=${PELAGOS_BIN:-build/release/bin}
bin=${bin#"$PWD/"}
for text in proto/*.in.md; do
    name=$(basename "$text" .in.md)
    [ "$name" != manual ] || continue
    [ -x "$bin/${name}_doc" ] || make --no-print-directory "$bin/${name}_doc"
    "$bin/${name}_doc" <"$text" >"$folder/$name.md"
    diff -u "proto/$name.md" "$folder/$name.md" || {
        echo "proto/$name.md is not current: run make $name"
        exit 1
    }
done

refused() {
    sed "$1" proto/pelagos.proto > "$folder/pelagos.proto"
    if cmp -s proto/pelagos.proto "$folder/pelagos.proto"; then
        echo "nothing changed by $1"
        exit 1
    fi
    if /usr/bin/python3 proto/fields.py c "$folder/pelagos.proto" \
        "$folder/out.c" 2> "$folder/log"; then
        echo "accepted: $1"
        exit 1
    fi
    grep -q "$2" "$folder/log" || { cat "$folder/log"; exit 1; }
}
refused 's/ \[m\/s; 0 \.\. 30\]//' 'Sea.wind_speed is a number without a unit'
refused 's/\[m\/s; 0 \.\. 30\]/[m\/s; 0 to 30]/' 'cannot read the range'
refused 's/\[m\/s; 0 \.\. 30\]/[m\/s; 30 .. 0]/' 'empty range'
refused 's/optional Sky sky = 5;/optional State sky = 5;/' 'contains itself'
