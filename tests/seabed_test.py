#!/usr/bin/python3
"""Bathymetry: rasters written by GDAL's own tools, soundings by every socket,
files that are not what they seem."""
import glob
import json
import os
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request

import netCDF4
import numpy as np
from osgeo import gdal as geo, osr

geo.UseExceptions()

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import cigi_host as cigi
from pelagos_daemon import (BIN, ROOT, SANITIZED, SLOW_S, Daemon, Session,
                            free_port, receive_all, until)

sys.path.insert(0, os.path.join(ROOT, "clients/python"))
from pelagos import Conflict, Ocean

DAMAGED = os.path.join(ROOT, "../shared/data/exr")
COLUMNS, ROWS, CELL = 160, 120, 1 / 960
WEST, NORTH = 5.1, 52.65


def height(lat, lon):
    """A slope from -25 m up to land."""
    return -25 + 200 * (lon - WEST) + 30 * (lat - 52.6)


def write_grid(path):
    with open(path, "w") as f:
        f.write(f"ncols {COLUMNS}\nnrows {ROWS}\nxllcorner {WEST}\n"
                f"yllcorner {NORTH - ROWS * CELL}\ncellsize {CELL}\n")
        for y in range(ROWS):
            f.write(" ".join(f"{height(NORTH - (y + .5) * CELL, WEST + (x + .5) * CELL):.4f}"
                             for x in range(COLUMNS)) + "\n")


def readers(pid):
    """Whether the daemon has a reader at work."""
    for path in glob.glob(f"/proc/{pid}/task/*/children"):
        with open(path) as f:
            if f.read().strip():
                return True
    return False


def gdal(*command):
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL,
                   timeout=SLOW_S)


@unittest.skipUnless(shutil.which("gdal_translate"), "needs gdal-bin")
class Seabed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="pelagos-seabed-")
        at = lambda name: os.path.join(cls.folder, name)
        write_grid(at("plain.asc"))
        gdal("gdal_translate", "-q", "-a_srs", "EPSG:4326", at("plain.asc"),
             at("geographic.tif"))
        gdal("gdalwarp", "-q", "-t_srs", "EPSG:32631", "-tr", "60", "60", "-r", "bilinear",
             "-dstnodata", "-32768", at("geographic.tif"), at("utm31.tif"))
        # as EMODnet and GEBCO publish: NetCDF; integers with a scale
        gdal("gdal_translate", "-q", "-of", "netCDF", at("geographic.tif"),
             at("grid.nc"))
        gdal("gdal_translate", "-q", "-ot", "Int16", "-scale", "-100", "100",
             "-10000", "10000", "-a_scale", "0.01", at("geographic.tif"),
             at("centimetres.tif"))
        with open(at("geographic.tif"), "rb") as f:
            whole = f.read()
        with open(at("cut.tif"), "wb") as f:
            f.write(whole[:len(whole) // 3])
        gdal("gdal_translate", "-q", "-of", "ENVI", at("geographic.tif"),
             at("envi.bin"))
        gdal("gdal_translate", "-q", "-of", "EHdr", at("geographic.tif"),
             at("ehdr.bil"))
        gdal("gdal_translate", "-q", "-of", "netCDF", "-co", "FORMAT=NC4",
             at("geographic.tif"), at("grid4.nc"))
        gdal("gdal_translate", "-q", "-of", "BAG", at("utm31.tif"),
             at("survey.bag"))
        gdal("gdal_translate", "-q", "-co", "PROFILE=BASELINE", "-ot", "Byte",
             "-scale", "-25", "10", "0", "250", at("geographic.tif"),
             at("picture.tif"))
        if os.path.exists(at("picture.tif.aux.xml")):
            os.remove(at("picture.tif.aux.xml"))
        with open(at("drawn.png"), "wb") as f:
            f.write(b"\x89PNG\r\n\x1a\n" + bytes(64))
        cls.cigi_port = free_port(socket.SOCK_DGRAM)
        cls.daemon = Daemon("--bathymetry", cls.folder, "--cigi",
                            f"127.0.0.1:{cls.cigi_port}", unix=True)

    @classmethod
    def tearDownClass(cls):
        cls.daemon.stop()
        shutil.rmtree(cls.folder)

    def choose(self, **seabed):
        answer = self.daemon.patch({"seabed": seabed})
        self.assertEqual(answer.status, 200, answer)

    def points(self, points):
        answer = self.daemon.request("POST", "/v1/surface",
                                     {"points": points, "time": 3})
        self.assertEqual(answer.status, 200, answer)
        return answer.json()["points"]

    def test_files_of_others(self):
        # The origin is 52.6 N, 5.2 E; 1 km of latitude is 0.008987 deg.
        for name in ("plain.asc", "geographic.tif", "utm31.tif", "grid.nc",
                     "centimetres.tif", "grid4.nc", "envi.bin", "ehdr.bil",
                     "survey.bag"):
            self.choose(file=name)
            got = [p["depth"] for p in self.points([[0, 0], [0, 1000],
                                                    [0, -3000]])]
            for depth, km in zip(got, (0, 1, -3)):
                want = -height(52.6 + km * 0.0089866, 5.2)
                # centimetres, and a second resampling through UTM
                self.assertAlmostEqual(depth, want, delta=0.02, msg=name)

    def test_names_as_long_as_files_have(self):
        longest = "tiefe-\u00fc_" * 27 + ".tif"
        longest = "x" * (255 - len(longest.encode())) + longest
        self.assertEqual(len(longest.encode()), 255)
        shutil.copy(os.path.join(self.folder, "geographic.tif"),
                    os.path.join(self.folder, longest))
        self.choose(file=longest)
        self.assertEqual(self.daemon.get("/v1/state").json()["seabed"]["file"],
                         longest)
        self.assertAlmostEqual(self.points([[0, 0]])[0]["depth"],
                               -height(52.6, 5.2), delta=0.02)
        answer = self.daemon.patch({"seabed": {"file": "x" + longest}})
        self.assertEqual(answer.status, 400, answer)
        self.assertIn("at most 255 bytes", answer.body.decode())

    def soundings(self, columns, rows, **query):
        answer = self.daemon.get("/v1/soundings?" + "&".join(
            f"{k}={v}" for k, v in dict(query, columns=columns,
                                        rows=rows).items()))
        self.assertEqual(answer.status, 200, answer)
        return np.frombuffer(answer.body, "<f4").reshape(rows, columns)

    def test_soundings_are_those_of_the_surface(self):
        self.choose(file="geographic.tif")
        for turn in (0, 37):
            grid = self.soundings(9, 5, latitude=52.6, longitude=5.2,
                                  spacing=40, turn=turn)
            a = np.radians(turn)
            points = [[right * np.cos(a) + up * np.sin(a),
                       up * np.cos(a) - right * np.sin(a)]
                      for up in np.arange(80, -81, -40)
                      for right in np.arange(-160, 161, 40)]
            want = [p["depth"] for p in self.points(points)]
            np.testing.assert_allclose(grid.ravel(), want, atol=1e-3)
        with Ocean(self.daemon.url("")) as ocean:
            np.testing.assert_array_equal(
                ocean.soundings(52.6, 5.2, spacing=40, columns=9, rows=5,
                                turn=37), grid)
        far = self.soundings(3, 3, latitude=10, longitude=5, spacing=10)
        self.assertTrue(np.isnan(far).all())
        whole = self.soundings(512, 512, spacing=0.5)
        self.assertEqual(whole.shape, (512, 512))

    def test_soundings_keep_a_mole_at_any_scale(self):
        """24 m broad, 600 m long, in 14 m of water: land in every raster."""
        rows = np.full((400, 400), -14.0)
        rows[180:182, 100:190] = 3.0
        with open(os.path.join(self.folder, "mole.asc"), "w") as f:
            f.write("ncols 400\nnrows 400\nxllcorner 5.18\nyllcorner 52.58\n"
                    "cellsize 0.0001\n" + "\n".join(
                        " ".join(map(str, row)) for row in rows))
        self.choose(file="mole.asc")
        latitude, longitude = 52.62 - 181 * 0.0001, 5.18 + 145 * 0.0001
        for spacing in (1, 3, 7, 20, 50, 120, 400, 1500, 20000):
            grid = self.soundings(32, 32, latitude=latitude + 2e-5,
                                  longitude=longitude, spacing=spacing, turn=5)
            self.assertGreaterEqual((grid < 0).sum(), min(600 // spacing, 20) or 1,
                                    spacing)

    def test_soundings_without_a_file_and_beyond_their_bounds(self):
        self.daemon.patch({"seabed": None})
        answer = self.daemon.get("/v1/soundings")
        self.assertEqual((answer.status, answer.json()["path"]),
                         (409, "seabed.file"), answer)
        with Ocean(self.daemon.url("")) as ocean:
            with self.assertRaises(Conflict) as refused:
                ocean.soundings()
            self.assertEqual(refused.exception.path, "seabed.file")
        for query in ("columns=513", "rows=0", "spacing=0", "latitude=91",
                      "columns=x", "nothing=1", "spacing=nan"):
            answer = self.daemon.get("/v1/soundings?" + query)
            self.assertEqual(answer.status, 400, query)
            self.assertIn(query.split("=")[0], answer.body.decode())

    def test_a_camera_in_the_ground_says_so(self):
        self.choose(file="mole.asc" if os.path.exists(os.path.join(
            self.folder, "mole.asc")) else "plain.asc")
        kept = self.daemon.state()["views"]
        try:
            for up, inside in ((10, None), (-5, None), (-40, "inside")):
                self.daemon.patch({"views": [{
                    "name": "eye", "up": up, "width": 64, "height": 48}]})
                answer = self.daemon.get("/v1/views/eye/frame.jpg")
                self.assertEqual(answer.status, 200, answer)
                self.assertEqual(answer.headers.get("X-Pelagos-Ground"),
                                 inside, up)
                with Session(self.daemon.connect_unix()) as session:
                    reply = session.ask(frame={"view": "eye"})
                self.assertEqual(reply.frame.in_ground, inside is not None)
                self.ground_in_files_and_streams(inside is not None)
        finally:
            self.daemon.patch({"views": kept})

    def ground_in_files_and_streams(self, inside):
        for ending, word in (("jpg", b'pelagos:Ground="inside"'),
                             ("png", b'pelagos:Ground="inside"'),
                             ("exr", b"pelagos.ground\0string\0"
                                     b"\6\0\0\0inside")):
            body = self.daemon.get("/v1/views/eye/frame." + ending).body
            self.assertEqual(word in body, inside, ending)
        with urllib.request.urlopen(self.daemon.url("/v1/views/eye/mjpeg"),
                                    timeout=SLOW_S) as parts:
            head = b""
            while b"\r\n\r\n" not in head:
                head += parts.read(1)
        self.assertEqual(b"X-Pelagos-Ground: inside" in head, inside)

    def test_a_simulator_finds_land(self):
        self.choose(file="geographic.tif")
        # 4 km east of the origin is land; a slope
        # of 200 m a degree of longitude, 30 a degree of latitude
        lon = 5.2 + 4000 / 67756
        with cigi.Host(("127.0.0.1", self.cigi_port)) as host:
            (_, land), (_, sea), (_, hot), (_, sight) = host.ask(
                cigi.hat_hot(1, 52.6, lon, 50, kind=2),
                cigi.hat_hot(2, 52.6, 5.2, 50, kind=2),
                cigi.hat_hot(3, 52.6, lon, 50, kind=1),
                cigi.los_vector(4, (52.6, lon - 0.01, 20), 90, -2, 5000,
                                extended=True))
        want = height(52.6, lon)
        self.assertGreater(want, 4)
        self.assertEqual((land["material"], sea["material"]), (2, 1))
        # the raster's bilinear cells
        self.assertAlmostEqual(land["hot"], want, delta=0.02)
        self.assertAlmostEqual(hot["height"], want, delta=0.02)
        self.assertAlmostEqual(land["hat"], 50 - land["hot"], places=9)
        self.assertLess(abs(sea["hot"]), 3)
        # It looks down the slope, west by south: 200 / 67756 and 30 / 111280
        # a metre.
        self.assertAlmostEqual(land["azimuth"], -95.2, delta=0.3)
        # 20 m up, 2 deg down, over ground that rises by 3 mm a metre
        self.assertEqual((sight["valid"], sight["material"]), (1, 2))
        rise = 200 / 67756
        eye = 20 - height(52.6, lon - 0.01)
        self.assertAlmostEqual(sight["range"], eye / (0.0349 + rise), delta=1)

    def test_soundings(self):
        self.choose(file="geographic.tif")
        wet, dry, beyond = self.points([[0, 0], [4500, 0], [9000, 0]])
        self.assertAlmostEqual(wet["sounding"], wet["depth"] + wet["height"],
                               places=9)
        self.assertLess(dry["depth"], -5)
        self.assertEqual(dry["sounding"], 0)
        self.assertNotIn("depth", beyond)
        self.assertNotIn("sounding", beyond)
        with Session(self.daemon.connect_unix()) as session:
            query = session.pb.SurfaceQuery(
                points=[{"east": 0, "north": 0}, {"east": 9000, "north": 0}],
                time=3)
            points = session.ask(surface=query).surface.points
            self.assertEqual(points[0].depth, wet["depth"])
            self.assertEqual(points[0].sounding, wet["sounding"])
            self.assertFalse(points[1].HasField("depth"))
        ctl = subprocess.run(
            [os.path.join(BIN, "pelagosctl"), "--timeout", "60", "--server",
             f"unix:{self.daemon.unix_path}", "surface", "0", "0", "9000", "0",
             "--time", "3", "--json"], capture_output=True, timeout=SLOW_S)
        points = json.loads(ctl.stdout)["points"]
        self.assertEqual(points[0]["sounding"], wet["sounding"])
        self.assertIsNone(points[1]["depth"])

    def test_waves_feel_it(self):
        def heights(level=0):
            self.assertEqual(self.daemon.patch(
                {"sea": {"level": level}}).status, 200)
            return {name: [p["height"] - level for p in self.points(
                        [[east, 7 * i] for i in range(40)])]
                    for name, east in (("deep", -12000), ("shallow", 1560))}

        def spread(values):
            return max(values) - min(values)
        self.assertEqual(self.daemon.patch({"sea": {
            "windSpeed": 11, "windDirection": 270}}).status, 200)
        self.choose(file="geographic.tif", waves=False)
        plain = heights()
        self.choose(file="geographic.tif", waves=True)
        felt = heights()
        high = heights(2)
        self.daemon.patch({"sea": {"level": 0}})
        self.assertEqual(felt["deep"], plain["deep"])
        self.assertEqual(self.points([[1560, 0]])[0]["height"],
                         felt["shallow"][0])
        depth = self.points([[1560, 0]])[0]["depth"]
        print(f"{depth:.2f} m deep: {spread(plain['shallow']):.2f} m from "
              f"trough to crest without, {spread(felt['shallow']):.2f} with, "
              f"{spread(high['shallow']):.2f} with 2 m of tide")
        self.assertLess(spread(felt["shallow"]), .5 * spread(plain["shallow"]))
        self.assertGreater(spread(high["shallow"]), spread(felt["shallow"]))

    def test_python(self):
        sys.path.insert(0, os.path.join(ROOT, "clients/python"))
        import numpy
        import pelagos
        self.choose(file="geographic.tif")
        ocean = pelagos.Ocean(self.daemon.url("").rstrip("/"))
        surface = ocean.surface([[0, 0], [4500, 0], [9000, 0]])
        self.assertAlmostEqual(surface.depth[0], -height(52.6, 5.2), delta=.02)
        self.assertEqual(surface.sounding[1], 0)
        self.assertTrue(numpy.isnan(surface.depth[2]))

    def test_nmea_out(self):
        receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(SLOW_S)
        port = receiver.getsockname()[1]
        with Daemon("--bathymetry", self.folder, "--nmea-out",
                    f"127.0.0.1:{port}") as daemon:
            daemon.patch({"seabed": {"file": "geographic.tif"}})
            end = time.monotonic() + SLOW_S
            data = b""
            while b"$SDDPT" not in data and time.monotonic() < end:
                data = receiver.recv(4096)
            receiver.close()
            line = [l for l in data.split(b"\r\n") if l[:6] == b"$SDDPT"]
            self.assertTrue(line, data)
            self.assertAlmostEqual(float(line[0].split(b",")[1]),
                                   -height(52.6, 5.2), delta=0.06)

    def slow_file(self):
        """Some tenths of a second's work for the reader."""
        path = os.path.join(self.folder, "slow.asc")
        if not os.path.exists(path):
            line = " ".join(f"{-20 + x % 50 / 10}" for x in range(1200)) + "\n"
            with open(path, "w") as f:
                f.write("ncols 1200\nnrows 1200\nxllcorner 5.1\n"
                        "yllcorner 52.5\ncellsize 0.0001\n" + line * 1200)
        return "slow.asc"

    def test_others_go_on_while_a_file_is_read(self):
        self.choose(file=None)
        slow = self.slow_file()
        answered = []
        with Session(self.daemon.connect_unix()) as waits, \
                Session(self.daemon.connect_unix()) as goes_on:
            # the second command of the same client comes after the first
            waits.send(waits.pb.Request(
                id=1, patch={"state": {"seabed": {"file": slow}}}))
            waits.send(waits.pb.Request(id=2, get={}))
            waits.socket.setblocking(False)
            while not answered:
                try:
                    answered.append(waits.receive())
                except BlockingIOError:
                    reply = goes_on.ask(patch={"state": {
                        "entities": [{"id": 1, "heading": 44}]}})
                    if not reply.HasField("state"):
                        raise AssertionError(reply)
                    if not reply.state.seabed.file:
                        before = reply.state.revision
                    time.sleep(0.01)  # the reader wants a core too
            waits.socket.setblocking(True)
            answered.append(waits.receive())
            self.assertFalse(answered[0].HasField("error"), answered[0])
            # An edit that was answered while the file was read came first.
            self.assertLess(before, answered[0].state.revision)
            self.assertEqual([r.id for r in answered], [1, 2])
            self.assertEqual([r.state.seabed.file for r in answered],
                             [slow, slow])
            self.assertEqual(answered[0].state.entities[0].heading, 44)

    def test_the_newest_of_several_clients_wins(self):
        self.choose(file=None)
        slow = self.slow_file()
        with self.daemon.connect_http() as first, \
                Session(self.daemon.connect_unix()) as second:
            body = json.dumps({"seabed": {"file": slow}}).encode()
            first.sendall(b"PATCH /v1/state HTTP/1.1\r\nHost: 127.0.0.1\r\n"
                          b"Content-Type: application/json\r\n"
                          b"Connection: close\r\nContent-Length: %d\r\n\r\n"
                          % len(body) + body)
            until("the reader runs",
                  lambda: readers(self.daemon.process.pid))
            reply = second.ask(patch={"remove": ["seabed"]})
            self.assertEqual(reply.state.seabed.file, "")
            answer = receive_all(first)
            self.assertIn(b" 200 ", answer.split(b"\r\n")[0])
            self.assertIn(b"slow.asc", answer)
        self.assertNotIn("file", self.daemon.state()["seabed"])

    def test_a_precondition_is_of_the_moment_of_the_edit(self):
        self.choose(file=None)
        slow = self.slow_file()
        tag = self.daemon.get("/v1/state").headers["ETag"]
        body = json.dumps({"seabed": {"file": slow}}).encode()
        with self.daemon.connect_http() as first:
            first.sendall(b"PATCH /v1/state HTTP/1.1\r\nHost: 127.0.0.1\r\n"
                          b"Content-Type: application/json\r\n"
                          b"If-Match: " + tag.encode() + b"\r\n"
                          b"Connection: close\r\nContent-Length: %d\r\n\r\n"
                          % len(body) + body)
            until("the reader runs",
                  lambda: readers(self.daemon.process.pid))
            self.daemon.patch({"entities": [{"id": 1, "heading": 55}]})
            status = int(receive_all(first).split(b" ")[1])
            self.assertEqual(status, 412)
        # and who left holds nobody up
        with self.daemon.connect_http() as gone:
            gone.sendall(b"PATCH /v1/state HTTP/1.1\r\nHost: 127.0.0.1\r\n"
                         b"Content-Type: application/json\r\n"
                         b"Content-Length: %d\r\n\r\n" % len(body) + body)
        self.choose(file="geographic.tif")

    def described(self):
        """What says where the bottom is; not the revision, which a host's
        loss, noticed late, raises too."""
        state = self.daemon.state()
        return state["seabed"], state.get("origin")

    def test_refusals(self):
        self.choose(file="geographic.tif")
        before = self.described()
        for name, words in (("cut.tif", "cut.tif"),
                            ("picture.tif", "no georeference"),
                            ("drawn.png", "no raster that is read"),
                            ("none.tif", "no such file"),
                            ("/etc/passwd", "without /")):
            answer = self.daemon.patch({"seabed": {"file": name}})
            self.assertNotEqual(answer.status, 200, name)
            text = answer.body.decode()
            self.assertIn(words, text)
            self.assertIn("seabed.file", text)
        answer = self.daemon.patch({"origin": {"latitude": 10}})
        self.assertIn("km from the scene's origin", answer.body.decode())
        self.assertEqual(self.described(), before)
        self.choose(file="picture.tif", latitude=52.6, longitude=5.2,
                    spacing=50)
        answer = self.daemon.patch(
            {"seabed": {k: None for k in ("file", "latitude", "longitude",
                                          "spacing")}})
        self.assertEqual(answer.status, 200, answer)
        self.assertEqual(self.points([[0, 0]])[0]["depth"],
                         self.daemon.state()["water"]["depth"])

    @unittest.skipUnless(os.path.isdir(DAMAGED), "no shared data")
    def test_damaged_files(self):
        folder = tempfile.mkdtemp(prefix="pelagos-damaged-")
        names = sorted(glob.glob(os.path.join(DAMAGED, "damaged-*")))
        # one with several channels
        names += [os.path.join(DAMAGED, "t05.exr"),
                  os.path.join(DAMAGED, "GrayRampsHorizontal.exr")]
        slowest = 0
        try:
            for i, name in enumerate(names):
                shutil.copy(name, os.path.join(folder, f"{i}.exr"))
            with Daemon("--bathymetry", folder) as daemon:
                # what the first picture takes is there
                daemon.get("/v1/views/bridge/frame.jpg?width=64&height=36")
                rss = grown = daemon.rss()
                for i in range(len(names)):
                    start = time.monotonic()
                    answer = daemon.patch({"seabed": {
                        "file": f"{i}.exr", "latitude": 52.6,
                        "longitude": 5.2, "spacing": 10}})
                    if "damaged" in names[i]:
                        grown = daemon.rss() - rss
                    else:
                        self.assertEqual(answer.status, 200, answer)
                    slowest = max(slowest, time.monotonic() - start)
                    self.assertTrue(daemon.alive(), names[i])
                print(f"  {len(names)} files, the slowest in "
                      f"{slowest * 1e3:.0f} ms, resident "
                      f"{grown / 1e6:+.1f} MB")
                if not SANITIZED:
                    # some are read: a field of 2048 x 2048 is 21 MB, and
                    # as much on its way
                    self.assertLess(grown, 64e6)
        finally:
            shutil.rmtree(folder)


READER = os.path.join(BIN, "pelagos-seabed")
LON0, LAT0, STEP = 4.0, 52.0, 1 / 240
LONS, LATS = LON0 + STEP * np.arange(-30, 31), LAT0 + STEP * np.arange(-24, 25)
#: What the file has 40 m above the sea or below it at 52 N 4 E.
DOWN = 40 + 100 * (LONS[None, :] - LON0) + 30 * (LATS[:, None] - LAT0)


def bottom(path, kind="elevation", at=(52.0, 4.0), east=0, north=0):
    """Height that the reader has east and north of `at`, or its words."""
    done = subprocess.run([READER, str(at[0]), str(at[1]), kind,
                           *os.path.split(path)], capture_output=True,
                          timeout=SLOW_S)
    if done.returncode:
        return done.stderr.decode()
    data = done.stdout
    assert data[:8] == b"pelsbed1"
    columns, rows, west, south, spacing = struct.unpack("<IIddd", data[8:40])
    heights = np.frombuffer(data[40:], "f4").reshape(rows, columns)
    x, y = (east - west) / spacing, (north - south) / spacing
    i, j = int(x), int(y)
    x, y = x - i, y - j
    return float(heights[j, i] * (1 - x) * (1 - y)
                 + heights[j, i + 1] * x * (1 - y)
                 + heights[j + 1, i] * (1 - x) * y
                 + heights[j + 1, i + 1] * x * y)


class Meanings(unittest.TestCase):
    """The meaning of numbers, by each way that a file can say it."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="pelagos-meaning-")
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.count = 0

    def path(self, ending):
        type(self).count += 1
        return os.path.join(self.folder, f"{self.count}{ending}")

    def netcdf(self, values=DOWN, name="seabed", order=("lat", "lon"),
               lons=LONS, lats=LATS, kind="f8", more=(), **attributes):
        path = self.path(".nc")
        with netCDF4.Dataset(path, "w") as d:
            for axis, v, units, standard in (
                    ("lon", lons, "degrees_east", "longitude"),
                    ("lat", lats, "degrees_north", "latitude")):
                d.createDimension(axis, len(v))
                c = d.createVariable(axis, kind, (axis,))
                c.units, c.standard_name, c[:] = units, standard, v
            for extra, size in more:
                d.createDimension(extra, size)
            dims = tuple(extra for extra, _ in more) + tuple(order)
            v = d.createVariable(name, "f4", dims, fill_value=-9999.0)
            v.setncatts(attributes)
            grid = values if order == ("lat", "lon") else values.T
            v[:] = np.broadcast_to(grid, v.shape)
        return path

    def tiff(self, crs="4326", values=DOWN, unit=None):
        """The same as GeoTIFF."""
        path = self.path(".tif")
        frame = osr.SpatialReference()
        frame.SetFromUserInput("EPSG:" + crs)
        to = geo.GetDriverByName("GTiff").Create(
            path, len(LONS), len(LATS), 1, geo.GDT_Float32)
        to.SetSpatialRef(frame)
        to.SetGeoTransform([LONS[0] - STEP / 2, STEP, 0,
                            LATS[-1] + STEP / 2, 0, -STEP])
        to.GetRasterBand(1).WriteRaster(
            0, 0, len(LONS), len(LATS), values[::-1].astype("f4").tobytes())
        if unit is not None:
            to.GetRasterBand(1).SetUnitType(unit)
        return path

    def is_at(self, path, want, kind="elevation", **place):
        got = bottom(path, kind, **place)
        self.assertIsInstance(got, float, (path, got))
        self.assertAlmostEqual(got, want, delta=0.05, msg=path)

    def refused(self, path, *words, kind="elevation"):
        got = bottom(path, kind)
        self.assertIsInstance(got, str, (path, got))
        print(got.strip())
        for word in words:
            self.assertIn(word, got)
        self.assertLess(len(got), 256)

    def test_which_way_by_attributes(self):
        for name in ("sea_floor_depth_below_geoid", "depth",
                     "sea_floor_depth_below_mean_sea_level",
                     "sea_floor_depth_below_sea_surface",
                     "sea_floor_depth"):
            path = self.netcdf(standard_name=name, units="m")
            self.is_at(path, -40)
            self.is_at(path, -40, "depth")
        for name in ("altitude", "height", "surface_altitude",
                     "height_above_mean_sea_level",
                     "height_above_reference_ellipsoid"):
            path = self.netcdf(-DOWN, standard_name=name, units="m")
            self.is_at(path, -40)
            self.refused(path, "DEPTH", name, "ELEVATION", kind="depth")
        self.is_at(self.netcdf(positive="down"), -40)
        self.is_at(self.netcdf(positive="DOWN"), -40, "depth")
        self.is_at(self.netcdf(-DOWN, positive="up"), -40)
        self.refused(self.netcdf(positive="up"), "positive \"up\"",
                     "ELEVATION", kind="depth")
        self.refused(self.netcdf(positive="up",
                                 standard_name="sea_floor_depth_below_geoid"),
                     "downward", "upward", "ncatted")

    def test_which_way_by_what_it_is_called(self):
        self.is_at(self.netcdf(name="deptho"), -40)
        self.is_at(self.netcdf(-DOWN, name="depth"), -40)
        self.is_at(self.netcdf(name="v", long_name="Sea floor Depth"), -40)
        self.is_at(self.netcdf(name="bathymetry"), -40)
        self.is_at(self.netcdf(DOWN, name="elevation"), 40)
        self.refused(self.netcdf(-DOWN, name="elevation"), "none of its",
                     "-5", "ELEVATION", kind="depth")
        self.is_at(self.netcdf(name="h", long_name="bathymetry at RHO-points"),
                   -40)
        mixed = DOWN - 42
        self.refused(self.netcdf(mixed, name="depth"), "DEPTH", "ncatted")
        self.is_at(self.netcdf(mixed, name="depth"), 2, "depth")

    def test_fill_values_that_nobody_tells(self):
        land = np.indices(DOWN.shape)[1] > DOWN.shape[1] * 2 // 3
        for fill in (-9999, 9999, -32768, 32767, -99999, 1e20):
            for values in (-DOWN, DOWN):
                for kind in ("elevation", "depth"):
                    self.refused(self.tiff(values=np.where(land, fill, values)),
                                 f"it has {fill:g}", "a_nodata", kind=kind)
        for deep in (-10900, 8800): # the deepest trench, the highest mountain
            self.is_at(self.tiff(values=np.where(land, deep, -DOWN)), -40)

    def test_which_way_by_vertical_crs(self):
        for crs in ("5831", "5715", "5866"):
            path = self.tiff("4326+" + crs)
            self.is_at(path, -40)
            self.is_at(path, -40, "depth")
            self.refused(self.tiff("4326+" + crs, values=-DOWN), "none is above 0",
                         "gdal_edit.py")
        path = self.tiff("4326+5714", values=-DOWN)
        self.is_at(path, -40)
        self.refused(path, "MSL height", "ELEVATION", kind="depth")

    def test_units(self):
        """Each once, whether the band, the CRS or both say it."""
        for unit, metre in (
                ("m", 1), ("metres", 1), ("Meters", 1), ("[m]", 1), ("cm", .01),
                ("dm", .1), ("mm", 1e-3), ("km", 1e3), ("ft", .3048),
                ("feet", .3048), ("US survey foot", 1200 / 3937),
                ("us-ft", 1200 / 3937), ("ftUS", 1200 / 3937),
                ("fathoms", 1.8288), ("fathom", 1.8288), ("yards", .9144),
                ("0.01 m", .01), ("", 1)):
            self.is_at(self.netcdf(-DOWN / metre, units=unit), -40)
        for unit, metre in (("cm", .01), ("US survey foot", 1200 / 3937),
                            ("fathom", 1.8288)):
            self.is_at(self.tiff(values=-DOWN / metre, unit=unit), -40)
        for unit in ("furlong", "m/s", "1", "degrees", "f", "fish"):
            self.refused(self.netcdf(units=unit), f'"{unit}"', "ncatted")
        self.refused(self.tiff(unit="fish"), '"fish"', "gdal_edit.py")
        for crs, foot in (("6360", 1200 / 3937), ("8228", .3048)):
            srs = "4326+" + crs
            self.is_at(self.tiff(srs, values=-DOWN / foot), -40)
            for unit in ("US survey foot", "ft"):
                self.is_at(self.tiff(srs, values=-DOWN / foot, unit=unit),
                           -40)
            self.refused(self.tiff(srs, unit="m"), '"m"', "foot",
                         "gdal_edit.py")
        self.is_at(self.tiff("4326+6358", values=DOWN / 1200 * 3937), -40)

    def test_order_of_dimensions(self):
        """The coordinates say which is east."""
        for order in (("lat", "lon"), ("lon", "lat")):
            for lats in (LATS, LATS[::-1]):
                values = DOWN if lats is LATS else DOWN[::-1]
                for more in ((), (("time", 1),)):
                    path = self.netcdf(-values, order=order, lats=lats,
                                       more=more)
                    self.is_at(path, -40)
                    self.is_at(path, -DOWN[24, 40], east=2862)
                    self.is_at(path, -DOWN[34, 30], north=4636)
        self.refused(self.netcdf(more=(("time", 3),)), "3 values along time",
                     "ncks")

    def test_rounded_coordinates(self):
        """Printed with so many digits, they are equal steps still."""
        for digits, kind in ((3, "f8"), (4, "f8"), (3, "f4"), (5, "f4")):
            path = self.netcdf(-DOWN, lons=np.round(LONS, digits), kind=kind,
                               lats=np.round(LATS, digits))
            self.is_at(path, -40)
            self.is_at(path, -DOWN[24, 40], east=2862)
        uneven = LONS.copy()
        uneven[40:] += STEP
        self.refused(self.netcdf(lons=uneven), "lon are not equal steps",
                     "cdo")

    def test_rotated_pole(self):
        path = self.netcdf()
        with netCDF4.Dataset(path, "a") as d:
            d["lon"].standard_name = "grid_longitude"
            d["lat"].standard_name = "grid_latitude"
            d["lon"].units = d["lat"].units = "degrees"
        self.refused(path, "rotated pole", "cdo")

    def test_projected(self):
        """In metres by a grid mapping; kilometres are refused."""
        lons = 1000.0 * np.arange(400, 420)
        lats = 1000.0 * np.arange(5750, 5770)
        grid = 30 + 0.001 * (lons[None, :] - 410e3) + 0 * lats[:, None]
        for scale in (1, 1e-3):
            for order in (("lat", "lon"), ("lon", "lat")):
                path = self.netcdf(-grid, lons=lons * scale, order=order,
                                   lats=lats * scale, grid_mapping="crs")
                with netCDF4.Dataset(path, "a") as d:
                    for axis, name in (("lon", "projection_x_coordinate"),
                                       ("lat", "projection_y_coordinate")):
                        d[axis].standard_name = name
                        d[axis].units = "m" if scale == 1 else "km"
                    d.createVariable("crs", "i4").setncatts({
                        "grid_mapping_name": "transverse_mercator",
                        "longitude_of_central_meridian": 3.0,
                        "latitude_of_projection_origin": 0.0,
                        "scale_factor_at_central_meridian": 0.9996,
                        "false_easting": 5e5, "false_northing": 0.0,
                        "semi_major_axis": 6378137.0,
                        "inverse_flattening": 298.257223563})
                if scale == 1:
                    # 410 km, 5760 km of UTM's zone 31
                    lon, lat = map(float, subprocess.run(
                        ["gdaltransform", "-s_srs", "EPSG:32631", "-t_srs",
                         "EPSG:4326", "-output_xy"], input="410000 5760000",
                        capture_output=True, text=True, check=True,
                        timeout=SLOW_S).stdout.split())
                    self.is_at(path, -30, at=(lat, lon))
                    self.is_at(path, -32, at=(lat, lon), east=2000)
                else:
                    self.refused(path, '"km"', "ncap2")

    def test_scaled(self):
        path = self.netcdf(name="z", scale_factor=0.5, add_offset=3.0,
                           units="ft", positive="down")
        self.is_at(path, -40 * 0.3048)


if __name__ == "__main__":
    unittest.main(verbosity=2)
