#!/usr/bin/python3
"""What files of pictures say of time, place, camera, sea and water, read by
exiftool and OpenEXR's exrheader. Live streams say nothing."""
import contextlib
import http.client
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import ROOT, Daemon

sys.path.insert(0, os.path.join(ROOT, "clients/python"))
sys.dont_write_bytecode = True
import pelagos

STATE = {
    "sea": {"windSpeed": 9, "windDirection": 200, "spectrum": "JONSWAP",
            "swell": [[1.5, 12, 240, 10]], "level": 0.5},
    "water": {"chlorophyll": 0.6, "cdom": 0.03, "minerals": 0.25,
              "salinity": 33, "temperature": 11, "depth": 80},
    "clock": {"mode": "STEPPED"},
}


def exiftool(path):
    text = subprocess.run(["exiftool", "-json", "-n", "-G1", "-struct", path],
                          check=True, capture_output=True, text=True).stdout
    return json.loads(text)[0]


class Notes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.folder = tempfile.TemporaryDirectory()
        answer = cls.daemon.request("PATCH", "/v1/state",
                                    json.dumps(STATE).encode())
        assert answer.status == 200, answer
        name = cls.daemon.get("/v1/state").json()["views"][0]["name"]
        cls.view = f"/v1/views/{name}"
        cls.name = name
        answer = cls.daemon.request(
            "PATCH", "/v1/state",
            json.dumps({"views": {name: {"yaw": 30, "pitch": -4, "roll": 2,
                                         "fieldOfView": 50}}}).encode())
        assert answer.status == 200, answer

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()
        assert cls.daemon.stop() == 0

    def keep(self, ending, query="width=160&height=90"):
        answer = self.daemon.get(f"{self.view}/frame.{ending}?{query}")
        self.assertEqual(answer.status, 200, answer)
        path = os.path.join(self.folder.name, "picture." + ending)
        with open(path, "wb") as file:
            file.write(answer.body)
        return path

    def exr(self, query=""):
        text = subprocess.run(
            ["exrheader", self.keep("exr", "width=160&height=90" + query)],
            check=True, capture_output=True, text=True).stdout
        notes = dict(re.findall(r'^(\S+) \(type string\): "(.*)"$', text, re.M))
        notes.update((name, float(value)) for name, value in re.findall(
            r"^(\S+) \(type (?:double|float)\): (\S+)$", text, re.M))
        return notes

    def test_an_exr_says_all_of_sea_water_and_camera(self):
        notes = self.exr("&layers=radiance,depth,slopeVariance")
        spectrum = self.daemon.get("/v1/spectrum").json()
        ours = spectrum["spectrum"]["significantHeight"]
        self.assertAlmostEqual(notes["pelagos.significantHeight"], ours, 4)
        self.assertAlmostEqual(notes["pelagos.peakPeriod"],
                               spectrum["peakPeriod"], 4)
        self.assertAlmostEqual(notes["pelagos.waveDirection"],
                               spectrum["meanDirection"], 2)
        self.assertEqual(notes["pelagos.spectrum"], "JONSWAP")
        self.assertEqual(notes["pelagos.swell"],
                         "1.5 m, 12 s, from 240 deg, spread 10 deg")
        self.assertEqual(notes["pelagos.seaLevel"], 0.5)
        self.assertEqual(notes["pelagos.water"], "constituents")
        for name, value in (("chlorophyll", 0.6), ("cdom", 0.03),
                            ("minerals", 0.25), ("salinity", 33),
                            ("waterTemperature", 11), ("waterDepth", 80)):
            self.assertAlmostEqual(notes["pelagos." + name], value, 6, name)
        water = self.daemon.get("/v1/optics/water").json()["water"]
        for name in ("absorption", "scattering"):
            for got, want in zip(notes["pelagos." + name].split(),
                                 water[name], strict=True):
                self.assertLess(abs(float(got) / want - 1), 1e-5, name)
        self.assertEqual(notes["pelagos.wavelengths"], "680 550 440")
        self.assertEqual(notes["pelagos.bandwidths"], "0 0 0")
        self.assertEqual(notes["pelagos.unit.depth"], "m")
        self.assertIn("sr", notes["pelagos.unit.radiance"])
        self.assertEqual(notes["pelagos.unit.slopeVariance"], "1")
        self.assertNotIn("pelagos.unit.normal", notes)
        self.assertEqual(notes["pelagos.projection"], "rectilinear")
        self.assertAlmostEqual(notes["pelagos.horizontalField"], 50, 2)
        self.assertAlmostEqual(
            math.tan(math.radians(notes["pelagos.verticalField"] / 2)) * 16 / 9,
            math.tan(math.radians(25)), 3)
        self.assertRegex(notes["software"], r"^pelagosd \d+\.\d+\.\d+")
        heading, pitch, roll = self.pose()
        self.assertAlmostEqual(notes["pelagos.heading"], heading, 3)
        self.assertAlmostEqual(notes["pelagos.pitch"], pitch, 3)
        self.assertAlmostEqual(notes["pelagos.roll"], roll, 3)

    def pose(self):
        """Of the camera, from the matrix that the header had all along."""
        with open(self.keep("exr"), "rb") as file:
            m = pelagos.read_exr(file.read()).attributes["worldToCamera"]
        right, up, ahead = (m[:3, i].tolist() for i in range(3))
        return (math.degrees(math.atan2(ahead[0], ahead[1])) % 360,
                math.degrees(math.asin(ahead[2])),
                math.degrees(math.atan2(-right[2], up[2])))

    def test_pictures_say_when_and_where(self):
        exr = self.exr()
        heading, pitch, roll = self.pose()
        for ending in ("jpg", "png"):
            notes = exiftool(self.keep(ending))
            gps = "GPS:"
            self.assertEqual(notes["GPS:GPSImgDirectionRef"], "T")
            # To hundredths.
            self.assertAlmostEqual(notes[gps + "GPSImgDirection"], heading,
                                   delta=0.0051)
            self.assertAlmostEqual(notes["Composite:GPSLatitude"],
                                   exr["latitude"], 4)
            self.assertAlmostEqual(notes["Composite:GPSLongitude"],
                                   exr["longitude"], 4)
            self.assertAlmostEqual(notes[gps + "GPSAltitude"], exr["altitude"],
                                   2)
            self.assertEqual(notes["ExifIFD:DateTimeOriginal"], exr["capDate"])
            self.assertEqual(notes["ExifIFD:OffsetTimeOriginal"], "+00:00")
            self.assertEqual(notes["ExifIFD:ExifImageWidth"], 160)
            self.assertEqual(notes["IFD0:ImageDescription"], self.name)
            self.assertEqual(notes["IFD0:Software"], exr["software"])
            # 36 mm / 2 / tan 25 deg
            self.assertEqual(notes["ExifIFD:FocalLengthIn35mmFormat"], 39)
            xmp = {k.split(":", 1)[1]: v for k, v in notes.items()
                   if k.startswith("XMP-pelagos:")}
            self.assertAlmostEqual(xmp["Heading"], heading, 3)
            self.assertAlmostEqual(xmp["Pitch"], pitch, 3)
            self.assertAlmostEqual(xmp["Roll"], roll, 3)
            self.assertAlmostEqual(xmp["HorizontalFieldOfView"], 50, 2)
            self.assertNotIn("ExifTool:Warning", notes)
            self.assertNotIn("ExifTool:Error", notes)

    def test_north_is_0(self):
        """Exif has 0.00 to 359.99, and nobody 360."""
        def turn(yaw, heading=0):
            answer = self.daemon.patch({
                "entities": {"1": {"heading": heading}},
                "views": {self.name: {"yaw": yaw, "roll": 0}}})
            self.assertEqual(answer.status, 200, answer)
        self.addCleanup(lambda: self.daemon.patch({
            "entities": {"1": {"heading": None}},
            "views": {self.name: {"yaw": 30, "roll": 2}}}))
        for yaw, exif, written in (
                (0, 0, 0), (-1e-12, 0, 0), (-1e-7, 0, 0),
                (-0.003, 0, 0), (-0.007, 359.99, 359.993),
                (0.004, 0, 0.004)):
            turn(yaw)
            notes = exiftool(self.keep("jpg"))
            self.assertEqual(notes["GPS:GPSImgDirection"], exif, yaw)
            self.assertAlmostEqual(notes["XMP-pelagos:Heading"], written, 5)
            self.assertLess(notes["XMP-pelagos:Heading"], 360)
            number = self.exr()["pelagos.heading"]
            self.assertTrue(0 <= number < 359.995, (yaw, number))
            truth = self.daemon.get(f"{self.view}/frame.json").json()
            for seen in truth.get("entities", []):
                self.assertTrue(0 <= seen["heading"] < 360, seen)
        for heading in (360, 0, 359.9999999999):
            turn(0, heading)
            notes = exiftool(self.keep("png"))
            self.assertEqual(notes["GPS:GPSImgDirection"], 0, heading)

    def test_depth_alone_is_found(self):
        """By readers who look for a channel of that name without a layer's."""
        with open(self.keep("exr", "width=64&height=36&layers=depth"),
                  "rb") as file:
            data = file.read()
        exr = pelagos.read_exr(data)
        self.assertEqual(list(exr.channels), ["Y", "depth.Z"])
        self.assertEqual(list(exr.layers), ["depth"])
        self.assertEqual(exr["depth"].shape, (36, 64))
        out = subprocess.run(["ffprobe", "-v", "error", "-show_entries",
                              "stream=width,height,pix_fmt", "-of", "csv=p=0",
                              os.path.join(self.folder.name, "picture.exr")],
                             capture_output=True, text=True)
        self.assertEqual(out.stdout.strip(), "64,36,grayf32le", out.stderr)
        self.assertTrue((exr.channels["Y"] == exr["depth"]).all())
        self.assertGreater(exr["depth"].max(), 100)
        with contextlib.suppress(ImportError):
            os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"
            import cv2
            seen = cv2.imread(os.path.join(self.folder.name, "picture.exr"),
                              -1)
            self.assertTrue((seen == exr["depth"]).all())
        both = pelagos.read_exr(self.daemon.get(
            f"{self.view}/frame.exr?width=64&height=36&layers=depth,normal"
        ).body)
        self.assertNotIn("Y", both.channels)
        self.assertTrue((both["depth"] == exr["depth"]).all())

    def test_the_same_moment_has_the_same_bytes(self):
        for ending in ("jpg", "png", "exr"):
            with open(self.keep(ending), "rb") as file:
                first = file.read()
            with open(self.keep(ending), "rb") as file:
                self.assertEqual(file.read(), first)

    def test_streams_say_nothing(self):
        link = http.client.HTTPConnection("127.0.0.1", self.daemon.http_port,
                                          timeout=60)
        link.request("GET", f"{self.view}/mjpeg")
        answer = link.getresponse()
        self.assertEqual(answer.status, 200)
        data = b""
        while data.count(b"\xff\xd9") < 1:
            data += answer.read1(65536)
        link.close()
        self.assertIn(b"\xff\xd8", data)
        self.assertNotIn(b"Exif", data)
        self.assertNotIn(b"ns.adobe.com", data)


if __name__ == "__main__":
    unittest.main(verbosity=2)
