#!/usr/bin/python3
"""Live views that are drawn coarser than they are (--quality)."""
import os
import struct
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from live_client import Live
from pelagos_daemon import SLOW_S, Daemon
from stream_test import VIEW


class Quality(unittest.TestCase):
    """Live views may be drawn coarser than they are; stills never are."""

    STILL = "/v1/views/bridge/frame.png?time=7"

    def still(self, *options):
        with Daemon(*options) as daemon:
            daemon.patch(VIEW)
            return daemon.get(self.STILL).body

    def drawn(self, daemon, query=""):
        with Live(daemon, "bridge", query) as live:
            head, data = live.picture()
            return head, data, live.texts[0]

    def test_fixed(self):
        full = self.still("--quality", "full")
        with Daemon("--quality", "0.5") as daemon:
            daemon.patch(VIEW)
            head, _, told = self.drawn(daemon)
            self.assertEqual((head.width, head.height), (320, 180))
            self.assertEqual((head.drawn_width, head.drawn_height), (160, 90))
            self.assertEqual((told["drawnWidth"], told["drawnHeight"]),
                             (160, 90))
            head, data, _ = self.drawn(daemon, "?codec=jpeg&width=200&height=90")
            self.assertEqual((head.width, head.drawn_width), (200, 100))
            # SOF0: the picture itself has the size that was asked for.
            at = data.index(b"\xff\xc0") + 5
            self.assertEqual(struct.unpack_from(">HH", data, at), (90, 200))
            self.assertEqual(daemon.metrics()["pelagos_frames_quality"], 0.5)
            self.assertEqual(daemon.get("/healthz").json()["quality"], 0.5)
            with Live(daemon, "bridge") as live:  # a viewer changes no still
                live.picture()
                self.assertEqual(daemon.get(self.STILL).body, full)

    def test_by_itself(self):
        """Frames that cannot hold their rate in full are drawn coarser."""
        with Daemon("--fps", "240") as daemon:
            daemon.patch(VIEW)
            daemon.patch({"views": {"bridge": {"width": 1280, "height": 720}}})
            with Live(daemon, "bridge") as live:
                head, _ = live.picture()
                self.assertLess(head.drawn_width, 1280)  # as is foreseen
                first, count = head, 0
                end = time.monotonic() + SLOW_S
                while head.drawn_width > 400 and time.monotonic() < end:
                    live.ack(head)
                    head, _ = live.picture()
                    count += 1
                self.assertEqual((head.width, head.height), (1280, 720))
                print(f"from {first.drawn_width} to {head.drawn_width} pixels "
                      f"of width in {count} pictures, "
                      f"{(head.stamp - first.stamp) / 1e6:.1f} s")
                self.assertLessEqual(head.drawn_width, 400)
            self.assertIn("FRM-006", daemon.log())

    def test_refused(self):
        for value in "0.2", "1.1", "nan", "best", "":
            with self.assertRaises(RuntimeError) as refused:
                Daemon("--quality", value)
            self.assertIn("neither auto, full nor a number within 0.25 .. 1",
                          str(refused.exception))


if __name__ == "__main__":
    unittest.main(verbosity=2)
