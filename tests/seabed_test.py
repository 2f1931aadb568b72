#!/usr/bin/python3
"""Bathymetry: rasters written by GDAL's own tools, soundings by every socket,
files that are not what they seem."""
import glob
import json
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import cigi_host as cigi
from pelagos_daemon import (BIN, ROOT, SANITIZED, SLOW_S, Daemon, Session,
                            free_port, receive_all, until)

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


if __name__ == "__main__":
    unittest.main(verbosity=2)
