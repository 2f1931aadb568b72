#!/usr/bin/python3
"""Dusk as an eye and a camera see it, on one sheet: `make dusk-sheet`.

    dusksheet.py [OUT.jpg]

The Sun from +4 to -18 degrees, 30 degrees right of ahead, over a sea in 6 m/s
with a ship 400 m off and her lights: of each pair the left picture is EYE's, the
right CAMERA's, as a daemon draws them on the software device. Prints EV and what
a screen shows, of its white: sky and sea beside the horizon, all of the picture.
"""
import io
import os
import sys

from PIL import Image, ImageDraw

from eyekit import ROOT, read_exr
from pelagos_daemon import Daemon
from sheet import font

SUNS = (4, 2, 0, -2, -4, -6, -8, -10, -12, -14, -16, -18)
PAIRS, WIDE, HIGH, LABEL = 2, 560, 315, 22
VIEW = {"width": WIDE, "height": HIGH, "up": 8, "pitch": 1, "yaw": 270,
        "fieldOfView": 60}
SEES = ("EYE", "CAMERA")
SHIP = {"model": {"name": "container-ship"}, "latitude": 36 + 40 / 110574,
        "longitude": -700 / 90000, "heading": 220, "lights": "AUTO"}


def shown(picture, top, bottom):
    """Linear luminance of rows, of white; their outer thirds: no ship there."""
    total, count = 0.0, 0
    for y in range(top, bottom):
        for x in (*range(0, WIDE // 3, 3), *range(WIDE * 2 // 3, WIDE, 3)):
            rgb = picture.getpixel((x, y))
            linear = [v / 3294.6 if v <= 10 else ((v / 255 + 0.055) / 1.055) ** 2.4
                      for v in rgb]
            total += (0.2126 * linear[0] + 0.7152 * linear[1]
                      + 0.0722 * linear[2])
            count += 1
    return total / count


def main():
    target = sys.argv[1] if len(sys.argv) > 1 else os.path.join(
        ROOT, "build", "dusk.jpg")
    os.makedirs(os.path.dirname(os.path.abspath(target)), exist_ok=True)
    os.nice(max(0, 10 - os.nice(0)))
    lines = -(-len(SUNS) // PAIRS)
    sheet = Image.new("RGB", (2 * PAIRS * WIDE, lines * (HIGH + LABEL)), "white")
    pen, face = ImageDraw.Draw(sheet), font(14)
    print("| Sun, ° | zenith, cd/m² | by | EV | sky at the horizon | sea "
          "before it | all |\n|---|---|---|---|---|---|---|")
    with Daemon() as daemon:
        answer = daemon.patch({
            "clock": {"mode": "STEPPED", "utc": "2026-09-10T12:00:00Z"},
            "origin": {"latitude": 36, "longitude": 0},
            "sea": {"windSpeed": 6, "windDirection": 250, "synthesiser": "FFT"},
            "sky": {"sunAzimuth": 300, "stars": True, "moonElevation": -40},
            "entities": {"1": SHIP},
            "views": [{"name": name.lower(), "vision": name, **VIEW}
                      for name in SEES]})
        if answer.status != 200:
            sys.exit(f"dusk: {answer.status} {answer.body[:300]!r}")
        for i, sun in enumerate(SUNS):
            answer = daemon.patch({"sky": {"sunElevation": sun}})
            if answer.status != 200:
                sys.exit(f"{sun}: {answer.status} {answer.body[:300]!r}")
            sky = daemon.get("/v1/optics/sky?from=GPU&elevation=90").json()
            zenith = sky["sky"]["luminance"]
            for k, name in enumerate(SEES):
                path = f"/v1/views/{name.lower()}/frame"
                picture = Image.open(io.BytesIO(
                    daemon.get(path + ".png").body)).convert("RGB")
                small = daemon.get(path + ".exr?layers=radiance").body
                ev = float(read_exr(small).attributes.get("pelagos.exposure"))
                x = (i % PAIRS * 2 + k) * WIDE
                y = i // PAIRS * (HIGH + LABEL)
                sheet.paste(picture, (x, y))
                middle = HIGH // 2 + 8
                parts = [shown(picture, *rows) for rows in (
                    (middle - 30, middle - 15), (middle + 15, middle + 40),
                    (0, HIGH))]
                print(f"| {sun} | {zenith:.3g} | {name} | {ev:.2f} | "
                      + " | ".join(f"{part:.2%}" for part in parts) + " |",
                      flush=True)
                pen.text((x + 4, y + HIGH + 2), f"Sun {sun}°, {name}: EV "
                         f"{ev:.1f}, zenith {zenith:.2g} cd/m²", fill="black",
                         font=face)
    sheet.save(target, quality=88)
    print(f"\n{target}")


if __name__ == "__main__":
    main()
