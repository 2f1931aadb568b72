#!/usr/bin/python3
"""RTSP by clients that set streams up and leave, or use others' sessions."""
import contextlib
import os
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import Daemon, free_port, receive_all, until
from rtsp_client import RtspClient

CLIENTS = "pelagos_rtsp_clients"
REFUSED = 'pelagos_refused_total{input="rtsp"}'


class Rtsp(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.port = free_port()
        cls.daemon = Daemon("--rtsp", f"127.0.0.1:{cls.port}")
        cls.daemon.patch({"views": [{"name": "bridge", "entity": 1,
                                     "width": 64, "height": 36}]})
        with contextlib.closing(cls.client(cls)) as first:
            first.play()  # GStreamer has started, shaders are compiled
            first.picture()
        until("it is gone", lambda: cls.daemon.metrics()[CLIENTS] == 0)

    @classmethod
    def tearDownClass(cls):
        status = cls.daemon.stop()
        assert status == 0, f"the daemon ended with {status}"

    def client(self):
        return RtspClient(self.port, "bridge")

    def test_a_session_is_of_its_connection(self):
        """Whoever else names it is sent away: it could play, pause, end it."""
        with contextlib.closing(self.client()) as owner:
            owner.play()
            owner.picture()
            url, session = owner.url, owner.session
            for method in ("OPTIONS", "GET_PARAMETER", "SET_PARAMETER", "PLAY",
                           "PAUSE", "SETUP", "TEARDOWN"):
                for line in (f"Session: {session}", f"session:{session};x=1",
                             f"Session : {session}",
                             f"Session:{' ' * 60}{session}"):
                    with contextlib.closing(self.client()) as other:
                        other.socket.sendall(
                            f"{method} {url} RTSP/1.0\r\nCSeq: 1\r\n{line}"
                            "\r\n\r\n".encode())
                        self.assertEqual(receive_all(other.socket), b"", line)
            with contextlib.closing(self.client()) as other:
                other.session = "A" * 16  # nobody's
                self.assertEqual(other.ask("PLAY", url)[0], 454)
            for _ in range(10):
                owner.picture()
            self.assertEqual(owner.ask("PAUSE", owner.url)[0], 200)
            self.assertEqual(owner.ask("PLAY", owner.url)[0], 200)
            owner.picture()
            self.assertEqual(owner.ask("TEARDOWN", owner.url)[0], 200)

    def test_setups_without_play(self):
        """As many as there are places, set up and never played; a newcomer is
        refused while they are there, and plays when they have gone."""
        crowd = []
        for _ in range(64):
            client = self.client()
            self.addCleanup(client.close)
            self.assertEqual(client.setup(client.describe()), 200)
            crowd.append(client)
        refused = self.daemon.metrics()[REFUSED]
        with contextlib.closing(self.client()) as late, \
                self.assertRaises((ConnectionError, BrokenPipeError)):
            late.play()
        self.assertGreater(self.daemon.metrics()[REFUSED], refused)
        for client in crowd:
            client.close()
        gone = time.monotonic()

        def plays():
            with contextlib.suppress(OSError, AssertionError), \
                    contextlib.closing(self.client()) as newcomer:
                newcomer.play()
                newcomer.picture()
                return True
        until("a newcomer plays", plays)
        print(f"64 RTSP sessions were never played: {time.monotonic() - gone:.1f}"
              " s after they had gone a newcomer had its picture (bar 5 s)")
        until("all are gone", lambda: self.daemon.metrics()[CLIENTS] == 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
