#!/usr/bin/python3
"""Comments and pages name only files that are there: `waves.md`,
`server/ocean/sea.h`, `bridges/ais.c` and the like, by their whole path, by one
below server/ or clients/, or by their name alone, as names are unique. Pages
name only functions, types and cases of tests that are there: `pel_sea_query`,
`ocean/sea.c: pel_sea_build`, `sea.c`: `sum_up`, `sea_test: energy`."""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
ENDS = "c|h|py|sh|md|glsl|frag|vert|comp|mjs|js|css|html|def|proto|conf|service|nmea|svg"
NAME = re.compile(rf"(?<![\w./*<$%-])((?:[\w.-]+/)*[\w-][\w.-]*\.(?:{ENDS}))(?![\w(*-])")
COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.S)
# Files that are made, or the system's; OUT.md and x.glsl stand for any.
ELSEWHERE = re.compile(
    r"^(build|netinet)/|(^|/)([A-Z]+|[a-z]|[a-z]+[-_][A-Z]+|a\.b)\.[\w.]+$|"
    r"(^|/)(pelagos\.pb-c\.[ch]|(fields|shaders|pages|block)\.c|lib/layers\.glsl)$")

PEL = re.compile(r"\b(?:pel|PEL)_[A-Za-z0-9_]+\b(?![*.])")
# `file: name, name`, then `file`: `name`, `name`.
WITHIN = re.compile(r"`([\w./]+): ([a-z]\w*(?:, [a-z]\w*)*)`")
BESIDE = re.compile(r"`([\w./]+\.[ch])`: ((?:`\w+`(?:, )?)+)")


def tracked():
    names = subprocess.run(["git", "ls-files"], cwd=ROOT, check=True,
                           capture_output=True, text=True).stdout.split("\n")
    return [n for n in names if n and (ROOT / n).is_file()]


def comments_of(path):
    text = path.read_text(encoding="utf-8", errors="replace")
    if path.suffix in (".c", ".h", ".def", ".glsl", ".frag", ".vert", ".comp",
                       ".mjs", ".js", ".css"):
        return COMMENT.finditer(text)
    if path.suffix == ".md":
        return re.finditer(r"(?s).+", re.sub(
            r"(?s)```.*?```", lambda m: "\n" * m[0].count("\n"), text))
    if path.suffix in (".py", ".sh") or path.name == "Makefile":
        return re.finditer(r'#[^\n]*|"""(?s:.*?)"""', text)
    return iter(())


def texts_of(word, files):
    """Texts of the files that a page means by this word: a path, a name, or a
    test by its name."""
    ends = {word, word + ".c", word + ".py"}
    return [(ROOT / f).read_text(encoding="utf-8", errors="replace")
            for f in files
            if f in ends or any(f.endswith("/" + e) for e in ends)]


def names_not_there(text, files, every):
    """(offset, word) of names on a page that no source has."""
    for match in PEL.finditer(text):
        if match[0] not in every:
            yield match.start(), match[0]
    for form in (WITHIN, BESIDE):
        for match in form.finditer(text):
            texts = texts_of(match[1], files)
            if not texts and match[1].endswith("_test"):
                yield match.start(), match[1]
            for name in re.findall(r"\w+", match[2]) if texts else ():
                if not any(re.search(rf"\b(?:test_)?{name}", t)
                           for t in texts):
                    yield match.start(), f"{match[1]}: {name}"


def main():
    files = tracked()
    sources = [f for f in files if f.endswith((".c", ".h", ".glsl", ".def",
                                               ".frag", ".vert", ".comp"))]
    every = {word for f in sources for word in PEL.findall(
        (ROOT / f).read_text(encoding="utf-8", errors="replace"))}
    known = set(files) | {pathlib.PurePath(f).name for f in files}
    known |= {f.split("/", 1)[1] for f in files if "/" in f}
    wrong = 0
    for name in files:
        for part in comments_of(ROOT / name):
            for match in NAME.finditer(part[0]):
                word = match[1].removeprefix("./")
                beside = (pathlib.PurePath(name).parent / word).as_posix()
                if (word in known or beside in known or
                        ELSEWHERE.search(word) or
                        (ROOT / name).parent.joinpath(word).exists()):
                    continue
                line = part.string.count("\n", 0, part.start() + match.start())
                print(f"{name}:{line + 1}: {word} is not there")
                wrong += 1
        if name.startswith("docs/") and name.endswith(".md"):
            text = (ROOT / name).read_text(encoding="utf-8")
            for at, word in names_not_there(text, files, every):
                print(f"{name}:{text.count(chr(10), 0, at) + 1}: {word} is "
                      "not there")
                wrong += 1
    print(f"pointers: {len(files)} files, {wrong} names of files, functions "
          "and cases that are not there")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
