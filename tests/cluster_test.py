#!/usr/bin/python3
"""One exercise on several nodes, the short form: one etcd, three daemons on
this machine. What takes minutes, losses and namespaces is tests/cluster/."""
import os
import sys
import time
import unittest

import cluster_case as case
from pelagos_daemon import Daemon, until

PNG = "/v1/views/bridge/frame.png?width=64&height=36"


def picture(node):
    """(frame, revision, PNG) as the node shows it now."""
    answer = node.get(PNG)
    assert answer.status == 200, answer
    return (int(answer.headers["X-Pelagos-Frame"]),
            int(answer.headers["X-Pelagos-Revision"]), answer.body)


class Cluster(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.store = case.Store()
        cls.nodes = {}
        cls.addClassCleanup(cls.store.stop)
        for name in ("a", "b"):
            cls.begin(name)
        cls.log = case.Log(cls.store.members[0])
        cls.addClassCleanup(cls.log.stop)

    @classmethod
    def begin(cls, name, *options):
        node = case.Node(name, cls.store, *options)
        cls.nodes[name] = node
        cls.addClassCleanup(node.stop)
        until(f"{name} takes part", lambda: node.is_master() or node.follows())
        return node

    @classmethod
    def master(cls):
        return until("a master", lambda: next(
            (n for n in cls.nodes.values() if n.alive() and n.is_master()),
            None))

    @classmethod
    def followers(cls):
        master = cls.master()
        return [n for n in cls.nodes.values() if n.alive() and n is not master]

    def edit(self, change):
        answer = self.master().patch(change)
        self.assertEqual(answer.status, 200, answer)
        return answer.json()

    def await_revision(self, node, revision):
        until(f"revision {revision} at {node.name}",
              lambda: int(node.state()["revision"]) >= revision)

    def test_1_all_show_the_same(self):
        self.edit({"clock": {"rate": 0}, "sea": {"windSpeed": 9}})
        for heading in range(20):
            state = self.edit({"entities": {"1": {"heading": heading}}})
        revision = int(state["revision"])
        pictures = []
        for node in self.nodes.values():
            self.await_revision(node, revision)
            own = node.state()
            self.assertEqual(own["entities"], state["entities"])
            self.assertEqual(own["clock"], state["clock"])
            until("its picture", lambda n=node: picture(n)[1] == revision)
            pictures.append(picture(node)[2])
        self.assertEqual(len(set(pictures)), 1)
        self.edit({"clock": {"rate": 1}})
        before = self.log.last()
        until("half a second of frames", lambda: self.log.last() > before + 15)
        for node in self.followers():
            status = node.metrics()
            self.assertEqual(status["pelagos_cluster_differences_total"], 0)
            self.assertEqual(status["pelagos_cluster_gaps_total"], 0)
        self.log.check()

    def test_2_edits_go_to_the_master(self):
        follower = self.followers()[0]
        before = follower.state()["revision"]
        answer = follower.patch({"sea": {"windSpeed": 3}})
        self.assertEqual(answer.status, 409, answer)
        self.assertIn("127.0.0.1", answer.json()["detail"])
        self.assertIn(f"node {self.master().name}", answer.json()["detail"])
        for method, path, body in (
                ("PUT", "/v1/views/wing", case.VIEW),
                ("DELETE", "/v1/views/bridge", None),
                ("PUT", "/v1/presets/x", {"patch": "{}"}),
                ("POST", "/v1/clock/step", {"seconds": 1})):
            answer = follower.request(method, path, body)
            self.assertEqual(answer.status, 409, (path, answer))
        self.assertEqual(follower.state()["revision"], before)

    def test_3_what_is_answered_is_sealed(self):
        """At the moment of an answer the store has the command already."""
        for i, (method, path, body) in enumerate((
                ("PATCH", "/v1/state", {"sea": {"windDirection": 11}}),
                ("PATCH", "/v1/state", {"sea": {"windSpeed": 12}}),
                ("PUT", "/v1/views/wing", case.VIEW),
                ("PUT", "/v1/presets/x", {"patch": "{}"}),
                ("DELETE", "/v1/presets/x", None),
                ("DELETE", "/v1/views/wing", None))):
            before = int(self.master().cluster()["frame"])
            answer = self.master().request(method, path, body)
            self.assertLess(answer.status, 300, answer)
            frame = self.log.pb.SealedFrame.FromString(
                self.store.get("bridge/log"))
            self.assertGreater(frame.seal.number, before, path)
            until("the log tells it",
                  lambda n=frame.seal.number: self.log.last() >= n)
            commands = [patch for number, patch in self.log.commands()
                        if before < number <= frame.seal.number]
            self.assertEqual(len(commands), 1, (path, commands))

    def test_4_a_late_node_joins(self):
        self.edit({"sea": {"windDirection": 77}})
        begun = time.monotonic()
        late = self.begin("c")
        self.await_revision(late, int(self.master().state()["revision"]))
        print(f"a late node follows {time.monotonic() - begun:.1f} s after "
              "its start")
        self.assertEqual(late.state()["sea"]["windDirection"], 77)

    def test_5_another_state_is_found(self):
        """A node whose state is another one says so, and has the right one
        afterwards."""
        number = int(self.master().cluster()["frame"]) + 150
        os.environ["PELAGOS_EXERCISE_STRAY"] = str(number)
        try:
            stray = self.begin("d")
        finally:
            del os.environ["PELAGOS_EXERCISE_STRAY"]
        until("the difference is found", lambda: stray.metrics()[
            "pelagos_cluster_differences_total"] == 1)
        until("it follows again", stray.follows)
        until("the frame goes by", lambda: int(
            stray.cluster()["frame"]) > number)
        self.assertEqual(stray.state()["clock"]["reckoning"], 60)
        self.assertIn("CLU-008", stray.log())
        stray.stop()

    def test_6_a_killed_master_is_replaced(self):
        state = self.edit({"entities": {"1": {"heading": 123}}})
        killed = self.master()
        begun = time.monotonic()
        killed.kill()
        master = self.master()
        print(f"another master {time.monotonic() - begun:.2f} s after kill -9")
        self.assertIsNot(master, killed)
        self.assertGreaterEqual(int(master.state()["revision"]),
                                int(state["revision"]))
        self.assertEqual(master.state()["entities"][0]["heading"], 123)
        self.edit({"entities": {"1": {"heading": 124}}})
        self.log.check()
        del self.nodes[killed.name]

    def test_7_what_does_not_go_together(self):
        with self.assertRaisesRegex(RuntimeError, "etcd keeps the state"):
            Daemon("--exercise", self.store.url(), "--state", "/tmp/x")
        with self.assertRaisesRegex(RuntimeError, "the exercise's name"):
            Daemon("--exercise", "http://127.0.0.1:1")


if __name__ == "__main__":
    if not case.has_etcd():
        print("SKIP: no etcd")
        sys.exit(77)
    unittest.main(verbosity=2)
