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
printed=$("$daemon" --print-config --config packaging/pelagosd.conf --fps 12)
check '--print-config has the file and the options' test \
    "$(grep -c -e '^# From packaging/pelagosd.conf:$' -e '^state=/var/lib' \
        -e '^fps=12$' <<<"$printed")" -ge 4
check '--version' grep -q '^pelagosd [0-9]' <("$daemon" --version)
check 'the installed key file is good' "$daemon" --check --device software \
    --config packaging/pelagosd.conf --state "$work/scene" --unix "$work/socket"

# --check is a start short of listening: what one refuses the other does, by the
# same words, and --check leaves no trace.
quiet=(--device software --http 127.0.0.1:0 --tcp off --rtsp off --modbus off
    --nmea off)
mkdir "$work/tried"
echo 0123456789abcdef >"$work/tried/open" && chmod 644 "$work/tried/open"
echo 0123456789abcdef >"$work/tried/token" && chmod 600 "$work/tried/token"
echo no certificate >"$work/tried/pem" && chmod 600 "$work/tried/pem"
echo 'sea.windSpeed holding' >"$work/tried/table"
echo '17 nonsense' >"$work/tried/types"
traces() {
    (cd "$work/tried" && find . -printf '%p %T@ %s\n' | sort)
}
tried=0
refused_by_both() { # options...
    local said started status words
    said=$("$daemon" --check "${quiet[@]}" "$@" 2>&1)
    status=$?
    started=$(timeout 60 "$daemon" "${quiet[@]}" "$@" 2>&1 >/dev/null)
    tried=$((tried + 1))
    [ $status -eq 1 ] && [[ $said == *'cannot start: '* ]] ||
        fail "--check $*: status $status, $said"
    # What would be bound or written is said before the system says it.
    case $* in
    *--state*|*--record\ *|*--unix*|*10.9.8.7*|*24000*)
        words='DMN-009 cannot start: ' ;;
    *) words="DMN-009 cannot start: ${said#*cannot start: }" ;;
    esac
    [[ $started == *"$words"* ]] || fail "$* by --check: $said; by a start: $started"
}
before=$(traces)
f=$work/tried
for wrong in "--token-file $f/none" "--token-file $f/open" \
    "--tls-cert $f/none --tls-key $f/none" "--tls-cert $f/pem --tls-key $f/pem" \
    "--spectra $f/none" "--bathymetry $f/none" "--weather $f/token" \
    "--panoramas $f/none" "--models $f/none" "--exercises $f/none" \
    "--recordings $f/none" "--state $f/none/scene" "--state $f" \
    "--record $f/none/log" "--record $f/token" "--unix $f/none/socket" \
    "--unix $f/token" "--console 127.0.0.1:1 --console-table $f/none" \
    "--console 127.0.0.1:1 --console-table $f/table" \
    "--cigi 127.0.0.1:0 --cigi-entities $f/none" \
    "--cigi 127.0.0.1:0 --cigi-entities $f/types" \
    "--cigi 127.0.0.1:0 --cigi-host [::1]:9" \
    "--modbus 127.0.0.1:0 --modbus-units 0" \
    "--modbus 127.0.0.1:0 --modbus-safe views.none.yaw=0" \
    "--http 10.9.8.7:0 --token-file $f/token --plain" \
    "--tcp 127.0.0.1:24000 --rtsp 127.0.0.1:24000" --device\ 77 \
    "--video-encoder nonsense" "--exercise http://127.0.0.1:1" \
    "--exercise http://127.0.0.1:1/x --exercise-node a/b" \
    "--exercise http://127.0.0.1:1/x --exercise-ca $f/none"; do
    # shellcheck disable=SC2086
    refused_by_both $wrong
done
ok "--check refuses what a start does, $tried wrong uses"
good_check() { # words that it says, options...
    local words=$1 said
    shift
    said=$("$daemon" --check "${quiet[@]}" "$@" 2>&1) &&
        [[ $said == *"$words"*'the options are good'* ]]
}
check '--check says what a start does with a state that is damaged' \
    good_check 'does not load' --state "$f/token"
check '--check says which name is not resolved' good_check \
    'nowhere.invalid is not resolved' --nmea-out nowhere.invalid:10110
check '--check takes everything that is right' good_check '' \
    --state "$f/scene" --record "$f/log" --unix "$f/socket" \
    --token-file "$f/token" --recordings "$f" --exercises "$f" \
    --exercise http://127.0.0.1:1/x --cigi 127.0.0.1:0 --nmea-tcp 127.0.0.1:0
check '--check leaves no trace' test "$before" = "$(traces)"
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
check 'each line of the log has its time' test -z "$(grep -vE \
    '^[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9:]{8}\.[0-9]{3}Z (error|warning|info|debug) [A-Z]{3}-[0-9]{3} ' \
    "$work/log")"
check '--check while a daemon has the state says so' good_check \
    'a daemon keeps its state' --state "$state" --http "${url#http://}"
check 'readyz once the first picture is drawn' grep -q '"ready"' \
    <(curl -sf "$url/readyz")
started=$(curl -sf "$url/metrics" |
    sed -n 's/^process_start_time_seconds //p')
check 'metrics say when the process began' test \
    "$(stat -c %Y "/proc/$pid")" -ge "$((${started%.*} - 2))" -a \
    "${started%.*}" -ge "$(($(date +%s) - 600))"
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

# --- readiness --------------------------------------------------------------------
stop TERM
start --exercise http://localhost:1/nobody --exercise-node alone
joining=$(curl -s -w ' %{http_code}' "$url/readyz")
[[ $joining == '{"status":"joining"}'*' 503' ]] || fail "readyz: $joining"
ok 'a node that takes no part yet is well, but not ready'
check 'and well' curl -sf -o /dev/null "$url/healthz"
stop KILL
start --state "$state"

# --- forms of the log -----------------------------------------------------------
stop TERM
lines() { # form, environment... : the first lines of a daemon that cannot start
    local form=$1
    shift
    : >"$work/forms"
    env "$@" "$daemon" "${quiet[@]}" --log-format "$form" --models /nowhere \
        2>>"$work/forms"
}
identity=$(touch "$work/forms" && stat -c %d:%i "$work/forms")
lines auto JOURNAL_STREAM="$identity"
check 'journald gets priorities and no time' grep -q '^<3>error DMN-009' \
    "$work/forms"
lines auto JOURNAL_STREAM=1:1
check 'but not where it does not read us' grep -q 'Z error DMN-009' "$work/forms"
lines json
check 'JSON lines' test "$(jq -r 'select(.id == "DMN-009") | .level' \
    "$work/forms")" = error
start --state "$state"

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
