#!/usr/bin/python3
"""The path of a lamp on the sea against facets at random: `make validate-lamps`.

    lamps.py [--quick] [--assert]

A floodlight on a mast lights the sea between it and an eye. Pictures of many
moments (EXR, 550 nm, lamp lit less unlit) in bands of 5 degrees of depression
and of azimuth, against facets: the level sea's points at the heights of
waves (normal), slopes normal with the variances along and across the wind that
/v1/spectrum gives, Fresnel's equations for 1.34, the beam 2^-(angle / 45
deg)^2, inverse squares; each point's radiance is I / d^2 F p / (4 cos v cos^4
b) (Cox and Munk 1954). What the lamp gives is what the same pictures have of it
directly. No facet hides another here: the light comes from 20 degrees above
and more. Writes lamps.json into build/validate/; status 3 with --assert where
the light of a whole path is off by more than 5 %.
"""
import argparse
import json
import math
import os
import sys

import numpy as np

from eyekit import ROOT, read_exr
from pelagos_daemon import Daemon

WIDTH, HEIGHT, FIELD, PITCH = 160, 160, 90.0, -28.0
EYE_M, LAMP_M, GREEN = 20.0, 30.0, 1
BAR = 0.05
N = 1.34


def fresnel(cosine):
    sine2 = (1 - cosine ** 2) / N ** 2
    inner = np.sqrt(1 - sine2)
    s = (cosine - N * inner) / (cosine + N * inner)
    p = (inner - N * cosine) / (inner + N * cosine)
    return 0.5 * (s * s + p * p)


def rays():
    """East, north, up of each pixel's way, and its solid angle."""
    half = math.tan(math.radians(FIELD) / 2)
    x = (np.arange(WIDTH) + 0.5) / WIDTH * 2 - 1
    x, y = np.meshgrid(x * half, -(np.arange(HEIGHT) + 0.5) / HEIGHT
                       * 2 * half * HEIGHT / WIDTH + half * HEIGHT / WIDTH)
    length = np.sqrt(1 + x * x + y * y)
    c, s = math.cos(math.radians(PITCH)), math.sin(math.radians(PITCH))
    way = np.stack([x, c - y * s, s + y * c], -1) / length[..., None]
    return way, (2 * half / WIDTH) ** 2 / length ** 3


def expected(way, away_m, candle, moments, wind_from, rng):
    """Radiance, mean over heights of the waves."""
    to_wind = math.radians(wind_from)
    along = np.array([math.sin(to_wind), math.cos(to_wind)])
    total = np.zeros(way.shape[:2])
    deviation = moments["significantHeight"] / 4
    lamp = np.array([0.0, away_m, LAMP_M])
    aim = np.array([0.0, away_m * EYE_M / (EYE_M + LAMP_M), 0.0]) - lamp
    aim /= np.linalg.norm(aim)
    draws = 64
    for _ in range(draws):
        z = deviation * rng.standard_normal(way.shape[:2])
        far = (z - EYE_M) / np.minimum(way[..., 2], -1e-6)
        at = way * far[..., None] + [0, 0, EYE_M]
        to = lamp - at
        d = np.linalg.norm(to, axis=-1)
        to /= d[..., None]
        h = to - way
        h /= np.linalg.norm(h, axis=-1)[..., None]
        slope = -h[..., :2] / h[..., 2:]
        a = slope @ along
        b = slope @ np.array([along[1], -along[0]])
        sa, sc = moments["slopeAlong"], moments["slopeCross"]
        density = (np.exp(-0.5 * (a * a / sa + b * b / sc))
                   / (2 * math.pi * math.sqrt(sa * sc)))
        off = np.degrees(np.arccos(np.clip(-(to @ aim), -1, 1)))
        beam = candle * 2 ** -(off / 45) ** 2
        light = (beam / d ** 2 * fresnel(np.sum(h * to, -1)) * density
                 / (4 * -way[..., 2] * h[..., 2] ** 4))
        total += np.where(way[..., 2] < -0.02, light, 0)
    return total / draws


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--assert", action="store_true", dest="check")
    options = parser.parse_args()
    moments_each = 16 if options.quick else 64
    way, solid = rays()
    depression = np.degrees(np.arcsin(-way[..., 2]))
    azimuth = np.degrees(np.arctan2(way[..., 0], way[..., 1]))
    rng = np.random.default_rng(5)
    results, worst = [], 0.0
    print("| sea | wind, m/s | away, m | rises, ° | whole path | 5° of depression "
          "about | 5° of azimuth about |\n"
          "|---|---|---|---|---|---|---|")
    with Daemon() as daemon:

        def patch(**changes):
            answer = daemon.patch(changes)
            if answer.status != 200:
                sys.exit(f"lamps: {answer.status} {answer.body[:300]!r}")

        def picture():
            body = daemon.get("/v1/views/v/frame.exr?layers=radiance").body
            return np.asarray(read_exr(body).layers["radiance"])[..., GREEN]

        cases = [("FFT", wind, away) for wind in (4, 8, 12)
                 for away in (40, 70, 110)]
        for kind, wind, away in cases[::3] if options.quick else cases:
            aim_down = math.degrees(math.atan2(
                LAMP_M, away * LAMP_M / (EYE_M + LAMP_M)))
            patch(clock={"mode": "STEPPED", "time": 0},
                  origin={"latitude": 0, "longitude": 0},
                  sky={"sunElevation": -40, "moonElevation": -40,
                       "visibility": 300000, "stars": False},
                  sea={"windSpeed": wind, "windDirection": 30,
                       "synthesiser": kind, "whitecaps": 0,
                       "sparkle": False},
                  entities={"7": {"latitude": away / 110574.3, "longitude": 0,
                                  "altitude": LAMP_M - 10, "heading": 180,
                                  "searchlight": {
                                      "on": True, "bearing": 0, "width": 90,
                                      "elevation": -aim_down,
                                      "intensity": 1e6}}},
                  views=[{"name": "v", "width": WIDTH, "height": HEIGHT,
                          "fieldOfView": FIELD, "up": EYE_M, "pitch": PITCH,
                          "yaw": 0, "glare": 0}])
            moments = daemon.get("/v1/spectrum").json()["drawn"]
            sums = []
            for k in range(moments_each):
                patch(clock={"mode": "STEPPED", "time": 13.7 * k})
                lit = picture()
                patch(entities={"7": {"searchlight": {"on": False}}})
                sums.append(lit - picture())
                patch(entities={"7": {"searchlight": {"on": True}}})
            mean = np.mean(sums, 0)
            # The lamp itself: above the horizon, straight.
            above = way[..., 2] > 0.01
            gap = math.hypot(away, LAMP_M - EYE_M)
            straight = math.degrees(math.acos(
                (away * away * LAMP_M / (EYE_M + LAMP_M)
                 + (LAMP_M - EYE_M) * LAMP_M)
                / gap / math.hypot(away * LAMP_M / (EYE_M + LAMP_M), LAMP_M)))
            direct = float((mean * solid)[above].sum())
            candle = direct * gap ** 2 / 2 ** -(straight / 45) ** 2
            wanted = expected(way, away, candle, moments, 30, rng)
            sea = way[..., 2] < -0.1
            each = [float((s * solid)[sea].sum()) for s in sums]
            ratio = np.mean(each) / float((wanted * solid)[sea].sum())
            noise = np.std(each) / np.mean(each) / math.sqrt(moments_each)
            whole = float((wanted * solid)[sea].sum())

            def band(angle, middles):
                out = []
                for middle in middles:
                    here = sea & (abs(angle - middle) < 2.5)
                    there = float((wanted * solid)[here].sum())
                    # Less is noise.
                    if there > 0.03 * whole:
                        off = float((mean * solid)[here].sum()) / there - 1
                        out.append(f"{middle}: {100 * off:+.0f}")
                return ", ".join(out)

            rise = math.degrees(math.atan2(EYE_M + LAMP_M, away))
            worst = max(worst, abs(ratio - 1))
            results.append({"sea": kind, "wind": wind, "away": away, "ratio": ratio,
                            "noise": noise})
            print(f"| {kind.lower()} | {wind} | {away} | {rise:.0f} | "
                  f"{100 * (ratio - 1):+.1f} ± {100 * noise:.1f} % | "
                  f"{band(depression, range(12, 70, 5))} | "
                  f"{band(azimuth, range(-30, 31, 5))} |", flush=True)
    folder = os.path.join(ROOT, "build", "validate")
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "lamps.json"), "w", encoding="utf-8") as f:
        json.dump(results, f)
    print(f"\nlight of a path: {100 * worst:.1f} % off at worst "
          f"(bar {100 * BAR:.0f} %)")
    return 3 if options.check and worst > BAR else 0


if __name__ == "__main__":
    sys.exit(main())
