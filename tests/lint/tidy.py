#!/usr/bin/python3
"""clang-tidy over every C source, as .clang-tidy says."""
import pathlib
import sys

import each

CONFIG = (pathlib.Path(each.ROOT) / ".clang-tidy").read_bytes()
QUIET = "--quiet", "--warnings-as-errors=*"
sys.exit(each.check("tidy", "clang-tidy", CONFIG, {
    path: (["clang-tidy", *QUIET, path, "--", *words[1:]], "")
    for path, words in each.commands().items()}))
