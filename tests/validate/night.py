#!/usr/bin/python3
"""Light of twilight, Moon and night against published values: `make
validate-night`.

    night.py [--quick] [--assert]

Twilight: radiance of the zenith at 550 nm with the Sun 5 to 15 degrees under the
horizon, from 2635 m in clear air, against the fits of Patat, Ugolnikov and
Postylyakov 2006 (A&A 455, 385, table 1) to 2,000 images in V at Paranal, as it
is and with the night of Paranal in the place of ours; and the light on the level sea with that of the American Meteorological Society's glossary
(at sunset, -6, -12, -18
degrees). Moonlight on the level sea by phase and
altitude against Krisciunas and Schaefer 1991 (PASP 103, 1033): their eq. 9 and
20 through air of Rozenberg's mass, extinction of molecules 0.097, ozone 0.03,
aerosols 0.10, and the integral over the sky of their eq. 15 and 21. Night: a
moonless zenith away from Milky Way and ecliptic. Everything is asked of a daemon
by `/v1/optics/sky`; nothing of the program is used. Writes night.json into
build/validate/ (quick: into its quick/); status 3 with --assert where a bar is
missed.
"""
import argparse
import json
import math
import os
import sys

import numpy as np

from eyekit import ROOT
from pelagos_daemon import Daemon

V_ZERO = 3.63e-11       # W m-2 nm-1 at 550 nm for magnitude 0 (Bessell 1998)
V_LUX = 2.54e-6         # lx for magnitude 0 (Allen)
ARCSECOND = (math.pi / 180 / 3600) ** 2
PATAT_V = (11.84, 1.518, -0.057)
# Their site's dark zenith in V, at sunspot maximum (Patat 2003, A&A 400, 1183):
# their twilight ends in it, ours in a night of its own.
PATAT_NIGHT = 21.61
# Of its centre, unrefracted; at sunset the upper limb is at the horizon.
GLOSSARY = ((-0.83, 410.0, 585.0), (-6.0, 2.0, 3.5), (-12.0, 0.008, 0.008),
            (-18.0, 6e-4, 6e-4))
EXTINCTION = 1.0857 * (0.097 + 0.03 + 0.10)
NL = 1e-5 / math.pi     # nanolamberts in cd/m2 are 1e-9 * 1e4 / pi


class Sky:
    def __init__(self, daemon):
        self.daemon = daemon
        self.patch(clock={"mode": "STEPPED", "utc": "2026-04-15T00:00:00Z"},
                   origin={"latitude": 50, "longitude": 0},
                   sea={"windSpeed": 5})

    def patch(self, **changes):
        answer = self.daemon.patch(changes)
        if answer.status != 200:
            sys.exit(f"night: {answer.status} {answer.body[:300]!r}")

    def ask(self, elevation=90.0, azimuth=0.0, height=2.0):
        answer = self.daemon.get(
            f"/v1/optics/sky?from=GPU&height={height:g}&elevation="
            f"{elevation:.6g}&azimuth={azimuth % 360:.6g}")
        if answer.status != 200:
            sys.exit(f"night: {answer.status} {answer.body[:300]!r}")
        return answer.json()["sky"]

    def level(self, value, azimuths=8):
        """Of the sky on the level plane, by Gauss's nodes in the sine squared
        of the elevation, symmetric about azimuth 180."""
        nodes, weights = np.polynomial.legendre.leggauss(7)
        total = 0.0
        for x, weight in zip(0.5 + 0.5 * nodes, 0.5 * weights):
            for k in range(azimuths):
                azimuth = 180 + 180 * (k + 0.5) / azimuths
                total += (weight * math.pi / azimuths * value(self.ask(
                    math.degrees(math.asin(math.sqrt(x))), azimuth)))
        return total


def magnitude(radiance):
    return -2.5 * math.log10(radiance * ARCSECOND / V_ZERO)


def twilight_rows(sky, options):
    rows = []
    print("| Sun, ° | Patat, mag/arcsec² | ours | ours over theirs | with their "
          "night |\n|---|---|---|---|---|")
    sky.patch(sky={"visibility": 300000, "sunAzimuth": 180, "stars": True,
                   "sunElevation": -40})
    night = sky.ask(height=2635)["radiance"][1]
    their_night = V_ZERO * 10 ** (-0.4 * PATAT_NIGHT) / ARCSECOND
    for depth in range(5, 16, 5 if options.quick else 1):
        sky.patch(sky={"sunElevation": -depth})
        x = depth - 5
        theirs = sum(a * x ** i for i, a in enumerate(PATAT_V))
        radiance = sky.ask(height=2635)["radiance"][1]
        ours = magnitude(radiance)
        ratio = 10 ** (-0.4 * (ours - theirs))
        there = 10 ** (-0.4 * (magnitude(radiance - night + their_night)
                               - theirs))
        rows.append({"sun": -depth, "theirs": theirs, "ours": ours,
                     "ratio": ratio, "there": there})
        print(f"| −{depth} | {theirs:.2f} | {ours:.2f} | {ratio:.2f} | "
              f"{there:.2f} |", flush=True)
    return rows


def dusk_rows(sky):
    rows = []
    print("\n| Sun, ° | glossary, lx | ours, lx |\n|---|---|---|")
    sky.patch(sky={"visibility": 40000, "stars": True})
    for elevation, low, high in GLOSSARY:
        sky.patch(sky={"sunElevation": elevation})
        ours = sky.level(lambda s: s["luminance"])
        rows.append({"sun": elevation, "low": low, "high": high,
                     "ours": ours})
        print(f"| {elevation:g} | {low:g} to {high:g} | {ours:.3g} |",
              flush=True)
    return rows


def air_mass(sine):
    return 1 / (sine + 0.025 * math.exp(-11 * sine))


def scattered(away, moon, sine, star):
    """Krisciunas and Schaefer 1991, eq. 15 and 21, cd/m2; star: of eq. 20."""
    f = (10 ** 5.36 * (1.06 + math.cos(away) ** 2)
         + 10 ** (6.15 - math.degrees(away) / 40))
    mass = (lambda s: (1 - 0.96 * (1 - s * s)) ** -0.5)
    return (f * star * 10 ** (-0.4 * EXTINCTION * mass(moon))
            * (1 - 10 ** (-0.4 * EXTINCTION * mass(sine)))) * NL


def moon_theirs(altitude, alpha):
    magnitudes = -12.73 + 0.026 * alpha + 4e-9 * alpha ** 4
    star = 10 ** (-0.4 * (magnitudes + 16.57))  # foot-candles
    sine = math.sin(math.radians(altitude))
    direct = (10.764 * star * sine
              * 10 ** (-0.4 * EXTINCTION * air_mass(sine)))
    total, steps = 0.0, 60
    for i in range(steps):
        x = (i + 0.5) / steps
        e = math.asin(math.sqrt(x))
        for k in range(steps):
            a = math.pi * (k + 0.5) / steps
            cosine = (math.sin(e) * sine + math.cos(e) * math.cos(a)
                      * math.cos(math.radians(altitude)))
            total += scattered(math.acos(max(-1, min(1, cosine))), sine,
                               math.sin(e), star)
    return direct, total * math.pi / steps ** 2


def moon_rows(sky, options):
    rows = []
    print("\n| altitude, ° | phase angle, ° | theirs, lx | of it sky | ours "
          "| of it sky | over theirs |\n|---|---|---|---|---|---|---|")
    sky.patch(sky={"visibility": 40000, "sunElevation": -60, "sunAzimuth": 0,
                   "moonAzimuth": 180, "stars": False})
    for altitude in (20, 60) if options.quick else (10, 20, 35, 50, 70, 85):
        whole = None
        for alpha in (0, 90) if options.quick else (0, 30, 60, 90, 120):
            lit = 0.5 + 0.5 * math.cos(math.radians(alpha))
            sky.patch(sky={"moonElevation": altitude, "moonPhase": lit})
            beam = sky.ask()["moonIrradiance"][1]
            if whole is None:  # the sky is in proportion
                whole = sky.level(lambda s: s["radiance"][1]) / beam
            direct = (beam * math.sin(math.radians(altitude))
                      / V_ZERO * V_LUX)
            ours = direct + beam * whole / V_ZERO * V_LUX
            d, s = moon_theirs(altitude, alpha)
            rows.append({"altitude": altitude, "alpha": alpha,
                         "theirs": d + s, "ours": ours,
                         "ratio": ours / (d + s)})
            print(f"| {altitude} | {alpha} | {d + s:.4f} | {s / (d + s):.0%} "
                  f"| {ours:.4f} | {1 - direct / ours:.0%} "
                  f"| {ours / (d + s):.2f} |", flush=True)
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--assert", dest="check", action="store_true")
    options = parser.parse_args()
    os.nice(max(0, 10 - os.nice(0)))
    with Daemon() as daemon:
        sky = Sky(daemon)
        twilight = twilight_rows(sky, options)
        dusk = dusk_rows(sky)
        moon = moon_rows(sky, options)
        sky.patch(sky={"moonElevation": None, "moonPhase": None,
                       "moonAzimuth": None, "sunElevation": -40,
                       "stars": True})
        zenith = magnitude(sky.ask()["radiance"][1])
    print(f"\nMoonless zenith: {zenith:.2f} mag/arcsec² in V", flush=True)
    worst = max((abs(row["ratio"] - 1), row["sun"]) for row in twilight
                if row["sun"] >= -13)
    late = max((abs(row["ratio"] - 1), row["sun"]) for row in twilight
               if row["sun"] < -13)
    there = max((abs(row["there"] - 1), row["sun"]) for row in twilight)
    off = max((abs(row["ratio"] - 1), row["altitude"], row["alpha"])
              for row in moon)
    dim = max((max(row["low"] / row["ours"], row["ours"] / row["high"], 1),
               row["sun"]) for row in dusk)
    checks = [
        ("zenith, Sun −5 to −13°, against Patat et al. 2006, V", "≤ 30 %",
         f"{worst[0]:.0%} at {worst[1]}°", bool(worst[0] <= 0.3)),
        ("the same, −14 and −15°", "≤ 30 %",
         f"{late[0]:.0%} at {late[1]}°", bool(late[0] <= 0.3)),
        ("zenith, Sun −5 to −15°, with the night of their site", "≤ 30 %",
         f"{there[0]:.0%} at {there[1]}°", bool(there[0] <= 0.3)),
        ("light on the level sea at sunset, −6, −12, −18° (AMS glossary)",
         "within a factor 1.3", f"{dim[0]:.2f} at {dim[1]:g}°",
         bool(dim[0] <= 1.3)),
        (f"moonlight on the level sea, {len(moon)} phases and altitudes",
         "≤ 20 % of Krisciunas and Schaefer 1991",
         f"{off[0]:.0%} at {off[1]}°, phase angle {off[2]}°",
         bool(off[0] <= 0.2)),
        ("moonless zenith away from the Milky Way", "22.0 ± 0.25 mag/arcsec²",
         f"{zenith:.2f}", bool(abs(zenith - 22) <= 0.25))]
    folder = os.path.join(ROOT, "build", "validate",
                          "quick" if options.quick else "")
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "night.json"), "w", encoding="utf-8") as f:
        json.dump({"twilight": twilight, "dusk": dusk, "moon": moon,
                   "checks": checks}, f)
    return 3 if options.check and not all(c[3] for c in checks) else 0


if __name__ == "__main__":
    sys.exit(main())
