#!/usr/bin/python3
"""NetCDF files of weather services as they come: axes, units, calendars, members
and versions, each read rightly or refused by name."""
import os
import sys
import unittest

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from weather_cases import (ALL, DAY_S, FIELDS, LATS, LONS, NAMES, STANDARDS, UNITS,
                           WIND, NetCDFCase, plane)


class NetCDF(NetCDFCase):
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
