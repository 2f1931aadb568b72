#!/usr/bin/python3
"""Visibility of the air from 200 m to 40 km, fog of the same, and banks and
layers of fog under several Suns, on one sheet: `make visibility-sheet`.

    visibility.py [OUT.jpg]

Drawn by a daemon on the software device, 12 m above the water, with a
fishing boat
400 m ahead.
"""
import io
import os
import sys

from PIL import Image, ImageDraw

from eyekit import ROOT, Daemon
from sheet import font

COLUMNS, WIDE, HIGH, LABEL = 4, 640, 360, 24
VIEW = {"name": "v", "width": WIDE, "height": HIGH, "up": 12, "pitch": -1, "yaw": 0,
        "fieldOfView": 50}
SHIP = {"id": 2, "name": "boat", "latitude": 52.60345, "longitude": 5.2006,
        "heading": 70, "model": {"name": "fishing-boat"}}
DAY = {"sunElevation": 28, "sunAzimuth": 50}
EVENING = {"sunElevation": 6, "sunAzimuth": 12}


def bank(visibility, north, radius, top):
    return {"visibility": visibility, "top": top, "radius": radius,
            "latitude": 52.6 + north / 111300, "longitude": 5.2, "speed": 0}


def skies():
    for metres in (200, 500, 1000, 2000, 5000, 10000, 20000, 40000):
        yield f"air, {metres} m", {**DAY, "visibility": metres}
    for metres in (50, 150, 400, 1000):
        yield f"fog 60 m high, {metres} m", {
            **DAY, "fog": [{"visibility": metres, "top": 60}]}
    yield "bank, 1.5 km ahead", {**DAY, "fog": [bank(120, 1500, 900, 45)]}
    yield "bank, Sun 6 deg", {**EVENING, "fog": [bank(120, 1500, 900, 45)]}
    yield "within the bank", {**DAY, "fog": [bank(150, 200, 700, 45)]}
    yield "a layer 8 m high", {**EVENING, "fog": [
        {"visibility": 150, "top": 8, "edge": 4}]}
    yield "fog, Sun 6 deg", {**EVENING, "fog": [{"visibility": 600}]}
    yield "fog, twilight", {"sunElevation": -4, "sunAzimuth": 12, "fog": [
        {"visibility": 600}]}
    yield "haze to 800 m, 8 km", {**EVENING, "fog": [
        {"visibility": 8000, "top": 800, "edge": 300}]}
    yield "lifted fog, 30 to 80 m", {**DAY, "fog": [
        {"visibility": 150, "bottom": 30, "top": 80, "edge": 15}]}


def must(answer):
    if answer.status != 200:
        sys.exit(f"{answer.status} {answer.body[:300]!r}")
    return answer


def main():
    target = sys.argv[1] if len(sys.argv) > 1 else os.path.join(
        ROOT, "build", "visibility.jpg")
    os.makedirs(os.path.dirname(os.path.abspath(target)), exist_ok=True)
    os.nice(max(0, 10 - os.nice(0)))
    every = list(skies())
    lines = -(-len(every) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * WIDE, lines * (HIGH + LABEL)), "white")
    pen, face = ImageDraw.Draw(sheet), font(15)
    with Daemon() as daemon:
        must(daemon.patch({"clock": {"mode": "STEPPED", "time": 100},
                           "entities": [SHIP], "views": [VIEW],
                           "sea": {"windSpeed": 5, "windDirection": 80,
                                   "synthesiser": "FFT"}}))
        for i, (words, sky) in enumerate(every):
            must(daemon.patch({"sky": {"fog": [], "visibility": 40000, **sky}}))
            answer = must(daemon.get("/v1/views/v/frame.png"))
            picture = Image.open(io.BytesIO(answer.body)).convert("RGB")
            x, y = i % COLUMNS * WIDE, i // COLUMNS * (HIGH + LABEL)
            sheet.paste(picture, (x, y))
            pen.text((x + 4, y + HIGH + 2), words, fill="black", font=face)
    sheet.save(target, quality=90)
    print(target)


if __name__ == "__main__":
    main()
