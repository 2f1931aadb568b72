#!/usr/bin/python3
"""What is seen from high up against a Monte Carlo of air and sea that shares
nothing with the program (spacetrace).

    space.py [--quick] [--assert]

Pictures of the open sea on the equator looking east, where the ellipsoid is a
circle of its larger radius, by sights from the nadir to beyond the limb, into
the glint, beside it and away from the Sun; 10 km to 10,000 km, Sun 10 to 60
degrees high, 7 m/s, 40 km of visibility. The trace is told the picture's slope
variances, and what leaves the water as the air's own light has it from below.
Judged is the radiance at 680, 550 and 440 nm, where it is above a thousandth of
the brightest and the trace's own noise is below half of the bar: 2 % where the
glint is less than a hundredth of it, 5 % where it is more. Its table goes into
build/validate/ (quick: into its quick/); status 3 with --assert where the median
of a view's offs is over its bar.
"""
import argparse
import json
import math
import os
import subprocess
import sys

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(
    os.path.abspath(__file__))))
sys.path[:0] = [os.path.join(ROOT, "tests"),
                os.path.join(ROOT, "clients", "python")]
import pelagos  # noqa: E402
from pelagos_daemon import Daemon  # noqa: E402

RADIUS_M = 6378137.0
HIGH, WIDE = 360, 32
# Height, Sun's elevation, its azimuth from the sight's.
VIEWS = [(1e4, 50, 0), (1e4, 40, 120), (2e4, 50, 0),
         (2e4, 30, 150), (5e4, 50, 0), (5e4, 20, 90), (1e5, 40, 0),
         (4e5, 60, 0), (4e5, 40, 0), (4e5, 30, 120), (4e5, 10, 180),
         (1e7, 60, 0), (1e7, 30, 150)]
WIND_FROM, WIND = 200.0, 7.0
# Share of the light that falls on it, at chlorophyll 0.2 mg/m3 (Morel and
# Maritorena 2001): what the air's light has from below, too.
WATER = "0.0006,0.006,0.02"


def sights(height):
    """Angles from the nadir that are compared."""
    horizon = math.degrees(math.asin(RADIUS_M / (RADIUS_M + height)))
    ground = horizon * np.array([0.15, 0.3, 0.45, 0.6, 0.75, 0.85, 0.92, 0.97])
    if height > 1e6: # a row of the picture is wider than its limb
        return ground
    limb = [math.degrees(math.asin((RADIUS_M + h) / (RADIUS_M + height)))
            for h in (5e3, 15e3, 30e3) if h < height]
    return np.concatenate([ground, limb])


def traced(height, elevation, azimuth, angles, slopes, toward, error):
    lines = "".join(f"{a:.6f} {azimuth:g}\n" for a in angles)
    out = subprocess.run(
        [os.path.join(ROOT, "build", "release", "bin", "spacetrace"),
         "--heights", f"{height:g}", "--sun", f"{90 - elevation:g}",
         "--radius", f"{RADIUS_M / 1e3:g}", "--visibility", "40",
         "--slopes", f"{slopes[0]:g},{slopes[1]:g}", "--toward", f"{toward:g}",
         "--water", WATER, "--error", f"{error:g}"],
        input=lines, capture_output=True, text=True, check=True).stdout
    rows = out.splitlines()
    names = rows[0].split(",")
    table = [dict(zip(names, map(float, r.split(",")))) for r in rows[1:]]
    pick = lambda name: np.array(  # noqa: E731
        [t[name] for t in table]).reshape(len(angles), 3)
    return pick("radiance"), pick("error"), pick("glint")


def drawn(ocean, daemon, height, angles):
    """Radiance at these angles, by a picture."""
    middle = 0.5 * (angles.min() + angles.max())
    field = min(max(1.15 * (angles.max() - angles.min()), 2.0), 120.0)
    width = 2 * math.degrees(math.atan(
        math.tan(math.radians(field / 2)) * WIDE / HIGH))
    answer = daemon.patch({"views": [{
        "name": "v", "width": WIDE, "height": HIGH, "up": height, "yaw": 90,
        "pitch": middle - 90, "fieldOfView": width}]})
    if answer.status != 200:
        sys.exit(f"space: {answer.status} {answer.body[:300]!r}")
    picture = ocean.frame("v", "exr", layers=("radiance", "slopeVariance"),
                          float_samples=True).exr()
    light = np.asarray(picture["radiance"], float)
    column = light.mean(axis=1)
    place = 0.5 * HIGH * (1 - np.tan(np.radians(angles - middle)) /
                          math.tan(math.radians(field / 2))) - 0.5
    rows = np.arange(HIGH)
    got = np.stack([np.interp(place, rows, column[:, k]) for k in range(3)], 1)
    slopes = np.asarray(picture["slopeVariance"], float).reshape(-1, 2).max(0)
    return got, slopes


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--assert", dest="check", action="store_true")
    options = parser.parse_args()
    os.nice(max(0, 10 - os.nice(0)))
    lines = ["| from | Sun | azimuth | sights | beside the glint, median, 90 in "
             "100 | in it | |", "|" + "---|" * 7]
    print("\n".join(lines))
    rows, failed = [], 0
    with Daemon() as daemon:
        ocean = pelagos.Ocean(daemon.url(), timeout=600)
        for height, elevation, azimuth in VIEWS[::3 if options.quick else 1]:
            daemon.patch({
                "clock": {"mode": "STEPPED", "time": 10},
                "origin": {"latitude": 0, "longitude": -150},
                "sea": {"windSpeed": WIND, "windDirection": WIND_FROM,
                        "spectrum": "ELFOUHAILY", "sparkle": False,
                        "whitecaps": 0},
                "sky": {"sunElevation": elevation, "sunAzimuth": 90 + azimuth,
                        "visibility": 40000}})
            angles = sights(height)
            ours, slopes = drawn(ocean, daemon, height, angles)
            # The wind's axis from the Sun's azimuth, anticlockwise.
            toward = (90 + azimuth) - (WIND_FROM + 180)
            theirs, error, glint = traced(height, elevation, azimuth, angles,
                                          slopes, toward,
                                          0.01 if options.quick else 0.005)
            theirs = np.maximum(theirs, 1e-30)
            bar = np.where(glint > 0.01 * theirs, 0.05, 0.02)
            off = np.abs(ours / theirs - 1)
            sure = (error / theirs < 0.5 * bar) & (theirs > 1e-3 *
                                                   theirs.max())
            row = {"height": height, "sun": elevation, "azimuth": azimuth,
                   "angles": angles.tolist(),
                   "off": (ours / theirs - 1).tolist(),
                   "glint": (glint / theirs).tolist()}
            words = []
            good = True
            for name, kind in (("beside", 0.02), ("in", 0.05)):
                these = off[sure & (bar == kind)]
                row[name] = float(np.median(these)) if len(these) else None
                words.append("–" if not len(these) else
                             f"{100 * np.median(these):.1f}, "
                             f"{100 * np.percentile(these, 90):.1f} %")
                good &= not len(these) or np.median(these) <= kind
            failed += not good
            row["pass"] = bool(good)
            rows.append(row)
            lines.append(f"| {height / 1e3:g} km | {elevation}° | {azimuth}° | "
                         f"{int(sure.sum())} | {words[0]} | {words[1]} | "
                         f"{'pass' if good else 'FAIL'} |")
            print(lines[-1], flush=True)
    folder = os.path.join(ROOT, "build", "validate",
                          "quick" if options.quick else "")
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "space.md"), "w", encoding="utf-8") as f:
        f.write("\n".join(lines) + "\n")
    with open(os.path.join(folder, "space.json"), "w", encoding="utf-8") as f:
        json.dump({"rows": rows}, f)
    print(f"\n{failed} of {len(rows)} rows fail")
    return 3 if options.check and failed else 0


if __name__ == "__main__":
    sys.exit(main())
