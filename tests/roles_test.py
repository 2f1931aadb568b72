#!/usr/bin/python3
"""Each route and command with each role, as a client that tries everything:
what is beyond a role is refused, and changes nothing."""
import os
import re
import sys
import tempfile
import unittest

from pelagos_daemon import ROOT, Daemon, Session

TOKENS = {role: f"{role}-token-0123456789" for role in
          ("watch", "steer", "instruct")}
ORDER = ["watch", "steer", "instruct"]
ROUTE = re.compile(r'PEL_ROUTE\("(\w+)",\s*"([^"]*)",\s*([^,]*),')
LEAST = re.compile(r'PEL_ROLE_ROUTE\((\w+), "(\w+)", "([^"]+)"\)')
# Opens a stream, or ends nowhere.
STREAMS = ("mjpeg", "/ts", "/live")


def read(name):
    with open(os.path.join(ROOT, "proto", name), encoding="utf-8") as file:
        return file.read()


def routes():
    """Method, pattern, and the least role by the table and its rule."""
    named = {(m, p): r.lower() for r, m, p in LEAST.findall(read("roles.def"))}
    for method, pattern, flags in ROUTE.findall(read("routes.def")):
        if "ROUTE_OPEN" not in flags:
            yield method, pattern, named.get(
                (method, pattern),
                "watch" if method == "GET" else "instruct")


class Roles(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.file = cls.write("".join(f"{t} {r} of-{r}\n"
                                     for r, t in TOKENS.items()))
        cls.daemon = Daemon("--token-file", cls.file)

    @classmethod
    def tearDownClass(cls):
        cls.daemon.stop()
        cls.folder.cleanup()

    @classmethod
    def write(cls, text):
        path = os.path.join(cls.folder.name, "tokens")
        with open(path, "w") as file:
            file.write(text)
        os.chmod(path, 0o600)
        return path

    def request(self, role, method, path, body=None):
        return self.daemon.request(method, path, body, headers={
            "Authorization": "Bearer " + TOKENS[role],
            "Content-Type": "application/json"})

    def state(self):
        return self.request("instruct", "GET", "/v1/state").json()

    def test_a_session_says_what_the_table_says(self):
        fields = re.findall(r'^PEL_ROLE_FIELD\((\w+), "([^"]+)"\)',
                            read("roles.def"), re.M)
        for role in ORDER:
            answer = self.request(role, "GET", "/v1/session").json()
            mine = ORDER[:ORDER.index(role) + 1]
            self.assertEqual(answer["role"], role)
            self.assertEqual(answer["routes"], [
                f"{method} {pattern}" for method, pattern, least in routes()
                if least in mine])
            self.assertEqual(answer["fields"], ["*"] if role == "instruct" else
                             [path for least, path in fields
                              if least.lower() in mine])
        self.assertEqual(self.daemon.get("/v1/session").status, 401)

    def test_every_route(self):
        tried = set()
        before = self.state()["revision"]
        for method, pattern, least in routes():
            if pattern.endswith(STREAMS):
                continue
            path = "/" + (pattern.replace("{view}", "nobody")
                          .replace("{ending}", "json").replace("{path}", "sea")
                          .replace("{question}", "brdf")
                          .replace("{preset}", "x").replace("{exercise}", "x"))
            for role in ORDER[:ORDER.index(least)]:
                answer = self.request(role, method, path,
                                      None if method in ("GET", "DELETE")
                                      else "{}")
                self.assertEqual(answer.status, 403, (role, method, path))
                problem = answer.json()
                self.assertEqual(problem["code"], "FORBIDDEN")
                self.assertIn(f"needs the role {least}", str(problem))
                tried.add((role, method))
            if method == "GET" and "frame" not in pattern:
                self.assertNotIn(
                    self.request(least, method, path).status, (401, 403),
                    (least, method, path))
        self.assertEqual(self.state()["revision"], before)
        for each in (("watch", "PATCH"), ("steer", "PUT"), ("steer", "POST"),
                     ("steer", "DELETE"), ("watch", "POST")):
            self.assertIn(each, tried)

    def test_what_a_helmsman_may(self):
        for body in ({"ownShip": {"rudder": 5, "throttle": 0.5}},
                     {"entities": {"1": {"speed": 3}}},
                     {"views": {"bridge": {"yaw": 20}}}):
            self.assertEqual(self.request("steer", "PATCH", "/v1/state",
                                          body).status, 200, body)
            self.assertEqual(self.request("watch", "PATCH", "/v1/state",
                                          body).status, 403, body)
        for body, path in (
                ({"sea": {"windSpeed": 20}}, "sea.windSpeed"),
                ({"ownShip": {"rudder": 9}, "clock": {"rate": 5}},
                 "clock.rate"),
                ({"entities": {"7": {"speed": 3}}}, "entities.7"),
                ({"views": {"bridge": None}}, "views.bridge"),
                ({"entities": []}, "entities"),
                ({"exercise": {"mark": 1}}, "exercise.mark")):
            before = self.state()["revision"]
            answer = self.request("steer", "PATCH", "/v1/state", body)
            self.assertEqual(answer.status, 403, body)
            self.assertEqual(answer.json()["path"], path)
            self.assertEqual(self.state()["revision"], before)

    def test_every_command(self):
        commands = {"get": {}, "patch": {"state": {"sea": {"wind_speed": 9}}},
                    "step": {"seconds": 1}, "surface": {}, "spectrum": {},
                    "models": {"name": "nobody"}, "exercise": {},
                    "place": {"view": "bridge", "node": "a"},
                    "recording": {"stop": True}, "debrief": {"close": True}}
        least = {name: "watch" for name in
                 ("get", "surface", "spectrum", "models")}
        for role in ORDER:
            for name, command in commands.items():
                with Session(self.daemon.connect_tcp()) as session:
                    self.assertTrue(session.ask(login={
                        "token": TOKENS[role]}).HasField("state"))
                    reply = session.ask(**{name: command})
                    forbidden = (reply.HasField("error") and
                                 reply.error.code ==
                                 session.pb.FORBIDDEN)
                    self.assertEqual(
                        forbidden, ORDER.index(role) <
                        ORDER.index(least.get(name, "instruct")),
                        (role, name, reply))
                    # The session goes on.
                    self.assertTrue(session.ask(get={}).HasField("state"))

    def test_what_is_to_come_is_the_instructors(self):
        """By no way of reading the state."""
        secret = "Man overboard at ten"
        self.assertEqual(self.request("instruct", "PUT", "/v1/presets/next", {
            "title": secret, "patch": '{"sea":{"windSpeed":21}}'}).status, 201)
        for role in ORDER:
            sees = role == "instruct"
            for path in ("/v1/state", "/v1/presets", "/v1/presets/next",
                         "/v1/state/presets", "/v1/state/presets.next.title",
                         "/v1/state/presets/next/patch"):
                answer = self.request(role, "GET", path)
                self.assertEqual(secret.encode() in answer.body or
                                 b"windSpeed" in answer.body and
                                 "patch" in path, sees, (role, path))
                if path != "/v1/state":
                    self.assertEqual(answer.status, 200 if sees else 403)
            self.assertEqual("exercise" in self.request(
                role, "GET", "/v1/state").json(), sees)
            with Session(self.daemon.connect_tcp()) as session:
                replies = [session.ask(login={"token": TOKENS[role]}),
                           session.ask(watch={})]
                self.request("instruct", "PATCH", "/v1/state",
                             {"sea": {"windSpeed": 9 + ORDER.index(role)}})
                replies.append(session.receive())
                for reply in replies:
                    self.assertEqual(len(reply.state.presets), int(sees))
                    self.assertEqual(reply.state.HasField("exercise"), sees)
        answer = self.request("steer", "PATCH", "/v1/state",
                              {"ownShip": {"rudder": 4}})
        self.assertNotIn(secret.encode(), answer.body)
        self.request("instruct", "DELETE", "/v1/presets/next")

    def test_who_one_is(self):
        for role in ORDER:
            self.assertEqual(self.request(role, "GET",
                                          "/healthz").json()["role"], role)
        self.assertNotIn("role", self.daemon.get("/healthz").json())
        self.assertEqual(self.daemon.get("/v1/state").status, 401)
        mixed = TOKENS["watch"][:-1]
        self.assertEqual(self.daemon.get("/v1/state", headers={
            "Authorization": "Bearer " + mixed}).status, 401)


class Files(unittest.TestCase):
    def test_bad_ones_name_the_line(self):
        import subprocess
        import pelagos_daemon
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "t")
            good = "a" * 20
            for text, says in (
                    (f"{good} watch\nshort steer\n", "line 2: a token has"),
                    (f"{good} captain\n", "line 1: after the token"),
                    (f"{good} watch\n{'b' * 20}\n", "line 2: after the token"),
                    (f"{good} watch me too\n", "line 1: after the role"),
                    (f"{good} watch\n{good} steer\n", "line 2: the token"),
                    ("# nobody\n\n", "must have a line"),
                    ("".join(f"{i:020d} watch\n" for i in range(65)),
                     "more than 64")):
                with open(path, "w") as file:
                    file.write(text)
                os.chmod(path, 0o600)
                done = subprocess.run(
                    [os.path.join(pelagos_daemon.BIN, "pelagosd"),
                     "--token-file", path, "--http", "127.0.0.1:0", "--tcp",
                     "127.0.0.1:0", "--rtsp", "off", "--modbus", "off",
                     "--nmea", "off", "--device", "software"],
                    capture_output=True, text=True,
                    timeout=pelagos_daemon.SLOW_S)
                self.assertEqual(done.returncode, 1, text)
                self.assertIn(says, done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2, argv=sys.argv)
