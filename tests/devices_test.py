#!/usr/bin/python3
"""Several devices draw one frame: two of software stand for two of hardware.

DEVICES: others, as `all`; they must be alike.
"""
import itertools
import os
import subprocess
import sys
import threading
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import BIN, Daemon, Session, until

DEVICES = os.environ.get("DEVICES", "software,software")
ONE = DEVICES.split(",", maxsplit=1)[0].replace("all", "auto")
# Each loss makes programs anew: seconds on a machine that does other things too.
PROGRAMS_S = 300
SIZES = (192, 108), (96, 64), (160, 96), (64, 36), (128, 72)
SCENE = {
    "clock": {"mode": "STEPPED", "time": 0},
    "sea": {"windSpeed": 9, "synthesiser": "FFT"},
    "sky": {"sunElevation": 30, "sunAzimuth": 40},
    "entities": {"3": {"latitude": 52.6012, "longitude": 5.2001,
                       "afloat": True, "wake": True, "wash": True, "speed": 5,
                       "poseTime": 0, "model": {"name": "tug"}}},
    "views": {"bridge": {"width": 192, "height": 108, "up": 9},
              "chart": {"entity": 1, "width": 2048, "height": 1536, "up": 9},
              **{f"w{i}": {"entity": 1, "width": w, "height": h,
                           "yaw": 40 * i - 80, "up": 9}
                 for i, (w, h) in enumerate(SIZES)}},
}
WINDOWS = [f"w{i}" for i in range(len(SIZES))]


def start(devices=DEVICES, lose=0, only=-1, for_good=False):
    losing = {"PELAGOS_GL_LOSE": str(lose),
              "PELAGOS_GL_LOSE_DEVICE": str(only),
              "PELAGOS_GL_LOSE_FOR_GOOD": "yes" if for_good else "no"}
    os.environ.update(losing)
    try:
        daemon = Daemon("--device", devices, unix=True)
    finally:
        for name in losing:
            del os.environ[name]
    answer = daemon.patch(SCENE)
    assert answer.status == 200, answer
    return daemon


def of_device(daemon, name, device):
    return daemon.metrics()[f'pelagos_device_{name}{{device="{device}"}}']


class Devices(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.one = start(ONE)

    @classmethod
    def tearDownClass(cls):
        cls.one.stop()

    def frames(self, daemon, time_s, views=WINDOWS):
        """Pictures of one frame, PNG."""
        with Session(daemon.connect_unix(PROGRAMS_S)) as session:
            reply = session.ask(frames={
                "time": time_s, "frames": [
                    {"view": view, "format": "PNG"} for view in views]})
        frames = list(reply.frames.frames)
        self.assertEqual(len(frames), len(views), reply)
        self.assertEqual(len({(f.number, f.time, f.revision)
                              for f in frames}), 1)
        return frames

    def same(self, daemon, time_s, views=WINDOWS):
        frames = self.frames(daemon, time_s, views)
        self.assertEqual([f.data for f in frames],
                         [f.data for f in self.frames(self.one, time_s, views)])
        return frames

    def test_one_frame_one_sea(self):
        """Every picture is that of one device, and both draw."""
        with start() as daemon:
            drew = set()
            for t in range(6):
                drew |= {f.device for f in self.same(daemon, t)}
            self.assertEqual(drew, {0, 1})
            layers = "/v1/views/bridge/frame.exr?layers=depth,id,normal&time=3"
            self.assertEqual(daemon.get(layers, timeout=PROGRAMS_S).body,
                             self.one.get(layers, timeout=PROGRAMS_S).body)
            for device in (0, 1):
                self.assertGreater(of_device(daemon, "views_total", device), 5)
                self.assertEqual(of_device(daemon, "standing", device), 1)

    def test_pictures_asked_for_alone_are_spread(self):
        with start() as daemon:
            devices, lock = set(), threading.Lock()
            times = itertools.count()

            def ask():
                with Session(daemon.connect_unix(PROGRAMS_S)) as session:
                    for _ in range(10):
                        with lock:
                            t = next(times)
                        f = session.ask(frame={
                            "view": "w2", "time": t}).frame
                        with lock:
                            devices.add(f.device)

            threads = [threading.Thread(target=ask) for _ in range(4)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            self.assertEqual(devices, {0, 1})

    def test_a_lost_device_leaves_its_views(self):
        """It is lost three times, and then not used any more; no picture is
        lost or changed by it, large ones and numbers of light neither."""
        with start(lose=4, only=1) as daemon:
            sky = "/v1/optics/sky?from=GPU"
            wanted = self.one.get(sky, timeout=PROGRAMS_S).json()["sky"]
            times = itertools.count()
            while daemon.metrics()["pelagos_device_losses_total"] < 3:
                t = next(times)
                self.assertLess(t, 200, "device 1 is not lost")
                self.same(daemon, t)
                if t % 4 == 1:
                    self.same(daemon, t, ["chart", "w0"])
                    self.assertEqual(
                        daemon.get(sky, timeout=PROGRAMS_S).json()["sky"],
                        wanted)
            until("device 1 is out",
                  lambda: of_device(daemon, "standing", 1) == 0)
            self.assertEqual(of_device(daemon, "standing", 0), 1)
            for _ in range(3):
                self.assertEqual({f.device for f in
                                  self.same(daemon, next(times))}, {0})
            self.assertEqual(daemon.metrics()["pelagos_device_fallen_back"], 0)
            self.assertIn("FRM-012", daemon.log())

    def test_a_withdrawn_device_leaves_its_views(self):
        """It cannot be had again: the other draws, the same pictures."""
        with start(lose=4, only=1, for_good=True) as daemon:
            times = itertools.count()
            while daemon.metrics()["pelagos_device_losses_total"] < 1:
                t = next(times)
                self.assertLess(t, 200, "device 1 is not lost")
                self.same(daemon, t)
            end = time.monotonic() + 3
            while time.monotonic() < end:
                self.assertEqual({f.device for f in
                                  self.same(daemon, next(times))}, {0})
                self.assertEqual(of_device(daemon, "standing", 1), 0)
            metrics = daemon.metrics()
            self.assertEqual(metrics["pelagos_device_losses_total"], 1)
            self.assertEqual(metrics["pelagos_device_fallen_back"], 0)

    def test_live_views_go_on_without_it(self):
        with start(lose=12, only=0) as daemon:
            daemon.patch({"clock": {"mode": "FREE"}})
            worst, last, numbers = 0.0, time.monotonic(), []
            with Session(daemon.connect_unix(PROGRAMS_S)) as session:
                while daemon.metrics()["pelagos_device_losses_total"] < 3:
                    reply = session.ask(frames={
                        "frames": [{"view": w} for w in WINDOWS]})
                    self.assertEqual(len(reply.frames.frames), len(WINDOWS))
                    numbers.append(reply.frames.frames[0].number)
                    now = time.monotonic()
                    worst, last = max(worst, now - last), now
            self.assertEqual(numbers, sorted(numbers))
            print(f"{len(numbers)} frames of five views while a device was "
                  f"lost three times: {1e3 * worst:.0f} ms between two at most")

    def test_bench_tells_each(self):
        with start() as daemon:
            # What a device took while it made its programs keeps it idle for
            # some tens of frames.
            until("both draw a frame", lambda: {
                f.device for f in self.frames(daemon, 0)} == {0, 1}, PROGRAMS_S)
            out = subprocess.run(
                [f"{BIN}/pelagosctl", "--server", f"unix:{daemon.unix_path}",
                 "bench", "--views", "w0,w1,w2,w3", "--sizes", "96x64",
                 "--seconds", "3", "--json"], capture_output=True, text=True,
                check=True, timeout=PROGRAMS_S).stdout
            self.assertIn('"device":0', out)
            self.assertIn('"device":1', out)

    def test_lists_that_are_none(self):
        for text, says in (("software,", "--device: 'software,'"),
                           ("0,,1", "--device: '0,,1'"),
                           ("both", "--device: 'both'"),
                           (",".join(["software"] * 17), "at most 16"),
                           ("software,998", "device 998")):
            done = subprocess.run(
                [f"{BIN}/pelagosd", "--device", text, "--http", "off"],
                capture_output=True, text=True, check=False,
                timeout=PROGRAMS_S)
            self.assertNotEqual(done.returncode, 0, text)
            self.assertIn(says, done.stderr + done.stdout)


if __name__ == "__main__":
    unittest.main(verbosity=2)
