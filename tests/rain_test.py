#!/usr/bin/python3
"""Rain and snow as pictures and numbers show them: the air as its extinction
says, the slopes of pixels and of the spectrum grow by the same, and any order
gives the same bits."""
import os
import sys

import numpy as np

from modbus_test import check
from pelagos_daemon import ROOT, SLOW_S, Daemon

sys.path.insert(0, os.path.join(ROOT, "clients", "python"))
import pelagos  # noqa: E402

STATE = {
    "clock": {"mode": "STEPPED", "time": 20},
    "sea": {"windSpeed": 7, "synthesiser": "FFT", "spectrum": "ELFOUHAILY"},
    "sky": {"sunElevation": 40, "sunAzimuth": 90, "visibility": 30000},
    "views": [{"name": "bridge", "width": 160, "height": 120, "up": 15,
               "pitch": -4, "yaw": 0, "fieldOfView": 30}]}


def picture(ocean, *layers):
    frame = ocean.frame("bridge", "exr", layers=layers, float_samples=True)
    return frame.exr()


def extinction(rain, snow=0.0):
    """By the drops' and flakes' shadows (docs/physics/atmosphere.md), 1/m."""
    return 3.646e-4 * rain ** 0.63 + 5.04e-3 * snow ** 0.86


def slopes(daemon):
    answer = daemon.request("GET", "/v1/spectrum").json()["spectrum"]
    return answer["slopeAlong"] + answer["slopeCross"]


def air_follows(daemon, ocean):
    """Snow is drawn as the visibility that its extinction leaves."""
    for snow in (0.05, 0.3, 1.0):
        daemon.patch({"sky": {"snow": snow, "visibility": 30000}})
        fallen = picture(ocean, "radiance", "air")
        left = 3.912 / (3.912 / 30000 + extinction(0, snow))
        daemon.patch({"sky": {"snow": 0, "visibility": left}})
        seen = picture(ocean, "radiance", "air")
        for layer in ("radiance", "air"):
            a, b = fallen[layer], seen[layer]
            if layer == "radiance":  # flakes near the eye; their mean is none
                a, b = np.mean(a, axis=(0, 1)), np.mean(b, axis=(0, 1))
            off = float(np.max(np.abs(a - b) / np.maximum(b, 1e-6)))
            print(f"  snow {snow} mm/h as {left:.0f} m, {layer}: {off:.1e}")
            # Three digits of the factor above, 3e-3 over the longest ways.
            check(off < 5e-3, f"{layer} {off}")
    daemon.patch({"sky": {"visibility": 30000}})


def slopes_are_the_same(daemon, ocean):
    """Where a pixel resolves only waves that rain spares, the layer
    slopeVariance changes by what the spectrum does."""
    dry, seen = slopes(daemon), None
    for rain in (0, 4, 30, 120):
        daemon.patch({"sky": {"rain": rain}})
        numbers = slopes(daemon)
        daemon.patch({"views": [{"name": "bridge", "up": 3000, "pitch": -50}]})
        layer = picture(ocean, "slopeVariance")["slopeVariance"]
        daemon.patch({"views": [{"name": "bridge", "up": 15, "pitch": -4}]})
        drawn = float(np.mean(layer[..., 0] + layer[..., 1]))
        print(f"  {rain} mm/h: spectrum {numbers:.4f} ({numbers - dry:+.4f}), "
              f"drawn {drawn:.4f}")
        seen = drawn if seen is None else seen
        # Cascades below any wavelength are within 1.3 % of the spectrum.
        check(abs(drawn - seen - (numbers - dry)) < 0.015 * numbers,
              f"{drawn} {numbers}")
        check(rain < 30 or numbers > dry + 0.01, "no ring waves")
    daemon.patch({"sky": {"rain": 0}})


def any_order(daemon, ocean):
    dry = ocean.frame("bridge", "png").data
    shots = {}
    for rain in (0, 20, 5, 20, 0, 5):
        daemon.patch({"sky": {"rain": rain}})
        data = ocean.frame("bridge", "png").data
        check(shots.setdefault(rain, data) == data, f"{rain} mm/h: other bits")
    check(shots[0] == dry and shots[5] != dry, "dry")


def radar_has_it(daemon, ocean):
    """A radar without a rain of its own is in the sky's."""
    def echoes(**rain):
        view = {**STATE["views"][0], "height": 160,
                "radar": {"range": 6, "rings": False, **rain}}
        check(daemon.patch({"views": [view]}).status == 200, "radar")
        return ocean.frame("bridge", "png").data
    daemon.patch({"sky": {"rain": 40}})
    own, none, skies = echoes(rain=40), echoes(rain=0), echoes(rain=None)
    check(own == skies and own != none, "radar's rain")
    daemon.patch({"sky": {"rain": 0}})
    check(echoes(rain=None) == echoes(rain=0), "radar without rain")
    daemon.patch({"views": [{**STATE["views"][0], "radar": None}]})


def metar_rains(daemon, _):
    daemon.patch({"sky": {"metar": "EHAM 231355Z 24015KT 4000 -RA BKN012 "
                                   "12/09 Q1003"}})
    sky = daemon.state()["sky"]
    check(sky["rain"] == 1 and sky["snow"] == 0, f"{sky}")
    whole = 3.912 / (3.912 / sky["visibility"] + extinction(1))
    check(abs(whole - 4000) < 10, f"{whole} m")
    daemon.patch({"sky": {"metar": "EHAM 231455Z 24015KT 9999 SCT030 12/09 "
                                   "Q1003"}})
    sky = daemon.state()["sky"]
    check((sky["rain"], sky["visibility"]) == (0, 20000), f"{sky}")


def main():
    with Daemon() as daemon:
        ocean = pelagos.Ocean(daemon.url(), timeout=SLOW_S)
        daemon.patch(STATE)
        for part in (air_follows, slopes_are_the_same, any_order,
                     radar_has_it, metar_rains):
            print(part.__name__)
            part(daemon, ocean)
        answer = daemon.request("PATCH", "/v1/state", {"sky": {"rain": 151}})
        check(answer.status == 400, f"{answer.status}")
    print("ok")


if __name__ == "__main__":
    main()
