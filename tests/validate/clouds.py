#!/usr/bin/python3
"""Light below clouds against photons: `make validate-clouds`.

    clouds.py [--quick] [--assert]

What comes through an overcast: the level irradiance and the radiance by zenith
angle of pictures of the sky, mean over seeds and azimuths, against photons
through level slabs (cloudtrace.c) of the depths that the clouds' columns have,
each by itself: columns are much wider than thick. The light that falls on the
clouds is the clear sky's at their tops, and the Sun's, asked of the daemon;
what the program knows of clouds is not used but for the shape of its columns:
x (2 - x) of their thickness at rank u, x = (u + 0.15 rise) / rise, and soft
tops (docs/physics/clouds.md). --quick: stratus alone; --assert: status 3 where
the irradiance is off by more than BAR.
"""
import argparse
import math
import os
import subprocess
import sys

import numpy as np

from eyekit import ROOT, read_exr
from pelagos_daemon import Daemon

BIN = os.environ.get("PELAGOS_BIN", os.path.join(ROOT, "build/release/bin"))
ZENITHS = (0, 15, 30, 45, 60, 70, 80)       # of cloudtrace's, those compared
SIDE = 32                                   # pixels of a face of the half cube
FACES = [(90, 0)] + [(0, azimuth) for azimuth in (0, 90, 180, 270)]
# base, thickness, extinction, rise, softness of clouds.def
GENERA = {"STRATUS": (350, 400, 0.035, 0.5, 120),
          "STRATOCUMULUS": (1200, 380, 0.030, 0.55, 70),
          "ALTOSTRATUS": (3500, 1500, 0.006, 0.5, 400)}
# Half of what is left is Eddington's (docs/validation.md).
BAR = 0.15
GREEN = 1                                   # 550 nm


class Sky:
    def __init__(self, daemon):
        self.daemon = daemon
        self.patch(clock={"mode": "STEPPED", "time": 10},
                   sea={"windSpeed": 4, "synthesiser": "FFT"},
                   views=[{"name": f"f{i}", "width": SIDE, "height": SIDE,
                           "fieldOfView": 90, "up": 2, "pitch": pitch,
                           "yaw": yaw} for i, (pitch, yaw) in enumerate(FACES)])
        axis = (np.arange(SIDE) + 0.5) / SIDE * 2 - 1
        x, y = np.meshgrid(axis, -axis)
        weight = (1 + x * x + y * y) ** -1.5 * (2 / SIDE) ** 2
        self.weight = np.stack([weight] * len(FACES))
        up = np.stack([np.ones_like(x)] + [y] * 4)
        self.cosine = up / np.sqrt(1 + x * x + y * y)
        self.zenith = np.degrees(np.arccos(np.clip(self.cosine, -1, 1)))

    def patch(self, **changes):
        answer = self.daemon.patch(changes)
        if answer.status != 200:
            sys.exit(f"clouds: {answer.status} {answer.body[:300]!r}")

    def faces(self):
        """Radiance at 550 nm of all pixels of the half cube."""
        out = []
        for i in range(len(FACES)):
            body = self.daemon.get(
                f"/v1/views/f{i}/frame.exr?layers=radiance").body
            # The Sun's disc and what is about it are counted apart.
            out.append(np.asarray(read_exr(body).layers["radiance"])[..., GREEN])
        return np.stack(out)

    def level(self, radiance):
        above = self.cosine > 0
        return float((radiance * self.cosine * self.weight)[above].sum())

    def by_zenith(self, radiance):
        return [float(radiance[abs(self.zenith - z) < 4].mean())
                for z in ZENITHS]

    def light(self, height):
        """Of the Sun across its beam, and of the clear sky on the level."""
        def ask(elevation, azimuth):
            return self.daemon.get(
                f"/v1/optics/sky?from=GPU&height={height:g}&elevation="
                f"{elevation:.6g}&azimuth={azimuth:g}").json()["sky"]
        nodes, weights = np.polynomial.legendre.leggauss(6)
        sky = 0.0
        for x, weight in zip(0.5 + 0.5 * nodes, 0.5 * weights):
            for k in range(8):
                sky += weight * math.pi / 8 * ask(
                    math.degrees(math.asin(math.sqrt(x))),
                    45 * k + 22.5)["radiance"][GREEN]
        return ask(45, 0)["sunIrradiance"][GREEN], sky


def depth_of(genus, u):
    _, thickness, extinction, rise, soft = GENERA[genus]
    x = min((u + 0.15 * rise) / rise, 1)
    thick = x * (2 - x) * thickness
    soft = min(soft, 0.5 * thickness)
    inside = (thick - 0.245 * soft if thick > 0.7 * soft else
              thick * thick / (2 * soft) + 0.3 * thick)
    return extinction * inside


def photons(cases, each):
    text = "".join(f"{depth:.4f} {degrees:.4f}\n" for depth, degrees in cases)
    out = subprocess.run([os.path.join(BIN, "cloudtrace"), "--cases",
                          "--photons", str(each)], input=text, text=True,
                         check=True, capture_output=True).stdout
    return [[float(v) for v in line.split()] for line in out.splitlines()]


def overcast(sky, genus, sun, seeds, ranks, each, write):
    base, thickness = GENERA[genus][:2]
    sky.patch(sky={"sunElevation": sun, "sunAzimuth": 40, "visibility": 300000,
                   "cloudCover": 0})
    direct, clear = sky.light(base + thickness)
    direct *= math.sin(math.radians(sun))
    faces = []
    for seed in range(seeds):
        sky.patch(sky={"cloudCover": 8, "cloudGenus": genus,
                       "cloudSeed": 100 + seed})
        faces.append(sky.faces())
    mean = np.mean(faces, 0)
    ours = [sky.level(mean), *sky.by_zenith(mean)]
    spread = np.std([sky.level(f) for f in faces]) / math.sqrt(seeds)
    depths = [depth_of(genus, (i + 0.5) / ranks) for i in range(ranks)]
    found = photons([(d, sun) for d in depths] + [(d, 0) for d in depths], each)
    theirs = np.zeros(1 + len(ZENITHS))
    noise = 0.0
    for part, row in zip([direct] * ranks + [clear] * ranks, found):
        theirs += part / ranks * np.array([row[0] + row[1],
                                           *row[3:3 + len(ZENITHS)]])
        noise += (part / ranks * row[2]) ** 2
    ratio = np.array(ours) / theirs
    error = math.hypot(spread / ours[0], math.sqrt(noise) / theirs[0])
    write(f"| {genus.lower()}, depth {np.mean(depths):.1f} | {sun} | "
          f"{direct:.3f}, {clear:.3f} | {ours[0]:.4f} | {theirs[0]:.4f} | "
          f"{100 * (ratio[0] - 1):+.1f} ± {100 * error:.1f} % | "
          + ", ".join(f"{100 * (r - 1):+.0f}" for r in ratio[1:]) + " |")
    return ratio[0] - 1


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--assert", action="store_true", dest="check")
    options = parser.parse_args()
    seeds, ranks, each = (2, 6, 3000) if options.quick else (12, 10, 10000)

    def write(line):
        print(line, flush=True)

    with Daemon() as daemon:
        sky = Sky(daemon)
        write("| overcast | Sun, ° | falls, level: Sun, sky | ours | photons | "
              "off | radiance at " + ", ".join(f"{z}" for z in ZENITHS)
              + "° of zenith, % off |\n|---|---|---|---|---|---|---|")
        worst = 0.0
        for genus in ("STRATUS",) if options.quick else GENERA:
            for sun in (15, 30, 60):
                off = overcast(sky, genus, sun, seeds, ranks, each, write)
                worst = max(worst, abs(off))
        write(f"\nlevel irradiance below an overcast: {100 * worst:.1f} % off "
              "at worst")
    return 3 if options.check and worst > BAR else 0


if __name__ == "__main__":
    sys.exit(main())
