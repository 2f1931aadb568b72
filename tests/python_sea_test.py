#!/usr/bin/python3
"""The Python client for who trains and tests vessels on the sea: a known state
by a seed, the sea at many times, its spectrum and light, horizon, labels,
places, and one name for each thing."""
import os
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import SLOW_S, Daemon
from python_client_test import OceanCase
import pelagos
from pelagos import Camera, Ocean, Origin, convergence, to_geographic, to_local

# Pictures of a machine that eight others use.
PATIENCE_S = 10 * SLOW_S


class Case(OceanCase):
    def setUp(self):
        self.ocean = Ocean(self.url, timeout=PATIENCE_S)
        self.addCleanup(self.ocean.close)
        self.ocean.reset(1, {"views": [{"name": "bridge", "entity": 1,
                                        "width": 160, "height": 96}]})


class Reset(Case):
    SCENE = {"sea": {"windSpeed": 11}, "sky": {"sunElevation": 20},
             "ownShip": {"on": True, "entity": 1, "throttle": 1, "rudder": 20},
             "entities": [{"id": 1, "name": "usv", "model": {"name": "usv"}},
                          {"id": 2, "model": {"name": "tug"}, "afloat": True,
                           "latitude": 52.601, "longitude": 5.2, "wake": True,
                           "heading": 90, "course": 90, "speed": 5}],
             "views": [{"name": "bow", "entity": 1, "up": 4, "width": 96,
                        "height": 64}]}

    def voyage(self, ocean):
        """What three steps from the reset look like, to the bit."""
        out = []
        for _ in range(3):
            state = ocean.step(0.5)
            ship = state.entities[0]
            out += [ocean.frame("bow", "png").data, state.clock.time,
                    ship.latitude, ship.longitude, ship.roll,
                    ocean.surface([[3, 4]]).height.tobytes()]
        return out

    def test_the_same_to_the_bit_whatever_was_before(self):
        o = self.ocean
        first_state = o.reset(7, self.SCENE)
        self.assertEqual((first_state.clock.time, first_state.clock.mode,
                          first_state.sea.seed), (0.0, "STEPPED", 7))
        first = self.voyage(o)
        # Everything that a client may leave behind.
        o.set(sea={"windSpeed": 20, "swell": [[3, 12, 90, 10]], "seed": 99,
                   "wave": [[2, 8, 10, 0]], "areas": [{"radius": 300}]},
              water={"named": "HARBOUR", "cdom": 2},
              sky={"sunElevation": 3, "rain": 20, "fog": [{"radius": 900}]},
              origin={"latitude": 10}, ownShip={"rudder": -30},
              clock={"mode": "FREE", "time": 500, "utc":
                     "2026-01-01T00:00:00Z"},
              sources={"otherStale": True}, seabed={"waves": False})
        o.entities.add(9, name="other")
        o.views.add("other", entity=9, meter="all")
        second_state = o.reset(7, self.SCENE)
        for part in ("clock", "origin", "sea", "water", "sky", "entities",
                     "views", "ownShip", "sources", "seabed"):
            self.assertEqual(getattr(second_state, part),
                             getattr(first_state, part), part)
        self.assertEqual(self.voyage(o), first)
        with Daemon() as fresh:
            other = Ocean(fresh.url(""), timeout=PATIENCE_S)
            other.reset(7, self.SCENE)
            self.assertEqual(self.voyage(other), first)
            other.close()
        o.reset(8, self.SCENE)
        self.assertNotEqual(self.voyage(o)[0], first[0])

    def test_without_a_scene_as_the_daemon_starts(self):
        with Daemon() as fresh:
            start = Ocean(fresh.url("")).state()
        state = self.ocean.reset()
        for part in ("origin", "sea", "water", "sky", "entities", "views",
                     "ownShip", "sources"):
            self.assertEqual(getattr(state, part), getattr(start, part), part)

    def test_scene_of_a_state(self):
        """What was read is a scene: its poses hold at 0, its wakes begin."""
        o = self.ocean
        o.reset(3, self.SCENE)
        o.step(5)
        state = o.state()
        self.assertEqual(state.entities[0].poseTime, 5)
        again = o.reset(4, state)
        self.assertEqual((again.sea.windSpeed, again.sea.seed, again.clock.time,
                          again.entities[0].poseTime), (11, 4, 0, 0))
        self.assertEqual(again.entities[0].latitude,
                         state.entities[0].latitude)
        by_key = o.reset(1, {"entities": {"5": {"name": "buoy"}},
                             "views": {"a": {"entity": 5}}})
        self.assertEqual(([e.id for e in by_key.entities],
                          by_key.views[0].name), ([5], "a"))

    def test_refusals(self):
        before = self.ocean.state()
        for seed, scene in ((-1, {}), (2 ** 32, {}),
                            (1, {"sea": {"windSpeed": 99}})):
            with self.assertRaises(pelagos.OutOfRange):
                self.ocean.reset(seed, scene)
        self.assertEqual(self.ocean.state(), before)


class SeaNumbers(Case):
    def test_spectrum(self):
        s = self.ocean.spectrum(frequencies=60, directions=36, lowest=0.3,
                                highest=20, wavelength=10,
                                patch={"sea": {"windSpeed": 12}})
        self.assertEqual((s.omega.shape, s.density.shape, s.directional.shape),
                         ((60,), (60,), (60, 36)))
        # S is the sum over directions; Hs is of the area below it.
        np.testing.assert_allclose(
            s.directional.sum(-1) * 2 * np.pi / 36, s.density, rtol=1e-3)
        area = np.trapz(s.density, s.omega)
        self.assertAlmostEqual(4 * np.sqrt(area) / s.significantHeight, 1,
                               delta=0.02)
        self.assertAlmostEqual(2 * np.pi / s.omega[s.density.argmax()],
                               s.peakPeriod, delta=0.5)
        self.assertLess(s.spectrumBelow.significantHeight,
                        s.spectrum.significantHeight)
        self.assertEqual(self.ocean["sea.windSpeed"], 8)  # for the answer only
        calm = self.ocean.spectrum()
        self.assertLess(calm.significantHeight, s.significantHeight)
        self.assertEqual((calm.omega.shape, calm.directional.shape),
                         ((0,), (0, 0)))
        with self.assertRaises(pelagos.OutOfRange):
            self.ocean.spectrum(frequencies=201)
        with self.assertRaises(pelagos.OutOfRange):
            self.ocean.spectrum(frequencies=5, lowest=0)

    def test_optics(self):
        o = self.ocean
        low, high = (o.optics("sky", elevation=20, patch={
            "sky": {"sunElevation": sun}}).sky for sun in (5, 50))
        self.assertLess(low.luminance, high.luminance)
        clear, green = (o.optics("water", wavelength=450, patch={
            "water": {"chlorophyll": c}}).water for c in (0.05, 10))
        self.assertGreater(clear.total[0], green.total[0])
        self.assertEqual(clear.wavelength, (450.0,))
        answer = o.optics("brdf", viewZenith=70)
        self.assertEqual((answer.from_, answer.water), ("REFERENCE", None))
        self.assertGreater(answer.brdf.fresnel, 0)
        self.assertEqual(answer.to_json()["from"], "REFERENCE")
        with self.assertRaises(ValueError):
            o.optics("fog")
        with self.assertRaises(pelagos.OutOfRange) as caught:
            o.optics("sky", elevation=99)
        self.assertEqual(caught.exception.maximum, 90)

    def test_series(self):
        s = self.ocean.series("brdf", {"windSpeed": [4, 9],
                                       "viewZenith": slice(10, 70, 30)},
                              patch={"sky": {"sunElevation": 30}})
        self.assertEqual(s.dims["brdf"], ("windSpeed", "viewZenith"))
        np.testing.assert_array_equal(s["viewZenith"], [10, 40, 70])
        for i, wind in enumerate((4, 9)):
            one = self.ocean.optics("brdf", viewZenith=40, patch={
                "sky": {"sunElevation": 30}, "sea": {"windSpeed": wind}})
            self.assertEqual(s["brdf"][i, 1], one.brdf.brdf)
        self.assertEqual(s.units["brdf"], "1/sr")
        self.assertEqual(s.query["optics"]["brdf"], {})
        d = s.dataset()
        self.assertEqual(float(d.brdf.sel(windSpeed=9, viewZenith=40)),
                         s["brdf"][1, 1])
        self.assertEqual(d.brdf.attrs["units"], "1/sr")
        self.assertEqual(d.windSpeed.attrs["standard_name"], "wind_speed")
        heights = self.ocean.series("surface", {"time": slice(0, 4, 2)},
                                    points=[[0, 0], [5, 5]])["height"]
        self.assertEqual(heights.shape, (3, 2))
        one = self.ocean.series("spectrum", frequencies=3)
        self.assertEqual(one["density"].shape, (3,))
        sky = self.ocean.series("sky", {"elevation": [5]}, source="GPU", time=3)
        self.assertEqual(sky["radiance"].shape, (1, 3))
        self.assertEqual(sky.query["optics"]["from"], "GPU")
        with self.assertRaisesRegex(pelagos.OutOfRange, "viewZenith"):
            self.ocean.series("brdf", {"viewZenith": [91]})
        with self.assertRaises(ValueError):
            self.ocean.series("clouds")
        with self.assertRaises(ValueError):
            self.ocean.series("spectrum", source="GPU")

    def test_models(self):
        kinds = {m.name: m.class_ for m in self.ocean.models().models}
        self.assertEqual(kinds["usv"], "USV")
        self.assertTrue(set(kinds.values()) <= set(pelagos.MODEL_CLASSES))

    def test_surface_at_times(self):
        o, points = self.ocean, np.array([[0, 0], [30, -5], [7, 7.5]])
        times = [12, 0.5, 3600]
        many = o.surface(points, times, acceleration=True, foam=True)
        self.assertIsInstance(many, pelagos.SurfaceSeries)
        self.assertEqual((len(many), many.height.shape, many.normal.shape,
                          many.acceleration.shape, many.foam.shape),
                         (3, (3, 3), (3, 3, 3), (3, 3, 3), (3, 3)))
        for one, time in zip(many, times):
            alone = o.surface(points, time)
            self.assertIsInstance(alone, pelagos.Surface)
            self.assertEqual((one.time, alone.time), (time, time))
            np.testing.assert_array_equal(one.height, alone.height)
            np.testing.assert_array_equal(one.velocity, alone.velocity)
        self.assertIsNone(o.surface(points, np.array([1.0])).foam)
        # A hull under way: each time its own points.
        track = points[None] + np.array(times)[:, None, None]
        moving = o.surface(track, times, moving=True)
        np.testing.assert_array_equal(
            moving.height[1], o.surface(track[1], times[1]).height)
        for bad in ([], [[1.0]], [-1.0]):
            with self.assertRaises((ValueError, pelagos.OutOfRange)):
                o.surface(points, bad)
        with self.assertRaises(ValueError):
            o.surface(points, times[:2], moving=True)
        with self.assertRaises(ValueError):
            o.surface(points, 3.0, moving=True)
        self.assertIsInstance(o.surface(points, np.float64(3)),
                              pelagos.Surface)


class Geometry(Case):
    def test_horizon_is_where_the_calm_sea_ends(self):
        self.ocean.set(sea={"windSpeed": 0, "level": 2})
        view = self.ocean.views["bridge"]
        self.ocean.entities[1].set(pitch=2, roll=5)
        for up, yaw, roll in ((4, 0, 0), (30, 40, -25), (3000, 200, 12)):
            view.set(up=up, yaw=yaw, roll=roll, pitch=-3, antialiasing=False)
            depth = view.layers("depth")["depth"]
            horizon = view.horizon()
            sky = np.isinf(depth)
            # The first row of sea has its middle below the horizon, by a
            # pixel at most.
            first = np.where(sky.all(0), 96, (~sky).argmax(0))
            inside = (horizon.rows > 0) & (horizon.rows < 96)
            self.assertGreater(inside.sum(), 60, (up, yaw, roll))
            np.testing.assert_allclose((first - horizon.rows)[inside], 0,
                                       atol=0.52)
            # The pictures' columns see it at its distance.
            self.assertLess(depth[~sky].max(), 1.01e3 * np.sqrt(
                horizon.distance ** 2 + up ** 2) / 1e3)
            slope = np.polyfit(np.arange(160)[inside] + 0.5,
                               horizon.rows[inside], 1)[0]
            self.assertAlmostEqual(np.degrees(np.arctan(slope)), horizon.tilt,
                                   delta=3)
            self.assertAlmostEqual(horizon.left, horizon.rows[0], delta=1)

    def test_dip_and_refraction(self):
        camera = self.ocean.views["bridge"].camera()
        level = camera.horizon(20)
        # Bowditch: 1.76 sqrt(m) minutes with refraction, 1.93 without.
        self.assertAlmostEqual(level.dip * 60, 1.93 * np.sqrt(20), delta=0.03)
        bent = camera.horizon(20, pelagos.STANDARD_REFRACTION)
        self.assertAlmostEqual(bent.dip * 60, 1.79 * np.sqrt(20), delta=0.05)
        self.assertGreater(bent.distance, level.distance)
        self.assertAlmostEqual(level.distance, 15950, delta=20)
        self.assertLess(bent.rows[80], level.rows[80])
        for height, refraction in ((0, 0), (-1, 0), (5, 1)):
            with self.assertRaises(ValueError):
                camera.horizon(height, refraction)
        # Straight down nothing is horizon, within the picture or elsewhere.
        self.ocean.views["bridge"].set(pitch=-90)
        down = self.ocean.views["bridge"].horizon()
        self.assertFalse(((down.rows >= 0) & (down.rows <= 96)).any())

    def test_places(self):
        """As the daemon has them, by cameras at these places."""
        origin = Origin(latitude=52.6, longitude=5.2)
        for latitude, longitude in ((52.6, 5.2), (52.7, 5.0), (51, 9),
                                    (-33, 18)):
            self.ocean.entities[1].set(latitude=latitude, longitude=longitude)
            here = to_local(latitude, longitude, origin)
            there = to_geographic(*here, origin)
            self.assertAlmostEqual(there.latitude, latitude, places=10)
            self.assertAlmostEqual(there.longitude, longitude, places=10)
            if abs(here.north) < 1e6:
                exr = self.ocean.frame("bridge", "exr", width=16,
                                       height=16).exr()
                camera = Camera.of_exr(exr)
                np.testing.assert_allclose(camera.position[:2], here,
                                           atol=1e-6 * np.hypot(*here) + 1e-3)
                ahead = camera.rotation[2]
                self.assertAlmostEqual(
                    np.degrees(np.arctan2(ahead[0], ahead[1])),
                    convergence(latitude, longitude, origin), places=3)
        # Vincenty's own example: Flinders Peak to Buninyong.
        here = to_local(-37.65282113889, 143.92649552778,
                        Origin(-37.95103341667, 144.42486788889))
        self.assertAlmostEqual(np.hypot(*here), 54972.271, delta=2e-3)
        with self.assertRaises(ValueError):
            to_local(-52.6, -174.8, origin)


class Labelling(Case):
    def scene(self):
        self.ocean.reset(5, {
            "sea": {"windSpeed": 6},
            "entities": [
                {"id": 1, "name": "usv"},
                {"id": 7, "model": {"name": "tug"}, "latitude": 52.6009,
                 "longitude": 5.2, "heading": 60, "afloat": True},
                {"id": 300, "model": {"name": "safe-water"}, "afloat": True,
                 "latitude": 52.6004, "longitude": 5.2002}],
            "views": [{"name": "bow", "entity": 1, "up": 5, "width": 240,
                       "height": 135}]})

    def test_labels_agree(self):
        self.scene()
        labels = self.ocean.views["bow"].labels()
        self.assertEqual((labels.image.shape, labels.depth.shape,
                          labels.ids.shape, labels.ids.dtype.name),
                         ((135, 240, 3), (135, 240), (135, 240), "int32"))
        self.assertEqual(labels.visible_ids(), [7, 300])
        self.assertEqual(labels.agreement(), {7: 1.0, 300: 1.0})
        for entity in labels.entities:
            mask = labels.mask(entity.id)
            self.assertEqual(int(mask.sum()), entity.pixels)
            self.assertEqual(
                {pelagos.MODEL_CLASSES[k] for k in labels.classes[mask]},
                {entity.kind})
            # The nearest of it is before its middle, by half its length.
            self.assertAlmostEqual(float(labels.depth[mask].min()),
                                   entity.distance, delta=17)
        self.assertEqual([e.kind for e in labels.entities],
                         ["TUG", "SAFE_WATER"])
        self.assertTrue((labels.classes[labels.ids < 0] == -1).all())
        # The label's camera is the picture's: the tug is where it projects.
        seen = labels.entities[0].seen.waterline[0]
        u, v = labels.camera.project([seen.right, seen.ahead, 0]
                                     + labels.camera.position * [1, 1, 0])
        self.assertAlmostEqual(u, seen.x, delta=1)
        small = self.ocean.views["bow"].labels(width=96, height=54,
                                               image=False)
        self.assertIsNone(small.image)
        self.assertEqual(small.ids.shape, (54, 96))

    def test_boxes_that_lie_are_noticed(self):
        self.scene()
        labels = self.ocean.views["bow"].labels(image=False)
        labels.ids[labels.ids == 300] = -1
        self.assertEqual(labels.agreement(), {7: 1.0, 300: 0.0})
        labels.ids[0, 0] = 7
        self.assertLess(labels.agreement()[7], 0.9)
        a = pelagos.Box(0, 0, 4, 2)
        self.assertEqual(a.overlap(pelagos.Box(2, 0, 4, 2)), 4 / 12)
        self.assertEqual(a.overlap(pelagos.Box(4, 0, 4, 2)), 0)

    def test_one_moment_while_all_runs(self):
        self.scene()
        self.ocean.set(clock={"mode": "FREE"})
        labels = self.ocean.views["bow"].labels(width=64, height=36)
        self.assertEqual(set(labels.agreement().values()), {1.0})
        frame, coco = self.ocean.frame, pelagos.Coco()

        def meddled(*given, **more):  # somebody sets a field before each
            with Ocean(self.url, timeout=PATIENCE_S) as other:
                other["sea.level"] = 0.1 + (other["sea.level"] or 0) % 1
            return frame(*given, **more)
        self.ocean.frame = meddled
        with self.assertRaises(pelagos.Conflict):
            self.ocean.views["bow"].labels(width=16, height=16, image=False)
        self.ocean.frame = frame
        self.assertEqual(coco.add_labels(labels, "a.png"), 1)
        with tempfile.NamedTemporaryFile(suffix=".json") as file:
            coco.save(file.name)
        self.assertEqual({a["entity"] for a in coco.annotations},
                         set(labels.visible_ids()))


class Names(Case):
    def test_handles_are_taken_where_names_are(self):
        o, view = self.ocean, self.ocean.views["bridge"]
        self.assertEqual((view.name, view.key), ("bridge", "bridge"))
        self.assertEqual(o.frame(view, width=16, height=16).view, "bridge")
        self.assertEqual(list(o.frames([view], width=16, height=16)),
                         ["bridge"])
        np.testing.assert_array_equal(o.image(view), view.image())
        truth, ids = pelagos.shot(o, view)
        self.assertEqual((truth["view"], ids.shape), ("bridge", (96, 160)))
        frame = o.frame("bridge", width=16, height=16)
        self.assertEqual(frame.host_frame, frame.host)
        ship = o.entities["ownship"]
        self.assertEqual((ship.id, ship.name, ship.key), (1, "ownship", "1"))
        o.entities.add(4)
        self.assertEqual((o.entities.ids(), o.entities.names()),
                         ([1, 4], ["ownship", ""]))
        self.assertEqual([e.id for e in o.entities], o.entities.ids())
        self.assertEqual([v.name for v in o.views], o.views.names())

    def test_elements_of_every_list(self):
        o = self.ocean
        o["sea.areas"] = [pelagos.Area(radius=50), {"radius": 60}]
        o["sea.areas.1.factor"] = 0.5
        o["sky.fog"] = [{"visibility": 900}]
        o["sky.fog.0.top"] = 70
        o["sea.wave"] = [[1, 9, 0, 0]]
        o["sea.wave.0"] = [2, 8, 10, 0]
        o.entities.add(7, name="mark", model={"name": "beacon"}, light={
            "character": "Fl 3s", "sectors": [{"begin": 0, "end": 90}]})
        o["entities.mark.light.sectors.0.end"] = 100
        o.entities[7]["light.sectors.0.begin"] = 10
        state = o.state()
        sector = state.entities[1].light.sectors[0]
        self.assertEqual(
            ([a.factor for a in state.sea.areas], state.sky.fog[0].top,
             state.sky.fog[0].visibility, state.sea.wave[0].height,
             sector.begin, sector.end), ([0.3, 0.5], 70, 900, 2, 10, 100))
        del o["sea.areas.0"]
        self.assertEqual([a.radius for a in o.state().sea.areas], [60])
        for path in ("sea.areas.4.factor", "sky.fog.x.top"):
            with self.assertRaises(LookupError):
                o[path] = 1
        with self.assertRaises(pelagos.NotFound):
            o["sea.areas.0.radus"] = 3
        o["view.bridge.yaw"] = 5  # `view` for `views`, and schema's names
        o["sea.wind_speed"] = 7
        self.assertEqual((o["views.bridge.yaw"], o["sea.windSpeed"]), (5, 7))

    def test_everything_is_exported(self):
        for name in pelagos.__all__:
            self.assertTrue(hasattr(pelagos, name), name)
        import dataclasses
        for field in dataclasses.fields(pelagos.State):
            kind = field.type.split("[")[-1].split(" ")[0].split(",")[0]
            if kind not in ("int", "tuple"):
                self.assertIn(kind, pelagos.__all__)


if __name__ == "__main__":
    unittest.main(verbosity=2)
