#!/usr/bin/python3
"""The script that lets a hull in Gazebo float on Pelagos' sea: a body under its
wrench and gravity comes to rest at its draught, upright, and goes with waves;
its topics, with gz-transport's classes of a few lines."""
import os
import pathlib
import subprocess
import sys
import types
import unittest

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import ROOT, SLOW_S
from python_client_test import SOURCE, OceanCase
sys.path.insert(0, f"{ROOT}/clients/gazebo")
from hull_wrench import GRAVITY, Follower, Hull, connect, rotation_of
from pelagos import Ocean

STEP_S = 0.02


class Body:
    """A rigid box of the hull's mass; semi-implicit Euler's steps."""

    def __init__(self, hull, length, beam, high):
        self.mass = hull.mass
        self.inertia = hull.mass / 12 * np.array(
            [beam ** 2 + high ** 2, length ** 2 + high ** 2,
             length ** 2 + beam ** 2])
        self.place, self.rotation = np.zeros(3), np.eye(3)
        self.velocity, self.spin = np.zeros(3), np.zeros(3)

    def step(self, force, torque):
        self.velocity = self.velocity + STEP_S * (
            force / self.mass - np.array([0, 0, GRAVITY]))
        self.place = self.place + STEP_S * self.velocity
        body = self.rotation.T @ torque / self.inertia
        self.spin = self.spin + STEP_S * (self.rotation @ body)
        x, y, z = STEP_S * self.spin
        turned = (np.eye(3) + np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
                  ) @ self.rotation
        u, _, v = np.linalg.svd(turned)
        self.rotation = u @ v


class Floating(OceanCase):
    def setUp(self):
        self.ocean = Ocean(self.url, timeout=10 * SLOW_S)
        self.addCleanup(self.ocean.close)

    def sail(self, steps, begin=0.0, **start):
        hull = Hull(5.4, 2.6, 0.4)
        body = Body(hull, 5.4, 2.6, 0.8)
        for name, value in start.items():
            setattr(body, name, np.array(value, float))
        out = []
        follower = Follower(self.ocean, hull)
        for n in range(steps):
            given = follower.take(begin + n * STEP_S, body.place,
                                  body.rotation)
            body.step(*(given or (np.zeros(3), np.zeros(3))))
            out.append((body.place[2], body.rotation[2, 2]))
        return body, np.array(out)

    def test_rests_at_its_draught(self):
        self.ocean.reset(1, {"sea": {"windSpeed": 0, "level": 1.5,
                                     "synthesiser": "TROCHOIDS"}})
        tilt = np.radians(8)
        body, _ = self.sail(500, place=[3, 4, 1.9], rotation=[
            [1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)],
            [0, np.sin(tilt), np.cos(tilt)]])
        self.assertAlmostEqual(body.place[2], 1.5, delta=0.02)
        self.assertGreater(body.rotation[2, 2], np.cos(np.radians(1.5)))
        self.assertLess(np.linalg.norm(body.velocity), 0.05)

    def test_goes_with_a_wave(self):
        """A wave of 8 s is far longer than the hull: it is carried."""
        self.ocean.reset(1, {"sea": {"windSpeed": 0, "wave": [[1, 8, 270, 0]],
                                     "synthesiser": "TROCHOIDS"}})
        _, path = self.sail(800)
        times = np.arange(800) * STEP_S
        water = self.ocean.surface([0, 0], times[200::10]).height
        heave = path[200::10, 0]
        self.assertGreater(np.corrcoef(heave, water)[0, 1], 0.95)
        self.assertAlmostEqual(heave.std() / water.std(), 1, delta=0.25)

    def test_topics(self):
        self.ocean.reset(1, {"sea": {"windSpeed": 0}})
        sent, heard = [], {}

        def message(**members):
            return types.SimpleNamespace(**members)

        class EntityWrench:
            def __init__(self):
                self.entity = message(name="", type=None)
                self.wrench = message(force=message(), torque=message())

        class Node:
            def advertise(self, topic, kind):
                heard["out"] = (topic, kind)
                return message(publish=sent.append)

            def subscribe(self, kind, topic, callback):
                heard["in"], heard["take"] = topic, callback
        modules = {
            "gz": message(), "gz.msgs10": message(),
            "gz.transport13": message(Node=Node),
            "gz.msgs10.entity_pb2": message(Entity=message(LINK=3)),
            "gz.msgs10.entity_wrench_pb2": message(EntityWrench=EntityWrench),
            "gz.msgs10.pose_v_pb2": message(Pose_V="Pose_V")}
        sys.modules.update(modules)
        self.addCleanup(lambda: [sys.modules.pop(n) for n in modules])
        hull = Hull(5.4, 2.6, 0.4)
        connect(Follower(self.ocean, hull), "sea", "usv", "base_link")
        self.assertEqual((heard["out"][0], heard["in"]),
                         ("/world/sea/wrench", "/world/sea/dynamic_pose/info"))
        for nsec in (0, 20_000_000, 20_000_000):
            heard["take"](message(
                header=message(stamp=message(sec=5, nsec=nsec)),
                pose=[message(name=name, position=message(x=0.0, y=0.0, z=0.0),
                              orientation=message(x=0.0, y=0.0, z=0.0, w=1.0))
                      for name in ("other", "usv")]))
        # Two poses of two times are one wrench: that of rest, its weight.
        self.assertEqual([m.entity.name for m in sent], ["usv::base_link"])
        self.assertAlmostEqual(sent[0].wrench.force.z / (hull.mass * GRAVITY),
                               1, delta=0.01)
        self.assertAlmostEqual(sent[0].wrench.torque.x, 0, delta=60)

    def test_types(self):
        done = subprocess.run(
            ["mypy", "--config-file", str(SOURCE / "pyproject.toml"),
             "--cache-dir", os.devnull, f"{ROOT}/clients/gazebo/hull_wrench.py"],
            capture_output=True, text=True,
            env={**os.environ, "MYPYPATH": str(SOURCE)})
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertTrue(pathlib.Path(ROOT, "docs/gazebo.md").exists())
        q = types.SimpleNamespace(x=0.0, y=0.0, z=2.0, w=2.0)
        np.testing.assert_allclose(rotation_of(q)[:, 0], [0, 1, 0], atol=1e-12)


if __name__ == "__main__":
    unittest.main(verbosity=2)
