#!/usr/bin/python3
"""Shares by role and by token: whatever one `watch` token takes, an instructor
edits, logs in, watches and asks for /healthz, each time, and another token that
watches gets in; a client that has gone leaves its place at once; a token that
is taken back ends what was begun with it. The attacks are those of
tests/soak/attacks.py, which measures how long the instructor waits."""
import http.client
import json
import multiprocessing
import os
import re
import signal
import socket
import sys
import tempfile
import time
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "soak"))
import attacks
from attacks import TOKENS, head
from live_client import Closed, Live
from pelagos_daemon import (Daemon, Session, free_port, receive_all, schema,
                            until)
from whep_offer import OFFER

OTHER = "other-watch-token-0123456789"
ROUNDS = 5
VIEW = {"entity": 1, "width": 64, "height": 36}


def bearer(token):
    return {"Authorization": "Bearer " + token}


class Case(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.rtsp_port = free_port()
        cls.write({**{t: r for r, t in TOKENS.items()}, OTHER: "watch"})
        cls.daemon = Daemon("--token-file", cls.tokens, "--rtsp",
                            f"127.0.0.1:{cls.rtsp_port}")
        cls.daemon.token = TOKENS["instruct"]
        assert cls.daemon.patch({
            "views": {"bridge": VIEW, "wing": VIEW},
            "sea": {"synthesiser": "TROCHOIDS"}}).status == 200
        assert cls.daemon.get("/v1/views/wing/frame.jpg").status == 200

    @classmethod
    def tearDownClass(cls):
        cls.daemon.stop()
        cls.folder.cleanup()

    @classmethod
    def write(cls, tokens):
        cls.tokens = os.path.join(cls.folder.name, "tokens")
        with open(cls.tokens, "w", encoding="ascii") as f:
            f.writelines(f"{t} {r}\n" for t, r in tokens.items())
        os.chmod(cls.tokens, 0o600)

    def metric(self, name):
        return self.daemon.metrics().get(name, 0)

    def session(self, token):
        session = Session(self.daemon.connect_tcp())
        self.addCleanup(session.close)
        reply = session.ask(login={"token": token})
        self.assertTrue(reply.HasField("state"), reply)
        return session

    def stream(self, token, view="wing", query="quality=90"):
        s = self.daemon.connect_http()
        self.addCleanup(s.close)
        s.sendall(head("GET", f"/v1/views/{view}/mjpeg?{query}").replace(
            TOKENS["watch"].encode(), token.encode()))
        return s


class Attacks(Case):
    def begin(self, make):
        attacker = multiprocessing.Process(target=attacks.attack, args=(
            make, {"http": self.daemon.http_port, "tcp": self.daemon.tcp_port,
                   "rtsp": self.rtsp_port}), daemon=True)
        attacker.start()

        def end():
            attacker.kill()
            attacker.join()
        self.addCleanup(end)

    def attacked(self, make, metric, least):
        """The instructor is served each time from when the attack has taken so
        many places; so is another who watches."""
        before = self.metric(metric) if metric.endswith("_total") else 0
        self.begin(make)
        until(f"{metric} is {least}",
              lambda: self.metric(metric) - before >= least)
        one = attacks.Instructor(self.daemon, self.rtsp_port)
        for _ in range(ROUNDS):
            for what in attacks.WAITS:
                one.waits[what].append(getattr(one, what)())
        self.session(OTHER)
        with self.stream(OTHER) as s:
            self.assertIn(b" 200 ", s.recv(4096))
        print(", ".join(f"{what} {attacks.p99(waits):.1f} ms"
                        for what, waits in one.waits.items()), flush=True)

    def test_hls_reloads(self):
        self.daemon.patch({"clock": {"mode": "STEPPED"}})
        self.addCleanup(self.daemon.patch, {"clock": {"mode": "FREE"}})
        self.attacked(attacks.hls_reloads, "pelagos_hls_waiting", 64)

    def test_hls_left(self):
        self.attacked(attacks.hls_left, "pelagos_http_vanished_total", 64)

    def test_mjpeg(self):
        self.attacked(attacks.mjpeg, "pelagos_mjpeg_viewers", 36)

    def test_kinds_of_video(self):
        self.attacked(attacks.ts_kinds, "pelagos_ts_viewers", 36)

    def test_websockets(self):
        self.attacked(attacks.websockets, "pelagos_live_viewers", 36)

    def test_sessions(self):
        self.attacked(attacks.sessions, 'pelagos_sessions{input="tcp"}', 36)

    def test_rtsp(self):
        self.attacked(attacks.rtsp, "pelagos_rtsp_streams", 30)

    def test_teardown(self):
        self.attacked(attacks.teardown, "pelagos_rtsp_accepted_total", 100)

    def test_idle(self):
        self.attacked(attacks.idle, "pelagos_http_connections", 100)


class Gone(Case):
    def test_hls_of_who_has_left(self):
        """Streams of which nobody has a playlist end with who asked for them,
        long before those that are idle."""
        def ask(width):
            s = self.daemon.connect_http()
            s.sendall(head("GET", "/v1/views/bridge/hls.m3u8?height=64&"
                           f"width={width}"))
            return s
        with ask(64) as s:
            self.assertIn(b" 200 ", s.recv(4096))
        self.daemon.patch({"clock": {"mode": "STEPPED"}})
        self.addCleanup(self.daemon.patch, {"clock": {"mode": "FREE"}})
        left = [ask(80 + 16 * i) for i in range(20)]
        until("they wait", lambda: self.metric("pelagos_hls_waiting") == 20)
        for s in left:
            s.close()
        with self.session(TOKENS["instruct"]):
            self.assertEqual(until("they are gone", lambda: (
                self.metric("pelagos_hls_waiting") == 0 and
                self.metric("pelagos_hls_streams"))), 1)

    def test_who_sends_no_more_has_the_answer(self):
        """Half a close is none: whoever waits for a picture, a playlist, an
        edit or a long answer has it."""
        body = json.dumps({"points": [{"east": i, "north": 0}
                                      for i in range(1000)]}).encode()
        playlist = "/v1/views/bridge/hls.m3u8?width=128&height=64"
        for method, path, body in (
                ("PATCH", "/v1/state", b'{"sea": {"windSpeed": 8}}'),
                ("GET", "/v1/views/bridge/frame.exr?width=512&height=512", b""),
                ("GET", "/v1/series/surface?points=0,0&sweep=time=0:60:0.1",
                 b""),
                ("POST", "/v1/surface", body),
                ("GET", "/v1/models", b""),
                ("GET", playlist, b""),
                ("GET", playlist + "&_HLS_msn=1&_HLS_part=0", b"")):
            with self.subTest(path=path), self.daemon.connect_http() as s:
                s.sendall(head(method, path, "instruct", body))
                s.shutdown(socket.SHUT_WR)
                answer = http.client.HTTPResponse(s)
                answer.begin()
                self.assertEqual(answer.status, 200, path)
                self.assertTrue(answer.read(), path)

    def test_older_clients_have_no_interim_answer(self):
        """HTTP/1.0 knows none (RFC 9110, 15.2)."""
        with self.daemon.connect_http() as s:
            s.sendall(head("GET", "/v1/views/bridge/frame.exr?width=1024&"
                           "height=1024", "instruct")
                      .replace(b"HTTP/1.1", b"HTTP/1.0"))
            s.shutdown(socket.SHUT_WR)
            self.assertIn(b" 200 ", receive_all(s)[:16])


class Revoked(Case):
    def transport(self, token):
        s = self.daemon.connect_http()
        self.addCleanup(s.close)
        s.sendall(b"GET /v1/views/wing/ts HTTP/1.1\r\nHost: localhost\r\n"
                  b"Authorization: Bearer " + token.encode() + b"\r\n\r\n")
        self.assertIn(b" 200 ", s.recv(4096))
        return s

    def webrtc(self, token):
        """Begun; nobody is at its end. It needs no connection of its own."""
        answer = self.daemon.request("POST", "/v1/views/wing/whep", OFFER, {
            **bearer(token), "Content-Type": "application/sdp"})
        self.assertEqual(answer.status, 201, answer)

    def reload(self, token):
        """A playlist that is not there before the clock goes on."""
        s = self.daemon.connect_http()
        self.addCleanup(s.close)
        s.sendall(b"GET /v1/views/wing/hls.m3u8?_HLS_msn=%d&_HLS_part=0 "
                  b"HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer %s"
                  b"\r\n\r\n" % (self.number + 1, token.encode()))
        return s

    def playlist(self):
        """The number of its last segment, once it stands."""
        def ask():
            text = self.daemon.get("/v1/views/wing/hls.m3u8").body.decode()
            first = int(re.search(r"SEQUENCE:(\d+)", text).group(1))
            return first + text.count("#EXTINF")
        before = ask()
        while (now := ask()) != before:
            before = now
        return now

    def counts(self):
        of = self.daemon.metrics()
        return {name: of.get("pelagos_" + name, 0) for name in (
            "hls_waiting", "mjpeg_viewers", "ts_viewers", "whep_sessions")}

    def test_what_a_lost_token_began_ends(self):
        watch, kept = TOKENS["watch"], OTHER
        ends = [self.stream(watch), self.session(watch).socket,
                self.stream(TOKENS["steer"]), self.transport(watch)]
        goes_on = [self.stream(kept), self.session(kept), self.transport(kept)]
        lives = [Live(self.daemon, "wing", "?codec=jpeg", bearer(t))
                 for t in (watch, kept)]
        for live in lives:
            live.ack(live.picture()[0])
        rtsp = socket.create_connection(("127.0.0.1", self.rtsp_port), 60)
        self.addCleanup(rtsp.close)
        ends.append(rtsp)
        rtsp.sendall(f"DESCRIBE rtsp://127.0.0.1:{self.rtsp_port}/wing "
                     "RTSP/1.0\r\nCSeq: 1\r\nAuthorization: Bearer "
                     f"{watch}\r\n\r\n".encode())
        self.assertIn(b" 200 ", rtsp.recv(4096))
        for token in (watch, kept):
            self.webrtc(token)
        self.daemon.patch({"clock": {"mode": "STEPPED"}})
        self.addCleanup(self.daemon.patch, {"clock": {"mode": "FREE"}})
        self.number = self.playlist()
        ends.append(self.reload(watch))
        waits = self.reload(kept)
        until("all are there", lambda: self.counts() == {
            "hls_waiting": 2, "mjpeg_viewers": 3, "ts_viewers": 2,
            "whep_sessions": 2})
        # One is gone, one may do less.
        self.write({kept: "watch", TOKENS["instruct"]: "instruct",
                    TOKENS["steer"]: "watch"})
        self.daemon.process.send_signal(signal.SIGHUP)
        begun = time.monotonic()
        for s in ends:
            s.settimeout(60)
            try:
                while s.recv(1 << 16):
                    pass
            except ConnectionResetError:
                pass
        print(f"{len(ends)} ended after {time.monotonic() - begun:.3f} s")
        # By the daemon's own count they went in the same dispatch.
        self.assertEqual(self.counts(), {
            "hls_waiting": 1, "mjpeg_viewers": 1, "ts_viewers": 1,
            "whep_sessions": 1})
        self.daemon.patch({"clock": {"mode": "FREE"}})
        waits.settimeout(60)
        self.assertIn(b" 200 ", waits.recv(4096))
        self.assertTrue(goes_on[2].recv(4096))
        with self.assertRaises((Closed, OSError)):
            while True:
                lives[0].ack(lives[0].picture()[0])
        for _ in range(3):
            lives[1].ack(lives[1].picture()[0])
        self.assertTrue(goes_on[0].recv(4096))
        self.assertTrue(goes_on[1].ask(get={}).HasField("state"))


class Rtsp(Case):
    def ask(self, s, token):
        """The status of a question that any token may ask."""
        s.sendall(f"GET_PARAMETER rtsp://127.0.0.1:{self.rtsp_port}/wing "
                  "RTSP/1.0\r\nCSeq: 1\r\nAuthorization: Bearer "
                  f"{token}\r\n\r\n".encode())
        return int(s.recv(4096).split()[1])

    def connect(self):
        s = socket.create_connection(("127.0.0.1", self.rtsp_port), 60)
        self.addCleanup(s.close)
        return s

    def fill(self, token):
        """Takes places until none is left; their connections."""
        taken = []
        while self.ask(s := self.connect(), token) != 503:
            taken.append(s)
        return taken, s

    def test_a_place_given_up_is_asked_for_again(self):
        """A connection that asks with another token, whose share is full, has
        no place, with its first token neither."""
        watched, _ = self.fill(TOKENS["watch"])
        others, late = self.fill(OTHER)
        self.assertGreater(len(watched), len(others))
        self.assertEqual(self.ask(others[0], TOKENS["watch"]), 503)
        self.assertNotEqual(self.ask(late, OTHER), 503)
        self.assertEqual(self.ask(others[0], OTHER), 503)


    def test_strangers_close_no_instructor(self):
        """Who gave a token has a place, whatever he asked; those who say
        nothing make room for each other."""
        s = self.connect()
        question = (f"OPTIONS rtsp://127.0.0.1:{self.rtsp_port}/wing "
                    "RTSP/1.0\r\nCSeq: 1\r\nAuthorization: Bearer "
                    f"{TOKENS['instruct']}\r\n\r\n").encode()
        s.sendall(question)
        self.assertIn(b" 200 ", s.recv(4096))
        name = 'pelagos_timeouts_total{input="rtsp"}'
        before = self.metric(name)
        strangers = []

        def crowd():
            strangers.extend(self.connect() for _ in range(16))
            return self.metric(name) - before > 64
        until("64 had to make room", crowd)
        s.sendall(question)
        self.assertIn(b" 200 ", s.recv(4096))


class Soundings(Case):
    def test_rasters_of_a_watcher_leave_places(self):
        """As many rasters as a token may ask for; the instructor asks too."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        with open(os.path.join(folder.name, "flat.asc"), "w") as f:
            f.write("ncols 50\nnrows 50\nxllcorner 5.1\nyllcorner 52.5\n"
                    "cellsize 0.01\n" + "\n".join(["-9 " * 50] * 50))
        path = "/v1/soundings?columns=512&rows=512&spacing="
        with Daemon("--token-file", self.tokens, "--bathymetry",
                    folder.name) as daemon:
            daemon.token = TOKENS["instruct"]
            self.assertEqual(daemon.patch({"seabed": {
                "file": "flat.asc"}}).status, 200)
            asked = [daemon.connect_http() for _ in range(48)]
            for s in asked:
                self.addCleanup(s.close)
                s.sendall(head("GET", path + "50"))
            refused = until("a share is taken", lambda: daemon.metrics().get(
                "pelagos_shares_refused_total", 0))
            self.assertGreater(refused, 0)
            self.assertEqual(daemon.get(path + "1").status, 200)


class Unread(Case):
    def test_slow_readers_of_health(self):
        """A client that asks for /healthz and reads nothing keeps nobody out."""
        for _ in range(150):
            s = socket.socket()
            self.addCleanup(s.close)
            s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            s.connect(("127.0.0.1", self.daemon.http_port))
            s.setblocking(False)
            try:
                for _ in range(400):
                    s.send(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"
                           * 50)
            except OSError:
                pass
        for _ in range(20):
            self.assertEqual(self.daemon.get(
                "/healthz", headers={"Authorization": ""}).status, 200)
            self.assertEqual(self.daemon.patch({
                "sea": {"windSpeed": 9}}).status, 200)


if __name__ == "__main__":
    unittest.main(verbosity=2)
