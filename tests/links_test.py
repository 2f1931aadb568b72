#!/usr/bin/python3
"""No file leads out: of every kind of file in a directory of the daemon's, and
of the files that belong to one, a link that leads out of the directory is not
read, and one that stays in it is as the file."""
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import models_test as models
import panorama_test as panorama
import spectrum_files_test as spectra
import weather_forecast as forecast
from pelagos_daemon import BIN, SLOW_S, Daemon, until

SIDE = 50


def made(write, ending):
    """The bytes of what a maker of files writes."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "made" + ending)
        write(path)
        with open(path, "rb") as f:
            return f.read()


def historical(stem):
    with tempfile.TemporaryDirectory() as folder:
        spectra.historical(folder)
        out = {}
        for name in os.listdir(folder):
            with open(os.path.join(folder, name), "rb") as f:
                out[stem + name[len("tst"):]] = f.read()
        return out


def realtime(stem):
    with tempfile.TemporaryDirectory() as folder:
        spectra.realtime(folder, True)
        out = {}
        for name in os.listdir(folder):
            with open(os.path.join(folder, name), "rb") as f:
                out[stem + name[len("dir"):]] = f.read()
        return out


def weather(path):
    lats, lons = forecast.grid(-2, 57, 15, 11, 1)
    forecast.write_netcdf(path, forecast.FIELDS, lats, lons, [0, 1])


def recording():
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "r.pelog")
        with Daemon("--record", path) as daemon:
            daemon.patch({"sky": {"visibility": 7000}})
        with open(path, "rb") as f:
            return f.read()


ASC = (f"ncols {SIDE}\nnrows {SIDE}\nxllcorner 5.1\nyllcorner 52.5\n"
       "cellsize 0.01\n" + "\n".join(["-9 " * SIDE] * SIDE)).encode()
ENVI = (f"ENVI\nsamples = {SIDE}\nlines = {SIDE}\nbands = 1\n"
        "header offset = 0\nfile type = ENVI Standard\ndata type = 4\n"
        "interleave = bsq\nbyte order = 0\n").encode()


class Links(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        top = tempfile.TemporaryDirectory()
        cls.addClassCleanup(top.cleanup)
        cls.top = top.name
        options = []
        for kind in ("spectra", "bathymetry", "weather", "panoramas", "models",
                     "exercises", "recordings"):
            for side in ("in", "out"):
                os.makedirs(os.path.join(cls.top, side, kind))
            options += ["--" + kind, os.path.join(cls.top, "in", kind)]
        cls.options = options
        cls.daemon = Daemon(*options)
        cls.addClassCleanup(cls.daemon.stop)

    def test_all_directories_are_tried(self):
        """A new one needs its case here."""
        said = subprocess.run([os.path.join(BIN, "pelagosd"), "--help"],
                              capture_output=True, text=True,
                              timeout=SLOW_S).stdout
        self.assertEqual(set(re.findall(r"--(\S+)[ =]DIRECTORY", said)),
                         {o[2:] for o in self.options[::2]}, said)

    def at(self, side, kind, name=""):
        return os.path.join(self.top, side, kind, name)

    def put(self, side, kind, files):
        for name, data in files.items():
            with open(self.at(side, kind, name), "wb") as f:
                f.write(data)

    def link(self, kind, stem, files, of, target):
        """As `stem`, links to what is there as `of`: target(name)."""
        for name in files:
            os.symlink(target(of + name[len(stem):]), self.at("in", kind, name))

    def kind(self, kind, files, ask):
        """files(stem): name → bytes; ask(stem): None, or why it is refused."""
        self.put("in", kind, files("own"))
        self.put("out", kind, files("secret"))
        os.symlink(self.at("out", kind), self.at("in", kind, "folder"))
        self.assertIsNone(ask("own"))
        # Chosen last, it is what all refusals leave.
        within = {"near": lambda name: name,
                  "round": lambda name: f"../{kind}/{name}",
                  "whole": lambda name: self.at("in", kind, name)}
        for stem, target in within.items():
            self.link(kind, stem, files(stem), "own", target)
            self.assertIsNone(ask(stem), stem)
        out = {"away": lambda name: f"../../out/{kind}/{name}",
               "gone": lambda name: self.at("out", kind, name)}
        for stem, target in out.items():
            self.link(kind, stem, files(stem), "secret", target)
            said = ask(stem)
            self.assertIsNotNone(said, stem)
            self.assertIn("link out of", said, stem)
        said = ask("folder/secret")
        self.assertIsNotNone(said)

    def without(self, kind, stem, files, away):
        """Those of `away` lead out, the others are there."""
        self.put("in", kind, {name: data for name, data in files.items()
                              if name not in away})
        self.put("out", kind, {name: files[name] for name in away})
        for name in away:
            os.symlink(self.at("out", kind, name), self.at("in", kind, name))

    def patched(self, change):
        answer = self.daemon.patch(change)
        return None if answer.status == 200 else answer.body.decode()

    def measured(self, name):
        return self.patched({"sea": {"spectrum": "MEASURED", "measured": name}})

    def model(self, name):
        return self.patched({"entities": {"1": {"model": {"name": name}}}})

    def seabed(self, name, **more):
        return self.patched({"seabed": {"file": name, **more}})

    def test_spectra(self):
        data = made(spectra.swan, ".spec")
        self.kind("spectra", lambda stem: {stem + ".spec": data},
                  lambda stem: self.measured(stem + ".spec#1"))

    def test_buoys(self):
        """Of NDBC, whose directions are files of their own."""
        self.kind("spectra", realtime, self.measured)
        os.remove(self.at("in", "spectra", "folder"))
        self.without("spectra", "part", realtime("part"), ["part.swdir"])
        self.assertIn("link out of", self.measured("part"))

    def test_buoys_of_a_year(self):
        self.kind("spectra", historical,
                  lambda stem: self.measured(stem + "w2020.txt"))
        os.remove(self.at("in", "spectra", "folder"))
        companions = [f"part{letter}2020.txt" for letter in "dijk"]
        self.without("spectra", "part", historical("part"), companions)
        if self.measured("partw2020.txt") is None:  # without directions
            self.assertIsNone(self.measured("ownw2020.txt"))
            own = self.daemon.get("/v1/spectrum").json()["meanDirection"]
            self.assertIsNone(self.measured("partw2020.txt"))
            self.assertNotAlmostEqual(
                self.daemon.get("/v1/spectrum").json()["meanDirection"], own, 0)

    def test_seabed(self):
        self.patched({"origin": {"latitude": 52.6, "longitude": 5.2}})
        self.kind("bathymetry", lambda stem: {stem + ".asc": ASC},
                  lambda stem: self.seabed(stem + ".asc"))
        place = {"latitude": 52.5, "longitude": 5.1, "spacing": 10}
        raw = np.full((SIDE, SIDE), -9, "<f4").tobytes()
        files = {"raw.bin": raw, "raw.hdr": ENVI}
        self.put("in", "bathymetry", files)
        self.assertIsNone(self.seabed("raw.bin", **place))
        self.without("bathymetry", "part", {
            "part.bin": raw, "part.hdr": ENVI}, ["part.hdr"])
        self.assertIsNotNone(self.seabed("part.bin", **place))

    def test_weather(self):
        data = made(weather, ".nc")
        self.kind("weather", lambda stem: {stem + ".nc": data},
                  lambda stem: self.patched({"sea": {
                      "spectrum": "ELFOUHAILY", "measured": None,
                      "field": {"file": stem + ".nc"}}}))

    def test_panoramas(self):
        data = panorama.radiance(panorama.picture(), True)
        self.kind("panoramas", lambda stem: {stem + ".hdr": data},
                  lambda stem: self.patched({"sky": {"file": stem + ".hdr"}}))

    def test_models(self):
        self.kind("models", lambda stem: {stem + ".glb": models.glb()},
                  lambda stem: self.model(stem + ".glb"))
        # The description.
        self.without("models", "told", {
            "told.glb": models.glb(), "told.json": b'{"length": 20}'},
            ["told.json"])
        self.assertIn("link out of", self.model("told.glb"))
        # A buffer.
        tree, binary = models.gltf(buffers=[{"byteLength": 168,
                                             "uri": "part.bin"}])
        files = {"part.gltf": json.dumps(tree).encode(), "part.bin": binary}
        self.without("models", "part", files, ["part.bin"])
        self.assertIsNotNone(self.model("part.gltf"))
        # Material and texture: the shape stands without them.
        obj = models.obj("skin.png").replace("wedge.mtl", "{}.mtl")
        mtl = b"newmtl paint\nKd 1 1 1\nmap_Kd skin.png\n"
        self.put("in", "models", {"bare.obj": obj.format("none").encode()})
        self.without("models", "mtl", {
            "mtl.obj": obj.format("mtl").encode(), "mtl.mtl": mtl},
            ["mtl.mtl"])
        self.without("models", "skin", {
            "skin.obj": obj.format("skin").encode(), "skin.mtl": mtl,
            "skin.png": models.png(64, 32)}, ["skin.png"])
        os.makedirs(self.at("in", "models", "whole"))
        self.put("in", "models", {
            "whole/skin.obj": obj.format("skin").encode(),
            "whole/skin.mtl": mtl, "whole/other.png": models.png(64, 32)})
        os.symlink("other.png", self.at("in", "models", "whole/skin.png"))

        def listed():
            names = self.daemon.get("/v1/models").json()["models"]
            return not any("ask again" in m.get("text", "")
                           for m in names) and {m["name"]: m for m in names}
        of = until("all are read", listed)
        self.assertNotIn("error", of["skin.obj"])
        texture = 64 * 32 * 4
        self.assertGreaterEqual(int(of["whole/skin.obj"]["bytes"]),
                                int(of["bare.obj"]["bytes"]) + texture)
        for name in ("skin.obj", "mtl.obj"):
            self.assertLess(int(of[name]["bytes"]),
                            int(of["bare.obj"]["bytes"]) + texture, name)
        self.assertFalse([n for n in of if n.startswith("folder/")])

    def test_exercises(self):
        data = json.dumps({"title": "one", "ownShip": 1, "state": {
            "entities": [{"id": 1, "latitude": 52.6, "longitude": 5.2}]
            }}).encode()

        def ask(stem):
            answer = self.daemon.get("/v1/exercises/" +
                                     stem.replace("/", "%2F"))
            loaded = self.daemon.request("POST", "/v1/exercise", {
                "action": "LOAD", "name": stem})
            self.assertEqual(answer.status == 200, loaded.status == 200, stem)
            return None if answer.status == 200 else answer.body.decode()
        self.kind("exercises", lambda stem: {stem + ".json": data}, ask)
        of = {e["name"]: e for e in
              self.daemon.get("/v1/exercises").json()["exercises"]}
        self.assertEqual({n for n, e in of.items() if "error" not in e},
                         {"own", "near", "round", "whole"})

    def test_recordings(self):
        data = recording()

        def ask(stem):
            answer = self.daemon.request("PATCH", "/v1/debrief", {
                "recording": stem + ".pelog"})
            if answer.status != 200:
                return answer.body.decode()
            now = until("it is read", lambda: not (
                now := self.daemon.get("/v1/debrief").json())["busy"] and
                now["state"] not in ("OPENING", "CLOSING") and now)
            return now.get("error")
        self.kind("recordings", lambda stem: {stem + ".pelog": data}, ask)
        self.daemon.request("PATCH", "/v1/debrief", {"close": True})
        names = {s for r in self.daemon.get(
            "/v1/recordings").json()["recordings"] for s in [r["name"]]}
        self.assertFalse(names & {"away", "away.pelog", "gone", "gone.pelog"})


if __name__ == "__main__":
    unittest.main(verbosity=2)
