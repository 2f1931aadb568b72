#!/bin/sh
# What the image starts: pelagosd with the arguments of `run`. With a token it
# listens on every address of the container; without one on loopback alone,
# which other containers of its network namespace reach (--network host, a pod).
# TLS is for a proxy in front, or for --tls-cert and --tls-key, as arguments.
set -eu
token=${PELAGOS_TOKEN_FILE:-/run/secrets/pelagos-token}
unset PELAGOS_TOKEN_FILE
if [ "${1:-}" != "" ] && [ "${1#-}" = "$1" ]; then
    exec "$@" # another program of the image
fi
if [ -r "$token" ]; then
    set -- --token-file "$token" --plain --http 0.0.0.0:8080 \
        --tcp 0.0.0.0:7878 --rtsp 0.0.0.0:8554 "$@"
else
    echo "no token at $token: loopback only" >&2
fi
exec pelagosd --state /var/lib/pelagos/scene --modbus off --nmea off "$@"
