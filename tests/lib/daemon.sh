# Sourced by tests: a pelagosd on the software device and free ports.
#
#   start_daemon [OPTION…]   starts it and waits until it answers
#   stop_daemon              SIGTERM; its status in $daemon_status
#   $http $tcp $modbus $nmea $socket   where it listens
#   $work                    a folder that goes with the test
#   fail TEXT                ends the test
#
# The daemon and the folder go away however the test ends.
: "${PELAGOS_BIN:=$PWD/build/release/bin}"
work=$(mktemp -d /tmp/pelagos-test.XXXXXX)
daemon=
daemon_status=

fail() {
    echo "FAILED: $*" >&2
    exit 1
}

skip() {
    echo "$*"
    exit 77
}

stop_daemon() {
    if [ -n "$daemon" ]; then
        kill "$daemon" 2>/dev/null
        wait "$daemon"
        daemon_status=$?
        daemon=
    fi
}

clean_up() {
    status=$?
    stop_daemon
    if [ $status -ne 0 ] && [ $status -ne 77 ] && [ -f "$work/log" ]; then
        echo "--- pelagosd's log" >&2
        tail -n 25 "$work/log" >&2
    fi
    rm -rf "$work"
}
trap clean_up EXIT
trap 'exit 130' INT TERM

free_ports() {
    PYTHONPATH=tests /usr/bin/python3 -B -c '
import socket
from pelagos_daemon import free_port
print(free_port(), free_port(), free_port(), free_port(socket.SOCK_DGRAM))'
}

start_daemon() {
    read -r http tcp modbus nmea < <(free_ports)
    socket=$work/socket
    "$PELAGOS_BIN/pelagosd" --device software --http "127.0.0.1:$http" \
        --tcp "127.0.0.1:$tcp" --rtsp off --modbus "127.0.0.1:$modbus" \
        --nmea "127.0.0.1:$nmea" --unix "$socket" "$@" >>"$work/log" 2>&1 &
    daemon=$!
    export PELAGOS_SERVER=tcp:127.0.0.1:$tcp
    for _ in $(seq 600); do
        kill -0 "$daemon" 2>/dev/null || fail "pelagosd ended at once"
        if curl -sf "http://127.0.0.1:$http/healthz" >/dev/null; then
            return
        fi
        sleep 0.1
    done
    fail "pelagosd does not answer"
}
