#!/usr/bin/python3
"""Reads every model file below a folder by `pelagosctl model check`.

  checkall.py DIR

One line a file: seconds, what it is or why it is refused. Exit status 1 if
one takes more than 5 s and a half, or a reader leaves no reason.
"""
import os
import pathlib
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("PELAGOS_BIN", ROOT / "build/release/bin"))
ENDINGS = {".glb", ".gltf", ".obj", ".dae", ".3ds", ".ac", ".stl", ".x"}


def main():
    folder = pathlib.Path(sys.argv[1])
    files = sorted(path for path in folder.rglob("*")
                   if path.suffix.lower() in ENDINGS)
    good = bad = 0
    for path in files:
        start = time.monotonic()
        run = subprocess.run([BIN / "pelagosctl", "model", "check", path],
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                             text=True)
        took = time.monotonic() - start
        lines = run.stdout.strip().splitlines()
        good += run.returncode == 0
        bad += took > 5.5 or not lines
        mark = "reads  " if run.returncode == 0 else "refused"
        print(f"{mark} {took:5.2f} s  {path.relative_to(folder)}: "
              f"{'; '.join(lines)[:200]}")
    print(f"{len(files)} files: {good} read, {len(files) - good} refused, "
          f"{bad} too slow or without a reason")
    sys.exit(1 if bad else 0)


main()
