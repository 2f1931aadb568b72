#!/usr/bin/python3
"""The state file: kill -9 at any moment leaves a scene that was once agreed
to, a file that cannot be written is reported and tried again.

KILLS (25): how often the daemon is killed.
"""
import json
import os
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import warnings

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import BIN, ROOT, SLOW_S, Daemon, Session, until

sys.path.insert(0, os.path.join(ROOT, "clients/python"))
from pelagos import Notice, Ocean

KILLS = int(os.environ.get("KILLS", "25"))


class StateFile(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="pelagos-state-")
        self.path = os.path.join(self.folder, "scene")
        self.addCleanup(shutil.rmtree, self.folder)

    def test_killed_at_any_moment(self):
        """Edits as fast as they are taken, then SIGKILL: the next life begins
        with one of them, never with less than the first edit of a life."""
        chance = random.Random(7)
        agreed = None
        for _ in range(KILLS):
            daemon = Daemon("--state", self.path)
            found = daemon.state()["sea"]["seed"]
            if agreed is not None:
                self.assertIn(found, agreed)
            agreed = []
            # One edit is on its own long enough to be written at once: what
            # was agreed to before it is history.
            end = time.monotonic() + chance.uniform(0, 0.2)
            seed = chance.randrange(1, 1 << 32)
            daemon.patch({"sea": {"seed": seed}})
            until("it is written", lambda: self.seed_on_disk() == seed)
            agreed.append(seed)
            while time.monotonic() < end:
                seed = chance.randrange(1, 1 << 32)
                agreed.append(seed)
                view = f"v{chance.randrange(60)}"
                daemon.patch({"sea": {"seed": seed},
                              "views": {view: {"yaw": chance.random()}}})
            daemon.stop(how=signal.SIGKILL)
        self.assertEqual([name for name in os.listdir(self.folder)
                          if name.endswith(".bad")], [])

    def seed_on_disk(self):
        try:
            with open(self.path) as f:
                return json.load(f)["sea"]["seed"]
        except FileNotFoundError:
            return None

    def test_tried_again(self):
        folder = os.path.join(self.folder, "later")
        path = os.path.join(folder, "scene")
        os.mkdir(folder)
        with Daemon("--state", path) as daemon:
            shutil.rmtree(folder)
            self.assertEqual(daemon.patch({"sea": {"windSpeed": 3}}).status,
                             200)
            until("it is told", lambda: "SCN-003" in daemon.log())
            self.assertGreaterEqual(
                daemon.metrics()["pelagos_scene_save_errors_total"], 1)
            self.assertEqual(
                daemon.get("/v1/views/bridge/frame.jpg?width=64&height=36")
                .status, 200)
            os.mkdir(folder)
            until("it is written", lambda: os.path.exists(path))
            with open(path) as f:
                self.assertEqual(json.load(f)["sea"]["windSpeed"], 3)
            # At the start, and now; it is counted after it is written.
            until("it is counted", lambda: daemon.metrics()[
                "pelagos_scene_saves_total"] == 2)

    def test_a_file_that_does_not_load(self):
        for text in ("", "{", '{"sea":{"windSpeed":99}}', '{"nope":1}',
                     "\0" * 5000, '{"views":[{"name":"a"},{"name":"a"}]}'):
            with open(self.path, "w") as f:
                f.write(text)
            with Daemon("--state", self.path) as daemon:
                self.assertIn("SCN-002", daemon.log())
                self.assertEqual(daemon.state()["sea"]["windSpeed"], 8)
            with open(self.path + ".bad") as f:
                self.assertEqual(f.read(), text)
            os.remove(self.path + ".bad")

    def test_two_daemons(self):
        with Daemon("--state", self.path) as daemon:
            with self.assertRaisesRegex(RuntimeError, "another daemon"):
                Daemon("--state", self.path)
            daemon.stop(how=signal.SIGKILL)
        with Daemon("--state", self.path):
            pass
        self.assertEqual(sorted(os.listdir(self.folder)),
                         ["scene", "scene.prev"])

    def test_what_is_gone_is_kept(self):
        """Files that the state names and that are gone come back."""
        spectra = os.path.join(self.folder, "spectra")
        heights = os.path.join(self.folder, "heights")
        os.mkdir(spectra)
        os.mkdir(heights)
        for ending in ("data_spec", "swdir", "swdir2", "swr1", "swr2"):
            spectral = ending == "data_spec"
            with open(os.path.join(spectra, f"buoy.{ending}"), "w") as f:
                f.write("#YY MM DD hh mm\n2026 06 21 12 00 "
                        + ("9.999 " if spectral else "")
                        + " ".join(f"{1 / (1 + abs(i - 5)):.3f} (0.{10 + i})"
                                   for i in range(12)) + "\n")
        with open(os.path.join(heights, "bay.asc"), "w") as f:
            f.write("ncols 40\nnrows 40\nxllcorner 5.18\nyllcorner 52.58\n"
                    "cellsize 0.001\n" + ("-9 " * 40 + "\n") * 40)
        options = ("--state", self.path, "--spectra", spectra,
                   "--bathymetry", heights)
        with Daemon(*options) as daemon:
            answer = daemon.patch({
                "sea": {"spectrum": "MEASURED", "measured": "buoy"},
                "seabed": {"file": "bay.asc"}})
            self.assertEqual(answer.status, 200, answer)
            self.assertNotIn("missing", daemon.get("/healthz").json())
        gone = os.path.join(self.folder, "gone")
        for name in (spectra, heights):
            os.rename(name, gone + os.path.basename(name))
            os.mkdir(name)
        with Daemon(*options) as daemon:
            state = daemon.state()
            self.assertNotIn("file", state["seabed"])
            self.assertEqual(state["sea"]["spectrum"], "PIERSON_MOSKOWITZ")
            missing = daemon.get("/healthz").json()["missing"]
            self.assertEqual([(m["path"], m["value"]) for m in missing],
                             [("seabed.file", "bay.asc"),
                              ("sea.measured", "buoy")])
            self.assertIn("no such file", missing[0]["reason"])
            self.assertIn("SCN-009", daemon.log())
            self.assertIn("SCN-005", daemon.log())
            daemon.patch({"sea": {"seed": 12}})
            until("it is written", lambda: self.seed_on_disk() == 12)
        for name in (spectra, heights):
            os.rmdir(name)
            os.rename(gone + os.path.basename(name), name)
        with Daemon(*options) as daemon:
            state = daemon.state()
            self.assertEqual(state["seabed"]["file"], "bay.asc")
            self.assertEqual(state["sea"]["spectrum"], "MEASURED")
            self.assertEqual(state["sea"]["seed"], 12)


class Notices(unittest.TestCase):
    def test_a_pose_that_switches_a_helm_off(self):
        """An edit that takes a ship from her model says so, one that does not
        is silent."""
        with Daemon() as daemon:
            def edit(change):
                answer = daemon.patch(change)
                self.assertEqual(answer.status, 200, answer)
                return answer.headers.get("X-Pelagos-Notice")
            for own, helm, path in (
                    ({"ownShip": {"on": True}}, {"ownShip": {"on": False}},
                     "ownShip.on"),
                    ({"ownShip": {"on": False}, "entities": {"7": {
                        "name": "tug", "helm": {"on": True}}}}, {
                            "entities": {"7": {"helm": {"on": False}}}},
                     "entities.7.helm.on")):
                ship = "1" if path == "ownShip.on" else "tug"
                for part in ({"speed": 5}, {"heading": 3}, {"latitude": 52.6}):
                    self.assertIsNone(edit(own))
                    said = edit({"entities": {ship: part}})
                    self.assertIsNotNone(said, part)
                    self.assertIn(path, said)
                    self.assertIsNone(edit({"entities": {ship: part}}),
                                      "it is led already")
                self.assertIsNone(edit(own))
                self.assertIsNone(edit({"entities": {ship: {"name": "tug"}}})
                                  if ship == "tug" else None)
                self.assertIsNone(edit(helm))
            edit({"ownShip": {"on": True}})
            self.assertIsNone(edit({"ownShip": {"on": True},
                                    "entities": {"1": {"speed": 4}}}))
            self.assertTrue(daemon.state()["ownShip"]["on"])

    def test_every_way_says_it(self):
        """The protobuf port, pelagosctl, Python and the log say what HTTP
        says."""
        with Daemon(unix=True) as daemon:
            def on():
                daemon.patch({"ownShip": {"on": True}})
            on()
            words = daemon.patch({"entities": {"1": {"speed": 5}}}).headers[
                "X-Pelagos-Notice"]
            logged = [line for line in daemon.log().splitlines()
                      if "SCN-035" in line]
            self.assertEqual(len(logged), 1)
            self.assertIn(words, logged[0])
            on()
            with Session(daemon.connect_tcp()) as session:
                speed = {"state": {"entities": [{"id": 1, "speed": 5}]}}
                self.assertEqual(session.ask(patch=speed).notice, words)
                self.assertFalse(session.ask(patch=speed).HasField("notice"))
            on()
            for said in (f"pelagosctl: {words}\n", ""):
                done = subprocess.run(
                    [os.path.join(BIN, "pelagosctl"), "--server",
                     f"unix:{daemon.unix_path}", "set", "entities.1.speed=4"],
                    capture_output=True, text=True, check=True)
                self.assertEqual(done.stderr, said)
            on()
            with Ocean(daemon.url("")) as ocean:
                with warnings.catch_warnings(record=True) as caught:
                    warnings.simplefilter("always")
                    ocean.entities[1]["speed"] = 3
                    ocean.entities[1]["speed"] = 4
                self.assertEqual([(w.category, str(w.message), w.filename)
                                  for w in caught],
                                 [(Notice, words, __file__)])


class Start(unittest.TestCase):
    """What cannot be kept is no start: the option, the value, the cure."""

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="pelagos-start-")
        self.addCleanup(shutil.rmtree, self.folder)

    def at(self, name):
        return os.path.join(self.folder, name)

    def refused(self, *options, says):
        result = subprocess.run(
            [os.path.join(BIN, "pelagosd"), "--device", "software",
             "--http", "127.0.0.1:0", "--tcp", "127.0.0.1:0", "--rtsp", "off",
             "--nmea", "off", "--modbus", "off", *options],
            capture_output=True, text=True, timeout=SLOW_S)
        self.assertGreater(result.returncode, 0, options)
        last = result.stderr.strip().splitlines()[-1]
        for words in says:
            self.assertIn(words, last)
        for listening in ("NET-001", "READY", "listening"):
            self.assertNotIn(listening, result.stderr)

    def test_places(self):
        self.refused("--state", self.at("none/state"),
                     says=["--state", self.at("none/state"), "written",
                           "name a file"])
        for option in ("--spectra", "--bathymetry"):
            self.refused(option, self.at("none"),
                         says=[option, self.at("none"), "no directory", "off"])
        if os.geteuid() != 0:
            os.chmod(self.folder, 0o500)
            self.refused("--state", self.at("state"), says=["written"])
            os.chmod(self.folder, 0o700)

    def test_values(self):
        self.refused("--video-encoder", "h265enc",
                     says=["--video-encoder", "h265enc", "auto", "x264enc"])
        for safe, words in (("sea.windSpeed=99", "0 to 30 m/s"),
                            ("sea.windspeed", "PATH=VALUE"),
                            ("sea.nothing=1", "sea.nothing"),
                            ("views.bridge.entity=7", "entity")):
            self.refused("--modbus", "127.0.0.1:0", "--modbus-safe", safe,
                         says=["--modbus-safe", words])

    def test_files_that_are_none(self):
        """A FIFO would hold the daemon up for ever."""
        os.mkfifo(self.at("fifo"))
        with open(self.at("token"), "w") as f:
            f.write("0123456789abcdef0123456789abcdef\n")
        os.chmod(self.at("token"), 0o600)
        for options in (["--state", self.at("fifo")],
                        ["--token-file", self.at("fifo")],
                        ["--token-file", self.at("token"), "--tls-cert",
                         self.at("fifo"), "--tls-key", self.at("token")],
                        ["--token-file", self.at("token"), "--tls-cert",
                         self.at("token"), "--tls-key", self.at("fifo")],
                        ["--console", "127.0.0.1:1", "--console-table",
                         self.at("fifo")],
                        ["--config", self.at("fifo")]):
            self.refused(*options, says=[self.at("fifo"), "FIFO"])

    def test_a_fifo_as_spectrum(self):
        os.mkfifo(self.at("buoy.data_spec"))
        with Daemon("--spectra", self.folder) as daemon:
            answer = daemon.patch({"sea": {"spectrum": "MEASURED",
                                           "measured": "buoy"}})
            self.assertEqual(answer.status, 400, answer)
            self.assertIn("FIFO", answer.body.decode())

    def test_clients(self):
        os.mkfifo(self.at("fifo"))
        ctl = os.path.join(BIN, "pelagosctl")
        server = socket.create_server(("127.0.0.1", 0))
        self.addCleanup(server.close)
        for command, variables in (
                (["replay", self.at("fifo")], {}),
                (["--server", f"tcp:127.0.0.1:{server.getsockname()[1]}",
                  "get", "sea"], {"PELAGOS_TOKEN_FILE": self.at("fifo")})):
            result = subprocess.run([ctl, *command], capture_output=True,
                                    text=True, timeout=SLOW_S,
                                    env={**os.environ, **variables})
            self.assertGreater(result.returncode, 0)
            self.assertIn(self.at("fifo"), result.stderr)

    def test_a_port_in_use(self):
        for kind, options in (
                (socket.SOCK_STREAM, ("--http", "--tcp", "--rtsp", "--modbus",
                                      "--nmea-tcp")),
                (socket.SOCK_DGRAM, ("--nmea", "--cigi"))):
            with socket.socket(socket.AF_INET, kind) as taken:
                taken.bind(("127.0.0.1", 0))
                if kind == socket.SOCK_STREAM:
                    taken.listen()
                port = taken.getsockname()[1]
                for option in options:
                    self.refused(option, f"127.0.0.1:{port}",
                                 says=[option + ":", str(port), "in use",
                                       "another"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
