#!/usr/bin/python3
"""Players that we did not write: OpenCV, mpv and VLC, over RTSP (UDP and TCP),
MPEG-TS and Motion-JPEG. `make players` installs them; one that is not there is
passed over, and said.

What they show is compared with the daemon's own picture of a sea that stands.
"""
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

import numpy
from PIL import Image

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import Daemon

WIDTH, HEIGHT = 320, 180
SLOW_S = 60.0

OPENCV = """
import cv2, numpy, sys, time
begun = time.monotonic()
capture = cv2.VideoCapture(sys.argv[1], cv2.CAP_FFMPEG)
for i in range(30):
    good, picture = capture.read()
    assert good, f"{i} pictures"
    if i == 0:
        print(f"{time.monotonic() - begun:.2f}")
cv2.imwrite(sys.argv[2], picture)
"""


def opencv():
    return subprocess.run([sys.executable, "-c", "import cv2"],
                          capture_output=True).returncode == 0


class Players(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="pelagos-players-")
        os.chmod(cls.folder, 0o777)  # VLC does not run as root
        cls.daemon = Daemon("--rtsp", "127.0.0.1:0", "--quality", "full")
        # Streams go on while time runs, so slowly that nothing moves.
        cls.daemon.patch({
            "clock": {"rate": 1e-9}, "views": [
                {"name": "bridge", "entity": 1, "width": WIDTH,
                 "height": HEIGHT}]})
        port = re.search(r"NET-006 .*:(\d+)/VIEW", cls.daemon.log()).group(1)
        cls.urls = {"RTSP": f"rtsp://127.0.0.1:{port}/bridge",
                    "MPEG-TS": cls.daemon.url("/v1/views/bridge/ts"),
                    "Motion-JPEG": cls.daemon.url("/v1/views/bridge/mjpeg")}
        path = os.path.join(cls.folder, "still.png")
        with open(path, "wb") as f:
            f.write(cls.daemon.get("/v1/views/bridge/frame.png").body)
        cls.still = cls.pixels(path)

    @classmethod
    def tearDownClass(cls):
        status = cls.daemon.stop()
        shutil.rmtree(cls.folder)
        assert status == 0, f"the daemon ended with {status}"

    @staticmethod
    def pixels(path, size=None):
        picture = Image.open(path).convert("RGB")
        return numpy.asarray(picture.resize(size) if size else picture,
                             numpy.float64)

    def looks_right(self, path, what, size=None):
        shown = self.pixels(path, size)
        self.assertEqual(shown.shape, (HEIGHT, WIDTH, 3))
        # H.264 of 300 kbit/s blurs the glitter by some levels; BT.709 taken
        # for BT.601, or full range for studio's, is 8 and more, another
        # picture tens.
        off = abs(shown - self.still).mean()
        print(f"{what}: off by {off:.1f} of 255")
        self.assertLess(off, 7)

    def fresh(self):
        return tempfile.mkdtemp(dir=self.folder)

    @unittest.skipUnless(opencv(), "no python3-opencv")
    def test_opencv(self):
        for way, url in [("RTSP", "udp"), ("RTSP", "tcp"), ("MPEG-TS", ""),
                         ("Motion-JPEG", "")]:
            transport, url = url, self.urls[way]
            path = os.path.join(self.fresh(), "last.png")
            environment = dict(os.environ)
            if transport:
                environment["OPENCV_FFMPEG_CAPTURE_OPTIONS"] = (
                    f"rtsp_transport;{transport}|fflags;nobuffer|"
                    "flags;low_delay|probesize;32|analyzeduration;0")
            done = subprocess.run([sys.executable, "-c", OPENCV, url, path],
                                  capture_output=True, text=True,
                                  timeout=SLOW_S, env=environment)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.looks_right(path, f"OpenCV, {way} {transport}, first picture "
                                   f"after {done.stdout.strip()} s")

    @unittest.skipUnless(shutil.which("mpv"), "no mpv")
    def test_mpv(self):
        for way, url in self.urls.items():
            folder = self.fresh()
            done = subprocess.run(
                ["mpv", "--no-config", "--really-quiet", "--vo=image",
                 "--vo-image-format=png", f"--vo-image-outdir={folder}",
                 "--ao=null", "--frames=30", url], capture_output=True,
                text=True, timeout=SLOW_S)
            shown = sorted(glob.glob(folder + "/*.png"))
            self.assertEqual(len(shown), 30, done.stderr)
            self.looks_right(shown[-1], f"mpv, {way}")

    @unittest.skipUnless(shutil.which("cvlc"), "no vlc-bin")
    def test_vlc(self):
        """Debian's VLC has no RTSP."""
        for way in "MPEG-TS", "Motion-JPEG":
            folder = self.fresh()
            os.chmod(folder, 0o777)
            user = (["runuser", "-u", "nobody", "--"] if os.geteuid() == 0
                    else [])
            player = subprocess.Popen(
                [*user, "env", f"HOME={folder}", "cvlc", "-I", "dummy",
                 "--no-audio", "--vout", "dummy", "--video-filter", "scene",
                 "--scene-ratio", "5", "--scene-format", "png",
                 "--scene-path", folder, self.urls[way]],
                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                start_new_session=True)
            try:
                end = time.monotonic() + SLOW_S
                shown = []
                while len(shown) < 8:
                    self.assertLess(time.monotonic(), end, way)
                    self.assertIsNone(player.poll(), way)
                    time.sleep(0.2)
                    shown = sorted(glob.glob(folder + "/*.png"))
            finally:
                os.killpg(player.pid, 15)
                player.wait()
            # The last may be half there; its filter stretches what it saves to
            # the rows of its memory, 14 more.
            self.looks_right(shown[-2], f"VLC, {way}", (WIDTH, HEIGHT))


if __name__ == "__main__":
    unittest.main(verbosity=2)
