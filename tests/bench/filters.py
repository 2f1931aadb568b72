#!/usr/bin/python3
"""What the paper's sky costs, against the default, in one run:
   tests/bench/filters.py [--hardware] [STILL]
On the software device in processor time a frame, which neighbours on the
machine hardly move; on hardware in time of the shading stage by its own clock."""
import re
import resource
import subprocess
import sys

arguments = [a for a in sys.argv[1:] if a != "--hardware"]
HARDWARE = len(arguments) < len(sys.argv) - 1
STILL = arguments[0] if arguments else "build/release/bin/still"
SIZE = ["width=1024", "height_px=768"] if HARDWARE else ["width=640",
                                                         "height_px=480"]
CASES = {"paper=0": "the sky over the facets seen (default)",
         "paper=1": "the paper's sky"}


def run(settings, frames):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    out = subprocess.run(
        [STILL, "/dev/null", *settings, *SIZE, f"frames={frames}"]
        + (["hardware=1", "stages=1"] if HARDWARE else []),
        capture_output=True, text=True, check=True).stdout
    if HARDWARE:
        return min(float(x) for x in re.findall(r"shade ([0-9.]+)", out))
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def frame_ms(settings):
    if HARDWARE:
        return run(settings, 40)
    return min((run(settings, 14) - run(settings, 4)) * 100 for _ in range(2))


for fft in (0, 1):
    base = None
    for case, name in CASES.items():
        ms = frame_ms(["wind=8", "height=6", f"fft={fft}", case])
        base = base or ms
        print(f"{'FFT      ' if fft else 'trochoids'} "
              f"{name:40}{ms:8.3f} ms {ms / base:5.2f}", flush=True)
