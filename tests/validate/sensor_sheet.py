#!/usr/bin/python3
"""Sensors and radar on one sheet: `make sensor-sheet`.

    sensor_sheet.py [OUT.jpg]

One scene with traffic, by day and by night, as eye, low-light camera, heat and
radar see it, drawn by a daemon of its own (build/sensors.jpg).
"""
import io
import os
import sys

from PIL import Image, ImageDraw

from eyekit import BASE, ROOT, VIEW
from pelagos_daemon import Daemon
from sheet import font

COLUMNS, WIDE, HIGH, LABEL = 4, 480, 360, 22
LAT, LON, MILE = 52.6, 5.2, 1 / 60


def thing(model, east_m, north_m, heading, **more):
    return {"model": {"name": model}, "latitude": LAT + north_m / 111320,
            "longitude": LON + east_m / 67700, "heading": heading,
            "course": heading, "speed": 6, **more}


TRAFFIC = {
    "1": thing("ferry", 60, 420, 250), "2": thing("tanker", -900, 2600, 100),
    "3": thing("tug", -110, 300, 60), "4": thing("safe-water", 75, 190, 0,
                                                 speed=0),
    "5": thing("container-ship", 4200, 3100, 320),
    "6": thing("fishing-boat", 1500, -1800, 10),
    "7": thing("sailing-yacht", -2300, -900, 90),
    "8": thing("bulk-carrier", -6000, 7000, 160),
}
FORWARD = {"up": 15, "pitch": -1.5, "fieldOfView": 45}


def scene(name, sun=35, wind=8, visibility=30000, sensor=None, radar=None,
          state=None):
    view = dict(FORWARD, sensor=sensor, radar=radar)
    if radar:
        view.update(up=25, width=HIGH, height=HIGH)
    return {"name": name, "view": view, "state": {
        "sky": {"sunElevation": sun, "sunAzimuth": 250,
                "visibility": visibility, **(state or {})},
        "sea": {"windSpeed": wind}, "entities": TRAFFIC}}


NIGHT = {"moonElevation": 40, "moonAzimuth": 200, "moonPhase": 0.6}
HOT, LOW = {"kind": "THERMAL", "autoGain": True}, {"kind": "LOW_LIGHT"}
SCENES = [
    scene("eye, Sun 35°"),
    scene("visible sensor", sensor={"kind": "VISIBLE"}),
    scene("low light, Sun 35°", sensor=LOW),
    scene("heat, automatic", sensor=HOT),
    scene("eye, Moon 40°, 0.6", sun=-30, state=NIGHT),
    scene("low light, Moon", sun=-30, state=NIGHT, sensor=dict(LOW, gain=0.6)),
    scene("low light, green, no Moon", sun=-30,
          sensor=dict(LOW, gain=0.9, phosphor="GREEN")),
    scene("heat, night, black hot", sun=-30, sensor=dict(HOT, blackHot=True)),
    scene("heat, haze 3 km", sensor=HOT, visibility=3000),
    scene("heat, clouds", sensor=dict(HOT, cloud=0.9)),
    scene("heat, 8 K about the sea", sensor={"kind": "THERMAL", "span": 8}),
    scene("heat, air 5 K colder", sensor=dict(HOT, airTemperature=10)),
    scene("radar 1.5 nmi, 8 m/s", radar={"range": 1.5}),
    scene("radar 3 nmi, sea suppressed", radar={"range": 3, "stc": 0.8}),
    scene("radar 6 nmi, north up", radar={"range": 6, "northUp": True}),
    scene("radar 6 nmi, 15 m/s", wind=15, radar={"range": 6}),
    scene("radar 6 nmi, rain 10 mm/h", radar={"range": 6, "rain": 10}),
    scene("the same, rain suppressed", radar={"range": 6, "rain": 10,
                                              "ftc": 0.7}),
    scene("radar 12 nmi", radar={"range": 12}),
    scene("radar 24 nmi", radar={"range": 24}),
]


def draw(daemon, view, state):
    daemon.patch({"sea": None, "sky": None, "views": None})
    whole = {name: {**BASE.get(name, {}), **state.get(name, {})}
             for name in {**BASE, **state}}
    view = {k: v for k, v in {**VIEW, **view}.items() if v is not None}
    answer = daemon.patch({**whole, "views": [view]})
    if answer.status != 200:
        sys.exit(f"{state}: {answer.status} {answer.body[:300]!r}")
    return Image.open(io.BytesIO(
        daemon.get("/v1/views/v/frame.png").body)).convert("RGB")


def main():
    target = sys.argv[1] if len(sys.argv) > 1 else os.path.join(
        ROOT, "build", "sensors.jpg")
    os.makedirs(os.path.dirname(os.path.abspath(target)), exist_ok=True)
    os.nice(max(0, 10 - os.nice(0)))
    lines = -(-len(SCENES) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * WIDE, lines * (HIGH + LABEL)), "white")
    pen, face = ImageDraw.Draw(sheet), font(13)
    with Daemon() as daemon:
        for i, each in enumerate(SCENES):
            picture = draw(daemon, {"width": WIDE, "height": HIGH,
                                    **each["view"]}, each["state"])
            x, y = i % COLUMNS * WIDE, i // COLUMNS * (HIGH + LABEL)
            sheet.paste(picture, (x + (WIDE - picture.width) // 2, y))
            pen.text((x + 4, y + HIGH + 3), each["name"], fill="black",
                     font=face)
    sheet.save(target, quality=90)
    print(target)


if __name__ == "__main__":
    main()
