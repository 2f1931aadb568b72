#!/usr/bin/python3
"""Files of weather services as they come: levels, means, members, grids, scan
orders, packings, units, calendars and versions, each read rightly or refused by
name. Fields are functions of place and time, written by ecCodes' tools and
netCDF4."""
import datetime
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import weather_forecast as forecast
from pelagos_daemon import BIN, SLOW_S

READER = os.path.join(BIN, "pelagos-weather")
LATS, LONS = np.arange(60., 39, -1), np.arange(-10., 21, 1)
DAY = datetime.datetime(2026, 6, 21, tzinfo=datetime.timezone.utc)
DAY_S = DAY.timestamp()
FIELDS = {  # latitude, longitude, number of the time
    "u": lambda a, o, k: 0.1 * a + 0 * o,
    "v": lambda a, o, k: 0.05 * o + 0.5 * k + 0 * a,
    "h": lambda a, o, k: 1 + 0.05 * (a - 40) + 0.05 * (o + 10),
    "p": lambda a, o, k: 7 + 0.05 * (a - 40) + 0.05 * (o + 10),
    "d": lambda a, o, k: 200 + a + o,
}
NUMBERS = {"u": 0, "v": 1, "h": 2, "p": 3, "d": 4}
SHORT = {"u": "10u", "v": "10v", "h": "swh", "p": "pp1d", "d": "mwd"}
WIND, ALL = "uv", "uvhpd"


def plane(name, k=0, lats=LATS, lons=LONS):
    return FIELDS[name](lats[:, None], lons[None, :], k) + np.zeros(
        (len(lats), len(lons)))


def message(values, keys, lats=LATS, lons=LONS, edition=2):
    """keys: what to set, in their order, the scanning mode among them; values:
    in that mode's order."""
    sets = [f"Ni={len(lons)}", f"Nj={len(lats)}",
            f"latitudeOfFirstGridPointInDegrees={lats[0]:.6f}",
            f"latitudeOfLastGridPointInDegrees={lats[-1]:.6f}",
            f"longitudeOfFirstGridPointInDegrees={lons[0]:.6f}",
            f"longitudeOfLastGridPointInDegrees={lons[-1]:.6f}",
            f"iDirectionIncrementInDegrees={abs(lons[1] - lons[0]):.6f}",
            f"jDirectionIncrementInDegrees={abs(lats[1] - lats[0]):.6f}",
            "dataDate=20260621", "dataTime=0", *keys]
    text = ",".join(f"{x:.9g}" for x in np.ravel(values))
    return edition, "".join(f"set {s};\n" for s in sets) + (
        "set bitsPerValue=20;\n" if not any("bitsPerValue" in k for k in keys)
        else "") + f"set values={{{text}}};\n"


def write_grib(path, messages):
    """One process for all: each begins with a sample of its own."""
    rules = "".join(f'if (count == {k}) {{\n{text}write "{path}";\n}}\n'
                    for k, (_, text) in enumerate(messages, 1))
    if os.path.exists(path):
        os.remove(path)
    with open(path + ".rules", "w", encoding="ascii") as f:
        f.write(rules)
    with open(path + ".samples", "wb") as out:
        for edition, _ in messages:
            with open(forecast.SAMPLE.format(edition), "rb") as f:
                out.write(f.read())
    subprocess.run(["grib_filter", path + ".rules", path + ".samples"],
                   check=True, timeout=SLOW_S)
    os.remove(path + ".rules")
    os.remove(path + ".samples")


def named(name):
    """Keys of a number at its own surface."""
    level = (["typeOfFirstFixedSurface=103", "level=10"] if name in WIND
             else ["typeOfFirstFixedSurface=1", "level=0"])
    return [f'shortName="{SHORT[name]}"', *level]


def plain(names=WIND, times=(0, 3, 6), lats=LATS, lons=LONS):
    return [message(plane(n, k, lats, lons), [*named(n), f'stepRange="{t}"'],
                    lats, lons)
            for k, t in enumerate(times) for n in names]


class Case(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="pelagos-weather-files-")
        cls.addClassCleanup(shutil.rmtree, cls.folder)

    def at(self, name):
        return os.path.join(self.folder, name)

    def run_reader(self, name):
        return subprocess.run([READER, self.folder, name],
                              capture_output=True, timeout=SLOW_S)

    def read(self, name):
        done = self.run_reader(name)
        self.assertEqual(done.returncode, 0, (name, done.stderr))
        return forecast.parse(done.stdout)

    def refused(self, name, *words):
        done = self.run_reader(name)
        said = done.stderr.decode()
        self.assertEqual((done.returncode, done.stdout), (1, b""),
                         (name, said))
        for word in words:
            self.assertIn(word, said, name)
        self.assertLess(len(said), 241, said)
        return said

    def right(self, name, names=WIND, hours=(0, 3, 6), lats=LATS, lons=LONS,
              note=None, fields=None, grids=None, holes=0):
        """Each number is everywhere what was written."""
        notes, read = self.read(name)
        fields = fields or FIELDS
        if note is not None:
            self.assertIn(note, notes, name)
        if grids:
            self.assertEqual(len(read), grids, name)
        found = {n for _, _, values in read for n in values}
        self.assertEqual(found, {NUMBERS[n] for n in names}, name)
        for (west, south, east, north), unix, values in read:
            np.testing.assert_allclose(
                (unix - DAY_S) / 3600, hours, atol=1e-3, err_msg=name)
            for n in names:
                if NUMBERS[n] not in values:
                    continue
                got = values[NUMBERS[n]]
                quantum = forecast.QUANTA[NUMBERS[n]]
                lat = (south + north * np.arange(got.shape[1]))[:, None]
                lon = (west + east * np.arange(got.shape[2]))[None, :]
                lon = np.where(lon > lons.max() + 0.5, lon - 360, lon)
                lon = np.where(lon < lons.min() - 0.5, lon + 360, lon)
                self.assertLess(abs(lat.max() - lats.max()), 0.01, name)
                for k in range(len(hours)):
                    want = fields[n](lat, lon, k) + 0 * lat + 0 * lon
                    if n == "d":
                        want = np.radians(270 - want)
                    off = got[k] * quantum - want
                    off = np.angle(np.exp(1j * off)) if n == "d" else off
                    known = got[k] != -32768
                    self.assertEqual((~known).sum(), holes, (name, n))
                    # and the last bit of 20 of the file's
                    self.assertLess(np.abs(off)[known].max(), quantum + 1e-4,
                                    (name, n, k))
        return read


@unittest.skipUnless(forecast.HAS_ECCODES, "needs libeccodes-tools")
class Grib(Case):
    def write(self, name, messages):
        write_grib(self.at(name), messages)
        return name

    def test_levels_and_means(self):
        """Wind of another height, or over hours, stands before the wind."""
        double = [2 * plane(n) for n in WIND]
        others = {
            "pbl": ["typeOfFirstFixedSurface=220", "scaleFactorOfFirstFixed"
                    "Surface=0", "scaledValueOfFirstFixedSurface=0"],
            "pressure": ["typeOfFirstFixedSurface=100", "level=850"],
            "depth": ["typeOfFirstFixedSurface=160", "level=10"],
            "h100": ["typeOfFirstFixedSurface=103", "level=100"],
            "layer": ["typeOfFirstFixedSurface=103", "level=10",
                      "typeOfSecondFixedSurface=103",
                      "scaleFactorOfSecondFixedSurface=0",
                      "scaledValueOfSecondFixedSurface=80"],
            "mean": ["typeOfFirstFixedSurface=103", "level=10",
                     "productDefinitionTemplateNumber=8",
                     "typeOfStatisticalProcessing=0", 'stepRange="0-3"'],
            "member": ["typeOfFirstFixedSurface=103", "level=10",
                       "productDefinitionTemplateNumber=1",
                       "typeOfEnsembleForecast=3", "perturbationNumber=7"],
            "derived": ["typeOfFirstFixedSurface=103", "level=10",
                        "productDefinitionTemplateNumber=2",
                        "derivedForecast=0"],
            "percentile": ["typeOfFirstFixedSurface=103", "level=10",
                           "productDefinitionTemplateNumber=6"],
            "error": ["typeOfFirstFixedSurface=103", "level=10",
                      "typeOfGeneratingProcess=6"],
        }
        words = {"pbl": "220", "pressure": "850", "depth": "depth",
                 "h100": "100", "layer": "", "mean": "over 0-3 h",
                 "member": "member 7", "derived": "derived of an ensemble",
                 "percentile": "percentile", "error": "forecast error"}
        for kind, keys in others.items():
            other = [message(v, [f"parameterCategory=2",
                                 f"parameterNumber={2 + i}", *keys])
                     for i, v in enumerate(double)]
            self.right(self.write(kind, other + plain()), note="not read")
            self.right(self.write(kind, plain() + other))
            self.refused(self.write(kind, other), "no wind 10 m above",
                         words[kind], "grib_ls FILE")

    def test_grib1(self):
        """Units of time, ranges, the ECMWF's local section."""
        local = ["centre=98", "setLocalDefinition=1", "localDefinitionNumber=1"]
        ensemble = [*local, "marsStream=1035", "numberOfForecastsInEnsemble=50"]
        for keys, hours, words in (
                (["unitOfTimeRange=10", "P1=2"], 6, None),
                (["timeRangeIndicator=10", "P1=0", "P2=200"], 200, None),
                (["unitOfTimeRange=0", "P1=90"], 1.5, None),
                (["unitOfTimeRange=254", "P1=120"], 1 / 30, None),
                (["timeRangeIndicator=1", "P1=0"], 0, None),
                (["timeRangeIndicator=3", "P1=0", "P2=3"], 0, "avg over 0-3"),
                (["timeRangeIndicator=2", "P1=0", "P2=6"], 0, "over 0-6"),
                (["timeRangeIndicator=113", "P1=0", "P2=6"], 0, "avg"),
                ([*local, "stream=1071"], 0, "monthly mean"),
                ([*ensemble, "marsType=10"], 0, None),
                ([*ensemble, "marsType=11", "perturbationNumber=3"], 0,
                 "member 3"),
                ([*ensemble, "marsType=17"], 0, "derived of an ensemble")):
            self.write("one", [message(plane(n), [
                f'shortName="{SHORT[n]}"', *keys], edition=1) for n in WIND])
            if words:
                self.refused("one", words)
            else:
                self.right("one", hours=(hours,))

    def test_multi(self):
        """Several fields in one message."""
        self.write("a", plain()[:2])
        self.write("b", [message(2 * plane(n), [
            "parameterCategory=2", f"parameterNumber={2 + i}",
            "typeOfFirstFixedSurface=220"]) for i, n in enumerate(WIND)])
        with open(self.at("all"), "wb") as out:
            for name in "ba":
                with open(self.at(name), "rb") as f:
                    data = f.read()
                size = int.from_bytes(data[8:16], "big")
                one, two = data[:size], data[size:]
                at, first = 16, []
                while one[at:at + 4] != b"7777":
                    n = int.from_bytes(one[at:at + 4], "big")
                    first.append(one[at:at + n])
                    at += n
                at, second = 16, []
                while two[at:at + 4] != b"7777":
                    n = int.from_bytes(two[at:at + 4], "big")
                    second.append(two[at:at + n])
                    at += n
                body = b"".join(first) + b"".join(
                    s for s in second if s[4] >= 4) + b"7777"
                out.write(one[:8] + (16 + len(body)).to_bytes(8, "big") + body)
        self.right("all", hours=(0,))

    def test_control(self):
        def run(kind, number, factor):
            return [message(factor * plane(n), [
                *named(n), "productDefinitionTemplateNumber=1",
                f"typeOfEnsembleForecast={kind}",
                f"perturbationNumber={number}"]) for n in WIND]
        control, member = run(1, 0, 1), run(3, 4, 2)
        self.right(self.write("control", member + control), hours=(0,))
        single = [message(plane(n), named(n)) for n in WIND]
        self.right(self.write("single", run(1, 0, 3) + member + single),
                   hours=(0,))
        self.refused(self.write("members", member), "member 4")
        self.refused(self.write("zero", run(3, 0, 1)), "member 0")

    def test_runs(self):
        """Components are of one run: the newest that has both."""
        def fields(names, hour, step, factor):
            return [message(factor * plane(n), [
                *named(n), f"dataTime={100 * hour}", f'stepRange="{step}"'])
                for n in names]
        old, new = fields("uv", 0, 6, 1), fields("uv", 6, 0, 2)
        for part in (new[:1], new[1:]): # a newer run whose file was cut
            self.right(self.write("cut", old + part), hours=(6,))
        double = {n: lambda a, o, k, f=FIELDS[n]: 2 * f(a, o, k)
                  for n in WIND}
        self.right(self.write("both", new + old), hours=(6,), fields=double)
        self.refused(self.write("none", old[:1] + new[1:]), "no run has all",
                     "2026-06-21T06:00:00Z", "grib_copy")

    def test_surface(self):
        """GFS-Wave codes its wind at the surface; the ECMWF too, in GRIB1."""
        sea = ["typeOfFirstFixedSurface=1", "level=0"]
        coded = [message(plane(n), ["parameterCategory=2",
                                    f"parameterNumber={2 + i}", *sea])
                 for i, n in enumerate(WIND)]
        self.right(self.write("surface", coded), hours=(0,),
                   note="coded at the surface")
        high = [message(plane(n), named(n)) for n in WIND]
        double = [message(2 * plane(n), ["parameterCategory=2",
                                         f"parameterNumber={2 + i}", *sea])
                  for i, n in enumerate(WIND)]
        self.right(self.write("both", double + high), hours=(0,))
        ecmwf = [message(plane(n), [
            "centre=98", "table2Version=128", f"indicatorOfParameter={165 + i}",
            "indicatorOfTypeOfLevel=1", "level=0"], edition=1)
            for i, n in enumerate(WIND)]
        self.right(self.write("ecmwf", ecmwf), hours=(0,))
        for level, kind in ((2, 105), (100, 105), (850, 100)):
            other = [message(plane(n), [
                "centre=7", "table2Version=2", f"indicatorOfParameter={33 + i}",
                f"indicatorOfTypeOfLevel={kind}", f"level={level}"], edition=1)
                for i, n in enumerate(WIND)]
            self.refused(self.write("other", other), str(level))

    def test_speed_and_direction(self):
        u, v = plane("u"), plane("v")
        speed, way = np.hypot(u, v), np.degrees(np.arctan2(-u, -v)) % 360
        level = ["typeOfFirstFixedSurface=103", "level=10"]
        self.right(self.write("polar", [
            message(speed, ["parameterCategory=2", "parameterNumber=1",
                            *level, "bitsPerValue=24"]),
            message(way, ["parameterCategory=2", "parameterNumber=0",
                          *level, "bitsPerValue=24"])]), hours=(0,))
        self.refused(self.write("speed", [
            message(speed, ["parameterCategory=2", "parameterNumber=1",
                            *level])]), "no wind")

    def test_two_grids(self):
        coarse = (np.arange(60., 39, -2), np.arange(-10., 21, 2))
        wind, waves = plain(), plain("hpd", (0, 3, 6), *coarse)
        for name, order in (("wind", wind + waves), ("waves", waves + wind)):
            read = self.right(self.write(name, order), ALL, grids=2)
            self.assertEqual([r[2][n].shape[1:] for r in read
                              for n in list(r[2])[:1]], [(21, 31), (11, 16)])
        # the same size, elsewhere; the same lattice, less of it
        for lats, lons in ((LATS, LONS + 5), (LATS[:11], LONS),
                           (LATS, LONS[3:9])):
            notes, read = self.read(self.write("moved", wind + plain(
                "hpd", (0, 3, 6), lats, lons)))
            place, _, values = read[1]
            self.assertEqual(values[2].shape, (3, len(lats), len(lons)))
            want = FIELDS["h"](lats[-1], lons[0], 0)
            self.assertAlmostEqual(values[2][0, 0, 0] / 1024, want, 2)
            self.assertAlmostEqual(place[1], lats[-1], 5)
        # one direction by 360 turned is the same place
        self.right(self.write("turned", wind + plain("hpd")), ALL, grids=1)
        # of u and v, or of height and period, it is refused
        self.refused(self.write("apart", plain("u") + plain(
            "v", (0, 3, 6), *coarse)), "another grid", "11", "31")
        self.refused(self.write("parts", wind + plain("hd") + plain(
            "p", (0, 3, 6), *coarse)), "another grid", "cdo")

    def test_scan_orders(self):
        """All sixteen, from north or south, east or west, by rows or columns,
        to and fro."""
        for mode in range(16):
            west, north, columns, fro = (mode >> b & 1 for b in range(4))
            lats = LATS[::-1] if north else LATS
            lons = LONS[::-1] if west else LONS
            messages = []
            for n in WIND:
                v = plane(n, 0, lats, lons)
                v = v.T if columns else v
                v = v.copy()
                if fro:
                    v[1::2] = v[1::2, ::-1]
                messages.append(message(v, [
                    f"iScansNegatively={west}", f"jScansPositively={north}",
                    f"jPointsAreConsecutive={columns}",
                    f"alternativeRowScanning={fro}", *named(n)], lats, lons))
            self.right(self.write(f"scan-{mode}", messages), hours=(0,))
        self.refused(self.write("offset", [
            message(plane(n), ["scanningMode=8", *named(n)]) for n in WIND]),
            "offset", "scanning mode 8")

    def test_longitudes(self):
        for lons in (np.arange(340., 360), np.arange(170., 190),
                     np.arange(-180., 180, 10), np.arange(0., 360, 10)):
            self.right(self.write("lons", plain(WIND, (0,), LATS, lons)),
                       hours=(0,), lons=lons)

    def test_other_grids(self):
        for grid, sample in (("regular_gg", "gg_sfc_grib2"),
                             ("rotated_ll", "rotated_ll_sfc_grib2"),
                             ("reduced_gg", "reduced_gg_sfc_grib2"),
                             ("polar_stereographic",
                              "polar_stereographic_sfc_grib2")):
            found = [os.path.join(os.path.dirname(forecast.SAMPLE), f)
                     for f in os.listdir(os.path.dirname(forecast.SAMPLE))
                     if f.endswith(f"{grid}_sfc_grib2.tmpl")
                     or f.endswith(f"{grid}_pl_grib2.tmpl")
                     or f.startswith(f"{grid}_") and "grib2" in f]
            if not found:
                continue
            subprocess.run(["grib_set", "-s", 'shortName=10u', found[0],
                            self.at(grid)], check=True, timeout=SLOW_S,
                           capture_output=True)
            self.refused(grid, grid, "regular_ll")

    def test_packings(self):
        # (ecCodes' own complex packing loses numbers as it writes.)
        for packing in ("grid_jpeg", "grid_ccsds", "grid_second_order",
                        "grid_ieee", "grid_png"):
            self.write("simple", plain())
            done = subprocess.run(
                ["grib_set", "-r", "-s", f"packingType={packing}",
                 self.at("simple"), self.at(packing)], timeout=SLOW_S,
                capture_output=True)
            if done.returncode == 0:
                self.right(packing)

    def test_constant(self):
        """No bits a value, with a binary scale that does not count then."""
        steady = {"u": 6, "v": -2.5, "h": 2, "p": 9, "d": 300}
        fields = {n: (lambda a, o, k, x=x: x + 0 * a * o)
                  for n, x in steady.items()}
        for edition in (1, 2):
            self.write("whole", [message(np.full((21, 31), x), [
                *(named(n) if edition == 2 else [f'shortName="{SHORT[n]}"']),
                "decimalScaleFactor=0"], edition=edition)
                for n, x in steady.items()])
            with open(self.at("whole"), "rb") as f:
                data = bytearray(f.read())
            at = 0
            while at < len(data): # 2⁻¹⁰
                size = int.from_bytes(data[at + 8:at + 16], "big")
                here = at + 16
                if edition == 1:
                    size = int.from_bytes(data[at + 4:at + 7], "big")
                    here = at + 8
                    for _ in range(2): # to its fourth section
                        here += int.from_bytes(data[here:here + 3], "big")
                    data[here + 4:here + 6] = b"\x80\x0a"
                while edition == 2 and data[here + 4] != 5:
                    here += int.from_bytes(data[here:here + 4], "big")
                if edition == 2:
                    self.assertEqual(data[here + 19], 0)
                    data[here + 15:here + 17] = b"\x80\x0a"
                at += size
            with open(self.at(f"constant-{edition}"), "wb") as f:
                f.write(data)
            self.right(f"constant-{edition}", ALL, hours=(0,), fields=fields)

    def test_times(self):
        """Units of steps, references, runs."""
        def at(unit, step, k, run="0"):
            return [message(plane(n, k), [
                *named(n), f"dataTime={run}",
                f"indicatorOfUnitOfTimeRange={unit}", f"forecastTime={step}"])
                for n in WIND]
        for unit, step, hours in ((0, 90, 1.5), (1, 5, 5), (2, 2, 48),
                                  (10, 3, 9), (11, 2, 12), (12, 3, 36),
                                  (13, 1800, 0.5)):
            self.right(self.write("unit", at(unit, step, 0)), hours=(hours,))
        self.refused(self.write("month", at(3, 2, 0)), "unit 3")
        # of several runs the newest; of one run two that differ: none
        self.right(self.write("runs", at(1, 6, 5) + at(1, 0, 0, "600")),
                   hours=(6,), note="newest run")
        self.right(self.write("runs2", at(1, 0, 0, "600") + at(1, 6, 5)),
                   hours=(6,))
        self.right(self.write("twice", at(1, 6, 0) * 2), hours=(6,))
        self.refused(self.write("differ", at(1, 6, 0) + at(1, 6, 1)),
                     "two different fields", "2026-06-21T06:00:00Z")
        self.refused(self.write("gap", plain() + at(1, 9, 0)[:1]),
                     "no wind to the north", "2026-06-21T09:00:00Z")

    def test_waves(self):
        """The choice among several heights, periods, directions, swells."""
        def wave(number, value, level=None, category=0):
            surface = (["typeOfFirstFixedSurface=1", "level=0"] if level is None
                       else ["typeOfFirstFixedSurface=241",
                             "scaleFactorOfFirstFixedSurface=0",
                             f"scaledValueOfFirstFixedSurface={level}"])
            return message(value + np.zeros((21, 31)), [
                "discipline=10", f"parameterCategory={category}",
                f"parameterNumber={number}", *surface])
        wind = plain(WIND, (0,))
        swells = [wave(7, 100 + 20 * k, k) for k in (3, 2, 1)] + [
            wave(8, 3 - 0.5 * k, k) for k in (2, 1, 3)] + [
            wave(9, 15 - k, k) for k in (2, 3, 1)]
        gfs = [wave(5, 1.25), wave(11, 9.5), wave(10, 250), wave(3, 2.5),
               wave(6, 6), wave(4, 200)]
        notes, [(_, _, v)] = self.read(self.write("gfswave", wind + swells
                                                  + gfs))
        have = {n: x[0, 3, 3] * forecast.QUANTA[n] for n, x in v.items()}
        for n, want in ((2, 2.5), (3, 9.5), (4, np.radians(20)), (5, 1.25),
                        (6, 14), (7, np.radians(150))):
            self.assertAlmostEqual(have[n], want, 2, n)
        # mean and peak: the peak's; the mean alone is told of
        for messages, want, note in (
                ([wave(15, 7), wave(34, 9), wave(14, 250), wave(3, 2)], 9, ""),
                ([wave(15, 7), wave(11, 8), wave(14, 250), wave(3, 2)], 8, ""),
                ([wave(15, 7), wave(14, 250), wave(3, 2)], 7.7,
                 "mean period")):
            notes, [(_, _, v)] = self.read(self.write("mean", wind + messages))
            self.assertAlmostEqual(v[3][0, 3, 3] / 1024, want, 2)
            self.assertEqual("mean period" in notes, bool(note))
        self.refused(self.write("second", wind + [wave(3, 2), wave(14, 2),
                                                  wave(28, 5)]), "peak period")
        # the second swell alone is not the first
        notes, [(_, _, v)] = self.read(self.write(
            "others", wind + gfs + [s for s in swells[:2]] + [wave(9, 9, 2)]))
        self.assertNotIn(6, v)
        self.assertIn("left out", notes)

    def test_holes(self):
        v = [np.where(np.add.outer(np.arange(21), np.arange(31)) % 9 == 0,
                      9999, plane(n)) for n in WIND]
        self.right(self.write("holes", [
            message(x, ["bitmapPresent=1", "missingValue=9999", *named(n)])
            for x, n in zip(v, WIND)]), hours=(0,), holes=int(
                (v[0] == 9999).sum()))

    def test_cut(self):
        self.write("whole", plain())
        with open(self.at("whole"), "rb") as f:
            data = f.read()
        for name, part in (("cut", data[:-5]), ("tail", data[:-700])):
            with open(self.at(name), "wb") as f:
                f.write(part)
            self.refused(name, "cut or damaged", "5 whole fields")
        with open(self.at("padded"), "wb") as f:
            f.write(b"\r\nWMO HEADER\n" + data + bytes(40))
        self.right("padded")


UNITS = {"u": "m s-1", "v": "m s**-1", "h": "m", "p": "s", "d": "degree"}
STANDARDS = {"u": "eastward_wind", "v": "northward_wind",
             "h": "sea_surface_wave_significant_height",
             "p": "sea_surface_wave_period_at_variance_spectral_density_"
                  "maximum",
             "d": "sea_surface_wave_from_direction"}
NAMES = {"u": "u10", "v": "v10", "h": "swh", "p": "pp1d", "d": "mwd"}


class NetCDF(Case):
    def make(self, file, names=WIND, dims=("time", "lat", "lon"), hours=(0, 3, 6),
             lats=LATS, lons=LONS, change=None, values=None, standards=False,
             kind="f4", time=("hours since 2026-06-21", None), fmt="NETCDF4"):
        """A file of these numbers; change(data set) goes over it at the end."""
        import netCDF4
        with netCDF4.Dataset(self.at(file), "w", format=fmt) as d:
            sizes = {"time": len(hours), "lat": len(lats), "lon": len(lons)}
            for dim in ("lat", "time", "lon"):
                if dim in dims:
                    d.createDimension(dim, sizes[dim])
            if "time" in dims:
                t = d.createVariable("time", "f8", ("time",))
                t.units = time[0]
                if time[1]:
                    t.calendar = time[1]
                t[:] = hours
            la = d.createVariable("lat", "f8", ("lat",))
            lo = d.createVariable("lon", "f8", ("lon",))
            la.units, lo.units = "degrees_north", "degrees_east"
            la[:], lo[:] = lats, lons
            for n in names:
                v = d.createVariable(NAMES[n] if not standards else "x" + n,
                                     kind, dims)
                v.units = UNITS[n]
                if standards:
                    v.standard_name = STANDARDS[n]
                all_ = np.stack([plane(n, k, lats, lons)
                                 for k in range(len(hours))])
                order = [("time", "lat", "lon").index(x) for x in dims]
                if len(dims) == 2:
                    all_, order = all_[0], [i - 1 for i in order]
                v[:] = (values or {}).get(n, lambda x: x)(all_).transpose(order)
            if change:
                change(d)
        return file

    def test_orders(self):
        """Axes in any order, rising or falling, with other names."""
        import itertools
        for i, dims in enumerate(itertools.permutations(("time", "lat", "lon"))):
            lats = LATS[::-1] if i % 2 else LATS
            lons = LONS[::-1] if i % 3 == 1 else LONS
            self.right(self.make("order.nc", ALL, dims, lats=lats, lons=lons),
                       ALL)
        square = np.arange(40., 61), np.arange(-10., 11)
        self.right(self.make("square.nc", dims=("time", "lon", "lat"),
                             lats=square[0], lons=square[1]),
                   lats=square[0], lons=square[1])

        def rename(d):
            for old, new in (("lat", "y"), ("lon", "x"), ("time", "t")):
                d.renameDimension(old, new)
                d.renameVariable(old, new)
        self.right(self.make("xy.nc", ALL, change=rename, standards=True,
                             fmt="NETCDF3_CLASSIC"), ALL)

    def test_longitudes(self):
        for lons in (np.concatenate([np.arange(0., 181, 10),
                                     np.arange(-170., 0, 10)]),
                     np.concatenate([np.arange(170., 180, 5),
                                     np.arange(-180., -160, 5)]),
                     np.arange(170., 200, 2), np.arange(0., 360, 10)):
            turned = np.where(lons < 100, lons + 360, lons) if (
                lons[0] == 170) else lons
            notes, [((west, _, east, _), _, v)] = self.read(
                self.make("lons.nc", lons=lons))
            for k, lon in enumerate(lons):
                column = round(((lon - west) % 360) / east)
                self.assertAlmostEqual(v[1][0, 0, column] / 256,
                                       FIELDS["v"](0, lon, 0), 2,
                                       (lon, west, east))

    def test_rounded(self):
        """Coordinates with few digits, in single precision."""
        for step, digits in ((1 / 12, 2), (1 / 12, 3), (1 / 12, 5), (1 / 6, 3),
                             (1 / 24, 3), (1 / 48, 4), (1 / 12, None)):
            lats, lons = 50 + step * np.arange(61), 3 + step * np.arange(81)
            if digits:
                lats, lons = np.round(lats, digits), np.round(lons, digits)

            def single(d):
                d["lat"][:] = np.float32(d["lat"][:])
                d["lon"][:] = np.float32(d["lon"][:])
            notes, [((west, south, east, north), _, v)] = self.read(
                self.make("rounded.nc", lats=lats, lons=lons, change=single))
            self.assertAlmostEqual(east, step, 4)
            self.assertAlmostEqual(west, 3, 2)
            self.assertAlmostEqual(south + 60 * north, lats[-1], 2)
        self.refused(self.make("uneven.nc", lats=np.array([57, 56, 54.5, 53])),
                     "equal steps")
        gauss = np.degrees(np.arcsin(np.polynomial.legendre.leggauss(64)[0]))
        self.refused(self.make("gauss.nc", lats=gauss), "equal steps", "cdo")

    def test_units(self):
        cases = {
            "u": [("knots", 3600 / 1852), ("kt", 3600 / 1852), ("kn", 3600 / 1852),
                  ("km/h", 3.6), ("km h-1", 3.6), ("km hr**-1", 3.6),
                  ("mph", 1 / 0.44704), ("mile/hour", 1 / 0.44704),
                  ("cm/s", 100), ("cm s-1", 100), ("m.s^-1", 1), ("mm/s", 1e3),
                  ("metres per second", 1), ("meter second-1", 1),
                  ("ft/s", 1 / 0.3048), ("nautical_mile/hour", 3600 / 1852),
                  ("0.1 m s-1", 10), ("m/min", 60), ("M/S", 1), ("mps", 1)],
            "h": [("cm", 100), ("feet", 1 / 0.3048), ("ft", 1 / 0.3048),
                  ("fathoms", 1 / 1.8288), ("km", 1e-3), ("mm", 1e3),
                  ("meters", 1), ("metre", 1), ("inches", 1 / 0.0254)],
            "p": [("hours", 1 / 3600), ("min", 1 / 60), ("seconds", 1),
                  ("ms", 1e3), ("sec", 1)],
            "d": [("radians", np.pi / 180), ("rad", np.pi / 180),
                  ("degrees_true", 1), ("Degree true", 1), ("deg", 1),
                  ("degrees clockwise from north", 1), ("degrees", 1)],
        }
        for number, units in cases.items():
            for unit, factor in units:
                def change(d, unit=unit):
                    d[NAMES[number]].units = unit
                self.right(self.make("unit.nc", ALL, change=change, kind="f8",
                                     values={number: lambda x: x * factor}),
                           ALL)
        for number, units in {
                "u": ("furlong/fortnight", "m", "s", "K", "m s-2", "1", "%",
                      "degrees"),
                "h": ("K", "m2", "m s-1", "Pa", "lightyears"),
                "p": ("Hz", "s-1", "K", "m", "1/s"),
                "d": ("m", "s", "gon", "degrees counterclockwise from east",
                      "K", "1")}.items():
            for unit in units:
                def change(d, unit=unit):
                    d[NAMES[number]].units = unit
                self.refused(self.make("unit.nc", ALL, change=change),
                             f'"{unit}"', NAMES[number], "ncatted")

        def bare(d):
            for v in d.variables.values():
                if v.name in NAMES.values():
                    del v.units
        self.right(self.make("bare.nc", ALL, change=bare), ALL,
                   note="swh has no units: m is taken")

        def frequency(d):
            d.renameVariable("pp1d", "fp")
            d["fp"].units = "Hz"
        self.right(self.make("fp.nc", ALL, change=frequency, kind="f8",
                             values={"p": lambda x: 1 / x}), ALL)

    def test_packed(self):
        """Scale, offset, fills, ranges, unsigned numbers."""
        hole = np.zeros((3, 21, 31), bool)
        hole[:, 3, 4:9] = True

        def make(kind, fill, scale, offset, **more):
            def change(d):
                d.set_auto_maskandscale(False)
                for n in WIND:
                    old = d[NAMES[n]][:]
                    d.renameVariable(NAMES[n], "old_" + n)
                    v = d.createVariable(NAMES[n], kind, ("time", "lat", "lon"),
                                         fill_value=more.get("fill_value",
                                                             fill))
                    v.set_auto_maskandscale(False)
                    v.units, v.scale_factor, v.add_offset = "m s-1", scale, \
                        offset
                    for key, value in more.get("attributes", {}).items():
                        v.setncattr(key, value)
                    raw = np.round((old.astype("f8") - offset) / scale)
                    v[:] = np.where(hole, fill, raw).astype("i8").astype(kind)
            return self.make("packed.nc", change=change, kind="f8")
        short = np.int16
        for file in (
                lambda: make("i2", -32767, 0.001, 3.),
                lambda: make("i2", -32767, 0.001, 3., fill_value=False),
                lambda: make("i2", -9999, 0.001, 3., fill_value=None,
                             attributes={"missing_value": short(-9999)}),
                lambda: make("i2", -9999, 0.001, 3., fill_value=None,
                             attributes={"valid_range": np.array(
                                 [-8000, 8000], short)}),
                lambda: make("i2", 9999, 0.001, 3., fill_value=None,
                             attributes={"valid_max": short(9000)}),
                lambda: make("i2", -1, 0.001, -30., attributes={
                    "_Unsigned": "true"})):
            self.right(file(), holes=5)
        for fill in (np.nan, 9.96921e36, 1e20):
            def change(d, fill=fill):
                for n in WIND:
                    x = np.where(hole, fill, d[NAMES[n]][:].data)
                    d.renameVariable(NAMES[n], "old_" + n)
                    v = d.createVariable(NAMES[n], "f4", ("time", "lat", "lon"),
                                         fill_value=None)
                    v.units = "m s-1"
                    if fill == 1e20:
                        v.missing_value = 1e20
                    v.set_auto_maskandscale(False)
                    v[:] = x
            self.right(self.make("float.nc", change=change), holes=5)

    def test_calendars(self):
        import cftime
        for units in ("days since 0001-01-01", "hours since 1-1-1 00:00:0.0",
                      "days since 1582-10-04", "days since 1582-10-15",
                      "seconds since 1970-01-01", "minutes since 1900-02-28",
                      "hours since 2000-02-29T12:00:00Z",
                      "days since 2026-06-20 18:00 -06:00",
                      "hours since 2026-06-21 05:30:00 +0530",
                      "hours since 2026-06-21 02:00:00.0 +02",
                      "hours since 2026-06-21 00:00:0.5",
                      "weeks since 1950-01-01", "days since 1858-11-17 UTC"):
            for calendar in (None, "standard", "gregorian",
                             "proleptic_gregorian", "julian", "noleap",
                             "365_day", "all_leap", "360_day"):
                start = units.split(" since ")[1]
                known = start.replace("Z", "").replace(" UTC", "")
                if calendar in ("noleap", "365_day", "360_day") and (
                        "02-29" in known):
                    continue
                label = [cftime.datetime(2026, 6, 21, h,
                                         calendar=calendar or "standard")
                         for h in (0, 3, 6)]
                parts = units.split()
                unit = parts[0] if parts[0] != "weeks" else "days"
                try:
                    numbers = cftime.date2num(
                        label, f"{unit} since {known}",
                        calendar=calendar or "standard")
                except ValueError:
                    continue
                numbers = np.array(numbers, "f8") / (
                    7 if parts[0] == "weeks" else 1)
                hours = np.array([0, 3, 6], float)
                if calendar == "julian": # 13 days later by ours
                    hours = hours + 13 * 24
                self.make("calendar.nc", time=(units, calendar))

                import netCDF4
                with netCDF4.Dataset(self.at("calendar.nc"), "a") as d:
                    d["time"][:] = numbers
                self.right("calendar.nc", hours=hours)
        for units, calendar, word in (
                ("hours since 2026-06-21", "moon", '"moon"'),
                ("months since 2026-06-21", None, "months"),
                ("hours", None, "no time"), ("hours since", None, "no time"),
                ("hours since 2026-13-21", None, "2026-13-21"),
                ("hours since 2026-02-30", "360_day", "February"),
                ("hours since 2026-06-21 00:00 CEST", None, "CEST")):
            self.refused(self.make("calendar.nc", time=(units, calendar)), word)

    def test_times(self):
        """Reference time and step, valid time, a time without a dimension."""
        # (HDF5 loses what is renamed.)
        classic = "NETCDF3_64BIT_DATA"
        def forecast_(d):
            d.renameDimension("time", "step")
            d.renameVariable("time", "step")
            d["step"].units, d["step"].standard_name = ("hours",
                                                        "forecast_period")
            t = d.createVariable("time", "i8", ())
            t.units, t.standard_name = ("seconds since 1970-01-01",
                                        "forecast_reference_time")
            t[...] = int(DAY_S)
        self.right(self.make("step.nc", change=forecast_, fmt=classic))

        def nameless(d):
            forecast_(d)
            d["time"].delncattr("standard_name")
            d["step"].delncattr("standard_name")
            v = d.createVariable("valid_time", "i8", ("step",))
            v.units = "seconds since 1970-01-01"
            v[:] = [int(DAY_S) + 3600 * h for h in (0, 3, 6)]
        self.right(self.make("nameless.nc", change=nameless, fmt=classic))

        def valid(d): # analyses: time is the run's, and its step is 3 h
            d["time"].standard_name = "forecast_reference_time"
            s = d.createVariable("step", "f8", ())
            s.units, s.standard_name = "hours", "forecast_period"
            s[...] = 3
        self.right(self.make("runs.nc", change=valid), hours=(3, 6, 9))

        def single(d):
            t = d.createVariable("time", "f8", ())
            t.units = "hours since 2026-06-21"
            t[...] = 7
        self.right(self.make("single.nc", dims=("lat", "lon"), change=single),
                   hours=(7,))
        self.refused(self.make("timeless.nc", dims=("lat", "lon")), "no time")

        def both(d): # (run, step): of one valid time the newest run's
            d.createDimension("run", 2)
            d.createDimension("step", 2)
            for name, units, standard, values in (
                    ("run", "hours since 2026-06-21",
                     "forecast_reference_time", (0, 3)),
                    ("step", "hours", "forecast_period", (0, 3))):
                v = d.createVariable(name, "f8", (name,))
                v.units, v.standard_name = units, standard
                v[:] = values
            for n in WIND:
                x = d[NAMES[n]][:]
                d.renameVariable(NAMES[n], "old_" + n)
                v = d.createVariable(NAMES[n], "f4",
                                     ("run", "step", "lat", "lon"))
                v.units = "m s-1"
                v[0, 0], v[0, 1], v[1, 0], v[1, 1] = x[0], x[1] + 5, x[1], x[2]
        self.right(self.make("both.nc", change=both), note="newest run")

    def extra(self, name, dimension, values, units=None, kind="f8",
              wrong=1.0, coordinate=True, right=None, **attributes):
        """A dimension more, in which only `right` has the right numbers."""
        def change(d):
            d.createDimension(dimension, len(values))
            if coordinate:
                c = d.createVariable(dimension, kind, (dimension,))
                for key, value in attributes.items():
                    c.setncattr(key, value)
                if units:
                    c.units = units
                c[:] = np.array(values, object if kind is str else None)
            for n in WIND:
                x = d[NAMES[n]][:]
                d.renameVariable(NAMES[n], "old_" + n)
                v = d.createVariable(NAMES[n], "f4",
                                     ("time", dimension, "lat", "lon"))
                v.units = "m s-1"
                for k in range(len(values)):
                    v[:, k] = x + (0 if k == right else wrong)
        return self.make(name, change=change)

    def test_heights(self):
        for values, units, right in (
                ((2, 10, 100), "m", 1), ((10,), "m", 0),
                ((100, 10), None, 1), ((1000, 2000), "cm", 0)):
            self.right(self.extra("height.nc", "height", values, units,
                                  right=right))
        self.right(self.extra("height.nc", "heightAboveGround", (80, 10), "m",
                              right=1))
        for dimension, values, units, words in (
                ("height", (2, 100), "m", ("2, 100 m", "10 m")),
                ("height", (10, 20), "hPa", ("hPa",)),
                ("plev", (85000, 92500), "Pa", ("85000", "Pa")),
                ("isobaricInhPa", (10, 20), "hPa", ("hPa",)),
                ("lev", (1, 2), None, ("1, 2",))):
            self.refused(self.extra("height.nc", dimension, values, units),
                         *words)
        self.refused(self.extra("height.nc", "layer", (0, 1),
                                coordinate=False), "layer")

        def scalar(value, units="m"):
            def change(d):
                v = d.createVariable("height", "f8", ())
                v.units, v.standard_name = units, "height"
                v[...] = value
                for n in WIND:
                    d[NAMES[n]].coordinates = "height"
            return change
        self.right(self.make("scalar.nc", change=scalar(10)))
        self.refused(self.make("scalar.nc", change=scalar(100)), "height 100")

        def titled(key, value):
            def change(d):
                for n in WIND:
                    d[NAMES[n]].setncattr(key, value)
            return change
        for key, value in (("long_name", "100 metre wind component"),
                           ("cell_methods", "time: mean (interval: 1 hour)"),
                           ("cell_methods", "area: mean time: maximum"),
                           ("GRIB_stepType", "avg")):
            self.refused(self.make("titled.nc", change=titled(key, value)),
                         "no wind", "u10 (")
        self.right(self.make("titled.nc", change=titled(
            "cell_methods", "time: point area: mean")))

        def hundred(d):
            for n in WIND:
                d.renameVariable("x" + n, n + "100")
        self.refused(self.make("u100.nc", change=hundred, standards=True),
                     "u100 (at 100 m)")

    def test_members(self):
        self.right(self.extra("member.nc", "number", (3, 0, 1), right=1))
        self.right(self.extra("member.nc", "realization", (0,), right=0,
                              standard_name="realization"))
        self.refused(self.extra("member.nc", "number", (1, 2, 3)),
                     "control member", "1, 2, 3", "ncwa")
        self.refused(self.extra("member.nc", "number", (7,)), "7")
        self.refused(self.extra("member.nc", "member", (0, 1),
                                coordinate=False), "member")

        def scalar(d):
            v = d.createVariable("number", "i8", ())
            v.standard_name = "realization"
            v[...] = 4
        self.refused(self.make("member.nc", change=scalar), "member 4")

    def test_versions(self):
        """expver: final data before preliminary, in whichever order."""
        for values, kind in (((1, 5), "i4"), ((5, 1), "i4"),
                             (("0001", "0005"), str), (("0005", "0001"), str)):
            def change(d, values=values, kind=kind):
                d.createDimension("expver", 2)
                c = d.createVariable("expver", kind, ("expver",))
                c[:] = np.array(values, object if kind is str else None)
                final = [int(v) for v in values].index(1)
                for n in WIND:
                    x = d[NAMES[n]][:].filled()
                    d.renameVariable(NAMES[n], "old_" + n)
                    v = d.createVariable(NAMES[n], "f4", (
                        "time", "expver", "lat", "lon"), fill_value=np.nan)
                    v.units = "m s-1"
                    all_ = np.stack([x, x], 1)
                    all_[:, 1 - final] += 3 # preliminary is another
                    all_[2, final] = np.nan
                    all_[2, 1 - final] -= 3
                    v[:] = all_
            self.right(self.make("expver.nc", change=change), note="expver")

    def test_beside_others(self):
        """What only looks like one of ours leaves the file to those."""
        def add(name, dims=("time", "lat", "lon"), value=20, **attributes):
            def change(d):
                if "plev" in dims:
                    d.createDimension("plev", 2)
                    c = d.createVariable("plev", "f8", ("plev",))
                    c.units, c[:] = "Pa", (85000, 50000)
                v = d.createVariable(name, "f4", dims)
                v.setncatts(attributes)
                v[:] = value
            return change
        levels = ("time", "plev", "lat", "lon")
        rain = add("tp", units="m", standard_name="unknown", value=0.001,
                   long_name="Total precipitation")
        self.right(self.make("rain.nc", ALL, change=rain), ALL, note="tp")
        self.right(self.make("rain.nc", change=rain))
        for name in ("u", "ugrd"):
            self.right(self.make("levels.nc", change=add(
                name, levels, units="m s-1", standard_name="eastward_wind")),
                note=f"not read: {name}")
        self.right(self.make("unit.nc", ALL, change=add("hs", units="W m-2")),
                   ALL, note="not read: hs")

        def heights(d):
            for z in (10, 100):
                c = d.createVariable(f"height{z}", "f8", ())
                c.units, c.standard_name, c[...] = "m", "height", z
            for n in WIND:
                d["x" + n].coordinates = "height10"
                add("far" + n, units="m s-1", standard_name=STANDARDS[n],
                    coordinates="height100")(d)
        self.right(self.make("heights.nc", change=heights, standards=True))

        def two_metres(d): # of temperatures, that nobody names
            c = d.createVariable("height", "f8", ())
            c.units, c.standard_name, c[...] = "m", "height", 2
        self.right(self.make("height.nc", change=two_metres))
        # and is refused for what it is where there is no other
        self.refused(self.make("rest.nc", "v", change=add(
            "u", levels, units="m s-1", standard_name="eastward_wind")),
            "85000", "Pa", "10 m")
        self.refused(self.make("rest.nc", change=add("swh", units="W m-2")),
                     "swh", "W m-2")

    def test_directions(self):
        """The standard name says to or from, whatever the variable's."""
        def to(d):
            d["mwd"].standard_name = "sea_surface_wave_to_direction"
        self.right(self.make("to.nc", ALL, change=to, values={
            "d": lambda x: x + 180}), ALL)

        def other(d):
            d["mwd"].standard_name = "sea_surface_wind_wave_from_direction"
        self.refused(self.make("other.nc", ALL, change=other), "wave direction",
                     "sea_surface_wind_wave_from_direction")

        def titled(d):
            d["mwd"].long_name = "direction toward which waves travel"
        self.refused(self.make("titled.nc", ALL, change=titled), "toward",
                     "ncatted")

        def polar(way):
            def change(d):
                u, v = d["u10"][:], d["v10"][:]
                d.renameVariable("u10", "a")
                d.renameVariable("v10", "b")
                s = d.createVariable("ws", "f8", ("time", "lat", "lon"))
                s.units, s.standard_name = "m s-1", "wind_speed"
                s[:] = np.hypot(u, v)
                w = d.createVariable("wd", "f8", ("time", "lat", "lon"))
                w.units, w.standard_name = "degree", f"wind_{way}_direction"
                w[:] = np.degrees(np.arctan2(u, v)) + 180 * (way == "from")
            return change
        for way in ("from", "to"):
            self.right(self.make("polar.nc", change=polar(way), kind="f8"))

    def test_other_grids(self):
        def curved(d):
            d.renameVariable("lat", "y")
            d.renameVariable("lon", "x")
            d.renameDimension("lat", "y")
            d.renameDimension("lon", "x")
            for n in ("y", "x"):
                d[n].delncattr("units")
            for name, units in (("nav_lat", "degrees_north"),
                                ("nav_lon", "degrees_east")):
                v = d.createVariable(name, "f8", ("y", "x"))
                v.units = units
            for n in WIND:
                d[NAMES[n]].coordinates = "nav_lat nav_lon"
        self.refused(self.make("curved.nc", change=curved), "nav_lat nav_lon",
                     "y, x", "cdo")

        def rotated(d):
            d.renameVariable("lat", "rlat")
            d.renameVariable("lon", "rlon")
            d["rlat"].units = d["rlon"].units = "degrees"
            d["rlat"].standard_name = "grid_latitude"
            d["rlon"].standard_name = "grid_longitude"
            d.renameDimension("lat", "rlat")
            d.renameDimension("lon", "rlon")
            p = d.createVariable("pole", "i4", ())
            p.grid_mapping_name = "rotated_latitude_longitude"
            for n in WIND:
                d[NAMES[n]].grid_mapping = "pole"
        self.refused(self.make("rotated.nc", change=rotated),
                     "rotated_latitude_longitude")

    def test_two_grids(self):
        import netCDF4
        self.make("two.nc", ALL)
        with netCDF4.Dataset(self.at("two.nc"), "a") as d:
            lats, lons = np.arange(41., 59, 3), np.arange(0., 15, 2.5)
            for name, v, units in (("lat2", lats, "degrees_north"),
                                   ("lon2", lons, "degrees_east")):
                d.createDimension(name, len(v))
                c = d.createVariable(name, "f8", (name,))
                c.units = units
                c[:] = v
            d.createDimension("time2", 2)
            t = d.createVariable("time2", "f8", ("time2",))
            t.units = "hours since 2026-06-21"
            t[:] = (1, 5)
            for n in "hpd":
                d.renameVariable(NAMES[n], "old_" + n)
                v = d.createVariable(NAMES[n], "f4", ("time2", "lat2", "lon2"))
                v.units = UNITS[n]
                v[:] = np.stack([plane(n, k, lats, lons) for k in (0, 1)])
        notes, (wind, waves) = self.read("two.nc")
        self.assertEqual([list(wind[2]), list(waves[2])], [[0, 1], [2, 3, 4]])
        np.testing.assert_allclose(waves[0], (0, 41, 2.5, 3), atol=1e-6)
        np.testing.assert_allclose((waves[1] - DAY_S) / 3600, (1, 5))
        np.testing.assert_allclose(waves[2][2] / 1024, np.stack([
            plane("h", k, lats, lons) for k in (0, 1)]), atol=1e-3)

    def test_groups(self):
        import netCDF4
        with netCDF4.Dataset(self.at("groups.nc"), "w") as d:
            d.createGroup("wind")
        self.refused("groups.nc", "1 groups", "ncks -G")

    def test_formats(self):
        for fmt in ("NETCDF3_CLASSIC", "NETCDF3_64BIT_OFFSET",
                    "NETCDF3_64BIT_DATA", "NETCDF4", "NETCDF4_CLASSIC"):
            self.right(self.make("format.nc", ALL, fmt=fmt), ALL)


if __name__ == "__main__":
    unittest.main(verbosity=2)
