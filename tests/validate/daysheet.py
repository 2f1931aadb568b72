#!/usr/bin/python3
"""24 hours of a day on one sheet: `make day-sheet`.

    daysheet.py [--dark] [OUT.jpg]

Each as a daemon draws it on the software device, looking south from 36° N 0° E
on 2026-06-29, a day of full Moon; --dark: on 2026-06-14, at new Moon. Prints
where Sun and Moon are, EV, and the luminance of the zenith.
"""
import io
import os
import sys

from PIL import Image, ImageDraw

from eyekit import ROOT, read_exr
from pelagos_daemon import Daemon
from sheet import font

COLUMNS, WIDE, HIGH, LABEL = 4, 640, 360, 40
VIEW = {"name": "v", "width": WIDE, "height": HIGH, "up": 12, "pitch": 11,
        "yaw": 180, "fieldOfView": 75}


def main():
    dark = "--dark" in sys.argv[1:]
    names = [name for name in sys.argv[1:] if name != "--dark"]
    day = "2026-06-14" if dark else "2026-06-29"
    target = names[0] if names else os.path.join(
        ROOT, "build", "day-dark.jpg" if dark else "day.jpg")
    os.makedirs(os.path.dirname(os.path.abspath(target)), exist_ok=True)
    os.nice(max(0, 10 - os.nice(0)))
    lines = -(-24 // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * WIDE, lines * (HIGH + LABEL)), "white")
    pen, face = ImageDraw.Draw(sheet), font(15)
    print("| UTC | Sun, ° | Moon, ° | EV | zenith, cd/m² |\n|---|---|---|---|---|")
    with Daemon() as daemon:
        for i in range(24):
            hour = (i + 12) % 24
            utc = f"{day[:-2]}{int(day[-2:]) + (i >= 12):02}T{hour:02}:00:00Z"
            answer = daemon.patch({
                "clock": {"mode": "STEPPED", "utc": utc},
                "origin": {"latitude": 36, "longitude": 0},
                "sea": {"windSpeed": 6, "windDirection": 250,
                        "synthesiser": "FFT"}, "views": [VIEW]})
            if answer.status != 200:
                sys.exit(f"{utc}: {answer.status} {answer.body[:300]!r}")
            light = daemon.get("/v1/optics/sky?from=GPU&elevation=90").json()
            picture = Image.open(io.BytesIO(
                daemon.get("/v1/views/v/frame.png").body)).convert("RGB")
            small = daemon.get("/v1/views/v/frame.exr?layers=radiance").body
            ev = float(read_exr(small).attributes.get("pelagos.exposure"))
            moon = light.get("moonElevation")
            x, y = i % COLUMNS * WIDE, i // COLUMNS * (HIGH + LABEL)
            sheet.paste(picture, (x, y))
            zenith = light["sky"]["luminance"]
            print(f"| {hour:02} | {light['sunElevation']:.1f} | {moon:.1f} | "
                  f"{ev:.2f} | {zenith:.3g} |", flush=True)
            pen.text((x + 4, y + HIGH + 2),
                     f"{utc[:16]}Z   Sun {light['sunElevation']:.0f}°, Moon "
                     f"{moon:.0f}° ({light['moonPhase']:.0%})\nEV {ev:.1f}, "
                     f"zenith {zenith:.2g} cd/m²", fill="black", font=face)
    sheet.save(target, quality=88)
    print(f"\n{target}")


if __name__ == "__main__":
    main()
