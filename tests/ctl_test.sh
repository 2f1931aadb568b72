#!/usr/bin/env bash
# pelagosctl and libpelagos against a running pelagosd, every command.
set -u
cd "$(dirname "$0")/.."
. tests/lib/daemon.sh
ctl=$work/pelagosctl
cat >"$ctl" <<SH
#!/bin/sh
exec "$PELAGOS_BIN/pelagosctl" --timeout 60 "\$@"
SH
chmod +x "$ctl"
out=$work/out err=$work/err

# run STATUS COMMAND…: pelagosctl ends with STATUS.
run() {
    local wanted=$1
    shift
    "$ctl" "$@" >"$out" 2>"$err"
    local status=$?
    [ $status -eq "$wanted" ] ||
        fail "pelagosctl $*: status $status, not $wanted: $(cat "$err")"
}
# says TEXT: the last command printed it (on either stream).
says() {
    cat "$out" "$err" | grep -qF -- "$1" ||
        fail "no \"$1\" in: $(cat "$out" "$err")"
}
is() {
    [ "$(cat "$out")" = "$1" ] || fail "\"$(cat "$out")\" is not \"$1\""
}

echo "== without a daemon"
PELAGOS_SERVER=tcp:127.0.0.1:1 run 3 get
says "make run"
run 2 get --server nonsense
says "tcp:HOST:PORT"
run 2 get --server 127.0.0.1:7878
says "did you mean tcp:127.0.0.1:7878"
run 2 gett
says "did you mean get"
run 2 help frmae
says "did you mean frame"
run 0 help
run 0 replay --help
says "--speed"
for shell in bash zsh fish; do
    run 0 completion $shell
    says pelagosctl
done
"$ctl" completion bash | bash -n || fail "the bash completion has an error"
# Every layer of the schema's table, also behind a comma.
for layer in $(sed -n 's/^PEL_LAYER([A-Z_]*, [a-z_]*, "\([A-Za-z]*\)".*/\1/p' \
    "${0%/*}/../proto/layers.def"); do
    completed=$(bash -c 'eval "$("$1" completion bash)"
        COMP_WORDS=(pelagosctl frame a.exr --layers "sun,$2"); COMP_CWORD=4
        _pelagosctl; echo "${COMPREPLY[0]}"' - "$ctl" "$layer")
    [ "$completed" = "sun,$layer" ] ||
        fail "the bash completion of --layers does not know $layer"
done
"$ctl" manual | LC_ALL=C.UTF-8 man -l --warnings - >/dev/null 2>"$err"
[ ! -s "$err" ] || fail "the manual: $(cat "$err")"


echo "== optics water"
run 0 optics water --jerlov IA --depth 8 --bottom sand --sun-zenith 40
jq -e '.leaving.total[1] > 0.001 and .water.depth == 8 and .orders == "all" and
    (.leaving | (.single[2] + .second[2] + .higher[2] + .bottomDirect[2] +
    .bottomScattered[2] + .raman[2] - .total[2]) | fabs < 1e-6)' "$out" \
    >/dev/null || fail "optics water: $(cat "$out")"
whole=$(jq '.leaving.total[1]' "$out")
run 0 optics water --jerlov IA --depth 8 --bottom sand --sun-zenith 40 \
    --no-raman
reference=$(jq '.leaving.total[1]' "$out")
jq -e ".leaving.raman[1] == 0 and .leaving.total[1] < $whole" "$out" \
    >/dev/null || fail "without Raman scattering: $(cat "$out")"
run 0 optics water --jerlov IA --depth 8 --bottom sand --sun-zenith 40 \
    --from montecarlo --paths 200000
jq -e "(.leaving.total[1] - $reference) | fabs < 0.03 * $reference" "$out" \
    >/dev/null || fail "Monte Carlo against $reference: $(cat "$out")"
run 0 optics water --absorption 0.3,0.06,0.02 --scattering 0.1 --bottom 0.3 \
    --orders paper
jq -e '.leaving.higher[1] == 0 and .water.asymmetry[0] == 0.924 and
    .water.albedo[2] == 0.3' "$out" >/dev/null || fail "paper: $(cat "$out")"
run 0 optics water --chlorophyll 0.5 --cdom 0.1 --wavelengths 400:700:100
jq -e '.water.wavelength == [400, 500, 600, 700] and
    (.water | (.waterAbsorption[1] + .phytoplanktonAbsorption[1] +
    .dissolvedAbsorption[1] + .detritusAbsorption[1] - .absorption[1]) |
    fabs < 1e-6) and (.remoteSensingReflectance | length) == 4' "$out" \
    >/dev/null || fail "wavelengths: $(cat "$out")"
run 2 optics water --wavelengths 300
says "400 to 700 nm"
run 2 optics water --jerlov I --cdom 1
says "--chlorophyll"
run 2 optics water --jerlov IV
says "I, IA, IB"
run 2 optics water --jerlov I --chlorophyll 1
says "one way"
run 2 optics water --absorption 1
says "go together"
run 2 optics water --absorption nan --scattering 1
run 2 optics water --absorption 0 --scattering 1
says "absorption must be from 0.001 to 100 1/m"
run 2 optics water --view-zenith 91
run 2 optics air
run 2 optics water sea.windSpeed=3

start_daemon

echo "== optics brdf, sky"
run 0 optics water --jerlov IA --depth 8 --bottom sand --sun-zenith 40 --from gpu
jq -e "(.leaving.total[1] - $whole) | fabs < 0.001 * $whole" "$out" \
    >/dev/null || fail "optics water of the device: $(cat "$out")"
water="--chlorophyll 2 --cdom 0.3 --minerals 3 --backscatter-ratio 0.02"
run 0 optics water $water
reference=$(jq '.leaving.total[1]' "$out")
run 0 optics water $water --from gpu
jq -e "(.leaving.total[1] - $reference) | fabs < 0.001 * $reference" "$out" \
    >/dev/null || fail "constituents on the device: $(cat "$out")"
run 0 --json optics brdf --wind 10 --sun-elevation 25 --view-zenith 70
cp "$out" "$work/reference"
jq -e '.brdf | .slopeDensity > 0 and .fresnel > 0 and .shadowing <= 1 and
    .reflectedSun > 0' "$out" >/dev/null || fail "optics brdf: $(cat "$out")"
run 0 --json optics brdf --wind 10 --sun-elevation 25 --view-zenith 70 \
    --from gpu
jq -es '(.[0].brdf.meanFresnel / .[1].brdf.meanFresnel - 1 | fabs) < 1e-3 and
    (.[0].brdf.slopeAlong == .[1].brdf.slopeAlong)' "$work/reference" "$out" \
    >/dev/null || fail "optics brdf of the device: $(cat "$out")"
run 0 optics brdf --slope-along 0.03 --slope-cross 0.02 sky.sunElevation=20
says "slope variance across            0.02"
run 0 optics sky --sun-elevation 20 --elevation 10 --visibility 20000
says "sky radiance"
run 0 optics sky --sun-elevation 20 --elevation 10 --from gpu
says "llvmpipe"
run 2 optics sky --elevation 91
run 2 optics brdf --from montecarlo
run 4 optics brdf --wind 99
says "it must be 0 to 30 m/s"

echo "== get, set, unset"
run 0 set sea.windSpeed=12.5 views.bridge.yaw=-30
says "sea.windSpeed = 12.5 m/s"
run 0 get sea.windSpeed
is 12.5
run 0 get view.bridge.yaw
is -30
run 0 get
says "sea.windSpeed = 12.5 m/s"
run 0 --json get
jq -e '.sea.windSpeed == 12.5' "$out" >/dev/null || fail "get --json"
run 0 --json get sea.windSpeed clock.mode
jq -es '.[0].value == 12.5 and .[1].value == "FREE"' "$out" >/dev/null ||
    fail "get --json of paths: $(cat "$out")"
run 0 set entities.ownship.heading=45 sea.swell.0.height=2.5
run 0 get entities.1.heading
is 45
run 0 get sea.swell.0.height
is 2.5
run 0 set sky.sunElevation=20
run 0 unset sky.sunElevation
run 4 unset entities.1
says "names entity 1, which is not there: add it"
! grep -q legal "$err" || fail "a range does not mend a conflict"
run 4 get sea.wind
says "did you mean sea.windSpeed?"
run 0 get sky.sunElevation
is ""
run 0 --server "unix:$socket" get sea.windSpeed
is 12.5

echo "== refusals change nothing and say what to do"
run 4 set sea.windSpeed=99
says "0 to 30 m/s"
run 4 set sea.windSpeed=5 sea.windSped=6
says "did you mean sea.windSpeed"
run 4 set sea.windSpeed=5 views.bridge.width=3
run 4 set sea.windSpeed=nan
run 4 set sea.windSpeed=fast
run 4 set sea.spectrum=FLAT
run 2 set sea.windSpeed
run 0 get sea.windSpeed
is 12.5
run 4 set views.brige.yaw=5
says "there is no such view; --create adds it"
says "did you mean views.bridge"
run 4 set entities.7.heading=5
says "there is no such entity"
run 0 views
! grep -q brige "$out" || fail "a mistyped name made a camera"
run 4 watch sea.nothing
says "sea.nothing"
run 4 watch views.brige
run 2 bench bridge
says "bridge"
says "one argument too many"
run 4 get entities.ownshp.heading
says "did you mean entities.ownship"
run 4 get sea.windSpede
says "did you mean sea.windSpeed"
run 4 frame bridg "$work/x.jpg"
says "did you mean bridge"
run 4 --json set sea.windSpeed=99
jq -e '.error.code == "OUT_OF_RANGE" and .error.path == "sea.windSpeed" and
    .error.maximum == 30 and .error.unit == "m/s"' "$err" >/dev/null ||
    fail "--json error: $(cat "$err")"

echo "== views, frames"
run 0 set --create views.wing.entity=1 views.wing.right=12 views.wing.yaw=90 \
    views.wing.width=320 views.wing.height=180
run 0 views
says "320x180"
for kind in jpg png exr; do
    run 0 frame wing "$work/wing.$kind" --width 160 --height 96
    says 160x96
done
file_starts() {
    [ "$(od -An -tx1 -N "$2" "$1" | tr -d " \n")" = "$3" ] || fail "$1 is no such picture"
}
file_starts "$work/wing.jpg" 3 ffd8ff
file_starts "$work/wing.png" 4 89504e47
file_starts "$work/wing.exr" 4 762f3101
run 0 frame wing "$work/all.exr" --layers radiance,depth,normal --float \
    --width 64 --height 48
exrheader "$work/all.exr" | grep -q depth || fail "no depth in the EXR"
run 4 frame wing "$work/bad.exr" --layers radiance,colour
[ ! -e "$work/bad.exr" ] || fail "a refused frame left a file"
run 2 frame wing "$work/x.gif"
run 1 frame wing /nonexistent/x.jpg
"$ctl" frame wing - --format png | cmp -n 4 - "$work/wing.png" ||
    fail "frame to standard output"

echo "== same state, same moment, same bytes"
run 0 frame wing "$work/a.png" --time 12.5
run 0 frame wing "$work/b.png" --time 12.5
cmp "$work/a.png" "$work/b.png" || fail "two pictures of one moment differ"

echo "== surface"
run 0 --json surface 0 0 -20 35.5 --time 10
jq -e '.time == 10 and (.points | length) == 2 and
    (.points[1].normal[2] > 0.3)' "$out" >/dev/null || fail "surface"
run 0 --json surface --foam --time 10 0 0
jq -e '.points[0].foam | (. >= 0) and (. <= 1)' "$out" >/dev/null ||
    fail "foam at a point"
run 0 --json surface --acceleration --time 10 0 0
jq -e '.points[0].acceleration | length == 3 and (map(fabs) | add) > 1e-3' \
    "$out" >/dev/null || fail "acceleration"
run 2 surface 0
run 0 --json spectrum -w 1 -n 3 -d 4
jq -e '.drawn.significantHeight > 0 and (.rows | length) == 3 and
    (.rows[0].directional | length) == 4 and
    .drawnBelow.slopeAlong < .drawn.slopeAlong' "$out" >/dev/null \
    || fail "spectrum"
run 0 spectrum sea.synthesiser=FFT sea.spectrum=ELFOUHAILY sea.beaufort=5
run 4 spectrum sea.windSpeed=31
run 2 spectrum --directions 99
run 0 surface -5 -.5

echo "== clock"
run 4 step 1
says "clock.mode=STEPPED"
run 0 set clock.mode=STEPPED
"$ctl" get clock.time >"$work/t0"
run 0 step 2.5
"$ctl" get clock.time | LC_ALL=C awk -v t0="$(cat "$work/t0")" \
    '{ d = $1 - t0 - 2.5; exit !(d < 1e-9 && d > -1e-9) }' ||
    fail "a step of 2.5 s"
run 0 set clock.mode=FREE

echo "== watch"
"$ctl" watch sea --count 2 --seconds 60 >"$work/watched" 2>"$err" &
watcher=$!
while kill -0 $watcher 2>/dev/null; do
    sleep 0.25
    "$ctl" -q set sea.windSpeed=7 sea.windDirection=100
    "$ctl" -q set sea.windSpeed=8 sea.windDirection=110
done
wait $watcher || fail "watch: $(cat "$err")"
grep -q '^sea.windSpeed = [78] m/s$' "$work/watched" ||
    fail "watch printed: $(cat "$work/watched")"

echo "== replay"
printf '%s\r\n' '# four seconds' '$GPHDT,90.0,T*0C' \
    '$GPRMC,120000,A,5230.000,N,00510.000,E,10.0,090.0,210626,,*1A' \
    '$GPRMC,120002,A,5230.000,N,00510.091,E,10.0,090.0,210626,,*10' \
    '$GPRMC,120004,A,5230.000,N,00510.182,E,10.0,090.0,210626,,*16' \
    >"$work/log.nmea"
/usr/bin/python3 - "$work/log.nmea" <<'PY'
import functools, sys
path = sys.argv[1]
lines = open(path).read().split("\n")
for i, line in enumerate(lines):
    if line.startswith("$"):
        body = line[1:line.index("*")]
        check = functools.reduce(lambda a, c: a ^ ord(c), body, 0)
        lines[i] = f"${body}*{check:02X}\r"
open(path, "w", newline="").write("\n".join(lines))
PY
run 0 set clock.rate=1 clock.mode=STEPPED
run 0 --json replay "$work/log.nmea" --speed 4 --to "127.0.0.1:$nmea"
jq -e '.sentences == 4 and .seconds > 0.9' "$out" >/dev/null || fail "replay: $(cat "$out")"
run 0 --json get clock.mode clock.rate
jq -es '.[0].value == "STEPPED" and .[1].value == 1' "$out" >/dev/null ||
    fail "replay did not restore the clock"
run 0 get entities.1.heading
is 90
run 1 replay /nonexistent
run 1 replay tests/run
says "no NMEA"
run 2 replay "$work/log.nmea" --speed 1000
run 0 set clock.mode=FREE

echo "== record"
run 0 record wing "$work/clip.mkv" --seconds 1 --fps 5
says frames
ffprobe -v error -select_streams v -show_entries stream=codec_name,width \
    -of csv=p=0 "$work/clip.mkv" | grep -q '^mjpeg,320' || fail "the clip"
run 0 --json record wing "$work/clip.mjpeg" --exact --seconds 0.5 --fps 10
jq -e '.frames == 5 and .wanted == 5' "$out" >/dev/null || fail "record --exact"
[ "$(ffprobe -v error -count_frames -show_entries stream=nb_read_frames \
    -of csv=p=0 "$work/clip.mjpeg")" = 5 ] || fail "five frames in clip.mjpeg"
run 1 record wing "$work/clip.webm" --seconds 1
run 4 record nothing "$work/none.mkv"

echo "== bench"
run 0 --json bench --seconds 0.5 --sizes 160x90 --views bridge,wing
jq -e '.[0].frames > 0 and .[0].views == 2 and .[0].renderMsMedian > 0' \
    "$out" >/dev/null || fail "bench: $(cat "$out")"

echo "== libpelagos from C"
built=${PELAGOS_BIN%/bin}
cc ${PELAGOS_CC_FLAGS-} -Iclients/lib "-I$built/gen" clients/lib/example.c \
    "$built/libpelagos.a" -lprotobuf-c -lssl -lcrypto -o "$work/example" ||
    fail "the example does not build"
"$work/example" "$work/example.jpg" "$PELAGOS_SERVER" || fail "the example"
file_starts "$work/example.jpg" 3 ffd8ff
cc ${PELAGOS_CC_FLAGS-} -Iclients/lib "-I$built/gen" clients/lib/save_live.c \
    "$built/libpelagos.a" -lprotobuf-c -lssl -lcrypto -o "$work/save_live" ||
    fail "the example of live pictures does not build"
"$work/save_live" wing "$work/live.mjpeg" 1 "http://127.0.0.1:$http" \
    >"$out" || fail "the example of live pictures"
saved=$(ffprobe -v error -count_frames -show_entries stream=nb_read_frames \
    -of csv=p=0 "$work/live.mjpeg")
says "$saved frames"
"$work/save_live" nothing "$work/none.mjpeg" 1 "http://127.0.0.1:$http" \
    2>"$out" && fail "a stream of no view"
says "no view called"

echo "== the other port, a daemon that goes"
run 3 --server "tcp:127.0.0.1:$http" --timeout 3 get
stop_daemon
[ "$daemon_status" -eq 0 ] || fail "pelagosd ended with $daemon_status"
run 3 get
