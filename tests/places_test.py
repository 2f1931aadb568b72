#!/usr/bin/python3
"""Cameras anywhere on Earth, end to end: what is drawn there is what is
queried, under the Sun of the place; orbits, satellites and ways are functions of
time; ships sail over the pole and the date line."""
import glob
import json
import math
import os
import signal
import subprocess
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import BIN, ROOT, Daemon  # noqa: E402

sys.path.insert(0, os.path.join(ROOT, "clients", "python"))
sys.dont_write_bytecode = True
import pelagos  # noqa: E402

UTC = "2026-06-21T20:00:00Z"
HOME = {"latitude": 52.6, "longitude": 5.2}
CLOCK = {"mode": "STEPPED", "time": 10, "utc": UTC}


def place(latitude, longitude, height=4):
    return {"latitude": latitude, "longitude": longitude, "height": height}


def png(daemon, view, time):
    answer = daemon.get(f"/v1/views/{view}/frame.png?time={time}")
    assert answer.status == 200, answer.body
    return answer.body


class Places(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.addClassCleanup(cls.daemon.stop)
        cls.ocean = pelagos.Ocean(cls.daemon.url(""), timeout=600)
        cls.addClassCleanup(cls.ocean.close)

    def patch(self, change):
        answer = self.daemon.patch(change)
        self.assertEqual(answer.status, 200, answer.body)

    def scene(self, views, origin=None, **more):
        """These views alone; the scene is otherwise the default one."""
        entities = more.pop("entities", [{"id": 1}])
        self.patch({"views": [], "entities": entities})
        self.patch({"clock": more.pop("clock", CLOCK),
                    "origin": origin or HOME, "views": views,
                    "sea": {"windSpeed": 8, "windDirection": 20, "seed": 3, "swell": [],
                            "synthesiser": "FFT", **more.pop("sea", {})},
                    **more})

    def exr(self, view, *layers, time=10.0):
        return self.ocean.frame(view, "exr", layers=layers, float_samples=True,
                                time=time).exr()

    # --- where waves are ------------------------------------------------------

    def test_drawn_is_queried(self):
        """Within 12 m: pixels of up to 2 cm, of which a twentieth is what the
        filter of positions leaves out; and positions are floats about a
        multiple of 131 km, good to 4 mm along slopes of a tenth."""
        cases = [
            (HOME, (53.3, 6.2)), (HOME, (85, 40)), (HOME, (10, 180)),
            (HOME, (60, -5)), ((0, 179.9), (0.3, -179.9)),
            ((85, 0), (85.01, 1)), ((89.9, 0), (89.95, 180)),
            ((90, 0), (89.99, 77)), ((10, 180), (10.01, -179.99))]
        for synthesiser in ("TROCHOIDS", "FFT"):
            for origin, (latitude, longitude) in cases:
                if isinstance(origin, tuple):
                    origin = {"latitude": origin[0], "longitude": origin[1]}
                self.scene([{"name": "v", "width": 640, "height": 360,
                             "pitch": -15, "fieldOfView": 50,
                             "at": place(latitude, longitude)}], origin,
                           sea={"synthesiser": synthesiser, "swell": [
                               {"height": 2, "period": 12, "direction": 0,
                                "spread": 5}]})
                picture = self.exr("v", "depth", "position")
                depth = np.asarray(picture["depth"]).reshape(-1)
                points = np.asarray(picture["position"],
                                    dtype=float).reshape(-1, 3)
                near = np.flatnonzero(depth < 12)
                points = points[near[::max(1, len(near) // 900)]]
                self.assertGreater(len(points), 300)
                asked = self.daemon.request("POST", "/v1/surface", {
                    "points": [[e, n] for e, n, _ in points], "time": 10.0})
                self.assertEqual(asked.status, 200, asked.body)
                height = [p.get("height", 0) for p in asked.json()["points"]]
                off = 1e3 * np.abs(points[:, 2] - height)
                print(f"  {synthesiser} {origin} at {latitude} {longitude}: "
                      f"median {np.median(off):.2f} mm, 99 in 100 within "
                      f"{np.percentile(off, 99):.2f}")
                self.assertLess(np.percentile(off, 99), 1)

    def test_near_the_origin_nothing_changes(self):
        """A view at the origin by its place has the bits of one without."""
        self.scene([{"name": "v", "width": 160, "height": 90, "up": 6}])
        plain = self.exr("v", "radiance", "depth")
        self.patch({"views": {"v": {"at": place(52.6, 5.2, 6)}}})
        placed = self.exr("v", "radiance", "depth")
        for layer in ("radiance", "depth"):
            self.assertTrue(np.array_equal(plain[layer], placed[layer],
                                           equal_nan=True), layer)

    # --- light ----------------------------------------------------------------

    SPOTS = {"hawaii": (20.5, -157), "tromso": (70.5, 18), "pole": (89, 0),
             "line": (0, 180)}

    def test_the_sun_of_the_place(self):
        """In the numbers and in the picture: as with the origin there, whose
        Sun place_test holds against libnova. One view at a time, and all of one
        job, are the same."""
        there = {}
        for name, (latitude, longitude) in self.SPOTS.items():
            self.scene([{"name": name, "width": 64, "height": 36}],
                       {"latitude": latitude, "longitude": longitude})
            notes = self.exr(name, "depth").attributes
            there[name] = (notes["pelagos.sunAzimuth"],
                           notes["pelagos.sunElevation"])
        self.scene([
            {"name": name, "width": 160, "height": 120, "fieldOfView": 8,
             "yaw": (there[name][0] + 180) % 360 - 180,
             "pitch": there[name][1], "at": place(*self.SPOTS[name])}
            for name in self.SPOTS])
        alone = {}
        for name, (azimuth, elevation) in there.items():
            picture = self.exr(name, "radiance")
            notes = picture.attributes
            cosine = math.cos(math.radians(elevation))
            turned = (notes["pelagos.sunAzimuth"] - azimuth + 180) % 360 - 180
            off = math.hypot(turned * cosine,
                             notes["pelagos.sunElevation"] - elevation)
            print(f"  {name}: Sun {azimuth:.2f}, {elevation:.2f}, off {off:.4f}"
                  " deg")
            self.assertLess(off, 0.01)
            # The disc lies in the middle; its tables go by 0.005 deg.
            green = np.asarray(picture["radiance"])[..., 1]
            rows, columns = np.nonzero(green > 0.5 * green.max())
            self.assertAlmostEqual(rows.mean(), 59.5, delta=1)
            self.assertAlmostEqual(columns.mean(), 79.5, delta=1)
            alone[name] = png(self.daemon, name, 10)
        answer = self.daemon.get("/v1/frames.png?views="
                                 + ",".join(self.SPOTS) + "&time=10")
        for name, picture in alone.items():
            self.assertIn(picture, answer.body, name)

    def test_the_night_of_the_place(self):
        """Stars, Moon and airglow off Hawaii as with the origin there."""
        sky = []
        for origin in ({"latitude": 20.5, "longitude": -157}, HOME):
            self.scene([{"name": "v", "width": 240, "height": 160, "pitch": 35,
                         "fieldOfView": 70, "yaw": 140,
                         "at": place(20.5, -157)}], origin,
                       clock={**CLOCK, "utc": "2026-06-22T08:30:00Z"},
                       sky={"stars": True})
            sky.append(np.asarray(self.exr("v", "radiance")["radiance"])[:90])
        a, b = sky
        self.assertLess(a.mean(), 1e-3)  # by night, with the Moon
        self.assertGreater(a.max() / np.median(a), 20)
        off = np.abs(a - b) / a.mean()
        bright = [set(np.argsort(x[..., 1], axis=None)[-12:]) for x in sky]
        print(f"  night: {np.percentile(off, 99):.3f} of the mean apart in 99 "
              f"of 100 pixels, {len(bright[0] & bright[1])} of the 12 "
              "brightest are the same")
        # The Milky Way is kept on a grid of some degrees about the eye, which
        # is turned; stars are where they are.
        self.assertLess(np.percentile(off, 99), 0.1)
        self.assertGreaterEqual(len(bright[0] & bright[1]), 10)

    def test_far_views_see_what_is_beside_them(self):
        """A buoy 60 m off, 1,000 km and more from the origin: where it is with
        the origin there, upright."""
        for latitude, longitude in ((61.4, 4), (10, -40), (-50, -172)):
            boxes = []
            for origin in ({"latitude": latitude, "longitude": longitude}, HOME):
                self.scene([{
                    "name": "v", "width": 320, "height": 180, "fieldOfView": 30,
                    "at": place(latitude, longitude, 3),
                    "lookAt": {"entity": 7}}], origin, sea={"windSpeed": 0},
                    entities=[{"id": 7, "heading": 0, "model": {
                        "name": "lateral-port-a"},
                        "latitude": latitude + 60 / 111e3,
                        "longitude": longitude + 1e-5}])
                truth = self.daemon.get("/v1/views/v/frame.json?time=10").json()
                seen = [e for e in truth["entities"] if e["id"] == 7]
                self.assertEqual(len(seen), 1, truth)
                boxes.append([seen[0]["visible"][k] for k in (
                    "x", "y", "width", "height")] + [
                    seen[0]["bearing"] % 360, seen[0]["distance"]])
            a, b = np.array(boxes)
            turned = (a[4] - b[4] + 180) % 360 - 180
            print(f"  {latitude} {longitude}: boxes {a[:4]} {b[:4]}, bearing "
                  f"{turned:.3f} deg, distance {a[5] - b[5]:.3f} m apart")
            self.assertLessEqual(np.abs(a[:4] - b[:4]).max(), 1)
            # The map alone would do to 0.12 deg at 1,000 km.
            self.assertLess(abs(turned), 0.13)
            self.assertLess(abs(a[5] - b[5]), 0.3)

    # --- ships ----------------------------------------------------------------

    def sail(self, latitude, longitude, course, origin):
        """Where a ship of 10 m/s is in 200 s, edited on the way."""
        self.scene([{"name": "v", "width": 64, "height": 48,
                     "orbit": {"entity": 1, "period": 90}}], origin,
                   sea={"windSpeed": 0},
                   entities=[{"id": 1, "latitude": latitude,
                              "longitude": longitude, "course": course,
                              "heading": course, "speed": 10, "poseTime": 10,
                              "wake": True, "model": {"name": "tanker",
                                                      "length": 100}}])
        way = []
        for step in range(20):
            time = 20 + 10 * step
            self.patch({"clock": {"time": time}} if step < 0 else {})
            self.assertEqual(self.daemon.request(
                "POST", "/v1/clock/step", {"until": time}).status, 200)
            if step % 5 == 4:
                self.patch({"entities": {"1": {"speed": 10}}})
            entity = self.daemon.state()["entities"][0]
            if step % 5 == 4:
                la, lo = (math.radians(entity[k]) for k in ("latitude",
                                                            "longitude"))
                way.append([math.cos(la) * math.cos(lo),
                            math.cos(la) * math.sin(lo), math.sin(la)])
            png(self.daemon, "v", time)
        return np.array(way), self.daemon.state()["entities"][0]

    def test_ships_cross_pole_and_date_line(self):
        for latitude, longitude, course, origin, end in (
                (89.991, 30, 0, {"latitude": 90, "longitude": 0}, -150),
                (89.991, 30, 0, {"latitude": 89.9, "longitude": -60}, -150),
                (10, 179.991, 90, {"latitude": 10, "longitude": 180}, None)):
            way, entity = self.sail(latitude, longitude, course, origin)
            steps = np.linalg.norm(np.diff(way, axis=0), axis=1) * 6.38e6
            self.assertTrue(np.all(np.abs(steps - 500) < 5), steps)
            turned = np.diff(way, axis=0)
            straight = np.dot(turned[0], turned[-1]) / np.prod(
                np.linalg.norm(turned[[0, -1]], axis=1))
            self.assertGreater(straight, 0.999999)
            if end is not None:
                self.assertAlmostEqual(entity["longitude"], end, delta=0.5)
                self.assertAlmostEqual(entity["course"], 180, delta=0.5)
            else:
                self.assertLess(entity["longitude"], -179.98)
            # Its wake lies behind it, on this side and on the other.
            east, north = self.local(entity)
            ahead = math.radians(self.course(entity))
            line = [(east - r * math.sin(ahead), north - r * math.cos(ahead))
                    for r in np.arange(100, 1800, 3.0)]
            height = np.asarray(self.ocean.surface(
                line, time=self.daemon.state()["clock"]["time"]).height)
            for part in np.array_split(height, 3)[:2]:
                self.assertGreater(np.ptp(part), 0.05)

    def course(self, entity):
        """In the picture's truth, of the map: over two moments."""
        a = self.local(entity)
        ahead = {**entity, **pelagos_ahead(entity, 100)}
        b = self.local(ahead)
        return math.degrees(math.atan2(b[0] - a[0], b[1] - a[1]))

    def local(self, entity):
        """By the daemon: where a camera at the entity's place stands."""
        self.patch({"views": [{"name": "q", "width": 16, "height": 16,
                               "at": place(entity["latitude"],
                                           entity["longitude"])}]})
        notes = self.exr("q", "depth").attributes
        return notes["pelagos.east"], notes["pelagos.north"]

    # --- errors ---------------------------------------------------------------

    def test_refusals_say_what_to_do(self):
        self.scene([{"name": "v", "entity": 1}])
        before = self.daemon.state()["views"]
        for change, path, words in (
                ({"at": place(1, 2)}, "views.v.at", "remove views.v.entity"),
                ({"entity": None, "at": {"latitude": 3}}, "views.v.at",
                 "both latitude and longitude"),
                ({"entity": None, "waypoints": [
                    {"latitude": 1, "longitude": 2, "time": 5},
                    {"latitude": 1, "longitude": 2, "time": 4}]},
                 "views.v.waypoints.1.time", "later"),
                ({"lookAt": {"entity": 99}}, "views.v.lookAt.entity",
                 "not there")):
            answer = self.daemon.patch({"views": {"v": change}})
            self.assertIn(answer.status, (400, 409), answer.body)
            self.assertEqual(answer.json()["path"], path)
            self.assertIn(words, answer.json()["detail"])
        self.assertEqual(self.daemon.state()["views"], before)


def pelagos_ahead(entity, metres):
    """On a sphere: good enough for a direction."""
    la, lo, c = (math.radians(entity[k]) for k in ("latitude", "longitude",
                                                   "course"))
    d = metres / 6.37e6
    north = math.asin(math.sin(la) * math.cos(d)
                      + math.cos(la) * math.sin(d) * math.cos(c))
    east = lo + math.atan2(math.sin(c) * math.sin(d) * math.cos(la),
                           math.cos(d) - math.sin(la) * math.sin(north))
    return {"latitude": math.degrees(north),
            "longitude": (math.degrees(east) + 180) % 360 - 180}


VIEWS = [
    {"name": "orbit", "width": 96, "height": 54, "orbit": {
        "entity": 1, "radius": 90, "elevation": 10, "period": 33}},
    {"name": "satellite", "width": 96, "height": 54, "pitch": -60, "satellite": {
        "inclination": 75, "node": 20, "phase": 40}},
    {"name": "way", "width": 96, "height": 54, "waypoints": [
        {"time": 0, **place(-17, 179.9, 2), "pitch": 0},
        {"time": 40, **place(-17, -179.9, 4e5), "pitch": -45}]}]
TIMES = (3, 21.5, 39, 60)


class Moments(unittest.TestCase):
    """Pictures of moving cameras: any order, after a restart, in a replay."""

    def start(self, *options):
        daemon = Daemon(*options)
        self.addCleanup(daemon.stop)
        return daemon

    def prepare(self, daemon):
        daemon.patch({"clock": {"mode": "STEPPED", "time": 0, "utc": UTC},
                      "entities": {"1": {"speed": 8, "course": 70, "model": {
                          "name": "motor-yacht"}}}})
        answer = daemon.patch({"views": VIEWS})
        self.assertEqual(answer.status, 200, answer.body)

    def pictures(self, daemon, order):
        return {(v, t): png(daemon, v, t) for v, t in order}

    def test_any_order_and_a_restart(self):
        order = [(v["name"], t) for v in VIEWS for t in TIMES]
        with tempfile.TemporaryDirectory() as folder:
            state = os.path.join(folder, "state.json")
            daemon = self.start("--state", state)
            self.prepare(daemon)
            first = self.pictures(daemon, order)
            self.assertEqual(self.pictures(daemon, order[::-1]), first)
            daemon.stop(signal.SIGKILL)
            again = self.start("--state", state)
            self.assertEqual(self.pictures(again, order[1::2] + order[::2]),
                             first)
            self.assertEqual(len(set(first.values())), len(order))

    def test_a_replay(self):
        with tempfile.TemporaryDirectory() as folder:
            log = os.path.join(folder, "a.pelog")
            daemon = self.start("--record", log)
            self.prepare(daemon)
            want = {}
            for time in TIMES:
                daemon.request("POST", "/v1/clock/step", {"until": time})
                want[time] = png(daemon, "way", time)
            daemon.stop()
            other = self.start()
            out = os.path.join(folder, "out")
            os.mkdir(out)
            self.ctl(other, "replay", log, "--frames", out, "--view", "way",
                     "--at", ",".join(map(str, TIMES)), "--speed", "100")
            files = sorted(glob.glob(os.path.join(out, "*.png")))
            self.assertEqual(len(files), len(TIMES), files)
            got = []
            for name in files:
                with open(name, "rb") as f:
                    got.append(f.read())
            self.assertEqual(got, [want[t] for t in TIMES])

    def ctl(self, daemon, *words):
        done = subprocess.run(
            [os.path.join(BIN, "pelagosctl"), "--timeout", "100", "--server",
             f"tcp:127.0.0.1:{daemon.tcp_port}", *words], capture_output=True,
            text=True, timeout=300, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_a_film_by_one_command(self):
        """From 2 m to 400 km: the way of the file, its frames those of single
        requests, its heights even in the logarithm."""
        with tempfile.TemporaryDirectory() as folder:
            way = os.path.join(folder, "climb.csv")
            with open(way, "w", encoding="ascii") as f:
                f.write("time,latitude,longitude,height,pitch\n"
                        "5,52.6,5.2,2,0\n7,52.6,5.2,400000,-60\n")
            daemon = self.start()
            told = json.loads(self.ctl(
                daemon, "--json", "record", "climb", folder + "/f_%02d.exr",
                "--waypoints", way, "--fps", "4", "--width", "64", "--height",
                "48"))
            self.assertEqual(told["frames"], 9)
            heights = []
            for i in range(9):
                with open(f"{folder}/f_{i:02d}.exr", "rb") as f:
                    frame = f.read()
                notes = pelagos.read_exr(frame).attributes
                self.assertAlmostEqual(notes["pelagos.time"], 5 + i / 4)
                heights.append(math.asinh(notes["altitude"]))
                single = daemon.get("/v1/views/climb/frame.exr?width=64&height="
                                    f"48&time={5 + i / 4}").body
                self.assertEqual(single, frame)
            steps = np.diff(heights)
            self.assertTrue(np.allclose(steps, steps[0], rtol=1e-5), steps)
            self.assertAlmostEqual(heights[0], math.asinh(2), places=6)
            self.ctl(daemon, "record", "climb", folder + "/climb.mkv",
                     "--waypoints", way, "--fps", "4")


if __name__ == "__main__":
    unittest.main(verbosity=2)
