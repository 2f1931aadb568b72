"""JSON from files that people write: refused with a reason, never by running
out of stack."""
from __future__ import annotations

import json
import math
import re
from typing import Any

# As deep as the daemon reads it (JSON_DEPTH of proto/bounds.def).
DEPTH = 32
_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[\[{\]}]', re.DOTALL)


def parse(text: str) -> Any:
    """ValueError says what is wrong: no JSON, a name twice, a number that
    is not finite, deeper than DEPTH."""
    depth = 0
    for token in _TOKEN.finditer(text):
        at = token.group()
        if at in "[{":
            depth += 1
            if depth > DEPTH:
                line = text.count("\n", 0, token.start()) + 1
                raise ValueError(f"line {line} is nested deeper than {DEPTH} "
                                 "lists and objects, which is the most")
        elif at in "]}":
            depth -= 1
    return json.loads(text, object_pairs_hook=_once, parse_float=_finite,
                      parse_constant=_finite)


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text} is no finite number")
    return value


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    out = dict(pairs)
    if len(out) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(n for n in names if names.count(n) > 1)
        raise ValueError(f"{twice!r} is there twice")
    return out
