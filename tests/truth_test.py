#!/usr/bin/python3
"""Ground truth of pictures: boxes and counts against the layer id of the same
moment, what is hidden against the same entity drawn alone, corners against the
client's own camera."""
import csv
import json
import math
import os
import pathlib
import sys
import tempfile
import unittest
import urllib.request

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import ROOT, Daemon

sys.path.insert(0, str(pathlib.Path(ROOT) / "clients/python"))
sys.dont_write_bytecode = True
import pelagos

# Metres north and east of the origin to degrees there.
NORTH = 1 / 111_290.0
EAST = 1 / (111_320.0 * math.cos(math.radians(52.6)))


def ship(number, name, north, east, heading, **more):
    return {"id": number, "latitude": 52.6 + north * NORTH,
            "longitude": 5.2 + east * EAST, "heading": heading,
            "model": {"name": name}, **more}


CAMERA = {"name": "eye", "up": 5,
          "yaw": 0, "pitch": -2, "fieldOfView": 60, "width": 480,
          "height": 270}
SHIPS = [ship(7, "tanker", 900, 60, 80), ship(8, "tug", 180, 0, 40),
         ship(9, "cardinal-north", 120, -30, 0),
         ship(65535, "ferry", 500, 330, 120), ship(3, "rib", -50, 0, 0)]


class Truth(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.addClassCleanup(cls.daemon.stop)
        # A busy machine compiles the first picture's shaders for 30 s and more.
        cls.ocean = pelagos.Ocean(cls.daemon.url(""), timeout=120)
        cls.addClassCleanup(cls.ocean.close)

    def scene(self, ships, wind=1, **more):
        self.ocean.patch({"clock": {"mode": "STEPPED", "time": 12},
                          "sea": {"windSpeed": wind}, "views": [CAMERA],
                          "entities": ships, **more})

    def both(self):
        """Truth, and the layer id as numbers plus one."""
        exr = self.ocean.frame("eye", "exr", layers=("id",)).exr()
        frame = self.ocean.frame("eye", "json")
        ids = next(iter(exr.layers.values())).astype(np.int64)
        return frame.truth(), ids

    def test_boxes_are_the_id_layers(self):
        for wind in 0.5, 14:
            self.scene(SHIPS, wind)
            truth, ids = self.both()
            found = {e["id"]: e for e in truth["entities"]}
            shown = set((np.unique(ids[ids > 0]) - 1).tolist())
            self.assertGreaterEqual(shown, {7, 8, 9, 65535})
            self.assertEqual(shown, {i for i in found
                                     if found[i]["pixels"] > 0})
            self.assertNotIn(3, found, "it is astern")
            for number in shown:
                rows, columns = np.nonzero(ids == number + 1)
                box = found[number]["visible"]
                self.assertEqual(found[number]["pixels"], len(rows))
                self.assertEqual(
                    [box["x"], box["y"], box["width"], box["height"]],
                    [columns.min(), rows.min(), np.ptp(columns) + 1,
                     np.ptp(rows) + 1])
            self.assertTrue(found[65535]["truncated"])
            self.assertFalse(found[8]["truncated"])

    def test_hidden_share_is_that_of_the_entity_alone(self):
        near = [ship(7, "tanker", 400, 0, 80), SHIPS[1]]
        self.scene(near[:1], 0.5)
        _, alone = self.both()
        self.scene(near, 0.5)
        truth, ids = self.both()
        tanker, tug = ({e["id"]: e for e in truth["entities"]}[i]
                       for i in (7, 8))
        mask = alone == 8
        whole = tanker["wholePixels"]
        # In ripples of millimetres the sea cuts the hull where its waterline
        # is; levels of detail may differ by half a pixel here and there: one
        # pixel in a hundred.
        rim = 0.01 * mask.sum()
        self.assertLess(abs(whole - mask.sum()), rim)
        hidden = 1 - (ids[mask] == 8).sum() / mask.sum()
        self.assertGreater(hidden, 0.03)
        self.assertLess(abs(tanker["hidden"] - hidden), rim / mask.sum())
        self.assertLess(tug["hidden"], 0.05)

    def test_points_are_the_cameras(self):
        self.scene(SHIPS)
        truth, _ = self.both()
        camera = pelagos.Camera.of_exr(
            self.ocean.frame("eye", "exr", layers=("id",)).exr())
        k, r = camera.intrinsics.K, camera.rotation
        for entity in truth["entities"]:
            self.assertEqual(len(entity["corners"]), 8)
            for p in entity["corners"] + entity["waterline"]:
                seen = np.array([p["right"], p["down"], p["ahead"]])
                world = np.array([p["east"], p["north"], p["up"]])
                flat = r @ (world - np.asarray(camera.position))
                # 1 km is 8 cm down the Earth's curve.
                np.testing.assert_allclose(seen, flat, atol=0.1)
                if seen[2] > 0:
                    u, v, w = k @ seen
                    self.assertAlmostEqual(p["x"], u / w, delta=0.02)
                    self.assertAlmostEqual(p["y"], v / w, delta=0.02)
        tug = next(e for e in truth["entities"] if e["id"] == 8)
        self.assertAlmostEqual(tug["distance"], math.hypot(180, 5), delta=2)
        self.assertLess(min(tug["bearing"], 360 - tug["bearing"]), 0.5)
        self.assertEqual((tug["class"], tug["model"]), ("TUG", "tug"))
        self.assertAlmostEqual(tug["heading"], 40)

    def test_headers_and_moment_are_the_pictures(self):
        self.scene(SHIPS)
        url = self.daemon.url("/v1/views/eye/frame.")
        heads = []
        for form in "png", "json":
            with urllib.request.urlopen(url + form + "?time=20") as answer:
                data = answer.read()
                heads.append([answer.headers["X-Pelagos-" + name] for name in
                              ("Frame", "Time", "Revision", "Stale")])
        self.assertEqual(heads[0], heads[1])
        truth = json.loads(data)
        self.assertEqual(truth["time"], 20)
        with urllib.request.urlopen(url + "json?time=20") as answer:
            self.assertEqual(answer.read(), data)
            self.assertEqual(answer.headers["Content-Type"],
                             "application/json")

    def test_coco(self):
        self.scene(SHIPS)
        coco = pelagos.Coco()
        shots = [pelagos.shot(self.ocean, "eye", time=t) for t in (5, 9)]
        for number, shot in enumerate(shots):
            coco.add(*shot, f"{number}.jpg")
        data = json.loads(json.dumps(coco.to_json()))
        self.assertEqual([i["id"] for i in data["images"]], [1, 2])
        names = {c["id"]: c["name"] for c in data["categories"]}
        self.assertEqual(len(names), len(data["categories"]))
        numbers = [a["id"] for a in data["annotations"]]
        self.assertEqual(sorted(set(numbers)), numbers)
        for a in data["annotations"]:
            _, ids = shots[a["image_id"] - 1]
            # Read as the format is published: runs down the columns, of what
            # is outside first.
            counts, (high, wide) = (a["segmentation"][k]
                                    for k in ("counts", "size"))
            flat = np.repeat(np.arange(len(counts)) % 2, counts)
            mask = flat.reshape(wide, high).T
            np.testing.assert_array_equal(mask, ids == a["entity"] + 1)
            self.assertEqual(a["area"], mask.sum())
        found = {names[a["category_id"]] for a in data["annotations"]}
        self.assertEqual(found, {"tanker", "tug", "ferry", "cardinal-north"})
        with self.assertRaises(ValueError):
            coco.add(shots[0][0], shots[0][1] * 0, "another moment.jpg")

    def test_positions(self):
        self.scene([ship(7, "tanker", 900, 60, 80, speed=8, course=85)])
        truths = [self.ocean.views["eye"].truth(time=t) for t in (12, 22)]
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "positions.csv")
            pelagos.positions_csv(truths, path)
            with open(path, encoding="utf-8", newline="") as file:
                rows = list(csv.DictReader(file))
        self.assertEqual([float(r["time"]) for r in rows], [12, 22])
        north, east = ((float(rows[1][k]) - float(rows[0][k])) / s for k, s in
                       (("latitude", NORTH), ("longitude", EAST)))
        self.assertAlmostEqual(north, 80 * math.cos(math.radians(85)), delta=.3)
        self.assertAlmostEqual(east, 80 * math.sin(math.radians(85)), delta=.5)

    def test_nothing_there(self):
        self.scene([])
        self.assertEqual(self.both()[0].get("entities", []), [])


if __name__ == "__main__":
    unittest.main()
