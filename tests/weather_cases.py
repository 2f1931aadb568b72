"""What tests of weather files share: fields that are functions of place and
time, files of them by ecCodes' tools and netCDF4, and what is read of these."""
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


UNITS = {"u": "m s-1", "v": "m s**-1", "h": "m", "p": "s", "d": "degree"}
STANDARDS = {"u": "eastward_wind", "v": "northward_wind",
             "h": "sea_surface_wave_significant_height",
             "p": "sea_surface_wave_period_at_variance_spectral_density_"
                  "maximum",
             "d": "sea_surface_wave_from_direction"}
NAMES = {"u": "u10", "v": "v10", "h": "swh", "p": "pp1d", "d": "mwd"}


class NetCDFCase(Case):
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
