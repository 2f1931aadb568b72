#!/usr/bin/python3
"""Comments and pages name only files that are there: `waves.md`,
`server/ocean/sea.h`, `bridges/ais.c` and the like, by their whole path, by one
below server/ or clients/, or by their name alone, as names are unique."""
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


def main():
    files = tracked()
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
    print(f"pointers: {len(files)} files, {wrong} names of files that are not "
          "there")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
