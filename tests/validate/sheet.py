#!/usr/bin/python3
"""24 scenes on one sheet, with figures: `make sheet`.

    sheet.py [OUT.jpg]

Draws Suns, winds, heights, hazes and waters by a daemon of its own on the
software device, lays them out with their names (build/sheet.jpg), and prints
of each the share of pixels at 250 or above (in one channel, in all), its mean
and its EV.
"""
import os
import subprocess
import sys
import tempfile

from PIL import Image, ImageDraw, ImageFont

from eyekit import ROOT, eye, figures

AHEAD, ABEAM, AWAY = 0, 90, 180
COLUMNS, WIDE, HIGH, LABEL = 4, 480, 270, 22


def scene(name, sun=35, look=AHEAD, wind=8, up=6, pitch=-2, visibility=40000,
          sea=None, water=None, seabed=None, **view):
    return {"name": name, "view": {"up": up, "pitch": pitch, "yaw": look,
                                   **view},
            "state": {"sky": {"sunElevation": sun, "visibility": visibility},
                      "sea": {"windSpeed": wind, **(sea or {})},
                      "water": water or {},
                      **({"seabed": seabed} if seabed else {})}}


SWELL = {"swell": [{"height": 3, "period": 12, "direction": 340,
                    "spread": 10}]}
SCENES = [
    scene("Sun 2°, ahead, 8 m/s", sun=2),
    scene("Sun 5°, ahead, 8 m/s", sun=5),
    scene("Sun 8°, ahead, 8 m/s", sun=8),
    scene("Sun 20°, ahead, 8 m/s", sun=20),
    scene("Sun 60°, ahead, 8 m/s", sun=60, pitch=-15),
    scene("Sun 20°, abeam, 8 m/s", sun=20, look=ABEAM),
    scene("Sun 20°, behind, 8 m/s", sun=20, look=AWAY),
    scene("Sun 60°, behind, 8 m/s", sun=60, look=AWAY),
    scene("2 m/s, Sun 8°, ahead", sun=8, wind=2),
    scene("15 m/s, Sun 35°, abeam, 15 m", wind=15, look=ABEAM, up=15),
    scene("20 m/s, Sun 20°, behind, 15 m", wind=20, sun=20, look=AWAY, up=15),
    scene("trochoids, 10 m/s, Sun 35°", wind=10,
          sea={"synthesiser": "TROCHOIDS"}),
    scene("2 m high, Sun 35°, abeam", up=2, look=ABEAM),
    scene("100 m, Sun 20°, ahead", sun=20, up=100, pitch=-10),
    scene("1,000 m, Sun 35°, ahead", up=1000, pitch=-20),
    scene("8,000 m, Sun 35°, abeam", up=8000, pitch=-25, look=ABEAM),
    scene("haze 5 km, Sun 20°, ahead", sun=20, visibility=5000),
    scene("clear 200 km, Sun 35°, behind", visibility=200000, look=AWAY),
    scene("dusk, Sun −3°, ahead", sun=-3),
    scene("late dusk, Sun −8°, ahead", sun=-8),
    scene("night, Sun −25°", sun=-25),
    scene("swell 3 m, 12 s, 3 m/s, 15 m", sea=SWELL, wind=3, sun=20, up=15,
          look=ABEAM),
    scene("shore from 8 m", sun=50, wind=4, look=50, pitch=-4, up=8,
          seabed={"file": "shore.asc"},
          water={"named": "TROPICAL", "bottom": "SAND"}),
    scene("Baltic water, from 30 m, down", sun=50, up=30, pitch=-40, look=AWAY,
          water={"named": "BALTIC"}),
]


def font(size):
    for path in ("/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",):
        if os.path.exists(path):
            return ImageFont.truetype(path, size)
    return ImageFont.load_default()


def main():
    target = sys.argv[1] if len(sys.argv) > 1 else os.path.join(
        ROOT, "build", "sheet.jpg")
    os.makedirs(os.path.dirname(os.path.abspath(target)), exist_ok=True)
    os.nice(max(0, 10 - os.nice(0)))
    lines = -(-len(SCENES) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * WIDE, lines * (HIGH + LABEL)), "white")
    pen, face = ImageDraw.Draw(sheet), font(13)
    print("| scene | at 250 or above | white | mean | EV |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["/usr/bin/python3", os.path.join(
            ROOT, "docs", "gallery", "shore.py"),
            os.path.join(folder, "shore.asc"), "7.9"], check=True)
        with eye("--bathymetry", folder) as draw:
            for i, each in enumerate(SCENES):
                picture, ev = draw({"width": WIDE, "height": HIGH,
                                    **each["view"]}, **each["state"])
                f = figures(picture)
                words = (f"{each['name']}: EV {ev:.1f}, "
                         f"≥250 {f['bright']:.1%}")
                print(f"| {each['name']} | {f['bright']:.1%} | "
                      f"{f['white']:.1%} | {f['mean']:.0f} | {ev:.1f} |",
                      flush=True)
                x, y = i % COLUMNS * WIDE, i // COLUMNS * (HIGH + LABEL)
                sheet.paste(picture, (x, y))
                pen.text((x + 4, y + HIGH + 3), words, fill="black", font=face)
    sheet.save(target, quality=90)
    print(f"\n{target}")


if __name__ == "__main__":
    main()
