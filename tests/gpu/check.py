#!/usr/bin/python3
"""Runs the renderer's tests, goldens and timings of the folder that it lies in
on this machine's GPU, and prints a table in Markdown.

    ./check.py [--device 0] [--tests 'NAME …'] [--no-timings] [OUT.md]

Status 0: every test passed; 1: some failed; 2: no hardware device here.
"""
import argparse
import os
import re
import statistics
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
LIMIT_S = 240  # the slowest takes 20 s on an H200
ROUNDS = 3
NVIDIA = "/usr/local/nvidia/share/glvnd/egl_vendor.d/10_nvidia.json"
FRAMES = [
    ("cascades, 1024×768", "fft=1"),
    ("trochoids, 1024×768", "fft=0"),
    ("cascades, 1920×1080", "fft=1 width=1920 height_px=1080"),
    ("– 1000 m, 20° down", "fft=1 height=1000 pitch=-20"),
    ("– 1000 m, 70° down", "fft=1 height=1000 pitch=-70"),
    ("– a tanker at 220 m", "fft=1 fleet=1"),
    ("– the waves of 16 ships", "fft=1 wakes=16"),
    ("– night, 50 lamps", "fft=1 sun=-30 lamps=50"),
    ("– fog", "fft=1 fog=2000"),
    ("– cumulus, 4 okta", "fft=1 okta=4"),
    ("– rain, 10 mm/h", "fft=1 rain=10"),
]


def environment(device):
    env = dict(os.environ, TEST_DEVICE=device)
    env["LD_LIBRARY_PATH"] = ":".join(
        path for path in (f"{HERE}/lib", env.get("LD_LIBRARY_PATH")) if path)
    # Where the driver lies apart, glvnd does not find it by itself.
    if os.path.exists(NVIDIA):
        env.setdefault("__EGL_VENDOR_LIBRARY_FILENAMES", NVIDIA)
    return env


def run(command, env):
    """Its status (None: hung), output and seconds."""
    start = time.monotonic()
    try:
        done = subprocess.run(command, cwd=HERE, env=env, timeout=LIMIT_S,
                              stdout=subprocess.PIPE, text=True,
                              stderr=subprocess.STDOUT, errors="replace",
                              check=False)
        return done.returncode, done.stdout, time.monotonic() - start
    except subprocess.TimeoutExpired as late:
        text = (late.stdout or b"").decode(errors="replace")
        return None, text, time.monotonic() - start


def check(names, env):
    """Rows of the table; logs of what failed go to stderr."""
    failed = 0
    rows = []
    for name in names:
        status, text, seconds = run([f"{HERE}/bin/{name}"], env)
        passed = len(re.findall(r"^\[ +OK +\]", text, re.M))
        wrong = sorted(set(re.findall(r"^\[  FAILED  \] (\w\S*)$", text, re.M)))
        if status != 0:
            failed += 1
            reason = ("hung" if status is None else
                      ", ".join(wrong) or f"status {status}")
            print(f"== {name}\n{text[-4000:]}", file=sys.stderr)
        else:
            reason = ""
        rows.append((name, passed, reason, seconds))
        print(f"{'FAILED' if status else 'ok':7}{seconds:7.1f} s  {name} "
              f"{reason}", file=sys.stderr, flush=True)
    return rows, failed


def milliseconds(program, words, env):
    status, text, _ = run([f"{HERE}/bin/{program}", "/tmp/gpu-check.png",
                           "hardware=1", "ev=14", "piped=300",
                           *words.split()], env)
    found = re.search(r"^piped: ([\d.]+) ms", text, re.M)
    if status != 0 or not found:
        print(f"== {program} {words}\n{text[-2000:]}", file=sys.stderr)
        return None
    return float(found[1])


def times(env):
    """In turns, so that what else the machine does falls on both alike."""
    programs = [name for name in ("still-parent", "still")
                if os.path.exists(f"{HERE}/bin/{name}")]
    for what, words in FRAMES:
        got = {name: [] for name in programs}
        for _ in range(ROUNDS):
            for name in programs:
                got[name].append(milliseconds(name, words, env))
        yield what, {name: statistics.median(ms) if None not in ms else None
                     for name, ms in got.items()}


def write(out, device, rows, timed):
    print(f"{device}\n", file=out)
    print("| test | cases passed | failed | s |\n|---|---|---|---|", file=out)
    for name, passed, reason, seconds in rows:
        print(f"| {name} | {passed} | {reason} | {seconds:.1f} |", file=out)
    if not timed:
        return
    names = list(timed[0][1])
    print("\n| ms a frame, two more under way | " + " | ".join(names) + " |",
          file=out)
    print("|---|" + "---|" * len(names), file=out)
    for what, got in timed:
        print(f"| {what} | " + " | ".join(
            "failed" if got[name] is None else f"{got[name]:.3f}"
            for name in names) + " |", file=out)


def describe(env):
    """The driver's name of the device, or None: only a software one."""
    status, text, _ = run([f"{HERE}/bin/still", "/tmp/gpu-check.png",
                           "hardware=1", "width=64", "height_px=64"], env)
    found = re.search(r"^hardware device: (.*)$", text, re.M)
    if status != 0 or not found:
        print(text, file=sys.stderr)
        return None
    return found[1]


def main():
    parser = argparse.ArgumentParser(
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--device", default="0")
    parser.add_argument("--tests", help="only these, divided by blanks")
    parser.add_argument("--no-timings", action="store_true")
    parser.add_argument("out", nargs="?")
    options = parser.parse_args()
    env = environment(options.device)
    device = describe(env)
    if device is None:
        print("no hardware device: nothing was checked", file=sys.stderr)
        return 2
    names = (options.tests.split() if options.tests else
             sorted(name for name in os.listdir(f"{HERE}/bin")
                    if name.endswith("_test")))
    rows, failed = check(names, env)
    timed = [] if options.no_timings else list(times(env))
    write(sys.stdout, device, rows, timed)
    if options.out:
        with open(options.out, "w", encoding="utf-8") as out:
            write(out, device, rows, timed)
    print(f"{len(rows) - failed} passed, {failed} failed", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
