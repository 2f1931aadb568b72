#!/usr/bin/python3
"""Cover of 1 to 8 octas under a high and a low Sun, each genus of cloud, and
Beaufort 6 under overcasts, on one sheet: `make octas-sheet`.

    octas.py [OUT.jpg]

Drawn by a daemon on the software device, 12 m above the water. Prints the EV of
each.
"""
import os
import sys

from PIL import Image, ImageDraw

from eyekit import ROOT, eye
from sheet import font

COLUMNS, WIDE, HIGH, LABEL = 4, 640, 360, 24
VIEW = {"width": WIDE, "height": HIGH, "up": 12, "pitch": 6, "yaw": 120}
GENERA = ["STRATOCUMULUS", "STRATUS", "NIMBOSTRATUS", "ALTOCUMULUS",
          "ALTOSTRATUS", "CIRRUS", "CUMULONIMBUS"]


def skies():
    for elevation in (40, 6):
        for cover in range(1, 9):
            yield f"{cover} octas, Sun {elevation} deg", 8, {
                "sunElevation": elevation, "sunAzimuth": 150,
                "cloudCover": cover,
                "cloudGenus": "CUMULUS" if cover < 6 else "STRATOCUMULUS"}
    for genus in GENERA:
        for cover in ((8,) if genus in ("STRATUS", "NIMBOSTRATUS",
                                        "ALTOSTRATUS") else (5,)):
            yield f"{genus.lower()}, {cover} octas, Sun 25 deg", 8, {
                "sunElevation": 25, "sunAzimuth": 150, "cloudCover": cover,
                "cloudGenus": genus}
    for genus in ("STRATOCUMULUS", "STRATUS", "NIMBOSTRATUS", "ALTOSTRATUS"):
        yield f"Beaufort 6 under {genus.lower()}", 12.4, {
            "sunElevation": 30, "sunAzimuth": 150, "cloudCover": 8,
            "cloudGenus": genus, "visibility": 20000}


def main():
    target = sys.argv[1] if len(sys.argv) > 1 else os.path.join(
        ROOT, "build", "octas.jpg")
    os.makedirs(os.path.dirname(os.path.abspath(target)), exist_ok=True)
    os.nice(max(0, 10 - os.nice(0)))
    every = list(skies())
    lines = -(-len(every) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * WIDE, lines * (HIGH + LABEL)), "white")
    pen, face = ImageDraw.Draw(sheet), font(15)
    print("| sky | EV |\n|---|---|")
    with eye() as draw:
        for i, (words, wind, sky) in enumerate(every):
            picture, ev = draw(VIEW, sky=sky, sea={
                "windSpeed": wind, "windDirection": 80, "synthesiser": "FFT",
                "whitecaps": 1})
            print(f"| {words} | {ev:.2f} |", flush=True)
            x, y = i % COLUMNS * WIDE, i // COLUMNS * (HIGH + LABEL)
            sheet.paste(picture, (x, y))
            pen.text((x + 4, y + HIGH + 2), words, fill="black", font=face)
    sheet.save(target, quality=90)
    print(f"\n{target}")


if __name__ == "__main__":
    main()
