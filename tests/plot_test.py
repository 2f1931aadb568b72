#!/usr/bin/python3
"""pelagosctl plot: every kind as SVG and PNG, by readers of others; what is drawn
are the numbers of the series; what is wrong is said."""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

import numpy as np
from PIL import Image

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import BIN, ROOT, Daemon

sys.path.insert(0, os.path.join(ROOT, "clients/python"))
from pelagos import Ocean, plot, read_exr

KINDS = {
    "rrs": (["--sweep", "chlorophyll=0.1,1", "sunZenith=40"],
            "Remote-sensing reflectance", ["wavelength λ [nm]", "sr⁻¹",
                                           "chlorophyll 0.1 mg/m³",
                                           "chlorophyll 1 mg/m³", "Sun 40°"]),
    "brdf": (["sea.windSpeed=6"], "BRDF", ["sr⁻¹", "wind 6 m/s",
                                           "Sun’s elevation 15°",
                                           "Sun’s elevation 60°"]),
    "rose": (["sea.spectrum=JONSWAP", "sea.windSpeed=14"],
             "Directional spectrum", ["m² s rad⁻²", "Hs ", "JONSWAP, wind 14",
                                      "0.08 Hz|0.1 Hz"]),
    "height": (["--at", "20,-5", "--seconds", "60"], "Height of the surface",
               ["height [m]", "Hs [m]", "simulated time [s]", "20 m east",
                "of the spectrum: "]),
    "rows": (["--view", "bridge"], "Radiance by rows",
             ["W m⁻² sr⁻¹ nm⁻¹", "680 nm", "550 nm", "440 nm", "level"]),
}


class Plots(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(unix=True)
        cls.addClassCleanup(cls.daemon.stop)
        cls.daemon.patch({
            "clock": {"mode": "STEPPED"}, "sea": {"synthesiser": "TROCHOIDS"},
            "views": [{"name": "bridge", "entity": 1, "width": 160,
                       "height": 120}]})
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name

    def ctl(self, *words, status=0, program=None, **environment):
        done = subprocess.run(
            [program or os.path.join(BIN, "pelagosctl"), "--server",
             "unix:" + self.daemon.unix_path, *words], capture_output=True,
            env={**os.environ, **environment})
        text = done.stderr.decode()
        self.assertEqual(done.returncode, status, text)
        return text

    def file(self, name):
        return os.path.join(self.folder, name)

    def text_of(self, path):
        return "\n".join("".join(e.itertext())
                         for e in ElementTree.parse(path).iter(
                             "{http://www.w3.org/2000/svg}text"))

    def test_svg(self):
        for kind, (words, title, shown) in KINDS.items():
            with self.subTest(kind):
                path = self.file(kind + ".svg")
                self.ctl("plot", kind, "-o", path, *words)
                tree = ElementTree.parse(path)
                text = self.text_of(path)
                self.assertIn(title, text)
                for words_shown in shown:
                    self.assertRegex(text, "|".join(
                        re.escape(w) for w in words_shown.split("|")))
                said = tree.find(".//{http://purl.org/dc/elements/1.1/}"
                                 "description").text
                if kind == "rows":
                    self.assertEqual(json.loads(said)["pelagos.view"], "bridge")
                else:
                    self.assertRegex(said, r"pelagosd \d+\.\d+")
                    query = json.loads(said.split(": ", 1)[1].split("; 20")[0])
                    self.assertTrue({"optics", "spectrum", "surface"} &
                                    set(query))
                made = self.file(kind + "-of-svg.png")
                subprocess.run(["rsvg-convert", "-o", made, path], check=True)
                self.looks_drawn(made)

    def looks_drawn(self, path):
        with Image.open(path) as image:
            image.load()
            pixels = np.asarray(image.convert("RGBA"), float)
        grey = pixels[..., :3].mean(-1) * pixels[..., 3] / 255 + (
            255 - pixels[..., 3])
        ink = (grey < 160).mean()
        self.assertGreater(ink, 0.004, path)
        self.assertLess(ink, 0.4, path)
        colourful = (np.ptp(pixels[..., :3], axis=-1) > 60) & (
            pixels[..., 3] > 0)
        self.assertGreater(colourful.mean(), 0.002, path)

    def test_png(self):
        for kind in ("rose", "height", "rows"):
            words, title, _ = KINDS[kind]
            with self.subTest(kind):
                path = self.file(kind + ".png")
                self.ctl("plot", kind, "-o", path, *words)
                self.looks_drawn(path)
                with Image.open(path) as image:
                    self.assertIn(title, image.text["Title"])
                    self.assertRegex(image.text["Software"], r"pelagos \d")
                    self.assertIn("sunElevation" if kind == "rows" else
                                  '"over"' if kind != "rose" else "JONSWAP",
                                  image.text["Description"])
                    self.assertGreaterEqual(min(image.size), 700)

    def test_the_same_numbers_are_the_same_bytes(self):
        for name in ("a.svg", "b.svg"):
            self.ctl("plot", "rows", "-o", self.file(name))
        with open(self.file("a.svg"), "rb") as a, \
                open(self.file("b.svg"), "rb") as b:
            self.assertEqual(a.read(), b.read())

    def test_what_is_drawn_are_the_numbers(self):
        ocean = Ocean(self.daemon.url()[:-1])
        s = ocean.series("water", {"chlorophyll": [0.2, 2],
                                   "wavelength": slice(400, 700, 50)})
        axes = plot.rrs(s).axes[0]
        for line, row in zip(axes.get_lines(), s["remoteSensingReflectance"]):
            np.testing.assert_array_equal(line.get_xdata(), s["wavelength"])
            np.testing.assert_allclose(line.get_ydata(), row * 1e3)
        s = ocean.series("brdf", {"sunElevation": [30], "viewAzimuth": [0, 180],
                                  "viewZenith": slice(0, 80, 10)},
                         patch={"sky": {"sunAzimuth": 180}})
        line = plot.brdf(s).axes[0].get_lines()[0]
        angles, radius = np.degrees(line.get_xdata()), line.get_ydata()
        top = 10 ** np.ceil(np.log10(s["brdf"].max()))
        at = {round(a): r for a, r in zip(angles, radius)}
        for k, zenith in enumerate(s["viewZenith"]):
            for side, sign in ((0, 1), (1, -1)):
                wanted = max(np.log10(s["brdf"][0, side, k] / top) + 6, 0)
                if zenith:
                    self.assertAlmostEqual(at[round(sign * zenith)], wanted)
        s = ocean.series("surface", {"time": slice(0, 60, 0.5)},
                         points=[[3, 4]])
        whole = ocean.series("spectrum")
        upper, lower = plot.height(s, whole).axes
        np.testing.assert_array_equal(upper.get_lines()[1].get_ydata(),
                                      s["height"][:, 0])
        hs = lower.get_lines()[0].get_ydata()
        self.assertAlmostEqual(hs[0], 4 * s["height"][:24, 0].std(), places=12)
        self.assertEqual(lower.get_lines()[2].get_ydata()[0],
                         whole["spectrum_significantHeight"])
        picture = read_exr(self.daemon.get(
            "/v1/views/bridge/frame.exr").body)
        lines = plot.rows(picture).axes[0].get_lines()
        for k in range(3):
            np.testing.assert_allclose(
                lines[k].get_xdata(),
                picture.layers["radiance"][..., k].mean(1), rtol=1e-6)

    def test_the_rows_have_their_elevations(self):
        """The horizon of the picture is at the drawn elevation of the dip."""
        picture = read_exr(self.daemon.get(
            "/v1/views/bridge/frame.exr?height=480&layers=radiance,depth").body)
        line = plot.rows(picture).axes[0].get_lines()[0]
        elevation = line.get_ydata()
        sea = np.isfinite(picture.layers["depth"]).mean(1)
        row = int(np.argmax(sea > 0.5))
        # 10 m above the sea: a dip of 0.1 deg; rows are 0.08 deg.
        self.assertAlmostEqual(elevation[row], -0.10, delta=0.15)
        self.assertGreater(elevation[0], elevation[-1])

    def test_refusals(self):
        for words, status, said in (
                (["plot", "pie", "-o", "a.svg"], 2, "rrs, brdf, rose"),
                (["plot", "rrs"], 2, "--output"),
                (["plot", "rrs", "-o", "a.pdf"], 2, ".svg or a .png"),
                (["plot", "rrs", "-o", "a.svg", "sunZenit=4"], 2, "sunZenith"),
                (["plot", "rrs", "-o", "a.svg", "sunZenith=94"], 4, "90"),
                (["plot", "rose", "-o", "a.svg", "--sweep", "windSpeed=1,2"], 2,
                 "rrs and brdf"),
                (["plot", "rose", "-o", "a.svg", "sea.windspeed=1"], None,
                 "windSpeed"),
                (["plot", "height", "-o", "a.svg", "sea.windSpeed=1"], 2,
                 "pelagosctl set"),
                (["plot", "height", "-o", "a.svg", "--at", "1"], 2,
                 "EAST,NORTH"),
                (["plot", "rows", "-o", "a.svg", "--view", "cellar"], 4,
                 "cellar"),
                (["plot", "rose", "-o", "/nowhere/a.svg"], 1, "/nowhere"),
                (["plot", "rose", "-o", self.file("flat.svg"),
                  "sea.windSpeed=0"], 1, "no waves")):
            done = subprocess.run(
                [os.path.join(BIN, "pelagosctl"), "--server",
                 "unix:" + self.daemon.unix_path, *words], capture_output=True,
                text=True, cwd=self.folder)
            self.assertIn(said, done.stderr, words)
            if status is not None:
                self.assertEqual(done.returncode, status, (words, done.stderr))
            self.assertNotIn("Traceback", done.stderr)
            self.assertFalse(os.path.exists(self.file("a.svg")), words)

    def test_without_the_packages(self):
        alone = self.file("alone")
        os.mkdir(alone)
        shutil.copy(os.path.join(BIN, "pelagosctl"), alone)
        text = self.ctl("plot", "rose", "-o", self.file("c.svg"), status=1,
                        program=os.path.join(alone, "pelagosctl"),
                        PATH="/nowhere")
        self.assertIn("apt install python3-pelagos python3-matplotlib", text)
        # A matplotlib that cannot be imported, before the system's.
        with open(os.path.join(alone, "matplotlib.py"), "w") as f:
            f.write("raise ImportError('not here')\n")
        series = self.daemon.get("/v1/series/spectrum?frequencies=20&"
                                 "directions=12").body
        done = subprocess.run(
            ["/usr/bin/python3", "-m", "pelagos.plot", "rose",
             self.file("c.svg")], input=series, capture_output=True,
            env={**os.environ, "PYTHONPATH": alone + ":" + os.path.join(
                ROOT, "clients/python")})
        self.assertEqual(done.returncode, 3)
        self.assertIn(b"apt install python3-matplotlib", done.stderr)

    def test_a_series_from_elsewhere(self):
        """curl and pelagos-plot, without pelagosctl."""
        series = self.daemon.get("/v1/series/water?sweep=wavelength=400:700:20")
        path = self.file("piped.svg")
        command = [os.path.join(BIN, "pelagos-plot"), "rrs", path]
        subprocess.run(command, input=series.body, check=True)
        self.assertIn("Remote-sensing", self.text_of(path))
        sky = self.daemon.get("/v1/series/sky?sweep=elevation=0:90:30").body
        done = subprocess.run(command, input=sky, capture_output=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn(b"has no wavelength" if b"wavelength" not in sky else
                      b"remoteSensingReflectance", done.stderr)


if __name__ == "__main__":
    unittest.main()
