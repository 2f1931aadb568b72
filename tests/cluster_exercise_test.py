#!/usr/bin/python3
"""An exercise of events on several nodes: the one that takes over goes on with
it at the exact place, without anybody's loading it again."""
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import cluster_case as case
from pelagos_daemon import BIN, Session, until

STATE = {"clock": {"reckoning": 100000}, "origin": {
    "latitude": 52.6, "longitude": 5.2}, "sea": {
        "windSpeed": 6, "synthesiser": "TROCHOIDS"}, "entities": [
            {"id": 1, "latitude": 52.6, "longitude": 5.2, "speed": 8,
             "course": 0, "heading": 0}]}


def event(name, number, **when):
    """Says in the state that it happened, by a field of its own."""
    return {"name": name, "when": [when], "patch": {"state": {
        "sky": {"visibility": 1000 + number}}}}


EVENTS = [event("first", 1, at=1), event("second", 2, at=4),
          event("third", 3, after="second", delay=2.5),
          # 100 m at 8 m/s
          event("north", 4, northOf=52.6 + 100 / 111195)]
# When each takes effect, which no take-over may change: exercise time [s].
WHEN = {"first": 1, "second": 4, "third": 6.5, "north": 12.5}


class Case(unittest.TestCase):
    def setUp(self):
        self.store = case.Store()
        self.addCleanup(self.store.stop)
        self.folder = tempfile.mkdtemp(prefix="pelagos-exercises-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.nodes = []

    def write(self, node, **change):
        folder = os.path.join(self.folder, node)
        os.makedirs(folder, exist_ok=True)
        with open(os.path.join(folder, "drill.json"), "w") as file:
            json.dump({"state": STATE, "events": EVENTS, **change}, file)
        return folder

    def begin(self, name, *options):
        folder = os.path.join(self.folder, name)
        os.makedirs(folder, exist_ok=True)
        node = case.Node(name, self.store, "--exercises", folder, *options)
        self.addCleanup(node.stop)
        self.nodes.append(node)
        until(f"{name} takes part", lambda: node.is_master() or node.follows())
        return node

    def watch(self):
        log = case.Log(self.store.members[0])
        self.addCleanup(log.stop)
        return log

    def do(self, node, action, status=200, **more):
        answer = node.request("POST", "/v1/exercise",
                              {"action": action, **more})
        self.assertEqual(answer.status, status, answer.body)
        return answer.json()

    def status(self, node):
        return node.get("/v1/exercise").json()

    def done(self, node):
        return {e["event"]: e for e in self.status(node)["run"].get(
            "events", ())}

    def lacks(self, node, of):
        """What the nodes say of `of`, once they say the present."""
        return next((n.get("lacks") for n in node.cluster().get("nodes", ())
                     if n["name"] == of), None)


    def fired(self, log):
        names = {1001 + i: e["name"] for i, e in enumerate(EVENTS)}
        return [names[int(patch.state.sky.visibility)]
                for _, patch in log.commands()
                if patch.state.HasField("sky")
                and int(patch.state.sky.visibility) in names]


class TakeOver(Case):
    def test_it_goes_on_at_the_exact_place(self):
        """Two masters die in the middle, of three nodes: each event happens
        once, when the file says."""
        for name in "abc":
            self.write(name)
        nodes = [self.begin(name) for name in "abc"]
        log = self.watch()
        a, b, c = nodes
        self.do(a, "LOAD", name="drill")
        self.do(a, "START")
        until("the first event", lambda: "first" in self.done(b))
        self.assertFalse(self.status(b)["leads"])
        a.kill()
        until("b takes over", b.is_master)
        self.assertTrue(self.status(b)["leads"], b.log())
        self.assertIn("EXR-011", b.log())
        until("the second event", lambda: "second" in self.done(b), 30)
        b.kill()
        until("c takes over", c.is_master)
        until("the last event", lambda: "north" in self.done(c), 60)
        # A master's status may be ahead of the seals.
        until("the log tells it", lambda: "north" in self.fired(log))
        self.assertEqual(self.fired(log), sorted(WHEN, key=WHEN.get))
        done = self.done(c)
        for name, time_s in WHEN.items():
            self.assertEqual(done[name].get("count"), 1, name)
            # `north` depends on motion, which each frame's time samples.
            self.assertAlmostEqual(done[name]["time"], time_s, delta=(
                0.11 if name == "north" else 1e-9), msg=name)
        log.check()

    def test_what_stands_goes_on_to_stand(self):
        """Loaded and paused exercises are the next master's to start, pause
        and rewind."""
        for name in "ab":
            self.write(name)
        a, b = self.begin("a"), self.begin("b")
        self.do(a, "LOAD", name="drill")
        for action in ("START", "PAUSE", "STOP", "REWIND", "LOAD"):
            problem = self.do(b, action, status=409, name="drill", time=0)
            self.assertIn("node a", problem["detail"], action)
        until("it is loaded", lambda: self.status(b)["run"][
            "phase"] == "READY")
        a.kill()
        until("b takes over", b.is_master)
        self.do(b, "START")
        until("the first event", lambda: "first" in self.done(b))
        self.do(b, "PAUSE")
        paused = self.status(b)["time"]
        self.write("a")
        back = self.begin("a")
        b.kill()
        until("a takes over", back.is_master)
        status = self.status(back)
        self.assertEqual(status["run"]["phase"], "PAUSED")
        self.assertEqual(status["time"], paused)
        self.do(back, "START")
        until("the second event", lambda: "second" in self.done(back), 30)
        earliest = self.status(back)["earliest"]
        self.assertEqual(earliest, paused)
        self.do(back, "REWIND", time=paused)
        self.assertEqual(sorted(self.done(back)), ["first"])

    def test_what_is_answered_is_sealed(self):
        """By HTTP and by protobuf: at the answer the store has the edit."""
        self.write("a")
        a = self.begin("a")
        log = self.watch()
        self.do(a, "LOAD", name="drill")
        # Its status may be ahead of the seals by a frame.
        until("it is loaded", lambda: [
            n for n, p in log.commands() if p.state.exercise.name == "drill"
            and n <= int(a.cluster()["frame"])])
        with Session(a.connect_tcp()) as session:
            def by_protobuf(action):
                reply = session.ask(exercise=session.pb.ExerciseCommand(
                    action=session.pb.ExerciseAction.Value(action)))
                self.assertEqual(reply.WhichOneof("result"), "exercise")
            for ask in [by_protobuf, lambda action: self.do(a, action)] * 5:
                for action in ("START", "PAUSE"):
                    before = int(a.cluster()["frame"])
                    ask(action)
                    number = log.pb.SealedFrame.FromString(
                        self.store.get("bridge/log")).seal.number
                    until("the log tells it", lambda n=number:
                          log.last() >= n)
                    phases = [p.state.exercise.phase for n, p in log.commands()
                              if before < n <= number
                              and p.state.exercise.HasField("phase")]
                    self.assertEqual(len(phases), 1, (ask, action))

    def test_who_lacks_the_file_says_so(self):
        self.write("a")
        self.write("c", title="another")
        a, b, c = (self.begin(name) for name in "abc")
        self.do(a, "LOAD", name="drill")
        self.do(a, "START")
        until("b says it", lambda: "is no exercise" in (
            self.lacks(a, "b") or ""))
        until("c says it", lambda: "another one" in (self.lacks(a, "c") or ""))
        self.assertIsNone(self.lacks(b, "a"))
        self.assertIn("EXR-012", b.log())
        self.assertIn("EXR-012", c.log())
        done = subprocess.run(
            [os.path.join(BIN, "pelagosctl"), "--server",
             f"tcp:127.0.0.1:{a.tcp_port}", "cluster"],
            capture_output=True, text=True, check=True)
        self.assertRegex(done.stdout, r"(?m)^b .*lacks exercise drill: ")
        self.write("c")  # and now it has it
        until("c has it", lambda: self.lacks(a, "c") is None)
        # A copy that is there stays, whatever becomes of the file.
        self.write("c", title="another")
        b.stop()
        a.kill()
        until("c takes over", c.is_master)
        self.assertTrue(self.status(c)["leads"], c.log())

    def test_who_lacks_the_file_takes_over_all_the_same(self):
        self.write("a")
        a, b = self.begin("a"), self.begin("b")
        self.do(a, "LOAD", name="drill")
        self.do(a, "START")
        until("b says it", lambda: self.lacks(a, "b"))
        a.kill()
        until("b takes over", b.is_master)
        self.assertIn("EXR-013", b.log())
        self.assertFalse(self.status(b)["leads"])
        until("it is told", lambda: self.lacks(b, "b"))
        self.write("b")
        self.do(b, "LOAD", name="drill")
        self.assertTrue(self.status(b)["leads"])
        until("nothing is lacking", lambda: not self.lacks(b, "b"))


if __name__ == "__main__":
    if not case.has_etcd():
        print("SKIP: no etcd")
        sys.exit(77)
    unittest.main(verbosity=2)
