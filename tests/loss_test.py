#!/usr/bin/python3
"""The graphics device is lost again and again (PELAGOS_GL_LOSE): clients get
every picture, each the one that a device which stays would draw.

LOSSES: how many, for `make soak`, within LOSS_SECONDS; LOSS_EVERY: pictures
from one to the next; LOSS_DEVICE: another device than the software one.
"""
import os
import statistics
import sys
import threading
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import Daemon, Session

LOSSES = int(os.environ.get("LOSSES", "6"))
SECONDS = float(os.environ.get("LOSS_SECONDS", "inf"))
DEVICE = os.environ.get("LOSS_DEVICE", "software")
EVERY = int(os.environ.get("LOSS_EVERY", "7"))
# Each loss makes programs anew: seconds on a machine that does other things too.
PROGRAMS_S = 300
SCENE = {
    "clock": {"mode": "STEPPED", "time": 0},
    "sea": {"windSpeed": 9, "synthesiser": "FFT"},
    "sky": {"sunElevation": 30, "sunAzimuth": 40},
    "entities": {"3": {"latitude": 52.6012, "longitude": 5.2001,
                       "afloat": True, "wake": True, "speed": 5,
                       "poseTime": 0,
                       "model": {"name": "tug"}}},
    "views": {"bridge": {"width": 192, "height": 108, "up": 9},
              "wing": {"entity": 1, "width": 96, "height": 64, "yaw": -40,
                       "up": 9},
              "chart": {"entity": 1, "width": 2048, "height": 1536, "up": 9}},
}
LAYERS = "depth,id,radiance"
# Rounds of EVERY pictures until each kind was drawn and each table made.
WARM = 50


def start(lose=None):
    os.environ["PELAGOS_GL_LOSE"] = str(lose or 0)
    try:
        daemon = Daemon("--device", DEVICE, unix=True)
    finally:
        del os.environ["PELAGOS_GL_LOSE"]
    answer = daemon.patch(SCENE)
    assert answer.status == 200, answer
    return daemon


def heap(daemon):
    return daemon.metrics().get("process_heap_bytes", 0)


def losses(daemon):
    return daemon.metrics()["pelagos_device_losses_total"]


class Loss(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.steady = start()

    @classmethod
    def tearDownClass(cls):
        cls.steady.stop()

    def same(self, daemon, time_s, path):
        """The same bytes from both; how long the one that loses took."""
        begun = time.monotonic()
        got = daemon.get(f"{path}time={time_s}", timeout=PROGRAMS_S)
        took = time.monotonic() - begun
        self.assertEqual(got.status, 200, got)
        self.assertEqual(got.body, self.steady.get(
            f"{path}time={time_s}", timeout=PROGRAMS_S).body, (path, time_s))
        return took

    def test_pictures_are_the_same(self):
        with start(EVERY) as daemon:
            took, before, end = [], 0, time.monotonic() + SECONDS
            while losses(daemon) < LOSSES and time.monotonic() < end:
                t = len(took) % 50
                path = (f"/v1/views/bridge/frame.exr?layers={LAYERS}&"
                        if t % 5 == 4 else "/v1/views/wing/frame.png?")
                took.append(self.same(daemon, t, path))
                if not before and len(took) >= WARM * EVERY:
                    before = heap(daemon)
                    counted = losses(daemon)
            m = daemon.metrics()
            count = m["pelagos_device_losses_total"]
            hit = sorted(took)[-int(count):]
            self.assertGreaterEqual(m["pelagos_device_views_again_total"],
                                    count)
            self.assertEqual(m["pelagos_device_fallen_back"], 0)
            print(f"{count:.0f} losses in {len(took)} pictures: median "
                  f"{1e3 * statistics.median(took):.0f} ms, with a loss "
                  f"{1e3 * statistics.median(hit):.0f}, p99 "
                  f"{1e3 * hit[int(0.99 * len(hit))]:.0f} (bar 250), worst "
                  f"{1e3 * hit[-1]:.0f}; a renderer stood again in "
                  f"{1e3 * m['pelagos_device_loss_worst_seconds']:.0f} ms at "
                  "worst")
            if before and count > counted:
                each = (heap(daemon) - before) / (count - counted)
                print(f"{each / 1e3:.1f} kB of heap each after the first "
                      f"{counted:.0f} (bar 4)")

    def test_large_pictures_begin_anew(self):
        """Lost in the middle of the bands, or after the last."""
        with start(3) as daemon:
            for t in range(4):
                self.same(daemon, t, "/v1/views/chart/frame.png?")
                self.same(daemon, t, "/v1/views/wing/frame.png?")
            self.assertGreater(losses(daemon), 1)

    def test_sets_and_streams_go_on(self):
        """Frames of a set are one moment; live pictures come in order."""
        with start(EVERY) as daemon:
            daemon.patch({"clock": {"mode": "FREE"}})
            seen, stop = [], threading.Event()

            def watch():
                with Session(daemon.connect_unix()) as session:
                    while not stop.is_set():
                        reply = session.ask(frame={"view": "wing"})
                        seen.append((reply.frame.number, len(reply.frame.data)))

            thread = threading.Thread(target=watch)
            thread.start()
            try:
                begun = losses(daemon)
                while losses(daemon) < begun + min(LOSSES, 20):
                    with Session(daemon.connect_unix()) as session:
                        reply = session.ask(frames={
                            "frames": [{"view": "bridge"}, {"view": "wing"}]})
                        frames = reply.frames.frames
                        self.assertEqual(len(frames), 2)
                        self.assertEqual(len({f.time for f in frames}), 1)
            finally:
                stop.set()
                thread.join()
            self.assertTrue(all(size > 0 for _, size in seen))
            numbers = [number for number, _ in seen]
            self.assertEqual(numbers, sorted(numbers))

    def test_optics_are_answered(self):
        with start(2) as daemon:
            path = "/v1/optics/sky?from=GPU"
            wanted = self.steady.get(path)
            self.assertEqual(wanted.status, 200, wanted)
            for t in range(4):
                self.same(daemon, t, "/v1/views/wing/frame.png?")
                self.assertEqual(daemon.get(path).json()["sky"],
                                 wanted.json()["sky"])
            self.assertGreater(losses(daemon), 1)

    def test_a_device_that_does_not_hold(self):
        """Not one picture comes: that is said, and the daemon stays."""
        with start(1) as daemon:
            answer = daemon.get("/v1/views/wing/frame.png?time=1", timeout=PROGRAMS_S)
            self.assertGreaterEqual(answer.status, 500, answer)
            self.assertIn("device", answer.json()["detail"])
            self.assertEqual(daemon.get("/healthz").status, 200)


if __name__ == "__main__":
    unittest.main(verbosity=2)
