#!/usr/bin/python3
"""An hour of each user in one sitting: the instructor of a bridge trainer, the
developer of an uncrewed vessel, the scientist. Each goes from one tool to the
next as a person would and prints what was seen; the parts have tests of their
own. (The visitor: page_visitor_test.mjs.)"""
import csv
import hashlib
import io
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import xarray
from PIL import Image
from pymodbus.client import ModbusTcpClient

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from modbus_test import floats
from pelagos_daemon import BIN, ROOT, Daemon, free_port, until

sys.path.insert(0, os.path.join(ROOT, "clients/python"))
sys.dont_write_bytecode = True
import pelagos

CTL = os.path.join(BIN, "pelagosctl")
WINDOWS = {name: (i - 2) * 45 for i, name in enumerate(
    ("port2", "port1", "ahead", "starboard1", "starboard2"))}


def say(text):
    print(f"    {text}", flush=True)


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="pelagos-hour-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def ctl(self, daemon, *words, status=0, **more):
        done = subprocess.run([CTL, "-s", f"tcp:127.0.0.1:{daemon.tcp_port}",
                               *map(str, words)], capture_output=True,
                              text=True, timeout=300, check=False, **more)
        self.assertEqual(done.returncode, status, done.stderr)
        return done.stdout + done.stderr


class Instructor(Case):
    """Five windows, a helmsman's console, an exercise, a rewind, a debrief."""

    TOKENS = {"instruct": "instructor-0123456789", "steer": "helm-0123456789ab",
              "watch": "gallery-0123456789ab"}

    def setUp(self):
        super().setUp()
        tokens = self.folder / "tokens"
        tokens.write_text("".join(f"{t} {role} {role}er\n"
                                  for role, t in self.TOKENS.items()))
        tokens.chmod(0o600)
        for name in "exercises", "recordings":
            (self.folder / name).mkdir()
        shutil.copy(os.path.join(ROOT, "clients/exercises/crossing.json"),
                    self.folder / "exercises")
        self.modbus = free_port()
        self.daemon = Daemon(
            "--token-file", str(tokens),
            f"--exercises={self.folder / 'exercises'}",
            f"--recordings={self.folder / 'recordings'}",
            "--modbus", f"127.0.0.1:{self.modbus}",
            "--modbus-heartbeat", "60000")
        self.addCleanup(self.daemon.stop)

    def ask(self, method, path, body=None, role="instruct", status=200):
        answer = self.daemon.request(method, path, body, headers={
            "Authorization": "Bearer " + self.TOKENS[role],
            "Content-Type": "application/json"}, timeout=300)
        self.assertEqual(answer.status, status, answer)
        return answer

    def state(self):
        return self.ask("GET", "/v1/state").json()

    def exercise(self, action, **more):
        return self.ask("POST", "/v1/exercise",
                        {"action": action, **more}).json()

    def go(self, to):
        while (now := self.state()["clock"]["time"]) < to:
            self.ask("POST", "/v1/clock/step", {"until": min(now + 5, to)})

    def pictures(self):
        """The pixels of the five windows, of one frame."""
        with pelagos.Ocean(self.daemon.url(""),
                           token=self.TOKENS["watch"]) as ocean:
            frames = ocean.frames(list(WINDOWS), "png")
            self.assertEqual(len({(f.number, f.time, f.revision)
                                  for f in frames.values()}), 1)
            return {name: f.image() for name, f in frames.items()}

    def test_an_evening_of_training(self):
        self.ask("PATCH", "/v1/state", {
            "clock": {"mode": "STEPPED"},
            "views": [{"name": name, "entity": 1, "yaw": yaw, "up": 12,
                       "fieldOfView": 45, "width": 192, "height": 144}
                      for name, yaw in WINDOWS.items()]})
        self.ask("POST", "/v1/recording", {"start": "evening"})
        self.exercise("LOAD", name="crossing")
        self.exercise("START")
        self.go(20)
        # The helmsman's own hands, and what they may not do.
        console = ModbusTcpClient("127.0.0.1", port=self.modbus)
        console.connect()
        console.write_register(90, 1)
        console.write_registers(92, floats(10, 0.8))
        self.assertFalse(console.write_register(96, 1).isError())
        self.assertEqual(self.state()["ownShip"]["rudder"], 10)
        for role, body in (("steer", {"sea": {"windSpeed": 20}}),
                           ("watch", {"ownShip": {"rudder": 0}})):
            error = self.ask("PATCH", "/v1/state", body, role, 403).json()
            say(f"{role}: {error['detail']}")
        self.go(50)
        heading = next(e for e in self.state()["entities"] if e["id"] == 1)
        self.assertGreater(heading["heading"], 5)
        clear = self.pictures()
        self.assertEqual(len({p.tobytes() for p in clear.values()}), 5)
        self.go(70)
        fog = self.pictures()
        # Fog of 900 m: the horizon goes into the sky.
        rows = slice(60, 84)
        steps = [float(np.abs(np.diff(p["ahead"][rows].mean(axis=(1, 2)))).max())
                 for p in (clear, fog)]
        say(f"greatest step between rows at the horizon: clear {steps[0]:.1f}, "
            f"fog {steps[1]:.1f} of 255")
        self.assertLess(steps[1], steps[0])
        self.exercise("PAUSE")
        facts = list(csv.DictReader(io.StringIO(
            self.ask("GET", "/v1/exercise.csv").body.decode())))
        say(f"facts: {len(facts)} rows, of {sorted(facts[0])}")
        self.assertGreater(len(facts), 1)
        # Again from 50 s, with the same hands: the same to the bit.
        self.exercise("REWIND", time=50)
        self.exercise("START")
        self.assertEqual(self.state()["clock"]["time"], 50)
        self.go(70)
        for name, picture in self.pictures().items():
            self.assertTrue(np.array_equal(picture, fog[name]), name)
        say("rewound to 50 s and sailed again: five windows the same bits")
        live = self.ask("GET", "/v1/views/ahead/frame.png").body
        self.exercise("STOP")
        self.ask("POST", "/v1/recording", {"stop": True})
        console.close()
        self.debrief(live)

    def debrief(self, live):
        def settled():
            now = self.ask("GET", "/v1/debrief").json()
            self.assertNotIn("error", now)
            return now if not now["busy"] and now["state"] == "OPEN" else None
        self.ask("PATCH", "/v1/debrief", {"recording": "evening"})
        opened = until("the recording is open", settled)
        self.ask("PATCH", "/v1/debrief", {"time": 70})
        until("the debrief stands at 70 s", settled)
        again = self.ask("GET", "/v1/debrief/views/ahead/frame.png").body
        pixels = [np.asarray(Image.open(io.BytesIO(p))) for p in (live, again)]
        self.assertTrue(np.array_equal(*pixels), "the debrief's picture")
        say(f"debrief of {opened['length']:.0f} s: "
            "the picture of 70 s is the live one")


class Developer(Case):
    """Labelled frames by a seed, checked by hand; the water under the hull; an
    environment; all of it once more from a daemon of its own."""

    EARTH_M = 6371008.8
    SCENE = {"sea": {"windSpeed": 7}, "sky": {"sunElevation": 35},
             "views": [{"name": "eye", "up": 6, "pitch": -3, "yaw": 20,
                        "fieldOfView": 50, "width": 320, "height": 180,
                        "level": True}],
             "entities": [
                 {"id": 1, "name": "usv", "latitude": 52.6, "longitude": 5.2},
                 {"id": 5, "name": "mark", "latitude": 52.60108,
                  "longitude": 5.20065, "model": {"name": "cardinal-north"}},
                 {"id": 6, "name": "ferry", "latitude": 52.6046,
                  "longitude": 5.2036, "heading": 80, "course": 80, "speed": 6,
                  "model": {"name": "ferry"}}]}

    def run_once(self, into):
        into.mkdir()
        hashes = []
        with Daemon() as daemon, pelagos.Ocean(daemon.url("")) as ocean:
            ocean.reset(42, self.SCENE)
            for n in range(4):
                ocean.step(0.5)
                for form in ("png", "exr", "json"):
                    frame = (ocean.frame("eye", "exr", layers=("radiance", "depth",
                                                               "id"))
                             if form == "exr" else ocean.frame("eye", form))
                    (into / f"{n}.{form}").write_bytes(frame.data)
                    hashes.append(hashlib.sha256(frame.data).hexdigest())
            heights = ocean.surface([[0, 0], [4, 0], [-4, 0]],
                                    [2.0, 2.5, 3.0]).height
            hashes.append(hashlib.sha256(heights.tobytes()).hexdigest())
            labels = ocean.views["eye"].labels()
        return hashes, labels, heights

    def test_a_day_at_the_perception_desk(self):
        hashes, labels, heights = self.run_once(self.folder / "first")
        again, _, _ = self.run_once(self.folder / "second")
        self.assertEqual(hashes, again)
        say(f"{len(hashes)} files from two daemons: the same bytes")
        self.assertEqual(heights.shape, (3, 3))
        self.assertGreater(np.abs(np.diff(heights, axis=0)).max(), 0)
        # Where a mark stands, by no code of ours: a pinhole, the Earth's radius.
        north = math.radians(52.60108 - 52.6) * self.EARTH_M
        east = (math.radians(5.20065 - 5.2) * self.EARTH_M *
                math.cos(math.radians(52.6)))
        bearing = math.degrees(math.atan2(east, north))
        u = 160 + 160 / math.tan(math.radians(25)) * math.tan(
            math.radians(bearing - 20))
        rows, columns = np.nonzero(labels.mask(5))
        self.assertGreater(len(rows), 8)
        found = columns.mean() + 0.5
        away = float(np.median(labels.depth[labels.mask(5)]))
        range_m = math.hypot(north, east, 6)
        say(f"mark 5: column {found:.1f}, by hand {u:.1f}; {away:.1f} m, by hand "
            f"{range_m:.1f} m")
        self.assertLess(abs(found - u), 1.0)  # it is 2 m wide: 6 pixels
        self.assertLess(abs(away - range_m), 2.5)  # its own size
        self.assertTrue({5, 6} <= {e.id for e in labels.entities})

    def test_an_agent_and_a_data_set(self):
        examples = pathlib.Path(ROOT, "clients/python/examples")
        with Daemon() as daemon:
            env = {**os.environ, "PELAGOS_URL": daemon.url(""),
                   "PYTHONPATH": os.path.join(ROOT, "clients/python")}
            done = subprocess.run(
                ["/usr/bin/python3", "-B", examples / "labelled.py", "--help"],
                env=env, capture_output=True, text=True, check=True)
            self.assertIn("usage", done.stdout)
            out = self.folder / "labelled"
            done = subprocess.run(
                ["/usr/bin/python3", "-B", examples / "labelled.py",
                 "--url", daemon.url(""), "--out", out, "--scenes", "2", "--seed", "3"],
                env=env, capture_output=True, text=True, check=False, timeout=300)
            self.assertEqual(done.returncode, 0, done.stderr)
            coco = json.loads(next(out.rglob("*.json")).read_text())
            for image in coco["images"]:
                with Image.open(next(out.rglob(image["file_name"]))) as picture:
                    self.assertEqual(picture.size,
                                     (image["width"], image["height"]))
            for box in coco["annotations"]:
                x, y, width, height = box["bbox"]
                self.assertTrue(x >= 0 and y >= 0 and width > 0 and height > 0)
            say(f"COCO: {len(coco['images'])} pictures, "
                f"{len(coco['annotations'])} boxes")


class Scientist(Case):
    """Reflectances, spectra, plots and a picture's header, against relations of
    others."""

    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.addClassCleanup(cls.daemon.stop)
        cls.daemon.patch({"clock": {"mode": "STEPPED"}, "views": {
            "bridge": {"width": 160, "height": 90}}})

    def opened(self, path):
        with xarray.open_dataset(path) as d:
            return d.load()

    def test_colour_of_water(self):
        """O'Reilly's OC4 (version 6, SeaWiFS), a regression of measurements: what
        chlorophyll do the ratios of our Rrs have? Measurements scatter about it by
        0.2 in the logarithm, a factor of 1.6; ours, of mean Case 1 waters with the
        Sun 30 degrees from the zenith, may be off by a third more."""
        out = self.folder / "rrs.nc"
        self.ctl(self.daemon, "optics", "water", "--sun-zenith", 30,
                 "--sweep", "chlorophyll=0.1,0.3,1,3", "--sweep",
                 "wavelength=443,490,510,555", "-o", out)
        header = subprocess.run(["ncdump", "-h", out], capture_output=True,
                                text=True, check=True).stdout
        for word in (":Conventions", ":history", "chlorophyll:units",
                     'remoteSensingReflectance:units = "1/sr"'):
            self.assertIn(word, header)
        d = self.opened(out)
        rrs = d.remoteSensingReflectance.transpose("chlorophyll",
                                                   "wavelength").values
        for chlorophyll, r in zip((0.1, 0.3, 1, 3), rrs):
            x = math.log10(max(r[:3]) / r[3])
            by_oc4 = 10 ** (0.3272 - 2.9940 * x + 2.7218 * x ** 2 -
                            1.2259 * x ** 3 - 0.5683 * x ** 4)
            say(f"chlorophyll {chlorophyll} mg/m3: OC4 of our Rrs says "
                f"{by_oc4:.2f}")
            self.assertLess(abs(math.log(by_oc4 / chlorophyll)), math.log(2.2))

    def test_heights_of_the_sea(self):
        """Pierson and Moskowitz: Hs = 0.21 U^2/g of the wind at 19.5 m, which is
        1.026 to 1.08 times that at 10 m."""
        out = self.folder / "hs.csv"
        self.ctl(self.daemon, "spectrum", "sea.spectrum=PIERSON_MOSKOWITZ",
                 "--sweep", "windSpeed=6:15:3", "-o", out)
        rows = list(csv.DictReader(
            line for line in out.read_text(encoding="utf-8").splitlines()
            if not line.startswith("#")))
        self.assertEqual(len(rows), 4)
        for row in rows:
            u = float(row["windSpeed"])
            hs = float(row["spectrum_significantHeight"])
            expected = 0.21 * (1.05 * u) ** 2 / 9.81
            say(f"wind {u:.0f} m/s: Hs {hs:.2f} m, Pierson and Moskowitz "
                f"{expected:.2f} m")
            self.assertLess(abs(hs / expected - 1), 0.1)

    def test_every_plot_opens(self):
        for kind in ("rrs", "brdf", "rose", "height", "rows"):
            for ending in "svg", "png":
                out = self.folder / f"{kind}.{ending}"
                more = ["--seconds", "20"] if kind == "height" else []
                self.ctl(self.daemon, "plot", kind, *more, "-o", out)
                if ending == "svg":
                    out = self.folder / f"{kind}.svg.png"
                    subprocess.run(["rsvg-convert", "-o", out,
                                    self.folder / f"{kind}.svg"], check=True)
                with Image.open(out) as picture:
                    shades = np.asarray(picture.convert("L"))
                self.assertGreater(min(shades.shape), 300, out)
                self.assertGreater(float(shades.std()), 10, out)
        say("five kinds, SVG by librsvg and PNG: opened, none of them empty")

    def test_a_picture_tells_what_it_is(self):
        out = self.folder / "bridge.exr"
        self.ctl(self.daemon, "frame", "bridge", out, "--layers",
                 "radiance,depth,normal")
        header = subprocess.run(["exrheader", out], capture_output=True, text=True,
                                check=True).stdout
        for word in ("significantHeight", "windSpeed", "spectrum", "chlorophyll",
                     "550", "nm", "depth.Z", "worldToCamera"):
            self.assertIn(word, header)


if __name__ == "__main__":
    unittest.main(verbosity=2)
