#!/usr/bin/python3
"""The Python client against the daemon: installed into an environment of its
own without a network, then everything it offers, and its examples."""
import contextlib
import io
import json
import math
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import ROOT, Daemon, free_port

SOURCE = pathlib.Path(ROOT) / "clients/python"
sys.path.insert(0, str(SOURCE))
sys.dont_write_bytecode = True
import pelagos
from pelagos import Camera, Ocean


class OceanCase(unittest.TestCase):
    daemon = None

    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.url = cls.daemon.url("")

    @classmethod
    def tearDownClass(cls):
        status = cls.daemon.stop()
        assert status == 0, f"the daemon ended with {status}"

    def setUp(self):
        self.ocean = Ocean(self.url)
        self.addCleanup(self.ocean.close)
        self.ocean.patch({
            "clock": {"mode": "STEPPED", "time": 5, "rate": None},
            "origin": None, "sea": None, "sky": None,
            "entities": [{"id": 1, "name": "ownship"}],
            "views": [{"name": "bridge", "entity": 1, "width": 320,
                       "height": 180}]})


class State(OceanCase):
    def test_set_and_read(self):
        o = self.ocean
        state = o.set(sea={"windSpeed": np.float64(12), "seed": np.int32(7)},
                      sky={"sunElevation": 20})
        self.assertEqual((state.sea.windSpeed, state.sea.seed,
                          state.sky.sunElevation), (12.0, 7, 20.0))
        self.assertIsInstance(state.revision, int)
        o["sea.windSpeed"] = 9
        self.assertEqual(o["sea.windSpeed"], 9)
        self.assertEqual(o["clock.mode"], "STEPPED")
        del o["sky.sunElevation"]
        self.assertIsNone(o["sky.sunElevation"])
        self.assertIsNone(o.state().sky.sunElevation)
        del o["sea.windSpeed"]
        self.assertEqual(o.state().sea.windSpeed, pelagos.Sea().windSpeed)

    def test_swell(self):
        o = self.ocean
        o["sea.swell"] = [[2, 9, 270, 10], pelagos.Swell(height=1, period=12)]
        o["sea.swell.0.height"] = 3
        self.assertEqual([s.height for s in o.state().sea.swell], [3.0, 1.0])
        self.assertEqual(o["sea.swell.1.period"], 12)
        del o["sea.swell.0"]
        self.assertEqual(len(o.state().sea.swell), 1)
        with self.assertRaises(LookupError):
            o["sea.swell.4.height"] = 1
        # Somebody else's swell comes between reading and writing.
        read = o.transport.request

        def interrupted(method, *more, **named):
            answer = read(method, *more, **named)
            if method == "GET":
                with Ocean(self.url) as other:
                    other.set(sea={"swell": [[5, 15, 0, 10]]})
            return answer
        o.transport.request = interrupted
        with self.assertRaises(pelagos.Conflict):
            o["sea.swell.0.height"] = 9
        o.transport.request = read
        self.assertEqual(o["sea.swell.0.height"], 5)

    def test_errors_say_all(self):
        before = self.ocean.state()
        with self.assertRaises(pelagos.OutOfRange) as caught:
            self.ocean.set(sea={"windSpeed": 99, "seed": 3})
        error = caught.exception
        self.assertEqual(
            (error.path, error.value, error.unit, error.minimum,
             error.maximum, error.status, error.code),
            ("sea.windSpeed", "99", "m/s", 0, 30, 400, "OUT_OF_RANGE"))
        self.assertIn("0 to 30 m/s", str(error))
        self.assertIsInstance(error, ValueError)
        with self.assertRaises(pelagos.NotFound) as caught:
            self.ocean["sea.windSped"] = 1
        self.assertEqual(caught.exception.path, "sea.windSped")
        with self.assertRaises(pelagos.NotFound):
            self.ocean.views["none"]
        with self.assertRaises(pelagos.NotFound):
            self.ocean.frame("none")
        with self.assertRaises(pelagos.Invalid):
            self.ocean.set(sea={"windSpeed": "much"})
        with self.assertRaises(ValueError):
            self.ocean.set(sea={"windSpeed": math.nan})
        with self.assertRaises(pelagos.Conflict):
            self.ocean.set(sea={"windSpeed": 3}, revision=before.revision + 9)
        self.ocean.set(clock={"mode": "FREE"})
        with self.assertRaises(pelagos.Conflict):
            self.ocean.step(1)
        self.assertEqual(self.ocean.state().sea, before.sea)

    def test_views_and_entities(self):
        o = self.ocean
        ship = o.entities["ownship"]
        ship.set(heading=45, roll=3)
        ship["pitch"] = 1
        self.assertEqual((ship.state.heading, ship.state.roll, ship["pitch"]),
                         (45.0, 3.0, 1))
        buoy = o.entities.add(7, name="buoy", latitude=52.601, longitude=5.2)
        wing = o.views.add("wing", entity=7, right=12, yaw=90)
        self.assertEqual(o.views.names(), ["bridge", "wing"])
        self.assertEqual(o.entities.ids(), [1, 7])
        self.assertEqual((wing.state.entity, wing["yaw"]), (7, 90))
        self.assertIn("wing", o.views)
        self.assertIn(7, o.entities)
        with self.assertRaises(pelagos.Conflict):
            buoy.remove()  # the wing stands on it
        wing.remove()
        del o.entities["buoy"]
        self.assertEqual((len(o.views), len(o.entities)), (1, 1))

    def test_kept(self):
        before = self.ocean.state()
        with self.ocean.kept():
            self.ocean.set(sea={"windSpeed": 20, "swell": [[1, 9, 0, 10]]},
                           sky={"sunElevation": 5}, entities=None, views=None)
        after = self.ocean.state()
        for part in ("clock", "origin", "sea", "water", "sky", "entities",
                     "views"):
            self.assertEqual(getattr(after, part), getattr(before, part))

    def test_schema_is_the_daemons(self):
        """Every field that the daemon names has its place, unit and range."""
        import dataclasses
        from pelagos import schema
        parts = {"entities": "Entity", "views": "View", "swell": "Swell",
                 "helm": "OwnShip", "areas": "Area", "fog": "Fog",
                 "track": "TrackPoint", "sectors": "LightSector",
                 "signal": "SignalLamp", "presets": "Preset",
                 "exercise": "ExerciseRun", "events": "ExerciseDone",
                 "at": "Place", "waypoints": "Waypoint",
                 "field": "WeatherField"}
        for path, field in self.ocean.fields().items():
            kind = schema.State
            known = None
            for name in path.split("."):
                if name in ("NAME", "ID", "N", "*", "INDEX"):
                    continue
                known = {f.name: f for f in dataclasses.fields(kind)}.get(name)
                self.assertIsNotNone(known, path)
                kind = getattr(schema, parts.get(
                    name, name[0].upper() + name[1:]), kind)
            if "maximum" in field:
                self.assertEqual(
                    (known.metadata["unit"], known.metadata["minimum"],
                     known.metadata["maximum"]),
                    (field.get("unit"), field["minimum"], field["maximum"]),
                    path)

    def test_steps(self):
        self.assertEqual(self.ocean.step(0.5).clock.time, 5.5)
        self.assertEqual(self.ocean.step(0.25).clock.time, 5.75)
        self.assertEqual(self.ocean.step(until=6.1).clock.time, 6.1)


class Connection(OceanCase):
    def test_nobody_there(self):
        with self.assertRaises(pelagos.Unreachable):
            Ocean(f"http://127.0.0.1:{free_port()}").state()
        with self.assertRaises(ValueError):
            Ocean("ftp://127.0.0.1")

    def test_silence_ends(self):
        with socket.create_server(("127.0.0.1", 0)) as silent:
            url = f"http://127.0.0.1:{silent.getsockname()[1]}"
            with self.assertRaises(pelagos.TimedOut):
                Ocean(url, timeout=0.3).state()

    def test_no_http(self):
        with socket.create_server(("127.0.0.1", 0)) as server:
            def answer():
                s, _ = server.accept()
                s.recv(1000)
                s.sendall(b"220 mail.example ESMTP\r\n")
                s.close()
            threading.Thread(target=answer, daemon=True).start()
            with self.assertRaises(pelagos.ProtocolError):
                Ocean(f"http://127.0.0.1:{server.getsockname()[1]}").state()

    def test_restart_is_survived(self):
        port = free_port()
        ocean = Ocean(f"http://127.0.0.1:{port}")
        with Daemon(http_port=port):
            ocean.state()
        with self.assertRaises(pelagos.Unreachable):
            ocean.state()
        with Daemon(http_port=port):
            self.assertEqual(ocean.state().revision, 0)
        # The kept connection is of a daemon that is no more; it is not used.
        with Daemon(http_port=port):
            ocean.set(clock={"mode": "STEPPED"})
            ocean.step(1)
        ocean.close()

    def test_threads_share(self):
        failures = []

        def work():
            try:
                for _ in range(20):
                    assert len(self.ocean.state().views) == 1
            except Exception as error:
                failures.append(error)
        threads = [threading.Thread(target=work) for _ in range(6)]
        for t in threads:
            t.start()
        for t in threads:
            t.join()
        self.assertEqual(failures, [])


class Pictures(OceanCase):
    def test_image(self):
        view = self.ocean.views["bridge"]
        image = view.image()
        self.assertEqual((image.shape, image.dtype), ((180, 320, 3), np.uint8))
        jpeg = view.frame("jpg", quality=95)
        self.assertEqual(jpeg.time, 5)
        # Quality 95 of a smooth picture: a few levels on average.
        self.assertLess(np.abs(jpeg.image().astype(int) - image).mean(), 3)
        # RGB, not BGR: the sky above is bluer than red.
        self.assertGreater(image[:20, :, 2].mean(), image[:20, :, 0].mean())
        small = view.frame("png", width=64, height=48).image()
        self.assertEqual(small.shape, (48, 64, 3))
        np.testing.assert_array_equal(view.image(time=5), image)
        self.assertTrue((view.image(time=6) != image).any())
        with self.assertRaises(pelagos.BadPicture):
            jpeg.exr()
        with self.assertRaises(pelagos.OutOfRange):
            view.frame("jpg", width=9)
        with self.assertRaises(ValueError):
            view.frame("gif")

    def test_together(self):
        self.ocean.views.add("aft", entity=1, yaw=180, width=64, height=48)
        frames = self.ocean.frames(["bridge", "aft"], "png")
        self.assertEqual(list(frames), ["bridge", "aft"])
        self.assertEqual({f.time for f in frames.values()}, {5.0})
        images = self.ocean.images(["aft", "bridge"], width=64, height=48)
        self.assertEqual({i.shape for i in images.values()}, {(48, 64, 3)})
        self.assertEqual(set(self.ocean.frames()),
                         {v.name for v in self.ocean.state().views})
        with self.ocean.kept():  # the clock runs, and they stay together
            self.ocean.set(clock={"mode": "FREE"})
            for _ in range(10):
                depth = self.ocean.frames(["bridge", "aft"], "exr", width=64,
                                          height=48, layers=["depth"])
                self.assertEqual(len({(f.number, f.time, f.revision)
                                      for f in depth.values()}), 1)
        with self.assertRaises(pelagos.NotFound) as caught:
            self.ocean.frames(["bridge", "nothing"])
        self.assertEqual(caught.exception.path, "frames.1.view")

    def test_layers(self):
        """As ffmpeg's reader has them, which is nobody's of us."""
        view = self.ocean.views["bridge"]
        frame = view.frame("exr", layers=("radiance", "depth", "normal"))
        exr = frame.exr()
        layers = exr.layers
        self.assertEqual(
            {n: (a.shape, a.dtype.name) for n, a in layers.items()},
            {"radiance": ((180, 320, 3), "float32"),
             "depth": ((180, 320), "float32"),
             "normal": ((180, 320, 3), "float32")})
        self.assertEqual(exr.attributes["pelagos.view"], "bridge")
        self.assertEqual(exr.attributes["pelagos.time"], 5.0)
        self.assertEqual(exr.attributes["pelagos.windSpeed"], 8.0)
        self.assertEqual(exr.attributes["worldToCamera"].shape, (4, 4))
        floats = view.frame("exr", layers=("radiance", "normal"),
                            float_samples=True).exr()
        # Halves have 11 bits, and 6e-8 where they are smallest.
        np.testing.assert_allclose(layers["radiance"], floats["radiance"],
                                   rtol=2 ** -11, atol=6e-8)
        np.testing.assert_allclose(layers["normal"], floats["normal"],
                                   rtol=2 ** -11, atol=6e-8)
        with tempfile.NamedTemporaryFile(suffix=".exr") as file:
            frame.save(file.name)
            read = subprocess.run(
                ["ffmpeg", "-loglevel", "error", "-i", file.name, "-f",
                 "rawvideo", "-pix_fmt", "gbrpf32le", "-"],
                capture_output=True, check=True).stdout
        green_blue_red = np.frombuffer(read, np.float32).reshape(3, 180, 320)
        np.testing.assert_array_equal(
            layers["radiance"], green_blue_red[[2, 0, 1]].transpose(1, 2, 0))
        sky = np.isinf(layers["depth"])
        self.assertTrue(sky.any() and not sky.all())
        self.assertTrue((layers["normal"][sky] == 0).all())
        length = np.linalg.norm(layers["normal"][~sky], axis=-1)
        np.testing.assert_allclose(length, 1, atol=1e-3)  # halves
        with self.assertRaises(KeyError):
            exr["colour"]
        # What light there is, is the sum of its parts (halves each).
        parts = view.layers("radiance", "sun", "sky", "water", "air",
                            float_samples=True)
        np.testing.assert_allclose(
            parts["sun"] + parts["sky"] + parts["water"] + parts["air"],
            parts["radiance"], rtol=1e-4, atol=1e-7)

    def test_positions_are_the_surface(self):
        """The layer's places are those that the daemon answers with, far
        from the origin too."""
        self.ocean.set(sea={"windSpeed": 8, "level": 1.5})
        view = self.ocean.views["bridge"]
        view.set(up=20, pitch=-40)
        for longitude in (5.2, 12.0):
            self.ocean.entities[1].set(latitude=52.6, longitude=longitude)
            exr = view.frame("exr", layers=("depth", "position")).exr()
            place = exr["position"]
            near = exr["depth"] < 60
            self.assertEqual(place.dtype.name, "float64")
            self.assertEqual(abs(place).max() > 4e5, longitude > 6)
            surface = self.ocean.surface(place[near][:, :2])
            off = np.abs(surface.height - place[near][:, 2])
            # Pixels at this distance do not resolve the shortest waves.
            self.assertLess(np.quantile(off, 0.99), 0.02)
            self.assertTrue((place[np.isinf(exr["depth"])] == 0).all())

    def test_depth_and_rays_reach_the_surface(self):
        """Every pixel's ray times its depth is a point of the sea that the
        daemon answers with when asked for the surface there."""
        self.ocean.set(sea={"windSpeed": 10})
        self.ocean.entities[1].set(heading=200, roll=8, pitch=-3)
        view = self.ocean.views["bridge"]
        for change in ({"fieldOfView": 50},
                       {"frustum": {"left": -40, "right": 10, "top": -2,
                                    "bottom": -35}}):
            view.set(forward=20, right=-7, up=25, yaw=30, pitch=-35, roll=12,
                     **change)
            exr = view.frame("exr", layers=("depth", "normal")).exr()
            camera = Camera.of_exr(exr)
            points = camera.unproject(exr["depth"])
            near = exr["depth"] < 60
            self.assertGreater(near.sum(), 20000)
            surface = self.ocean.surface(points[near][:, :2])
            error = np.abs(surface.height - points[near][:, 2])
            # 1 cm is the promise; hidden slopes of a mesh may miss it.
            self.assertLess(np.median(error), 0.01)
            self.assertLess(np.percentile(error, 99), 0.05)
            # K and pose lead back to the pixels' centres.
            v, u = np.nonzero(near)
            back = camera.project(points[near])
            np.testing.assert_allclose(back, np.stack([u, v], -1) + 0.5,
                                       atol=1e-3)
            # The state says the same as the picture (single floats).
            again = view.camera()
            np.testing.assert_allclose(again.intrinsics.K,
                                       camera.intrinsics.K, rtol=1e-5)
            np.testing.assert_allclose(again.rotation, camera.rotation,
                                       atol=1e-6)
            np.testing.assert_allclose(again.position, camera.position,
                                       atol=1e-4)

    def test_stands_at_an_eye_point(self):
        o = self.ocean
        o.entities[1].set(model={"name": "tug"})
        view = o.views["bridge"]
        view.stand(1)
        [model] = [m for m in o.models().models if m.name == "tug"]
        for length in (None, 40.0):
            o.entities[1].set(model={"name": "tug", "length": length})
            view.stand(1, model.eyes[0].name)
            times = (length or model.length) / model.length
            self.assertEqual((view["forward"], view["up"]),
                             (round(model.eyes[0].forward * times, 3),
                              round(model.eyes[0].up * times, 3)))
        with self.assertRaisesRegex(LookupError, "no eye point 'mast'"):
            view.stand(1, "mast")
        o.entities[1].set(model=None)
        with self.assertRaisesRegex(LookupError, "has no model"):
            view.stand(1)

    def test_curved_sea(self):
        """A camera agrees with the daemon's boxes and with its depth up to the
        horizon, from 2 to 20,000 m."""
        o = Ocean(self.url, timeout=300)
        self.addCleanup(o.close)
        o.set(sea={"windSpeed": 0})
        view = o.views["bridge"]
        far = {2: 8, 30: 20, 200: 50, 1000: 110, 20000: 110}  # km
        seen = 0
        for height, most in far.items():
            places = [most * share for share in (0.01, 0.1, 0.5, 1)]
            o.patch({"entities": {str(10 + i): {
                **dict(zip(("latitude", "longitude"),
                           pelagos.to_geographic(120 * km, 1000 * km))),
                "model": {"name": "safe-water"}, "heading": 70}
                for i, km in enumerate(places)}, "views": {"bridge": {
                    "entity": None, "up": height, "yaw": 5,
                    "pitch": -20 if height > 1000 else -2,
                    "fieldOfView": 40, "width": 640, "height": 360}}})
            camera = view.camera()
            points = [p for one in view.truth().get("entities", [])
                      for p in (*one["corners"], *one["waterline"])
                      if "x" in p]
            seen += len(points)
            for p in points:
                drawn = camera.project([p["east"], p["north"], p["up"]])
                self.assertLess(np.abs(drawn - [p["x"], p["y"]]).max(), 0.1,
                                f"{height} m")
            exr = view.frame("exr", layers=("depth", "position")).exr()
            camera = Camera.of_exr(exr)
            sea = np.isfinite(exr["depth"])
            self.assertGreater(exr["depth"][sea].max(),
                               300 * math.sqrt(2 * 6360 * height / 1000))
            v, u = np.nonzero(sea)
            back = camera.project(exr["position"][sea])
            self.assertLess(np.abs(back - np.stack([u, v], -1) - 0.5).max(),
                            0.05, f"{height} m")
            off = camera.unproject(exr["depth"])[sea] - exr["position"][sea]
            self.assertLess((np.linalg.norm(off, axis=-1)
                             / (exr["depth"][sea] + 10)).max(),
                            1e-3 if height > 1000 else 2e-5, f"{height} m")
        self.assertGreaterEqual(seen, 40)

    def test_sea_from_space(self):
        """A camera high up agrees with position, depth and the limb: the
        daemon draws the ellipsoid there. The sphere is 5 px off at the limb
        from 400 km, 41 px from 3,000 km."""
        o = Ocean(self.url, timeout=300)
        self.addCleanup(o.close)
        o.set(sea={"windSpeed": 0})
        self.addCleanup(o.patch, {"origin": None, "sea": {"level": None},
                                  "views": {"bridge": {"at": None}}})
        view = o.views["bridge"]
        for height, latitude, away, pitch, level in (
                (25e3, 52.6, 0, -10, 0), (400e3, 5, 0, -25, 0),
                (400e3, -70, 20, -60, 2), (3000e3, 40, 0, -50, 0)):
            o.patch({"origin": {"latitude": latitude}, "sea": {"level": level},
                     "views": {"bridge": {
                         "entity": None, "up": height, "yaw": 30,
                         "at": {"latitude": latitude + away, "longitude": 30},
                         "pitch": pitch, "fieldOfView": 40, "width": 320,
                         "height": 180}}})
            exr = view.frame("exr", layers=("depth", "position")).exr()
            camera = Camera.of_exr(exr)
            sea = np.isfinite(exr["depth"])
            v, u = np.nonzero(sea)
            back = camera.project(exr["position"][sea])
            self.assertLess(np.abs(back - np.stack([u, v], -1) - 0.5).max(),
                            0.02, f"{height} m")
            off = camera.unproject(exr["depth"])[sea] - exr["position"][sea]
            # depth is a float: 0.25 m at 3,000 km
            self.assertLess(np.linalg.norm(off, axis=-1).max(), 5,
                            f"{height} m")
            horizon = view.horizon()
            if not sea.all():
                self.assertLess(np.abs(horizon.rows - sea.argmax(0)).max(),
                                0.6, f"{height} m")
                farthest = np.linalg.norm(
                    (exr["position"][sea] - camera.position)[:, :2], axis=-1)
                self.assertLess(farthest.max(), 1.005 * horizon.distance)
                self.assertGreater(farthest.max(), 0.9 * horizon.distance)

    def test_camera_axes(self):
        """A camera in the world at height 30 that looks east: what is north
        of the axis lies to the left, what is low lies low."""
        view = self.ocean.views.add("east", up=30, yaw=90, fieldOfView=90,
                                    width=400, height=200)
        camera = view.camera()
        self.assertEqual(camera.intrinsics, view.intrinsics())
        np.testing.assert_allclose(camera.position, [0, 0, 30], atol=1e-5)
        np.testing.assert_allclose(camera.intrinsics.K, [
            [200, 0, 200], [0, 200, 100], [0, 0, 1]], atol=1e-9)
        points = [[100, 0, 30], [100, 50, 30], [100, 0, 5], [-1, 0, 30]]
        # The sea falls by d²/2R on the way: 1 mm at 100 m.
        drop = [200 * d2 / (2 * 6.36e6) / 100 for d2 in (1e4, 1.25e4)]
        np.testing.assert_allclose(
            camera.project(points),
            [[200, 100 + drop[0]], [100, 100 + drop[1]], [200, 150 + drop[0]],
             [np.nan, np.nan]], atol=1e-4)
        half = view.intrinsics(width=200, height=200)
        np.testing.assert_allclose(half.K[:2, :2], [[100, 0], [0, 100]])


class SurfaceQueries(OceanCase):
    def test_shapes(self):
        east, north = np.meshgrid(np.arange(5.0), np.arange(4.0))
        grid = self.ocean.surface(np.stack([east, north], -1))
        self.assertEqual((grid.height.shape, grid.normal.shape,
                          grid.velocity.shape), ((4, 5), (4, 5, 3), (4, 5, 3)))
        self.assertEqual(grid.time, 5.0)
        one = self.ocean.surface([2, 3])
        self.assertEqual(one.height.shape, ())
        self.assertEqual(one.height, grid.height[3, 2])
        np.testing.assert_allclose(np.linalg.norm(grid.normal, axis=-1), 1,
                                   atol=1e-9)
        for bad in ([1, 2, 3], [], 5, [[math.inf, 0]]):
            with self.assertRaises(ValueError):
                self.ocean.surface(bad)
        with self.assertRaises(pelagos.OutOfRange):
            self.ocean.surface([[3e7, 0]])

    def test_acceleration_is_of_the_water(self):
        points = np.array([[0, 0], [12, -7], [-30, 40.0]])
        surface = self.ocean.surface(points, 5, acceleration=True)
        self.assertIsNone(self.ocean.surface(points, 5).acceleration)
        # Central difference of the velocity where the water goes. Over 4 ms
        # its third derivative counts: the shortest waves, of some 10 rad/s and
        # 1 m/s2, change the slope by 1e2 * 4e-6 / 6 of themselves.
        step = 2e-3
        along = surface.velocity[:, :2] * step
        after, before = (self.ocean.surface(points + s * along,
                                            5 + s * step).velocity
                         for s in (1, -1))
        slope = (after - before) / (2 * step)
        self.assertGreater(np.abs(slope).max(), 0.5)
        np.testing.assert_allclose(surface.acceleration, slope, atol=0.02)

    def test_foam_is_a_share_of_the_water(self):
        points = np.stack(np.meshgrid(np.arange(0, 800, 20.0),
                                      np.arange(0, 800, 20.0)), axis=-1)
        self.assertIsNone(self.ocean.surface(points, 5).foam)
        self.ocean.set(sea={"windSpeed": 14, "whitecaps": 4})
        foam = self.ocean.surface(points, 5, foam=True).foam
        self.assertEqual(foam.shape, points.shape[:-1])
        self.assertTrue(np.all((foam >= 0) & (foam <= 1)))
        self.assertGreater(foam.max(), 0.3)
        self.assertGreater(np.mean(foam < 0.01), 0.5)
        self.ocean.set(sea={"whitecaps": 0})
        foam = self.ocean.surface(points, 5, foam=True).foam
        self.assertEqual(foam.max(), 0)

    def test_of_the_sea_in_a_frame(self):
        self.ocean.set(clock={"mode": "FREE"})
        frame = self.ocean.frame("bridge", width=64, height=36)
        there = self.ocean.surface([[3, 4]], frame=frame.number)
        self.assertAlmostEqual(there.time, frame.time, delta=1e-9)
        self.assertEqual(self.ocean.surface([[3, 4]], frame.time).height,
                         there.height)

    def test_frames_tell_of_silent_inputs(self):
        def stale():
            return self.ocean.frame("bridge", width=64, height=36).stale
        self.assertFalse(stale())
        self.ocean.set(sources={"otherStale": True})
        self.assertTrue(stale())
        with self.ocean.views["bridge"].live(width=64, height=36) as stream:
            self.assertTrue(next(iter(stream)).stale)

    def test_batches_are_of_one_time(self):
        """More points than one query takes, with the clock running."""
        self.ocean.set(clock={"mode": "FREE"})
        point = [1 / 3, -200000 / 3]
        many = self.ocean.surface(np.tile(point, (20001, 1)))
        self.assertEqual(len(many.height), 20001)
        self.assertEqual(len(set(many.height)), 1)
        self.assertEqual(self.ocean.surface([point], many.time).height[0],
                         many.height[0])


class Live(OceanCase):
    def newest_only(self, **options):
        self.ocean.set(clock={"mode": "FREE"})
        with self.ocean.views["bridge"].live(**options) as stream:
            first = next(stream)
            self.assertEqual(first.image().shape, (180, 320, 3))
            time.sleep(1.0)
            newest = next(stream)
            # Never a picture from the queue: 1 s later, one of that moment.
            self.assertGreater(newest.time, first.time + 0.5)
            self.assertEqual(stream.received, stream.dropped + 2)
            self.assertEqual(newest.dropped, stream.dropped)
            numbers = [frame.number for _, frame in zip(range(3), stream)]
            self.assertEqual(numbers, sorted(set(numbers)))
        with self.assertRaises(StopIteration):
            next(stream)
        stream.close()
        return stream, newest

    def test_websocket(self):
        stream, frame = self.newest_only()
        self.assertEqual(stream.protocol, "websocket")
        # The same machine, the same clock.
        self.assertLess(abs(time.time() - frame.stamp), 5)
        with self.ocean.views["bridge"].live(width=64, height=48,
                                             quality=40) as stream:
            self.assertEqual(next(stream).image().shape, (48, 64, 3))

    def test_mjpeg(self):
        stream, _ = self.newest_only(fps=30)
        self.assertEqual(stream.protocol, "mjpeg")

    def test_a_daemon_without_websocket(self):
        """404 for the route, not for the view: Motion-JPEG it is."""
        part = (b"HTTP/1.1 200 OK\r\nContent-Type: multipart/x\r\n\r\n"
                b"--pelagos\r\nContent-Length: 3\r\nX-Pelagos-Frame: 7\r\n"
                b"\r\nabc\r\n--pelagos\r\n")
        with socket.create_server(("127.0.0.1", 0)) as server:
            def answer():
                for data in (b"HTTP/1.1 404 Not Found\r\nContent-Length: 2"
                             b"\r\n\r\n{}", part):
                    s, _ = server.accept()
                    s.recv(1000)
                    s.sendall(data)
                    s.close()
            threading.Thread(target=answer, daemon=True).start()
            ocean = Ocean(f"http://127.0.0.1:{server.getsockname()[1]}")
            with pelagos.LiveStream(ocean.transport, "bridge") as stream:
                frame = next(stream)
                self.assertEqual((frame.number, frame.data), (7, b"abc"))
                with self.assertRaises(pelagos.Unreachable):
                    next(stream)

    def test_noise_is_refused(self):
        """Frames that no WebSocket server sends, or no picture of ours."""
        import base64
        import hashlib
        import re
        for noise in (b"\x82\x05hello", b"\x02\x00", b"\x82\xff",
                      b"\x82\x7f" + b"\xff" * 8, b"\x81\x01{",
                      b"\x82\x40" + b"\x09" * 64):
            with socket.create_server(("127.0.0.1", 0)) as server:
                def answer():
                    s, _ = server.accept()
                    key = re.search(rb"Sec-WebSocket-Key: (\S+)",
                                    s.recv(2000)).group(1)
                    accept = base64.b64encode(hashlib.sha1(
                        key + b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
                        ).digest())
                    s.sendall(b"HTTP/1.1 101 X\r\nSec-WebSocket-Accept: "
                              + accept + b"\r\n\r\n" + noise)
                    s.recv(100)
                    s.close()
                thread = threading.Thread(target=answer, daemon=True)
                thread.start()
                ocean = Ocean(f"http://127.0.0.1:{server.getsockname()[1]}")
                with pelagos.LiveStream(ocean.transport, "bridge") as stream:
                    with self.assertRaises(pelagos.ProtocolError, msg=noise):
                        next(stream)
                thread.join()

    def test_video(self):
        """Twenty access units in a row are twenty pictures for ffmpeg."""
        self.ocean.set(clock={"mode": "FREE"})
        with self.ocean.views["bridge"].video(bitrate=2000) as video:
            packets = [packet for packet, _ in zip(video, range(20))]
        self.assertTrue(packets[0].key and packets[0].format == "h264")
        self.assertEqual(packets[0].data[:3], b"\0\0\0")
        with tempfile.NamedTemporaryFile(suffix=".h264") as file:
            file.write(b"".join(packet.data for packet in packets))
            file.flush()
            read = subprocess.run(
                ["ffprobe", "-v", "error", "-count_frames", "-show_entries",
                 "stream=nb_read_frames,width,height", "-of", "csv=p=0",
                 file.name], capture_output=True, text=True, check=True)
        self.assertEqual(read.stdout.strip(), "320,180,20")

    def test_end_and_refusal(self):
        for options in ({}, {"fps": 5}):
            with self.assertRaises(pelagos.NotFound):
                pelagos.LiveStream(self.ocean.transport, "none", **options)
        with self.assertRaises(pelagos.OutOfRange):
            self.ocean.views["bridge"].live(fps=1000)
        with self.assertRaises(pelagos.OutOfRange):
            self.ocean.views["bridge"].live(width=9, height=9)
        self.ocean.set(clock={"mode": "FREE"})
        for options in ({}, {"fps": 10, "quality": 50}):
            view = self.ocean.views.add("short", width=64, height=48)
            with view.live(**options) as stream:
                next(stream)
                view.remove()
                with self.assertRaises(pelagos.Unreachable):
                    for _ in stream:
                        pass

    def test_close_from_elsewhere(self):
        view = self.ocean.views["bridge"]
        for stream in (view.live(), view.live(fps=10), view.video()):
            next(stream)
            threading.Timer(0.3, stream.close).start()
            for _ in stream:  # the clock stands: it waits, until the close
                pass


class Examples(OceanCase):
    def run_example(self, name, *arguments, **environment):
        clean = {k: v for k, v in os.environ.items() if k != "DISPLAY"}
        done = subprocess.run(
            ["/usr/bin/python3", "-B", str(SOURCE / "examples" / name),
             "--url", self.url, *arguments], capture_output=True, text=True,
            env={**clean, "PYTHONPATH": str(SOURCE), **environment},
            timeout=120)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def setUp(self):
        super().setUp()
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="pelagos-test-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def test_dataset_repeats_to_the_bit(self):
        before = self.ocean.state()
        self.run_example("dataset.py", "--out", str(self.folder / "a"),
                         "--frames", "4", "--size", "160x96")
        after = self.ocean.state()
        self.assertEqual((after.sea, after.views, after.entities, after.clock),
                         (before.sea, before.views, before.entities,
                          before.clock))
        # Whatever the daemon did meanwhile.
        self.ocean.set(sea={"windSpeed": 25, "synthesiser": "FFT",
                            "depth": 20, "spectrum": "TMA"},
                       sky={"visibility": 900}, origin={"latitude": 10},
                       clock={"time": 77, "mode": "FREE"})
        self.run_example("dataset.py", "--out", str(self.folder / "b"),
                         "--frames", "4", "--size", "160x96")
        names = sorted(p.name for p in (self.folder / "a").iterdir())
        self.assertEqual(names, [f"{n:04}.{e}" for n in range(4)
                                 for e in ("exr", "json", "png")])
        for name in names:
            self.assertEqual((self.folder / "a" / name).read_bytes(),
                             (self.folder / "b" / name).read_bytes(), name)
        self.run_example("dataset.py", "--out", str(self.folder / "c"),
                         "--frames", "1", "--size", "160x96", "--seed", "2")
        self.assertNotEqual((self.folder / "a/0000.png").read_bytes(),
                            (self.folder / "c/0000.png").read_bytes())
        label = json.loads((self.folder / "a/0003.json").read_text())
        exr = pelagos.read_exr(self.folder / "a/0003.exr")
        self.assertEqual(label["time"], exr.attributes["pelagos.time"])
        self.assertEqual(label["time"], 1.5)
        self.assertEqual(exr["depth"].shape, (96, 160))
        self.assertEqual(label["camera"]["K"],
                         Camera.of_exr(exr).intrinsics.K.tolist())
        self.assertEqual(set(label["hull"]),
                         {"bow", "stern", "port", "starboard", "middle"})
        for point in label["hull"].values():
            self.assertLess(abs(point["water"]), 10)
        # The camera stands 12 m above and 5 m ahead of the ship's point.
        away = np.subtract(label["camera"]["position"],
                           label["ship"]["position"])
        self.assertAlmostEqual(np.linalg.norm(away), 13, places=4)

    def test_live_writes_without_a_window(self):
        self.ocean.set(clock={"mode": "FREE"})
        out = self.run_example("live.py", "bridge", "--frames", "3", "--out",
                               str(self.folder))
        self.assertIn("no window here", out)
        files = sorted(self.folder.glob("bridge-*.jpg"))
        self.assertEqual(len(files), 3)
        self.assertEqual(files[0].read_bytes()[:2], b"\xff\xd8")

    def test_live_shows_in_a_window(self):
        """With an OpenCV of a few lines that notes what it is given."""
        (self.folder / "cv2.py").write_text(
            "import numpy\n"
            "IMREAD_COLOR = FONT_HERSHEY_SIMPLEX = 1\n"
            "keys = iter([ord('w'), ord('d'), 0xff, ord('q')])\n"
            "def imdecode(data, how):\n"
            "    import io\n"
            "    from PIL import Image\n"
            "    return numpy.asarray(Image.open(io.BytesIO(\n"
            "        data.tobytes())))[:, :, ::-1]\n"
            "def putText(*_): pass\n"
            "def imshow(title, image): print('SHOWN', title, image.shape)\n"
            "def waitKey(ms): return next(keys)\n"
            "def destroyAllWindows(): print('CLOSED')\n")
        self.ocean.set(clock={"mode": "FREE"})
        out = self.run_example("live.py", DISPLAY=":9",
                               PYTHONPATH=f"{SOURCE}:{self.folder}")
        self.assertEqual(
            out, "SHOWN Pelagos: bridge (180, 320, 3)\n" * 4 + "CLOSED\n")
        self.assertEqual((self.ocean["sea.windSpeed"],
                          self.ocean["views.bridge.yaw"]), (9, 5))

    def test_bridge(self):
        self.ocean.set(sea={"windSpeed": 12})
        self.ocean.entities[1].set(heading=40, roll=6, pitch=2)
        self.ocean.set(clock={"mode": "FREE"})
        out = self.run_example("bridge.py", "--out",
                               str(self.folder / "panorama.png"), "--size",
                               "320x240", "--live", "5")
        self.assertEqual(out.count(": meets"), 4, out)
        self.assertEqual(out.count(": one frame"), 1, out)
        self.assertEqual(out.count(": each is one frame"), 1, out)
        self.assertEqual(self.ocean.views.names(), ["bridge"])
        image = pelagos.frame.decode(
            (self.folder / "panorama.png").read_bytes())
        self.assertEqual(image.shape[1], 1280)
        self.assertTrue((image.max(-1) > 0).all(), "there are holes")


class Installation(unittest.TestCase):
    def test_types(self):
        """By mypy, strictly, as pyproject.toml has it."""
        if not shutil.which("mypy"):
            self.skipTest("mypy is not installed")
        with tempfile.TemporaryDirectory() as cache:
            done = subprocess.run(
                ["mypy", "--cache-dir", cache, "pelagos",
                 *map(str, sorted(SOURCE.glob("examples/*.py")))],
                capture_output=True, text=True, cwd=SOURCE,
                env={**os.environ, "MYPYPATH": "examples"})
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_pip_without_network(self):
        folder = pathlib.Path(tempfile.mkdtemp(prefix="pelagos-test-"))
        self.addCleanup(shutil.rmtree, folder)
        # A copy: pip leaves a build folder beside the sources.
        source = folder / "source"
        shutil.copytree(SOURCE, source, ignore=shutil.ignore_patterns(
            "build", "*.egg-info", "__pycache__"))
        python = folder / "venv/bin/python"
        for command in (
                ["/usr/bin/python3", "-m", "venv", "--system-site-packages",
                 str(folder / "venv")],
                [str(python), "-m", "pip", "install", "--quiet", "--no-index",
                 "--no-build-isolation", "--disable-pip-version-check",
                 str(source)]):
            done = subprocess.run(command, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        clean = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
        with Daemon() as daemon:
            done = subprocess.run(
                [str(python), "-c",
                 "import os, pelagos; print(pelagos.__file__)\n"
                 "assert os.path.exists(os.path.join(os.path.dirname("
                 "pelagos.__file__), 'py.typed'))\n"
                 "print(pelagos.Ocean().views['bridge'].frame().image().shape)"
                 ], capture_output=True, text=True, cwd=folder,
                env={**clean, "PELAGOS_URL": daemon.url("")})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("/venv/", done.stdout)
        self.assertIn("(720, 1280, 3)", done.stdout)

    def test_without_numpy(self):
        """Steering needs nothing; arrays say what is missing."""
        blocker = tempfile.mkdtemp(prefix="pelagos-test-")
        self.addCleanup(shutil.rmtree, blocker)
        with open(os.path.join(blocker, "numpy.py"), "w") as f:
            f.write("raise ImportError('none')\n")
        with Daemon() as daemon:
            done = subprocess.run(
                ["/usr/bin/python3", "-B", "-c",
                 "import pelagos\no = pelagos.Ocean()\n"
                 "o['sea.windSpeed'] = 7\n"
                 "print(len(o.frame('bridge', width=64, height=48).data))\n"
                 "try: o.surface([[0, 0]])\n"
                 "except pelagos.MissingPackage as e: print(e)"],
                capture_output=True, text=True,
                env={**os.environ, "PYTHONPATH": f"{blocker}:{SOURCE}",
                     "PELAGOS_URL": daemon.url("")})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("apt install python3-numpy", done.stdout)

    def test_readme_quick_start(self):
        text = (SOURCE / "README.md").read_text()
        code = text.split("```python\n")[1].split("```")[0]
        with Daemon() as daemon, tempfile.TemporaryDirectory() as folder:
            os.environ["PELAGOS_URL"] = daemon.url("")
            self.addCleanup(os.environ.pop, "PELAGOS_URL")
            with contextlib.redirect_stdout(io.StringIO()), \
                    contextlib.chdir(folder):
                names = {}
                exec(code, names)
                names["ocean"].close()


if __name__ == "__main__":
    unittest.main(verbosity=2)
