#!/usr/bin/python3
"""The wash of ships end to end: of plain entities and under helms, a function
of state and time in any order, after a restart and with the throttle astern;
where it is off, as if it were not there."""
import json
import math
import os
import pathlib
import sys
import tempfile
import unittest
import urllib.request

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import ROOT, Daemon

sys.path.insert(0, str(pathlib.Path(ROOT) / "clients/python"))
sys.dont_write_bytecode = True
import pelagos

NORTH = 1 / 111_290.0
SPEED = 7.0
VIEW = {"entity": 1, "up": 60, "pitch": -90, "yaw": 0, "width": 96,
        "height": 96, "fieldOfView": 90}


class Wash(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.place = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.place.cleanup)
        cls.daemon = Daemon()
        cls.addClassCleanup(cls.daemon.stop)
        cls.ocean = pelagos.Ocean(cls.daemon.url(""))
        cls.addClassCleanup(cls.ocean.close)

    def raw(self):
        with urllib.request.urlopen(self.daemon.url("/v1/state")) as answer:
            return json.load(answer)

    def entity(self):
        return next(e for e in self.raw()["entities"] if e["id"] == 5)

    def start(self, **more):
        """A ship that goes north from the origin, and an eye 60 m above."""
        if 5 in [e["id"] for e in self.raw()["entities"]]:
            self.ocean.patch({"entities": {"5": None}})
        self.ocean.patch({"clock": {"mode": "STEPPED", "time": 0,
                                    "reckoning": 3600},
                          "sea": {"windSpeed": 3},
                          "views": {"eye": VIEW},
                          "entities": {"1": {"latitude": 52.6,
                                             "longitude": 5.2, "speed": 0}}})
        self.ocean.patch({"entities": {"5": {
            "latitude": 52.6, "longitude": 5.2, "heading": 0, "course": 0,
            "speed": SPEED, "turnRate": 0, "wash": True,
            "model": {"name": "fishing-boat"}, **more}}})

    def foam(self, time=None):
        exr = self.ocean.frame("eye", "exr", layers=("foam",), time=time).exr()
        return np.array(next(iter(exr.layers.values())))

    def go(self, until):
        while self.ocean.state().clock.time < until - 1e-9:
            self.ocean.step(min(10.0, until - self.ocean.state().clock.time))

    def test_foam_stays_and_ages(self):
        self.start()
        self.ocean.step(8.0)
        young = self.foam()
        self.ocean.step(20.0)
        old = self.foam()
        self.assertGreater(young.mean(), 0.003)
        self.assertLess(old.mean(), 0.6 * young.mean())
        self.assertGreater(old.mean(), 0)

    def test_any_order(self):
        self.start()
        self.ocean.step(30.0)
        self.ocean.patch({"entities": {"5": {"course": 60, "heading": 60}}})
        self.ocean.step(10.0)
        first = [self.foam(t) for t in (41.0, 50.0, 45.0)]
        self.ocean.step(10.0)
        np.testing.assert_array_equal(first[1], self.foam())
        again = [self.foam(t) for t in (45.0, 41.0)]
        np.testing.assert_array_equal(first[2], again[0])
        np.testing.assert_array_equal(first[0], again[1])
        self.assertGreater(len(self.entity()["track"]), 1)
        self.assertIn("heading", self.entity()["track"][0])

    def test_off_is_none(self):
        self.start(wash=False)
        self.ocean.step(8.0)
        self.assertEqual(self.foam().max(), 0)
        off = np.asarray(self.ocean.surface([(0, 0), (3, 2)]).height)
        self.start(wash=True)
        self.ocean.step(8.0)
        on = np.asarray(self.ocean.surface([(0, 0), (3, 2), (500, 0)]).height)
        self.assertTrue((on[:2] != off).all())
        self.start(wash=False)
        self.ocean.step(8.0)
        beside = np.asarray(self.ocean.surface([(500, 0)]).height)
        self.assertEqual(on[2], beside[0])

    def helm(self, **more):
        self.start(speed=0, helm={"on": True, "length": 24, "beam": 7,
                                  "throttle": 0, "maxSpeed": 6, **more})

    def test_the_screw_of_a_helm(self):
        """Tied up it is the throttle that washes, aft or along the sides."""
        rows = {}
        for throttle in (1, -1):
            # A long time to gather way: it all but lies still.
            self.helm(throttle=throttle, surgeTime=1000)
            self.ocean.step(10.0)
            rows[throttle] = self.foam().sum(axis=tuple(range(1, 2))).ravel()
        half = len(rows[1]) // 2
        self.assertGreater(rows[1][half + 5:].sum(), 1)
        self.assertEqual(rows[1][:half].max(), 0)
        self.assertGreater(rows[-1][:half + 5].sum(), 1)

    def test_a_helm_turns_in_pieces(self):
        """However its way is cut by frames, queries and looks at the state."""
        seen = []
        for cuts in (1, 7):
            self.helm(throttle=1, rudder=20, surgeTime=5)
            for i in range(cuts):
                self.go(42.0 * (i + 1) / cuts)
                if cuts > 1:
                    self.foam()
            self.assertEqual(self.ocean.state().clock.time, 42.0)
            seen.append(self.foam())
        self.assertGreater(seen[0].mean(), 0.001)
        np.testing.assert_array_equal(seen[0], seen[1])
        track = self.entity()["track"]
        self.assertGreater(len(track), 4)
        self.assertTrue(all(abs(p["push"] - 6) < 1e-12 for p in track))

    def test_orders_end_nothing(self):
        """Water that it washed before an order goes on being that."""
        self.helm(throttle=1, surgeTime=5)
        self.go(30.0)
        before = self.foam(34.0)
        self.ocean.patch({"entities": {"5": {"helm": {"throttle": -1}}}})
        after = self.foam(34.0)
        self.assertGreater(len(self.entity()["track"]), 1)
        # Its past, south of where it is, is the same but for the ages of nodes.
        rows = before.shape[0]
        low = slice(rows // 2 - 10, rows)
        self.assertGreater(before[low].mean(), 0.001)
        self.assertLess(abs(after[low].mean() - before[low].mean()),
                        0.1 * before[low].mean())


class Restart(unittest.TestCase):
    def test_a_restart_in_a_turn(self):
        with tempfile.TemporaryDirectory() as place:
            options = ("--state", os.path.join(place, "state.json"))
            foam = []
            for run in range(2):
                daemon = Daemon(*options)
                ocean = pelagos.Ocean(daemon.url(""))
                try:
                    if run == 0:
                        ocean.patch({
                            "clock": {"mode": "STEPPED", "time": 0,
                                      "reckoning": 3600},
                            "sea": {"windSpeed": 3}, "views": {"eye": VIEW},
                            "entities": {"1": {"latitude": 52.6,
                                               "longitude": 5.2, "speed": 0},
                                         "5": {"latitude": 52.6,
                                               "longitude": 5.2, "heading": 0,
                                               "course": 0, "speed": SPEED,
                                               "wash": True, "model": {
                                                   "name": "fishing-boat"}}}})
                        ocean.step(10.0)
                        ocean.patch({"entities": {"5": {"turnRate": 5}}})
                        ocean.step(10.0)
                        ocean.patch({"entities": {"5": {"turnRate": 2}}})
                    exr = ocean.frame("eye", "exr", layers=("foam",),
                                      time=23.0).exr()
                    foam.append(np.array(next(iter(exr.layers.values()))))
                finally:
                    ocean.close()
                    daemon.stop()
            self.assertGreater(foam[0].mean(), 0.001)
            np.testing.assert_array_equal(foam[0], foam[1])


if __name__ == "__main__":
    unittest.main()
