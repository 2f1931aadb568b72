#!/usr/bin/python3
"""Rain and snow of growing rates over one sea, by day, at dusk and under the
Moon, on one sheet: `make weather-sheet`.

    weather.py [OUT.jpg]

Drawn by a daemon on the software device, 9 m above the water, a coaster 700 m
and a buoy 250 m away. Prints the EV of each.
"""
import os
import sys

from PIL import Image, ImageDraw

from eyekit import ROOT, eye
from sheet import font

COLUMNS, WIDE, HIGH, LABEL = 3, 960, 540, 28
VIEW = {"width": WIDE, "height": HIGH, "up": 9, "pitch": -1, "yaw": 60,
        "fieldOfView": 50}
WEATHER = [
    ("dry, altostratus", {"cloudGenus": "ALTOSTRATUS"}, 8),
    ("drizzle 0.5 mm/h", {"rain": 0.5}, 6),
    ("rain 4 mm/h", {"rain": 4}, 8),
    ("heavy rain 25 mm/h", {"rain": 25}, 10),
    ("squall, 80 mm/h", {"rain": 80}, 16),
    ("snow 0.4 mm/h", {"snow": 0.4}, 6),
    ("heavy snow 2.5 mm/h", {"snow": 2.5}, 10),
]
LIGHT = [("Sun 35 deg", {"sunElevation": 35, "sunAzimuth": 150}),
         ("Sun 3 deg below", {"sunElevation": -3, "sunAzimuth": 150}),
         ("full Moon 40 deg", {"sunElevation": -30, "sunAzimuth": 330,
                               "moonElevation": 40, "moonAzimuth": 150})]


def thing(model, east_m, north_m, heading):
    return {"model": {"name": model}, "latitude": north_m / 110574,
            "longitude": east_m / 111320, "heading": heading}


SHIPS = {"1": thing("container-ship", 560, 420, 300),
         "2": thing("lateral-port-a", 240, 80, 0)}


def main():
    target = sys.argv[1] if len(sys.argv) > 1 else os.path.join(
        ROOT, "build", "weather.jpg")
    os.makedirs(os.path.dirname(os.path.abspath(target)), exist_ok=True)
    os.nice(max(0, 10 - os.nice(0)))
    sheet = Image.new("RGB", (COLUMNS * WIDE, len(WEATHER) * (HIGH + LABEL)),
                      "white")
    pen, face = ImageDraw.Draw(sheet), font(17)
    print("| weather | light | EV |\n|---|---|---|")
    with eye() as draw:
        for j, (words, sky, wind) in enumerate(WEATHER):
            for i, (light, bodies) in enumerate(LIGHT):
                picture, ev = draw(
                    VIEW, entities=SHIPS, origin={"latitude": 0, "longitude": 0}, sky={
                        "cloudCover": 8, "cloudGenus": "NIMBOSTRATUS",
                        "visibility": 25000, **bodies, **sky},
                    sea={"windSpeed": wind, "windDirection": 80,
                         "synthesiser": "FFT", "spectrum": "ELFOUHAILY",
                         "whitecaps": 1})
                print(f"| {words} | {light} | {ev:.2f} |", flush=True)
                x, y = i * WIDE, j * (HIGH + LABEL)
                sheet.paste(picture, (x, y))
                pen.text((x + 4, y + HIGH + 3), f"{words}, {light}",
                         fill="black", font=face)
    sheet.save(target, quality=90)
    print(f"\n{target}")


if __name__ == "__main__":
    main()
