#!/usr/bin/python3
"""The C example of what a vessel senses, linked with libpelagos shared and
static: its heights, pixels and distances are those that the Python client
reads."""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import BIN, CC_FLAGS, ROOT, SLOW_S
from python_client_test import OceanCase
from pelagos import Ocean

BUILT = pathlib.Path(BIN).parent
LIBRARY = next(BUILT.glob("libpelagos.so.*.*.*"), None)


class Sense(OceanCase):
    def setUp(self):
        self.ocean = Ocean(self.url, timeout=10 * SLOW_S)
        self.addCleanup(self.ocean.close)
        self.ocean.reset(7, {
            "entities": [{"id": 1}, {"id": 900, "model": {"name": "tug"},
                                     "latitude": 52.6005, "longitude": 5.2}],
            "views": [{"name": "bow", "entity": 1, "width": 160,
                       "height": 90}]})
        self.ocean.step(2)

    def build(self, folder, library):
        flags = subprocess.run(
            ["pkg-config", "--cflags", "--libs", "OpenEXR"], check=True,
            capture_output=True, text=True).stdout.split()
        subprocess.run(
            ["cc", "-std=c17", "-D_GNU_SOURCE", "-Wall", "-Wextra", "-Werror",
             *CC_FLAGS, "-I", f"{ROOT}/clients/lib", "-I", f"{BUILT}/gen",
             f"{ROOT}/clients/lib/sense.c", "-o", f"{folder}/sense", *library,
             *flags, "-lOpenEXRCore", "-lm"], check=True)
        return [f"{folder}/sense", "bow", f"tcp:127.0.0.1:{self.daemon.tcp_port}"]

    def check(self, out):
        heights = [float(h) for h in re.findall(r"north: *(\S+) m,", out)]
        hull = [[0, 3], [0, -3], [1.5, 0], [-1.5, 0], [0, 0]]
        np.testing.assert_allclose(
            heights, self.ocean.surface(hull).height, atol=6e-4)
        labels = self.ocean.views["bow"].labels(image=False)
        seen = re.search(r"entity 900: (\d+) pixels, (\S+) m away", out)
        mask = labels.mask(900)
        self.assertEqual(int(seen[1]), mask.sum())
        self.assertAlmostEqual(float(seen[2]), labels.depth[mask].min(),
                               delta=0.06)
        sky = np.isinf(labels.depth) & (labels.ids < 0)
        self.assertIn(f"160 x 90 pixels: {(labels.ids < 0).sum() - sky.sum()} "
                      f"of sea, {sky.sum()} of sky", out)

    def test_static(self):
        with tempfile.TemporaryDirectory() as folder:
            command = self.build(folder, [
                str(BUILT / "libpelagos.a"), "-lprotobuf-c", "-lssl",
                "-lcrypto"])
            done = subprocess.run([*command, "20"], capture_output=True,
                                  text=True)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.check(done.stdout)
            self.assertRegex(done.stdout, r"20 queries of 5 points.* a second")
            for wrong, what in (([command[0]], "usage"),
                                ([command[0], "none", command[2]], "none")):
                done = subprocess.run(wrong, capture_output=True, text=True)
                self.assertNotEqual(done.returncode, 0)
                self.assertIn(what, done.stderr)

    def test_shared(self):
        with tempfile.TemporaryDirectory() as folder:
            soname = ".".join(LIBRARY.name.split(".")[:4])
            pathlib.Path(folder, "libpelagos.so").symlink_to(LIBRARY)
            pathlib.Path(folder, soname).symlink_to(LIBRARY)
            command = self.build(folder, [f"-L{folder}", "-lpelagos",
                                          "-lprotobuf-c"])
            needed = subprocess.run(["readelf", "-d", command[0]], check=True,
                                    capture_output=True, text=True).stdout
            self.assertIn(f"[{soname}]", needed)
            done = subprocess.run(command, capture_output=True, text=True,
                                  env={**os.environ, "LD_LIBRARY_PATH": folder})
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.check(done.stdout)


if __name__ == "__main__":
    unittest.main(verbosity=2)
