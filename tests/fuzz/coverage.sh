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
    proto/pelog.c proto/ranges.c proto/wire.c proto/message.c proto/sweep.c
    proto/unpack.c
    server/net/http_{auth,exercise,live,optics,preset,request}.c
    server/net/http_{route,series,set,view}.c server/net/series_plan.c
    server/net/{hls,roles,token,websocket,whepoffer}.c
    server/bridges/{ais,console_table,modbus_adu,modbus_map}.c
    server/bridges/cigi{,_areas,_conditions,_entities,_layers,_lights}.c
    server/bridges/cigi_{packet,pose,query,sensor,weather,world}.c
    server/bridges/nmea_{parse,values,targets}.c
    server/scene/{metar,edit,viewplace,waypoints,cameras,presets}.c
    server/scene/{exercisecheck,exercisewhen}.c
    server/cluster/{etcdtext,seals_etcd}.c
    server/models/{describe,model,modelload,modelwire}.c
    server/models/reader/{gltfcheck,picture}.c
    server/ocean/{ndbc,spectrumfile}.c
    server/ocean/reader/{netcdfform,shelf,textforms}.c
    server/panorama/{panorama,panoramaload}.c
    server/panorama/reader/{equirect,equirectexr,equirectrgbe}.c
    server/seabed/{load,seabed,wire}.c server/seabed/reader/{exr,gdal,geo}.c
    server/seabed/reader/hdf5.c server/weather/{load,weather,wire}.c
    server/weather/reader/{axis,calendar,forecast,gribfile,names}.c
    server/weather/reader/{netcdfaxes,netcdffile,units}.c
    server/continents/continents.c server/continents/reader/coastlines.c)
llvm-cov export -summary-only "${objects[@]:1}" \
    -instr-profile="$out/all.profdata" "${parsers[@]}" >"$out/summary.json"
/usr/bin/python3 - "$out/summary.json" "${#parsers[@]}" <<'END' | tee "$out/report.txt"
import json, os, sys
with open(sys.argv[1], encoding="utf-8") as f:
    files = json.load(f)["data"][0]["files"]
below = 0
for each in sorted(files, key=lambda e: e["summary"]["lines"]["percent"]):
    share = each["summary"]["lines"]["percent"]
    below += share < 85
    print(f"{share:6.1f} %  {os.path.relpath(each['filename'])}")
print(f"{below} of {len(files)} parsers below 85 % of their lines")
if len(files) != int(sys.argv[2]):
    sys.exit("no target has all of them in it")
sys.exit(below > 0)
END
