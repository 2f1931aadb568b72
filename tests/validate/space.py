#!/usr/bin/python3
"""What is seen from high up against a Monte Carlo of air and sea that shares
nothing with the program (spacetrace).

    space.py [--quick] [--assert] [--own-water]

Pictures of the open sea on the equator looking east, where the ellipsoid is a
circle of its larger radius, by sights from the nadir to beyond the limb, into
the glint, beside it and away from the Sun; 1 km to 10,000 km, Sun 10 to 60
degrees high, 7 m/s, 40 km of visibility. The trace is told the picture's slope
variances, and what leaves the water as the air's own light has it from below
(--own-water: what leaves the picture's straight up, by /v1/optics/water).
Judged is the radiance at 680, 550 and 440 nm, where it is above a thousandth of
the brightest and the noise of the trace, and of the few waves that are seen
from 1 km, is below half of the bar: 2 % where the glint is less than a hundredth
of it, 5 % where it is more.

Then rows of four pitches as the eye rises from 1 km to 400 km, an octave at a
time and through every change of form. A row's light changes with the height, by
the air before it and the place that it shows; the trace's does alike. Judged is
by how much what is drawn moves against it from each height to the next, as
luminance: 1 %, and twice the noise of the two traces.

Its tables go into build/validate/ (quick: into its quick/); status 3 with
--assert where the median of a view's offs, or a row, is over its bar.
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
VIEWS = [(1e3, 50, 0), (1e3, 30, 120), (1e4, 50, 0), (1e4, 40, 120),
         (2e4, 50, 0),
         (2e4, 30, 150), (5e4, 50, 0), (5e4, 20, 90), (1e5, 40, 0),
         (4e5, 60, 0), (4e5, 40, 0), (4e5, 30, 120), (4e5, 10, 180),
         (1e7, 60, 0), (1e7, 30, 150)]
# Of the rows: heights, m, and pitches, of which those that meet the sea count.
HEIGHTS = (1e3, 2e3, 4e3, 8e3, 9.99e3, 1e4, 1.4e4, 2e4, 3e4, 6e4, 1.2e5, 2.4e5,
           4e5)
PITCHES = (-90, -60, -35, -22)
ROWS_SUN = (40, 120) # elevation, azimuth from the sight's
# Of 680, 550 and 440 nm in a luminance: of light like the day's within 1 %.
WEIGHTS = np.array([0.285, 0.70, 0.015])
WIND_FROM, WIND = 200.0, 7.0
# Share of the light that falls on it, at chlorophyll 0.2 mg/m3 (Morel and
# Maritorena 2001): what the air's light has from below, too.
TOLD = {"water": "0.0006,0.006,0.02", "own": False}
# A level surface of 1.34 lets 0.979 of light through straight up, of light from
# all sides alike 0.934, by what it brings to a level face.
UPRIGHT = 0.979 / 0.934


def sights(height):
    """Angles from the nadir that are compared."""
    horizon = math.degrees(math.asin(RADIUS_M / (RADIUS_M + height)))
    ground = horizon * np.array([0.15, 0.3, 0.45, 0.6, 0.75, 0.85, 0.92, 0.97])
    if height > 1e6: # a row of the picture is wider than its limb
        return ground
    limb = [math.degrees(math.asin((RADIUS_M + h) / (RADIUS_M + height)))
            for h in (5e3, 15e3, 30e3) if h < height]
    return np.concatenate([ground, limb])


def traced(height, elevation, azimuth, angles, slopes, toward, error,
           wind=WIND):
    lines = "".join(f"{a:.6f} {azimuth:g}\n" for a in angles)
    out = subprocess.run(
        [os.path.join(ROOT, "build", "release", "bin", "spacetrace"),
         "--heights", f"{height:g}", "--sun", f"{90 - elevation:g}",
         "--radius", f"{RADIUS_M / 1e3:g}", "--visibility", "40",
         "--slopes", f"{slopes[0]:g},{slopes[1]:g}", "--toward", f"{toward:g}",
         "--water", TOLD["water"], "--error", f"{error:g}",
         "--ground", "waves", "--wind", f"{wind:g}"],
        input=lines, capture_output=True, text=True, check=True).stdout
    rows = out.splitlines()
    names = rows[0].split(",")
    table = [dict(zip(names, map(float, r.split(",")))) for r in rows[1:]]
    pick = lambda name: np.array(  # noqa: E731
        [t[name] for t in table]).reshape(len(angles), 3)
    return pick("radiance"), pick("error"), pick("glint")


def patches(height):
    """Moments whose waves a picture is the mean of: from low down it shows few."""
    return max(1, min(16, round(3e4 / height)))


def scene(daemon, elevation, azimuth, time=10):
    daemon.patch({
        "clock": {"mode": "STEPPED", "time": time},
        "origin": {"latitude": 0, "longitude": -150},
        "sea": {"windSpeed": WIND, "windDirection": WIND_FROM,
                "spectrum": "ELFOUHAILY", "sparkle": False, "whitecaps": 0},
        "sky": {"sunElevation": elevation, "sunAzimuth": 90 + azimuth,
                "visibility": 40000}})
    if TOLD["own"]:
        rrs = daemon.get("/v1/optics/water").json()["water"][
            "remoteSensingReflectance"]
        TOLD["water"] = ",".join(f"{math.pi * r / UPRIGHT:.5g}" for r in rrs)


def view(daemon, **fields):
    answer = daemon.patch({"views": [dict(fields, name="v")]})
    if answer.status != 200:
        sys.exit(f"space: {answer.status} {answer.body[:300]!r}")


def row_of(ocean, daemon, height, pitch, time):
    """Mean radiance of a few rows, of waves' as many as count."""
    scene(daemon, ROWS_SUN[0], ROWS_SUN[1], time)
    view(daemon, width=64, height=16, up=height, yaw=90, pitch=pitch,
         fieldOfView=6)
    picture = ocean.frame("v", "exr", layers=("radiance",),
                          float_samples=True).exr()
    return np.asarray(picture["radiance"], float)[6:10].reshape(-1, 3).mean(0)


def rows_rise(ocean, daemon, slopes, quick):
    """Rows of the table: by pitch, what is drawn over what is traced."""
    lines = ["| pitch | heights | moves at most, luminance | at | noise | |",
             "|" + "---|" * 6]
    rows, failed = [], 0
    error = 0.004 if quick else 0.002
    for pitch in PITCHES:
        heights = [h for h in HEIGHTS[::2 if quick else 1]
                   if 90 + pitch < 0.97 * math.degrees(
                       math.asin(RADIUS_M / (RADIUS_M + h)))]
        share, noise, light = [], [], []
        for height in heights:
            times = 1 if quick else patches(height)
            ours = np.mean([row_of(ocean, daemon, height, pitch, 10 + 37 * i)
                            for i in range(times)], 0) @ WEIGHTS
            toward = (90 + ROWS_SUN[1]) - (WIND_FROM + 180)
            theirs, off, _ = traced(height, *ROWS_SUN, np.array([90.0 + pitch]),
                                    slopes, toward, error)
            share.append(ours / (theirs[0] @ WEIGHTS))
            light.append((ours, theirs[0] @ WEIGHTS))
            noise.append(math.sqrt(((off[0] * WEIGHTS) ** 2).sum()) /
                         (theirs[0] @ WEIGHTS))
        moves = [b / a - 1 for a, b in zip(share, share[1:])]
        blurs = [math.hypot(a, b) for a, b in zip(noise, noise[1:])]
        worst = max(range(len(moves)), key=lambda i: abs(moves[i]))
        good = all(abs(m) <= 0.01 + 2 * n for m, n in zip(moves, blurs))
        failed += not good
        rows.append({"pitch": pitch, "heights": heights, "share": share,
                     "noise": noise, "pass": good})
        lines.append(f"| {pitch}° | {heights[0] / 1e3:g} to "
                     f"{heights[-1] / 1e3:g} km | {100 * moves[worst]:+.2f} % | "
                     f"{heights[worst] / 1e3:g} to "
                     f"{heights[worst + 1] / 1e3:g} km | "
                     f"{100 * max(noise):.2f} % | "
                     f"{'pass' if good else 'FAIL'} |")
        print(lines[-1], flush=True)
        print("    drawn over traced: " + ", ".join(
            f"{h / 1e3:g} km {100 * s - 100:+.2f} %"
            for h, s in zip(heights, share)), flush=True)
        print("    from each to the next, drawn (traced: the air's): " +
              ", ".join(f"{100 * b[0] / a[0] - 100:+.1f} % "
                        f"({100 * b[1] / a[1] - 100:+.1f})"
                        for a, b in zip(light, light[1:])), flush=True)
    return lines, rows, failed


def drawn(ocean, daemon, height, angles):
    """Radiance at these angles, by a picture, and its noise of few waves."""
    middle = 0.5 * (angles.min() + angles.max())
    field = min(max(1.15 * (angles.max() - angles.min()), 2.0), 120.0)
    width = 2 * math.degrees(math.atan(
        math.tan(math.radians(field / 2)) * WIDE / HIGH))
    view(daemon, width=WIDE, height=HIGH, up=height, yaw=90,
         pitch=middle - 90, fieldOfView=width)
    columns = []
    for i in range(patches(height)):
        daemon.patch({"clock": {"time": 10 + 37 * i}})
        picture = ocean.frame("v", "exr", layers=("radiance", "slopeVariance"),
                              float_samples=True).exr()
        light = np.asarray(picture["radiance"], float)
        columns.append(light.mean(axis=1))
    column = np.mean(columns, 0)
    blur = np.std(columns, 0) / math.sqrt(max(len(columns) - 1, 1))
    place = 0.5 * HIGH * (1 - np.tan(np.radians(angles - middle)) /
                          math.tan(math.radians(field / 2))) - 0.5
    rows = np.arange(HIGH)
    got, noise = (np.stack([np.interp(place, rows, of[:, k])
                            for k in range(3)], 1) for of in (column, blur))
    slopes = np.asarray(picture["slopeVariance"], float).reshape(-1, 2).max(0)
    return got, noise, slopes


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--assert", dest="check", action="store_true")
    parser.add_argument("--own-water", action="store_true")
    options = parser.parse_args()
    TOLD["own"] = options.own_water
    os.nice(max(0, 10 - os.nice(0)))
    lines = ["| from | Sun | azimuth | sights | beside the glint, median, 90 in "
             "100 | in it | |", "|" + "---|" * 7]
    print("\n".join(lines))
    rows, failed = [], 0
    with Daemon() as daemon:
        ocean = pelagos.Ocean(daemon.url(), timeout=600)
        for height, elevation, azimuth in VIEWS[::3 if options.quick else 1]:
            scene(daemon, elevation, azimuth)
            angles = sights(height)
            ours, few, slopes = drawn(ocean, daemon, height, angles)
            # The wind's axis from the Sun's azimuth, anticlockwise.
            toward = (90 + azimuth) - (WIND_FROM + 180)
            theirs, error, glint = traced(height, elevation, azimuth, angles,
                                          slopes, toward,
                                          0.01 if options.quick else 0.005)
            theirs = np.maximum(theirs, 1e-30)
            bar = np.where(glint > 0.01 * theirs, 0.05, 0.02)
            off = np.abs(ours / theirs - 1)
            error = np.hypot(error, few)
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
        scene(daemon, *ROWS_SUN)
        _, _, slopes = drawn(ocean, daemon, HEIGHTS[-1], np.array([10.0, 40.0]))
        more, risen, fell = rows_rise(ocean, daemon, slopes, options.quick)
        lines += [""] + more
        failed += fell
    folder = os.path.join(ROOT, "build", "validate",
                          "quick" if options.quick else "")
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "space.md"), "w", encoding="utf-8") as f:
        f.write("\n".join(lines) + "\n")
    with open(os.path.join(folder, "space.json"), "w", encoding="utf-8") as f:
        json.dump({"rows": rows, "rise": risen}, f)
    print(f"\n{failed} of {len(rows) + len(risen)} rows fail")
    return 3 if options.check and failed else 0


if __name__ == "__main__":
    sys.exit(main())
