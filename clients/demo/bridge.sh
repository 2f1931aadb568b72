#!/bin/sh
# Five windows of a ship's bridge from a pelagosd of its own: see
# clients/python/examples/bridge.py, which gets the arguments.
set -eu
cd "$(dirname "$0")/../.."
port=$(/usr/bin/python3 -c 'import socket
s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
mkdir -p build/bridge
build/pelagosd --http "127.0.0.1:$port" --tcp off --rtsp off --modbus off \
    --nmea off --device "${DEVICE:-auto}" >build/bridge/log 2>&1 &
daemon=$!
trap 'kill $daemon 2>/dev/null || true' EXIT
for _ in $(seq 100); do
    curl -sf -o /dev/null "http://127.0.0.1:$port/healthz" && break
    sleep 0.1
done
PYTHONPATH=clients/python /usr/bin/python3 -B \
    clients/python/examples/bridge.py --url "http://127.0.0.1:$port" \
    --out build/bridge/panorama.png --live 20 "$@"
