#!/usr/bin/env bash
# coverage.sh FOLDER TARGET...: runs each fuzz target over its corpora (what make
# fuzz found, what is in the tree, what seeds.py makes) and says which share of
# the lines of each parser was reached. Fails where one is below 85 %.
set -euo pipefail
out=$1
shift
objects=()
seeds=$out/seeds
/usr/bin/python3 -B tests/fuzz/seeds.py "$seeds"
for target; do
    name=$(basename "$target")
    folders=()
    for folder in "build/corpus/$name" "tests/fuzz/corpus/$name" \
        "$seeds/$name"; do
        [ -d "$folder" ] && folders+=("$folder")
    done
    LLVM_PROFILE_FILE=$out/$name.profraw "$target" -runs=0 "${folders[@]}" \
        2>"$out/$name.log" || { tail -5 "$out/$name.log"; exit 1; }
    objects+=(-object "$target")
done
llvm-profdata merge -sparse -o "$out/all.profdata" "$out"/*.profraw
parsers=(proto/json.c proto/jsonread.c proto/patch.c proto/path.c
    proto/pelog.c proto/ranges.c proto/wire.c proto/message.c proto/unpack.c
    server/net/http_request.c server/net/http_route.c server/net/http_view.c
    server/bridges/ais.c server/bridges/cigi.c server/bridges/cigi_packet.c
    server/bridges/cigi_world.c server/bridges/cigi_weather.c
    server/bridges/console_table.c server/bridges/modbus_adu.c
    server/bridges/modbus_map.c server/bridges/nmea_parse.c
    server/bridges/nmea_values.c server/bridges/nmea_targets.c
    server/scene/metar.c server/scene/edit.c server/scene/viewplace.c
    server/scene/waypoints.c server/scene/cameras.c
    server/continents/reader/coastlines.c)
llvm-cov export -summary-only "${objects[@]:1}" \
    -instr-profile="$out/all.profdata" "${parsers[@]}" >"$out/summary.json"
/usr/bin/python3 - "$out/summary.json" <<'END' | tee "$out/report.txt"
import json, os, sys
with open(sys.argv[1], encoding="utf-8") as f:
    files = json.load(f)["data"][0]["files"]
below = 0
for each in sorted(files, key=lambda e: e["summary"]["lines"]["percent"]):
    share = each["summary"]["lines"]["percent"]
    below += share < 85
    print(f"{share:6.1f} %  {os.path.relpath(each['filename'])}")
print(f"{below} of {len(files)} parsers below 85 % of their lines")
sys.exit(below > 0)
END
