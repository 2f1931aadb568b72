#!/usr/bin/env bash
# Runs the benchmark on whatever EGL device there is and keeps what it says in
# the folder OUT (build/bench). BENCH names the program; shared libraries that
# a bare machine lacks may lie in ./libs (see docs/benchmarks.md).
#
#   OUT=… BENCH=… tests/bench/gpu.sh [bench options]
set -eu
out=${OUT:-build/bench}
bench=${BENCH:-build/release/bin/bench}
mkdir -p "$out"
if [ -d libs ]; then
    export LD_LIBRARY_PATH="$PWD/libs${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
    # NVIDIA's driver registers itself with glvnd through this file.
    nvidia=/usr/share/glvnd/egl_vendor.d/10_nvidia.json
    if [ ! -e "$nvidia" ] && [ -e libs/10_nvidia.json ]; then
        export __EGL_VENDOR_LIBRARY_DIRS="$PWD/libs"
    fi
fi
if command -v nvidia-smi >/dev/null; then
    nvidia-smi >"$out/nvidia-smi.txt" 2>&1 || true
fi
for shading in compute fragment; do
    "$bench" --device auto --shading "$shading" \
        --json "$out/bench-$shading.json" "$@" 2>"$out/bench-$shading.log" |
        tee "$out/bench-$shading.txt"
done
