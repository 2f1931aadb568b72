#!/usr/bin/python3
"""Plain words. In prose (pages, comments, texts of logs and of the page) no
sentence opens with a bare "Of", nor with a "What" or "Whose" that asks nothing;
and none has "no more" for "no longer", "anew", "whence" or "come by".

Without arguments it judges COVERED, which grows as folders become clean; with
paths it judges those: tests/lint/words.py server/net.
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
COVERED = """
README.md CHANGELOG.md CONTRIBUTING.md docs proto/live.md proto/pelog.md
proto/manual.in.md proto/nmea.in.md
proto/modbus_client.md tests/lint tests/models packaging/image clients/voyage
clients/ros2/pelagos_bridge/launch
""".split()
# Not clean yet; this file names the words that it refuses.
LEFT_OUT = {"docs/reliability.md", "tests/lint/words.py"}
C_LIKE = {".c", ".h", ".def", ".glsl", ".frag", ".vert", ".comp", ".js",
          ".mjs", ".css", ".proto"}
COMMENT = re.compile(r"/\*.*?\*/|(?://[^\n]*\n[ \t]*)*//[^\n]*", re.S)
STRING = re.compile(r'"(?:[^"\\\n]|\\.)*"')
PYTHON = re.compile(r'"""(?s:.*?)"""|(?:^[ \t]*#[^\n]*\n?)+', re.M)
OPENS = re.compile(r"(?:^ *(?:[-*] +)?|[.!?;:|] +|\*\* +)"
                   r"(Of|What|Whose)\b[^.!?|]*[.!?|]?", re.M)
WORDS = re.compile(r"\b(no more\b(?! than)|anew|whence|com(?:e|es|ing) by|"
                   r"came by)\b", re.I)


def blank(match):
    """The lines that it had, without its words."""
    return "\n" * match[0].count("\n")


def prose(path, text):
    """(offset, text) of the parts that people read."""
    if path.suffix == ".md":
        text = re.sub(r"```.*?```", lambda m: re.sub(r"[^\n]", " ", m[0]),
                      text, flags=re.S)
        text = re.sub(r"`[^`\n]*`", lambda m: "x" * len(m[0]), text)
        text = re.sub(r"^#.*$", lambda m: " " * len(m[0]), text, flags=re.M)
        yield 0, text
    elif path.suffix in C_LIKE:
        for match in COMMENT.finditer(text):
            yield match.start(), re.sub(
                r"(?m)^[ \t]*(?:/\*+|\*+/|\*|//)?[ \t]*|\*/",
                lambda m: " " * len(m[0]), match[0])
        code = COMMENT.sub(lambda m: re.sub(r"[^\n]", " ", m[0]), text)
        for match in STRING.finditer(code):
            if " " in match[0]:
                yield match.start() + 1, match[0][1:-1]
    elif path.suffix in (".py", ".sh"):
        for match in PYTHON.finditer(text):
            yield match.start(), re.sub(
                r'(?m)^[ \t]*#*[ \t]?|"""', lambda m: " " * len(m[0]),
                match[0])


def faults(path, text):
    for at, part in prose(path, text):
        # A line may end within a sentence: its next is no opening.
        joined = re.sub(r"(?<=[^\n|])\n[ \t]*(?=[^\s|*#-])",
                        lambda m: " " * len(m[0]), part.lstrip())
        lead = at + len(part) - len(part.lstrip())
        for match in OPENS.finditer(joined):
            if not match[0].rstrip().endswith("?"):
                yield lead + match.start(1), match[0].strip()[:60]
        for match in WORDS.finditer(part):
            yield at + match.start(), match[0]


def tracked(paths):
    listed = subprocess.run(["git", "ls-files", "--", *paths], cwd=ROOT,
                            check=True, capture_output=True, text=True)
    return [f for f in listed.stdout.split("\n") if f and f not in LEFT_OUT]


def main():
    files, wrong = tracked(sys.argv[1:] or COVERED), 0
    for name in files:
        path = ROOT / name
        if not path.is_file() or path.suffix not in C_LIKE | {".md", ".py",
                                                              ".sh"}:
            continue
        text = path.read_text(encoding="utf-8", errors="replace")
        for at, words in faults(path, text):
            print(f"{name}:{text.count(chr(10), 0, at) + 1}: "
                  f"\"{' '.join(words.split())}\"")
            wrong += 1
    print(f"words: {len(files)} files, {wrong} that want a plainer word")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
