#!/usr/bin/python3
"""A picture as the sky (sky.file): OpenEXR and Radiance, where its light goes,
its Sun, what is refused, the same bits in any order and after a restart."""
import json
import math
import os
import struct
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import ROOT, Daemon

sys.path.insert(0, os.path.join(ROOT, "clients/python"))
sys.dont_write_bytecode = True
import pelagos
from pelagos.camera import Camera

COLUMNS, ROWS = 512, 256
SUN = (40.0, 25.0)  # right of the middle, above the horizon; degrees
SUN_VALUE, SUN_DEG = 4e4, 1.5  # of a round spot
VIEW = {"up": 10, "pitch": 20, "yaw": 0, "width": 160, "height": 120,
        "fieldOfView": 70}


def sky_of(azimuth, elevation):
    """What the picture shows: smooth, another in each direction; the ground
    below is black, so that it is missed where it gets in. Radians."""
    up = 0.4 + 0.9 * np.sin(np.maximum(elevation, 0))
    side = 1 + 0.4 * np.cos(azimuth - 0.8) * np.cos(elevation)
    return np.where(elevation < 0, 0, up * side)


def grid():
    azimuth = ((np.arange(COLUMNS) + 0.5) / COLUMNS - 0.5) * 2 * math.pi
    elevation = (0.5 - (np.arange(ROWS) + 0.5) / ROWS) * math.pi
    return np.meshgrid(azimuth, elevation)


def picture(sun=False):
    azimuth, elevation = grid()
    grey = sky_of(azimuth, elevation)
    rgb = np.repeat(grey[..., None], 3, axis=2).astype(np.float32)
    if sun:
        a, e = np.radians(SUN)
        cosine = (np.sin(elevation) * math.sin(e)
                  + np.cos(elevation) * math.cos(e) * np.cos(azimuth - a))
        rgb[cosine > math.cos(math.radians(SUN_DEG / 2))] = SUN_VALUE
    return rgb


def exr(rgb):
    """Uncompressed floats, with a channel that is not wanted."""
    rows, columns, _ = rgb.shape

    def attribute(name, kind, data):
        return (name + b"\0" + kind + b"\0" + struct.pack("<i", len(data))
                + data)
    window = struct.pack("<4i", 0, 0, columns - 1, rows - 1)
    channels = b"".join(n + b"\0" + struct.pack("<iIii", 2, 0, 1, 1)
                        for n in (b"A", b"B", b"G", b"R")) + b"\0"
    head = (struct.pack("<ii", 20000630, 2)
            + attribute(b"channels", b"chlist", channels)
            + attribute(b"compression", b"compression", b"\0")
            + attribute(b"dataWindow", b"box2i", window)
            + attribute(b"displayWindow", b"box2i", window)
            + attribute(b"lineOrder", b"lineOrder", b"\0")
            + attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1))
            + attribute(b"screenWindowCenter", b"v2f", bytes(8))
            + attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1))
            + b"\0")
    size = 16 * columns
    table = b"".join(struct.pack("<Q", len(head) + 8 * rows + i * (size + 8))
                     for i in range(rows))
    body = b"".join(
        struct.pack("<ii", y, size) + np.concatenate(
            [np.full(columns, 7), rgb[y, :, 2], rgb[y, :, 1],
             rgb[y, :, 0]]).astype("<f4").tobytes() for y in range(rows))
    return head + table + body


def radiance(rgb, runs):
    rows, columns, _ = rgb.shape
    largest = np.maximum(rgb.max(axis=2), 1e-30)
    exponent = np.ceil(np.log2(largest * 256 / 255.5))
    rgbe = np.empty((rows, columns, 4), np.uint8)
    rgbe[..., :3] = rgb * (256 / 2 ** exponent)[..., None]
    rgbe[..., 3] = np.where(rgb.max(axis=2) > 1e-20, exponent + 128, 0)
    out = [b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n"
           % (rows, columns)]
    for row in rgbe:
        if not runs:
            out.append(row.tobytes())
            continue
        out.append(bytes([2, 2, columns >> 8, columns & 255]))
        for plane in row.T:
            at = 0
            while at < columns:
                same = 1
                while (at + same < columns and same < 127
                       and plane[at + same] == plane[at]):
                    same += 1
                if same > 2:
                    out.append(bytes([128 + same, plane[at]]))
                    at += same
                else:
                    out.append(bytes([1, plane[at]]))
                    at += 1
    return b"".join(out)


def directions(picture_):
    """Azimuth clockwise from north and elevation of each pixel."""
    camera = Camera.of_exr(picture_)
    to = camera.intrinsics.rays() @ camera.rotation
    return (np.arctan2(to[..., 0], to[..., 1]), np.arcsin(to[..., 2]))


class Panorama(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.place = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.place.cleanup)
        files = {"smooth.exr": exr(picture()),
                 "runs.hdr": radiance(picture(), True),
                 "flat.hdr": radiance(picture(), False),
                 "sun.exr": exr(picture(True)),
                 "square.exr": exr(picture()[:, :ROWS]),
                 "cut.exr": exr(picture())[:90000],
                 "cut.hdr": radiance(picture(), True)[:9000],
                 "words.hdr": b"#?RADIANCE\n\n-Y 99999999 +X 99999999\n",
                 "text.exr": b"neither"}
        for name, data in files.items():
            with open(os.path.join(cls.place.name, name), "wb") as f:
                f.write(data)
        cls.state = os.path.join(cls.place.name, "state.json")
        cls.start()
        cls.ocean.set(sea={"windSpeed": 0, "whitecaps": 0})
        cls.addClassCleanup(lambda: cls.daemon.stop())

    @classmethod
    def start(cls):
        cls.daemon = Daemon(f"--panoramas={cls.place.name}",
                            f"--state={cls.state}")
        cls.ocean = pelagos.Ocean(cls.daemon.url(""))

    def layers(self, *names, **view):
        self.ocean.views["bridge"].set(**{**VIEW, **view})
        frame = self.ocean.frame("bridge", "exr", layers=names,
                                 float_samples=True, time=5)
        return frame.exr()

    def sky(self, **sky):
        base = {"file": "smooth.exr", "fileScale": 1000, "fileAzimuth": 0,
                "fileSun": "NONE_SEEN", "sunElevation": 30, "sunAzimuth": 60,
                "visibility": 300000}
        self.ocean.set(sky={**base, **sky})

    def test_the_sky_is_the_picture(self):
        """By both forms: each pixel is a constant times the picture's value,
        within what 8 bits of RGBE have, and a horizon that lies where the
        eye's is, 0.1 degrees lower."""
        for name, bound in (("smooth.exr", 4e-3), ("runs.hdr", 8e-3),
                            ("flat.hdr", 8e-3)):
            for turned in (0, 210):
                self.sky(file=name, fileAzimuth=turned)
                seen = self.layers("radiance", "depth", yaw=turned + 30)
                light, depth = seen.layers["radiance"], seen.layers["depth"]
                azimuth, elevation = directions(seen)
                up = np.isinf(depth) & (elevation > 0.03)
                self.assertGreater(up.sum(), 5000)
                want = sky_of(azimuth - math.radians(turned), elevation)
                for i in range(3):
                    ratio = light[..., i][up] / want[up]
                    middle = np.median(ratio)
                    self.assertLess(np.abs(ratio / middle - 1).max(), bound,
                                    (name, turned, i))
                # 683 lm/W over 106.9 nm of an even spectrum, 15 %: daylight.
                self.assertAlmostEqual(
                    np.median((light[..., 1][up] / want[up])) * 73012 / 1000,
                    1, delta=0.15)

    def test_scale(self):
        self.sky()
        one = self.layers("radiance").layers["radiance"]
        self.sky(fileScale=4000)
        four = self.layers("radiance").layers["radiance"]
        np.testing.assert_allclose(four, 4 * one, rtol=1e-4, atol=1e-9)

    def test_level_sea_mirrors_it(self):
        """A flat sea's sky layer over its Fresnel reflectance is the picture in
        the mirror's direction, within the map's blur of a degree or two."""
        self.sky()
        above = self.layers("radiance", "depth").layers
        azimuth, elevation = directions(self.layers("depth"))
        k = np.median(above["radiance"][..., 1][np.isinf(above["depth"])]
                      / sky_of(azimuth, elevation)[np.isinf(above["depth"])])
        seen = self.layers("sky", "fresnel", "depth", pitch=-45)
        azimuth, elevation = directions(seen)
        fresnel = seen.layers["fresnel"]
        fresnel = fresnel[..., 1] if fresnel.ndim == 3 else fresnel
        part = np.isfinite(seen.layers["depth"]) & (elevation < -0.3)
        got = seen.layers["sky"][..., 1][part] / fresnel[part]
        want = k * sky_of(azimuth, -elevation)[part]
        error = np.abs(got / want - 1)
        print(f"  mirrored: median {100 * np.median(error):.2f} %, worst "
              f"{100 * error.max():.2f} %")
        self.assertLess(np.median(error), 0.02)
        self.assertLess(error.max(), 0.05)

    def test_its_sun(self):
        """Found in place, taken out, and as strong in the light layers."""
        self.sky(file="sun.exr", fileSun="IN_THE_PICTURE", fileAzimuth=100)
        seen = self.layers("sun", "sky", "depth", yaw=100 + SUN[0],
                           pitch=SUN[1], fieldOfView=6)
        sun = seen.layers["sun"][..., 1]
        azimuth, elevation = directions(seen)
        x = np.average(np.degrees(azimuth) % 360, weights=sun)
        y = np.average(np.degrees(elevation), weights=sun)
        # Within a texel, 0.7 degrees.
        self.assertAlmostEqual(x, (100 + SUN[0]) % 360, delta=0.5)
        self.assertAlmostEqual(y, SUN[1], delta=0.5)
        sky = seen.layers["sky"][..., 1]
        self.assertLess(sky.max() / sky.min(), 1.5)  # its spot is gone
        pixel = (2 * math.tan(math.radians(3)) / VIEW["width"]) ** 2
        solid = pixel * Camera.of_exr(seen).intrinsics.rays()[..., 2] ** 3
        azimuth, elevation = grid()
        texels = picture(True)[..., 1] > SUN_VALUE / 2
        given = 1000 * SUN_VALUE * (
            np.cos(elevation) * (2 * math.pi / COLUMNS) * (math.pi / ROWS)
        )[texels].sum()
        got = 73012 * (sun * solid).sum()
        print(f"  its Sun: {given:.0f} lx in the file, {got:.0f} drawn")
        self.assertAlmostEqual(got / given, 1, delta=0.15)  # as above

    def test_what_is_refused(self):
        self.sky()
        for name, words in (
                ("square.exr", "twice as wide"), ("cut.exr", "OpenEXR"),
                ("cut.hdr", "cut short"), ("words.hdr", "twice as wide"),
                ("text.exr", "neither"), ("none.exr", "none.exr"),
                ("../state.json", "name"), ("/etc/passwd", "name")):
            with self.assertRaises(pelagos.PelagosError) as caught:
                self.ocean.set(sky={"file": name})
            self.assertEqual(caught.exception.path, "sky.file", name)
            self.assertEqual(self.ocean.state().sky.file, "smooth.exr")

    def test_any_order_and_a_restart(self):
        """The same bits before and after other skies, and of a daemon that
        has them from its state; one whose file is gone has the computed sky
        and keeps the name."""
        self.sky()
        first = self.layers("radiance").layers["radiance"]
        self.sky(file="sun.exr", fileSun="IN_THE_PICTURE")
        other = self.layers("radiance").layers["radiance"]
        self.assertFalse(np.array_equal(first, other))
        self.sky()
        np.testing.assert_array_equal(
            first, self.layers("radiance").layers["radiance"])
        self.daemon.stop()
        type(self).start()
        np.testing.assert_array_equal(
            first, self.layers("radiance").layers["radiance"])
        self.daemon.stop()
        at = os.path.join(self.place.name, "smooth.exr")
        os.rename(at, at + ".away")
        type(self).start()
        self.assertEqual(self.ocean.state().sky.file, "smooth.exr")
        self.assertIn("SCN-018", self.daemon.log())
        computed = self.layers("radiance").layers["radiance"]
        self.assertFalse(np.array_equal(first, computed))
        os.rename(at + ".away", at)
        self.ocean.set(sky={"file": None})

    def test_without_it_nothing_changes(self):
        """What was drawn before any picture is drawn after one."""
        self.ocean.set(sky={"file": None, "fileSun": None, "sunElevation": 30,
                            "sunAzimuth": 60, "visibility": 40000})
        before = self.layers("radiance").layers["radiance"]
        self.sky()
        self.layers("radiance")
        self.ocean.set(sky={"file": None, "fileSun": None, "sunElevation": 30,
                            "sunAzimuth": 60, "visibility": 40000})
        np.testing.assert_array_equal(
            before, self.layers("radiance").layers["radiance"])


if __name__ == "__main__":
    unittest.main(verbosity=1)
