#!/usr/bin/python3
"""GRIB files of weather services as they come: levels, means, members, grids,
scan orders, packings and times, each read rightly or refused by name."""
import os
import subprocess
import sys
import unittest

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import weather_forecast as forecast
from pelagos_daemon import SLOW_S
from weather_cases import (ALL, FIELDS, LATS, LONS, SHORT, WIND, Case, message,
                           named, plain, plane, write_grib)


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
        # of no kind that it tells, but perturbed by the type of its data
        for kind, number in (("pf", 0), ("pf", 2)):
            self.refused(self.write("kind", [message(plane(n), [
                *named(n), "productDefinitionTemplateNumber=1",
                f"typeOfProcessedData={4 if kind == 'pf' else 3}",
                "typeOfEnsembleForecast=255", f"perturbationNumber={number}"])
                for n in WIND]), f"member {number}")

    def test_fill(self):
        """A fill value without a bitmap, and the command that makes it one."""
        v = [plane(n).copy() for n in WIND]
        for x in v:
            x[3:5, 4:9] = -99
        said = self.refused(self.write("fill", [
            message(x, named(n)) for x, n in zip(v, WIND)]), "fill value", "-99")
        self.assertIn("cdo setrtomiss,-99.0", said)

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


if __name__ == "__main__":
    unittest.main(verbosity=2)
