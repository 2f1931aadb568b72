#!/usr/bin/python3
"""A contact sheet of models: each from the side, ahead, above and aslant.

  sheet.py [--level N] [--columns N] [--out FILE.png] [NAME|FILE...]

Without names: every built-in model.
"""
import argparse
import os
import pathlib
import re
import subprocess
import sys
import tempfile

from PIL import Image, ImageDraw

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("PELAGOS_BIN", ROOT / "build/release/bin"))


def builtins():
    text = (ROOT / "server/models/kinds.def").read_text()
    return re.findall(r'^PEL_BUILTIN\("([^"]+)"', text, re.M)


def draw(name, level, folder):
    """The picture of a model with a line of text, or None."""
    out = pathlib.Path(folder) / "model.png"
    path = pathlib.Path(name)
    place = path.parent if path.is_file() else "builtin"
    run = subprocess.run([BIN / "drawmodel", place, path.name, str(level), out],
                         stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                         text=True)
    if run.returncode:
        print(f"{name}: {run.stderr.strip()}", file=sys.stderr)
        return None
    with Image.open(out) as picture:
        picture = picture.convert("RGB")
    ImageDraw.Draw(picture).text((8, 4), run.stdout.strip(), fill=(0, 0, 0))
    print(run.stdout.strip())
    return picture


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--level", type=int, default=0)
    parser.add_argument("--columns", type=int, default=2)
    parser.add_argument("--out", default=ROOT / "build/models.png")
    parser.add_argument("names", nargs="*")
    args = parser.parse_args()
    names = args.names or builtins()
    with tempfile.TemporaryDirectory() as folder:
        pictures = [draw(name, args.level, folder) for name in names]
    drawn = [picture for picture in pictures if picture]
    if not drawn:
        sys.exit("nothing was drawn")
    width, height = drawn[0].size
    rows = -(-len(drawn) // args.columns)
    sheet = Image.new("RGB", (width * args.columns, height * rows))
    for i, picture in enumerate(drawn):
        sheet.paste(picture, (i % args.columns * width,
                              i // args.columns * height))
    pathlib.Path(args.out).parent.mkdir(parents=True, exist_ok=True)
    sheet.save(args.out)
    print(f"{args.out}: {len(drawn)} of {len(names)} models")


main()
