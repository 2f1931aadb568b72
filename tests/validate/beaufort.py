#!/usr/bin/python3
"""The sea of Beaufort 0 to 11 on one sheet: `make beaufort-sheet`.

    beaufort.py [OUT.jpg]

Each as a daemon draws it on the software device from a bridge 12 m above the
water, the wind from 40° left of ahead, with the middle of the force's wind and
the World Meteorological Organization's words for the sea (Manual on Codes,
WMO-No. 306). Prints the EV of each.
"""
import os
import sys

from PIL import Image, ImageDraw

from eyekit import ROOT, eye
from sheet import font

COLUMNS, WIDE, HIGH, LABEL = 3, 960, 540, 44
WORDS = [
    "Sea like a mirror.",
    "Ripples with the appearance of scales, without foam crests.",
    "Small wavelets, still short; crests have a glassy appearance.",
    "Large wavelets; crests begin to break; perhaps scattered white horses.",
    "Small waves, becoming longer; fairly frequent white horses.",
    "Moderate waves; many white horses; chance of some spray.",
    "Large waves; white foam crests more extensive everywhere; some spray.",
    "Sea heaps up; foam begins to be blown in streaks along the wind.",
    "Moderately high waves; foam in well-marked streaks along the wind.",
    "High waves; dense streaks of foam; spray may affect visibility.",
    "Very high waves; the sea takes a white appearance; visibility affected.",
    "Exceptionally high waves; covered with long white patches of foam.",
]
VIEW = {"width": WIDE, "height": HIGH, "up": 12, "pitch": -6, "yaw": 120}
SKY = {"sunElevation": 35, "visibility": 40000}


def main():
    target = sys.argv[1] if len(sys.argv) > 1 else os.path.join(
        ROOT, "build", "beaufort.jpg")
    os.makedirs(os.path.dirname(os.path.abspath(target)), exist_ok=True)
    os.nice(max(0, 10 - os.nice(0)))
    lines = -(-len(WORDS) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * WIDE, lines * (HIGH + LABEL)), "white")
    pen, face = ImageDraw.Draw(sheet), font(15)
    print("| Beaufort | m/s | EV |\n|---|---|---|")
    with eye() as draw:
        for force, words in enumerate(WORDS):
            wind = min(0.836 * force ** 1.5, 30)
            picture, ev = draw(VIEW, sky=SKY, sea={
                "windSpeed": wind, "windDirection": 80, "whitecaps": 1})
            print(f"| {force} | {wind:.1f} | {ev:.2f} |", flush=True)
            x, y = force % COLUMNS * WIDE, force // COLUMNS * (HIGH + LABEL)
            sheet.paste(picture, (x, y))
            pen.text((x + 4, y + HIGH + 2),
                     f"Beaufort {force}, {wind:.1f} m/s\n{words}",
                     fill="black", font=face)
    sheet.save(target, quality=90)
    print(f"\n{target}")


if __name__ == "__main__":
    main()
