#!/usr/bin/env bash
# Runs bench_streams on whatever EGL device there is and keeps what it says in
# the folder OUT (build/bench). BENCH names the program. On a bare machine its
# shared libraries may lie in ./libs and GStreamer's plugins (libgstapp.so,
# libgstcoreelements.so, libgstx264.so) in ./gst: see docs/benchmarks.md.
#
#   OUT=… BENCH=… tests/bench/gpu_streams.sh [bench_streams options]
set -eu
out=${OUT:-build/bench}
bench=${BENCH:-build/release/bin/bench_streams}
mkdir -p "$out"
if [ -d libs ]; then
    export LD_LIBRARY_PATH="$PWD/libs${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
    nvidia=/usr/share/glvnd/egl_vendor.d/10_nvidia.json
    if [ ! -e "$nvidia" ] && [ -e libs/10_nvidia.json ]; then
        export __EGL_VENDOR_LIBRARY_DIRS="$PWD/libs"
    fi
fi
if [ -d gst ]; then
    export GST_PLUGIN_PATH_1_0="$PWD/gst" GST_PLUGIN_SYSTEM_PATH_1_0= \
        GST_REGISTRY="$out/gst.registry" GST_REGISTRY_FORK=no
fi
"$bench" --device auto --json "$out/bench-streams.json" "$@" \
    2>"$out/bench-streams.log" | tee "$out/bench-streams.txt"
rm -f "$out/gst.registry"
