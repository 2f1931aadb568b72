#!/usr/bin/python3
"""The moment of presentation of a frame that several nodes show: the seal's,
to the microsecond, in every header of every node."""
import contextlib
import os
import sys
import threading
import time
import unittest

import cluster_case as case
from live_client import Live
from pelagos_daemon import until

QUERY = "?codec=jpeg"  # the stream that MJPEG's viewers have too
DELIVERY_MS = 40
COUNT = 20
CLOCK_MS = 250  # by what b's clock is ahead
# From a seal to a node that draws nothing: by b's clock, as its windows go by
# it, and what the loopback interface takes at its quickest.
WAY_MS = CLOCK_MS + 20
LATER_MS = 1950  # more than any node here draws for, of the 2,000 that count


class Present(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.store = case.Store()
        cls.addClassCleanup(cls.store.stop)
        cls.nodes = [cls.begin("a")]
        cls.nodes[0].patch({"views": {"bridge": {"width": 64, "height": 36}}})
        # A clock that is wrong changes nothing of what is sealed.
        os.environ["PELAGOS_EXERCISE_CLOCK"] = str(CLOCK_MS)
        try:
            cls.nodes.append(cls.begin("b"))
        finally:
            del os.environ["PELAGOS_EXERCISE_CLOCK"]
        cls.log = case.Log(cls.store.members[0])
        cls.addClassCleanup(cls.log.stop)

    @classmethod
    def begin(cls, name):
        node = case.Node(name, cls.store)
        cls.addClassCleanup(node.stop)
        until(f"{name} takes part", lambda: node.is_master() or node.follows())
        return node

    def seals(self):
        return {n: frame.seal for n, frame, _ in list(self.log.frames)}

    def websocket(self, node, out, enough):
        with Live(node, "bridge", QUERY) as live:
            while not enough():
                head, _ = live.picture()
                live.ack(head)
                if not head.flags & 4:  # of what coasts nothing is sealed
                    out[head.number] = head.present

    def mjpeg(self, node, out, enough):
        with contextlib.closing(node.connect_http()) as s:
            s.sendall(b"GET /v1/views/bridge/mjpeg HTTP/1.1\r\n"
                      b"Host: localhost\r\n\r\n")
            data, head = b"", {}
            while not enough():
                chunk = s.recv(1 << 16)
                assert chunk, data
                data += chunk
                while b"\r\n" in data:
                    line, data = data.split(b"\r\n", 1)
                    name, _, value = line.partition(b": ")
                    head[name] = value
                    if not line and b"X-Pelagos-Present" in head:
                        if head[b"X-Pelagos-Stale"] in (b"", b"none"):
                            whole, part = head[b"X-Pelagos-Present"].split(b".")
                            out[int(head[b"X-Pelagos-Frame"])] = int(
                                whole + part)
                        head = {}

    def test_all_headers_say_what_is_sealed(self):
        seen = [({}, way, node) for node in self.nodes
                for way in (self.websocket, self.mjpeg)]

        end = time.monotonic() + 60

        def enough():
            return time.monotonic() > end or len(set.intersection(*(
                set(list(out)) for out, _, _ in seen))) >= COUNT
        threads = [threading.Thread(target=way, args=(node, out, enough))
                   for out, way, node in seen]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        newest = max(max(out) for out, _, _ in seen)
        until("the log tells it", lambda: self.log.last() >= newest)
        seals = self.seals()
        for out, way, node in seen:
            for number, present in out.items():
                self.assertEqual(present, seals[number].present // 1000,
                                 (node.name, way.__name__, number))
        common = set.intersection(*(set(list(out)) for out, _, _ in seen))
        print(f"{len(common)} frames seen by all four, "
              f"{sum(len(out) for out, _, _ in seen)} headers")
        self.assertGreater(len(common), 0)

    def test_the_slowest_node_moves_all(self):
        """A seal's moment is when it was made, the longest delay that a node
        says, and 40 ms; one that is silent does not count any more."""
        def ahead_ms():
            last = self.log.last()
            seal = self.seals()[last]
            return (seal.present - seal.made) * 1e-6
        until("the log tells something", lambda: self.log.last() > 0)
        until("the nodes say something", lambda: self.nodes[0].cluster().get(
            "nodes"))
        # Whatever pictures took that nobody sees any more.
        until("no node holds up another",
              lambda: ahead_ms() < DELIVERY_MS + WAY_MS)
        self.assertGreaterEqual(ahead_ms(), DELIVERY_MS)
        for beat in range(1, 21):
            self.store.put("bridge/nodes/slow", self.log.pb.ClusterNode(
                name="slow", delay=LATER_MS, beat=beat).SerializeToString())
            time.sleep(0.1)
        self.assertAlmostEqual(ahead_ms(), LATER_MS + DELIVERY_MS, delta=1e-3)
        out = {}
        self.websocket(self.nodes[1], out, lambda: len(out) >= COUNT)
        until("the log tells it", lambda: self.log.last() >= max(out))
        for number, present in out.items():
            seal = self.seals()[number]
            self.assertEqual(present, seal.present // 1000)
        until("it is silent", lambda: ahead_ms() < DELIVERY_MS + WAY_MS)


if __name__ == "__main__":
    if not case.has_etcd():
        print("SKIP: no etcd")
        sys.exit(77)
    unittest.main(verbosity=2)
