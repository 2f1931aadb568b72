#!/usr/bin/env bash
# pelagosctl record: clips as drawn and as streamed, sequences of EXRs; what is
# there already, interruption, a full disk.
set -u
cd "$(dirname "$0")/.."
. tests/lib/daemon.sh
command -v ffprobe >/dev/null || skip "no ffprobe"

out=$work/out err=$work/err

# GObject has no frame pointers, so lsan.supp knows it by whole stacks alone.
whole=${ASAN_OPTIONS:-}:fast_unwind_on_malloc=0

# run STATUS ARGUMENT…: pelagosctl ends with it.
run() {
    local want=$1
    shift
    ASAN_OPTIONS=$whole timeout 300 "$PELAGOS_BIN/pelagosctl" --timeout 60 \
        "$@" >"$out" 2>"$err"
    local status=$?
    [ $status = "$want" ] ||
        fail "pelagosctl $*: status $status, not $want: $(cat "$out" "$err")"
}
says() { grep -qF -- "$1" "$out" "$err" || fail "no '$1': $(cat "$out" "$err")"; }
entry() { ffprobe -v error -select_streams v -count_frames \
    -show_entries "stream=$1" -of csv=p=0 "$2"; }
# Simulated time in an EXR's header.
time_of() {
    /usr/bin/python3 -c '
import struct, sys
head = open(sys.argv[1], "rb").read(16384)
at = head.index(b"pelagos.time\0double\0") + 24
print("%.9f" % struct.unpack_from("<d", head, at))' "$1"
}

start_daemon
export PELAGOS_URL=http://127.0.0.1:$http
curl -sf -X PUT -H 'Content-Type: application/json' \
    -d '{"entity":1,"width":160,"height":90}' \
    "http://127.0.0.1:$http/v1/views/wing" >/dev/null || fail "no view"

echo "== what is there is kept"
echo mine >"$work/clip.mkv"
run 1 record wing "$work/clip.mkv" --seconds 1
says "exists already: --overwrite"
[ "$(cat "$work/clip.mkv")" = mine ] || fail "clip.mkv was touched"
run 0 record wing "$work/clip.mkv" --seconds 0.5 --fps 4 --exact --overwrite
[ "$(entry nb_read_frames "$work/clip.mkv")" = 2 ] || fail "two frames"

echo "== as it is streamed"
for kind in mp4 mkv; do
    run 0 --json record wing "$work/live.$kind" --stream --seconds 1
    frames=$(jq .frames "$out")
    [ "$frames" -gt 0 ] || fail "$frames pictures"
    [ "$(entry codec_name,width "$work/live.$kind")" = h264,160 ] ||
        fail "live.$kind: $(entry codec_name,width "$work/live.$kind")"
    [ "$(entry nb_read_frames "$work/live.$kind")" = "$frames" ] ||
        fail "live.$kind: not $frames frames"
done
run 0 record wing "$work/small.mp4" --stream --seconds 0.3 --width 96 \
    --height 64 --bitrate 300
[ "$(entry width "$work/small.mp4")" = 96 ] || fail "the size of small.mp4"
run 1 record nothing "$work/nothing.mp4" --stream --seconds 1
says "Not Found"
PELAGOS_URL=http://127.0.0.1:1 run 1 record wing "$work/far.mp4" --stream \
    --seconds 1
says "is this pelagosd's HTTP port (--url)?"
[ ! -e "$work/far.mp4" ] || fail "an empty far.mp4 is left"
run 2 record wing "$work/live.webm" --stream --exact
run 1 record wing "$work/live.webm" --stream
says ".mkv or .mp4"
run 2 record wing "$work/a.mkv" --layers depth
run 2 record wing "$work/a.mkv" --bitrate 500
run 2 record wing "$work/a%s.exr"

echo "== a sequence"
run 0 --json record wing "$work/s_%04d.exr" --seconds 1 --fps 5 --from 20 \
    --layers radiance,depth
jq -e '.frames == 5 and .kept == 0 and .time == 20' "$out" >/dev/null ||
    fail "$(cat "$out")"
for i in 0 1 2 3 4; do
    [ "$(time_of "$work/s_000$i.exr")" = "$(LC_ALL=C printf '%.9f' \
        "$(jq -n "20 + $i / 5")")" ] ||
        fail "s_000$i.exr is of $(time_of "$work/s_000$i.exr") s"
    grep -qa 'depth.Z' "$work/s_000$i.exr" || fail "no depth in s_000$i.exr"
done
sha256sum "$work"/s_*.exr >"$work/sums"
run 1 record wing "$work/s_%04d.exr" --seconds 1 --fps 5 --layers radiance,depth
says "5 of the 5 files"

echo "== gone on with, at the same times: the same bytes"
rm "$work/s_0002.exr" "$work/s_0004.exr"
run 0 --json record wing "$work/s_%04d.exr" --seconds 1 --fps 5 --resume \
    --layers radiance,depth
jq -e '.frames == 2 and .kept == 3 and .time == 20' "$out" >/dev/null ||
    fail "$(cat "$out")"
sha256sum -c --quiet "$work/sums" || fail "not the same bytes"

echo "== a full disk"
rm "$work/s_0002.exr" "$work/s_0003.exr"
ln -s /dev/full "$work/s_0003.exr.part"
run 1 record wing "$work/s_%04d.exr" --seconds 1 --fps 5 --resume \
    --layers radiance,depth
says "No space left on device; 4 of 5 frames are there"
[ ! -e "$work/s_0003.exr" ] || fail "half a file"
run 0 record wing "$work/s_%04d.exr" --seconds 1 --fps 5 --resume \
    --layers radiance,depth
sha256sum -c --quiet "$work/sums" || fail "not the same bytes"
for kind in mkv mjpeg; do
    ln -sf /dev/full "$work/full.$kind"
    run 1 record wing "$work/full.$kind" --exact --seconds 2 --fps 10 --overwrite
    says "space left"
done
ln -sf /dev/full "$work/full.mp4"
run 1 record wing "$work/full.mkv" --stream --seconds 2 --overwrite
says "space left"

echo "== interrupted"
"$PELAGOS_BIN/pelagosctl" --timeout 60 record wing "$work/i.png" --seconds 600 --fps 60 \
    >"$out" 2>"$err" &
recorder=$!
for _ in $(seq 600); do
    [ -e "$work/i_00001.png" ] && break
    sleep 0.1
done
kill "$recorder"
wait "$recorder"
[ $? = 1 ] || fail "interrupted: another status than 1"
says "go on with --resume"
run 2 record wing "$work/i.png" --layers depth --seconds x
stop_daemon
[ "$daemon_status" = 0 ] || fail "the daemon ended with $daemon_status"
