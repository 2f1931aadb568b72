#!/usr/bin/python3
"""Exercises over the interfaces of a daemon: the examples run, the same
whatever the steps; they go on after a kill and after a rewind; the facts are
those of a computation of its own; pelagosctl."""
import csv
import io
import json
import math
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

import pelagos_daemon
from pelagos_daemon import ROOT, Daemon, Session, until

EXERCISES = os.path.join(ROOT, "clients/exercises")
CTL = os.path.join(pelagos_daemon.BIN, "pelagosctl")
EARTH_M = 6371008.8


class Case(unittest.TestCase):
    def setUp(self):
        self.place = tempfile.mkdtemp(prefix="pelagos-exercise-")
        self.addCleanup(shutil.rmtree, self.place, ignore_errors=True)
        self.folder = os.path.join(self.place, "exercises")
        os.mkdir(self.folder)
        for name in os.listdir(EXERCISES):
            self.take(name)

    def take(self, name):
        """The example without its models, which take seconds to make."""
        with open(os.path.join(EXERCISES, name)) as file:
            exercise = json.load(file)
        for entity in exercise["state"]["entities"].values():
            entity.pop("model", None)
            entity.pop("mooring", None)
            entity.pop("afloat", None)
        with open(os.path.join(self.folder, name), "w") as file:
            json.dump(exercise, file)

    def daemon(self, *options):
        daemon = Daemon(f"--exercises={self.folder}", *options)
        self.addCleanup(daemon.stop)
        return daemon

    def do(self, daemon, action, status=200, **more):
        answer = daemon.request("POST", "/v1/exercise",
                                {"action": action, **more})
        self.assertEqual(answer.status, status, answer.body)
        return answer.json()

    def begin(self, daemon, name):
        daemon.patch({"clock": {"mode": "STEPPED"}})
        self.do(daemon, "LOAD", name=name)
        self.assertEqual(daemon.state()["exercise"]["phase"], "READY")
        self.do(daemon, "START")

    def go(self, daemon, to, step=10):
        now = daemon.state()["clock"]["time"]
        while now < to:
            now = min(now + step, to)
            answer = daemon.request("POST", "/v1/clock/step", {"until": now})
            self.assertEqual(answer.status, 200, answer.body)

    def facts(self, daemon, ship=None):
        answer = daemon.get("/v1/exercise.csv" +
                            ("" if ship is None else f"?ship={ship}"))
        self.assertEqual(answer.status, 200)
        return answer.body.decode()

    def rows(self, daemon, ship=None):
        return list(csv.DictReader(io.StringIO(self.facts(daemon, ship))))

    def events(self, daemon):
        return {e["event"]: e["time"]
                for e in daemon.state()["exercise"].get("events", [])
                if e.get("count")}

    def picture(self, daemon):
        answer = daemon.get("/v1/views/bridge/frame.png?width=160&height=90",
                            timeout=10 * pelagos_daemon.SLOW_S)
        self.assertEqual(answer.status, 200)
        return pixels(answer.body)


def pixels(png):
    """The picture itself: what is said of it names the revision."""
    out, at = b"", 8
    while at < len(png):
        size = int.from_bytes(png[at:at + 4], "big")
        if png[at + 4:at + 8] == b"IDAT":
            out += png[at + 8:at + 8 + size]
        at += 12 + size
    return out


class Running(Case):
    def test_steps_do_not_matter(self):
        """Log, facts and picture, to the bit."""
        outcomes = []
        for step in (10, 0.73):
            record = os.path.join(self.place, f"log-{step}")
            daemon = self.daemon(f"--record={record}")
            self.begin(daemon, "crossing")
            self.go(daemon, 130, step)
            outcomes.append((self.facts(daemon), self.picture(daemon),
                             self.events(daemon)))
            daemon.stop()
            outcomes[-1] += (self.patches(record),)
        self.assertEqual(outcomes[0][2], outcomes[1][2])
        self.assertEqual(outcomes[0][2]["fog"], 60)
        self.assertIn("close-quarters", outcomes[0][2])
        self.assertEqual(outcomes[0][0], outcomes[1][0])
        self.assertEqual(outcomes[0][1], outcomes[1][1])
        # Before it was loaded time ran by itself.
        first, second = (o[3][2:] for o in outcomes)
        self.assertEqual(first, second)
        self.assertGreater(len(first), 15)

    def patches(self, record):
        """Every edit of a log and when it took effect."""
        pb = pelagos_daemon.schema()
        with open(record, "rb") as file:
            data = file.read()
        out = []
        for entry in map(pb.LogEntry.FromString,
                         pelagos_daemon.log_entries(data)):
            if entry.HasField("patch"):
                out.append((entry.time, entry.patch.SerializeToString()))
        return out

    def test_seas_of_events_are_built_aside(self):
        """A step across events that ask for FFT seas is answered when they
        were built, by another thread than the one that serves everybody; over
        HTTP and protobuf, by one step or many the same facts."""
        entities = [{"id": 1, "latitude": 52.6, "longitude": 5.2}]
        with open(os.path.join(self.folder, "seas.json"), "w") as file:
            json.dump({"state": {
                "sea": {"synthesiser": "FFT", "windSpeed": 8},
                "ownShip": {"on": True, "throttle": 0.5},
                "entities": entities}, "events": [
                {"name": "gale", "when": [{"at": 3}],
                 "patch": {"state": {"sea": {"windSpeed": 17}}}},
                {"name": "veers", "when": [{"after": "gale", "delay": 2}],
                 "patch": {"state": {"sea": {"windDirection": 310}}}}]}, file)
        facts = []
        for way in ("http", "protobuf", "small"):
            daemon = self.daemon()
            self.begin(daemon, "seas")
            # Its first sea is built by who looks at it first.
            daemon.request("POST", "/v1/surface", {"points": [[0, 0]]})
            before = self.built(daemon)
            if way == "http":
                self.go(daemon, 9)
            elif way == "small":
                self.go(daemon, 9, 0.4)
            else:
                with Session(daemon.connect_tcp()) as session:
                    reply = session.ask(step={"seconds": 9})
                self.assertEqual(reply.state.clock.time, 9)
                self.assertEqual(reply.state.sea.wind_speed, 17)
            state = daemon.state()
            self.assertEqual((state["clock"]["time"], state["sea"]["windSpeed"],
                              state["sea"]["windDirection"]), (9, 17, 310))
            self.assertEqual(self.events(daemon), {"gale": 3, "veers": 5})
            self.assertEqual(self.built(daemon), before,
                             "seas were built by the control thread")
            self.assertEqual(daemon.metrics()["pelagos_scene_prepared_total"],
                             2)
            facts.append(self.facts(daemon))
        self.assertEqual(facts[0], facts[1])
        self.assertEqual(facts[0], facts[2])

    def built(self, daemon):
        return daemon.metrics().get(
            'pelagos_control_work_total{what="sea"}', 0)

    def test_a_replay_needs_no_exercises(self):
        record = os.path.join(self.place, "log")
        daemon = self.daemon(f"--record={record}")
        self.begin(daemon, "blackout")
        self.go(daemon, 100)
        state, picture = daemon.state(), self.picture(daemon)
        daemon.stop()
        with Daemon() as other:
            subprocess.run([CTL, "--server", f"tcp:127.0.0.1:{other.tcp_port}",
                            "--quiet", "replay", record], check=True,
                           timeout=pelagos_daemon.SLOW_S * 5)
            replayed = other.state()
            for each in (state, replayed):
                del each["revision"]
            self.assertEqual(replayed, state)
            self.assertEqual(self.picture(other), picture)

    def test_it_goes_on_after_a_kill(self):
        """The ships of "crossing" sail by their helms and go on from the last
        mark; here they are reckoned, and go on to the bit."""
        self.without_helm("crossing")
        state = os.path.join(self.place, "state")
        straight = self.daemon()
        self.begin(straight, "crossing")
        self.go(straight, 150)
        daemon = self.daemon(f"--state={state}")
        self.begin(daemon, "crossing")
        self.go(daemon, 95.5, 0.5)
        daemon.stop(signal.SIGKILL)
        daemon = self.daemon(f"--state={state}")
        self.assertEqual(daemon.state()["clock"]["time"], 95.5)
        self.assertTrue(daemon.get("/v1/exercise").json()["leads"])
        self.go(daemon, 150)
        self.assertEqual(self.facts(daemon), self.facts(straight))
        self.assertEqual(self.events(daemon), self.events(straight))
        self.assertEqual(self.picture(daemon), self.picture(straight))

    def without_helm(self, name):
        path = os.path.join(self.folder, name + ".json")
        with open(path) as file:
            exercise = json.load(file)
        exercise["state"]["ownShip"]["on"] = False
        with open(path, "w") as file:
            json.dump(exercise, file)

    def test_rewound_it_is_the_same_again(self):
        daemon = self.daemon()
        self.begin(daemon, "blackout")
        self.go(daemon, 130)
        facts, picture = self.facts(daemon), self.picture(daemon)
        self.assertIn("blackout", self.events(daemon))
        for time in (101.3, 0):
            answer = self.do(daemon, "REWIND", time=time)
            self.assertEqual(answer["time"], time)
            self.assertEqual(daemon.state()["clock"]["time"], time)
            self.do(daemon, "START")
            self.go(daemon, 130)
            self.assertEqual(self.facts(daemon), facts)
            self.assertEqual(self.picture(daemon), picture)
        problem = self.do(daemon, "REWIND", time=131, status=400)
        self.assertEqual((problem["path"], problem["maximum"]), ("time", 130))

    def test_the_examples_as_they_are(self):
        with Daemon(f"--exercises={EXERCISES}") as daemon:
            for name in os.listdir(EXERCISES):
                self.begin(daemon, name.removesuffix(".json"))
                self.go(daemon, 20)
                self.assertEqual(len(self.facts(daemon).splitlines()), 22)

    def test_time_that_runs_by_itself(self):
        daemon = self.daemon()
        daemon.patch({"clock": {"mode": "FREE", "rate": 40}})
        self.do(daemon, "LOAD", name="crossing")
        self.do(daemon, "START")
        until("fog", lambda: "fog" in self.events(daemon))
        self.do(daemon, "PAUSE")
        time = daemon.state()["clock"]["time"]
        self.assertEqual(daemon.state()["clock"]["time"], time)
        self.do(daemon, "REWIND", time=30)
        self.assertNotIn("fog", self.events(daemon))
        self.assertEqual(daemon.state()["clock"]["mode"], "FREE")
        self.do(daemon, "START")
        until("fog again", lambda: self.events(daemon).get("fog") == 60)
        self.do(daemon, "STOP")
        self.assertEqual(daemon.state()["clock"]["rate"], 40)


class Facts(Case):
    def test_they_are_those_of_a_computation_of_its_own(self):
        """Ranges, CPA and TCPA on the sphere from the places in the rows."""
        daemon = self.daemon()
        self.begin(daemon, "crossing")
        self.go(daemon, 240)
        target = {e["id"]: e for e in daemon.state()["entities"]}[3]
        rows = list(csv.DictReader(io.StringIO(self.facts(daemon))))
        self.assertEqual([float(r["time_s"]) for r in rows],
                         [float(t) for t in range(241)])
        closest = math.inf
        for row in rows:
            time = float(row["time_s"])
            east, north = plane(float(row["latitude_deg"]),
                                float(row["longitude_deg"]),
                                *reckon(target, time))
            own = vector(float(row["speed_mps"]), float(row["course_deg"]))
            other = vector(target["speed"], target["course"])
            u, v = other[0] - own[0], other[1] - own[1]
            tcpa = -(east * u + north * v) / (u * u + v * v)
            cpa = math.hypot(east + u * tcpa, north + v * tcpa)
            distance = math.hypot(east, north)
            closest = min(closest, distance)
            # The sphere against the ellipsoid: 0.4 %.
            self.assertAlmostEqual(float(row["range_3_m"]), distance,
                                   delta=0.004 * distance)
            self.assertAlmostEqual(float(row["cpa_3_m"]), cpa,
                                   delta=0.004 * distance + 1)
            self.assertAlmostEqual(float(row["tcpa_3_s"]), tcpa,
                                   delta=0.01 * abs(tcpa) + 2)
            self.assertAlmostEqual(float(row["closest_3_m"]), closest,
                                   delta=0.004 * closest)
        self.assertGreater(float(rows[-1]["over_limit_s"]), 0)
        self.assertIn("fog", rows[60]["events"])
        fastest = max(float(r["speed_mps"]) for r in rows)
        self.assertEqual(float(rows[-1]["speed_max_mps"]), fastest)

    def test_grounding_is_counted(self):
        daemon = self.daemon()
        self.begin(daemon, "blackout")
        self.go(daemon, 402)
        rows = list(csv.DictReader(io.StringIO(self.facts(daemon))))
        afloat = [r for r in rows if r["aground"] == "0"]
        self.assertEqual(float(afloat[0]["under_keel_m"]), 6 - 3.6)
        self.assertEqual(rows[-1]["aground"], "1")
        self.assertEqual(rows[-1]["groundings"], "1")
        self.assertEqual(float(rows[-1]["under_keel_min_m"]), -0.1)


class Ships(Case):
    """Several own ships."""

    def test_two_bridges_meet(self):
        daemon = self.daemon()
        self.begin(daemon, "two-bridges")
        self.go(daemon, 150)
        first, second = self.rows(daemon, 1), self.rows(daemon, 7)
        self.assertEqual(self.rows(daemon), first)
        self.assertEqual(len(first), 151)
        events = self.events(daemon)
        over = {1: 0, 7: 0}
        level = 0
        for time, (one, seven) in enumerate(zip(first, second)):
            at = [float(row[f"{axis}_deg"]) for row in (one, seven)
                  for axis in ("latitude", "longitude")]
            distance = math.hypot(*plane(*at))
            for row, other in ((one, 7), (seven, 1)):
                # The sphere against the ellipsoid: 0.4 %.
                self.assertAlmostEqual(float(row[f"range_{other}_m"]),
                                       distance, delta=0.004 * distance + 0.1)
                self.assertEqual(row["collisions"], "0")
                self.assertEqual(float(row["time_s"]), time)
            for fact in ("range", "cpa", "hulls", "closest"):
                self.assertAlmostEqual(float(one[f"{fact}_7_m"]),
                                       float(seven[f"{fact}_1_m"]), delta=0.002)
            self.assertEqual(one["events"], seven["events"])
            level = -1 if time >= events["ebb"] else 0
            self.assertEqual(float(one["under_keel_m"]), round(
                9 + level - 2.1, 3))
            self.assertEqual(float(seven["under_keel_m"]), 9 + level - 6.5)
            # Both may go 5.5 m/s, ship 7 no more than 4.
            for ship, row, limit in ((1, one, 5.5), (7, seven, 4)):
                faster = max(0, float(row["speed_mps"]) - limit)
                over[ship] += time > 0 and faster > 0
                self.assertAlmostEqual(float(row["over_limit_mps"]), faster,
                                       delta=0.0011)
        self.assertEqual(level, -1)
        for ship, row in ((1, first[-1]), (7, second[-1])):
            self.assertEqual(float(row["over_limit_s"]), over[ship])
            self.assertGreater(over[ship], 5)
        # Events about ship 7, at the tenth of a second at which they are so.
        self.assertAlmostEqual(events["squat"], events["ebb"] + 0.1, places=6)
        south = next(float(r["time_s"]) for r in second
                     if float(r["latitude_deg"]) < 52.608)
        self.assertTrue(south - 1 < events["ebb"] <= south, (south, events))
        near = next(float(r["time_s"]) for r in second if float(
            r["cpa_1_m"]) < 100 and 0 < float(r["tcpa_1_s"]) < 60)
        self.assertTrue(near - 1 < events["close-quarters"] <= near,
                        (near, events))

    def test_a_ship_that_is_none_of_them(self):
        daemon = self.daemon()
        self.begin(daemon, "two-bridges")
        self.assertEqual(daemon.get("/v1/exercise").json()["ships"], [1, 7])
        self.go(daemon, 2)
        for ship, value in ((3, "3"), (0, "0"), (65536, "65536"), ("x", "x")):
            answer = daemon.get(f"/v1/exercise.csv?ship={ship}")
            self.assertEqual(answer.status, 400, answer.body)
            problem = answer.json()
            self.assertEqual((problem["path"], problem["value"]),
                             ("ship", value))
        self.assertIn("must be one of the own ships: 1 7",
                      self.do(daemon, "FACTS", ship=3, status=400)["detail"])
        answer = daemon.get("/v1/exercise.csv?ships=7")
        self.assertEqual((answer.status, answer.json()["path"]),
                         (400, "ships"))
        self.assertEqual(self.do(daemon, "FACTS", ship=7)["facts"],
                         self.facts(daemon, 7))
        self.assertEqual(self.do(daemon, "FACTS")["facts"],
                         self.facts(daemon, 1))
        with Session(daemon.connect_tcp()) as session:
            reply = session.ask(exercise={"action": "FACTS", "ship": 7})
            self.assertEqual(reply.exercise.facts, self.facts(daemon, 7))
            self.assertEqual(list(reply.exercise.ships), [1, 7])

    def test_further_ships_change_nothing_of_the_first(self):
        with open(os.path.join(self.folder, "crossing.json")) as file:
            exercise = json.load(file)
        exercise["ships"] = [{"id": 3, "draught": 1}, {"id": 2}]
        with open(os.path.join(self.folder, "more.json"), "w") as file:
            json.dump(exercise, file)
        facts = []
        for name in ("crossing", "more"):
            daemon = self.daemon()
            self.begin(daemon, name)
            self.go(daemon, 70)
            facts.append(self.facts(daemon))
        self.assertEqual(facts[0], facts[1])
        # Of ship 2 the targets are 1 and 3.
        self.assertEqual([name for name in self.rows(daemon, 2)[0]
                          if name.startswith("range")],
                         ["range_1_m", "range_3_m"])
        self.assertEqual(float(self.rows(daemon, 3)[5]["under_keel_m"]), 19)

    def test_they_go_on_after_a_kill(self):
        """At a mark, from which the helms go on to the bit."""
        state = os.path.join(self.place, "state")
        straight = self.daemon()
        self.begin(straight, "two-bridges")
        self.go(straight, 120)
        daemon = self.daemon(f"--state={state}")
        self.begin(daemon, "two-bridges")
        self.go(daemon, 90)
        daemon.stop(signal.SIGKILL)
        daemon = self.daemon(f"--state={state}")
        self.go(daemon, 120)
        for ship, path in ((1, ".exercise.csv"), (7, ".exercise.7.csv")):
            facts = self.facts(daemon, ship)
            self.assertEqual(facts, self.facts(straight, ship))
            with open(state + path) as file:
                self.assertEqual(file.read(), facts)
        self.do(daemon, "REWIND", time=95.5)
        self.assertEqual(len(self.rows(daemon, 7)), 96)
        self.do(daemon, "START")
        self.go(daemon, 120)
        for ship in (1, 7):
            self.assertEqual(self.facts(daemon, ship),
                             self.facts(straight, ship))
        # Another exercise leaves none of ship 7's.
        self.do(daemon, "STOP")
        daemon.stop(signal.SIGKILL)
        daemon = self.daemon(f"--state={state}")
        self.do(daemon, "LOAD", name="crossing")
        self.assertFalse(os.path.exists(state + ".exercise.7.csv"))
        self.assertTrue(os.path.exists(state + ".exercise.csv"))


def plane(lat0, lon0, lat1, lon1):
    mean = math.radians((lat0 + lat1) / 2)
    return (EARTH_M * math.radians(lon1 - lon0) * math.cos(mean),
            EARTH_M * math.radians(lat1 - lat0))


def vector(speed, course):
    return (speed * math.sin(math.radians(course)),
            speed * math.cos(math.radians(course)))


def reckon(entity, time):
    east, north = vector(entity["speed"], entity["course"])
    seconds = time - entity["poseTime"]
    lat = entity["latitude"] + math.degrees(north * seconds / EARTH_M)
    return lat, entity["longitude"] + math.degrees(
        east * seconds / EARTH_M / math.cos(math.radians(lat)))


class Interfaces(Case):
    def test_files(self):
        daemon = self.daemon()
        listed = daemon.get("/v1/exercises").json()["exercises"]
        self.assertEqual([e["name"] for e in listed],
                         ["blackout", "crossing", "two-bridges"])
        self.assertTrue(all("error" not in e for e in listed), listed)
        one = daemon.get("/v1/exercises/crossing").json()
        one["title"] = "Mine"
        self.assertEqual(daemon.request("PUT", "/v1/exercises/mine",
                                        one).status, 200)
        self.assertEqual(daemon.get("/v1/exercises/mine").json(), one)
        one["events"][0]["patch"]["state"]["sky"]["visibility"] = -1
        answer = daemon.request("PUT", "/v1/exercises/mine", one)
        self.assertEqual(answer.status, 400)
        self.assertEqual(answer.json()["path"],
                         "events.fog.patch.state.sky.visibility")
        self.assertEqual(daemon.get("/v1/exercises/mine").json()["title"],
                         "Mine")
        # A link within the directory is as the file, one out of it is refused.
        with tempfile.TemporaryDirectory() as outside:
            away = os.path.join(outside, "away.json")
            with open(away, "w") as file:
                json.dump({"title": "elsewhere"}, file)
            for name, target in (("away", away), ("within", "mine.json")):
                os.symlink(target, os.path.join(self.folder, name + ".json"))
            answer = daemon.get("/v1/exercises/away")
            self.assertGreaterEqual(answer.status, 400)
            self.assertIn("away.json is a link out of", answer.body.decode())
            self.assertEqual(daemon.get("/v1/exercises/within").json()["title"],
                             "Mine")
            for name in ("away", "within"):
                os.remove(os.path.join(self.folder, name + ".json"))
        for name in ("..%2Fstate", "a.b", "x" * 65, "-rf"):
            answer = daemon.request("PUT", f"/v1/exercises/{name}", {})
            self.assertEqual(answer.status, 400, name)
        # A command that is refused leaves the file.
        self.do(daemon, "DELETE", name="mine", time=-1, status=400)
        self.assertEqual(daemon.get("/v1/exercises/mine").status, 200)
        self.assertEqual(daemon.request("DELETE",
                                        "/v1/exercises/mine").status, 204)
        self.assertEqual(daemon.get("/v1/exercises/mine").status, 404)
        with open(os.path.join(self.folder, "bad.json"), "w") as file:
            file.write('{"draught": 99}')
        listed = daemon.get("/v1/exercises").json()["exercises"]
        self.assertEqual(listed[0]["name"], "bad")
        self.assertEqual(listed[0]["error"]["path"], "draught")
        self.do(daemon, "LOAD", name="bad", status=400)
        self.do(daemon, "PAUSE", status=409)

    def test_entities_by_their_numbers(self):
        """One form, with one meaning in a state, an event, a query, a PATCH;
        the arrays of older files keep theirs."""
        ship = {"latitude": 52.6, "longitude": 5.2}

        def outcome(state, patch):
            with open(os.path.join(self.folder, "map.json"), "w") as file:
                json.dump({"state": {"entities": state}, "events": [
                    {"name": "e", "when": [{"at": 1}],
                     "patch": {"state": {"entities": patch}}}]}, file)
            daemon = self.daemon()
            self.begin(daemon, "map")
            self.go(daemon, 2)
            return {e["id"]: (e["heading"], e.get("light", {}).get("character"))
                    for e in daemon.state()["entities"]}
        # As a PATCH does it.
        patched = self.daemon()
        patched.patch({"entities": {"1": ship, "2": {
            **ship, "heading": 90, "light": {"character": "F"}}, "3": ship}})
        change = {"1": {"heading": 7}, "2": {"light": None}, "3": None,
                  "4": {**ship, "heading": 11}}
        patched.patch({"entities": change})
        want = {e["id"]: (e["heading"], e.get("light", {}).get("character"))
                for e in patched.state()["entities"]}
        self.assertEqual(sorted(want), [1, 2, 4])
        begin = {"1": ship, "2": {**ship, "heading": 90,
                                  "light": {"character": "F"}}, "3": ship}
        self.assertEqual(outcome(begin, change), want)
        # An array in an event changes those that it names and no other.
        listed = [{"id": int(i), **e} for i, e in begin.items()]
        self.assertEqual(
            outcome(listed, [{"id": 1, "heading": 7}]),
            {1: (7, None), 2: (90, "F"), 3: (0, None)})
        answer = patched.request("POST", "/v1/spectrum", {"patch": {"state": {
            "views": {"bridge": {"yaw": 5}}, "sea": {"windSpeed": 3}}}})
        self.assertEqual(answer.status, 200, answer.body)

    def ctl(self, daemon, *words, expected=0):
        done = subprocess.run(
            [CTL, "--server", f"tcp:127.0.0.1:{daemon.tcp_port}", "exercise",
             *words], capture_output=True, text=True,
            timeout=pelagos_daemon.SLOW_S)
        self.assertEqual(done.returncode, expected, done.stderr)
        return done.stdout if expected == 0 else done.stderr

    def test_pelagosctl(self):
        daemon = self.daemon()
        daemon.patch({"clock": {"mode": "STEPPED"}})
        self.assertIn("Crossing in closing fog", self.ctl(daemon, "list"))
        shown = json.loads(self.ctl(daemon, "show", "crossing"))
        self.assertEqual(shown["events"][0]["name"], "fog")
        path = os.path.join(self.place, "mine.json")
        shown["events"][0]["when"][0]["at"] = 61
        with open(path, "w") as file:
            json.dump(shown, file)
        self.assertIn("good", self.ctl(daemon, "check", path))
        self.ctl(daemon, "save", "mine", path)
        self.ctl(daemon, "load", "mine")
        self.ctl(daemon, "start")
        self.go(daemon, 70)
        said = self.ctl(daemon)
        self.assertIn("mine: running, 70.0 s", said)
        self.assertIn("61.0 s  fog", said)
        self.ctl(daemon, "pause")
        self.ctl(daemon, "rewind", "12.5")
        self.assertIn("next: fog at 61.0 s", self.ctl(daemon, "status"))
        self.assertEqual(self.ctl(daemon, "facts").count("\n"), 14)
        self.assertEqual(self.ctl(daemon, "facts", "1"),
                         self.ctl(daemon, "facts"))
        self.assertIn("must be one of the own ships: 1",
                      self.ctl(daemon, "facts", "2", expected=4))
        self.assertIn("usage: pelagosctl exercise facts [SHIP]",
                      self.ctl(daemon, "facts", "1", "2", expected=2))
        self.assertIn("is no number of a ship",
                      self.ctl(daemon, "facts", "me", expected=2))
        self.ctl(daemon, "stop")
        self.ctl(daemon, "delete", "mine")
        self.assertIn("is no exercise",
                      self.ctl(daemon, "load", "mine", expected=4))
        self.assertIn("usage: pelagosctl exercise rewind SECONDS",
                      self.ctl(daemon, "rewind", expected=2))
        self.ctl(daemon, "dance", expected=2)
        shown["state"]["sea"]["windSpeed"] = 99
        with open(path, "w") as file:
            json.dump(shown, file)
        said = self.ctl(daemon, "check", path, expected=4)
        self.assertIn("state.sea.windSpeed is 99 m/s; it must be 0 to 30 m/s",
                      said)


if __name__ == "__main__":
    unittest.main(verbosity=2, argv=sys.argv)
