#!/usr/bin/python3
"""What one large picture took, smaller ones give back."""
import os
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)),
                                "..", "clients", "python"))
from pelagos_daemon import SANITIZED, Daemon, Session
from pelagos.schema import LAYERS

ALL = ",".join(LAYERS)
SIDE = 1100
# Of readback; targets are a band's, and 256 MiB are the most.
TAKEN = SIDE * SIDE * 188


class Memory(unittest.TestCase):
    @unittest.skipIf(SANITIZED, "sanitizers keep freed memory back")
    def test_large_picture(self):
        with Daemon(unix=True) as daemon:
            daemon.patch({"views": {"bridge": {"width": SIDE,
                                               "height": SIDE}}})
            answer = daemon.get(f"/v1/views/bridge/frame.exr?layers={ALL}",
                                timeout=120)
            self.assertEqual(answer.status, 200, answer.status)
            large = daemon.rss()
            daemon.patch({"views": {"bridge": {"width": 64, "height": 36}}})
            with Session(daemon.connect_unix()) as session:
                for _ in range(400):
                    reply = session.ask(frame={"view": "bridge"})
                    self.assertTrue(reply.frame.data)
            small = daemon.rss()
            print(f"{large / 1e6:.0f} MB, then {small / 1e6:.0f} MB")
            self.assertGreater(large - small, 0.8 * TAKEN)
            # 290 to 315 MB, most of it compiled programs: those of outlines and
            # of whitecaps are 30.
            self.assertLess(small, 340e6)


if __name__ == "__main__":
    unittest.main(verbosity=2)
