"""Reads tables of rows such as layers.def."""
import re

TOKEN = re.compile(r'"((?:[^"\\]|\\.)*)"|([A-Za-z0-9_.+-]+)|([(),])')


def rows(path, macro):
    """The cells of every `macro(…)` in a file, strings without quotes. Names
    that the file itself defines as a string stand for it."""
    with open(path, encoding="utf-8") as file:
        text = re.sub(r"/\*.*?\*/", " ", file.read(), flags=re.S)
    words = dict(re.findall(r'^#define (\w+) "(.*)"$', text, re.M))
    text = re.sub(r"^#.*$", " ", text, flags=re.M)
    out, at = [], 0
    while True:
        start = re.compile(rf"\b{macro}\s*\(").search(text, at)
        if not start:
            return out
        cells, at = [""], start.end()
        while True:
            token = TOKEN.search(text, at)
            at = token.end()
            string, word, mark = token.groups()
            if mark == ")":
                break
            if mark == ",":
                cells.append("")
            elif string is not None:
                cells[-1] += string.replace('\\"', '"')
            else:
                cells[-1] += words.get(word, word)
        out.append(cells)
