#!/usr/bin/python3
"""clang-tidy over C sources, as .clang-tidy says.

    tidy.py [FILE...]   paths of sources; without any, every one
"""
import argparse
import os
import pathlib
import sys

import each

CONFIG = (pathlib.Path(each.ROOT) / ".clang-tidy").read_bytes()
QUIET = "--quiet", "--warnings-as-errors=*"
parser = argparse.ArgumentParser(
    description="clang-tidy over C sources, as .clang-tidy says")
parser.add_argument("file", nargs="*", help="a .c file; none: every one")
chosen = [os.path.relpath(os.path.realpath(f), each.ROOT)
          for f in parser.parse_args().file]
commands = each.commands()
if unknown := [f for f in chosen if f not in commands]:
    parser.error(f"not compiled: {unknown[0]}")
sys.exit(each.check("tidy", "clang-tidy", CONFIG, {
    path: (["clang-tidy", *QUIET, path, "--", *words[1:]], "")
    for path, words in commands.items() if not chosen or path in chosen},
    whole=not chosen))
