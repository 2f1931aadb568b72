#!/usr/bin/python3
"""C sources are as .clang-format says; `make format` makes them so."""
import shutil
import subprocess
import sys

import each

if not shutil.which("clang-format"):
    print("no clang-format")
    sys.exit(each.SKIPPED)
files = each.sources(".c", ".h")
sys.exit(subprocess.run(["clang-format", "--dry-run", "--Werror", *files],
                        cwd=each.ROOT, check=False).returncode)
