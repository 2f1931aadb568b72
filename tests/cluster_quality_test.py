#!/usr/bin/python3
"""The scale at which live views of one exercise are drawn: the seal's, on all
nodes that leave it open; the slowest of them decides, or the master's option."""
import os
import subprocess
import sys
import threading
import time
import unittest

import cluster_case as case
from live_client import Live
from pelagos_daemon import BIN, SLOW_S, until

COUNT = 5


class Quality(unittest.TestCase):
    def setUp(self):
        self.store = case.Store()
        self.addCleanup(self.store.stop)
        self.log = case.Log(self.store.members[0])
        self.addCleanup(self.log.stop)

    def begin(self, name, quality):
        node = case.Node(name, self.store, fps=5, quality=quality)
        self.addCleanup(node.stop)
        until(f"{name} takes part", lambda: node.is_master() or node.follows())
        return node

    def sealed(self):
        return self.log.frames[-1][1].seal.quality if self.log.frames else None

    def watch(self, *nodes):
        """Of each node {frame: (scale, JPEG)} with COUNT frames that all have,
        none of which goes on without a seal."""
        seen = [{} for _ in nodes]
        end = time.monotonic() + 60

        def enough():
            return time.monotonic() > end or len(set.intersection(
                *(set(list(one)) for one in seen))) >= COUNT

        def look(node, out):
            with Live(node, "bridge", "?codec=jpeg") as live:
                while not enough():
                    head, data = live.picture()
                    live.ack(head)
                    if not head.flags & 4:
                        out[head.number] = (head.drawn_width / head.width, data)
        threads = [threading.Thread(target=look, args=pair)
                   for pair in zip(nodes, seen)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        common = set.intersection(*(set(one) for one in seen))
        self.assertGreaterEqual(len(common), COUNT)
        until("the log tells it", lambda: self.log.last() >= max(common))
        return [{n: one[n] for n in common} for one in seen]

    def said(self, node, of):
        return next((n for n in node.cluster().get("nodes", ())
                     if n["name"] == of), {})

    def test_what_the_master_fixes(self):
        a, b = self.begin("a", "0.5"), self.begin("b", "auto")
        a.patch({"views": {"bridge": {"width": 128, "height": 72}}})
        of_a, of_b = self.watch(a, b)
        self.assertTrue(of_a == of_b, "to the bit")
        self.assertEqual({scale for scale, _ in of_a.values()}, {0.5})
        self.assertEqual(self.sealed(), 0.5)
        until("b says that it is alike", lambda: self.said(a, "b").get("alike"))
        self.assertNotIn("quality", self.said(b, "a"))
        c = self.begin("c", "full")
        until("c says that it is not", lambda: self.said(a, "c").get(
            "alike") is False)
        until("its log tells why", lambda: "CLU-022" in c.log())
        self.assertEqual(c.log().count("CLU-022"), 1)
        self.assertNotIn("CLU-022", b.log())
        of_a, of_c = self.watch(a, c)
        self.assertEqual({scale for scale, _ in of_c.values()}, {1})
        for number, (_, data) in of_a.items():
            self.assertNotEqual(data, of_c[number][1])
        done = subprocess.run(
            [os.path.join(BIN, "pelagosctl"), "--server",
             f"tcp:127.0.0.1:{a.tcp_port}", "cluster"],
            capture_output=True, text=True, check=True).stdout
        self.assertRegex(done, r"(?m)^c .*not bit-equal")
        self.assertNotRegex(done, r"(?m)^[ab] .*not bit-equal")

    def test_the_slowest_decides(self):
        a, b = self.begin("a", "auto"), self.begin("b", "auto")
        a.patch({"views": {"bridge": {"width": 128, "height": 72}}})
        until("a seal says it", lambda: self.sealed() == 1)
        end = threading.Event()

        def speak():
            beat = 0
            while not end.wait(0.3):
                beat += 1
                self.store.put("bridge/nodes/slow", self.log.pb.ClusterNode(
                    name="slow", quality=0.5, beat=beat).SerializeToString())
        thread = threading.Thread(target=speak)
        thread.start()
        try:
            # Or less, where these two are slower still.
            until("it is the slow one's", lambda: self.sealed() <= 0.5)
            of_a, of_b = self.watch(a, b)
            self.assertTrue(of_a == of_b)
            self.assertLessEqual(max(s for s, _ in of_a.values()), 0.5)
        finally:
            end.set()
            thread.join()
        until("it is silent", lambda: self.sealed() == 1, 2 * SLOW_S)


if __name__ == "__main__":
    if not case.has_etcd():
        print("SKIP: no etcd")
        sys.exit(77)
    unittest.main(verbosity=2)
