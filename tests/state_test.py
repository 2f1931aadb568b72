#!/usr/bin/python3
"""The state file: kill -9 at any moment leaves a scene that was once agreed
to, a file that cannot be written is reported and tried again.

KILLS (25): how often the daemon is killed.
"""
import json
import os
import random
import shutil
import signal
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import Daemon, until

KILLS = int(os.environ.get("KILLS", "25"))


class StateFile(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="pelagos-state-")
        self.path = os.path.join(self.folder, "scene")
        self.addCleanup(shutil.rmtree, self.folder)

    def test_killed_at_any_moment(self):
        """Edits as fast as they are taken, then SIGKILL: the next life begins
        with one of them, never with less than the first edit of a life."""
        chance = random.Random(7)
        agreed = None
        for _ in range(KILLS):
            daemon = Daemon("--state", self.path)
            found = daemon.state()["sea"]["seed"]
            if agreed is not None:
                self.assertIn(found, agreed)
            agreed = []
            # One edit is on its own long enough to be written at once: what
            # was agreed to before it is history.
            end = time.monotonic() + chance.uniform(0, 0.2)
            seed = chance.randrange(1, 1 << 32)
            daemon.patch({"sea": {"seed": seed}})
            until("it is written", lambda: self.seed_on_disk() == seed)
            agreed.append(seed)
            while time.monotonic() < end:
                seed = chance.randrange(1, 1 << 32)
                agreed.append(seed)
                view = f"v{chance.randrange(60)}"
                daemon.patch({"sea": {"seed": seed},
                              "views": {view: {"yaw": chance.random()}}})
            daemon.stop(how=signal.SIGKILL)
        self.assertEqual([name for name in os.listdir(self.folder)
                          if name.endswith(".bad")], [])

    def seed_on_disk(self):
        try:
            with open(self.path) as f:
                return json.load(f)["sea"]["seed"]
        except FileNotFoundError:
            return None

    def test_tried_again(self):
        folder = os.path.join(self.folder, "later")
        path = os.path.join(folder, "scene")
        with Daemon("--state", path) as daemon:
            self.assertEqual(daemon.patch({"sea": {"windSpeed": 3}}).status,
                             200)
            until("it is told", lambda: "SCN-003" in daemon.log())
            self.assertGreaterEqual(
                daemon.metrics()["pelagos_scene_save_errors_total"], 1)
            self.assertEqual(
                daemon.get("/v1/views/bridge/frame.jpg?width=64&height=36")
                .status, 200)
            os.mkdir(folder)
            until("it is written", lambda: os.path.exists(path))
            with open(path) as f:
                self.assertEqual(json.load(f)["sea"]["windSpeed"], 3)
            self.assertEqual(daemon.metrics()["pelagos_scene_saves_total"], 1)

    def test_a_file_that_does_not_load(self):
        for text in ("", "{", '{"sea":{"windSpeed":99}}', '{"nope":1}',
                     "\0" * 5000, '{"views":[{"name":"a"},{"name":"a"}]}'):
            with open(self.path, "w") as f:
                f.write(text)
            with Daemon("--state", self.path) as daemon:
                self.assertIn("SCN-002", daemon.log())
                self.assertEqual(daemon.state()["sea"]["windSpeed"], 8)
            with open(self.path + ".bad") as f:
                self.assertEqual(f.read(), text)


if __name__ == "__main__":
    unittest.main(verbosity=2)
