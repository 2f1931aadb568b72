#!/usr/bin/python3
"""/v1/openapi.json: a validator that is not ours takes it, it names every route
and no other, and a live daemon's answers have the forms that it promises."""
import contextlib
import http.client
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest

import jsonschema

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import ROOT, SLOW_S, Daemon, Response, until
from whep_offer import OFFER

VALIDATOR = os.path.join(ROOT, "build/npm/node_modules/@seriousme/"
                         "openapi-schema-validator/bin/validate-api-cli.js")
# What stands for the names in a path.
NAMES = {"view": "bridge", "file": "style.css", "exercise": "one",
         "preset": "one"}
FIELDS = ["sea", "sea.windSpeed", "sea.spectrum", "views", "clock/utc",
          "views/bridge/yaw", "sky.sunElevation"]
ENDLESS = ("multipart/x-mixed-replace", "video/mp2t")


def rows():
    """Method and path of each row of the table, read by other means than the
    document's."""
    with open(os.path.join(ROOT, "proto/routes.def"), encoding="utf-8") as f:
        text = f.read().split("#endif", 2)[2]
    return re.findall(r'PEL_ROUTE\(\s*"([A-Z]+)",\s*"([^"]*)"', text)


# What the example of the document is no axis of.
SERIES = {"/v1/series/water": "/v1/series/water?sweep=sunZenith=20,40",
          "/v1/series/surface": "/v1/series/surface?sweep=time=0:2:1&points=0,5"}


class OpenApi(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        with open(os.path.join(folder.name, "one.json"), "w") as file:
            json.dump({"state": {"entities": [{"id": 1}]}}, file)
        cls.daemon = Daemon(f"--exercises={folder.name}")
        cls.addClassCleanup(cls.daemon.stop)
        answer = cls.daemon.get("/v1/openapi.json")
        assert answer.status == 200, answer
        assert answer.headers["Content-Type"] == "application/json"
        cls.document = answer.json()
        cls.daemon.patch({"views": [{"name": "bridge", "entity": 1, "width": 64,
                                     "height": 48}]})
        cls.daemon.request("PUT", "/v1/presets/one", {
            "patch": "{\"sea\":{\"windSpeed\":6}}"})
        cls.daemon.get("/v1/views/bridge/frame.jpg", timeout=SLOW_S)
        until("well", lambda: cls.daemon.get("/healthz").status == 200)

    def check(self, value, schema):
        """`value` has the form `schema` of the document."""
        whole = {"components": self.document["components"], **schema}
        validator = jsonschema.Draft202012Validator(whole)
        errors = [f"{e.json_path}: {e.message[:300]}"
                  for e in validator.iter_errors(value)]
        self.assertEqual(errors[:5], [])

    def check_answer(self, operation, answer, where):
        """An answer to a documented request: status, type, headers, form."""
        said = operation["responses"].get(str(answer.status))
        self.assertIsNotNone(said, f"{where}: {answer.status} is not said")
        if "$ref" in said:
            said = self.document["components"]["responses"][
                said["$ref"].split("/")[-1]]
        kind = (answer.headers["Content-Type"] or "").split(";")[0]
        types = said.get("content", {})
        if not types:
            self.assertEqual(answer.body, b"", where)
            return
        self.assertIn(kind, types, where)
        for name in answer.headers:
            if name.startswith("X-Pelagos") or name == "ETag":
                self.assertIn(name, said.get("headers", {}), where)
        if kind.endswith("json"):
            with self.subTest(where):
                self.check(answer.json(), types[kind].get("schema", {}))

    def test_validator_that_is_not_ours(self):
        if not os.path.exists(VALIDATOR):
            self.skipTest("no @seriousme/openapi-schema-validator: make deps")
        path = os.path.join(self.daemon.folder, "openapi.json")

        def judge(document):
            with open(path, "w", encoding="utf-8") as f:
                json.dump(document, f)
            out = subprocess.run(["node", VALIDATOR, path], text=True,
                                 capture_output=True, timeout=60)
            return out.stdout + out.stderr
        self.assertRegex(judge(self.document), r'"valid": *true')
        broken = json.loads(json.dumps(self.document))
        broken["paths"]["/healthz"]["get"]["responses"]["200"].pop(
            "description")
        self.assertNotRegex(judge(broken), r'"valid": *true')

    def test_every_route_and_no_other(self):
        endings = ["jpg", "png", "exr", "json"]
        expected = set()
        for method, path in rows():
            paths = ([path.replace("{ending}", e) for e in endings]
                     if "{ending}" in path else
                     [path.replace("{question}", q)
                      for q in ("brdf", "sky", "water")]
                     if "{question}" in path else [path])
            expected |= {(method, "/" + p) for p in paths}
        said = {(method.upper(), path)
                for path, item in self.document["paths"].items()
                for method in item}
        self.assertEqual(said, expected)
        self.assertGreater(len(said), 30)
        # Nothing is answered but by the table.
        with open(os.path.join(ROOT, "server/net/http_route.c")) as f:
            table = f.read().split("routes[] = {")[1].split("};")[0]
        self.assertEqual(re.findall(r'"([A-Z]+)"', table), [])

    def test_version(self):
        with open(os.path.join(ROOT, "VERSION")) as f:
            self.assertEqual(self.document["info"]["version"],
                             f.read().strip())
        self.assertEqual(self.daemon.get("/healthz").json()["version"],
                         self.document["info"]["version"])

    def head_of(self, path):
        """The headers of an endless answer, as far as they are asked for."""
        c = http.client.HTTPConnection("127.0.0.1", self.daemon.http_port,
                                       timeout=60)
        with contextlib.closing(c):
            c.request("GET", path)
            answer = c.getresponse()
            body = answer.read(1 if answer.status == 200 else None)
            return Response(answer.status, answer.headers, body)

    def piece(self):
        answer = self.daemon.get("/v1/views/bridge/hls.m3u8")
        name = re.search(r"hls/([^/]+\.ts)$", answer.body.decode(), re.M)
        return "/v1/hls/" + name.group(1)

    def test_every_get(self):
        called = 0
        for path, item in self.document["paths"].items():
            if "get" not in item:
                continue
            operation = item["get"]
            url = re.sub(r"\{(\w+)\}",
                         lambda m: NAMES.get(m.group(1), "{}"), path)
            urls = ([url.replace("{}", field) for field in FIELDS]
                    if "{}" in url else [url])
            types = operation["responses"].get("200", {}).get("content", {})
            examples = "&".join(f"{p['name']}={p['example']}"
                                for p in operation.get("parameters", [])
                                if "example" in p)
            if examples:
                urls = [SERIES.get(url, f"{url}?{examples}") for url in urls]
            for url in urls:
                if url.startswith("/v1/hls/"):  # what the playlist names
                    url = self.piece()
                if url.endswith("/frame.json"):  # a truth of something
                    self.daemon.patch({"entities": {"1": {
                        "model": {"name": "yacht"}}}})
                answer = (self.head_of(url)
                          if any(t in ENDLESS for t in types)
                          else self.daemon.get(url))
                wanted = 426 if url.endswith("/live") else 200
                if "/debrief/" in url:
                    wanted = 404  # none is open
                elif url.endswith("/exercise.csv"):
                    wanted = 409  # none is loaded
                elif url.endswith("/soundings"):
                    wanted = 409  # no seabed.file
                self.assertEqual(answer.status, wanted, url)
                self.check_answer(operation, answer, url)
                called += 1
        self.assertGreater(called, 25)

    def test_parameters(self):
        """Each is taken at the ends of its range and refused beyond them, with
        the range that is said."""
        seen = 0
        for path, item in self.document["paths"].items():
            for parameter in item.get("get", {}).get("parameters", []):
                schema = parameter.get("schema", {})
                if (parameter.get("in") != "query" or "maximum" not in schema
                        or "/debrief/" in path):  # as of the live views
                    continue
                url = path.replace("{view}", "bridge")
                name, unit = parameter["name"], schema.get("x-unit")
                for value, ok in ((schema["minimum"], True),
                                  (schema["minimum"] - 1, False),
                                  (schema["maximum"] + 1, False)):
                    where = f"{url}?{name}={value:.10g}"
                    if ok and not re.search(r"frame\.jpg|optics.*[a-z]Z", where):
                        continue  # one of a kind: pictures take their time
                    answer = self.ask(where)
                    if ok:
                        self.assertNotEqual(answer.status, 400, where)
                        continue
                    self.assertEqual(answer.status, 400, where)
                    problem = answer.json()
                    self.check_answer(item["get"], answer, where)
                    if "minimum" in problem:
                        self.assertEqual(
                            (problem["minimum"], problem["maximum"]),
                            (schema["minimum"], schema["maximum"]), where)
                    if unit and "unit" in problem:
                        self.assertEqual(problem["unit"], unit, where)
                    seen += 1
        self.assertGreater(seen, 40)

    def ask(self, where):
        endless = "/mjpeg" in where or "/ts" in where
        return self.head_of(where) if endless else self.daemon.get(where)

    def test_unknown_parameters(self):
        for path, item in self.document["paths"].items():
            # The page's address says what it shows; no debrief is open.
            if ("get" in item and "{file}" not in path and path != "/"
                    and "/debrief/" not in path):
                url = path.replace("{view}", "bridge").replace(
                    "{path}", "sea").replace("{preset}", "one").replace(
                    "{exercise}", "one") + "?nonsense=1"
                if url.startswith("/v1/hls/"):
                    url = self.piece() + "?nonsense=1"
                lax = "X-Pelagos-Ignored" in item["get"]["responses"].get(
                    "200", {}).get("headers", {})
                answer = (self.ask(url) if "/live" not in url else
                          Response(400, {}, b""))
                self.assertEqual(answer.status, 200 if lax else 400, url)
                if "/live" not in url:
                    self.check_answer(item["get"], answer, url)

    CALLS = [
        ("PATCH", "/v1/state", {"sea": {"windSpeed": 7, "swell": [[2, 9]]}},
         200),
        ("PATCH", "/v1/state", {"sea": {"windSpeed": None, "swell": None}}, 200),
        ("PATCH", "/v1/state", {"views": {"two": {"yaw": 3}, "bridge": {}}},
         200),
        ("PATCH", "/v1/state", {"views": {"two": None}}, 200),
        ("PATCH", "/v1/state", {"sea": {"windSpeed": 99}}, 400),
        ("PATCH", "/v1/state", {"see": {}}, 400),
        ("PATCH", "/v1/state", {"sea": {"windSpeed": "x"}}, 400),
        ("PUT", "/v1/views/three", {"entity": 1, "width": 64}, 201),
        ("PUT", "/v1/views/three", {"entity": 1, "yaw": 9}, 200),
        ("PUT", "/v1/views/three", {"yaw": 1e9}, 400),
        ("POST", "/v1/views/bridge/whep", "v=0", 400),
        ("POST", "/v1/views/bridge/whep", OFFER, 201),
        ("DELETE", "/v1/whep/none", None, 404),
        ("DELETE", "/v1/views/three", None, 204),
        ("DELETE", "/v1/views/three", None, 404),
        ("PUT", "/v1/cluster/place/bridge", {"node": "a"}, 409),
        ("PUT", "/v1/cluster/place/bridge", {"node": 3}, 400),
        ("DELETE", "/v1/cluster/place/bridge", None, 409),
        ("POST", "/v1/surface", {"points": [[0, 5], {"east": 1, "north": 2}],
                                 "acceleration": True, "foam": True}, 200),
        ("POST", "/v1/surface", {"points": [[0, 1e9]]}, 400),
        ("POST", "/v1/spectrum", {"frequencies": 4, "directions": 3}, 200),
        ("POST", "/v1/spectrum", {"frequencies": 201}, 400),
        ("POST", "/v1/spectrum", {"format": "SWAN"}, 200),
        ("POST", "/v1/optics", {"brdf": {"viewZenith": 20}}, 200),
        ("POST", "/v1/optics", {"water": {}, "from": "REFERENCE"}, 200),
        ("POST", "/v1/optics", {"sky": {"elevation": 91}}, 400),
        ("POST", "/v1/series", {"spectrum": {}, "sweep": [
            {"over": "windSpeed", "values": [4, 8]}]}, 200),
        ("POST", "/v1/series", {"spectrum": {}, "sweep": [
            {"over": "windSpeed", "values": "4"}]}, 400),
        ("POST", "/v1/clock/step", {"seconds": 1}, 409),
        ("PUT", "/v1/presets/two", {"patch": "{\"sea\":{\"windSpeed\":5}}"}, 201),
        ("POST", "/v1/presets/two", None, 200),
        ("DELETE", "/v1/presets/two", None, 204),
        ("DELETE", "/v1/presets/two", None, 404),
        ("POST", "/v1/recording", {"start": "one"}, 409),
        ("PATCH", "/v1/debrief", {"close": True}, 200),
        ("POST", "/v1/exercise", {"action": "STATUS"}, 200),
        ("POST", "/v1/exercise", {"action": "CHECK", "exercise": {
            "draught": 99}}, 400),
        ("PUT", "/v1/exercises/two",
         {"state": {"entities": [{"id": 1}]}, "events": [
             {"name": "rain", "when": [{"at": 1}],
              "patch": {"state": {"sky": {"rain": 3}}}}]}, 200),
        ("PUT", "/v1/exercises/two", {"draught": 99}, 400),
        ("DELETE", "/v1/exercises/two", None, 204),
        ("DELETE", "/v1/exercises/two", None, 404),
    ]

    def test_calls_with_bodies(self):
        """Bodies that are taken have the forms of the document, most of those
        that are refused have not; every answer has."""
        called = set()
        for method, url, body, status in self.CALLS:
            path = (url if url in self.document["paths"] else
                    "/v1/exercises/{exercise}" if "exercises" in url else
                    "/v1/presets/{preset}" if "presets" in url else
                    "/v1/views/{view}/whep" if url.endswith("/whep") else
                    "/v1/cluster/place/{view}" if "/place/" in url else
                    "/v1/whep/{session}" if "/whep/" in url else
                    "/v1/views/{view}")
            operation = self.document["paths"][path][method.lower()]
            sdp = isinstance(body, str)
            answer = self.daemon.request(method, url, body, {
                "Content-Type": "application/sdp"} if sdp else None)
            where = f"{method} {url} {body}"
            self.assertEqual(answer.status, status, (where, answer))
            self.check_answer(operation, answer, where)
            called.add((method, path))
            if body is None or sdp or status in (404, 409):
                continue
            schema = operation["requestBody"]["content"]["application/json"][
                "schema"]
            validator = jsonschema.Draft202012Validator(
                {"components": self.document["components"], **schema})
            # What an array of fields may hold is not said.
            if status < 300 or "points" not in body:
                self.assertEqual(validator.is_valid(body), status < 300, where)
        said = {(method.upper(), path)
                for path, item in self.document["paths"].items()
                for method in item if method != "get"}
        self.assertEqual(called, said)

    def test_units_and_ranges_are_those_of_fields(self):
        """GET /v1/fields, made in C, and the document, by Python, agree."""
        schemas = self.document["components"]["schemas"]

        def walk(name, prefix):
            for key, field in schemas[name]["properties"].items():
                inner = field.get("items", field)
                inner = inner.get("anyOf", [inner])[0]
                target = inner.get("$ref", "").split("/")[-1]
                if target and "properties" in schemas[target]:
                    yield from walk(target, prefix + [key])
                else:
                    yield prefix + [key], field
        said = {".".join(path): field for path, field in walk("State", [])}
        compared = 0
        for field in self.daemon.get("/v1/fields").json()["fields"]:
            if "minimum" not in field:
                continue
            path = re.sub(r"\.(NAME|ID|N|KEY|\*|<\w+>|\{\w+\})(?=\.|$)", "",
                          field["path"])
            form = said.get(path)
            if form is None:
                continue
            form = dict(form, **form.get("items", {}))
            self.assertEqual((form["minimum"], form["maximum"]),
                             (field["minimum"], field["maximum"]), path)
            if field.get("unit", "1") != "1":
                self.assertEqual(form["x-unit"], field["unit"], path)
            compared += 1
        self.assertGreater(compared, 80)


if __name__ == "__main__":
    unittest.main()
