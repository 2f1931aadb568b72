#!/usr/bin/python3
"""An exercise that is recorded on its nodes, and its state kept beside etcd's:
one etcd, two daemons, a ship that sails, the master killed on the way. Each log
has what was sealed and nothing else; replays of all of them give the pictures
that the nodes showed."""
import contextlib
import http.client
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import cluster_case as case
from pelagos_daemon import BIN, SLOW_S, Daemon, log_entries, schema, until

NEVER = {"sea": {"windSpeed": 23.5}}  # of edits that nobody seals
AHEAD_S = 10.5  # from one whole state to the next, and a little


def entries_of(*paths):
    """Those of a log, in the order of its segments; a torn end is left out."""
    pb = schema()
    logs = []
    for path in paths:
        with open(path, "rb") as f:
            data = f.read()
        entries = [pb.LogEntry.FromString(entry)
                   for entry in log_entries(data)]
        assert entries[0].head.version == 2, entries[0].head.version
        logs.append(entries)
    logs.sort(key=lambda entries: entries[0].head.segment)
    return [entry for entries in logs for entry in entries]


def patches(entries):
    return [(e.time, e.revision, e.patch.SerializeToString(deterministic=True))
            for e in entries if e.HasField("patch")]


def segments(path):
    folder, name = os.path.split(path)
    return sorted(os.path.join(folder, n) for n in os.listdir(folder)
                  if n == name or n.startswith(name + ".0"))


class Pictures:
    """What the nodes showed: {time: [PNG, revision]}, and EXR of some."""

    def __init__(self):
        self.png, self.exr = {}, {}

    def take(self, node, kind="png"):
        answer = node.get(f"/v1/views/bridge/frame.{kind}")
        assert answer.status == 200, answer
        if answer.headers["X-Pelagos-Stale"] != "none":
            return
        moment = float(answer.headers["X-Pelagos-Time"])
        kept = self.png if kind == "png" else self.exr
        assert kept.setdefault(moment, answer.body) == answer.body, moment


class Recorded(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="pelagos-recorded-")
        self.addCleanup(shutil.rmtree, self.folder, True)
        self.store = case.Store()
        self.addCleanup(self.store.stop)
        self.log = case.Log(self.store.members[0])
        self.addCleanup(self.log.stop)
        self.pictures = Pictures()
        self.turn = 0

    def path(self, name):
        return os.path.join(self.folder, name)

    def begin(self, name, *options):
        os.makedirs(self.path(name), exist_ok=True)
        node = case.Node(name, self.store, "--state",
                         self.path(name + ".json"), "--record",
                         self.path(name + ".pelog"), "--recordings",
                         self.path(name), *options)
        self.addCleanup(node.stop)
        until(f"{name} takes part", lambda: node.is_master() or node.follows())
        return node

    def master(self, *nodes):
        return until("a master", lambda: next(
            (n for n in nodes if n.alive() and n.is_master()), None))

    def edit(self, change, *nodes):
        """By the master, and again where that has changed meanwhile, as it may
        on a machine that is starved."""
        for _ in range(10):
            answer = self.master(*nodes).patch(change)
            if answer.status != 409:
                break
        self.assertEqual(answer.status, 200, answer)
        return answer.json()

    @contextlib.contextmanager
    def etcd_stands(self, seconds):
        process = self.store.members[0].process
        process.send_signal(signal.SIGSTOP)
        begun = time.monotonic()
        yield
        time.sleep(max(0, seconds - (time.monotonic() - begun)))
        process.send_signal(signal.SIGCONT)

    def never_sealed(self, master):  # its edits wait for etcd
        """An edit that the master accepts while etcd stands; its answer comes
        into the list: a refusal, when it gives up, which a starved machine may
        see before it sees the edit."""
        answers = []
        time.sleep(0.2)  # a frame is under way, that has it not

        def send():
            with contextlib.suppress(OSError, http.client.HTTPException):
                answers.append(master.patch(NEVER))
        threading.Thread(target=send, daemon=True).start()
        until("it is accepted", lambda: answers or master.state()["sea"][
            "windSpeed"] == NEVER["sea"]["windSpeed"])
        self.assertLessEqual({answer.status for answer in answers}, {409})
        return answers

    def sail(self, seconds, *nodes):
        """Edits at various times, and pictures of all nodes meanwhile."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.turn += 1
            change = {"sky": {"sunElevation": 5 + self.turn % 50}}
            if self.turn % 5 == 0:
                change = {"ownShip": {"rudder": self.turn % 40 - 20}}
            elif self.turn % 7 == 0:
                change = {"sea": {"windSpeed": 5 + self.turn % 9}}
            last = self.edit(change, *nodes)
            for i, node in enumerate(nodes):
                self.pictures.take(node, "exr" if (self.turn + i) % 6 == 0
                                   else "png")
        return last

    def await_both(self, a, b):
        until("both take part", lambda: (a.is_master() and b.follows()) or (
            b.is_master() and a.follows()))

    def begin_two(self):
        """The first begins the exercise with its file, the other's is set
        aside."""
        for name, wind in (("a", 7.25), ("b", 3.5)):
            with Daemon("--state", self.path(name + ".json")) as alone:
                self.assertEqual(alone.patch({
                    "sea": {"windSpeed": wind}, "views": {"bridge": {
                        "width": 64, "height": 36, "up": 12}}}).status, 200)
        a = self.begin("a")
        self.assertEqual(a.state()["sea"]["windSpeed"], 7.25)
        b = self.begin("b")
        self.assertEqual(b.state()["sea"]["windSpeed"], 7.25)
        self.assertIn("SCN-020", b.log())
        self.assertNotIn("SCN-020", a.log())
        with open(self.path("b.json.aside")) as f:
            self.assertIn('"windSpeed": 3.5', f.read())
        self.assertFalse(os.path.exists(self.path("a.json.aside")))
        self.assertFalse(os.path.exists(self.path("a.json.journal")))
        return a, b

    def replayed(self, paths, times):
        """{time: PNG} of a daemon by itself."""
        out = tempfile.mkdtemp(dir=self.folder)
        with Daemon("--quality", "full") as alone:
            subprocess.run(
                [os.path.join(BIN, "pelagosctl"), "--timeout", f"{SLOW_S:g}",
                 "replay", *paths, "--view", "bridge", "--frames", out, "--at",
                 ",".join(repr(t) for t in times)],
                check=True, stdout=subprocess.DEVNULL, env={
                    **os.environ,
                    "PELAGOS_SERVER": f"tcp:127.0.0.1:{alone.tcp_port}"})
        drawn = sorted(os.listdir(out))
        self.assertEqual(len(drawn), len(times))
        pictures = {}
        for moment, name in zip(times, drawn):
            with open(os.path.join(out, name), "rb") as f:
                pictures[moment] = f.read()
        return pictures

    def check_log(self, name, paths):
        """What the log has is what was sealed in its time, but for frames that
        it says are missing."""
        entries = entries_of(*paths)
        runs = [[]]
        for entry in entries:
            runs += [[]] if entry.missed else []
            runs[-1].append(entry)
        last = max(e.revision for e in entries)
        until("etcd's log is told", lambda: any(
            e.revision >= last for _, f, _ in self.log.frames
            for e in f.entries))
        sealed = patches(e for _, f, _ in self.log.frames for e in f.entries)
        at = 0
        for mine in filter(None, map(patches, runs)):
            at = sealed.index(mine[0], at)
            self.assertEqual(mine, sealed[at:at + len(mine)], name)
            at += len(mine)
        return runs

    def check_replay(self, name, paths, runs):
        shown = self.pictures.png
        times = sorted(t for t in shown if any(
            run[0].time <= t <= run[-1].time for run in runs))
        self.assertGreater(len(times), 20)
        drawn = self.replayed(paths, times)
        for moment in times:
            self.assertEqual(drawn[moment], shown[moment], (name, moment))
        entries = sum(runs, [])
        print(f"{name}: {len(patches(entries))} edits, "
              f"{sum(e.HasField('state') for e in entries)} whole states, "
              f"{sum(e.missed for e in entries)} frames missing, "
              f"{len(times)} pictures are those that the nodes showed",
              flush=True)

    def check_debrief(self, node, name, runs):
        """On a node of the exercise, while it goes on: to and fro."""
        def settled():
            now = node.get("/v1/debrief").json()
            return now if not now["busy"] and now["state"] not in (
                "OPENING", "CLOSING") else None
        node.request("PATCH", "/v1/debrief", {"recording": name})
        now = until("it is open", settled)
        self.assertEqual(now["state"], "OPEN", now)
        places = [(kind, t) for kind in ("png", "exr")
                  for t in sorted(getattr(self.pictures, kind))
                  if any(run[0].time <= t <= run[-1].time for run in runs)]
        self.assertGreater(len(places), 20)
        places = places[::-7] + places[::7] + places[-1:]
        for kind, moment in places:
            node.request("PATCH", "/v1/debrief", {"time": moment})
            now = until("it is there", settled)
            self.assertNotIn("error", now)
            answer = node.get(f"/v1/debrief/views/bridge/frame.{kind}")
            self.assertEqual(answer.status, 200, answer)
            shown = getattr(self.pictures, kind)[moment]
            self.assertTrue(answer.body == shown, (kind, moment))
        print(f"debrief of {name}: {len(places)} moments to and fro",
              flush=True)

    def check_state(self, path, acknowledged, moment):
        """Without etcd: the last sealed state that was written."""
        with Daemon("--state", path) as alone:
            state = alone.state()
        self.assertNotEqual(state["sea"]["windSpeed"],
                            NEVER["sea"]["windSpeed"])
        self.assertEqual(state["revision"], acknowledged["revision"])
        for part in ("sky", "sea", "views", "seabed"):
            self.assertEqual(state.get(part), acknowledged.get(part))
        self.assertEqual(state["ownShip"]["rudder"],
                         acknowledged["ownShip"]["rudder"])
        self.assertGreater(state["clock"]["time"], moment - AHEAD_S)

    def test_it_is_recorded(self):
        a, b = self.begin_two()
        self.edit({"ownShip": {"on": True, "throttle": 0.6, "rudder": 5}}, a, b)
        self.sail(6, a, b)
        answer = b.request("POST", "/v1/recording", {"start": "late"})
        self.assertEqual(answer.status, 409, answer)  # --record has it
        for turn in range(12):
            last = self.sail(2 if turn else 9, a, b)
            killed = self.master(a, b)
            other = b if killed is a else a
            with self.etcd_stands(2.2):
                answers = self.never_sealed(killed)
                time.sleep(1.5)  # its file has what is sealed
                moment = float(killed.get("/v1/views/bridge/frame.png").headers[
                    "X-Pelagos-Time"])
                in_time = not answers
                if in_time:
                    killed.process.kill()
                    killed.process.wait()
            if in_time:
                break
            # On a machine that is starved it may have given up by then.
            self.assertEqual(answers[0].status, 409, answers[0])
            self.await_both(a, b)
        self.assertTrue(in_time, answers)
        until("the other takes over", other.is_master)
        self.check_state(self.path(killed.name + ".json"), last, moment)
        self.sail(12, other)
        other.stop()
        for node in (killed, other):
            mine = segments(self.path(node.name + ".pelog"))
            runs = self.check_log(node.name, mine)
            self.check_replay(node.name, mine, runs)
        self.assertTrue(runs[-1][-1].HasField("step"))  # ended in order
        self.assertGreaterEqual(sum(e.HasField("state") for e in runs[-1]), 1)

    def test_one_who_gives_up(self):
        """The master's log has no edit that it undid, and goes on; recordings
        begun by a client, a debrief on a node; one whose state was another for
        a frame has the log all the same."""
        a = self.begin("a")
        b = case.Node("b", self.store, "--recordings", self.folder)
        self.addCleanup(b.stop)
        until("b follows", b.follows)
        os.environ["PELAGOS_EXERCISE_STRAY"] = str(
            int(a.cluster()["frame"]) + 120)
        try:
            c = self.begin("c", "--exercise-rank", "-1")
        finally:
            del os.environ["PELAGOS_EXERCISE_STRAY"]
        self.edit({"views": {"bridge": {"width": 64, "height": 36, "up": 12}},
                   "ownShip": {"on": True, "throttle": 0.6, "rudder": 5}}, a, b)
        self.sail(3, a, b)
        answer = b.request("POST", "/v1/recording", {"start": "late"})
        self.assertEqual(answer.status, 200, answer)
        self.sail(3, a, b)
        with self.etcd_stands(4):
            answers = self.never_sealed(self.master(a, b))
            until("the client is told", lambda: answers)
        self.assertEqual(answers[0].status, 409, answers[0])
        self.await_both(a, b)
        self.sail(14, a, b)
        self.assertNotEqual(self.master(a, b).state()["sea"]["windSpeed"],
                            NEVER["sea"]["windSpeed"])
        answer = b.request("POST", "/v1/recording", {"stop": True})
        self.assertEqual(answer.status, 200, answer)
        runs = self.check_log("late", [self.path("late.pelog")])
        self.check_replay("late", [self.path("late.pelog")], runs)
        self.check_debrief(b, "late", runs)
        self.assertIn("CLU-008", c.log())
        for node in (a, c):
            node.stop()
            mine = segments(self.path(node.name + ".pelog"))
            runs = self.check_log(node.name, mine)
            self.check_replay(node.name, mine, runs)


if __name__ == "__main__":
    if not case.has_etcd():
        print("SKIP: no etcd")
        sys.exit(77)
    unittest.main(verbosity=2)
