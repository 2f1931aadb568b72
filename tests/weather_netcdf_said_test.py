#!/usr/bin/python3
"""NetCDF whose numbers look right and are not: fill values that nobody declared,
statistics, levels and maps of other kinds, directions that go to. Each is
refused by name, or read as its attributes say."""
import os
import shutil
import subprocess
import sys
import unittest

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import SLOW_S
from weather_cases import ALL, NAMES, WIND, NetCDFCase

CLASSIC = "NETCDF3_64BIT_DATA" # (HDF5 loses what is renamed.)
LAND = (slice(None), slice(3, 5), slice(4, 9)) # 10 nodes of each time


def attributes(names, **values):
    def change(d):
        for n in names:
            d[NAMES[n]].setncatts(values)
    return change


class Fills(NetCDFCase):
    def filled(self, value, names=WIND, kind="f4"):
        def change(d):
            for n in names:
                x = d[NAMES[n]][:]
                x[LAND] = value
                d[NAMES[n]][:] = x
        return self.make("fill.nc", ALL, change=change, kind=kind)

    def packed(self, fill, scale=0.001, kind="i2", offset=0., declared=None,
               **more):
        def change(d):
            d.set_auto_maskandscale(False)
            for n in WIND:
                old = d[NAMES[n]][:].astype("f8")
                d.renameVariable(NAMES[n], "old_" + n)
                v = d.createVariable(NAMES[n], kind, ("time", "lat", "lon"),
                                     fill_value=declared)
                v.set_auto_maskandscale(False)
                v.units, v.scale_factor, v.add_offset = "m s-1", scale, offset
                v.setncatts(more)
                raw = np.round((old - offset) / float(scale))
                raw[LAND] = fill
                v[:] = raw.astype(kind)
        return self.make("packed.nc", change=change, kind="f8")

    def mended(self, name, said, **right):
        """The command of the refusal, for each variable of ours."""
        self.assertIn("ncatted", said)
        if shutil.which("ncatted"):
            words = said[said.index("ncatted"):].split()
            self.assertEqual(words[-1], "FILE", said)
            for n in WIND:
                of = words[2].split(",")
                of[1] = NAMES[n]
                subprocess.run([*words[:2], ",".join(of), self.at(name)],
                               check=True, timeout=SLOW_S)
            self.right(name, holes=10, **right)

    def test_undeclared(self):
        for value in (-99, -99.9, 99.99, -77, -999, 1e10):
            name = self.filled(value)
            self.refused(name, "u10", f"has {value:g}", "fill value")
        for value in (-99, -9, -999, -361, 511):
            self.refused(self.filled(value, "d"), "mwd", f"has {value}")
        for value in (-99, -9, 32, 99):
            self.refused(self.filled(value, "h"), "swh", f"has {value}")
        # a calm is nothing odd
        def calm(d):
            for n in "uvh":
                x = d[NAMES[n]][:]
                x[LAND] = 0
                d[NAMES[n]][:] = x
        self.read(self.make("calm.nc", ALL, change=calm))

    def test_ends_of_types(self):
        for fill, kind, offset in ((-32768, "i2", 0.), (32767, "i2", 0.),
                                   (-2147483648, "i4", 0.),
                                   (65535, "u2", -30.)):
            name = self.packed(fill, kind=kind, offset=offset)
            said = self.refused(name, "u10", str(fill), "end of its type")
            self.mended(name, said)
        # a fill value that is told is another: -32768 is far from all then
        self.refused(self.packed(-32768, declared=-32767), "-32.768", "far")
        name = self.packed(-9999)
        self.mended(name, self.refused(name, "-9.999", "u10,o,s,-9999"))

    def test_told_otherwise(self):
        """Attributes as texts, of values instead of packed numbers, several."""
        short = np.int16
        for more in ({"missing_value": "-9999"},
                     {"missing_value": np.array([-888, -9999], short)},
                     {"missing_value": -9.999},
                     {"missing_value": np.float32(-9.999)},
                     {"valid_min": "-9000"},
                     {"valid_range": np.array([-9., 9.])}):
            self.right(self.packed(-9999, **more), holes=10)
        self.right(self.packed(-32768, scale="0.001", declared=-32768),
                   holes=10)


class Kinds(NetCDFCase):
    def test_levels(self):
        """A level of 10 is no height of 10 m."""
        for name, values, more in (
                ("lev", range(1, 21), {}),
                ("level", range(1, 21),
                 {"standard_name": "model_level_number"}),
                ("level", (10, 50, 1000), {}), ("plev", (10, 1000), {}),
                ("isobaricInhPa", (10, 1000), {}),
                ("depth", (0, 5, 10), {"units": "m", "positive": "down"}),
                ("hybrid", (137,), {}), ("sigma", (0.99,), {}),
                ("quantile", (0.9,), {}), ("percentile", (95,), {}),
                ("threshold", (15,), {})):
            values = list(values)
            at = values.index(10) if 10 in values else 0
            self.refused(self.extra("level.nc", name, values, right=at, **more),
                         f"along {name}", f"{values[0]:g}")
        for name, more in (("height", {"units": "m"}), ("height", {}),
                           ("height_above_ground1", {"units": "m"})):
            self.right(self.extra("level.nc", name, [2, 10, 80], right=1,
                                  **more))
        self.right(self.extra("level.nc", "odd", [7], right=0),
                   note="at its one odd, 7")

        def scalar(d):
            v = d.createVariable("quantile", "f8", ())
            v[...] = 0.9
            for n in WIND:
                d[NAMES[n]].coordinates = "quantile"
        self.refused(self.make("scalar.nc", change=scalar), "u10", "quantile")

    def test_methods(self):
        def of_time(name, method):
            def change(d):
                if name != "time":
                    d.renameDimension("time", name)
                    d.renameVariable("time", name)
                attributes(WIND, cell_methods=method)(d)
            return self.make("methods.nc", change=change, fmt=CLASSIC)
        for name, method in (
                ("T", "T: mean"), ("t", "t: mean"), ("time", "area: time: mean"),
                ("time", "time:mean"), ("time", "mean"),
                ("time", "realization: mean"), ("time", "area: maximum"),
                ("time", "number: standard_deviation time: point"),
                ("time", "area: mean where sea time: maximum"),
                ("time", "time: mean within days time: mean over days")):
            self.refused(of_time(name, method), "cell_methods")
        for name, method in (
                ("T", "T: point"), ("time", "area: mean where sea time: point"),
                ("time", "lat: lon: mean"), ("time", "time: lat: lon: point"),
                ("time", "time: point (interval: 1 h) area: mean")):
            self.right(of_time(name, method))

    def test_titles(self):
        for more in ({"GRIB_dataType": "em"}, {"GRIB_dataType": "es"},
                     {"GRIB_dataType": "pf"}, {"long_name": "wind gust"},
                     {"long_name": "10 metre U wind, 3-hour mean"},
                     {"long_name": "ensemble mean of 10 metre wind"},
                     {"long_name": "spread of 10 m wind"},
                     {"level": "80 m above ground"}, {"GRIB_level": 100,
                      "GRIB_typeOfLevel": "heightAboveGround"}):
            self.refused(self.make("title.nc", change=attributes(WIND, **more)),
                         "not read: u10")
        for more in ({"GRIB_dataType": "fc"}, {"level": "10 m above ground"},
                     {"long_name": "10 metre U wind component"}):
            self.right(self.make("title.nc", change=attributes(WIND, **more)))

    def test_maps(self):
        def of(name):
            def change(d):
                d.createVariable("crs", "i4", ()).grid_mapping_name = name
                attributes(WIND, grid_mapping="crs")(d)
            return self.make("map.nc", change=change)
        for name in ("rotated_latitude_longitude", "mercator"):
            self.refused(of(name), "u10", name, "cdo")
        self.right(of("latitude_longitude"))

        def mean_year(d):
            d["time"].climatology = "climatology_bounds"
        self.refused(self.make("year.nc", change=mean_year), "climatology")

    def test_zones(self):
        for units in ("hours since 2026-06-21 02:00 UTC +2",
                      "hours since 2026-06-21 00:00:00 +02:00 DST"):
            self.refused(self.make("zone.nc", time=(units, None)), units)


class Ways(NetCDFCase):
    """A direction without a standard_name comes from there, and no text of its
    own may say otherwise."""

    def test_to(self):
        turn = {"d": lambda x: x + 180}
        for key, text in (
                ("long_name", "mean wave direction (to)"),
                ("long_name", "wave propagation direction"),
                ("long_name", "mean direction, going-to"),
                ("long_name", "Direction of waves (degrees to, true north)"),
                ("long_name", "heading of waves"),
                ("comment", "direction waves go to"),
                ("convention", "oceanographic"),
                ("direction_convention", "to")):
            name = self.make("to.nc", ALL, values=turn,
                             change=attributes("d", **{key: text}))
            said = self.refused(name, "mwd", key, text[:20], "ncatted")
        if shutil.which("ncatted"):
            words = said[said.index("ncatted"):].split()
            subprocess.run([*words[:-1], self.at(name)], check=True,
                           timeout=SLOW_S)
            self.right(name, ALL)
        for text in ("Mean wave direction", "Direction from which waves come",
                     "Direction relative to true north", "Total direction",
                     "Mean direction of total swell"):
            self.right(self.make("from.nc", ALL,
                                 change=attributes("d", long_name=text)), ALL)

    def test_against_the_compass(self):
        for text in ("Cartesian convention", "counterclockwise from east",
                     "mathematical"):
            self.refused(self.make("turned.nc", ALL, change=attributes(
                "d", comment=text)), "against the compass", "ncap2")

    def test_wind(self):
        def polar(d):
            u, v = d["u10"][:], d["v10"][:]
            d.renameVariable("u10", "wind_speed")
            d.renameVariable("v10", "wind_direction")
            d["wind_speed"][:] = np.hypot(u, v)
            d["wind_direction"][:] = np.degrees(np.arctan2(u, v)) % 360
            d["wind_direction"].units = "degrees"
            d["wind_direction"].long_name = "direction it blows towards"
        name = self.make("polar.nc", change=polar, kind="f8", fmt=CLASSIC)
        self.refused(name, "wind_direction", "c,wind_to_direction FILE")


if __name__ == "__main__":
    unittest.main(verbosity=2)
