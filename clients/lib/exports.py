#!/usr/bin/env python3
"""exports.py NODE HEADER…: the linker's version script of the functions and
descriptors that the headers declare."""
import re
import sys

COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.S)
FUNCTION = re.compile(r"\b(pel(?:agos_)?_\w+)\s*\(")
OBJECT = re.compile(r"extern\s+const\s+\w+\s+(\w+)\s*;")


def names(path):
    with open(path, encoding="utf-8") as file:
        text = COMMENT.sub(" ", file.read())
    text = re.sub(r"^\s*#(?:.*\\\n)*.*$", " ", text, flags=re.M)
    return FUNCTION.findall(text) + OBJECT.findall(text)


def main():
    node, headers = sys.argv[1], sys.argv[2:]
    print(node, "{\n  global:")
    for name in sorted({n for path in headers for n in names(path)}):
        print(f"    {name};")
    print("  local: *;\n};")


if __name__ == "__main__":
    main()
