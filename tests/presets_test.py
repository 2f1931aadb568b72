#!/usr/bin/python3
"""Presets by HTTP, protobuf and pelagosctl: what is refused, what is kept over
a restart and a kill; the almanac by both."""
import json
import os
import signal
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import BIN, Daemon, Session, schema

STORM = {"sea": {"windSpeed": 24, "swell": [{"height": 3, "period": 12}]},
         "sky": {"cloudCover": 8}}


def text(change):
    return json.dumps(change, separators=(",", ":"))


class Presets(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.state = os.path.join(folder.name, "state.json")
        self.begin()

    def begin(self):
        self.daemon = Daemon("--state", self.state)
        self.addCleanup(self.daemon.stop)

    def put(self, name, body, **more):
        return self.daemon.request("PUT", f"/v1/presets/{name}",
                                   json.dumps(body), {
            "Content-Type": "application/json"}, **more)

    def names(self):
        return [p["name"] for p in
                self.daemon.get("/v1/presets").json()["presets"]]

    def ctl(self, *words):
        return subprocess.run(
            [os.path.join(BIN, "pelagosctl"), "--server",
             f"tcp:127.0.0.1:{self.daemon.tcp_port}", *words],
            capture_output=True, text=True, check=False)

    def test_made_read_applied_removed(self):
        self.assertEqual(self.daemon.get("/v1/presets").json(),
                         {"presets": []})
        made = self.put("storm", {"title": "Großer Sturm",
                                  "patch": text(STORM)})
        self.assertEqual(made.status, 201)
        self.assertEqual(made.headers["Location"], "/v1/presets/storm")
        self.assertEqual(made.json(), {"name": "storm", "patch": text(STORM),
                                       "title": "Großer Sturm"})
        self.assertEqual(self.put("storm", {"patch": "{}"}).status, 200)
        self.assertEqual(self.daemon.get("/v1/presets/storm").json(),
                         {"name": "storm", "patch": "{}"})
        self.put("storm", {"patch": text(STORM)})
        after = self.daemon.request("POST", "/v1/presets/storm")
        self.assertEqual(after.status, 200)
        self.assertEqual(after.json()["sea"]["windSpeed"], 24)
        self.assertEqual(len(self.daemon.state()["sea"]["swell"]), 1)
        gone = self.daemon.request("DELETE", "/v1/presets/storm")
        self.assertEqual(gone.status, 204)
        self.assertEqual(self.names(), [])

    def test_refused(self):
        cases = [("a%20b", {"patch": "{}"}, "presets"),
                 ("x" * 65, {"patch": "{}"}, "presets." + "x" * 64 + ".name"),
                 ("a", {}, "patch"),
                 ("a", {"patch": "{}", "name": "b"}, "name"),
                 ("a", {"patch": "[]"}, "presets.a.patch"),
                 ("a", {"patch": text({"sea": {"windSpeed": 99}})},
                  "presets.a.patch"),
                 ("a", {"patch": text({"sea": {"wind": 9}})},
                  "presets.a.patch"),
                 ("a", {"patch": text({"presets": None})}, "presets.a.patch"),
                 ("a", {"patch": "{}", "title": "t" * 65}, "presets.a.title")]
        before = self.daemon.state()["revision"]
        for name, body, path in cases:
            answer = self.put(name, body)
            self.assertEqual(answer.status, 400, answer)
            self.assertEqual(answer.json()["path"], path, answer)
        self.assertEqual(self.daemon.state()["revision"], before)
        for method in ("GET", "POST", "DELETE"):
            self.assertEqual(self.daemon.request(
                method, "/v1/presets/none").status, 404)
        wrong = self.daemon.request("PATCH", "/v1/presets/a", b"{}")
        self.assertEqual(wrong.status, 405)
        self.assertIn("POST", wrong.headers["Allow"])
        # What names something that is gone meanwhile changes nothing.
        self.put("a", {"patch": text({"views": {"stern": None}})})
        self.assertEqual(self.daemon.request("POST", "/v1/presets/a").status,
                         400)

    def test_kept(self):
        self.put("storm", {"patch": text(STORM), "title": "S"})
        self.daemon.stop(signal.SIGKILL)
        self.begin()
        self.assertEqual(self.names(), ["storm"])
        self.put("calm", {"patch": text({"sea": {"windSpeed": 1}})})
        self.assertEqual(self.daemon.stop(), 0)
        self.begin()
        self.assertEqual(self.names(), ["storm", "calm"])
        self.assertEqual(self.daemon.get("/v1/presets/storm").json()["patch"],
                         text(STORM))

    def test_pelagosctl(self):
        self.daemon.patch({"sea": {"windSpeed": 17, "swell": [{}]},
                           "sky": {"sunElevation": 4}})
        self.assertEqual(self.ctl("preset", "save", "now", "--title",
                                  "As it was").returncode, 0)
        self.daemon.patch({"sea": {"windSpeed": 2, "swell": None,
                                   "beaufort": 3},
                           "sky": {"sunElevation": None},
                           "water": {"named": "BALTIC"}})
        self.assertEqual(self.ctl("preset", "apply", "now").returncode, 0)
        state = self.daemon.state()
        self.assertEqual([state["sea"]["windSpeed"],
                          len(state["sea"]["swell"]),
                          state["sky"]["sunElevation"],
                          "named" in state["water"]], [17, 1, 4, False])
        self.assertIn("As it was", self.ctl("preset", "list").stdout)
        self.assertEqual(self.ctl("preset", "save", "bad", "--patch",
                                  text({"sea": {"windSpeed": 99}})).returncode,
                         4)
        self.assertEqual(self.ctl("preset", "delete", "now").returncode, 0)
        for words in (("delete", "now"), ("apply", "now")):
            done = self.ctl("preset", *words)
            self.assertEqual(done.returncode, 4, done.stderr)
        for words in (("save",), ("list", "x"), ("what",)):
            self.assertEqual(self.ctl("preset", *words).returncode, 2)
        self.assertEqual(json.loads(self.ctl("--json", "preset",
                                             "list").stdout),
                         {"presets": []})

    def test_almanac(self):
        self.daemon.patch({"clock": {"mode": "STEPPED", "time": 3600,
                                     "utc": "2000-01-01T11:00:00Z"},
                           "origin": {"latitude": 51.51, "longitude": -0.13}})
        answer = self.daemon.get("/v1/almanac").json()
        self.assertEqual(answer["utc"], "2000-01-01T12:00:00Z")
        self.assertRegex(answer["sun"]["rise"], "^2000-01-01T08:0[56]:")
        self.assertAlmostEqual(answer["sun"]["elevation"], 15.5, delta=0.1)
        other = self.daemon.get("/v1/almanac?time=90000").json()
        self.assertEqual(other["utc"], "2000-01-02T12:00:00Z")
        for query in ("time=-1", "time=x", "when=2"):
            self.assertEqual(self.daemon.get("/v1/almanac?" + query).status,
                             400)
        with Session(self.daemon.connect_tcp()) as session:
            pb = schema()
            reply = session.ask(almanac=pb.AlmanacQuery())
            self.assertEqual(reply.almanac.sun.rise, answer["sun"]["rise"])
            reply = session.ask(almanac=pb.AlmanacQuery(time=-5))
            self.assertEqual(reply.error.code, pb.OUT_OF_RANGE)


if __name__ == "__main__":
    unittest.main()
