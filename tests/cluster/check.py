#!/usr/bin/python3
"""One exercise on several machines, the long form (`make cluster-check`): three
members of etcd and four daemons in namespaces, as root. What the clients saw
is judged by history.py.

    check.py [--commands N] [--kills N] [TEST ...]
"""
import argparse
import contextlib
import os
import random
import shutil
import struct
import subprocess
import sys
import threading
import time
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.dirname(HERE))

import history
import spaces
from cluster_case import Log, Store, packed_digest
from pelagos_daemon import BIN, Daemon, schema, until, varint

STORES = ("s1", "s2", "s3")
NODES = ("n1", "n2", "n3", "n4")
options = argparse.Namespace(commands=10000, kills=20)


def percentile(values, share):
    return sorted(values)[min(int(share * len(values)), len(values) - 1)]


class Client(threading.Thread):
    """Writes names to entity 1, one after the other, wherever the master is;
    what it saw is its history."""

    def __init__(self, check, number, count=None):
        super().__init__(daemon=True)
        self.check, self.number, self.count = check, number, count
        self.history, self.ending = [], False
        self.start()

    def run(self):
        i, session, at = 0, None, None
        pb = schema()
        while not self.ending and (self.count is None or i < self.count):
            if session is None:
                at = random.choice(self.check.machines)
                with contextlib.suppress(OSError):
                    session = at.session(5)
                if session is None:
                    time.sleep(0.02)
                    continue
            name = f"c{self.number}-{i}"
            command = {"name": name, "begun": time.monotonic(),
                       "result": "unknown", "ended": None}
            self.history.append(command)
            reply = None
            with contextlib.suppress(OSError):
                reply = session.ask(patch={"state": {
                    "entities": [{"id": 1, "name": name}]}})
            command["ended"] = time.monotonic()
            i += 1
            if reply is None or reply.WhichOneof("result") == "error":
                text = reply.error.message if reply else ""
                if "shows what the master" in text or "takes no edits" in text:
                    command["result"] = "refused"
                with contextlib.suppress(OSError):
                    session.close()
                session = None
                time.sleep(0.01)
            else:
                command["result"] = "done"

    def done(self):
        return sum(c["result"] == "done" for c in self.history)


class Cluster(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = spaces.folder()
        cls.addClassCleanup(shutil.rmtree, cls.folder, True)
        cls.net = spaces.Net(STORES + NODES)
        cls.addClassCleanup(cls.net.close)
        cls.store = Store(members=spaces.members(cls.net, STORES))
        cls.addClassCleanup(cls.store.stop)
        print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")

    def setUp(self):
        """Each test has an exercise of its own."""
        self.exercise = self.id().rsplit(".", 1)[-1]
        self.machines = []
        self.addCleanup(self.end_machines)
        self.net.loss(0)
        self.net.cut(())
        for name in NODES:
            machine = spaces.Machine(self.net, name,
                                     self.store.url(self.exercise), self.folder)
            machine.start()
            self.machines.append(machine)
        for machine in self.machines:
            spaces.await_part(machine)
        self.ask(self.master(), patch={"state": {"views": [
            {"name": "bridge", "width": 64, "height": 36}]}})

    def end_machines(self):
        for machine in self.machines:
            if machine.alive():
                machine.kill()

    def master(self, seconds=60):
        return until("a master", lambda: next(
            (m for m in self.machines if m.alive() and m.has_role("MASTER")),
            None), seconds)

    def ask(self, machine, **command):
        with machine.session() as session:
            reply = session.ask(**command)
        self.assertNotEqual(reply.WhichOneof("result"), "error", reply)
        return reply

    def frames(self):
        """Every frame of the exercise, as the store has them."""
        member = self.store.leader() or until("a leader", self.store.leader)
        last = schema().SealedFrame.FromString(
            self.store.get(self.exercise + "/log")).seal.number
        log = Log(member, self.exercise)
        until("the whole log", lambda: log.last() >= last)
        log.stop()
        return log

    def judge(self, log, clients):
        log.check()
        frames = [{"number": n, "term": f.seal.term, "names": [
            e.patch.state.entities[0].name for e in f.entries
            if e.patch.state.entities and e.patch.state.entities[0].name]}
            for n, f, _ in log.frames]
        commands = [c for client in clients for c in client.history]
        for c in commands:
            c["ended"] = c["ended"] or float("inf")
        complaints = history.judge(commands, frames)
        self.assertEqual(complaints, [], complaints[:10])

    def gaps(self, log):
        """Between one frame and the next, by the masters' clocks, which here
        are one. [s]"""
        made = [f.seal.made for _, f, _ in log.frames]
        return [1e-9 * (b - a) for a, b in zip(made, made[1:])]

    # --- the same everywhere -------------------------------------------------

    def test_same_with_loss(self):
        """Commands with 5 % loss: the state of every node, asked for all the
        while, has the digest of the frame of its time."""
        self.net.loss(5)
        clients = [Client(self, k, options.commands // 8) for k in range(8)]
        looked, wrong = {m.name: {} for m in self.machines}, []

        def look(machine):
            with contextlib.suppress(OSError):
                with machine.session() as session:
                    while any(c.is_alive() for c in clients):
                        state = session.ask(get={}).state
                        looked[machine.name][state.clock.time] = (
                            packed_digest(state))
                        time.sleep(0.02)
        begun = time.monotonic()
        lookers = [threading.Thread(target=look, args=(m,), daemon=True)
                   for m in self.machines]
        for thread in lookers:
            thread.start()
        for thread in clients + lookers:
            thread.join(900)
        took = time.monotonic() - begun
        log = self.frames()
        self.judge(log, clients)
        sealed = {f.seal.time: f.seal.digest for _, f, _ in log.frames}
        compared = 0
        for name, states in looked.items():
            for moment, digest in states.items():
                if moment in sealed:
                    compared += 1
                    if digest != sealed[moment]:
                        wrong.append((name, moment))
        self.assertEqual(wrong, [])
        for machine in self.machines:
            self.assertNotIn("CLU-008", machine.log())
        gaps = self.gaps(log)
        print(f"5 % loss: {sum(c.done() for c in clients)} commands done in "
              f"{took:.0f} s, {len(log.frames)} frames, {compared} states "
              f"compared; from frame to frame p50 {percentile(gaps, .5):.3f}, "
              f"p99 {percentile(gaps, .99):.3f}, worst {max(gaps):.2f} s; "
              f"{max(f.seal.term for _, f, _ in log.frames)} terms")
        self.assertGreater(compared, 100)

    def test_equal_pictures(self):
        """200 pictures of each node, with 5 % loss."""
        self.net.loss(5)
        self.edit({"clock": {"rate": 0}})
        pb = schema()
        for i in range(200):
            revision = self.edit({"entities": [{"id": 1, "heading": i}]})
            pictures = set()
            for machine in self.machines:
                with machine.session() as session:
                    def shown():
                        frame = session.ask(frame={
                            "view": "bridge", "format": pb.PNG}).frame
                        return frame if frame.revision == revision else None
                    pictures.add(until("the picture", shown).data)
            self.assertEqual(len(pictures), 1, i)
        print("200 pictures of 4 nodes are equal")

    def edit(self, state):
        """By the master, whoever it is; the revision after it."""
        for _ in range(50):
            with contextlib.suppress(OSError, AssertionError):
                reply = self.ask(self.master(), patch={"state": state})
                return reply.state.revision
            time.sleep(0.1)
        raise AssertionError("nobody takes the edit")

    def test_a_replay_is_equal(self):
        """Pictures of running time against those of a replay of the log by a
        daemon that is by itself."""
        self.edit({"own_ship": {"on": True, "throttle": 0.8, "rudder": 10}})
        pb = schema()
        taken = {}
        first = pb.ClusterHead.FromString(
            self.store.get(self.exercise + "/head"))
        until("frames after the head", lambda: int(
            self.master().cluster().frame) > first.number + 5)
        for i in range(30):
            self.edit({"entities": [{"id": 1, "heading": 3 * i}]})
            with self.machines[i % 4].session() as session:
                frame = session.ask(frame={"view": "bridge",
                                           "format": pb.PNG}).frame
            if not frame.stale:
                taken[frame.time] = frame.data
        log = self.frames()
        path = os.path.join(self.folder, "log.pelog")
        end = self.write_pelog(path, first, log)
        out = os.path.join(self.folder, "frames")
        with Daemon("--quality", "full") as alone:
            subprocess.run(
                [os.path.join(BIN, "pelagosctl"), "replay", path,
                 "--view", "bridge", "--frames", out, "--at",
                 ",".join(repr(t) for t in sorted(taken))],
                check=True, stdout=subprocess.DEVNULL,
                env={**os.environ,
                     "PELAGOS_SERVER": f"tcp:127.0.0.1:{alone.tcp_port}"})
            drawn = sorted(os.listdir(out))
            self.assertEqual(len(drawn), len(taken))
            for name, moment in zip(drawn, sorted(taken)):
                with open(os.path.join(out, name), "rb") as f:
                    self.assertEqual(f.read(), taken[moment], name)
        print(f"{len(taken)} pictures of running time are those of a replay "
              f"of {end} frames")

    def write_pelog(self, path, head, log):
        pb = schema()
        entries = [pb.LogEntry(
            time=head.state.clock.time, revision=head.state.revision,
            head=pb.LogHead(version=1, program=head.program,
                            device=head.device, waves=head.waves,
                            began="2000-01-01T00:00:00Z", state=head.state,
                            recording="cluster", segment=1))]
        count = 0
        for number, frame, _ in log.frames:
            if number > head.number:
                count += 1
                entries += frame.entries
                entries.append(pb.LogEntry(
                    time=frame.seal.time, revision=entries[-1].revision,
                    step=pb.ClockStep(until=frame.seal.time)))
        with open(path, "wb") as f:
            f.write(b"PELOG1\r\n")
            for entry in entries:
                data = entry.SerializeToString()
                f.write(varint(len(data)) + data)
        return count

    # --- what takes how long -------------------------------------------------

    def test_time_to_seal(self):
        time.sleep(10)
        status = self.master().cluster()
        print(f"60 frames/s, no loss: sealed p50 {status.sealed_median:.1f}, "
              f"p99 {status.sealed_p99:.1f} ms (bars 5 and 12)")
        self.assertEqual(len(status.nodes), 4)

    def test_late_joiner(self):
        late = self.machines[3]
        late.kill()
        time.sleep(2)
        begun = time.monotonic()
        late.start()
        until("it listens", lambda: os.path.exists(late.socket))
        listens = time.monotonic() - begun
        until("it follows", lambda: late.has_role("FOLLOWER"))
        joined = time.monotonic() - begun
        print(f"a late node follows {joined:.2f} s after its start, "
              f"{joined - listens:.2f} s after it listens (bar 2)")

    # --- failures --------------------------------------------------------------

    def kills(self, what, count, bar):
        """kill -9, `count` times; each node is there again before the next.
        The worst gap that a kill caused, of each."""
        clients = [Client(self, k) for k in range(3)]
        worst = []
        for i in range(count):
            time.sleep(1 + random.random())
            until("all take part", lambda: all(
                m.has_role("MASTER", "FOLLOWER") for m in self.machines))
            begun = time.time_ns()
            master, leader = self.master(), until("a leader",
                                                  self.store.leader)
            if what in ("master", "both"):
                master.kill()
            if what in ("leader", "both"):
                leader.kill()
            until("frames go on", lambda: self.goes_on(begun))
            if what in ("leader", "both"):
                self.store.restart(leader)
            if what in ("master", "both"):
                master.start()
                spaces.await_part(master)
            worst.append(begun)
        for client in clients:
            client.ending = True
        for client in clients:
            client.join(30)
        log = self.frames()
        self.judge(log, clients)
        gaps = []
        made = [f.seal.made for _, f, _ in log.frames]
        for begun in worst:
            around = [1e-9 * (b - a) for a, b in zip(made, made[1:])
                      if b > begun and a < begun + 5_000_000_000]
            gaps.append(max(around))
        print(f"{count} kills of {what}: {sum(c.done() for c in clients)} "
              f"commands answered, none lost; gaps p50 "
              f"{percentile(gaps, .5):.2f}, worst {max(gaps):.2f} s (bar "
              f"{bar}); load {os.getloadavg()[0]:.1f}")

    def goes_on(self, since):
        with contextlib.suppress(Exception):
            frame = schema().SealedFrame.FromString(
                self.store.get(self.exercise + "/log"))
            return frame.seal.made > since + 50_000_000
        return False

    def test_kill_master(self):
        self.kills("master", options.kills, 0.5)

    def test_kill_leader(self):
        self.kills("leader", options.kills, 1.0)

    def test_kill_both(self):
        self.kills("both", options.kills, 1.5)

    def test_kill_follower(self):
        """The others do not notice."""
        follower = next(m for m in self.machines
                        if m.has_role("FOLLOWER"))
        time.sleep(2)
        begun = time.time_ns()
        follower.kill()
        time.sleep(2)
        made = [f.seal.made for _, f, _ in self.frames().frames]
        gaps = [1e-9 * (b - a) for a, b in zip(made, made[1:]) if b > begun]
        print(f"a follower killed: worst gap {max(gaps):.3f} s (bar 0.1)")

    def test_cut_off(self):
        """The master with one member of etcd on a side of its own: it seals
        nothing and tells its clients so, the others go on, and it follows
        when the network is whole again."""
        master = self.master()
        clients = [Client(self, k) for k in range(3)]
        time.sleep(2)
        self.net.cut([master.name, STORES[0]])
        cut = time.time_ns()
        others = [m for m in self.machines if m is not master]
        until("another master", lambda: any(
            m.has_role("MASTER") for m in others))
        # A command that is given to the cut-off one alone.
        with master.session(20) as session:
            reply = session.ask(patch={"state": {"entities": [
                {"id": 1, "name": "cut-0"}]}})
        self.assertEqual(reply.WhichOneof("result"), "error")
        time.sleep(2)
        with master.session() as session:
            frame = session.ask(frame={"view": "bridge"}).frame
        self.assertTrue(frame.stale)
        stood = frame.number
        time.sleep(1)
        with master.session() as session:
            frame = session.ask(frame={"view": "bridge"}).frame
        self.assertEqual(frame.number, stood)
        self.net.cut(())
        until("it follows", lambda: master.has_role("FOLLOWER"))
        for client in clients:
            client.ending = True
        for client in clients:
            client.join(30)
        log = self.frames()
        self.judge(log, clients)
        late = [n for n, f, _ in log.frames
                if f.seal.master == master.name and f.seal.term == 1
                and f.seal.made > cut + 500_000_000]
        self.assertEqual(late, [])
        print(f"cut off at frame {stood}; the others went on to "
              f"{log.last()}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--commands", type=int, default=10000)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("tests", nargs="*")
    given = parser.parse_args()
    options.commands, options.kills = given.commands, given.kills
    if os.geteuid() != 0 or not shutil.which("etcd") or not shutil.which("nft"):
        print("SKIP: needs root, etcd, nft")
        sys.exit(77)
    history.self_test()
    unittest.main(argv=[sys.argv[0], "-v", *given.tests])


if __name__ == "__main__":
    main()
