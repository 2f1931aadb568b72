#!/usr/bin/python3
"""Ship waves end to end: what is drawn is what is queried, tracks are state,
moments are functions of it, and what is off is as if it were not there."""
import json
import math
import os
import pathlib
import sys
import unittest
import urllib.request

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import ROOT, Daemon

sys.path.insert(0, str(pathlib.Path(ROOT) / "clients/python"))
sys.dont_write_bytecode = True
import pelagos

NORTH = 1 / 111_290.0
EAST = 1 / (111_320.0 * math.cos(math.radians(52.6)))
SPEED = 6.17


class Wakes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.addClassCleanup(cls.daemon.stop)
        cls.ocean = pelagos.Ocean(cls.daemon.url(""))
        cls.addClassCleanup(cls.ocean.close)

    def start(self, wake=True, **more):
        """A ship that goes north from 1200 m south of the origin, at time 0."""
        self.ocean.patch({"clock": {"mode": "STEPPED", "time": 0,
                                    "reckoning": 3600},
                          "sea": {"windSpeed": 0, "whitecaps": 0}})
        self.ocean.patch({"entities": {"5": None}} if 5 in self.ids() else {})
        self.ocean.patch({"entities": {"5": {
            "latitude": 52.6 - 1200 * NORTH, "longitude": 5.2,
            "heading": 0, "course": 0, "speed": SPEED, "turnRate": 0,
            "model": {"name": "tanker", "length": 100}, "wake": wake,
            **more}}})

    def heights(self, points, time=None):
        return np.asarray(self.ocean.surface(points, time=time).height)

    def raw(self):
        with urllib.request.urlopen(self.daemon.url("/v1/state")) as answer:
            return json.load(answer)

    def ids(self):
        return [e["id"] for e in self.raw()["entities"]]

    def track(self):
        state = self.raw()
        entity = [e for e in state["entities"] if e["id"] == 5][0]
        return entity.get("track", [])

    LINE = [(0.0, -100.0 - 2.0 * i) for i in range(60)]

    def test_waves_of_the_right_length(self):
        self.start()
        line = [(0.0, -150.0 - 0.5 * i) for i in range(400)]
        h = self.heights(line, 200.0)
        self.assertGreater(np.ptp(h), 0.1)
        rising = np.nonzero((h[:-1] < 0) & (h[1:] >= 0))[0]
        length = 0.5 * (rising[-1] - rising[0]) / (len(rising) - 1)
        want = 2 * math.pi * SPEED ** 2 / 9.81
        self.assertLess(abs(length / want - 1), 0.03)

    def test_off_is_calm(self):
        self.start(wake=False)
        self.assertEqual(np.ptp(self.heights(self.LINE, 200.0)), 0)

    def test_a_moment_is_a_function_of_the_state(self):
        self.start()
        first = self.heights(self.LINE, 230.0)
        self.heights(self.LINE, 200.0)
        self.ocean.step(230.0)
        np.testing.assert_array_equal(first, self.heights(self.LINE))

    def test_tracks_are_kept_and_end(self):
        self.start()
        self.ocean.step(150.0)
        self.assertEqual(self.track(), [])
        self.ocean.patch({"entities": {"5": {"course": 90, "heading": 90}}})
        self.assertEqual(len(self.track()), 2)
        old = self.heights(self.LINE)
        self.assertGreater(np.ptp(old), 0.1)
        self.ocean.step(5.0)
        self.ocean.patch({"entities": {"5": {"turnRate": 2}}})
        for _ in range(300):
            self.ocean.step(2.0)
            self.ocean.patch({"entities": {"5": {"speed": SPEED}}})
        self.assertLessEqual(len(self.track()), 240)
        self.assertGreater(len(self.track()), 50)
        self.ocean.patch({"entities": {"5": {"latitude": 52.7}}})
        self.assertEqual(self.track(), [])

    def test_slopes_that_pixels_hide_are_counted(self):
        """From a height at which a pixel is longer than the waves the mean
        square slope is the one of the queried surface."""
        self.start()
        self.ocean.step(200.0)
        grid = [(4.0 * i - 50, -250.0 + 4.0 * j) for i in range(25) for j in range(25)]
        n = np.asarray(self.ocean.surface(grid).normal)
        want = np.mean((n[:, 0] ** 2 + n[:, 1] ** 2) / n[:, 2] ** 2)
        got = []
        for height in (100, 1000, 4000):
            self.ocean.patch({"views": {"eye": {
                "entity": 1, "up": height, "pitch": -90, "width": 120, "height": 120,
                "fieldOfView": 2 * math.degrees(math.atan(50 / height))
                if height == 100 else 60}},
                "entities": {"1": {"latitude": 52.6 - 202 * NORTH,
                                   "longitude": 5.2}}})
            exr = self.ocean.frame("eye", "exr", layers=(
                "position", "normal", "slopeVariance")).exr()
            layers = {k.split(".")[0]: v for k, v in exr.layers.items()}
            place, normal, lost = (layers[k] for k in ("position", "normal", "slopeVariance"))
            inside = (np.abs(place[..., 0]) < 50) & (np.abs(place[..., 1] + 202) < 50)
            s = normal[inside]
            shown = np.mean((s[:, 0] ** 2 + s[:, 1] ** 2) / s[:, 2] ** 2)
            hidden = np.mean(np.sum(lost[inside], axis=-1))
            got.append(shown + hidden)
            print(f"from {height} m: mean square slope {shown:.5f} shown, "
                  f"{hidden:.5f} hidden, {want:.5f} queried")
        # 625 places of a grid, pixels of 1 m, 10 m and 40 m: 3 to 6 % off
        np.testing.assert_allclose(got, want, rtol=0.1)

    def test_drawn_is_queried(self):
        self.start()
        self.ocean.step(200.0)
        self.ocean.patch({"views": {"eye": {"entity": 1, "up": 30, "pitch": -60, "yaw": 180, "width": 320,
            "height": 240, "fieldOfView": 60}},
            "entities": {"1": {"latitude": 52.6 - 100 * NORTH,
                               "longitude": 5.2}}})
        exr = self.ocean.frame("eye", "exr", layers=("position",)).exr()
        place = next(iter(exr.layers.values())).reshape(-1, 3)[::97]
        h = self.heights([(float(p[0]), float(p[1])) for p in place])
        off = np.abs(h - place[:, 2])
        self.assertGreater(np.ptp(h), 0.2)
        print(f"drawn against queried: median {np.median(off) * 1e3:.2f} mm, "
              f"most {off.max() * 1e3:.2f} mm")
        self.assertLess(np.quantile(off, 0.99), 1e-3)

    def test_the_bow_wave_is_drawn_and_queried(self):
        """The raised crest beside the stem, from above it."""
        self.start(speed=9, model={"name": "ferry", "length": 84})
        self.ocean.step(200.0)
        bow = -1200 + 9 * 200.0 + 36
        self.ocean.patch({"views": {"eye": {
            "entity": 1, "up": 30, "pitch": -60, "yaw": -90, "width": 320,
            "height": 240, "fieldOfView": 60}},
            "entities": {"1": {"latitude": 52.6 + bow * NORTH,
                               "longitude": 5.2 + 25 * EAST}}})
        exr = self.ocean.frame("eye", "exr", layers=("position",)).exr()
        place = next(iter(exr.layers.values())).reshape(-1, 3)[::61]
        # Of the sea, not of the hull: a ship's side is steep and higher.
        water = place[np.abs(place[:, 0]) > 6.5]
        asked = [(float(p[0]), float(p[1])) for p in water]
        h = self.heights(asked)
        off = np.abs(h - water[:, 2])
        print(f"bow: {len(off)} places, crest {h.max():.2f} m, median "
              f"{np.median(off) * 1e3:.2f} mm, p99 {np.quantile(off, .99) * 1e3:.2f}")
        self.assertGreater(h.max(), 0.4)
        self.assertLess(np.quantile(off, 0.99), 1e-3)


if __name__ == "__main__":
    unittest.main()
