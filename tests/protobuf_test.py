#!/usr/bin/python3
"""Protobuf sessions over TCP and the Unix socket, end to end."""
import contextlib
import os
import random
import socket
import stat
import struct
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import (SANITIZED, SLOW_S, Daemon, Session, receive_all,
                            schema, until, varint)

pb = schema()


def malformed(transport):
    return f'pelagos_malformed_total{{input="{transport}"}}'


class SessionCase(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(unix=True)

    @classmethod
    def tearDownClass(cls):
        path = cls.daemon.unix_path
        status = cls.daemon.stop()
        assert status == 0, f"the daemon ended with {status}"
        assert not os.path.exists(path), "the Unix socket is left behind"

    def setUp(self):
        self.daemon.patch({"clock": None, "sea": None, "views": [
            {"name": "bridge", "entity": 1, "width": 320, "height": 180}]})

    def tcp(self):
        session = Session(self.daemon.connect_tcp())
        self.addCleanup(session.close)
        return session


class Commands(SessionCase):
    def test_get_and_patch(self):
        for connect in (self.daemon.connect_tcp, self.daemon.connect_unix):
            with Session(connect()) as session:
                state = session.ask(get={}).state
                self.assertEqual(state.sea.wind_speed, 8)
                reply = session.ask(patch={"state": {
                    "sea": {"wind_speed": 11.5}}})
                self.assertEqual(reply.state.sea.wind_speed, 11.5)
                self.assertEqual(reply.state.revision, state.revision + 1)
                reply = session.ask(patch={"remove": ["sea.windSpeed"]})
                self.assertEqual(reply.state.sea.wind_speed, 8)

    def test_refused_patch(self):
        session = self.tcp()
        before = session.ask(get={}).state
        error = session.ask(patch={"state": {"sea": {
            "gamma": 2, "wind_speed": 77}}}).error
        self.assertEqual(
            (error.code, error.path, error.unit, error.minimum, error.maximum),
            (pb.OUT_OF_RANGE, "sea.windSpeed", "m/s", 0, 30))
        for bad in (float("nan"), float("inf")):
            reply = session.ask(patch={"state": {"sea": {"wind_speed": bad}}})
            self.assertEqual(reply.WhichOneof("result"), "error")
        after = session.ask(get={}).state
        self.assertEqual((after.revision, after.sea),
                         (before.revision, before.sea))

    def test_frame(self):
        session = self.tcp()
        reply = session.ask(frame={"view": "bridge", "format": "PNG",
                                   "width": 64, "height": 32, "time": 3})
        frame = reply.frame
        self.assertTrue(frame.data.startswith(b"\x89PNG"))
        self.assertEqual((frame.view, frame.width, frame.height, frame.time,
                          frame.format), ("bridge", 64, 32, 3, pb.PNG))
        self.assertEqual(frame.revision, session.ask(get={}).state.revision)
        self.assertEqual(session.ask(frame={"view": "x"}).error.code,
                         pb.NOT_FOUND)
        error = session.ask(frame={"view": "bridge", "quality": 0}).error
        self.assertEqual((error.code, error.path), (pb.OUT_OF_RANGE,
                                                    "quality"))
        error = session.ask(frame={"view": "bridge",
                                   "time": float("nan")}).error
        self.assertEqual((error.code, error.path), (pb.INVALID, "time"))

    def test_large_frame(self):
        """A reply of many megabytes, read slowly, arrives whole."""
        session = self.tcp()
        frame = session.ask(frame={"view": "bridge", "format": "EXR",
                                   "width": 1280, "height": 720,
                                   "float_samples": True, "layers": [
                                       "radiance", "depth", "normal"]}).frame
        self.assertEqual(frame.data[:4], b"\x76\x2f\x31\x01")
        self.assertGreater(len(frame.data), 1000000)

    def test_spectrum(self):
        session = self.tcp()
        spectrum = session.ask(spectrum={"frequencies": 4}).spectrum
        self.assertEqual(len(spectrum.rows), 4)
        http = self.daemon.request(
            "POST", "/v1/spectrum", {"frequencies": 4}).json()
        self.assertEqual(spectrum.drawn.slope_along,
                         http["drawn"]["slopeAlong"])
        error = session.ask(spectrum={"directions": 73}).error
        self.assertEqual(error.path, "directions")

    def test_surface(self):
        session = self.tcp()
        query = {"points": [{"east": 1, "north": 2}] * 100, "time": 5}
        surface = session.ask(surface=query).surface
        self.assertEqual((surface.time, len(surface.points)), (5, 100))
        http = self.daemon.request("POST", "/v1/surface", {
            "points": [[1, 2]], "time": 5}).json()
        self.assertEqual(surface.points[0].height,
                         http["points"][0]["height"])
        error = session.ask(surface={"points": [{"east": 1}]}).error
        self.assertEqual((error.code, error.path), (pb.INVALID, "points.0"))

    def test_step(self):
        session = self.tcp()
        self.assertEqual(session.ask(step={"seconds": 1}).error.code,
                         pb.CONFLICT)
        session.ask(patch={"state": {"clock": {"mode": "STEPPED",
                                               "time": 10}}})
        self.assertEqual(session.ask(step={"seconds": 2}).state.clock.time, 12)

    def test_pipelined(self):
        session = self.tcp()
        for i in range(200):
            session.send(pb.Request(id=i, get={}))
        self.assertEqual([session.receive().id for _ in range(200)],
                         list(range(200)))

    def test_byte_by_byte(self):
        session = self.tcp()
        data = pb.Request(id=9, patch={"state": {"sea": {
            "seed": 5}}}).SerializeToString()
        for byte in varint(len(data)) + data:
            session.socket.sendall(bytes([byte]))
            time.sleep(0.005)
        self.assertEqual(session.receive().state.sea.seed, 5)

    def test_too_many_in_flight(self):
        session = self.tcp()
        together = b""  # or the first would be done before the last is there
        for i in range(20):
            data = pb.Request(id=i, frame={
                "view": "bridge", "format": "PNG", "width": 640,
                "height": 360, "time": i}).SerializeToString()
            together += varint(len(data)) + data
        session.socket.sendall(together)
        replies = [session.receive() for _ in range(20)]
        self.assertEqual(sorted(r.id for r in replies), list(range(20)))
        busy = [r for r in replies if r.WhichOneof("result") == "error"]
        self.assertTrue(busy and all(r.error.code == pb.BUSY for r in busy))
        self.assertGreaterEqual(len(replies) - len(busy), 16)

    def test_watch(self):
        session, other = self.tcp(), self.tcp()
        session.send(pb.Request(id=70, watch={}))
        first = session.receive()
        self.assertEqual(first.id, 70)
        other.ask(patch={"state": {"sea": {"seed": 77}}})
        reply = session.receive()
        self.assertEqual((reply.id, reply.state.sea.seed), (70, 77))
        # A slow reader misses states, not the newest one. (Not of the sea,
        # each of which would be built.)
        for azimuth in range(2000):
            other.ask(patch={"state": {"sky": {"sun_azimuth": azimuth / 10}}})
        seen = 0
        while reply.state.sky.sun_azimuth != 199.9:
            reply = session.receive()
            seen += 1
        self.assertLessEqual(seen, 2000)


class Hostile(SessionCase):
    def state(self):
        state = self.daemon.state()
        state["clock"].pop("time")
        return state

    def test_malformed_gets_an_error_and_the_end(self):
        for data in (b"\x05\xff\xff\xff\xff\xff", b"\xff" * 10,
                     varint(70000) + b"x" * 100):
            for connect in (self.daemon.connect_tcp,
                            self.daemon.connect_unix):
                with Session(connect()) as session:
                    session.socket.sendall(data)
                    self.assertEqual(session.receive().error.code,
                                     pb.MALFORMED)
                    self.assertIsNone(session.receive())
        with Session(self.daemon.connect_tcp()) as session:
            session.send(pb.Request(id=4))
            error = session.receive()
            self.assertEqual((error.id, error.error.code), (4, pb.INVALID))
            self.assertEqual(session.ask(get={}).state.sea.seed, 1)

    def test_thousand_malformed(self):
        rng = random.Random(6)
        good = pb.Request(id=1, patch={"state": {"sea": {
            "wind_speed": 29}}}).SerializeToString()
        for transport, connect in (("tcp", self.daemon.connect_tcp),
                                   ("unix", self.daemon.connect_unix)):
            before = self.state()
            counted = self.daemon.metrics()[malformed(transport)]
            for i in range(1000):
                if i % 2:
                    noise = bytes(rng.randrange(256) for _ in range(40))
                    data = varint(len(noise)) + b"\x0f" + noise[1:]
                else:
                    data = varint(len(good)) + b"\xff" + good[1:]
                with connect() as s:
                    s.sendall(data)
                    reply = receive_all(s)
                self.assertTrue(reply)
            after = self.daemon.metrics()[malformed(transport)]
            self.assertEqual(after - counted, 1000)
            self.assertEqual(self.state(), before)

    def test_half_sent_and_dripping(self):
        session = self.tcp()
        dripping = self.tcp()
        dripping.socket.settimeout(0.3)
        begin = time.monotonic()
        session.socket.sendall(b"\x10\x08")
        dripping.socket.sendall(varint(60000))
        ended = None
        while time.monotonic() - begin < SLOW_S and ended is None:
            with contextlib.suppress(socket.timeout):
                try:
                    dripping.socket.sendall(b"\x0a")
                    if not dripping.socket.recv(10):
                        ended = time.monotonic() - begin
                except ConnectionError:
                    ended = time.monotonic() - begin
        # 15 s are given; a busy daemon looks later.
        self.assertTrue(ended and ended > 14, ended)
        self.assertIsNone(session.receive())

    def test_stalled_reader(self):
        """Asking without reading: the daemon stops reading, does not grow."""
        before = self.daemon.rss()
        with self.daemon.connect_tcp() as s:
            s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            s.settimeout(1)
            data = pb.Request(id=1, get={}).SerializeToString()
            sent = 0
            with contextlib.suppress(OSError):
                for _ in range(200000):
                    s.sendall((varint(len(data)) + data) * 100)
                    sent += 100
            self.assertLess(sent, 20000000)
            if not SANITIZED:
                self.assertLess(self.daemon.rss() - before, 8e6)
        self.assertEqual(self.tcp().ask(get={}).state.sea.seed, 1)

    def test_vanished_client(self):
        for _ in range(20):
            session = Session(self.daemon.connect_tcp())
            for i in range(3):
                session.send(pb.Request(id=i, frame={
                    "view": "bridge", "width": 2048, "height": 1024,
                    "format": "PNG"}))
            session.send(pb.Request(id=9, surface={"points": [
                {"east": 0, "north": 0}] * 500}))
            session.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER,
                                      struct.pack("ii", 1, 0))
            session.close()
        for left in ("pelagos_frames_requests_waiting",
                     'pelagos_sessions{input="tcp"}'):
            until("nothing is left of them",
                  lambda: self.daemon.metrics()[left] == 0)

    def test_session_limit(self):
        sockets = [self.daemon.connect_tcp() for _ in range(64)]
        with Session(self.daemon.connect_tcp()) as session:
            self.assertEqual(session.receive().error.code, pb.BUSY)
            self.assertIsNone(session.receive())
        for s in sockets:
            s.close()
        until("there is room", lambda: self.daemon.metrics()[
            'pelagos_sessions{input="tcp"}'] == 0)
        self.assertEqual(self.tcp().ask(get={}).state.sea.seed, 1)


class Shares(SessionCase):
    def test_tcp_does_not_keep_unix_out(self):
        """64 who watch cannot make room, and have TCP's places only."""
        watchers = []
        for _ in range(64):
            session = Session(self.daemon.connect_tcp())
            self.addCleanup(session.close)
            self.assertTrue(session.ask(watch={}).HasField("state"))
            watchers.append(session)
        with Session(self.daemon.connect_tcp()) as session:
            reply = session.receive()
            self.assertEqual(reply.error.code, pb.BUSY)
        with Session(self.daemon.connect_unix()) as session:
            self.assertTrue(session.ask(get={}).HasField("state"))


class UnixSocket(SessionCase):
    def test_mode(self):
        mode = os.stat(self.daemon.unix_path).st_mode
        self.assertTrue(stat.S_ISSOCK(mode))
        self.assertEqual(stat.S_IMODE(mode), 0o600)

    def test_taken_and_stale_paths(self):
        with self.assertRaises(RuntimeError):
            Daemon("--unix", self.daemon.unix_path)
        self.daemon.connect_unix().close()
        stale = os.path.join(self.daemon.folder, "stale")
        with socket.socket(socket.AF_UNIX) as s:
            s.bind(stale)
        with Daemon("--unix", stale):
            with socket.socket(socket.AF_UNIX) as s:
                s.connect(stale)
        self.assertFalse(os.path.exists(stale))
        ordinary = os.path.join(self.daemon.folder, "file")
        with open(ordinary, "w") as f:
            f.write("precious")
        with self.assertRaises(RuntimeError):
            Daemon("--unix", ordinary)
        with open(ordinary) as f:
            self.assertEqual(f.read(), "precious")


if __name__ == "__main__":
    unittest.main(verbosity=2)
