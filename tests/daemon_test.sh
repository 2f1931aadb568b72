#!/bin/bash
# The daemon as a process: start, options, key file, signals, state, service.
set -u
cd "$(dirname "$0")/.."
daemon=${PELAGOS_BIN:-build/release/bin}/pelagosd
work=$(mktemp -d)
pid=
cleanup() {
    if [ -n "$pid" ]; then
        kill -KILL "$pid" 2>/dev/null
    fi
    rm -rf "$work"
}
trap cleanup EXIT

count=0
ok() {
    count=$((count + 1))
    echo "ok $count - $1"
}
fail() {
    echo "not ok - $1"
    sed 's/^/# /' "$work/log" 2>/dev/null
    exit 1
}
check() { # description, command...
    local what=$1
    shift
    if "$@"; then
        ok "$what"
    else
        fail "$what: $*"
    fi
}

# Waits until a command succeeds, at most a minute (a sanitizer's build on a
# busy machine takes its time).
wait_for() {
    for _ in $(seq 1200); do
        if "$@"; then
            return 0
        fi
        sleep 0.05
    done
    return 1
}
wait_log() { # a line of the log that matches
    wait_for grep -qE "$1" "$work/log"
}

start() { # options...
    : >"$work/log"
    "$daemon" --device software --http 127.0.0.1:0 --tcp 127.0.0.1:0 --rtsp off \
        --modbus 127.0.0.1:0 --nmea 127.0.0.1:0 --log-level debug "$@" \
        2>"$work/log" &
    pid=$!
    wait_log 'DMN-003' || fail "no first frame"
    url=$(grep -oE 'http://127.0.0.1:[0-9]+' "$work/log" | head -n 1)
}

stop() { # signal; prints the exit status
    kill "-$1" "$pid"
    wait "$pid"
    local status=$?
    pid=
    echo $status >"$work/status"
}

# --- options ------------------------------------------------------------------
refused() { # expected words, options...
    local words=$1 said status
    shift
    said=$("$daemon" "$@" 2>&1)
    status=$?
    [ $status -eq 2 ] && [[ $said == *"$words"* ]]
}
check 'a bad number is refused' refused '1 .. 240 Hz' --fps 0
check 'a bad address is refused' refused 'ADDRESS:PORT' --http 80
check 'an unknown option is refused' refused 'no-such' --no-such
check 'another network is refused' refused 'token' --http 0.0.0.0:8080
check 'Modbus to a network needs a list' refused '--modbus-allow' \
    --modbus 0.0.0.0:1502
check 'a missing key file is refused' refused 'nowhere' --config /nowhere
check '--version' grep -q '^pelagosd [0-9]' <("$daemon" --version)
check 'the installed key file is good' "$daemon" --check \
    --config packaging/pelagosd.conf
"$daemon" --print-man >"$work/pelagosd.8"
if command -v man >/dev/null; then
    check 'the manual page has no warnings' test -z \
        "$(LC_ALL=C.UTF-8 MANWIDTH=78 man --warnings -E UTF-8 -l \
            "$work/pelagosd.8" 2>&1 >/dev/null)"
fi
"$daemon" --print-completion >"$work/completion"
check 'the completion is bash' bash -n "$work/completion"
completes() {
    # shellcheck disable=SC1091
    (. "$work/completion" && COMP_WORDS=(pelagosd --nmea-wind m) COMP_CWORD=2 &&
        _pelagosd && [ "${COMPREPLY[*]}" = mean ])
}
check 'it completes' completes

# --- a life -------------------------------------------------------------------
state=$work/scene
start --state "$state"
# A figure; the bar, on a quiet machine, is 2 s.
echo "# $(grep -oE 'first frame [0-9]+ ms' "$work/log") after the start"
check 'healthz' curl -sf -o /dev/null "$url/healthz"
check 'metrics count frames' grep -q '^pelagos_frames_drawn_total' \
    <(curl -sf "$url/metrics")
curl -sf -o /dev/null -X PATCH -H 'Content-Type: application/json' -d \
    '{"clock":{"mode":"STEPPED","time":100},"sea":{"windSpeed":13.5,"seed":7}}' \
    "$url/v1/state" || fail "the patch is not taken"
for format in png jpg exr; do
    curl -sf -o "$work/before.$format" \
        "$url/v1/views/bridge/frame.$format?width=160&height=90" ||
        fail "no $format"
done
check 'the picture is a PNG' grep -q PNG <(head -c 4 "$work/before.png")
written() {
    [ -f "$state" ] && [ "$(jq .sea.windSpeed "$state")" = 13.5 ]
}
check 'the scene is written' wait_for written
stop KILL
start --state "$state"
wind=$(curl -sf "$url/v1/state" | jq .sea.windSpeed)
check 'the scene survives kill -9' test "$wind" = 13.5
for format in png jpg exr; do
    curl -sf -o "$work/after.$format" \
        "$url/v1/views/bridge/frame.$format?width=160&height=90&time=100"
    check "the same $format after the restart" \
        cmp "$work/before.$format" "$work/after.$format"
done

# --- SIGTERM with viewers ---------------------------------------------------------
curl -sf -o "$work/stream" "$url/v1/views/bridge/mjpeg" &
viewer=$!
check 'live frames come' wait_for test -s "$work/stream"
stop TERM
wait $viewer
check 'SIGTERM ends with status 0' test "$(cat "$work/status")" = 0

# --- key file and SIGHUP ------------------------------------------------------------
conf=$work/pelagosd.conf
printf '[render]\nfps=10\n[scene]\nwaves=40\n' >"$conf"
start --config "$conf"
printf '[render]\nfps=20\n[scene]\nwaves=50\n' >"$conf"
kill -HUP "$pid"
check 'SIGHUP reads the key file' wait_log 'DMN-022'
check 'it applies what it can' grep -q 'DMN-021 fps has changed$' "$work/log"
check 'and says what needs a restart' grep -q 'waves has changed: restart' \
    "$work/log"
printf '[render]\nfps=0\n' >"$conf"
kill -HUP "$pid"
check 'a wrong key file changes nothing' wait_log 'DMN-020.*1 .. 240 Hz'
check 'and the daemon goes on' curl -sf -o /dev/null "$url/healthz"

# --- a port that is taken ---------------------------------------------------------------
port=${url##*:}
"$daemon" --device software --http "127.0.0.1:$port" --tcp off --rtsp off --modbus off \
    --nmea off 2>"$work/second"
check 'a port that is taken: status 1' test $? -eq 1
check 'with a message' grep -q "DMN-009.*$port" "$work/second"
stop INT
check 'SIGINT ends with status 0' test "$(cat "$work/status")" = 0

# --- service ---------------------------------------------------------------------------------
/usr/bin/python3 - "$work/notify" "$work/notified" <<'EOF' &
import socket, sys
s = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
s.bind(sys.argv[1])
s.settimeout(120)
with open(sys.argv[2], "w") as out:
    while True:
        text = s.recv(4096).decode()
        print(text, file=out, flush=True)
        if "STOPPING" in text:
            break
EOF
listener=$!
wait_for test -S "$work/notify" || fail "no socket"
NOTIFY_SOCKET=$work/notify WATCHDOG_USEC=300000 start
check 'the watchdog is fed' wait_for grep -q WATCHDOG=1 "$work/notified"
stop TERM
wait $listener
for word in READY=1 WATCHDOG=1 STOPPING=1; do
    check "systemd hears $word" grep -q "$word" "$work/notified"
done
if command -v systemd-analyze >/dev/null; then
    # 0.1 of it is RestrictRealtime, which would take --realtime away.
    check 'exposure is at most 1.3' systemd-analyze security --offline=true \
        --threshold=13 --no-pager packaging/pelagosd.service >"$work/exposure"
    echo "# $(grep -oE 'service: [0-9.]+' "$work/exposure")"
fi
check 'shaders may be compiled at run time' test -z \
    "$(grep '^MemoryDenyWriteExecute=yes' packaging/pelagosd.service)"
echo "1..$count"
