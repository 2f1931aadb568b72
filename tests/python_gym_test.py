#!/usr/bin/python3
"""The example environment by what gymnasium's env_checker asks of one, with
gymnasium where it is installed and without; the labelled data set, whose files
repeat to the bit and whose boxes are those of its pixels."""
import copy
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from PIL import Image

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import SLOW_S
from python_client_test import SOURCE, OceanCase
sys.path.insert(0, str(SOURCE / "examples"))
import pelagos
import plain_gym
import usv_env

PATIENCE_S = 10 * SLOW_S
SIZE = (32, 24)


def same(a, b):
    """Observations to the bit."""
    return a.keys() == b.keys() and all(
        np.array_equal(a[n], b[n]) and a[n].dtype == b[n].dtype for n in a)


class Environment(OceanCase):
    def make(self, **more):
        env = usv_env.UsvEnv(self.url, size=SIZE, timeout=PATIENCE_S, **more)
        self.addCleanup(env.close)
        return env

    def setUp(self):
        """As before another test: a reset makes its own state."""

    def test_the_contract(self):
        env = self.make(render_mode="rgb_array", steps=4)
        self.assertIs(env.unwrapped, env)
        self.assertIn(env.render_mode, env.metadata["render_modes"])
        # Spaces: samples are members, with shape and dtype as said.
        for space in (env.action_space, *env.observation_space.spaces.values()):
            space.seed(3)
            first = space.sample()
            space.seed(3)
            self.assertTrue(np.array_equal(first, space.sample()))
            self.assertTrue(space.contains(first))
            self.assertEqual((first.shape, first.dtype),
                             (space.shape, space.dtype))
        self.assertTrue(env.observation_space.contains(
            env.observation_space.sample()))
        # reset: a pair, the observation a member, seeded alike alike.
        given = env.reset(seed=123)
        self.assertIsInstance(given, tuple)
        observation, info = given
        self.assertIsInstance(info, dict)
        self.assertTrue(env.observation_space.contains(observation))
        drawn = copy.deepcopy(env.np_random).random()
        again, _ = env.reset(seed=123)
        self.assertTrue(same(observation, again))
        self.assertEqual(env.np_random.random(), drawn)
        unlike, _ = env.reset(seed=456)
        self.assertFalse(same(observation, unlike))
        after, _ = env.reset()  # without a seed the generator goes on
        self.assertFalse(same(unlike, after))
        _, info = env.reset(seed=1, options={"wind": 3.0})
        self.assertEqual(info["wind"], 3.0)
        # step: five things of their types; the action stays as it was.
        env.action_space.seed(0)
        action = env.action_space.sample()
        kept = action.copy()
        observation, reward, terminated, truncated, info = env.step(action)
        self.assertTrue(env.observation_space.contains(observation))
        self.assertEqual(
            [type(v) for v in (reward, terminated, truncated, info)],
            [float, bool, bool, dict])
        self.assertTrue(np.isfinite(reward))
        np.testing.assert_array_equal(action, kept)
        picture = env.render()
        self.assertEqual((picture.shape, picture.dtype),
                         ((320, 480, 3), np.uint8))
        # What was given is not changed by what comes.
        before = copy.deepcopy(observation)
        env.step(action)
        self.assertTrue(same(before, observation))
        # The episode is cut at its length, and then over.
        self.assertFalse(env.step(action)[3])
        _, _, terminated, truncated, _ = env.step(action)
        self.assertEqual((terminated, truncated), (False, True))
        with self.assertRaises(RuntimeError):
            env.step(action)
        for bad in ([2, 0], [0], [np.nan, 0], "full ahead"):
            env.reset(seed=1)
            with self.assertRaises(ValueError):
                env.step(bad)
        with self.assertRaises(ValueError):
            env.reset(seed=-1)
        with self.assertRaises(ValueError):
            self.make(observe="smell")
        with self.assertRaises(ValueError):
            self.make(render_mode="human")
        self.assertIsNone(self.make().render())

    def test_the_same_actions_are_the_same_episode(self):
        """To the bit, whatever others did to the daemon."""
        def episode(env):
            out = [env.reset(seed=9)[0]]
            env.action_space.seed(5)
            for _ in range(4):
                out.append(env.step(env.action_space.sample()))
            return out
        for observe in ("image", "depth"):
            env = self.make(observe=observe)
            first = episode(env)
            with pelagos.Ocean(self.url) as other:
                other.set(sea={"windSpeed": 17}, water={"named": "HARBOUR"},
                          clock={"mode": "FREE"})
            second = episode(self.make(observe=observe))
            self.assertTrue(same(first[0], second[0]))
            for a, b in zip(first[1:], second[1:]):
                self.assertTrue(same(a[0], b[0]))
                self.assertEqual(a[1:], b[1:])
        self.assertEqual(first[0]["depth"].max(), usv_env.FAR_M)
        self.assertLess(first[0]["depth"].min(), 20)

    def test_the_task(self):
        """A helmsman gets to the end of the track; the buoy is seen, and who
        steers at it ends there; who turns away is lost."""
        env = self.make(observe="depth", steps=150)
        ends = {}
        for name, aim, seed in (("keeps", usv_env.helmsman, 4),
                                ("hits", None, 4), ("leaves", None, 4)):
            state = env.reset(seed=seed)[0]["state"]
            total, over = 0.0, False
            while not over:
                if aim:
                    action = aim(state)
                elif name == "hits":
                    right = np.arctan2(state[9], state[8])
                    action = np.array([np.clip(2 * right, -1, 1), 1])
                else:  # athwart the track
                    error = np.pi / 2 - np.arctan2(state[2], state[3])
                    action = np.array([np.clip(2 * error, -1, 1), 1])
                seen, reward, terminated, truncated, info = env.step(action)
                state, total = seen["state"], total + reward
                over = terminated or truncated
            ends[name] = (terminated, info, total)
        terminated, info, total = ends["keeps"]
        self.assertTrue(terminated and info["along"] >= usv_env.TRACK_M)
        self.assertGreater(total, 200)
        terminated, info, worse = ends["hits"]
        self.assertTrue(terminated and info["buoy"] < usv_env.HIT_M)
        self.assertLess(worse, total - 100)
        terminated, info, _ = ends["leaves"]
        self.assertTrue(terminated and abs(info["off"]) > usv_env.LOST_M)

    def test_with_gymnasium_it_is_one_of_its_environments(self):
        """With a stand-in of that name, where the real one is not there."""
        code = ("import usv_env, gymnasium\n"
                "env = usv_env.UsvEnv()\n"
                "assert isinstance(env, gymnasium.Env)\n"
                "assert isinstance(env.action_space, gymnasium.spaces.Box)\n"
                "try:\n    from gymnasium.utils.env_checker import check_env\n"
                "except ImportError: print('stand-in')\n"
                "else:\n    check_env(env, skip_render_check=True)\n"
                "    print('checked')\n")
        with tempfile.TemporaryDirectory() as folder:
            stand_in = pathlib.Path(folder, "gymnasium.py")
            try:
                import gymnasium
                self.assertTrue(gymnasium)
            except ImportError:
                stand_in.write_text(
                    "import plain_gym as spaces\nclass Env(spaces.Env): pass\n")
            done = subprocess.run(
                ["/usr/bin/python3", "-B", "-c", code], capture_output=True,
                text=True, env={**os.environ, "PELAGOS_URL": self.url,
                                "PYTHONPATH": f"{SOURCE}:{SOURCE}/examples:"
                                f"{folder}"})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(done.stdout, ("stand-in\n", "checked\n"))

    def test_seeds_of_the_plain_generator(self):
        for bad in (-1, 1.5, "a"):
            with self.assertRaises(ValueError):
                plain_gym.generator(bad)
        self.assertIsInstance(plain_gym.Box(0, 1, (2,)).low, np.ndarray)
        self.assertNotIn(np.array([2.0, 0], np.float32),
                         plain_gym.Box(0, 1, (2,)))
        self.assertNotIn(np.array([0.5, 0]), plain_gym.Box(0, 1, (2,)))


class Labelled(OceanCase):
    def run_example(self, out, *arguments):
        done = subprocess.run(
            ["/usr/bin/python3", "-B", str(SOURCE / "examples/labelled.py"),
             "--url", self.url, "--out", str(out), "--size", "160x96",
             "--timeout", str(PATIENCE_S), *arguments], capture_output=True,
            text=True, env={**os.environ, "PYTHONPATH": str(SOURCE)})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_labelled(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            before = self.ocean.state()
            told = self.run_example(folder / "a", "--scenes", "3")
            self.assertIn("mean overlap 1.0000, least 1.0000", told)
            self.assertRegex(told, r"\d\.\d\d pictures a second")
            after = self.ocean.state()
            self.assertEqual((after.sea, after.entities, after.clock),
                             (before.sea, before.entities, before.clock))
            self.ocean.set(sea={"windSpeed": 25}, clock={"mode": "FREE"})
            self.run_example(folder / "b", "--scenes", "3")
            files = sorted(p.relative_to(folder / "a") for p in
                           (folder / "a").rglob("*") if p.is_file())
            self.assertEqual(len(files), 10)
            for file in files:
                self.assertEqual((folder / "a" / file).read_bytes(),
                                 (folder / "b" / file).read_bytes(), file)
            self.check(folder / "a")
            self.run_example(folder / "c", "--scenes", "1", "--seed", "2")
            self.assertNotEqual((folder / "a/images/0000.png").read_bytes(),
                                (folder / "c/images/0000.png").read_bytes())

    def check(self, folder):
        """As a reader who has the files alone."""
        coco = json.loads((folder / "annotations.json").read_text())
        self.assertEqual(len(coco["images"]), 3)
        self.assertGreater(len(coco["annotations"]), 5)
        names = {c["id"]: c["name"] for c in coco["categories"]}
        for image in coco["images"]:
            file = pathlib.Path(image["file_name"]).stem
            picture = np.asarray(Image.open(folder / image["file_name"]))
            ids = np.asarray(Image.open(folder / f"ids/{file}.png"))
            depth = np.asarray(Image.open(folder / f"depth/{file}.tif"))
            self.assertEqual((picture.shape, ids.shape, depth.shape),
                             ((96, 160, 3), (96, 160), (96, 160)))
            marked = [a for a in coco["annotations"]
                      if a["image_id"] == image["id"]]
            self.assertEqual({a["entity"] + 1 for a in marked},
                             set(np.unique(ids)) - {0})
            for a in marked:
                rows, columns = np.nonzero(ids == a["entity"] + 1)
                self.assertEqual(a["bbox"], [
                    columns.min(), rows.min(), np.ptp(columns) + 1,
                    np.ptp(rows) + 1])
                self.assertLess(abs(depth[rows, columns].min()
                                    - a["distance"]), 160)
                self.assertIn(a["category_id"], names)


if __name__ == "__main__":
    unittest.main(verbosity=2)
