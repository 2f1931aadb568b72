#!/usr/bin/python3
"""Log records: every id stands once in the sources, and docs/log.md has each
with its level, its text and what to do about it.

    tests/lint/log_ids.py           compares
    tests/lint/log_ids.py --write   writes levels and texts into docs/log.md;
                                    what to do stays, and is `?` for a new id
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/log.md"
CALL = re.compile(r'\bpel_(log|log_limited|error|warn|info|debug)\(')
ID = re.compile(r'"([A-Z]{3}-\d{3})"\s*,\s*')
LITERAL = re.compile(r'"((?:[^"\\]|\\.)*)"\s*')
ROW = re.compile(r"^\| ([A-Z]{3}-\d{3}) \| ([^|]*) \| ([^|]*) \| (.*) \|$")
LEVELS = {"error": "error", "warn": "warning", "info": "info",
          "debug": "debug"}


def level_of(function, before):
    if function in LEVELS:
        return LEVELS[function]
    named = re.findall(r"PEL_LOG_(ERROR|WARNING|INFO|DEBUG)", before)
    return " or ".join(dict.fromkeys(word.lower() for word in named))


def text_of(source, at):
    """The format at `at`: adjacent literals; of a choice, both."""
    texts, depth = [], 0
    while at < len(source):
        match = LITERAL.match(source, at)
        if match:
            joined = ""
            while match:
                joined += match[1]
                at = match.end()
                match = LITERAL.match(source, at)
            texts.append(joined)
            continue
        char = source[at]
        depth += char in "(["
        depth -= char in ")]"
        if depth < 0 or (depth == 0 and char == ","):
            break
        at += 1
    text = " / ".join(texts).replace("%%", "%").replace("|", "\\|")
    return text.replace("\\\"", "\"")


def records():
    """(id, level, text, place) of each call."""
    for path in sorted((ROOT / "server").rglob("*.c")):
        if path.name.endswith("_test.c"):
            continue
        source = path.read_text(encoding="utf-8")
        for call in CALL.finditer(source):
            found = ID.search(source, call.end(), call.end() + 400)
            if not found or ";" in source[call.end():found.start()]:
                continue
            line = source.count("\n", 0, call.start()) + 1
            yield (found[1], level_of(call[1], source[call.end():
                                                      found.start()]),
                   text_of(source, found.end()),
                   f"{path.relative_to(ROOT)}:{line}")


def named():
    """Every id in the sources, however it is used."""
    for path in sorted((ROOT / "server").rglob("*.c")):
        if not path.name.endswith("_test.c"):
            source = path.read_text(encoding="utf-8")
            for match in re.finditer(r'"([A-Z]{3}-\d{3})"', source):
                yield match[1]


def rows():
    return {m[1]: m.groups() for m in map(
        ROW.match, PAGE.read_text(encoding="utf-8").splitlines()) if m}


def write(found):
    known = rows()
    head = PAGE.read_text(encoding="utf-8").split("| id |")[0]
    table = ["| id | level | text | what it means, what to do |",
             "|---|---|---|---|"]
    for name, (level, text, _) in sorted(found.items()):
        advice = known[name][3] if name in known else "?"
        table.append(f"| {name} | {level} | `{text}` | {advice} |")
    PAGE.write_text(head + "\n".join(table) + "\n", encoding="utf-8")


def main():
    found, wrong = {}, []
    for name, level, text, place in records():
        if name in found:
            wrong.append(f"{place}: {name} is {found[name][2]}'s already: "
                         "an id means one thing")
        found.setdefault(name, (level, text, place))
    for name in sorted(set(named()) - set(found)):
        wrong.append(f"{name} is named, but not in a call that can be read")
    if "--write" in sys.argv[1:]:
        write(found)
    known = rows()
    for name, (level, text, place) in sorted(found.items()):
        if name not in known:
            wrong.append(f"{place}: {name} is not in docs/log.md: "
                         "tests/lint/log_ids.py --write")
        elif known[name][1:3] != (level, f"`{text}`"):
            wrong.append(f"{place}: docs/log.md has another level or text for "
                         f"{name}: tests/lint/log_ids.py --write")
        elif len(known[name][3]) < 2:
            wrong.append(f"docs/log.md does not say what {name} means and "
                         "what to do")
    for name in sorted(set(known) - set(found)):
        wrong.append(f"docs/log.md has {name}, which no source writes")
    print("\n".join(wrong) or f"{len(found)} log ids, each once, documented")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
