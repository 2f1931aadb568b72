#!/usr/bin/python3
"""HTTP end to end: every endpoint, every error and the state unchanged after
it."""
import contextlib
import math
import os
import re
import struct
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from http_case import HttpCase
from pelagos_daemon import ROOT, Daemon

MERGE = {"Content-Type": "application/merge-patch+json"}


class Endpoints(HttpCase):
    def test_health(self):
        answer = self.daemon.get("/healthz")
        self.assertEqual(answer.status, 200)
        self.assertEqual(answer.json()["status"], "ok")
        self.assertIn("llvmpipe", answer.json()["device"])
        self.assertEqual(self.daemon.request("HEAD", "/healthz").body, b"")

    def test_metrics_are_prometheus_text(self):
        """What promtool's linter asks for, and no series twice."""
        answer = self.daemon.get("/metrics")
        self.assertEqual(answer.headers["Content-Type"],
                         "text/plain; version=0.0.4; charset=utf-8")
        family, kind, seen, series, helps = None, None, set(), set(), set()
        sample = re.compile(r'([a-z_0-9]+)(\{([a-z_]+="[^"\\\n]*",?)*\})? '
                            r"(-?[0-9.]+(e[+-]?[0-9]+)?|NaN|[+-]Inf)$")
        for line in answer.body.decode().splitlines():
            if line.startswith("# HELP "):
                family = line.split()[2]
                self.assertNotIn(family, seen, "a family in two places")
                seen.add(family)
                self.assertRegex(family, "^(pelagos|process)_[a-z0-9_]+$")
                words = line.split(" ", 3)[3]
                self.assertNotIn(words, helps, "two families say the same")
                self.assertRegex(words, r"^[A-Z0-9].*[.a-z0-9]$")
                helps.add(words)
                for unit in ("_ms", "_milliseconds", "_kb", "_percent"):
                    self.assertNotIn(unit, family, "not a base unit")
            elif line.startswith("# TYPE "):
                self.assertEqual(line.split()[2], family)
                kind = line.split()[3]
                self.assertIn(kind, ("counter", "gauge", "summary"))
                self.assertEqual(kind == "counter", family.endswith("_total"))
            else:
                match = sample.match(line)
                self.assertTrue(match, line)
                self.assertEqual(match.group(1), family, line)
                self.assertNotIn(line.rsplit(" ", 1)[0], series)
                series.add(line.rsplit(" ", 1)[0])
                self.assertEqual("quantile=" in line, kind == "summary", line)
                if kind == "counter":
                    self.assertGreaterEqual(float(match.group(4)), 0, line)
        for name in ("pelagos_frames_drawn_total", "pelagos_revision",
                     "process_resident_memory_bytes"):
            self.assertIn(name, seen)

    def test_state_and_patch(self):
        answer = self.daemon.patch({"sea": {"windSpeed": 12}}, headers=MERGE)
        self.assertEqual(answer.status, 200, answer)
        self.assertEqual(answer.json()["sea"]["windSpeed"], 12)
        tag = answer.headers["ETag"]
        self.assertEqual(tag, f'W/"{answer.json()["revision"]}"')
        self.assertEqual(self.daemon.get("/v1/state").headers["ETag"], tag)
        self.assertEqual(answer.headers["Cache-Control"], "no-store")
        answer = self.daemon.patch({"sea": {"windSpeed": None}})
        self.assertEqual(answer.json()["sea"]["windSpeed"], 8)

    def test_if_match(self):
        tag = self.daemon.get("/v1/state").headers["ETag"]
        change = {"sea": {"gamma": 2}}
        self.refused(self.daemon.patch(change, headers={"If-Match": '"0x"'}),
                     412, code="CONFLICT")
        self.refused(self.daemon.patch(change, headers={
            "If-Match": f'W/"9{tag[3:]}'}), 412)
        answer = self.daemon.patch(
            change, headers={"If-Match": f'"a", {tag}'})
        self.assertEqual(answer.status, 200)
        self.assertEqual(self.daemon.patch(
            change, headers={"If-Match": tag}).status, 412)
        self.assertEqual(self.daemon.patch(
            change, headers={"If-Match": "*"}).status, 200)

    def test_one_field(self):
        answer = self.daemon.get("/v1/state/sea.windSpeed")
        self.assertEqual(answer.json(), {
            "path": "sea.windSpeed", "value": 8, "unit": "m/s",
            "minimum": 0, "maximum": 30})
        for path, value in (("sea/spectrum", "PIERSON_MOSKOWITZ"),
                            ("views.bridge.width", 320),
                            ("sky/sunElevation", None),
                            ("sea/swell", [])):
            answer = self.daemon.get("/v1/state/" + path)
            self.assertEqual(answer.json()["value"], value, path)
        sky = self.daemon.get("/v1/state/sky").json()["value"]
        self.assertEqual((sky["visibility"], sky["cloudCover"]), (40000, 0))
        self.assertNotIn("sunElevation", sky)
        self.refused(self.daemon.get("/v1/state/sea.nothing"), 404,
                     code="NOT_FOUND", path="sea.nothing")

    def test_fields_and_schema(self):
        fields = {f["path"]: f for f in
                  self.daemon.get("/v1/fields").json()["fields"]}
        self.assertEqual(fields["sea.windSpeed"]["maximum"], 30)
        self.assertEqual(fields["sea.gamma"]["spectra"], ["JONSWAP", "TMA"])
        self.assertEqual(fields["sea.height"]["spectra"], ["BRETSCHNEIDER"])
        self.assertNotIn("spectra", fields["sea.level"])
        with open(os.path.join(ROOT, "proto", "pelagos.proto"), "rb") as f:
            self.assertEqual(self.daemon.get("/v1/schema").body, f.read())

    def test_views(self):
        answer = self.daemon.request("PUT", "/v1/views/port-side",
                                     {"entity": 1, "yaw": -90, "width": 64,
                                      "height": 48})
        self.assertEqual(answer.status, 201, answer)
        self.assertEqual(answer.headers["Location"], "/v1/views/port-side")
        self.assertEqual(answer.json()["yaw"], -90)
        answer = self.daemon.request("PUT", "/v1/views/port-side",
                                     {"name": "port-side", "up": 3})
        self.assertEqual(answer.status, 200)
        view = self.daemon.get("/v1/views/port-side").json()
        self.assertEqual((view["yaw"], view["up"], view["width"]),
                         (0, 3, 1280), "PUT replaces")
        self.assertNotIn("entity", view)
        names = [v["name"] for v in
                 self.daemon.get("/v1/views").json()["views"]]
        self.assertEqual(names, ["bridge", "port-side"])
        answer = self.daemon.request("DELETE", "/v1/views/port-side")
        self.assertEqual((answer.status, answer.body), (204, b""))
        answer = self.daemon.request("DELETE", "/v1/views/port-side")
        self.assertEqual(answer.status, 404)
        self.assertEqual(answer.json()["path"], "views.port-side")
        self.daemon.request("DELETE", "/v1/views/bridge")
        self.assertEqual(self.daemon.get("/v1/views").json(), {"views": []})

    def test_pictures(self):
        for name, start in (("frame.jpg", b"\xff\xd8\xff"),
                            ("frame.png", b"\x89PNG\r\n"),
                            ("frame.exr", b"\x76\x2f\x31\x01")):
            answer = self.daemon.get(f"/v1/views/bridge/{name}")
            self.assertEqual(answer.status, 200, answer)
            self.assertTrue(answer.body.startswith(start), name)
            self.assertEqual(answer.headers["X-Pelagos-Revision"],
                             self.before["revision"])
            self.assertGreater(int(answer.headers["X-Pelagos-Frame"]), 0)
        self.assertEqual(answer.headers["Content-Type"], "image/x-exr")
        answer = self.daemon.get("/v1/views/bridge/frame.png?width=64&height=36"
                                 "&time=12.5")
        self.assertEqual(struct.unpack(">II", answer.body[16:24]), (64, 36))
        self.assertEqual(float(answer.headers["X-Pelagos-Time"]), 12.5)
        again = self.daemon.get("/v1/views/bridge/frame.png?width=64&height=36"
                                "&time=12.5")
        self.assertEqual(answer.body, again.body, "same moment, same bytes")
        small = self.daemon.get("/v1/views/bridge/frame.jpg?quality=5")
        large = self.daemon.get("/v1/views/bridge/frame.jpg?quality=100")
        self.assertLess(len(small.body), len(large.body))
        layers = self.daemon.get("/v1/views/bridge/frame.exr?float=1&width=32"
                                 "&height=16&layers=radiance,depth,normal")
        for channel in (b"depth.Z\0", b"normal.X\0", b"R\0"):
            self.assertIn(channel, layers.body)
        for path in ("/v1/views/bridge/frame.jpeg", "/v1/frames.jpeg"):
            other = self.daemon.get(path + "?width=32&height=16")
            self.assertEqual(other.status, 200, other)
            self.assertIn(b"\xff\xd8\xff", other.body)
        self.assertEqual(
            self.daemon.get("/v1/views/bridge/frame.JPEG").status, 404)

    def test_picture_refusals(self):
        base = "/v1/views/bridge/frame.jpg?"
        for query, code, path in (
                ("width=0", "OUT_OF_RANGE", "width"),
                ("width=99999999999", "OUT_OF_RANGE", "width"),
                ("width=12.5", "INVALID", "width"),
                ("height=-1", "OUT_OF_RANGE", "height"),
                ("time=nan", "INVALID", "time"),
                ("time=inf", "INVALID", "time"),
                ("time=0x10", "INVALID", "time"),
                ("time=-1", "OUT_OF_RANGE", "time"),
                ("quality=101", "OUT_OF_RANGE", "quality"),
                ("layers=gold", "INVALID", "layers"),
                ("float=perhaps", "INVALID", "float"),
                ("qualty=3", "NOT_FOUND", "qualty")):
            self.refused(self.daemon.get(base + query), 400, code=code,
                         path=path)
        self.refused(self.daemon.get(base + "width=17&width=18"), 400)
        self.refused(self.daemon.get("/v1/views/none/frame.jpg"), 404,
                     path="views.none")
        self.refused(self.daemon.get("/v1/views/bridge/frame.gif"), 404)
        self.refused(self.daemon.get("/v1/views/bridge/mjpeg?fps=0"), 400,
                     code="OUT_OF_RANGE", path="fps", maximum=240)

    def test_spectrum(self):
        now = self.daemon.request("GET", "/v1/spectrum").json()
        self.assertGreater(now["drawn"]["significantHeight"], 0)
        self.assertAlmostEqual(now["drawn"]["significantHeight"],
                               now["spectrum"]["significantHeight"], 2)
        before = self.daemon.request("GET", "/v1/state").json()["sea"]
        other = self.daemon.request("POST", "/v1/spectrum", {
            "patch": {"state": {"sea": {"windSpeed": 20}}},
            "wavelength": 1, "frequencies": 5, "directions": 8}).json()
        self.assertGreater(other["drawn"]["significantHeight"],
                           now["drawn"]["significantHeight"])
        self.assertEqual([len(row["directional"]) for row in other["rows"]],
                         [8] * 5)
        self.assertEqual(
            self.daemon.request("GET", "/v1/state").json()["sea"], before)
        self.refused(self.daemon.request(
            "POST", "/v1/spectrum", {"frequencies": 201}), 400,
            path="frequencies", maximum=200)
        self.refused(self.daemon.request("POST", "/v1/spectrum", {
            "patch": {"state": {"sea": {"windSpeed": 31}}}}), 400,
            path="sea.windSpeed", maximum=30)

    def test_optics(self):
        reference = self.daemon.get(
            "/v1/optics/brdf?sky.sunElevation=30&viewZenith=70"
            "&sea.windSpeed=11").json()
        drawn = self.daemon.get(
            "/v1/optics/brdf?sky.sunElevation=30&viewZenith=70"
            "&sea.windSpeed=11&from=GPU").json()
        self.assertAlmostEqual(reference["sunElevation"], 30, 6)
        self.assertIn("llvmpipe", drawn["device"])
        for name in ("lambdaView", "shadowing", "meanFresnel"):
            self.assertAlmostEqual(reference["brdf"][name],
                                   drawn["brdf"][name], 4)
        # Wider slopes, the same view: more of the Sun from far aside.
        calm = self.daemon.get("/v1/optics/brdf?slopeAlong=0.01"
                               "&slopeCross=0.01").json()["brdf"]
        self.assertEqual(calm["slopeAlong"], 0.01)
        sky = [self.daemon.request("POST", "/v1/optics", {
            "sky": {"elevation": 20, "azimuth": 90}, "from": source,
            "patch": {"state": {"sky": {"sunElevation": 40}}},
        }).json()["sky"] for source in ("REFERENCE", "GPU")]
        for a, b in zip(sky[0]["radiance"], sky[1]["radiance"]):
            self.assertLess(abs(a / b - 1), 0.04)
        self.refused(self.daemon.get("/v1/optics/brdf?viewZenith=91"), 400,
                     path="brdf.viewZenith", maximum=90)
        self.refused(self.daemon.get("/v1/optics/sky?viewZenith=9"), 400,
                     code="NOT_FOUND", path="viewZenith")
        self.refused(self.daemon.get("/v1/optics/sky?sky.visibility=1"), 400,
                     path="sky.visibility", minimum=200)
        self.refused(self.daemon.get("/v1/optics/sky?elevation=nan"), 400,
                     code="INVALID", path="elevation")
        self.refused(self.daemon.get("/v1/optics/patch"), 404)
        self.refused(self.daemon.get("/v1/optics/brdf?from=MONTECARLO"), 400,
                     path="from")
        self.refused(self.daemon.get("/v1/optics/water?sunZenith=91"), 400,
                     path="water.sunZenith", maximum=90)
        where = ("sunZenith=40&viewZenith=30&azimuth=70&water.jerlov=IA"
                 "&water.depth=8&water.bottom=SAND")
        drawn, reference, followed = [
            self.daemon.get("/v1/optics/water?" + where + "&from=" + f
                            ).json()["water"]
            for f in ("GPU", "REFERENCE", "MONTECARLO")]
        raman = reference["raman"]
        self.assertGreater(min(raman), 0)
        for name in "single", "second", "higher", "bottom", "total":
            for i in range(3):
                # The maps hold 1/1000 of their maximum; Raman's light is in
                # their higher orders.
                wanted = reference[name][i] + (name == "higher") * raman[i]
                self.assertAlmostEqual(drawn[name][i] / max(reference["total"]),
                                       wanted / max(reference["total"]), 3)
        for i in range(3):
            self.assertLess(abs(followed["total"][i] + raman[i]
                                - reference["total"][i]),
                            5 * followed["totalError"][i])
        plain = self.daemon.get("/v1/optics/water?" + where
                                + "&water.raman=false").json()["water"]
        self.assertEqual(plain["raman"], [0, 0, 0])
        for i in range(3):
            self.assertAlmostEqual(plain["total"][i] + raman[i],
                                   reference["total"][i], 12)
        two = self.daemon.get("/v1/optics/water?" + where
                              + "&water.orders=TWO").json()["water"]
        self.assertEqual(two["higher"], [0, 0, 0])
        self.assertEqual(two["single"], reference["single"])
        self.wavelengths()
        self.refused(self.daemon.request("POST", "/v1/optics", {}), 400)

    def wavelengths(self):
        water = ("/v1/optics/water?water.chlorophyll=0.5&water.cdom=0.1"
                 "&water.minerals=1&water.backscatterRatio=0.012")
        light = self.daemon.get(water + "&wavelength=400&wavelengthLast=700"
                                "&wavelengthStep=50").json()["water"]
        self.assertEqual(light["wavelength"], list(range(400, 701, 50)))
        for i in range(7):
            self.assertAlmostEqual(
                light["absorption"][i],
                sum(light[n + "Absorption"][i] for n in (
                    "water", "phytoplankton", "dissolved", "detritus")), 12)
            self.assertAlmostEqual(
                light["backscattering"][i],
                0.5 * light["molecularScattering"][i]
                + 0.012 * light["particleScattering"][i], 9)
            self.assertAlmostEqual(
                light["remoteSensingReflectance"][i] * math.cos(math.pi / 6),
                light["total"][i], 12)
            self.assertGreater(light["diffuseAttenuation"][i],
                               light["absorption"][i])
            self.assertLess(light["irradianceReflectance"][i], 0.5)
        one = self.daemon.get(water + "&wavelength=450").json()["water"]
        self.assertEqual(one["total"], [light["total"][1]])
        three = self.daemon.get(water).json()["water"]
        self.assertEqual(three["wavelength"], [680, 550, 440])
        self.refused(self.daemon.get(water + "&wavelength=450&from=GPU"), 400)
        self.refused(self.daemon.get(water + "&wavelengthLast=450"), 400)
        self.refused(self.daemon.get(water + "&wavelength=399"), 400,
                     path="water.wavelength", minimum=400)

    def test_which_view_is_missing(self):
        answer = self.daemon.get("/v1/frames.jpg?views=bridge,wign")
        self.assertEqual(answer.status, 404)
        self.assertIn('"wign"', answer.json()["detail"])

    def test_surface(self):
        answer = self.daemon.request("POST", "/v1/surface", {
            "points": [[0, 0], [10.5, -3]], "time": 7})
        self.assertEqual(answer.status, 200, answer)
        result = answer.json()
        self.assertEqual(result["time"], 7)
        self.assertEqual(len(result["points"]), 2)
        normal = result["points"][0]["normal"]
        self.assertAlmostEqual(sum(x * x for x in normal.values()), 1, 6)
        self.assertLess(abs(result["points"][1]["height"]), 5)
        self.assertEqual(set(result["points"][0]["velocity"]),
                         {"east", "north", "up"})
        flat = self.daemon.request("POST", "/v1/surface", {"points": [0, 0]})
        self.assertEqual(flat.status, 400)
        self.assertIn("[east, …]", flat.json()["detail"])
        many = {"points": [[i, -i] for i in range(10000)]}
        self.assertEqual(len(self.daemon.request(
            "POST", "/v1/surface", many).json()["points"]), 10000)
        many["points"].append([1, 1])
        self.refused(self.daemon.request("POST", "/v1/surface", many), 400,
                     code="OUT_OF_RANGE", path="points")
        self.refused(self.daemon.request(
            "POST", "/v1/surface", {"points": [[0, 0], [3e7, 0]]}), 400,
            code="OUT_OF_RANGE", path="points.1.east", maximum=2.1e7, unit="m")
        self.refused(self.daemon.request(
            "POST", "/v1/surface", {"points": [[0]]}), 400)

    def test_clock_step(self):
        self.refused(self.daemon.request("POST", "/v1/clock/step",
                                         {"seconds": 1}), 409,
                     code="CONFLICT")
        self.daemon.patch({"clock": {"mode": "STEPPED", "time": 100}})
        answer = self.daemon.request("POST", "/v1/clock/step", {"seconds": 2})
        self.assertEqual(answer.json()["clock"]["time"], 102)
        answer = self.daemon.request("POST", "/v1/clock/step")
        self.assertAlmostEqual(answer.json()["clock"]["time"], 102 + 1 / 30)
        answer = self.daemon.request("POST", "/v1/clock/step",
                                     {"seconds": -1})
        self.assertEqual(answer.status, 400)
        self.assertEqual(answer.json()["path"], "seconds")

    def test_page_files(self):
        answer = self.daemon.get("/")
        self.assertIn(b"<title>Pelagos</title>", answer.body)
        self.assertEqual(answer.headers["Content-Type"],
                         "text/html; charset=utf-8")
        self.assertIn("default-src 'self'",
                      answer.headers["Content-Security-Policy"])
        self.assertEqual(answer.headers["X-Content-Type-Options"], "nosniff")
        for name, kind in (("app.js", "text/javascript"),
                           ("style.css", "text/css"),
                           ("favicon.svg", "image/svg+xml")):
            answer = self.daemon.get("/" + name)
            self.assertTrue(answer.headers["Content-Type"].startswith(kind))
            tag = answer.headers["ETag"]
            again = self.daemon.get("/" + name,
                                    headers={"If-None-Match": tag})
            self.assertEqual((again.status, again.body), (304, b""))
        self.refused(self.daemon.get("/../etc/passwd"), 404)
        self.refused(self.daemon.get("/%2e%2e/%2e%2e/etc/passwd"), 404)

    def test_keep_alive(self):
        import http.client
        connection = http.client.HTTPConnection("127.0.0.1",
                                                self.daemon.http_port)
        with contextlib.closing(connection):
            for _ in range(20):
                connection.request("GET", "/v1/views/bridge/frame.jpg"
                                          "?width=32&height=16")
                self.assertEqual(connection.getresponse().read()[:2],
                                 b"\xff\xd8")


class Refusals(HttpCase):
    def test_values(self):
        for change, code, path in (
                ({"sea": {"windSpeed": 31}}, "OUT_OF_RANGE", "sea.windSpeed"),
                ({"sea": {"windSpeed": "high"}}, "INVALID", "sea.windSpeed"),
                ({"sea": {"windspeed": 3}}, "NOT_FOUND", "sea.windspeed"),
                ({"sea": 3}, "INVALID", "sea"),
                ({"sea": {"windSpeed": 5}, "sky": {"visibility": 1}},
                 "OUT_OF_RANGE", "sky.visibility"),
                ({"views": {"bridge": {"yaw": 1, "width": 5}}},
                 "OUT_OF_RANGE", "views.bridge.width")):
            answer = self.daemon.patch(change, headers=MERGE)
            problem = self.refused(answer, 400, code=code, path=path)
        self.assertEqual((problem["unit"], problem["minimum"],
                          problem["maximum"], problem["value"]),
                         ("px", 16, 4096, "5"))
        self.refused(self.daemon.request("PUT", "/v1/views/bridge",
                                         {"name": "other"}), 400, path="name")
        self.refused(self.daemon.request("PUT", "/v1/views/a.b", {}), 400)

    def test_forms(self):
        for body in (b"", b"{", b"[]", b"{} {}", b'{"sea":{"windSpeed":NaN}}',
                     b'{"sea":{"windSpeed":1e999}}', b"\xff\xfe", b"{\"a\":1",
                     b'{"sea":{"windSpeed":1,"windSpeed":2}}',
                     b"[" * 60000):
            self.refused(self.daemon.patch(body), 400)

    def test_methods_and_places(self):
        for method, path, allow in (
                ("POST", "/v1/state", "GET, HEAD, PATCH"),
                ("DELETE", "/v1/state", "GET, HEAD, PATCH"),
                ("PATCH", "/v1/views/bridge", "GET, HEAD, PUT, DELETE"),
                ("GET", "/v1/surface", "POST"),
                ("POST", "/healthz", "GET, HEAD"),
                ("HEAD", "/v1/views/bridge/live", "GET")):
            answer = self.daemon.request(method, path)
            self.assertEqual((answer.status, answer.headers["Allow"]),
                             (405, allow), (method, path))
        for path in ("/v1", "/v2/state", "/v1/state/", "/nothing",
                     "/v1/views/bridge/frame.jpg/more", "//", "//healthz"):
            self.assertEqual(self.daemon.get(path).status, 404, path)
        self.refused(self.daemon.get("/v1/state?pretty=1"), 400,
                     path="pretty")
        for path in ("/%", "/%zz", "/v1/state%00", "/a%0d%0ab",
                     "/v1/almanac?" + "&".join(f"a{i}=1" for i in range(40)),
                     "/a/b/c/d/e/f/g/h/i/j"):
            self.refused(self.daemon.get(path), 400)
        self.refused(self.daemon.get("/" + "a" * 3000), 414)

    def test_content_type(self):
        for kind in ("text/plain", "application/x-www-form-urlencoded",
                     "application/json; charset=latin1", "application/jsonx"):
            self.refused(self.daemon.patch(
                {}, headers={"Content-Type": kind}), 415)
        for kind in ("application/json; charset=utf-8", "APPLICATION/JSON"):
            self.assertEqual(self.daemon.patch(
                {}, headers={"Content-Type": kind}).status, 200)

    def test_strangers(self):
        evil = {"Host": "evil.example"}
        self.refused(self.daemon.get("/v1/state", headers=evil), 403)
        self.refused(self.daemon.get("/v1/state", headers={
            "Host": "127.0.0.1.evil.example"}), 403)
        port = self.daemon.http_port
        for host in (f"localhost:{port}", "127.0.0.1", "[::1]:80",
                     "192.168.1.20:8080"):
            self.assertEqual(self.daemon.get(
                "/healthz", headers={"Host": host}).status, 200, host)
        for origin in ("http://evil.example", "null",
                       f"http://127.0.0.1:{port + 1}"):
            self.refused(self.daemon.patch(
                {"sea": {"windSpeed": 1}}, headers={"Origin": origin}), 403)
        self.assertEqual(self.daemon.patch(
            {}, headers={"Origin": f"http://127.0.0.1:{port}"}).status, 200)

    def test_bodies_too_large(self):
        self.refused(self.daemon.patch(b" " * 65537), 413)
        self.refused(self.daemon.get("/v1/state", body=b"{}"), 400)
        self.assertEqual(self.daemon.patch(b"{}" + b" " * 65000).status, 200)


class Origins(HttpCase):
    PICTURE = "/v1/views/bridge/frame.jpg?width=64&height=36"
    COSTLY = (PICTURE, "/v1/frames.jpg", "/v1/views/bridge/mjpeg",
              "/v1/views/bridge/ts", "/v1/optics/brdf?viewZenith=30")

    def test_other_pages(self):
        drawn = "pelagos_frames_drawn_total"
        before = self.daemon.metrics().get(drawn)
        for path in self.COSTLY:
            for headers in ({"Sec-Fetch-Site": "cross-site"},
                            {"Sec-Fetch-Site": "same-site"},
                            {"Sec-Fetch-Site": "cross-site",
                             "Referer": "https://desk.example/"},
                            {"Origin": "https://desk.example"}):
                answer = self.daemon.get(path, headers=headers)
                self.refused(answer, 403)
                self.assertIn("--allow-origin", answer.json()["detail"])
        self.assertEqual(self.daemon.metrics().get(drawn), before)
        for site in ("same-origin", "none"):
            self.assertEqual(self.daemon.get(self.PICTURE, headers={
                "Sec-Fetch-Site": site}).status, 200)
        self.assertEqual(self.daemon.get("/", headers={
            "Sec-Fetch-Site": "cross-site"}).status, 200, "a link to the page")

    def test_edits_of_other_pages(self):
        """Pages of other origins, by all that their browsers say of them."""
        before = self.daemon.state()["revision"]
        for method, path, body in (
                ("PATCH", "/v1/state", {"sea": {"windSpeed": 21}}),
                ("POST", "/v1/clock/step", {}), ("POST", "/v1/surface", {}),
                ("PUT", "/v1/views/mine", {}), ("DELETE", "/v1/views/bridge",
                                                None)):
            for site in ("cross-site", "same-site", "Cross-Site"):
                answer = self.daemon.request(method, path, body, headers={
                    "Sec-Fetch-Site": site})
                self.refused(answer, 403)
        self.assertEqual(self.daemon.state()["revision"], before)
        self.assertEqual(self.daemon.patch({}, headers={
            "Sec-Fetch-Site": "same-origin"}).status, 200)

    def test_allowed_pages(self):
        with Daemon("--allow-origin",
                    "https://a.example,https://desk.example") as daemon:
            for headers, status in (
                    ({"Origin": "https://desk.example"}, 200),
                    ({"Sec-Fetch-Site": "cross-site",
                      "Referer": "https://desk.example/x"}, 200),
                    ({"Sec-Fetch-Site": "cross-site"}, 403),
                    ({"Origin": "https://desk.example.evil"}, 403),
                    ({"Origin": "null"}, 403)):
                answer = daemon.get(self.PICTURE, headers=headers)
                self.assertEqual(answer.status, status, headers)
                policy = answer.headers["Cross-Origin-Resource-Policy"]
                self.assertEqual(policy, "cross-origin" if status == 200
                                 else "same-origin")
            answer = daemon.get("/v1/views/bridge/live", headers={
                "Origin": "https://desk.example", "Upgrade": "websocket",
                "Connection": "Upgrade", "Sec-WebSocket-Version": "13",
                "Sec-WebSocket-Key": "x"})
            self.assertEqual(answer.status, 400, "its key, not its origin")


class Heads(HttpCase):
    def test_pictures(self):
        """As GET says, without drawing."""
        drawn = "pelagos_frames_views_drawn_total"
        before = self.daemon.metrics()
        for path, kind in (
                ("/v1/views/bridge/frame.jpg", "image/jpeg"),
                ("/v1/views/bridge/frame.png?width=64", "image/png"),
                ("/v1/views/bridge/frame.exr", "image/x-exr"),
                ("/v1/frames.jpg", "multipart/mixed; boundary=pelagos-frame"),
                ("/v1/views/bridge/mjpeg",
                 "multipart/x-mixed-replace; boundary=pelagos"),
                ("/v1/views/bridge/ts", "video/mp2t")):
            answer = self.daemon.request("HEAD", path)
            self.assertEqual((answer.status, answer.body), (200, b""), path)
            self.assertEqual(answer.headers["Content-Type"], kind)
        for path, status in (("/v1/views/nothing/frame.jpg", 404),
                             ("/v1/views/bridge/frame.jpg?width=1", 400),
                             ("/v1/views/bridge/frame.jpg?widht=1", 400)):
            self.assertEqual(self.daemon.request("HEAD", path).status, status)
        self.assertEqual(self.daemon.metrics().get(drawn), before.get(drawn))

    def test_many_parameters(self):
        """A whole water, every number of it."""
        def paths(name, value):
            if isinstance(value, dict):
                return [p for k, v in value.items()
                        for p in paths(f"{name}.{k}", v)]
            number = (isinstance(value, (int, float))
                      and not isinstance(value, bool))
            return [f"{name}={value:g}"] if number else []
        state = self.daemon.state()
        given = [p for part in ("water", "sea", "sky", "origin", "seabed")
                 for p in paths(part, state[part]) if "Step" not in p]
        self.assertGreater(len(given), 16)
        answer = self.daemon.get("/v1/optics/water?viewZenith=30&"
                                 + "&".join(given))
        self.assertEqual(answer.status, 200, answer)


if __name__ == "__main__":
    unittest.main(verbosity=2)
