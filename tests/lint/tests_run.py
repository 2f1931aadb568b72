#!/usr/bin/python3
"""Every test of tests/ is one that tests/run runs: executable, or named by a
target of the Makefile."""
import glob
import os
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(
    os.path.abspath(__file__))))
os.chdir(ROOT)
with open("Makefile", encoding="utf-8") as text:
    makefile = text.read()
tests = sorted(path for end in ("py", "mjs", "sh")
               for path in glob.glob(f"tests/*_test.{end}"))
idle = [path for path in tests
        if not os.access(path, os.X_OK) and path not in makefile]
for path in idle:
    print(f"{path} is not executable, so nothing runs it")
print(f"tests: {len(tests)}, {len(idle)} of them run by nothing")
sys.exit(bool(idle) or not tests)
