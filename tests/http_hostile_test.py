#!/usr/bin/python3
"""HTTP by clients that are slow, hostile or both."""
import contextlib
import json
import os
import random
import re
import socket
import struct
import sys
import threading
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from http_case import HttpCase, without_time
from pelagos_daemon import SANITIZED, SLOW_S, Daemon, receive_all, until

MALFORMED = 'pelagos_malformed_total{input="http"}'
ENCODED = "pelagos_frames_encoded_total"
DROPPED = "pelagos_mjpeg_frames_dropped_total"


def patch_request(head, body=b'{"sea":{"windSpeed":29}}'):
    return b"PATCH /v1/state HTTP/1.1\r\n" + head + b"\r\n" + body


class Hostile(HttpCase):
    def unchanged(self):
        self.assertEqual(without_time(self.daemon.state()), self.before)

    def test_one_host(self):
        for head in (b"", b"Host: localhost\r\nHost: localhost\r\n"):
            answer = self.daemon.raw(
                b"GET /v1/state HTTP/1.1\r\n" + head + b"\r\n")
            self.assertEqual(answer.count(b"HTTP/1.1 400"), 1, answer)
            self.assertIn(b"application/problem+json", answer)

    def test_smuggling(self):
        host = b"Host: localhost\r\n"
        kind = b"Content-Type: application/json\r\n"
        body = b'{"sea":{"windSpeed":29}}'
        chunked = b"%x\r\n%s\r\n0\r\n\r\n" % (len(body), body)
        length = b"Content-Length: %d\r\n" % len(body)
        for head, data in (
                (host + kind + length + b"Transfer-Encoding: chunked\r\n",
                 chunked),
                (host + kind + b"Transfer-Encoding: chunked\r\n" + length,
                 chunked),
                (host + kind + length + b"Content-Length: 5\r\n", body),
                (host + kind + length + length, body),
                (host + kind + b"Content-Length: +24\r\n", body),
                (host + kind + b"Content-Length: -1\r\n", body),
                (host + kind + b"Content-Length: 0x18\r\n", body),
                (host + kind + b"Transfer-Encoding: xchunked\r\n", chunked),
                (host + kind + b"Transfer-Encoding: chunked, identity\r\n",
                 chunked),
                (kind + length, body),
                (host + host + kind + length, body),
                (host + kind + length + b" folded: 1\r\nX : y\r\n", body)):
            answer = self.daemon.raw(patch_request(head, data) +
                                     b"GET /healthz HTTP/1.1\r\n" + host +
                                     b"\r\n")
            self.assertNotIn(b" 200 ", answer.split(b"\r\n")[0], head)
            # What follows a doubtful message is not read as a request.
            # (libmicrohttpd 0.9.75 sends the head of its own 400 twice.)
            answers = set(re.findall(rb"HTTP/1\.1 (\d+)", answer))
            self.assertLessEqual(len(answers), 1, (head, answer))
            self.assertNotIn(b'"status":"ok"', answer)
            self.unchanged()

    def test_300_megabytes(self):
        before = self.daemon.rss()
        block = b"x" * 65536

        def send(head, chunked):
            with self.daemon.connect_http() as s:
                s.sendall(patch_request(
                    b"Host: localhost\r\nContent-Type: application/json\r\n" +
                    head, b""))
                with contextlib.suppress(OSError):
                    for _ in range(300 * 16):
                        s.sendall((b"10000\r\n" + block + b"\r\n")
                                  if chunked else block)
                return receive_all(s)

        answer = send(b"Content-Length: 314572800\r\n", False)
        self.assertTrue(not answer or b" 413 " in answer[:20], answer[:80])
        send(b"Transfer-Encoding: chunked\r\n", True)
        # The bar is 2 MB; a picture drawn meanwhile may cost a little more.
        if not SANITIZED:
            self.assertLess(self.daemon.rss() - before, 4e6)
        self.unchanged()

    def test_large_headers(self):
        answer = self.daemon.raw(b"GET / HTTP/1.1\r\nHost: localhost\r\nX: " +
                                 b"y" * 40000 + b"\r\n\r\n")
        self.assertRegex(answer[:13], rb"HTTP/1.1 4\d\d")
        many = b"".join(b"X%d: y\r\n" % i for i in range(100))
        answer = self.daemon.raw(b"GET / HTTP/1.1\r\nHost: localhost\r\n" +
                                 b"Connection: close\r\n" + many + b"\r\n")
        self.assertRegex(answer[:13], rb"HTTP/1.1 4\d\d")

    def test_pages_of_the_library(self):
        """What is no HTTP is refused by libmicrohttpd before we are asked, as
        the manual says: a bare status, and the end."""
        for status, head in ((505, b"GET / HTTP/3.0\r\nHost: localhost"),
                             (400, b"GET / HTTP/1.1\r\nHost: localhost\r\nX")):
            answer = self.daemon.raw(head + b"\r\n\r\n")
            self.assertEqual(answer[:13], b"HTTP/1.1 %d " % status)
            self.assertIn(b"Connection: close", answer)
            self.assertIn(b"<html>", answer)
        self.assertEqual(self.daemon.raw(b"GARBAGE\r\n\r\n"), b"")
        self.unchanged()

    def refused_once(self, answer, status=400):
        """One head, problem+json, and the end."""
        self.assertEqual(answer.count(b"HTTP/1.1"), 1, answer)
        head, body = answer.split(b"\r\n\r\n")
        self.assertTrue(head.startswith(b"HTTP/1.1 %d " % status), head)
        self.assertIn(b"Connection: close", head)
        self.assertIn(b"application/problem+json", head)
        self.assertEqual(json.loads(body)["status"], status)

    def test_lengths_that_are_none(self):
        """libmicrohttpd writes the head of its own answer twice."""
        for length in (b"x", b"", b"+24", b"-1", b"0x18", b"2 4", b"24,24",
                       b"9" * 30):
            counted = self.daemon.metrics()[MALFORMED]
            self.refused_once(self.daemon.raw(patch_request(
                b"Host: localhost\r\nContent-Type: application/json\r\n"
                b"Content-Length: " + length + b"\r\n")))
            self.assertGreater(self.daemon.metrics()[MALFORMED], counted)
        self.unchanged()

    def test_line_longer_than_memory(self):
        """The line of a chunk's size: libmicrohttpd turned over it on a core
        until its client had been silent for 10 s."""
        for line in (b"0" * 20000, b"1;" + b"x" * 20000,
                     b"1\r\n{\r\n" + b"0" * 20000):
            before = self.daemon.control_cpu()
            begin = time.monotonic()
            self.refused_once(self.daemon.raw(patch_request(
                b"Host: localhost\r\nContent-Type: application/json\r\n"
                b"Transfer-Encoding: chunked\r\n", line)))
            print(f"line of 20,000 bytes: closed after "
                  f"{time.monotonic() - begin:.3f} s, "
                  f"{self.daemon.control_cpu() - before:.3f} s of processor "
                  "(bar 0.25 s)")
            self.assertLess(self.daemon.control_cpu() - before, 1)
        self.unchanged()

    def test_nul_in_the_head(self):
        """What follows it would not be read."""
        host = b"Host: localhost\r\n"
        end = b"Connection: close\r\n\r\n"
        for head in (b"GET /v1/state HTTP/1.1\r\nHost: localhost\0.example\r\n",
                     b"GET /v1/state HTTP/1.1\r\n" + host + b"X: a\0b\r\n",
                     b"GET /v1/state\0/sea HTTP/1.1\r\n" + host,
                     b"GET /v1/state\0 HTTP/1.1\r\n" + host,
                     b"GET\0T /v1/state HTTP/1.1\r\n" + host,
                     b"GET /v1/state HTTP/1.1\r\n" + host +
                     b"X: a\r\n folded: b\r\n"):
            answer = self.daemon.raw(head + end)
            self.assertRegex(answer, rb"^HTTP/1.1 400 (?s:.)*has a NUL", head)
        # What is odd, and plain.
        for head in (b"GET /healthz?%41=b%20c HTTP/1.1\r\nHost:localhost\r\n"
                     b"X:\t a b \t\r\nEmpty:\r\nCookie: a=b; c=d\r\n",
                     b"GET /v1/%73tate HTTP/1.1\n" + host,
                     b"GET /healthz HTTP/1.0\r\n" + host):
            answer = self.daemon.raw(head + end)
            self.assertNotIn(b"has a NUL", answer)
            self.assertIn(b"HTTP/1.", answer)

    def test_half_sent_and_dripping(self):
        """All are closed, and a good client is served meanwhile."""
        starts = (b"", b"GET", b"GET / HTTP/1.1\r\n",
                  b"GET / HTTP/1.1\r\nHost: loc",
                  b"PATCH /v1/state HTTP/1.1\r\nHost: localhost\r\n"
                  b"Content-Type: application/json\r\n"
                  b"Content-Length: 1000\r\n\r\n{")
        sockets = []
        for i in range(100):
            s = self.daemon.connect_http()
            s.sendall(starts[i % len(starts)])
            s.setblocking(False)
            self.addCleanup(s.close)
            sockets.append((s, i % 2 == 1))
        begin = time.monotonic()
        waits, deaths = [], {}
        while (time.monotonic() - begin < SLOW_S
               and len(deaths) < len(sockets)):
            for i, (s, drips) in enumerate(sockets):
                if i in deaths:
                    continue
                with contextlib.suppress(BlockingIOError):
                    try:
                        if drips:
                            s.send(b"x")
                        if s.recv(4096) == b"":
                            deaths[i] = time.monotonic() - begin
                    except ConnectionError:
                        deaths[i] = time.monotonic() - begin
            start = time.monotonic()
            self.assertEqual(self.daemon.get("/healthz").status, 200)
            waits.append(time.monotonic() - start)
            time.sleep(0.2)
        for s, _ in sockets:
            s.close()
        self.assertEqual(len(deaths), len(sockets), "some stay open")
        tell(waits)
        self.assertGreater(self.daemon.metrics()[
            'pelagos_timeouts_total{input="http"}'], 0)

    def malformed_message(self, rng, kind, good):
        if kind == 0:  # noise
            return bytes(rng.randrange(256) for _ in range(200))
        if kind == 1:  # broken on the request line
            return rng.choice([
                b"G\0T / HTTP/1.1", b"GET / HTTQ/1.1", b"GET nowhere HTTP/1.1",
                b"GET /%% HTTP/1.1"]) + b"\r\nHost: localhost\r\n" \
                b"Connection: close\r\n\r\n"
        if kind == 2:  # half of a message
            return good[:rng.randrange(1, len(good) - 1)]
        while True:  # a body that is not JSON
            at = len(good) - rng.randrange(1, 25)
            data = good[:at] + bytes([rng.randrange(256)]) + good[at + 1:]
            try:
                json.loads(data[-24:])
            except ValueError:
                return data

    def test_thousand_malformed(self):
        rng = random.Random(5)
        good = patch_request(b"Host: localhost\r\nContent-Type: "
                             b"application/json\r\nContent-Length: 24\r\n"
                             b"Connection: close\r\n")
        counted = self.daemon.metrics()[MALFORMED]
        for batch in range(20):
            sockets = []
            for i in range(50):
                data = self.malformed_message(rng, i % 4, good)
                s = self.daemon.connect_http()
                s.sendall(data)
                s.shutdown(socket.SHUT_WR)
                sockets.append((s, data))
            for s, data in sockets:
                answer = receive_all(s)
                self.assertFalse(answer.startswith(b"HTTP/1.1 2"),
                                 (data, answer))
                s.close()
        self.unchanged()
        until("all are counted", lambda: self.daemon.metrics()[MALFORMED]
              - counted >= 1000)

    def test_vanished_clients_cost_nothing(self):
        for _ in range(30):
            s = self.daemon.connect_http()
            s.sendall(b"GET /v1/views/bridge/frame.png?width=2048&height=1024 "
                      b"HTTP/1.1\r\nHost: localhost\r\n\r\n")
            s.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER,
                         struct.pack("ii", 1, 0))
            s.close()
        until("nothing waits", lambda: self.daemon.metrics()[
            "pelagos_frames_requests_waiting"] == 0)
        until("all are gone", lambda: self.daemon.metrics()[
            "pelagos_http_connections"] <= 2)

    def test_two_thousand_half_sent(self):
        """They crowd each other out, not the one who asks properly."""
        sockets = []
        waits = []
        for i in range(2000):
            s = self.daemon.connect_http()
            s.sendall(b"GET / HTTP/1.1\r\nHost: l")
            sockets.append(s)
            self.addCleanup(s.close)
            if i % 20 == 0:
                start = time.monotonic()
                self.assertEqual(self.daemon.get("/healthz").status, 200)
                waits.append(time.monotonic() - start)
            if len(sockets) > 500:
                sockets.pop(0).close()
        tell(waits)
        # Newcomers, and 128 that are being closed.
        self.assertLessEqual(
            self.daemon.metrics()["pelagos_http_connections"], 512 + 128)

    def test_two_thousand_half_bodies(self):
        """As above; they have got further."""
        head = (b"PATCH /v1/state HTTP/1.1\r\nHost: localhost\r\nContent-Type:"
                b" application/json\r\nContent-Length: 1000\r\n\r\n{")
        sockets = []
        for i in range(2000):
            s = self.daemon.connect_http()
            s.sendall(head)
            sockets.append(s)
            self.addCleanup(s.close)
            if i % 50 == 0:
                self.assertEqual(self.daemon.get("/healthz").status, 200)
                self.assertEqual(self.daemon.get("/v1/state").status, 200)
            if len(sockets) > 500:
                sockets.pop(0).close()
        self.unchanged()

    def stream(self, more=b""):
        s = self.daemon.connect_http()
        self.addCleanup(s.close)
        s.sendall(b"GET /v1/views/bridge/mjpeg?fps=0.2 HTTP/1.1\r\n"
                  b"Host: localhost\r\n" + more + b"\r\n")
        return s, s.recv(100).split()[1]

    def test_connection_limit(self):
        """Streams leave an eighth of the places to other requests; when all
        are taken, health has a few of its own."""
        streams = [self.stream() for _ in range(120)]
        self.assertEqual([status for _, status in streams],
                         [b"200"] * 112 + [b"429"] * 8)
        self.assertEqual(self.daemon.get("/healthz").status, 200)
        self.assertEqual(self.daemon.get("/v1/state").status, 200)
        # Answers that take long cannot make room.
        self.daemon.patch({"clock": {"mode": "STEPPED"}})
        slow = []
        for _ in range(16):
            s = self.daemon.connect_http()
            self.addCleanup(s.close)
            s.sendall(b"GET /v1/views/bridge/frame.png?width=4096&height=4096 "
                      b"HTTP/1.1\r\nHost: localhost\r\n\r\n")
            slow.append(s)
        answer = self.daemon.raw(b"GET /healthz HTTP/1.1\r\n"
                                 b"Host: localhost\r\n"
                                 b"Connection: close\r\n\r\n")
        self.assertIn(b'"status"', answer)
        for s, _ in streams:
            s.close()
        for s in slow:
            s.close()
        until("there is room",
              lambda: self.daemon.get("/v1/state").status == 200)
        until("what nobody waits for is dropped",
              lambda: self.daemon.metrics()[
                  "pelagos_frames_requests_waiting"] == 0)

    def test_forwarded_addresses(self):
        """Only a proxy that is named may say for whom it asks."""
        one, other = (b"X-Forwarded-For: 198.51.100.9, 203.0.113.%d\r\n" % i
                      for i in (5, 6))
        self.assertEqual([self.stream(one)[1] for _ in range(17)],
                         [b"200"] * 17)
        with Daemon("--trust-proxy", "127.0.0.1") as daemon:
            before, type(self).daemon = self.daemon, daemon
            try:
                self.assertEqual([self.stream(one)[1] for _ in range(17)],
                                 [b"200"] * 16 + [b"429"])
                self.assertEqual(self.stream(other)[1], b"200")
                self.assertEqual(self.stream()[1], b"200")
            finally:
                type(self).daemon = before


def tell(waits):
    """Figures only: this machine may be busy. The bar of p99 is 50 ms."""
    waits = sorted(1e3 * w for w in waits)
    print(f"healthz: median {waits[len(waits) // 2]:.1f}, p99 "
          f"{waits[int(0.99 * len(waits))]:.1f} ms of {len(waits)}")


class Viewer(threading.Thread):
    """Reads Motion JPEG and counts the pictures."""

    def __init__(self, daemon, query=""):
        super().__init__(daemon=True)
        self.socket = daemon.connect_http()
        self.socket.sendall(f"GET /v1/views/bridge/mjpeg{query} HTTP/1.1\r\n"
                            "Host: localhost\r\n\r\n".encode())
        self.stamps, self.numbers, self.bad = [], [], 0
        self.head = ""
        self.start()

    def run(self):
        with contextlib.suppress(OSError, ValueError):
            f = self.socket.makefile("rb")
            while (line := f.readline()) != b"\r\n":
                self.head += line.decode()
            while line := f.readline():
                if line.startswith(b"Content-Length:"):
                    length = int(line.split()[1])
                elif line.startswith(b"X-Pelagos-Frame:"):
                    self.numbers.append(int(line.split()[1]))
                elif line == b"\r\n" and len(self.numbers) > len(self.stamps):
                    data = f.read(length)
                    self.bad += (data[:2] != b"\xff\xd8" or
                                 data[-2:] != b"\xff\xd9")
                    self.stamps.append(time.monotonic())

    def close(self):
        self.socket.shutdown(socket.SHUT_RDWR)
        self.join()
        self.socket.close()


class Streams(HttpCase):
    def test_stream(self):
        until("nobody watches",
              lambda: self.daemon.metrics()["pelagos_mjpeg_viewers"] == 0)
        begin = time.monotonic()
        viewer = Viewer(self.daemon)
        slow = Viewer(self.daemon, "?fps=5&quality=30")
        until("live pictures", lambda: len(viewer.stamps) >= 60)
        self.assertIn("multipart/x-mixed-replace; boundary=pelagos",
                      viewer.head)
        seen = len(slow.stamps)
        self.assertGreater(seen, 0)
        self.assertLess(seen, 5 * (time.monotonic() - begin) + 2)
        self.assertEqual((viewer.bad, slow.bad), (0, 0))
        self.assertEqual(viewer.numbers, sorted(set(viewer.numbers)))
        self.assertEqual(self.daemon.metrics()["pelagos_mjpeg_viewers"], 2)
        viewer.close()
        # Deleting the view ends the stream.
        self.daemon.request("DELETE", "/v1/views/bridge")
        slow.join(SLOW_S)
        self.assertFalse(slow.is_alive())
        slow.socket.close()
        until("nobody watches",
              lambda: self.daemon.metrics()["pelagos_mjpeg_viewers"] == 0)

    def test_stalled_viewers(self):
        """Twenty that never read cost the good one nothing, and little
        memory."""
        self.daemon.patch({"views": {"bridge": {"width": 1280,
                                                "height": 720}}})
        good = Viewer(self.daemon)
        self.addCleanup(good.close)
        until("live pictures", lambda: len(good.stamps) >= 10)
        before = self.daemon.rss()
        stalled = []
        for _ in range(20):
            s = socket.socket()
            self.addCleanup(s.close)
            s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            s.connect(("127.0.0.1", self.daemon.http_port))
            s.sendall(b"GET /v1/views/bridge/mjpeg HTTP/1.1\r\n"
                      b"Host: localhost\r\n\r\n")
            stalled.append(s)
        until("they are there", lambda: self.daemon.metrics()[
            "pelagos_mjpeg_viewers"] == 21)
        encoded, seen = -self.daemon.metrics()[ENCODED], -len(good.stamps)
        until("pictures are dropped for them",
              lambda: self.daemon.metrics()[DROPPED] > 60)
        encoded += self.daemon.metrics()[ENCODED]
        until("the good one has what was encoded",
              lambda: len(good.stamps) + seen >= encoded // 2)
        grown = self.daemon.rss() - before
        self.assertEqual(self.daemon.metrics()["pelagos_mjpeg_viewers"], 21)
        self.assertEqual(good.bad, 0)
        if not SANITIZED:
            # Two pictures and 64 KiB each would be 20 × 0.4 MB.
            self.assertLess(grown, 16e6)


class Sockets(unittest.TestCase):
    def test_out_of_descriptors(self):
        """At its descriptor limit the daemon refuses, does not spin, and
        accepts again."""
        import resource
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        with Daemon() as daemon:
            daemon.get("/v1/views/bridge/frame.jpg")  # it has settled
            resource.prlimit(daemon.process.pid, resource.RLIMIT_NOFILE,
                             (80, hard))
            sockets = []
            for _ in range(120):
                with contextlib.suppress(OSError):
                    sockets.append(daemon.connect_http(2))
            held = f"/proc/{daemon.process.pid}/fd"
            until("it has what it may", lambda: len(os.listdir(held)) >= 79)
            busy = cpu_seconds(daemon.process.pid)
            time.sleep(1)
            self.assertLess(cpu_seconds(daemon.process.pid) - busy, 0.5)
            for s in sockets:
                s.close()

            def answers():
                with contextlib.suppress(OSError):
                    return daemon.get("/healthz", timeout=2).status == 200
            until("it accepts again", answers)
            self.assertGreater(daemon.metrics()["pelagos_starved_total"], 0)

    def test_remote_address_is_refused(self):
        with self.assertRaises(RuntimeError) as caught:
            Daemon("--http", "0.0.0.0:0")
        self.assertIn("not loopback", str(caught.exception))


def cpu_seconds(pid):
    with open(f"/proc/{pid}/stat") as f:
        fields = f.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    unittest.main(verbosity=2)
