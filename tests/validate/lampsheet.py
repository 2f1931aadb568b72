#!/usr/bin/python3
"""The five windows of a bridge by night, with traffic, on one sheet:
`make lamps-sheet`.

    lampsheet.py [OUT.jpg]

A fairway at dusk, under the Moon, under stars and in haze: a tanker and a ferry
meet own ship, a trawler works, a container ship is at anchor, lateral and
cardinal marks flash, a lighthouse stands behind them; own ship's searchlight is
on a buoy. The windows share a meter, as bridge.py has them. Prints their EV.
"""
import io
import os
import sys

from PIL import Image, ImageDraw

from eyekit import BASE, ROOT
from sheet import font

sys.path.insert(0, os.path.join(ROOT, "clients", "python", "examples"))
from bridge import ACROSS, BOTTOM, TOP, WINDOWS  # noqa: E402
from pelagos.exr import read_exr  # noqa: E402
from pelagos_daemon import Daemon  # noqa: E402

WIDE, HIGH, LABEL = 640, 540, 28
OWN = 1
LIGHT = [
    ("dusk, Sun 7 deg below", {"sunElevation": -7, "sunAzimuth": 285,
                               "visibility": 30000}),
    ("full Moon 25 deg, 3 octas", {
        "sunElevation": -30, "sunAzimuth": 300, "moonElevation": 25,
        "moonAzimuth": 25, "visibility": 30000, "cloudCover": 3,
        "cloudGenus": "STRATOCUMULUS"}),
    ("no Moon", {"sunElevation": -40, "sunAzimuth": 300,
                 "visibility": 30000}),
    ("no Moon, visibility 4 km", {"sunElevation": -40, "sunAzimuth": 300,
                                  "visibility": 4000}),
]


def at(east_m, north_m, heading=0.0, **more):
    return {"latitude": north_m / 110574, "longitude": east_m / 111320,
            "heading": heading, **more}


def ship(model, east_m, north_m, heading, **more):
    return at(east_m, north_m, heading, model={"name": model}, lights="AUTO",
              **more)


def mark(model, east_m, north_m, **more):
    return ship(model, east_m, north_m, 0, **more)


TRAFFIC = {
    str(OWN): ship("ferry", 0, 0, 0, speed=7, searchlight={
        "on": True, "bearing": 33.5, "elevation": -4, "width": 3,
        "intensity": 2e6}),
    "2": ship("tanker", -320, 1500, 178, speed=6),
    "3": ship("ferry", 900, 1900, 225, speed=9),
    "4": ship("fishing-boat", 1100, 500, 60, speed=2,
              navigationStatus="TRAWLING"),
    "5": ship("container-ship", -1500, 500, 20,
              navigationStatus="AT_ANCHOR"),
    "6": ship("sailing-yacht", -500, 250, 100, speed=3, navigationStatus="SAILING"),
    "10": mark("lateral-port-a", -200, 420),
    "11": mark("lateral-starboard-a", 200, 300),
    "12": mark("lateral-port-a", -200, 1250),
    "13": mark("lateral-starboard-a", 200, 1250),
    "14": mark("cardinal-east", 150, 330),
    "20": at(2600, 3200, lights="ON", light={
        "character": "Fl(3) W 12s", "range": 20, "height": 42, "phase": 9}),
}


def views():
    return {name: {
        "entity": OWN, "forward": 84, "up": 24, "yaw": foot, "width": WIDE,
        "height": HIGH, "meter": "bridge", "vision": "EYE",
        "frustum": {"left": middle - foot - ACROSS / 2,
                    "right": middle - foot + ACROSS / 2,
                    "top": TOP, "bottom": BOTTOM}}
        for name, (middle, foot) in WINDOWS.items()}


def main():
    target = sys.argv[1] if len(sys.argv) > 1 else os.path.join(
        ROOT, "build", "lamps.jpg")
    os.makedirs(os.path.dirname(os.path.abspath(target)), exist_ok=True)
    os.nice(max(0, 10 - os.nice(0)))
    sheet = Image.new("RGB", (len(WINDOWS) * WIDE, len(LIGHT) * (HIGH + LABEL)),
                      "white")
    pen, face = ImageDraw.Draw(sheet), font(17)
    print("| light | EV |\n|---|---|")
    with Daemon() as daemon:
        for j, (words, sky) in enumerate(LIGHT):
            daemon.patch({"sky": None, "views": None})
            answer = daemon.patch({
                **BASE, "origin": {"latitude": 0, "longitude": 0},
                "sea": {"windDirection": 250, "windSpeed": 6,
                        "synthesiser": "FFT", "spectrum": "ELFOUHAILY"},
                "clock": {"mode": "STEPPED", "time": 100.3,
                          "utc": "2026-03-03T21:00:00Z"},
                "sky": sky, "entities": TRAFFIC, "views": views()})
            if answer.status != 200:
                sys.exit(f"{words}: {answer.status} {answer.body[:300]!r}")
            for i, name in enumerate(sorted(
                    WINDOWS, key=lambda window: WINDOWS[window][0])):
                path = f"/v1/views/{name}/frame"
                picture = Image.open(io.BytesIO(daemon.get(path + ".png").body))
                sheet.paste(picture.convert("RGB"),
                            (i * WIDE, j * (HIGH + LABEL)))
            small = daemon.get(path + ".exr?layers=radiance").body
            ev = float(read_exr(small).attributes["pelagos.exposure"])
            print(f"| {words} | {ev:.2f} |", flush=True)
            pen.text((4, j * (HIGH + LABEL) + HIGH + 3), words, fill="black",
                     font=face)
    sheet.save(target, quality=90)
    print(f"\n{target}")


if __name__ == "__main__":
    main()
