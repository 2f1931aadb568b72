#!/usr/bin/python3
"""Wave spectra of others' forms (--spectra): WAVEWATCH III, SWAN, ERA5, NDBC.
The sea of each has the height, peak and direction that numpy integrates from
the same file; damaged files are refused and the sea stays. Files are made
here; those of ../shared/data are tried too, where they lie."""
import datetime
import json
import math
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

import netCDF4
import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import BIN, ROOT, SLOW_S, Daemon

SHARED = os.path.join(os.path.dirname(ROOT), "shared/data/waves")
EPOCH = datetime.datetime(2020, 6, 8, 3, tzinfo=datetime.timezone.utc)
STEP = datetime.timedelta(hours=3)
F = 0.04 * 1.1 ** np.arange(26)
FROM = np.arange(5.0, 360.0, 10.0)  # degrees


def density(height, period, come_from):
    """m2/Hz/degree over F and FROM."""
    fp = 1 / period
    s = F ** -5 * np.exp(-1.25 * (F / fp) ** -4)
    s *= height ** 2 / 16 / np.trapz(s, F)
    d = np.maximum(np.cos(np.radians(FROM - come_from)), 0) ** 6
    return s[:, None] * (d / d.sum() / 10)[None, :]


def moments(f, come_from, e):
    """Hs, Tp, mean direction from, of e per Hz and per bin of direction."""
    s = e.sum(1)
    a = np.radians(come_from)
    x = np.trapz((e * np.cos(a)).sum(1), f)
    y = np.trapz((e * np.sin(a)).sum(1), f)
    return (4 * math.sqrt(np.trapz(s, f)), 1 / f[s.argmax()],
            math.degrees(math.atan2(y, x)) % 360)


SEAS = {"one": density(2.0, 9, 240), "two": density(3.5, 12, 300)}


def swan(path):
    with open(path, "w") as f:
        f.write("SWAN   1  Swan standard spectral file\n$ made by a test\n"
                "TIME\n 1\nLONLAT\n 2\n 10.0 50.0\n 12.5 51.0\n"
                f"AFREQ\n {len(F)}\n" + "".join(f"{v:.5f}\n" for v in F)
                + f"NDIR\n {len(FROM)}\n" + "".join(f"{v:.4f}\n" for v in FROM)
                + "QUANT\n 1\nVaDens  variance\nm2/Hz/degr  unit\n -99 none\n")
        for i in range(2):
            f.write((EPOCH + i * STEP).strftime("%Y%m%d.%H%M%S  time\n"))
            if i == 0:
                f.write("NODATA\n")
            for name in ("one", "two")[1 - i:]:
                e = SEAS[name] * (1 + i) ** 2
                unit = e.max() / 9999
                f.write(f"FACTOR\n {unit:.8E}\n" + "\n".join(
                    " ".join(f"{v:5.0f}" for v in row) for row in e / unit)
                    + "\n")


def ww3(path):
    to = np.radians((FROM + 180) % 360)
    with open(path, "w") as f:
        f.write(f"'WAVEWATCH III SPECTRA' {len(F)} {len(FROM)} 2 'a test'\n")
        for row in (F, to):
            f.write(" ".join(f"{v:.4E}" for v in row) + "\n")
        f.write(EPOCH.strftime("%Y%m%d %H%M%S\n"))
        for name in SEAS:
            f.write(f"'{name:10s}' 50.0 10.0 100.0 8.0 270.0 0.1 90.0\n")
            e = SEAS[name].T * math.degrees(1)  # frequencies run first
            f.write("\n".join(f"{v:.5E}" for v in e.ravel()) + "\n")


def netcdf(path, kind):
    with netCDF4.Dataset(path, "w", format={"ww3": "NETCDF3_CLASSIC"}.get(
            kind, "NETCDF4")) as d:
        for name, size in (("time", None), ("station", 2),
                           ("frequency", len(F)), ("direction", len(FROM)),
                           ("text", 8)):
            d.createDimension(name, size)
        t = d.createVariable("time", "f8", ("time",))
        t.units = "days since 1990-01-01T00:00:00Z"
        t[:] = [(EPOCH - datetime.datetime(
            1990, 1, 1, tzinfo=datetime.timezone.utc)).total_seconds() / 86400]
        d.createVariable("frequency", "f4", ("frequency",))[:] = F
        v = d.createVariable("direction", "f4", ("direction",))
        names = d.createVariable("station_name", "S1", ("station", "text"))
        for i, name in enumerate(SEAS):
            names[i] = netCDF4.stringtochar(np.array([name], "S8"))[0]
        if kind == "ww3":
            v.standard_name, v.units = "sea_surface_wave_to_direction", "degree"
            v[:] = (FROM + 180) % 360
        else:
            v.standard_name = "sea_surface_wave_from_direction"
            v.units = "radians"
            v[:] = np.radians(FROM)
        e = d.createVariable("efth" if kind == "ww3" else "density", "f4",
                             ("time", "station", "frequency", "direction"))
        e[:] = np.array(list(SEAS.values()))[None] * math.degrees(1)


def era5(path):
    f, to = 0.03453 * 1.1 ** np.arange(30), 7.5 + 15 * np.arange(24)
    s = f ** -5 * np.exp(-1.25 * (f * 11) ** -4)
    s *= 2.5 ** 2 / 16 / np.trapz(s, f)
    d = np.maximum(np.cos(np.radians(to + 180 - 210)), 0) ** 4
    e = s[:, None] * (d / d.sum() / 15)[None, :]
    with netCDF4.Dataset(path, "w") as n:
        for name, size in (("longitude", 2), ("latitude", 1),
                           ("direction", 24), ("frequency", 30), ("time", 1)):
            n.createDimension(name, size)
        n.createVariable("longitude", "f4", ("longitude",))[:] = [0, 36]
        n.createVariable("latitude", "f4", ("latitude",))[:] = [40]
        t = n.createVariable("time", "i4", ("time",))
        t.units = "hours since 1900-01-01 00:00:00.0"
        t[:] = [1055811]
        v = n.createVariable("d2fd", "i2", ("time", "frequency", "direction",
                                            "latitude", "longitude"),
                             fill_value=-32767)
        v.scale_factor, v.add_offset = 14 / 65000, -5.0
        with np.errstate(divide="ignore"):
            logs = np.log10(e * math.degrees(1))
        logs = np.ma.masked_less(logs, -11.9)
        full = np.ma.masked_all((1, 30, 24, 1, 2))
        full[0, :, :, 0, 0] = logs
        v[:] = full
    return moments(f, (to + 180) % 360, e * 15)


def historical(folder):
    """Values of a year as NDBC has them; the 99.00 and MM are missing."""
    head = "#YY  MM DD hh mm " + " ".join(f"{v:.4f}" for v in F) + "\n"
    s = SEAS["one"].sum(1) * 10
    rows = {"w": s, "d": s * 0 + 240, "i": s * 0 + 240, "j": s * 0 + 0.8,
            "k": s * 0 + 0.5}
    for letter, row in rows.items():
        with open(os.path.join(folder, f"tst{letter}2020.txt"), "w") as f:
            f.write(head)
            text = [f"{v:.4f}" for v in row]
            text[-1] = "MM" if letter == "w" else "999.0"
            f.write("2020 06 08 03 00 " + " ".join(text) + "\n")


def realtime(folder, directions):
    name = "dir" if directions else "nodir"
    s = SEAS["one"].sum(1) * 10
    rows = {"data_spec": s}
    if directions:
        rows.update(swdir=s * 0 + 240, swdir2=s * 0 + 240, swr1=s * 0 + 0.8,
                    swr2=s * 0 + 0.5)
    for ending, row in rows.items():
        with open(os.path.join(folder, f"{name}.{ending}"), "w") as f:
            f.write("#YY  MM DD hh mm\n2020 06 08 03 00 "
                    + ("9.999 " if ending == "data_spec" else "")
                    + " ".join(f"{'MM' if i == 0 else f'{v:.3f}'} ({x:.3f})"
                               for i, (v, x) in enumerate(zip(row, F)))
                    + "\n")


READER = os.path.join(BIN, "pelagos-spectrum")
HZ = 0.03 + 0.01 * np.arange(38)
STAMP = "2026-06-21T12:00:00"


def buoy_sea():
    """2 m, 10 s, m2/Hz over HZ."""
    with np.errstate(under="ignore"):
        s = HZ ** -5.0 * np.exp(-1.25 * (HZ * 10) ** -4)
    return s * 0.25 / np.trapz(s, HZ)


def read(path, station="", time="nan"):
    """Hs, Tp, direction and the moments at the peak; or the reader's words."""
    done = subprocess.run([READER, *os.path.split(path), time, station],
                          capture_output=True, timeout=SLOW_S)
    if done.returncode:
        return done.stderr.decode()
    n = struct.unpack("<i", done.stdout[8:12])[0]
    f, e, r1, r2, a1, a2 = np.frombuffer(done.stdout[24:]).reshape(6, n)
    x, y = (np.trapz(e * r1 * g(a1), f) for g in (np.cos, np.sin))
    k = e.argmax()
    return {"hs": 4 * math.sqrt(np.trapz(e, f)), "tp": 1 / f[k], "r1": r1[k],
            "r2": r2[k], "from": (270 - math.degrees(math.atan2(y, x))) % 360,
            "from2": (270 - math.degrees(a2[k])) % 180, "bands": n}


class Forms(unittest.TestCase):
    """Each form and unit by the reader alone: 2 m, 10 s, from 210."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="pelagos-forms-")
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.count = 0

    def path(self, ending):
        type(self).count += 1
        return os.path.join(self.folder, f"{self.count}{ending}")

    def write(self, ending, text):
        path = self.path(ending)
        with open(path, "w", encoding="utf-8") as f:
            f.write(text)
        return path

    def is_it(self, path, come_from=210, **place):
        got = read(path, **place)
        self.assertIsInstance(got, dict, got)
        self.assertAlmostEqual(got["hs"], 2, delta=0.03, msg=path)
        self.assertAlmostEqual(got["tp"], 10, delta=0.6, msg=path)
        if come_from is None:
            self.assertEqual(got["r1"], 0)
        else:
            self.assertAlmostEqual(got["from"], come_from, delta=1, msg=path)
        return got

    def refused(self, path, *words, **place):
        got = read(path, **place)
        self.assertIsInstance(got, str, got)
        print(got.strip())
        for word in words:
            self.assertIn(word, got)

    # --- SWAN ---------------------------------------------------------------

    def swan(self, names, unit="m2/Hz/degr", quantity="VaDens", value=None,
             factor=1.0):
        e = density(2, 10, 210) / factor
        text = ("SWAN   1\nTIME\n 1\nLONLAT\n"
                f" {len(names)}  number of locations\n")
        for i, name in enumerate(names):
            text += f" {5.1 + i:.3f} 52.550 {name}\n"
        text += (f"AFREQ\n {len(F)}\n" + "".join(f"{v:.5f}\n" for v in F)
                 + f"NDIR\n {len(FROM)}\n" + "".join(f"{v}\n" for v in FROM)
                 + f"QUANT\n 1\n{quantity}\n{unit}  unit\n -99 none\n"
                 "20260621.120000\n")
        for i in range(len(names)):
            rows = e * (1 + i) ** 2
            text += "FACTOR\n 1e-8\n" + "\n".join(
                " ".join(str(value) if value is not None else f"{v:.0f}"
                         for v in row * 1e8) for row in rows) + "\n"
        return self.write(".spc", text)

    def test_swan_by_place_name(self):
        for names, asked in ((("Buoy_North", "Buoy_South"), "Buoy_North"),
                             (("'Harbour mouth 1'", "'Harbour mouth 2'"),
                              "Harbour mouth 1"),
                             (("46000", "46001"), "46000"),
                             (("2", "1"), "2"), (("a", "b"), "A"),
                             (("", ""), "1"), (("$ x", "$ y"), "1")):
            path = self.swan(names)
            self.is_it(path, station=asked)
            self.is_it(path, station="52.55,5.1")
            self.assertIn("which station", read(path))
        path = self.swan(("Pier_A", "Pier_B"))
        self.assertAlmostEqual(read(path, "Pier_B")["hs"], 4, delta=0.06)
        self.refused(path, "no station", "Pier_A", station="Pier_C")
        self.is_it(self.swan(("Alone",)))

    def test_swan_units(self):
        g = 1025 * 9.80665
        for unit, quantity, factor in (
                ("m2/Hz/degr", "VaDens", 1), ("J/m2/Hz/degr", "EnDens", 1 / g),
                ("m2/Hz/rad", "VaDens", math.pi / 180)):
            self.is_it(self.swan(("a",), unit, quantity, factor=factor))
        self.refused(self.swan(("a",), "m2/Hz"), "m2/Hz/degr")
        self.refused(self.swan(("a",), value=-99), "no data")

    # --- NDBC ---------------------------------------------------------------

    def ndbc(self, head, stamp, minutes=True, missing=(), letters="w",
             mark="999.00", second=""):
        type(self).count += 1
        rows = {"w": buoy_sea(), "d": HZ * 0 + 210, "i": HZ * 0 + 212,
                "j": HZ * 0 + .85, "k": HZ * 0 + .55}
        for letter in letters:
            path = os.path.join(self.folder,
                                f"{44000 + self.count}{letter}2019.txt")
            with open(path, "w") as f:
                f.write(head + " ".join(f"{v:.3f}"[1:] for v in HZ) + "\n"
                        + second)
                f.write(stamp + (" 00 " if minutes else " ") + " ".join(
                    mark if i in missing else f"{v:.2f}"
                    for i, v in enumerate(rows[letter])) + "\n")
        return os.path.join(self.folder, f"{44000 + self.count}w2019.txt")

    def test_ndbc_heads(self):
        for head, stamp, minutes in (
                ("YYYY MM DD hh  ", "2000 01 01 00", False),
                ("YY MM DD hh  ", "96 01 01 00", False),
                ("#YY  MM DD hh mm   ", "2019 01 01 00", True),
                ("YYYY MM DD hh mm ", "2005 01 01 00", True)):
            self.is_it(self.ndbc(head, stamp, minutes), None)
            path = self.ndbc(head, stamp, minutes, letters="wdijk")
            self.is_it(path)
            folder = os.path.join(self.folder, f"LARGE{self.count}")
            os.mkdir(folder)
            for letter in "wdijk":
                name = os.path.basename(path).replace("w", letter)
                shutil.copy(os.path.join(self.folder, name),
                            os.path.join(folder, name.upper()))
            self.is_it(os.path.join(folder, os.path.basename(path).upper()))
        self.is_it(self.ndbc("#YY  MM DD hh mm ", "2019 01 01 00",
                             second="#yr  mo dy hr mn Hz\n"), None)

    def test_ndbc_files_that_are_no_densities(self):
        """A file of directions looks like one of densities: 37 m of sea."""
        head, stamp = "#YY  MM DD hh mm   ", "2019 01 01 00"
        path = self.ndbc(head, stamp, letters="wdijk")
        folder = os.path.join(self.folder, f"ndbc{self.count}")
        os.mkdir(folder)
        for letter in "wdijk":
            shutil.copy(os.path.join(
                self.folder, os.path.basename(path).replace("w", letter)),
                os.path.join(folder, f"44902{letter}2019.txt"))
        at = lambda letter: os.path.join(folder, f"44902{letter}2019.txt")
        self.is_it(at("w"))
        for letter, words in (("d", "alpha1"), ("i", "alpha2"), ("j", "r1"),
                              ("k", "r2")):
            self.refused(at(letter), words, "44902w2019.txt")
        shutil.copy(at("d"), os.path.join(folder, "renamed.txt"))
        self.refused(os.path.join(folder, "renamed.txt"), "bands are 210",
                     "no densities")
        os.remove(at("j"))
        self.refused(at("w"), "'j'", "r1")
        for letter in "dik":
            os.remove(at(letter))
        self.is_it(at("w"), None)

    def test_missing_bands_are_no_calm_sea(self):
        head, stamp = "#YY  MM DD hh mm   ", "2019 01 01 00"
        for mark in ("999.00", "MM", "99.00", "9999.0"):
            path = self.ndbc(head, stamp, missing=range(38), mark=mark)
            self.refused(path, "no density", "measuredTime")
        got = self.is_it(self.ndbc(head, stamp, missing=(0, 1, 20, 37)), None)
        self.assertEqual(got["bands"], 34)
        path = self.ndbc(head, stamp)
        with open(path, encoding="utf-8") as f:
            text = f.read()
        with open(path, "w", encoding="utf-8") as f:
            f.write(text.rstrip().rsplit(" ", 1)[0] + "\n" + text.split(
                "\n")[1] + "\n")
        self.refused(path, "line 2", "fewer values")

    def test_ndbc_fills_among_bands(self):
        """99.00 in some bands was a sea of 11 m, of all alike no sea at all."""
        head, stamp = "#YY  MM DD hh mm   ", "2019 01 01 00"
        for mark in ("99.00", "9.99", "99.99"):
            got = self.is_it(self.ndbc(head, stamp, missing=(0, 1, 36, 37),
                                       mark=mark), None)
            self.assertEqual(got["bands"], 34, mark)
            self.refused(self.ndbc(head, stamp, missing=range(38), mark=mark),
                         "no density")
        self.refused(self.ndbc(head, "2019 02 30 00"), "time")

    def test_ndbc_moments_in_hundredths(self):
        path = self.ndbc("#YY  MM DD hh mm   ", "2019 01 01 00",
                         letters="wdijk")
        plain = self.is_it(path)
        for letter in "jk":
            other = os.path.join(self.folder, os.path.basename(path).replace(
                "w", letter))
            with open(other, encoding="utf-8") as f:
                top, *rows = f.read().splitlines()
            with open(other, "w", encoding="utf-8") as f:
                f.write(top + "\n")
                for row in rows:
                    words = row.split()
                    f.write(" ".join(words[:5] + [
                        f"{100 * float(w):.2f}" for w in words[5:]]) + "\n")
        self.assertAlmostEqual(self.is_it(path)["r1"], plain["r1"], 3)

    def netcdf(self, directions=True, scale=1.0, axis=HZ, axis_units="Hz",
               units="m2/Hz", missing=slice(0, 0), polar=slice(0, 0),
               time_units="seconds since 1970-01-01", calendar=None):
        path = self.path(".nc")
        with netCDF4.Dataset(path, "w") as d:
            for name, size in (("time", 1), ("frequency", len(axis)),
                               ("latitude", 1), ("longitude", 1)):
                d.createDimension(name, size)
            t = d.createVariable("time", "f8", ("time",))
            t.units, t[:] = time_units, 1782043200
            if calendar:
                t.calendar = calendar
            f = d.createVariable("frequency", "f8", ("frequency",))
            f.units, f[:] = axis_units, axis
            for name in ("latitude", "longitude"):
                d.createVariable(name, "f4", (name,))[:] = 40
            rows = {"spectral_wave_density": buoy_sea() * scale}
            if directions:
                rows.update(mean_wave_dir=HZ * 0 + 210, principal_wave_dir=
                            HZ * 0 + 212, wave_spectrum_r1=HZ * 0 + .85,
                            wave_spectrum_r2=HZ * 0 + .55)
            for name, row in rows.items():
                v = d.createVariable(name, "f8", ("time", "frequency",
                                                  "latitude", "longitude"),
                                     fill_value=999.0)
                row = np.ma.array(row)
                row[missing if name[0] == "s" else polar] = np.ma.masked
                v[:] = row[None, :, None, None]
            d["spectral_wave_density"].units = units
        return path

    def test_netcdf_of_buoys(self):
        self.is_it(self.netcdf())
        self.is_it(self.netcdf(directions=False), None)
        self.is_it(self.netcdf(polar=slice(0, 38)), None)
        self.is_it(self.netcdf(polar=slice(20, 38)))
        self.refused(self.netcdf(missing=slice(0, 38)), "no density")
        self.assertEqual(self.is_it(self.netcdf(missing=slice(30, 38)))
                         ["bands"], 30)

    def test_netcdf_units(self):
        w = 2 * math.pi * HZ
        self.is_it(self.netcdf(units="(meter * meter)/Hz"))
        self.is_it(self.netcdf(scale=1e4, units="cm2/Hz"))
        self.is_it(self.netcdf(axis=1e3 * HZ, axis_units="mHz"))
        self.is_it(self.netcdf(axis=w, axis_units="rad/s"))
        self.is_it(self.netcdf(axis=w, axis_units="rad s-1",
                               scale=1 / 2 / math.pi, units="m2 s rad-1"))
        self.is_it(self.netcdf(axis=1 / HZ, axis_units="s"))
        self.is_it(self.netcdf(axis=1 / HZ, axis_units="s", scale=HZ ** 2,
                               units="m2/s"))
        self.refused(self.netcdf(axis=w, axis_units="rad/s", units="m2 s"),
                     "m2 s", "ncatted")
        for wrong in ("m", "m2/Hz/degr", "J", "dB", "m2 Hz"):
            self.refused(self.netcdf(units=wrong), f'"{wrong}"', "ncatted")
        for wrong in ("m", "1", "kayser"):
            self.refused(self.netcdf(axis_units=wrong), f'"{wrong}"',
                         "ncatted")

    def test_netcdf_times(self):
        minute = "seconds since 1970-01-01 00:00:00 +01:00"
        self.is_it(self.netcdf(), time="1782043200")
        self.is_it(self.netcdf(time_units=minute), time="1782039600")
        self.refused(self.netcdf(calendar="lunar"), "lunar")
        self.refused(self.netcdf(time_units="fortnights since 1970-01-01"),
                     "fortnights")

    def test_netcdf_directions(self):
        def change(units, standard=None, long_name=None, values=None,
                   density_units=None, scale=1.0):
            path = self.path(".nc")
            netcdf(path, "swan")
            with netCDF4.Dataset(path, "a") as d:
                v = d["direction"]
                for name in ("standard_name", "units"):
                    v.delncattr(name)
                for name, text in (("units", units), ("long_name", long_name),
                                   ("standard_name", standard)):
                    if text:
                        v.setncattr(name, text)
                v[:] = FROM if values is None else values
                d["density"][:] = (density(2, 10, 210) * math.degrees(1)
                                   * scale)[None, None]
                if density_units:
                    d["density"].units = density_units
            return path
        wave = "sea_surface_wave_"
        to, radians = (FROM + 180) % 360, np.radians(FROM)
        for case in (
                ("degree", wave + "from_direction"),
                ("degreeT", wave + "from_direction"),
                ("radians", wave + "from_direction", None, radians),
                ("degree", wave + "to_direction", None, to),
                ("degree", None, "direction waves come from"),
                (None, wave + "from_direction"),
                ("degree", wave + "from_direction", None, None,
                 "m2/Hz/degree", math.pi / 180),
                ("degree", wave + "from_direction", None, None,
                 "m^{2}.s.degree^{-1}", math.pi / 180)):
            self.is_it(change(*case), station="1")
        self.refused(change("degree"), "come from", "ncatted", station="1")
        self.refused(change("gon", wave + "from_direction"), '"gon"',
                     station="1")
        self.refused(change(None, wave + "from_direction", None, radians),
                     "unit", station="1")
        self.refused(change("degree", wave + "from_direction", None, None,
                            "m2/Hz"), '"m2/Hz"', station="1")

    # --- buoys of others ----------------------------------------------------

    def test_cdip(self):
        def cdip(flag=1, missing=slice(0, 0)):
            path = self.path(".nc")
            with netCDF4.Dataset(path, "w") as d:
                d.createDimension("waveTime", 2)
                d.createDimension("waveFrequency", len(HZ))
                t = d.createVariable("waveTime", "i4", ("waveTime",))
                t.units = "seconds since 1970-01-01 00:00:00 UTC"
                t[:] = [1782043200, 1782045000]
                f = d.createVariable("waveFrequency", "f4", ("waveFrequency",))
                f.units, f[:] = "hertz", HZ
                flags = d.createVariable("waveFlagPrimary", "i1",
                                         ("waveTime",))
                flags[:] = flag
                a = math.radians(210)
                for name, row in (
                        ("waveEnergyDensity", buoy_sea()),
                        ("waveA1Value", 0.8 * math.cos(a)),
                        ("waveB1Value", 0.8 * math.sin(a)),
                        ("waveA2Value", 0.5 * math.cos(2 * a)),
                        ("waveB2Value", 0.5 * math.sin(2 * a))):
                    v = d.createVariable(name, "f4", (
                        "waveTime", "waveFrequency"), fill_value=-999.99)
                    row = np.ma.array(row + 0 * HZ)
                    row[missing] = np.ma.masked
                    v[:] = np.ma.stack([row, row])
                d["waveEnergyDensity"].units = "meter^2 second"
            return path
        got = self.is_it(cdip())
        self.assertAlmostEqual(got["r1"], 0.8, places=5)
        self.assertAlmostEqual(got["r2"], 0.5, places=5)
        self.assertAlmostEqual(got["from2"], 30, delta=0.1)
        self.is_it(cdip(), time="1782043200")
        self.refused(cdip(flag=4), "waveFlagPrimary", "measuredTime")
        self.refused(cdip(missing=slice(None)), "no density")

    def test_spotter(self):
        def spotter(ids=("SPOT-1",), **change):
            a = math.radians(270 - 210)
            row = {"frequency": list(HZ), "varianceDensity": list(buoy_sea()),
                   "a1": [0.8 * math.cos(a)] * 38,
                   "b1": [0.8 * math.sin(a)] * 38,
                   "a2": [0.5 * math.cos(2 * a)] * 38,
                   "b2": [0.5 * math.sin(2 * a)] * 38,
                   "direction": [210.0] * 38,
                   "directionalSpread": [36.0] * 38,
                   "timestamp": STAMP + ".000Z", "latitude": 52.5,
                   "longitude": 5.1}
            row = {k: v for k, v in {**row, **change}.items() if v is not None}
            return self.write(".json", json.dumps({"data": [
                {"waves": [], "frequencyData": [row], "spotterId": name}
                for name in ids]}))
        got = self.is_it(spotter())
        self.assertAlmostEqual(got["r1"], 0.8, places=5)
        self.assertAlmostEqual(got["from2"], 30, delta=0.1)
        self.is_it(spotter(("SPOT-1", "SPOT-2")), station="SPOT-2")
        self.refused(spotter(("SPOT-1", "SPOT-2")), "SPOT-1")
        self.is_it(spotter(a1=None, b1=None, a2=None, b2=None))
        self.is_it(spotter(a2=None, b2=None))
        self.is_it(spotter(timestamp=STAMP + "+02:00"), time="1782036000")
        self.refused(spotter(), "no record within", time="1782136000")
        self.refused(spotter(direction=[30.0] * 38), "differ by 180")
        self.refused(spotter(varianceDensity=[None] * 38), "no density")
        self.refused(spotter(a1=[0.1]), "a1 has 1 values")
        self.refused(spotter(varianceDensity=None), "includeFrequencyData")
        for text in ("{", "[" * 100, '{"data":', '{"a":[1,}'):
            self.refused(self.write(".json", text), "JSON")

    def test_datawell(self):
        def spt(height=200, first="", spread=36.0, kurtosis=3.0, ending=".spt",
                energy=1.0, tail=""):
            s = buoy_sea()
            return self.write(ending, first + "\r\n".join(
                ["5", f"{height}", "8.0", f"{s.max():.4f}", "18.0", "15.0", "7",
                 "0.0", "0.0", "0.0", "90", "66\u00b0"]
                + [f"{f:.4f},{energy * e / s.max():.4e},210.0,{spread},0.00,"
                   f"{kurtosis}" for f, e in zip(HZ, s)]) + tail)
        for ending in (".spt", ".SPT", "}2026-06-21T12h00Z.spt"):
            got = self.is_it(spt(ending=ending))
            self.assertAlmostEqual(got["r1"], 1 - math.radians(36) ** 2 / 2,
                                   places=5)
            self.assertAlmostEqual(got["from2"], 30, delta=0.1)
        self.is_it(spt(first="PTR\r\n"))
        self.is_it(spt(tail="\r\n"))
        self.is_it(spt(ending="}2026-06-21T12h00Z.spt"), time="1782043200")
        self.refused(spt(ending="}2026-06-21T12h00Z.spt"), "2026-06-21T12:00",
                     time="1782143200")
        self.refused(spt(height=0), "no spectrum")
        self.refused(spt(energy=0), "no spectrum")
        self.refused(self.write(".spt", "nothing\nhere\n"), "Hs in cm")


class Files(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="pelagos-spectra-")
        for name in os.listdir(SHARED) if os.path.isdir(SHARED) else ():
            shutil.copy(os.path.join(SHARED, name), cls.folder)
        at = lambda name: os.path.join(cls.folder, name)
        swan(at("made.spec"))
        ww3(at("made.ww3"))
        netcdf(at("made-ww3.nc"), "ww3")
        netcdf(at("made-swan.nc"), "swan")
        cls.era5 = era5(at("made-era5.nc"))
        historical(cls.folder)
        realtime(cls.folder, True)
        realtime(cls.folder, False)
        cls.daemon = Daemon("--spectra", cls.folder)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)
        assert cls.daemon.stop() == 0

    def sea(self, measured, time=None):
        return self.daemon.request("PATCH", "/v1/state", json.dumps({"sea": {
            "spectrum": "MEASURED", "measured": measured,
            "measuredTime": time}}).encode())

    def numbers(self, measured, time=None):
        answer = self.sea(measured, time)
        self.assertEqual(answer.status, 200, (measured, answer))
        s = self.daemon.get("/v1/spectrum").json()
        return (s["spectrum"]["significantHeight"], s["peakPeriod"],
                s["meanDirection"])

    def check(self, want, measured, time=None, bars=(0.04, 0.06, 3)):
        """Bars: of Hs and Tp relative, of the direction degrees. The daemon
        continues the spectrum beyond the record, and its peak lies between
        bins."""
        got = self.numbers(measured, time)
        print(f"{measured} {time or ''}: Hs {got[0]:.3f} ({want[0]:.3f}) m, "
              f"Tp {got[1]:.2f} ({want[1]:.2f}) s, "
              f"from {got[2]:.1f} ({want[2]}) deg")
        self.assertLess(abs(got[0] / want[0] - 1), bars[0], measured)
        self.assertLess(abs(got[1] / want[1] - 1), bars[1], measured)
        if want[2] is not None:
            self.assertLess(abs((got[2] - want[2] + 180) % 360 - 180), bars[2],
                            measured)

    def test_each_form_by_station(self):
        for i, name in enumerate(SEAS):
            want = moments(F, FROM, SEAS[name] * 10)
            self.check(want, f"made.ww3#{name}")
            self.check(want, f"made-ww3.nc#{name}")
            self.check(want, f"made-swan.nc#{i + 1}")
        self.check(moments(F, FROM, SEAS["two"] * 10), "made.spec#51,12.4",
                   EPOCH.isoformat().replace("+00:00", "Z"))
        self.check(moments(F, FROM, SEAS["one"] * 40), "made.spec#1")
        self.check(self.era5, "made-era5.nc#40,0.5")

    def test_buoys_with_missing_values(self):
        want = moments(F, FROM, SEAS["one"] * 10)
        self.check(want, "tstw2020.txt")
        self.check(want, "dir")
        self.check(want[:2] + (None,),
                   "nodir")

    def test_names_with_marks_and_of_any_length(self):
        want = moments(F, FROM, SEAS["two"] * 10)
        for name in ("buoy#3.ww3", "s\u00fcd " + "x" * 240 + ".ww3"):
            shutil.copy(os.path.join(self.folder, "made.ww3"),
                        os.path.join(self.folder, name))
            self.check(want, name + "#two")
            self.assertIn("one", self.sea(name).body.decode())

    def test_what_is_not_there_is_listed(self):
        for measured, time, words in (
                ("made.ww3", None, ("one", "two", "#")),
                ("made.ww3#three", None, ("one", "two")),
                ("made.spec#1", "2020-06-08T03:00:00Z", ("no data",)),
                ("made.spec#2", "2021-06-08T03:00:00Z", ("2020-06-08",)),
                ("made-era5.nc#40,36", None, ("no data",)),
                ("made-era5.nc#-40,36", None, ("40,",)),
                ("none.nc", None, ("no such file",)),
                ("../made.ww3", None, ("below",))):
            answer = self.sea(measured, time)
            self.assertIn(answer.status, (400, 404, 409, 422), measured)
            text = answer.body.decode()
            for word in words:
                self.assertIn(word, text, measured)

    def test_damaged_files_are_refused_and_nothing_is_lost(self):
        before = self.numbers("made.ww3#one")
        for name in ("made.spec", "made.ww3", "made-ww3.nc", "made-swan.nc",
                     "tstw2020.txt"):
            with open(os.path.join(self.folder, name), "rb") as f:
                whole = f.read()
            for kind, data in (("cut", whole[:len(whole) * 2 // 3]),
                               ("head", whole[:40]), ("empty", b""),
                               ("noise", whole[:60] + os.urandom(3000))):
                broken = kind + "-" + name
                with open(os.path.join(self.folder, broken), "wb") as f:
                    f.write(data)
                answer = self.sea(broken + "#1")
                self.assertNotEqual(answer.status, 200, broken)
                self.assertIn(broken, answer.body.decode())
        state = self.daemon.get("/v1/state").json()
        self.assertEqual(state["sea"]["measured"], "made.ww3#one")
        s = self.daemon.get("/v1/spectrum").json()
        self.assertEqual(s["spectrum"]["significantHeight"], before[0])

    def test_directions_that_are_none(self):
        at = os.path.join(self.folder, "nowhere.nc")
        netcdf(at, "swan")
        with netCDF4.Dataset(at, "a") as d:
            d["direction"][3] = float("nan")
        answer = self.sea("nowhere.nc#1")
        self.assertIn("direction 4 of 36 is no number", answer.body.decode())
        with netCDF4.Dataset(at, "a") as d:
            d["direction"][3] = 0.6
            d["density"][0, 0, 2, :] = 8e36
            d["density"].scale_factor = 1.5e271
        answer = self.sea("nowhere.nc#1")
        self.assertIn("has no end", answer.body.decode())

    @unittest.skipUnless(os.path.isdir(SHARED), "no shared data")
    def test_real_files(self):
        with open(os.path.join(SHARED, "swanfile.tab")) as f:
            for line in f:
                if line[0] != "%":
                    v = line.split()
                    day = v[0]
                    self.check((float(v[1]), float(v[4]), float(v[2])),
                               "swanfile.spec", f"{day[:4]}-{day[4:6]}-"
                               f"{day[6:8]}T00:00:00Z", bars=(0.04, 0.08, 6))
        with netCDF4.Dataset(os.path.join(SHARED, "ww3file.nc")) as d:
            f = d["frequency"][:].astype(float)
            e = d["efth"][-1, 1].astype(float)
            step = 2 * math.pi / 24
            self.check(moments(f, (d["direction"][:] + 180) % 360, e * step),
                       "ww3file.nc#2", bars=(0.05, 0.08, 4))
        with netCDF4.Dataset(os.path.join(SHARED, "swanfile.nc")) as d:
            f = d["frequency"][:].astype(float)
            e = d["density"][-1, 0].astype(float)
            self.check(moments(f, np.degrees(d["direction"][:]),
                               e * 2 * math.pi / 36), "swanfile.nc",
                       bars=(0.05, 0.08, 4))
        with netCDF4.Dataset(os.path.join(SHARED, "era5file.nc")) as d:
            x = np.ma.filled(d["d2fd"][0, :, :, 2, 3], -99)
            f = 0.03453 * 1.1 ** np.arange(30)
            self.check(moments(f, (7.5 + 15 * np.arange(24) + 180) % 360,
                               10.0 ** x * 2 * math.pi / 24),
                       "era5file.nc#" + f"{d['latitude'][2]:g},"
                       f"{d['longitude'][3]:g}", bars=(0.05, 0.08, 4))
        with netCDF4.Dataset(os.path.join(SHARED, "ndbc-42098w9999.nc")) as d:
            f = d["frequency"][:].astype(float)
            s = np.ma.filled(d["spectral_wave_density"][-1, :, 0, 0], 0)
            self.check((4 * math.sqrt(np.trapz(s, f)), 1 / f[s.argmax()],
                        None), "ndbc-42098w9999.nc",
                       # Two peaks, of 5.3 and 4.4 s, differ by 2 %.
                       bars=(0.05, 0.2, 4))
        self.assertGreater(self.numbers("ww3station.spec")[0], 0.1)
        self.assertGreater(self.numbers("swanhot.spec#12")[0], 0.01)


if __name__ == "__main__":
    unittest.main(verbosity=2)
