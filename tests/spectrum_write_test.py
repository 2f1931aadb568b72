#!/usr/bin/python3
"""Spectra for wave models (pelagosctl spectrum --format, GET /v1/spectrum):
WAVEWATCH III's text and NetCDF, SWAN's file, NDBC's five. Each is read by numpy
after the published form (of WAVEWATCH III's manual, ww3_outp and ww3_ounp; SWAN's
user manual, appendix D; NDBC's "Measurement Descriptions"), by xarray and ncdump,
and by our own reader: height, peak, directions and spread are those of the sea
within what the form prints."""
import datetime
import io
import json
import math
import os
import re
import subprocess
import sys
import tarfile
import tempfile
import unittest

import numpy as np
import xarray

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import BIN, Daemon

SEAS = {
    "wind": {"spectrum": "PIERSON_MOSKOWITZ", "windSpeed": 9,
             "windDirection": 240},
    "storm": {"spectrum": "JONSWAP", "windSpeed": 18, "windDirection": 30,
              "fetch": 300000},
    "mixed": {"spectrum": "TMA", "windSpeed": 8, "windDirection": 300,
              "depth": 15, "swell": [[1.5, 12, 200]]},
}
PLACE = (41.25, -70.5)
UTC = datetime.datetime(2026, 2, 3, 4, 5, 6, tzinfo=datetime.timezone.utc)


# --- readers of others' forms: f [Hz], directions from [deg], E [m2/Hz/rad] ---

def read_ww3(text):
    """Header: 'WAVEWATCH III SPECTRA' NK NTH NPT 'GRID'; frequencies; directions
    that waves go to, rad clockwise from north; date; 'POINT' lat lon d U dir C
    dir; E(f, th), frequencies first."""
    head, rest = text.split("\n", 1)
    kind, nf, nd, points, grid = re.fullmatch(
        r"'(.{21})' *(\d+) +(\d+) +(\d+) '(.{30})'", head).groups()
    assert kind == "WAVEWATCH III SPECTRA" and int(points) == 1
    nf, nd = int(nf), int(nd)
    values = re.findall(r"'[^']*'|\S+", rest)
    f = np.array(values[:nf], float)
    to = np.array(values[nf:nf + nd], float)
    at = nf + nd
    when = datetime.datetime.strptime(" ".join(values[at:at + 2]),
                                      "%Y%m%d %H%M%S")
    point = [values[at + 2].strip("'").strip()] + [
        float(v) for v in values[at + 3:at + 10]]
    e = np.array(values[at + 10:], float).reshape(nd, nf).T
    return f, np.degrees(to) + 180, e, when, point


def read_swan(text):
    lines = iter(text.split("\n"))
    assert next(lines).startswith("SWAN   1")
    out = {}
    for line in lines:
        word = line.split()[0] if line.strip() else ""
        if word == "LONLAT":
            n = int(next(lines).split()[0])
            out["place"] = [[float(v) for v in next(lines).split()]
                            for _ in range(n)]
        elif word in ("AFREQ", "NDIR"):
            n = int(next(lines).split()[0])
            out[word] = np.array([float(next(lines)) for _ in range(n)])
        elif word == "QUANT":
            assert int(next(lines).split()[0]) == 1
            assert next(lines).split()[0] == "VaDens"
            assert next(lines).split()[0] == "m2/Hz/degr"
            out["exception"] = float(next(lines).split()[0])
        elif re.fullmatch(r"\d{8}\.\d{6}", word):
            out["when"] = datetime.datetime.strptime(word, "%Y%m%d.%H%M%S")
        elif word == "FACTOR":
            factor = float(next(lines))
            e = np.array([[int(v) for v in next(lines).split()]
                          for _ in out["AFREQ"]]) * factor
            assert e.shape == (len(out["AFREQ"]), len(out["NDIR"]))
            out["e"] = e * math.degrees(1)
    return (out["AFREQ"], out["NDIR"], out["e"], out["when"],
            ["", out["place"][0][1], out["place"][0][0]])


def read_ndbc(files):
    """f, and S, alpha1, alpha2, r1, r2 by frequency."""
    out = []
    for ending in ("data_spec", "swdir", "swdir2", "swr1", "swr2"):
        head, row = files[ending].strip().split("\n")
        assert head.startswith("#YY  MM DD hh mm ")
        words = row.split()
        when = datetime.datetime(*map(int, words[:5]))
        pairs = re.findall(r"(\S+) \((\S+)\)", row)
        out.append(np.array([float(v) for v, _ in pairs]))
        f = np.array([float(v) for _, v in pairs])
    return f, out, when


def numbers(f, come_from, e):
    """Hs, Tp, mean direction, and at the peak r1's spread [deg]."""
    width = 2 * math.pi / len(come_from)
    s = e.sum(1) * width
    z = (e * np.exp(1j * np.radians(come_from))).sum(1) * width
    peak = s.argmax()
    mean = np.trapz(z, f)
    return (4 * math.sqrt(np.trapz(s, f)), 1 / f[peak],
            np.degrees(np.angle(mean)) % 360,
            np.degrees(np.angle(z[peak])) % 360,
            np.degrees(math.sqrt(2 - 2 * abs(z[peak]) / s[peak])))


class Written(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name
        cls.daemon = Daemon(f"--spectra={cls.folder}", unix=True)
        cls.addClassCleanup(cls.daemon.stop)
        cls.daemon.patch({"clock": {
            "mode": "STEPPED", "time": 0, "utc": UTC.strftime("%Y-%m-%dT%H:%M:%SZ")},
            "origin": dict(zip(("latitude", "longitude"), PLACE)),
            "sea": {"synthesiser": "TROCHOIDS"}})

    def set_sea(self, name):
        answer = self.daemon.patch({"sea": None})
        answer = self.daemon.patch({"sea": {"synthesiser": "TROCHOIDS",
                                            **SEAS[name]}})
        self.assertEqual(answer.status, 200, answer)
        return self.spectrum()

    def spectrum(self, **query):
        answer = self.daemon.request("POST", "/v1/spectrum", query)
        self.assertEqual(answer.status, 200, answer)
        return answer.json()

    def file(self, form, more=""):
        answer = self.daemon.get(f"/v1/spectrum?format={form}{more}")
        self.assertEqual(answer.status, 200, answer)
        return answer

    def at(self, hz, patch=None):
        """What pelagosd says of the sea at a frequency."""
        omega = 2 * math.pi * hz
        query = {"frequencies": 1, "lowest": omega, "highest": omega + 1}
        if patch:
            query["patch"] = patch
        return self.spectrum(**query)["rows"][0]

    def band(self, f, hz, sector):
        """Mean direction and spread of a band of the file, from many
        frequencies within it, as sectors of so many degrees would show them."""
        i = abs(f - hz).argmin()
        low, high = np.pi * (f[i - 1] + f[i]), np.pi * (f[i] + f[i + 1])
        rows = self.spectrum(frequencies=41, lowest=low, highest=high)["rows"]
        omega, s, a, w = (np.array([r[k] for r in rows]) for k in (
            "omega", "density", "direction", "spread"))
        r1 = 1 - np.radians(w) ** 2 / 2
        z = np.trapz(s * r1 * np.exp(1j * np.radians(a)), omega)
        r1 = abs(z) / np.trapz(s, omega) * np.sinc(sector / 360)
        return (np.degrees(np.angle(z)) % 360,
                np.degrees(math.sqrt(2 - 2 * r1)))

    def agrees(self, f, got, said, hs=1e-3, degrees=0.15, width=0.3):
        """A file's numbers with those of the sea that it was written from."""
        height, period, mean, at_peak, spread = got
        # Beyond 1.6 Hz are 0.04 % of the height.
        self.assertAlmostEqual(height / said["spectrum"]["significantHeight"],
                               1, delta=hs + 6e-4)
        # Frequencies are 7 % apart.
        self.assertAlmostEqual(period / said["peakPeriod"], 1, delta=0.045)
        self.assertLess(abs((mean - said["meanDirection"] + 180) % 360 - 180),
                        degrees + 0.1)
        direction, wanted = self.band(f, 1 / period, 10)
        self.assertLess(abs((at_peak - direction + 180) % 360 - 180), degrees)
        self.assertAlmostEqual(spread, wanted, delta=width)

    def read_back(self, measured, got, hs=1.5e-3, spread=0.3):
        """Our own reader's sea with what the file says by numpy."""
        patch = {"remove": ["sea.swell"], "state": {"sea": {
            "spectrum": "MEASURED", "measured": measured}}}
        said = self.spectrum(patch=patch)
        height, period, mean, at_peak, width = got
        self.assertAlmostEqual(said["spectrum"]["significantHeight"] / height,
                               1, delta=hs)
        self.assertAlmostEqual(said["peakPeriod"] / period, 1, delta=0.02)
        self.assertLess(abs((said["meanDirection"] - mean + 180) % 360 - 180),
                        0.5)
        row = self.at(1 / period, patch)
        self.assertLess(abs((row["direction"] - at_peak + 180) % 360 - 180), 1)
        self.assertAlmostEqual(row["spread"], width, delta=spread + 0.5)

    def keep(self, name, data):
        with open(os.path.join(self.folder, name), "wb") as f:
            f.write(data)

    def test_ww3_text(self):
        for sea in SEAS:
            said = self.set_sea(sea)
            answer = self.file("ww3")
            self.assertIn("text/plain", answer.headers["Content-Type"])
            f, come_from, e, when, point = read_ww3(answer.body.decode())
            self.assertEqual((len(f), len(come_from)), (60, 36))
            got = numbers(f, come_from, e)
            self.agrees(f, got, said)
            self.assertEqual(when, UTC.replace(tzinfo=None))
            self.assertEqual(point[:3], ["pelagos", *PLACE])
            self.assertEqual(point[3], SEAS[sea].get("depth", 9999))
            self.assertEqual(point[4:6], [SEAS[sea]["windSpeed"],
                                          SEAS[sea]["windDirection"]])
            for line in answer.body.decode().split("\n"):
                self.assertLess(len(line), 81)
            self.keep("ww3.spec", answer.body)
            self.read_back("ww3.spec", got)

    def test_swan(self):
        for sea in SEAS:
            said = self.set_sea(sea)
            answer = self.file("swan")
            f, come_from, e, when, point = read_swan(answer.body.decode())
            got = numbers(f, come_from, e)
            self.agrees(f, got, said)
            self.assertEqual(when, UTC.replace(tzinfo=None))
            self.assertEqual(tuple(point[1:]), PLACE)
            self.assertIn('pelagosd', answer.body.decode().split("\n")[1])
            self.keep("swan.spc", answer.body)
            self.read_back("swan.spc", got)

    def test_ndbc(self):
        for sea in SEAS:
            said = self.set_sea(sea)
            answer = self.file("ndbc")
            self.assertEqual(answer.headers["Content-Type"],
                             "application/x-tar")
            files = {}
            with tarfile.open(fileobj=io.BytesIO(answer.body)) as tar:
                for member in tar.getmembers():
                    self.assertTrue(member.name.startswith("pelagos."))
                    data = tar.extractfile(member).read()
                    files[member.name.split(".")[1]] = data.decode()
                    self.keep(member.name, data)
            f, (s, alpha1, alpha2, r1, r2), when = read_ndbc(files)
            self.assertEqual(when, UTC.replace(tzinfo=None, second=0))
            known = s > 0
            self.assertTrue(np.all(alpha1[~known] == 999))
            self.assertTrue(np.all(r1[known] <= 1))
            # As NDBC says: D = (½ + r1 cos(A − α1) + r2 cos 2(A − α2)) / π.
            peak = s.argmax()
            mean = np.trapz(np.where(known, s * r1 * np.exp(
                1j * np.radians(alpha1)), 0), f)
            got = (4 * math.sqrt(np.trapz(s, f)), 1 / f[peak],
                   np.degrees(np.angle(mean)) % 360, alpha1[peak],
                   np.degrees(math.sqrt(2 - 2 * r1[peak])))
            # 0.0005 m2/Hz over 1.6 Hz; r1 of two digits.
            self.agrees(f, got, said, hs=0.0004 / (said["spectrum"][
                "significantHeight"] / 4) ** 2, degrees=0.3,
                        width=math.degrees(0.005 / math.radians(got[4])) + 0.2)
            self.read_back("pelagos", got, hs=3e-3, spread=0.6)
            # The second moment is that of the density over directions.
            _, come_from, e, _, _ = read_swan(self.file("swan").body.decode())
            fs = read_swan(self.file("swan").body.decode())[0]
            k = abs(fs - f[peak]).argmin()
            z = (e[k] * np.exp(2j * np.radians(come_from))).sum() / e[k].sum()
            self.assertAlmostEqual(r2[peak], abs(z), delta=0.02)
            self.assertLess(abs((alpha2[peak] - np.degrees(np.angle(z)) / 2
                                 + 90) % 180 - 90), 1.5)

    def test_ww3_netcdf(self):
        for sea in SEAS:
            said = self.set_sea(sea)
            answer = self.file("netcdf")
            self.assertEqual(answer.headers["Content-Type"],
                             "application/netcdf")
            self.keep("ww3.nc", answer.body)
            path = os.path.join(self.folder, "ww3.nc")
            with xarray.open_dataset(path) as d:
                self.assertEqual(d.efth.dims, ("time", "station", "frequency",
                                               "direction"))
                self.assertEqual(d.efth.attrs["units"], "m2 s rad-1")
                self.assertEqual(
                    d.direction.attrs["standard_name"],
                    "sea_surface_wave_to_direction")
                # WAVEWATCH III counts days: to the second.
                self.assertLess(abs(d.time.values[0] - np.datetime64(
                    UTC.replace(tzinfo=None))), np.timedelta64(2, "s"))
                self.assertEqual(b"".join(np.atleast_1d(
                    d.station_name.values[0])).decode().strip()
                    if d.station_name.ndim > 1 else
                    d.station_name.values[0].decode().strip(), "pelagos")
                self.assertAlmostEqual(float(d.latitude[0, 0]), PLACE[0])
                self.assertAlmostEqual(float(d.longitude[0, 0]), PLACE[1])
                f = d.frequency.values.astype(float)
                got = numbers(f, d.direction.values + 180,
                              d.efth.values[0, 0].astype(float))
                self.assertTrue(np.all(d.frequency1 <= d.frequency))
                self.assertTrue(np.all(d.frequency2 >= d.frequency))
                # Their own sum, by widths of bands.
                m0 = float((d.efth[0, 0].sum("direction") * 2 * math.pi / 36 *
                            (d.frequency2 - d.frequency1)).sum())
                self.assertAlmostEqual(4 * math.sqrt(m0) / got[0], 1, delta=1e-3)
            self.agrees(f, got, said)
            self.read_back("ww3.nc#pelagos", got)
        out = subprocess.run(["ncdump", "-h", path], text=True, check=True,
                             capture_output=True).stdout
        self.assertIn("float efth(time, station, frequency, direction) ;", out)
        self.assertIn("PIERSON_MOSKOWITZ" if sea == "wind" else "TMA", out)

    def test_numbers_that_are_asked_for(self):
        self.set_sea("wind")
        f, come_from, e, _, _ = read_swan(self.file(
            "swan", "&frequencies=40&directions=24&lowest=0.4&highest=6"
        ).body.decode())
        self.assertEqual((len(f), len(come_from)), (40, 24))
        self.assertAlmostEqual(f[0], 0.4 / 2 / math.pi, places=5)
        self.assertAlmostEqual(f[-1], 6 / 2 / math.pi, places=4)
        # An odd number has no direction opposite another.
        g, other, odd, _, _ = read_ww3(self.file("ww3", "&directions=25")
                                       .body.decode())
        a, b = numbers(f, come_from, e), numbers(g, other, odd)
        self.assertAlmostEqual(a[0] / b[0], 1, delta=5e-3)
        self.assertLess(abs(a[2] - b[2]), 0.5)
        # Of a sea that is not in force.
        calm = read_swan(self.file("swan", "&sea.windSpeed=4").body.decode())
        self.assertLess(numbers(*calm[:3])[0], 0.3 * a[0])

    def test_flat(self):
        for form in ("ww3", "swan", "ndbc", "netcdf"):
            self.assertEqual(self.file(form, "&sea.windSpeed=0").status, 200)
        self.assertIn("\nZERO\n", self.file(
            "swan", "&sea.windSpeed=0").body.decode())

    def test_refusals(self):
        for query, said in (("format=wam", "ww3, swan, ndbc"),
                            ("format=ww3&frequencies=2", "3 to 128"),
                            ("format=ww3&frequencies=129", "3 to 128"),
                            ("format=swan&directions=2", "3 directions"),
                            ("format=ndbc&highest=50", "12.57"),
                            ("format=ww3&lowest=5&highest=5.1", "fifth"),
                            ("frequences=3", "no such parameter")):
            answer = self.daemon.get("/v1/spectrum?" + query)
            self.assertEqual(answer.status, 400, query)
            self.assertIn(said, answer.json()["detail"], query)
        answer = self.daemon.request("POST", "/v1/series", {
            "spectrum": {"format": "WW3"}})
        self.assertEqual(answer.status, 400)

    def ctl(self, *words, status=0):
        done = subprocess.run(
            [os.path.join(BIN, "pelagosctl"), "--server",
             "unix:" + self.daemon.unix_path, *words], capture_output=True,
            text=True)
        self.assertEqual(done.returncode, status, done.stderr)
        return done.stdout if status == 0 else done.stderr

    def test_command_line(self):
        self.set_sea("storm")
        for form in ("ww3", "swan"):
            self.assertEqual(self.ctl("spectrum", "--format", form),
                             self.file(form).body.decode())
        path = os.path.join(self.folder, "buoy")
        self.ctl("spectrum", "--format", "ndbc", "-o", path)
        for ending in ("data_spec", "swdir", "swdir2", "swr1", "swr2"):
            self.assertTrue(os.path.exists(f"{path}.{ending}"))
        path = os.path.join(self.folder, "of_ctl.nc")
        self.ctl("spectrum", "--format", "netcdf", "-o", path,
                 "sea.windSpeed=5", "--frequencies", "30")
        with xarray.open_dataset(path) as d:
            self.assertEqual(d.efth.shape, (1, 1, 30, 36))
            self.assertEqual(float(d.wnd[0, 0]), 5)
        self.assertIn("ww3, swan", self.ctl("spectrum", "--format", "wam",
                                            status=2))
        self.assertIn("--output", self.ctl("spectrum", "--format", "ndbc",
                                           status=2))


if __name__ == "__main__":
    unittest.main()
