#!/usr/bin/python3
"""clang-tidy over C sources, as .clang-tidy says.

    tidy.py [--deep] [FILE...]   paths of sources; without any, every one

The analyser looks at so many states of each function (NODES) that it takes a
sixth of the time that its own limit of 225,000 would; --deep has that, and so
has a source that it finds something in: what it had to give up may be why.
"""
import argparse
import os
import pathlib
import sys

import each

CONFIG = (pathlib.Path(each.ROOT) / ".clang-tidy").read_bytes()
QUIET = "--quiet", "--warnings-as-errors=*"
NODES = 20000
TWICE = ('{ [ -n "$0" ] && clang-tidy $0 "$@" >/dev/null 2>&1; } || '
         'exec clang-tidy "$@"')
parser = argparse.ArgumentParser(
    description="clang-tidy over C sources, as .clang-tidy says")
parser.add_argument("file", nargs="*", help="a .c file; none: every one")
parser.add_argument("--deep", action="store_true",
                    help="as far as the analyser goes by itself")
asked = parser.parse_args()
chosen = [os.path.relpath(os.path.realpath(f), each.ROOT) for f in asked.file]
limit = [] if asked.deep else [
    f"--extra-arg={word}" for word in ("-Xclang", "-analyzer-config", "-Xclang",
                                       f"max-nodes={NODES}")]
commands = each.commands()
if unknown := [f for f in chosen if f not in commands]:
    parser.error(f"not compiled: {unknown[0]}")
sys.exit(each.check("tidy", "clang-tidy", CONFIG + repr(limit).encode(), {
    path: (["sh", "-c", TWICE, " ".join(limit), *QUIET, path, "--",
            *words[1:]], "")
    for path, words in commands.items() if not chosen or path in chosen},
    whole=not chosen))
