#!/usr/bin/python3
"""What a failed test's log says of the failure.

    why.py brief LOG    one line for each part that failed, the first line first
    why.py show LOG     the lines that matter with their neighbours, then the end

Knows cmocka, Python's unittest, TAP (node's test runner, our shell tests) and
the sanitizers; of anything else it takes lines that speak of an error.
"""
import re
import sys

TAP = re.compile(r"^\s*not ok\b(?!.*# *(SKIP|TODO))", re.I)
UNITTEST = re.compile(r"^(FAIL|ERROR): \w+ \(")
RAISED = re.compile(r"^\w[\w.]*(Error|Exception|Expired|Timeout|Exit)\b")
CMOCKA_RUN = re.compile(r"^\[ RUN      \] (.*)")
CMOCKA = re.compile(r"^\[  ERROR   \] --- (.*)")
OTHERS = re.compile(
    r"^(FAILED|FAIL|ERROR|Error|error): |Sanitizer: |runtime error: |^✖ |"
    r"Segmentation fault|Aborted|core dumped|Assertion .*failed|"
    r"^\[   LINE   \]|^[\w/.-]+: line \d+: |" + RAISED.pattern)
# Only where nothing above is found: a daemon's log may say it in passing.
WEAK = re.compile(r"\b(error|failed|fatal|cannot|not found|refused)\b", re.I)
BEFORE, AFTER, MOST, TAIL = 2, 24, 100, 15


def tap_reason(lines, at):
    """The `error:` of the YAML block below a `not ok`."""
    for i in range(at + 1, min(at + 12, len(lines))):
        text = lines[i].strip()
        if re.match(r"(not )?ok\b", text):
            break
        if text.startswith("error:"):
            text = text.removeprefix("error:").strip().strip("'\"")
            if text[:1] not in ("|", ">"):
                return text
            block = [line.strip() for line in lines[i + 1:i + 5]]
            if "code:" in " ".join(block):
                block = block[:next(n for n, line in enumerate(block)
                                    if "code:" in line)]
            return " ".join(filter(None, block))
    return ""


def unittest_reason(lines, at):
    for i in range(at + 2, len(lines)):
        if lines[i].startswith("====="):
            break
        if RAISED.match(lines[i]):
            return lines[i]
    return ""


def cmocka_reason(lines, at):
    if "[   LINE   ]" in lines[at]:  # fail_msg: its words are the line before
        place = lines[at].split("[   LINE   ] --- ")[1]
        words = lines[at - 1].removeprefix("ERROR: ")
    else:
        words = CMOCKA.match(lines[at]).group(1)
        place = lines[at + 1] if at + 1 < len(lines) else ""
        place = place.removeprefix("[   LINE   ] --- ")
    return f"{words} ({place})"


def parts(lines):
    """[(index, text)] of what failed, in the log's order."""
    found, running = [], ""
    for i, line in enumerate(lines):
        if run := CMOCKA_RUN.match(line):
            running = run.group(1)
        elif CMOCKA.match(line):
            found.append((i, f"{running}: {cmocka_reason(lines, i)}"))
        elif TAP.match(line):
            why = tap_reason(lines, i)
            # A suite's line only repeats that something below it failed.
            if not re.match(r"\d+ subtests? failed", why):
                found.append((i, line.strip() + (why and f": {why}")))
        elif UNITTEST.match(line):
            why = unittest_reason(lines, i)
            found.append((i, line + (why and f": {why}")))
    for pattern in (OTHERS, WEAK):
        if not found:
            found = [(i, line.strip()) for i, line in enumerate(lines)
                     if pattern.search(line)]
    return found


def show(lines):
    """What failed with its neighbours, then the end of the log."""
    wanted = set()
    for at, _ in parts(lines):
        if len(wanted) < MOST:
            wanted.update(range(max(at - BEFORE, 0),
                                min(at + AFTER, len(lines))))
    wanted.update(range(max(len(lines) - TAIL, 0), len(lines)))
    last = -1
    for i in sorted(wanted):
        if i != last + 1:
            print("    ⋮")
        print(f"    | {lines[i][:400]}")
        last = i


def main():
    how, path = sys.argv[1:]
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")
    with open(path, encoding="utf-8", errors="replace") as log:
        lines = [line.rstrip("\r\n") for line in log]
    if how == "show":
        show(lines)
        return
    for _, text in parts(lines) or [(0, next(
            (line for line in reversed(lines) if line.strip()), "said nothing")
    )]:
        print(text[:240])


main()
