#!/usr/bin/python3
"""The drawn surface against the queried one.

    drawn.py [--quick] [--assert]

For seas and heights of the eye, the height is asked for (`POST /v1/surface`) at
the places that pixels of water show (EXR layer `position`). Judged is
every pixel in which the sea's dominant wave is eight pixels long or longer, as
it lies in the picture: along the line of sight at its grazing angle. A pixel
of the picture is its height on a wall across the line of sight. Bars: median
1 mm + 0.05 pixel, 99 in 100 within 1 pixel. Its table and .json go into
build/validate/ (quick: into its quick/); status 3 with --assert where a row
fails.
"""
import argparse
import json
import math
import os
import sys

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(
    os.path.abspath(__file__))))
sys.path[:0] = [os.path.join(ROOT, "tests"),
                os.path.join(ROOT, "clients", "python")]
import pelagos  # noqa: E402
from pelagos_daemon import Daemon  # noqa: E402

EARTH_M, G = 6.36e6, 9.81
WIDE, HIGH, FIELD = 1024, 576, 50
# Name: state, length of the dominant wave. Pierson and Moskowitz have their
# peak at 0.877 g / V, V the wind at 19.5 m.
SEAS = {"swell 3 m, 12 s": ({"windSpeed": 0, "swell": [
    {"height": 3, "period": 12, "direction": 0, "spread": 5}]},
    G * 144 / (2 * math.pi))}
for _wind in (5, 10, 15, 20):
    SEAS[f"PM {_wind} m/s"] = (
        {"windSpeed": _wind, "swell": [],
         "spectrum": "PIERSON_MOSKOWITZ"},
        2 * math.pi * (1.0625 * _wind / 0.877) ** 2 / G)
EYES = (2, 6, 15, 40, 100)


def far_points(daemon, ocean, eye):
    """Points of the water in the picture and their slant distances."""
    daemon.patch({"views": [{
        "name": "v", "width": WIDE, "height": HIGH, "up": eye,
        "pitch": -FIELD * HIGH / WIDE / 2 * 0.8, "fieldOfView": FIELD}]})
    picture = ocean.frame("v", "exr", layers=("depth", "position"),
                          float_samples=True, time=10.0).exr()
    depth = np.asarray(picture["depth"]).reshape(-1)
    points = np.asarray(picture["position"], dtype=float).reshape(-1, 3)
    water = np.isfinite(depth) & (depth < 1e5)
    return points[water], depth[water]


def queried(daemon, points):
    heights = []
    for part in np.array_split(points, max(1, len(points) // 1000)):
        body = {"points": [{"east": float(e), "north": float(n)}
                           for e, n in part], "time": 10.0}
        answer = daemon.request("POST", "/v1/surface", body)
        if answer.status != 200:
            sys.exit(f"drawn: {answer.status} {answer.body[:200]!r}")
        heights += [p.get("height", 0) for p in answer.json()["points"]]
    return np.array(heights)


def measure(daemon, ocean, eye, wave_m, most):
    points, depth = far_points(daemon, ocean, eye)
    pixel = depth * 2 * math.tan(math.radians(FIELD / 2)) / WIDE
    # The eye above the curved sea; the angle at which the sight meets it.
    grazing = np.maximum(eye / depth - depth / (2 * EARTH_M), 1e-6)
    judged = np.flatnonzero(wave_m * np.minimum(grazing, 1) >= 8 * pixel)
    if len(judged) > most:
        judged = np.random.default_rng(1).choice(judged, most, replace=False)
    error = np.abs(points[judged, 2] - queried(daemon, points[judged, :2]))
    over = (error - 1e-3) / pixel[judged]
    return {"pixels": len(judged), "median_mm": 1e3 * float(np.median(error)),
            "worst_m": float(error.max()),
            "median_px": float(np.median(over)),
            "p99_px": float(np.percentile(error / pixel[judged], 99)),
            "farthest": float(depth[judged].max())}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--assert", dest="check", action="store_true")
    options = parser.parse_args()
    os.nice(max(0, 10 - os.nice(0)))
    lines = ["| synthesiser | sea | eye | pixels | to | median | over 1 mm, "
             "pixels | 99 in 100, pixels | worst | |", "|" + "---|" * 10]
    print("\n".join(lines))
    rows = []
    eyes = EYES[1::2] if options.quick else EYES
    with Daemon() as daemon:
        ocean = pelagos.Ocean(daemon.url(), timeout=600)
        for synthesiser in ("TROCHOIDS", "FFT"):
            for name, (sea, wave_m) in list(SEAS.items())[
                    ::2 if options.quick else 1]:
                daemon.patch({"clock": {"mode": "STEPPED", "time": 10},
                              "sea": {**sea, "synthesiser": synthesiser,
                                      "windDirection": 20, "seed": 3}})
                for eye in eyes:
                    row = {"synthesiser": synthesiser, "sea": name, "eye": eye,
                           **measure(daemon, ocean, eye, wave_m,
                                     2000 if options.quick else 20000)}
                    row["pass"] = (row["median_px"] <= 0.05
                                   and row["p99_px"] <= 1)
                    rows.append(row)
                    lines.append(
                        f"| {synthesiser} | {name} | {eye} m | {row['pixels']}"
                        f" | {row['farthest']:.0f} m"
                        f" | {row['median_mm']:.1f} mm | "
                        f"{row['median_px']:.3f} | {row['p99_px']:.2f} | "
                        f"{row['worst_m']:.2f} m | "
                        f"{'pass' if row['pass'] else 'FAIL'} |")
                    print(lines[-1], flush=True)
    folder = os.path.join(ROOT, "build", "validate",
                          "quick" if options.quick else "")
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "drawn.md"), "w", encoding="utf-8") as f:
        f.write("\n".join(lines) + "\n")
    with open(os.path.join(folder, "drawn.json"), "w", encoding="utf-8") as f:
        json.dump({"rows": rows}, f)
    failed = sum(not row["pass"] for row in rows)
    print(f"\n{failed} of {len(rows)} rows fail")
    return 3 if options.check and failed else 0


if __name__ == "__main__":
    sys.exit(main())
