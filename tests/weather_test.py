#!/usr/bin/python3
"""Weather as a field: files of others, the sea at own ship that follows them,
voyages, replays and restarts; files that are not what they seem."""
import datetime
import glob
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import weather_forecast as forecast
from pelagos_daemon import BIN, ROOT, SLOW_S, Daemon, until

READER = os.path.join(BIN, "pelagos-weather")
START = "2026-06-21T12:30:00Z"
HALF_HOUR = 0.5  # of the forecast, at clock.time 0
LATS, LONS = forecast.grid(-2, 57, 15, 11, 1)
HOURS = [0, 1, 2, 3]
SHIP = {"latitude": 52.6, "longitude": 3.4, "speed": 9, "course": 80,
        "heading": 80}


def truth(name, lat, lon, hour):
    """Linear between nodes and times, from the numbers that were written."""
    def at(node_lat, node_lon, node_hour):
        return float(forecast.FIELDS[name](np.array(node_lat),
                                           np.array(node_lon), node_hour))
    a, o, h = math.floor(lat), math.floor(lon), math.floor(hour)
    total = 0
    for i in range(8):
        x, y, t = i & 1, i >> 1 & 1, i >> 2
        weight = ((lon - o if x else 1 - lon + o)
                  * (lat - a if y else 1 - lat + a)
                  * (hour - h if t else 1 - hour + h))
        total += weight * at(a + y, o + x, h + t) if weight else 0
    return total


def reader(folder, name):
    return subprocess.run([READER, folder, name], capture_output=True,
                          timeout=SLOW_S)


class Files(unittest.TestCase):
    """What pelagos-weather makes of a file, and of what is none."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="pelagos-forecast-")
        cls.addClassCleanup(shutil.rmtree, cls.folder)

    def at(self, name):
        return os.path.join(self.folder, name)

    def read(self, name):
        done = reader(self.folder, name)
        self.assertEqual(done.returncode, 0, (name, done.stderr))
        notes, grids = forecast.parse(done.stdout)
        self.assertEqual(len(grids), 1, name)
        return grids[0]

    def same_as_written(self, name, lats, lons, land=False):
        (west, south, east, north), unix, values = self.read(name)
        self.assertEqual(list(unix), [forecast.NOON_UNIX_S + 3600 * h
                                      for h in HOURS])
        t, r, c = values[0].shape
        lat = (south + north * np.arange(r))[None, :, None]
        lon = (west + east * np.arange(c))[None, None, :]
        lon = np.where(lon < lons[0] - 0.01, lon + 360, lon)
        lon = np.where(lon > lons[-1] + 0.01, lon - 360, lon)
        hour = np.array(HOURS, float)[:, None, None]
        # half a quantum of ours, and as much of a 16-bit file's
        for n, key, quantum in ((0, "u10", 1 / 256), (1, "v10", 1 / 256),
                                (2, "swh", 1 / 1024), (3, "pp1d", 1 / 1024)):
            want = forecast.FIELDS[key](lat, lon, hour)
            got = values[n] * quantum
            known = values[n] != -32768
            self.assertEqual(known.all(), key != "swh" or not land,
                             (name, key))
            self.assertLess(np.abs(got - want)[known].max(), quantum,
                            (name, key))
        way = np.radians(270 - forecast.FIELDS["mwd"](lat, lon, hour))
        off = values[4] * (math.pi / 32767) - way
        known = values[4] != -32768
        off = np.abs(np.angle(np.exp(1j * off)))[known]
        self.assertLess(off.max(), 3e-4, name)
        return values

    def test_netcdf(self):
        f = forecast.FIELDS
        forecast.write_netcdf(self.at("plain.nc"), f, LATS, LONS, HOURS)
        self.same_as_written("plain.nc", LATS, LONS)
        # as ERA5: 16 bits, from south, 0 to 360
        forecast.write_netcdf(self.at("era5.nc"), f, LATS[::-1], LONS, HOURS,
                              packed=True)
        self.same_as_written("era5.nc", LATS, LONS)
        lats, lons = forecast.grid(0, 90, 72, 37, 5)
        forecast.write_netcdf(self.at("world.nc"), f, lats, lons, HOURS)
        self.same_as_written("world.nc", lats, lons)
        with_land = dict(f, swh=lambda a, o, h: np.where(
            (a > 54) & (o > 5), np.nan, f["swh"](a, o, h)))
        for packed in (False, True):
            forecast.write_netcdf(self.at("land.nc"), with_land, LATS, LONS,
                                  HOURS, packed=packed)
            v = self.same_as_written("land.nc", LATS, LONS, land=True)
            self.assertEqual((v[2] == -32768).sum(), 4 * 3 * 7)

    @unittest.skipUnless(forecast.HAS_ECCODES, "needs libeccodes-tools")
    def test_grib(self):
        f = forecast.FIELDS
        forecast.write_grib(self.at("a.grib2"), f, LATS, LONS, HOURS)
        self.same_as_written("a.grib2", LATS, LONS)
        lats, lons = forecast.grid(0, 90, 36, 19, 10)
        forecast.write_grib(self.at("world.grib2"), f, lats, lons, HOURS)
        self.same_as_written("world.grib2", lats, lons)
        parts = dict(f, shww=lambda a, o, h: 1 + 0.01 * o + 0 * a,
                     mpts=lambda a, o, h: 12 + 0.01 * o + 0 * a,
                     mdts=lambda a, o, h: 300 + 0.01 * o + 0 * a)
        forecast.write_grib(self.at("parts.grib2"), parts, LATS, LONS, HOURS)
        # GRIB 1 is what the ECMWF gives of ERA5
        forecast.write_grib(self.at("parts.grib1"), parts, LATS, LONS, HOURS,
                            edition=1)
        for name in ("parts.grib2", "parts.grib1"):
            values = self.same_as_written(name, LATS, LONS)
            self.assertEqual(sorted(values), list(range(8)), name)
            for n, want, quantum in (
                    (5, 1 + 0.01 * LONS, 1 / 1024),
                    (6, 12 + 0.01 * LONS, 1 / 1024),
                    (7, -30 - 0.01 * LONS, 180 / 32767)):
                off = values[n] * quantum - want
                self.assertLess(np.abs(off).max(), quantum, (name, n))

    def refused(self, name, *words):
        done = reader(self.folder, name)
        self.assertEqual((done.returncode, done.stdout), (1, b""), name)
        said = done.stderr.decode()
        for word in words:
            self.assertIn(word, said, name)

    def test_refused(self):
        f = forecast.FIELDS
        write = lambda name, fields=f, lats=LATS, lons=LONS, hours=HOURS, **m: \
            forecast.write_netcdf(self.at(name), fields, lats, lons, hours, **m)
        without = lambda *names: {k: v for k, v in f.items() if k not in names}
        write("calm.nc", without("u10"))
        self.refused("calm.nc", "no wind", "UGRD")
        write("half.nc", without("v10"))
        self.refused("half.nc", "wind to the north")
        write("aimless.nc", without("mwd"))
        self.refused("aimless.nc", "wave direction", "mwd")
        write("timeless.nc", leave_time=True)
        self.refused("timeless.nc", "no time")
        wild = dict(f, swh=lambda a, o, h: np.where(a > 54, np.nan, 2 + 0 * o))
        write("wild.nc", wild, undeclared=True)
        self.refused("wild.nc", "significant wave height", "1e+20",
                     "2026-06-21T12:00:00Z", "fill value")
        write("skewed.nc", lats=np.array([57, 56, 54.5, 53, 50, 49.0]))
        self.refused("skewed.nc", "equal steps")
        with open(self.at("text.grib2"), "w") as out:
            out.write("wind 12 m/s\n")
        self.refused("text.grib2", "no GRIB or NetCDF")
        self.refused("nowhere.nc")
        subprocess.run(["gdal_translate", "-q", "-of", "GTiff",
                        f"NETCDF:{self.at('calm.nc')}:v10",
                        self.at("a.tif")], check=True, timeout=SLOW_S)
        self.refused("a.tif", "no GRIB or NetCDF")
        # a file of elsewhere is not read
        os.symlink("/etc/passwd", self.at("passwd.nc"))
        self.refused("passwd.nc")

    def test_times_that_are_none(self):
        import netCDF4
        for name, start in (("far.nc", "99999-01-01"),
                            ("before.nc", "-2147483648-01-01")):
            forecast.write_netcdf(self.at(name), forecast.FIELDS, LATS, LONS,
                                  HOURS)
            with netCDF4.Dataset(self.at(name), "a") as d:
                d["time"].units = "hours since " + start
            self.refused(name, "no time")

    def test_hdf5(self):
        """NetCDF 4 that hands on to other files."""
        any_raster = os.path.join(BIN, "any_raster")
        if not os.path.exists(any_raster):
            self.skipTest("needs any_raster")
        other = os.path.join(tempfile.gettempdir(), "pelagos-elsewhere.bin")
        with open(other, "wb") as f:
            f.write(bytes(65536))
        self.addCleanup(os.remove, other)
        for kind, words in (("storage", "external storage"),
                            ("link", "external link")):
            subprocess.run([any_raster, "hdf5", kind, self.at(kind + ".nc"),
                            other], check=True, timeout=SLOW_S)
            self.refused(kind + ".nc", words)

    def test_too_much(self):
        import netCDF4
        for name, size, times in (("wide.nc", 8000, 1), ("long.nc", 3000, 16)):
            with netCDF4.Dataset(self.at(name), "w") as d:
                for dimension, n in (("time", times), ("lat", size // 2),
                                     ("lon", size)):
                    d.createDimension(dimension, n)
                t = d.createVariable("time", "f8", ("time",))
                t.units = "days since 2026-06-21"
                t[:] = range(times)
                la = d.createVariable("lat", "f8", ("lat",))
                lo = d.createVariable("lon", "f8", ("lon",))
                la.units, lo.units = "degrees_north", "degrees_east"
                la[:] = np.linspace(60, -60, size // 2)
                lo[:] = np.arange(size) * (359 / size)
                for wind in ("u10", "v10"): # of which nothing is written
                    d.createVariable(wind, "i2", ("time", "lat", "lon"),
                                     zlib=True, fill_value=-1)
        self.refused("wide.nc", "8000 × 4000", "at most 7200 × 3601")
        self.refused("long.nc", "times")

    def test_cut(self):
        """No length of a file crashes the daemon, and few the reader."""
        names = ["cut.nc"]
        forecast.write_netcdf(self.at("cut.nc"), forecast.FIELDS, LATS, LONS,
                              HOURS)
        if forecast.HAS_ECCODES:
            names.append("cut.grib2")
            forecast.write_grib(self.at("cut.grib2"), forecast.FIELDS, LATS,
                                LONS, HOURS)
        for name in names:
            with open(self.at(name), "rb") as f:
                whole = f.read()
            for i in range(12):
                with open(self.at("part-" + name), "wb") as f:
                    f.write(whole[:max(len(whole) * i // 12 - 1, 0)])
                done = reader(self.folder, "part-" + name)
                self.assertEqual((done.returncode, done.stdout), (1, b""),
                                 (name, i))
                if name == "cut.grib2" and i > 0:
                    self.assertIn(b"is cut or damaged", done.stderr, i)
            # and with bytes that are not the file's
            for i in range(12):
                bad = bytearray(whole)
                for k in range(20):
                    bad[(i * 7919 + k * 104729) % len(bad)] ^= 0xff
                with open(self.at("bad-" + name), "wb") as f:
                    f.write(bad)
                done = reader(self.folder, "bad-" + name)
                self.assertIn(done.returncode, (0, 1, -11, -6, -8, -25),
                              (name, i))


class Sea(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="pelagos-weather-")
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        write = forecast.write_netcdf
        if forecast.HAS_ECCODES:
            write = forecast.write_grib
        write(os.path.join(cls.folder, "front"), forecast.FIELDS, LATS, LONS,
              HOURS)
        forecast.write_netcdf(
            os.path.join(cls.folder, "wind.nc"),
            {k: forecast.FIELDS[k] for k in ("u10", "v10")}, LATS, LONS, HOURS)

    def ask(self, daemon, method, path, body=None, status=200):
        answer = daemon.request(method, path, body)
        self.assertEqual(answer.status, status, answer)
        return answer.json()

    def begin(self, daemon, mode="STEPPED", ship=SHIP, file="front",
              utc=START, time=0):
        self.ask(daemon, "PATCH", "/v1/state", {
            "clock": {"mode": mode, "utc": utc, "time": time},
            "origin": {"latitude": 52.6, "longitude": 3.4},
            "entities": {"1": ship},
            "views": {"bridge": {"width": 160, "height": 90}},
            "sea": {"spectrum": "ELFOUHAILY", "field": {"file": file}}})

    def settled(self, daemon):
        until("the sea follows", lambda: daemon.state()["sea"]["field"].get(
            "first") and daemon.metrics()["pelagos_scene_waiting"] == 0)

    def step(self, daemon, until_s):
        self.ask(daemon, "POST", "/v1/clock/step", {"until": until_s})

    def check_sea(self, daemon):
        """The state's sea is the field's where the ship is."""
        state = daemon.state()
        sea, field = state["sea"], state["sea"]["field"]
        hour = HALF_HOUR + state["clock"]["time"] / 3600
        ship = state["entities"][0]
        seconds = state["clock"]["time"] - ship.get("poseTime", 0)
        lat = ship["latitude"] + seconds * ship["speed"] * math.cos(
            math.radians(ship["course"])) / 111270
        lon = ship["longitude"] + seconds * ship["speed"] * math.sin(
            math.radians(ship["course"])) / 111320 / math.cos(
                math.radians(lat))
        u, v, hs = (truth(k, lat, lon, hour) for k in ("u10", "v10", "swh"))
        comes_from = math.radians(sea["windDirection"])
        got = (-sea["windSpeed"] * math.sin(comes_from),
               -sea["windSpeed"] * math.cos(comes_from))
        # a step, and a quantum; the frame's north turns by 0.8° each degree
        self.assertLess(math.hypot(got[0] - u, got[1] - v), 0.02 + 1 / 256
                        + 0.02 * abs(lon - 3.4) * math.hypot(u, v), state)
        self.assertAlmostEqual(field["height"], hs, delta=0.02)
        drawn = self.ask(daemon, "GET", "/v1/spectrum")["drawn"]
        self.assertAlmostEqual(drawn["significantHeight"] / hs, 1, delta=0.03)
        return sea

    def test_follows(self):
        with Daemon("--weather", self.folder) as daemon:
            self.begin(daemon)
            self.settled(daemon)
            state = daemon.state()
            self.assertEqual(state["sea"]["field"]["place"], "INSIDE")
            self.assertTrue(state["sea"]["field"]["known"])
            self.assertEqual(state["sea"]["field"]["first"],
                             "2026-06-21T12:00:00Z")
            self.assertEqual(state["sea"]["field"]["last"],
                             "2026-06-21T15:00:00Z")
            seas = [self.check_sea(daemon)]
            for i in range(4):
                # an hour on, and the ship, by its reckoning, with it
                self.ask(daemon, "PATCH", "/v1/state", {
                    "clock": {"time": 1700.0 * (i + 1)},
                    "entities": {"1": {"longitude": 3.4 + 0.3 * i}}})
                self.settled(daemon)
                seas.append(self.check_sea(daemon))
            self.assertGreater(seas[-1]["windSpeed"], seas[0]["windSpeed"] + 3)
            # beyond its end, and beside it
            self.ask(daemon, "PATCH", "/v1/state", {"clock": {"time": 10000}})
            until("held", lambda: daemon.state()["sea"]["field"]["place"]
                  == "AFTER")
            self.ask(daemon, "PATCH", "/v1/state", {
                "clock": {"time": 0}, "entities": {"1": {"longitude": -20}}})
            until("beside", lambda: daemon.state()["sea"]["field"]["place"]
                  == "OUTSIDE")
            # wind alone: the waves are the state's
            self.ask(daemon, "PATCH", "/v1/state", {
                "sea": {"field": {"file": "wind.nc"}, "fetch": 77000}})
            self.settled(daemon)
            until("no waves", lambda: "height" not in
                  daemon.state()["sea"]["field"])
            self.ask(daemon, "PATCH", "/v1/state", {"sea": {"fetch": 88000}})
            self.assertEqual(daemon.state()["sea"]["fetch"], 88000)

    def refused(self, daemon, patch, status, *words):
        answer = daemon.patch(patch)
        self.assertEqual(answer.status, status, answer)
        for word in words:
            self.assertIn(word, answer.body.decode())

    def test_refusals(self):
        with Daemon("--weather", self.folder) as daemon:
            self.refused(daemon, {"sea": {"field": {"file": "front"}}}, 409,
                         "sea.spectrum", "ELFOUHAILY or JONSWAP")
            good = {"spectrum": "JONSWAP", "field": {"file": "front"}}
            self.refused(daemon, {"sea": dict(good, synthesiser="TROCHOIDS")},
                         409, "sea.synthesiser", "FFT")
            answer = daemon.patch({"sea": dict(good, field={"file": "gone"})})
            self.assertIn(answer.status, (400, 404))
            self.assertIn("sea.field.file", answer.body.decode())
            answer = daemon.patch({"sea": dict(good, field={"file": "../x"})})
            self.assertEqual(answer.status, 400)
            self.refused(daemon, {"sea": {"field": {"shift": 1e11}}}, 400,
                         "sea.field.shift")
            self.assertNotIn("file", daemon.state()["sea"].get("field", {}))
            self.ask(daemon, "PATCH", "/v1/state", {
                "clock": {"mode": "STEPPED", "utc": START},
                "origin": {"latitude": 52.6, "longitude": 3.4},
                "entities": {"1": SHIP}, "sea": good})
            self.settled(daemon)
            before = daemon.state()
            for change, path in (({"sea": {"windSpeed": 3}}, "sea.windSpeed"),
                                 ({"sea": {"windDirection": 3}},
                                  "sea.windDirection"),
                                 ({"sea": {"fetch": 3000}}, "sea.fetch"),
                                 ({"sea": {"swell": [{"height": 5}]}},
                                  "sea.swell"),
                                 ({"sea": {"beaufort": 9}}, "sea.windSpeed"),
                                 ({"sky": {"metar":
                                           "EHAM 211225Z 18025KT 9999"}},
                                  "sea.windSpeed")):
                self.refused(daemon, change, 409, path, "remove sea.field")
            self.assertEqual(daemon.state(), before)
            # what it does not lead is edited as ever
            self.ask(daemon, "PATCH", "/v1/state", {"sea": {"whitecaps": 0.5}})
            # the field may stand without leading
            self.ask(daemon, "PATCH", "/v1/state",
                     {"sea": {"field": {"leads": False}}})
            self.ask(daemon, "PATCH", "/v1/state", {"sea": {"windSpeed": 3}})
            self.ask(daemon, "PATCH", "/v1/state", {"sea": {"field": None}})
            self.assertNotIn("field", daemon.state()["sea"])
        with Daemon() as daemon:
            self.refused(daemon, {"sea": good}, 409, "sea.field.file",
                         "--weather")

    def heights(self, daemon, time_s):
        answer = self.ask(daemon, "POST", "/v1/surface", {
            "points": [[70 * (i % 12), 40 * (i // 12) - 300]
                       for i in range(120)],
            "time": time_s})["points"]
        return np.array([p["height"] for p in answer])

    def test_no_jump(self):
        """Heights of one moment before and after the sea follows the field,
        where a fast ship crosses a front, after five days: by then the least
        change of a frequency would have turned every phase."""
        days = 5 * 86400
        with Daemon("--weather", self.folder) as daemon:
            self.ask(daemon, "PATCH", "/v1/state", {
                "clock": {"mode": "STEPPED", "time": days}})
            self.begin(daemon, ship=dict(SHIP, speed=200, longitude=4.3),
                       utc="2026-06-16T12:30:00Z", time=days)
            self.settled(daemon)
            worst, renewed = 0, set()
            for t in range(days + 1, days + 13):
                self.step(daemon, t - 0.05)
                before = self.heights(daemon, t)
                self.step(daemon, t)
                worst = max(worst, np.abs(self.heights(daemon, t)
                                          - before).max())
                renewed.add(daemon.state()["sea"]["field"]["time"])
            print(f"  {len(renewed)} seas in 12 s; a step moves heights by "
                  f"{1e3 * worst:.2f} mm at most")
            self.assertGreater(len(renewed), 4)
            # weathersea_test: 4.3 mm over a front, by 0.5 mm rms or a second's
            # change, which here is as much
            self.assertLess(worst, 8e-3)
            self.assertGreater(worst, 1e-5)

    def test_ship(self):
        """Own ship heaves through new seas as through one: its acceleration
        where they change is as elsewhere."""
        with Daemon("--weather", self.folder) as daemon:
            self.begin(daemon, ship=dict(SHIP, longitude=4.6, speed=6))
            self.ask(daemon, "PATCH", "/v1/state", {
                "sea": {"field": {"shift": 600}},
                "ownShip": {"on": True, "throttle": 0.5}})
            self.settled(daemon)
            dt, poses, seas = 0.1, [], []
            for i in range(1, 200):
                self.step(daemon, i * dt)
                state = daemon.state()
                ship = state["entities"][0]
                poses.append([ship["altitude"], ship["pitch"] / 10,
                              ship["roll"] / 10])
                seas.append(state["sea"]["field"]["time"])
            poses = np.array(poses)
            bends = np.abs(poses[2:] - 2 * poses[1:-1] + poses[:-2]).max(1)
            new = np.array([a != b for a, b in zip(seas[1:], seas)])
            near = new[:-1] | new[1:]
            print(f"  {new.sum()} seas; second differences {bends[near].max():.4f}"
                  f" where they change, {bends[~near].max():.4f} elsewhere")
            self.assertGreater(new.sum(), 2)
            self.assertLess(bends[near].max(), 1.5 * bends[~near].max() + 2e-3)

    def voyage(self, daemon, from_s, to_s):
        """In steps of 4 s; what the state says of the sea at each."""
        seas = []
        for t in range(from_s + 4, to_s + 1, 4):
            self.step(daemon, t)
            seas.append((daemon.state()["sea"],
                         self.heights(daemon, t).tolist()))
        return seas

    def test_restart(self):
        """In the middle of a voyage: as if there had been none."""
        ship = dict(SHIP, speed=120)
        options = lambda name: ("--weather", self.folder, "--state",
                                os.path.join(self.folder, name))
        with Daemon(*options("one.json")) as daemon:
            self.begin(daemon, ship=ship)
            self.settled(daemon)
            whole = self.voyage(daemon, 0, 40)
        with Daemon(*options("two.json")) as daemon:
            self.begin(daemon, ship=ship)
            self.settled(daemon)
            parts = self.voyage(daemon, 0, 20)
        with Daemon(*options("two.json")) as daemon:
            parts += self.voyage(daemon, 20, 40)
        self.assertEqual(whole, parts)
        self.assertGreater(len({s["windSpeed"] for s, _ in whole}), 3)

    def test_rewind(self):
        """An exercise that is rewound has the sea of that moment again, and
        from there the same seas."""
        rising = {"u10": lambda a, o, h: 3 + 9 * h + 0 * a + 0 * o,
                  "v10": lambda a, o, h: 0 * a + 0 * o,
                  "swh": lambda a, o, h: 1 + h + 0 * a + 0 * o,
                  "pp1d": lambda a, o, h: 8 + 0 * a + 0 * o,
                  "mwd": lambda a, o, h: 250 + 0 * a + 0 * o}
        forecast.write_netcdf(os.path.join(self.folder, "rising.nc"), rising,
                              *forecast.grid(-180, 90, 72, 37, 5), HOURS)
        exercises = os.path.join(ROOT, "clients/exercises")
        with Daemon("--weather", self.folder,
                    f"--exercises={exercises}") as daemon:
            command = lambda **c: self.ask(daemon, "POST", "/v1/exercise", c)
            self.ask(daemon, "PATCH", "/v1/state",
                     {"clock": {"mode": "STEPPED"}})
            command(action="LOAD", name="blackout")
            until("it is loaded", lambda: daemon.state()["exercise"]["phase"]
                  == "READY")
            clock = daemon.state()["clock"]
            begins = datetime.datetime.fromisoformat(
                clock["utc"].replace("Z", "+00:00")).timestamp()
            self.ask(daemon, "PATCH", "/v1/state", {"sea": {
                "spectrum": "JONSWAP", "synthesiser": "FFT",
                "field": {"file": "rising.nc", "shift":
                          forecast.NOON_UNIX_S + 600 - begins
                          - clock["time"]}}})
            self.settled(daemon)
            command(action="START")
            seas = []
            for t in range(10, 50, 10):
                self.step(daemon, clock["time"] + t)
                seas.append(daemon.state()["sea"])
            command(action="REWIND", time=10)
            self.assertEqual(daemon.state()["sea"], seas[0])
            command(action="START")
            now = daemon.state()["clock"]["time"]
            for i in range(1, 4):
                self.step(daemon, now + 10 * i)
                self.assertEqual(daemon.state()["sea"], seas[i])
            self.assertEqual(len({s["windSpeed"] for s in seas}), 4)

    def replayed(self, log, times):
        with Daemon("--weather", self.folder) as daemon:
            out = os.path.join(self.folder, "frames")
            done = subprocess.run(
                [os.path.join(BIN, "pelagosctl"), "--timeout", "60",
                 "--server", f"tcp:127.0.0.1:{daemon.tcp_port}", "replay", log,
                 "--frames", out, "--at", ",".join(repr(t) for t in times)],
                capture_output=True, text=True, timeout=300)
            self.assertEqual(done.returncode, 0, done.stderr)
            pictures = []
            for name in sorted(glob.glob(out + "/*.png")):
                with open(name, "rb") as f:
                    pictures.append(f.read())
                os.remove(name)
            return pictures, daemon.state()["sea"]

    def test_replay(self):
        begun = 1000  # what is asked for is not of the seconds before it began
        for mode in ("STEPPED", "FREE"):
            log = os.path.join(self.folder, f"{mode}.pelog")
            pictures = {}
            with Daemon("--weather", self.folder, "--record", log) as daemon:
                self.begin(daemon, mode, ship=dict(SHIP, speed=200, poseTime=begun),
                           time=begun)
                self.settled(daemon)
                for i in range(4):
                    if mode == "STEPPED":
                        self.step(daemon, begun + 3 * i + 3)
                    else:
                        time.sleep(1.2)
                        until("its sea is built", lambda: daemon.metrics()[
                            "pelagos_scene_waiting"] == 0)
                    at = daemon.state()["clock"]["time"]
                    answer = daemon.get(
                        f"/v1/views/bridge/frame.png?time={at!r}")
                    self.assertEqual(answer.status, 200)
                    pictures[at] = answer.body
                sea = daemon.state()["sea"]
            again, replayed = self.replayed(log, pictures)
            self.assertEqual(len(again), 4)
            for i, (at, picture) in enumerate(pictures.items()):
                self.assertEqual(again[i], picture, (mode, at))
            if mode == "STEPPED":
                self.assertEqual(replayed["windSpeed"], sea["windSpeed"])
                self.assertFalse(replayed["field"]["leads"])

    def test_gone(self):
        """A start without the file: the sea stays, the state keeps it."""
        path = os.path.join(self.folder, "gone.json")
        shutil.copy(os.path.join(self.folder, "front"),
                    os.path.join(self.folder, "lost"))
        with Daemon("--weather", self.folder, "--state", path) as daemon:
            self.begin(daemon, file="lost")
            self.settled(daemon)
            wind = daemon.state()["sea"]["windSpeed"]
        os.remove(os.path.join(self.folder, "lost"))
        with Daemon("--weather", self.folder, "--state", path) as daemon:
            sea = daemon.state()["sea"]
            self.assertEqual(sea["windSpeed"], wind)
            self.assertEqual(sea["field"]["file"], "lost")
            self.assertIn("SCN-019", daemon.log())
            self.step(daemon, 5)
            self.ask(daemon, "PATCH", "/v1/state", {"sea": {"field": None}})

    def test_damaged(self):
        """The daemon refuses what the reader does not read, and goes on."""
        bad = os.path.join(self.folder, "bad.grib2")
        with open(os.path.join(self.folder, "front"), "rb") as f:
            whole = f.read()
        with Daemon("--weather", self.folder) as daemon:
            for size in (0, 4, 100, len(whole) * 5 // 8):
                with open(bad, "wb") as f:
                    f.write(whole[:size])
                answer = daemon.patch({"sea": {
                    "spectrum": "JONSWAP", "field": {"file": "bad.grib2"}}})
                self.assertEqual(answer.status, 400, answer)
                self.assertIn("sea.field.file", answer.body.decode())
            self.assertNotIn("field", json.dumps(daemon.state()["sea"]))
            self.assertTrue(daemon.alive())


if __name__ == "__main__":
    unittest.main(verbosity=2)
