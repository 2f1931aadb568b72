"""Sphinx extension: docstrings of this package are plain text for `help()`.
What is laid out in them is told to Sphinx: blocks that stand in become code,
rows of a name, two blanks and words become lists of definitions."""
from __future__ import annotations

import re
from typing import Any

ROW = re.compile(r"(\S.*?)\s{2,}(\S.*)")
# What reStructuredText would take for markup.
MARKUP = re.compile(r"(?<!`)([*|\\])|(\w)_(?!\w)")
CODE = re.compile(r"`([^`]+)`")


def prose(text: str) -> str:
    """A piece of text without markup but code in single backticks."""
    parts = CODE.split(text)
    return "".join(f"``{part}``" if n % 2 else MARKUP.sub(
        lambda m: "\\" + m[1] if m[1] else m[2] + "\\_", part)
        for n, part in enumerate(parts))


def blocks(lines: list[str]) -> list[list[str]]:
    out: list[list[str]] = [[]]
    for line in lines:
        if line.strip():
            out[-1].append(line.rstrip())
        elif out[-1]:
            out.append([])
    return [block for block in out if block]


def rows(block: list[str]) -> list[tuple[str, list[str]]] | None:
    """Names and their words, where all of the block is such rows."""
    found: list[tuple[str, list[str]]] = []
    for line in block:
        if line[0] != " " and (match := ROW.fullmatch(line)):
            found.append((match[1], [match[2]]))
        elif found and line[0] == " ":
            found[-1][1].append(line.strip())
        else:
            return None
    return found


def told(lines: list[str]) -> list[str]:
    out: list[str] = []
    for block in blocks(lines):
        if all(line[0] == " " for line in block):
            out += ["::", "", *("   " + line for line in block)]
        elif found := rows(block):
            for name, words in found:
                out += [f"``{name}``", *("   " + prose(w) for w in words)]
        else:
            # Within a paragraph what stands in is a row without its table.
            out += [prose(line.strip()) for line in block]
        out.append("")
    return out


def docstring(app: Any, what: str, name: str, thing: Any, options: Any,
              lines: list[str]) -> None:
    lines[:] = told(lines)


def setup(app: Any) -> dict[str, Any]:
    app.connect("autodoc-process-docstring", docstring)
    return {"parallel_read_safe": True}
