#!/usr/bin/python3
"""Every header compiles alone, with the flags of a source beside it."""
import os
import sys

import each

known = each.commands()
any_source = known["server/main.c"]
beside = {os.path.dirname(path): words for path, words in known.items()}
sys.exit(each.check("headers", any_source[0].split()[0], b"", {
    path: (beside.get(os.path.dirname(path), any_source)
           + ["-Werror", "-fsyntax-only", "-x", "c", "-"],
           f'#include "{path}"\n')
    for path in each.sources(".h")}))
