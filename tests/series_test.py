#!/usr/bin/python3
"""Series of numbers (/v1/series, pelagosctl --sweep): each cell is what the
question alone answers; JSON, CSV and NetCDF say the same; NetCDF is read by
ncdump and xarray and keeps CF's rules; what cannot be asked is refused by name."""
import csv
import datetime
import io
import itertools
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import threading
import unittest

import numpy as np
import xarray

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import (BIN, ROOT, SANITIZED, Daemon, Session, schema,
                            until)

# CF's standard name table 83: names that may stand in our files, with the
# table's canonical units.
CF = {"solar_elevation_angle": "degree", "solar_azimuth_angle": "degree",
      "solar_zenith_angle": "degree", "sensor_zenith_angle": "degree",
      "sensor_azimuth_angle": "degree", "radiation_wavelength": "m",
      "wind_speed": "m s-1", "time": "s",
      "sea_surface_wave_significant_height": "m",
      "sea_surface_wave_period_at_variance_spectral_density_maximum": "s",
      "sea_surface_wave_from_direction": "degree",
      "sea_surface_wave_directional_spread": "degree",
      "sea_surface_wind_wave_significant_height": "m",
      "sea_surface_swell_wave_significant_height": "m",
      "sea_surface_height_above_mean_sea_level": "m",
      "mass_concentration_of_chlorophyll_in_sea_water": "kg m-3"}
# Which of our units convert to those.
SAME = {"degree": {"degree"}, "m": {"m", "nm"}, "m s-1": {"m/s"}, "s": {"s"},
        "kg m-3": {"mg/m3"}}


def product(lists):
    return list(itertools.product(*lists))


class Case(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(unix=True)
        cls.addClassCleanup(cls.daemon.stop)
        cls.daemon.patch({"clock": {"mode": "STEPPED"},
                          "sea": {"synthesiser": "TROCHOIDS"},
                          "sky": {"sunElevation": 40, "sunAzimuth": 130}})
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name

    def series(self, path, **more):
        answer = self.daemon.get("/v1/series/" + path, **more)
        self.assertEqual(answer.status, 200, answer)
        return answer

    def lists(self, path):
        """Axes by name in order, variables as arrays over their axes."""
        s = self.series(path).json()
        axes = {a["name"]: np.array(a["values"]) for a in s.get("axes", [])}
        variables = {
            v["name"]: np.array(v["values"], float).reshape(
                [len(axes[a]) for a in v.get("axes", [])])
            for v in s["variables"]}
        return s, axes, variables

    def opened(self, data):
        path = os.path.join(self.folder, "series.nc")
        with open(path, "wb") as f:
            f.write(data)
        with xarray.open_dataset(path) as d:
            return d.load()

    def refused(self, path, status, *words, code=None):
        answer = self.daemon.get("/v1/series/" + path)
        self.assertEqual(answer.status, status, answer)
        problem = answer.json()
        for word in words:
            self.assertIn(word, problem["detail"])
        if code:
            self.assertEqual(problem["code"], code)
        return problem


class Cells(Case):
    def test_brdf_is_what_each_question_answers(self):
        _, axes, v = self.lists(
            "brdf?sweep=sunElevation=5:65:20;viewZenith=0:80:40&sea.windSpeed=9")
        self.assertEqual(list(axes), ["sunElevation", "viewZenith"])
        np.testing.assert_array_equal(axes["sunElevation"], [5, 25, 45, 65])
        np.testing.assert_array_equal(axes["viewZenith"], [0, 40, 80])
        for (i, s), (k, z) in product(map(enumerate, axes.values())):
            one = self.daemon.get(f"/v1/optics/brdf?viewZenith={z}&sky."
                                  f"sunElevation={s}&sea.windSpeed=9").json()
            for name in ("brdf", "meanFresnel", "lambdaSun"):
                self.assertEqual(v[name][i, k], one["brdf"][name], (s, z, name))
            self.assertEqual(v["sunAzimuth"][i, k], one["sunAzimuth"])

    def test_axes_of_any_order(self):
        """Cells are asked in another order than they are listed in."""
        a = self.lists("brdf?sweep=viewZenith=10,40,70;sea.windSpeed=4,9;"
                       "slopeCross=0.01,0.02")[2]["brdf"]
        b = self.lists("brdf?sweep=slopeCross=0.01,0.02;viewZenith=10,40,70;"
                       "sea.windSpeed=4,9")[2]["brdf"]
        np.testing.assert_array_equal(a, b.transpose(1, 2, 0))
        self.assertEqual(len(set(a.ravel())), 12)

    def test_water_by_wavelength(self):
        _, axes, v = self.lists("water?sweep=chlorophyll=0.1,3;"
                                "wavelength=400:700:50&sunZenith=40")
        self.assertEqual(v["remoteSensingReflectance"].shape, (2, 7))
        for i, c in enumerate(axes["chlorophyll"]):
            one = self.daemon.get(
                "/v1/optics/water?wavelength=400&wavelengthLast=700&"
                f"wavelengthStep=50&sunZenith=40&water.chlorophyll={c}"
            ).json()["water"]
            for name in ("total", "remoteSensingReflectance", "absorption",
                         "diffuseAttenuation"):
                np.testing.assert_array_equal(v[name][i], one[name])
        # Known for long: green water is not blue (Morel and Maritorena 2001).
        blue = v["remoteSensingReflectance"][:, 1]
        green = v["remoteSensingReflectance"][:, 3]
        self.assertGreater(blue[0], 2 * green[0])
        self.assertLess(blue[1], green[1])

    def test_lists_are_dimensions(self):
        s, axes, v = self.lists("sky?sweep=elevation=10:70:30&azimuth=20")
        np.testing.assert_array_equal(axes["wavelength"], [680, 550, 440])
        self.assertEqual(v["radiance"].shape, (3, 3))
        self.assertEqual(v["luminance"].shape, (3,))
        unit = {x["name"]: x["unit"] for x in s["variables"] + s["axes"]}
        self.assertEqual(unit["radiance"], "W/m2/sr/nm")
        self.assertEqual(unit["wavelength"], "nm")
        self.assertEqual(unit["elevation"], "deg")

    def test_spectrum(self):
        _, axes, v = self.lists("spectrum?sweep=sea.windSpeed=6,12&frequencies=5"
                                "&directions=8&lowest=0.5&highest=2")
        self.assertEqual(v["directional"].shape, (2, 5, 8))
        np.testing.assert_allclose(axes["omega"], np.geomspace(0.5, 2, 5))
        np.testing.assert_array_equal(axes["theta"],
                                      np.arange(8) * 45)
        for i, wind in enumerate((6, 12)):
            one = self.daemon.request("POST", "/v1/spectrum", {
                "frequencies": 5, "directions": 8, "lowest": 0.5, "highest": 2,
                "patch": {"state": {"sea": {"windSpeed": wind}}}}).json()
            self.assertEqual(v["spectrum_significantHeight"][i],
                             one["spectrum"]["significantHeight"])
            np.testing.assert_array_equal(
                v["directional"][i], [r["directional"] for r in one["rows"]])
        # Pierson and Moskowitz: Hs goes as the square of the wind.
        h = v["spectrum_significantHeight"]
        self.assertAlmostEqual(h[1] / h[0], 4, delta=0.01)

    def test_no_axes(self):
        _, axes, v = self.lists("brdf?viewZenith=30")
        self.assertEqual(axes, {})
        one = self.daemon.get("/v1/optics/brdf?viewZenith=30").json()["brdf"]
        self.assertEqual(float(v["brdf"]), one["brdf"])
        d = self.opened(self.series("spectrum?frequencies=4&directions=6&"
                                    "format=netcdf").body)
        self.assertEqual(d.directional.shape, (4, 6))
        self.assertEqual(d.peakPeriod.shape, ())

    def test_surface_by_time(self):
        _, axes, v = self.lists("surface?sweep=time=0:30:0.5&points=0,0;12,-7")
        self.assertEqual(v["height"].shape, (61, 2))
        np.testing.assert_array_equal(v["east"], [0, 12])
        np.testing.assert_array_equal(v["north"], [0, -7])
        for i in (0, 7, 60):
            one = self.daemon.request("POST", "/v1/surface", {
                "time": axes["time"][i], "points": [[0, 0], [12, -7]]}).json()
            np.testing.assert_array_equal(
                v["height"][i], [p["height"] for p in one["points"]])
            self.assertEqual(v["velocity_up"][i, 1],
                             one["points"][1]["velocity"]["up"])
        # Its standard deviation is a quarter of Hs, within what 30 s leave open.
        self.assertGreater(v["height"].std(), 0.05)

    def test_sky_by_time_follows_the_sun(self):
        self.daemon.patch({"sky": {"sunElevation": None, "sunAzimuth": None}})
        self.addCleanup(self.daemon.patch, {"sky": {"sunElevation": 40,
                                                    "sunAzimuth": 130}})
        _, axes, v = self.lists("sky?sweep=time=0:36000:7200")
        sun = v["sunElevation"]
        self.assertGreater(np.ptp(sun), 20)
        one = self.daemon.get("/v1/almanac?time=7200").json()["sun"]
        self.assertAlmostEqual(sun[1], one["elevation"], delta=0.01)

    def test_one_moment_while_the_clock_runs(self):
        self.daemon.patch({"sky": {"sunElevation": None},
                           "clock": {"mode": "FREE", "rate": 20}})
        self.addCleanup(self.daemon.patch, {"sky": {"sunElevation": 40},
                                            "clock": {"mode": "STEPPED"}})
        _, _, v = self.lists("sky?sweep=elevation=0:90:3")
        self.assertEqual(len(set(v["sunElevation"])), 1)

    def test_a_change_under_way_is_told(self):
        """No series is of two seas; what others do to ships does not matter."""
        answers = []
        t = threading.Thread(target=lambda: answers.append(self.daemon.get(
            "/v1/series/water?sweep=wavelength=400:700:1;"
            "chlorophyll=0.1,0.2,0.5,1,2")))
        t.start()
        wind = itertools.cycle((5, 6))
        while t.is_alive():
            self.daemon.patch({"sea": {"windSpeed": next(wind)}})
        t.join()
        self.assertEqual(answers[0].status, 409, answers[0])
        self.assertIn("ask again", answers[0].json()["detail"])


class Forms(Case):
    QUERY = "sky?sweep=sunElevation=10,50;elevation=20:60:20&azimuth=80"

    def test_csv_and_netcdf_say_what_json_says(self):
        s, axes, v = self.lists(self.QUERY)
        d = self.opened(self.series(self.QUERY + "&format=netcdf").body)
        text = self.series(self.QUERY + "&format=csv").body.decode()
        lines = text.split("\r\n")
        rows = list(csv.DictReader(l for l in lines if not l.startswith("#")))
        self.assertEqual(len(rows), math.prod(map(len, axes.values())))
        names = {a: i for i, a in enumerate(axes)}
        for row, at in zip(rows, product(range(len(a)) for a in axes.values())):
            for name, values in axes.items():
                self.assertEqual(float(row[name]), values[at[names[name]]])
            for x in s["variables"]:
                there = tuple(at[names[a]] for a in x["axes"])
                self.assertEqual(float(row[x["name"]]),
                                 v[x["name"]][there], x["name"])
        self.assertEqual(set(d.data_vars) | set(d.coords), set(v) | set(axes))
        for x in s["variables"]:
            self.assertEqual(list(d[x["name"]].dims), x["axes"])
            np.testing.assert_array_equal(d[x["name"]].values, v[x["name"]])
        for line in ("# radiance [W/m2/sr/nm]", "# elevation [deg]",
                     '# state: {"clock"'):
            self.assertIn("\n" + line, text)

    def test_netcdf_keeps_the_conventions(self):
        paths = [self.QUERY, "brdf?sweep=windSpeed=4,9;viewZenith=0:60:30",
                 "water?sweep=wavelength=400:700:100",
                 "spectrum?sweep=windSpeed=5,9&frequencies=3&directions=4",
                 "surface?sweep=time=0:4:1&points=0,0"]
        for path in paths:
            d = self.opened(self.series(path + "&format=netcdf").body)
            self.assertEqual(d.attrs["Conventions"], "CF-1.10")
            self.assertRegex(d.attrs["history"], r"^20\d\d-\d\d-\d\dT\d\d:\d\d:"
                             r"\d\dZ pelagosd \d+\.\d+\.\d+ on ")
            query = json.loads(d.attrs["history"].split(": ", 1)[1])
            self.assertEqual(len(query["sweep"]), path.split("&")[0].count("=")
                             - path.count("sweep="), path)
            self.assertIn("sea", json.loads(d.attrs["pelagos_state"]))
            again = self.opened(self.daemon.request(
                "POST", "/v1/series", query).body)
            self.assertTrue(d.equals(again), path)
            for name, v in {**d.data_vars, **d.coords}.items():
                self.assertRegex(name, r"^[A-Za-z][A-Za-z0-9_]*$")
                unit = v.attrs.get("units") or v.encoding.get("units")
                self.assertTrue(unit, name)
                self.assertNotIn("deg", unit.replace("degree", ""), name)
                standard = v.attrs.get("standard_name")
                if standard in CF and standard != "time":
                    self.assertIn(unit, SAME[CF[standard]], name)
                self.assertTrue(v.attrs.get("long_name"), name)

    def test_vectors_and_places(self):
        """Numbers of a vector have its unit; places of points are metres of
        a mapping that says where they are."""
        path = ("surface?sweep=time=0:2:1&points=0,0;3000,-4000"
                "&acceleration=true")
        s, _, v = self.lists(path)
        units = {x["name"]: x["unit"] for x in s["variables"]}
        for name, unit in {"velocity": "m/s", "acceleration": "m/s2",
                           "normal": "1"}.items():
            for axis in ("east", "north", "up"):
                self.assertEqual(units[f"{name}_{axis}"], unit)
        text = self.series(path + "&format=csv").body.decode()
        self.assertIn("# acceleration_east [m/s2]", text)
        d = self.opened(self.series(path + "&format=netcdf").body)
        for name, unit in units.items():
            self.assertEqual(d[name].attrs["units"],
                             "degree" if unit == "deg" else unit, name)
        self.assertEqual(d.east.attrs["standard_name"],
                         "projection_x_coordinate")
        self.assertEqual(d.north.attrs["standard_name"],
                         "projection_y_coordinate")
        crs = d[d.height.encoding["grid_mapping"]
                if "grid_mapping" in d.height.encoding
                else d.height.attrs["grid_mapping"]]
        self.assertEqual(crs.attrs["grid_mapping_name"],
                         "azimuthal_equidistant")
        origin = self.daemon.state()["origin"]
        self.assertEqual((crs.attrs["latitude_of_projection_origin"],
                          crs.attrs["longitude_of_projection_origin"]),
                         (origin["latitude"], origin["longitude"]))
        self.assertAlmostEqual(crs.attrs["inverse_flattening"],
                               298.257223563)
        # Appendix F's attributes of it, and no others that it has not.
        self.assertLessEqual({"false_easting", "false_northing",
                              "semi_major_axis"}, set(crs.attrs))
        d = self.opened(self.series("brdf?sweep=viewZenith=0:60:30"
                                    "&format=netcdf").body)
        self.assertNotIn("crs", d)

    def test_ncdump_reads_it(self):
        path = os.path.join(self.folder, "dump.nc")
        with open(path, "wb") as f:
            f.write(self.series(self.QUERY + "&format=netcdf").body)
        out = subprocess.run(["ncdump", "-v", "elevation", path], text=True,
                             capture_output=True, check=True).stdout
        self.assertIn("elevation = 20, 40, 60 ;", out)
        self.assertIn("radiance(sunElevation, elevation, wavelength)", out)
        kind = subprocess.run(["ncdump", "-k", path], text=True,
                              capture_output=True, check=True).stdout
        self.assertEqual(kind.strip(), "64-bit offset")

    def test_time_is_a_time(self):
        self.daemon.patch({"clock": {"utc": "2026-03-04T05:06:07Z"}})
        d = self.opened(self.series("surface?sweep=time=0:20:10&points=0,0"
                                    "&format=netcdf").body)
        self.assertEqual(str(d.time.values[2])[:19], "2026-03-04T05:06:27")
        self.assertEqual(d.height.attrs.get("coordinates")
                         or d.height.encoding.get("coordinates"), "east north")

    def test_accept(self):
        for accept, kind in (("text/csv", "text/csv"),
                             ("application/netcdf", "application/netcdf"),
                             ("application/x-netcdf, */*", "application/netcdf"),
                             ("application/json", "application/json"),
                             ("*/*", "application/json"),
                             ("text/csv;q=0.9, application/json", "text/csv")):
            answer = self.series(self.QUERY, headers={"Accept": accept})
            self.assertEqual(answer.headers["Content-Type"].split(";")[0], kind,
                             accept)
        answer = self.series(self.QUERY + "&format=json",
                             headers={"Accept": "text/csv"})
        self.assertEqual(answer.headers["Content-Type"], "application/json")

    def test_post_is_get(self):
        body = {"sweep": [{"over": "sunElevation", "values": [10, 50]},
                          {"over": "elevation", "first": 20, "last": 60,
                           "step": 20}],
                "optics": {"sky": {"azimuth": 80}}}
        got, posted = (x.json() for x in (
            self.series(self.QUERY),
            self.daemon.request("POST", "/v1/series", body)))
        self.assertIn("variables", posted, posted)
        self.assertEqual(got["variables"], posted["variables"])
        self.assertEqual(got["axes"], posted["axes"])
        for format in ("CSV", "NETCDF"):
            answer = self.daemon.request("POST", "/v1/series",
                                         {**body, "format": format})
            self.assertIn(format.lower(), answer.headers["Content-Type"])
        answer = self.daemon.request("POST", "/v1/series?format=csv", body)
        self.assertIn("csv", answer.headers["Content-Type"])

    def test_over_protobuf(self):
        session = Session(self.daemon.connect_unix())
        self.addCleanup(session.close)
        reply = session.ask(series={
            "sweep": [{"over": "viewZenith", "values": [1, 2, 3]}],
            "optics": {"brdf": {}}})
        names = [v.name for v in reply.series.variables]
        self.assertIn("brdf", names)
        self.assertEqual(len(reply.series.variables[0].values), 3)
        reply = session.ask(series={
            "sweep": [{"over": "viewZenith", "values": [1, 2, 3]}],
            "format": schema().NETCDF, "optics": {"brdf": {}}})
        self.assertEqual(reply.series.file[:4], b"CDF\x02")
        self.assertFalse(reply.series.variables)


class Refusals(Case):
    def test_axes(self):
        self.refused("brdf?sweep=windspeed=1,2", 400, "windspeed", "viewZenith",
                     code="NOT_FOUND")
        self.refused("brdf?sweep=viewZenith=0:80:-1", 400, "no steps of -1")
        self.refused("brdf?sweep=viewZenith=0:80:0", 400, "no steps of 0")
        self.refused("brdf?sweep=viewZenith=0:80:x", 400, "FIRST:LAST:STEP")
        self.refused("brdf?sweep=viewZenith", 400, "FIRST:LAST:STEP")
        self.refused("brdf?sweep=viewZenith=0,1;viewZenith=2,3", 400, "two axes")
        self.refused("brdf?sweep=" + ";".join(
            f"{n}=0.1,0.2" for n in ("slopeAlong", "slopeCross", "viewZenith",
                                     "sea.windSpeed", "time")), 400, "at most 4 axes")
        self.refused("spectrum?sweep=frequencies=1,2", 400, "no number",
                     code="NOT_FOUND")
        self.refused("spectrum?sweep=time=1,2", 400, "no number")
        self.refused("water?sweep=sunElevation=1,2", 400, "sunZenith")
        self.refused("water?sweep=wavelength=400,500&wavelengthLast=600", 400,
                     "wavelengthLast")
        self.refused("surface?sweep=time=0,1", 400, "point")
        self.refused("surface?sweep=sea.windSpeed=1,2&points=0,0", 400,
                     "in force")
        self.refused("clouds?sweep=a=1,2", 404, "brdf, sky, water")
        self.refused("sky?sweep=elevation=1,2&format=xls", 400,
                     "json, csv or netcdf")

    def test_values(self):
        p = self.refused("brdf?sweep=viewZenith=0:120:10", 400, "viewZenith",
                         code="OUT_OF_RANGE")
        self.assertEqual((p["minimum"], p["maximum"], p["unit"]),
                         (0, 90, "deg"))
        p = self.refused("brdf?sweep=sea.windSpeed=10,99", 400, "windSpeed",
                         code="OUT_OF_RANGE")
        self.assertEqual(p["maximum"], 30)
        self.refused("brdf?sweep=windSpeed=1,2&viewZenith=91", 400,
                     "viewZenith", code="OUT_OF_RANGE")
        self.refused("sky?sweep=elevation=0:90:0.001", 400, "10000",
                     code="OUT_OF_RANGE")
        self.refused("spectrum?sweep=sea.gamma=1:7:0.5&frequencies=200&"
                     "directions=72&format=csv", 400, "netcdf",
                     code="OUT_OF_RANGE")

    def test_a_bad_patch(self):
        self.refused("brdf?sweep=viewZenith=1,2&sea.windSpeed=99", 400,
                     "windSpeed")


class Manners(Case):
    def test_control_thread_does_not_wait(self):
        """A big series of each kind and form: nothing of it occupies the
        control thread for a millisecond by its own work."""
        def busy():
            m = self.daemon.metrics()
            ns = self.daemon.control_cpu()
            return m, ns
        # By the ephemeris: Sun, Moon and night of a moment take milliseconds.
        self.daemon.patch({"sky": {"sunElevation": None, "sunAzimuth": None}})
        self.addCleanup(self.daemon.patch, {"sky": {"sunElevation": 40,
                                                    "sunAzimuth": 130}})
        before, _ = busy()
        for path in ("spectrum?sweep=sea.gamma=1:4:0.5&frequencies=200&"
                     "directions=72", "surface?sweep=time=0:400:1&points="
                     + ";".join(f"{i},0" for i in range(100)),
                     "brdf?sweep=viewZenith=0:89:2;sunElevation=1:89:22",
                     "sky?sweep=elevation=0:88:8;time=0:3600:120"):
            for format in ("json", "csv", "netcdf"):
                self.series(f"{path}&format={format}")
        after, _ = busy()
        counts = {k: after.get(k, 0) - before.get(k, 0) for k in after
                  if "series" in k}
        self.assertTrue(counts, "the metrics do not know series")
        self.assertGreater(sum(counts.values()), 1000)
        stalls = sum(n for k, n in counts.items() if "stall" in k)
        # A turn that the machine takes away counts too, so not none: of some
        # thousands, those that the work itself made would be all.
        if not SANITIZED:
            self.assertLess(stalls, 0.02 * sum(counts.values()), counts)
        spent = [float(m) for m in re.findall(
            r'"series" \((\S+) ms of processor', self.daemon.log())]
        self.assertLess(max(spent, default=0), 50 if SANITIZED else 5)

    def test_pictures_and_edits_go_on_meanwhile(self):
        answers = []
        t = threading.Thread(target=lambda: answers.append(self.daemon.get(
            "/v1/series/water?sweep=wavelength=400:700:1;chlorophyll=0.1,1,5")))
        t.start()
        edits = 0
        while t.is_alive():
            answer = self.daemon.patch({"entities": {"1": {
                "heading": edits % 360}}})
            self.assertEqual(answer.status, 200)
            edits += 1
        t.join()
        self.assertEqual(answers[0].status, 200, answers[0])
        self.assertGreater(edits, 5)

    def test_who_goes_away_is_not_worked_for(self):
        s = self.daemon.connect_http()
        s.sendall(b"GET /v1/series/water?sweep=wavelength=400:700:0.5;"
                  b"chlorophyll=0.1,0.2,0.5,1,2,5,7,9 HTTP/1.1\r\n"
                  b"Host: localhost\r\n\r\n")
        until("it is under way", lambda: self.under_way() > 0)
        s.close()
        until("it has ended", lambda: self.under_way() == 0)

    def under_way(self):
        return self.daemon.metrics()["pelagos_series_under_way"]


class CommandLine(Case):
    def ctl(self, *words, status=0):
        done = subprocess.run(
            [os.path.join(BIN, "pelagosctl"), "--server",
             "unix:" + self.daemon.unix_path, "--timeout", "60", *words],
            capture_output=True)
        self.assertEqual(done.returncode, status, done.stderr.decode())
        return done.stdout if status == 0 else done.stderr.decode()

    def test_tables_and_files(self):
        rows = self.ctl("optics", "brdf", "--wind", "7", "--sweep",
                        "viewZenith=0:60:20", "--sweep", "sunElevation=20,50")
        lines = [l for l in rows.decode().splitlines() if l[0] != "#"]
        self.assertEqual(len(lines), 1 + 4 * 2)
        path = os.path.join(self.folder, "water.nc")
        self.ctl("optics", "water", "--chlorophyll", "0.5", "--bottom", "sand",
                 "--depth", "9", "--sweep", "wavelength=400:700:100", "-o", path)
        with xarray.open_dataset(path) as d:
            here = json.loads(self.ctl(
                "optics", "water", "--chlorophyll", "0.5", "--bottom", "sand",
                "--depth", "9", "--wavelengths", "400:700:100"))
            np.testing.assert_allclose(d.remoteSensingReflectance.values,
                                       here["remoteSensingReflectance"],
                                       rtol=1e-5)  # as it is printed
        s = json.loads(self.ctl("spectrum", "--sweep", "windSpeed=4:8:2",
                                "--format", "json"))
        self.assertEqual(s["axes"][0]["values"], [4, 6, 8])
        one = json.loads(self.ctl("optics", "sky", "--elevation", "30",
                                  "--format", "json"))
        self.assertNotIn("axes", one["variables"][0])
        s = json.loads(self.ctl("--json", "surface", "0", "0", "9", "9",
                                "--sweep", "time=0:3:1"))
        self.assertEqual([len(a["values"]) for a in s["axes"]], [4, 2])

    def test_refusals(self):
        self.assertIn("viewZenith", self.ctl(
            "optics", "brdf", "--sweep", "viewzenit=1,2", status=4))
        self.assertIn("FIRST:LAST:STEP", self.ctl(
            "optics", "sky", "--sweep", "elevation", status=2))
        self.assertIn("csv, json, netcdf", self.ctl(
            "spectrum", "--sweep", "windSpeed=1,2", "--format", "xls", status=2))
        self.assertIn(".nc", self.ctl(
            "spectrum", "--sweep", "windSpeed=1,2", "-o", "a.xls", status=2))


if __name__ == "__main__":
    unittest.main()
