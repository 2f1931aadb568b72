#!/usr/bin/python3
"""Floods of the sockets, each beside its bar (docs/reliability.md). SOAK=1:
the long form."""
import contextlib
import gzip
import os
import random
import resource
import selectors
import socket
import stat
import subprocess
import struct
import sys
import tempfile
import threading
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import pelagos_daemon
from cigi_network_test import Proxy
from live_client import Closed, Live
from pelagos_daemon import (SANITIZED, SLOW_S, Daemon, free_port, receive_all,
                            until)

SOAK = bool(os.environ.get("SOAK"))


def quantile(values, share):
    return sorted(values)[min(int(share * len(values)), len(values) - 1)]


def tell(what, figure, bar):
    print(f"{what}: {figure} (bar: {bar})", flush=True)


def many_descriptors(count):
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(count, hard), hard))
    return min(count, hard)


class Good(threading.Thread):
    """A client that asks for health all the time, each time anew; `waits`."""

    def __init__(self, daemon):
        super().__init__(daemon=True)
        self.daemon_, self.waits, self.over = daemon, [], threading.Event()
        self.start()

    def run(self):
        while not self.over.is_set():
            begin = time.monotonic()
            status = self.daemon_.get("/healthz").status
            self.waits.append(time.monotonic() - begin)
            assert status == 200, status
            time.sleep(0.01)

    def stop(self):
        self.over.set()
        self.join()
        return (f"{len(self.waits)} good requests, median "
                f"{1e3 * quantile(self.waits, 0.5):.1f}, p99 "
                f"{1e3 * quantile(self.waits, 0.99):.1f} ms")


class Sockets(unittest.TestCase):
    def start(self, *options):
        daemon = Daemon(*options)
        self.addCleanup(daemon.stop)
        daemon.patch({"views": [{"name": "bridge", "entity": 1, "width": 64,
                                 "height": 36}],
                      "sea": {"synthesiser": "TROCHOIDS"}})
        daemon.get("/v1/views/bridge/frame.jpg", timeout=SLOW_S)
        return daemon

    def test_few_descriptors(self):
        """So few that it could serve nobody: it says what it needs. With some
        more /healthz is answered however many others come."""
        done = subprocess.run(
            [f"{pelagos_daemon.BIN}/pelagosd", "--tcp", "127.0.0.1:0", "--http",
             "127.0.0.1:0"], capture_output=True, text=True, timeout=SLOW_S,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NOFILE,
                                                  (16, 16)))
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("16 file descriptors are allowed", done.stderr)
        self.assertIn("ulimit -n", done.stderr)
        daemon = self.start()
        hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
        resource.prlimit(daemon.process.pid, resource.RLIMIT_NOFILE, (64, hard))
        for i in range(120):
            s = socket.create_connection(("127.0.0.1", daemon.http_port), SLOW_S)
            self.addCleanup(s.close)
            if i % 2:
                s.sendall(b"GET /v1/state HTTP/1.1\r\nHost: localhost\r\n\r\n")
        for _ in range(20):
            self.assertEqual(daemon.get("/healthz").status, 200)

    def test_ten_thousand_connects(self):
        """At a limit of 256 descriptors."""
        count = min(10000, many_descriptors(12000) - 200)
        daemon = self.start()
        hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
        resource.prlimit(daemon.process.pid, resource.RLIMIT_NOFILE,
                         (256, hard))
        sockets = []
        begin = time.monotonic()
        for i in range(count):
            s = socket.socket()
            s.setblocking(False)
            with contextlib.suppress(OSError):
                s.connect(("127.0.0.1", (daemon.http_port,
                                         daemon.tcp_port)[i % 2]))
            sockets.append(s)
        connected = time.monotonic() - begin
        self.assertTrue(daemon.alive())
        for s in sockets:
            s.close()
        released = time.monotonic()

        def answers():
            with contextlib.suppress(OSError):
                return daemon.get("/healthz", timeout=1).status == 200
        until("it accepts again", answers)
        tell(f"{count} connects at a limit of 256 descriptors",
             f"{connected:.1f} s; alive, accepted again "
             f"{time.monotonic() - released:.2f} s after their release",
             "alive, 1 s")
        until("all are gone", lambda: daemon.metrics()[
            "pelagos_http_connections"] <= 2)
        self.assertGreater(
            daemon.metrics()["pelagos_starved_total"] +
            daemon.metrics()['pelagos_refused_total{input="http"}'] +
            daemon.metrics()["pelagos_http_evicted_total"], 0)

    def test_two_thousand_half_sent(self):
        """All stay open until the daemon ends them."""
        count = min(2000, many_descriptors(4000) - 200)
        daemon = self.start()
        heads = (b"GET / HTTP/1.1\r\nHost: l",
                 b"PATCH /v1/state HTTP/1.1\r\nHost: localhost\r\n"
                 b"Content-Type: application/json\r\nContent-Length: 999\r\n"
                 b"\r\n{", b"G", b"")
        good = Good(daemon)
        chosen = selectors.DefaultSelector()
        begin = time.monotonic()
        for i in range(count):
            s = daemon.connect_http()
            self.addCleanup(s.close)
            with contextlib.suppress(OSError):
                s.sendall(heads[i % len(heads)])
            s.setblocking(False)
            chosen.register(s, selectors.EVENT_READ)
        sent = time.monotonic()
        while chosen.get_map() and time.monotonic() - sent < SLOW_S:
            for key, _ in chosen.select(0.5):
                with contextlib.suppress(BlockingIOError):
                    try:
                        over = key.fileobj.recv(4096) == b""
                    except ConnectionError:
                        over = True
                    if over:
                        chosen.unregister(key.fileobj)
        self.assertFalse(chosen.get_map(), "some stay open")
        tell(f"{count} half-sent requests",
             f"all sent within {sent - begin:.1f} s, the last closed "
             f"{time.monotonic() - sent:.1f} s later; {good.stop()}",
             "15 s, p99 50 ms")

    def test_modbus_behind_1200_descriptors(self):
        """libmodbus and select() go to 1024."""
        port = free_port()
        many_descriptors(4000)
        before = pelagos_daemon.BIN
        with tempfile.TemporaryDirectory() as folder:
            wrapper = os.path.join(folder, "pelagosd")
            with open(wrapper, "w", encoding="ascii") as f:
                f.write("#!/usr/bin/python3\nimport os, resource, sys\n"
                        "most = resource.getrlimit(resource.RLIMIT_NOFILE)[1]\n"
                        "resource.setrlimit(resource.RLIMIT_NOFILE, "
                        "(min(4096, most), most))\n"
                        "for i in range(1200):\n    os.set_inheritable("
                        "os.open('/dev/null', os.O_RDONLY), True)\n"
                        f"os.execv('{before}/pelagosd', sys.argv)\n")
            os.chmod(wrapper, stat.S_IRWXU)
            pelagos_daemon.BIN = folder
            try:
                daemon = self.start("--modbus", f"127.0.0.1:{port}")
            finally:
                pelagos_daemon.BIN = before
        held = len(os.listdir(f"/proc/{daemon.process.pid}/fd"))
        self.assertGreater(held, 1200)
        waits = []
        with socket.create_connection(("127.0.0.1", port), SLOW_S) as s:
            for i in range(100):
                begin = time.monotonic()
                s.sendall(struct.pack(">HHHBBHH", i, 0, 6, 1, 3, 0, 2))
                answer = s.recv(300)
                waits.append(time.monotonic() - begin)
                self.assertEqual(answer[:2], struct.pack(">H", i))
                self.assertEqual(answer[7], 3)
        tell(f"a Modbus client behind {held} descriptors",
             f"median {1e3 * quantile(waits, .5):.1f}, slowest "
             f"{1e3 * max(waits):.1f} ms", "20 ms")

    def grown(self, daemon, before):
        grown = (daemon.rss() - before) / (1 << 20)
        if not SANITIZED:
            self.assertLess(grown, 8)
        return f"grown by {grown:.1f} MiB"

    def test_endless_websocket_message(self):
        daemon = self.start()
        with Live(daemon, "bridge", "?codec=jpeg") as live:
            live.ack(live.picture()[0])
        before = daemon.rss()
        for size in (0, 1, 120):
            with Live(daemon, "bridge", "?codec=jpeg") as live:
                sent = 0
                live.socket.settimeout(0.2)
                live.send_frame(2, b"", final=False)
                block = b"".join(self.fragment(b"x" * size)
                                 for _ in range(100))
                begin = time.monotonic()
                limit = 10 if SOAK else 3
                with contextlib.suppress(OSError):
                    while time.monotonic() - begin < limit:
                        live.socket.sendall(block)
                        sent += 100
                closed = time.monotonic() - begin < limit
                live.socket.settimeout(SLOW_S)
                code = None
                with contextlib.suppress(OSError):
                    try:
                        while closed:
                            live.message()
                    except Closed as end:
                        code = end.code
            tell(f"endless message in fragments of {size} bytes",
                 f"{sent} fragments on the way, closed with {code}; "
                 f"{self.grown(daemon, before)}", "64 KiB, 2 MiB")
            self.assertTrue(closed)
        self.assertEqual(daemon.get("/healthz").status, 200)

    def fragment(self, data):
        mask = os.urandom(4)
        head = struct.pack(">BB", 0, 0x80 | len(data)) if len(data) < 126 \
            else struct.pack(">BBH", 0, 0x80 | 126, len(data))
        return head + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(data))

    def test_compressed_bombs(self):
        """Nothing is ever inflated: over HTTP it is no JSON, and a compressed
        WebSocket frame is an error."""
        daemon = self.start()
        before = daemon.rss()
        bomb = gzip.compress(b'{"sea":{"windSpeed":1' + b" " * (60 << 20) +
                             b"}}")
        self.assertLess(len(bomb), 65536)
        for encoding in ("gzip", "deflate", "br", "x"):
            answer = daemon.patch(bomb, headers={
                "Content-Type": "application/json",
                "Content-Encoding": encoding})
            self.assertIn(answer.status, (400, 415))
        with Live(daemon, "bridge", "?codec=jpeg", headers={
                "Sec-WebSocket-Extensions": "permessage-deflate"}) as live:
            self.assertNotIn("permessage-deflate", live.head)
            live.socket.sendall(bytes([0xc2]) + self.fragment(b"x" * 20)[1:])
            with self.assertRaises(Closed) as caught:
                while True:
                    live.message()
            self.assertEqual(caught.exception.code, 1002)
        tell("bombs of 60 MiB in 60 KiB over HTTP, a compressed WebSocket "
             "frame", f"400, 1002; {self.grown(daemon, before)}", "2 MiB")

    def test_300_megabytes(self):
        daemon = self.start()
        before = daemon.rss()
        block = b"x" * 65536
        sent = 0
        with daemon.connect_http() as s:
            s.sendall(b"PATCH /v1/state HTTP/1.1\r\nHost: localhost\r\n"
                      b"Content-Type: application/json\r\n"
                      b"Transfer-Encoding: chunked\r\n\r\n")
            with contextlib.suppress(OSError):
                for _ in range(300 * 16):
                    s.sendall(b"10000\r\n" + block + b"\r\n")
                    sent += 65536
            receive_all(s)
        tell("a body of 300 MB", f"refused, {sent >> 10} KiB of it on the "
             f"way; {self.grown(daemon, before)}", "2 MiB")
        self.assertLess(sent, 16 << 20)


def sentence(body):
    total = 0
    for c in body.encode():
        total ^= c
    return f"${body}*{total:02X}\r\n".encode()


class Udp(unittest.TestCase):
    """CIGI is in cigi_network_test.py."""

    def test_nmea_by_a_bad_network(self):
        """Positions of a ship that sails due north, and its heading, by
        datagrams that are lost, doubled and held back."""
        port = free_port(socket.SOCK_DGRAM)
        with Daemon("--nmea", f"127.0.0.1:{port}") as daemon:
            daemon.patch({"sea": {"synthesiser": "TROCHOIDS"}})
            for loss, double, hold in ((.05, 0, 0), (.15, .1, .1),
                                       (.3, .2, .2)):
                proxy = Proxy(("127.0.0.1", port), 5, loss, double, hold)
                out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
                out.connect(proxy.address)

                def send(number):
                    minutes = number * 0.01
                    clock = f"12{number // 600:02d}{number % 600 / 10:05.2f}"
                    out.send(sentence(
                        f"GPRMC,{clock},A,52{minutes:07.4f},N,00400.0000,E,"
                        "10.0,0.0,210626,,,A") +
                        sentence(f"HEHDT,{number % 360}.0,T"))

                def north():
                    ship = next(e for e in daemon.state()["entities"]
                                if int(e["id"]) == 1)
                    return ship["latitude"], ship["heading"]
                malformed = self.dropped(daemon)
                newest, back, seen = 0, 0, 0
                count = 400 if SOAK else 150
                for number in range(1, count):
                    send(number)
                    time.sleep(0.005)
                    if number % 10 == 0:
                        # What is shown is of one datagram, never a mixture.
                        latitude, heading = north()
                        seen += 1
                        back += latitude < newest - 1e-4
                        newest = max(newest, latitude)
                proxy.loss = proxy.double = proxy.hold = 0
                time.sleep(0.2)  # what was held back is out
                for number in (count, count + 1):
                    send(number)
                wanted = 52 + (count + 1) * 0.01 / 60
                until("clean within two datagrams", lambda: abs(
                    north()[0] - wanted) < 1e-3 and
                    abs(north()[1] - (count + 1) % 360) < 0.5, 5)
                self.assertEqual(self.dropped(daemon), malformed)
                tell(f"NMEA, {loss:.0%} lost, {proxy.doubled} doubled, "
                     f"{proxy.held} held back",
                     f"{back} of {seen} looks saw an older place; clean two "
                     "datagrams after the end", "0, 2")
                self.assertEqual(back, 0)
                out.close()
                proxy.stop()

    def dropped(self, daemon):
        return sum(value for name, value in daemon.metrics().items()
                   if name.startswith("pelagos_nmea_dropped_total"))


if __name__ == "__main__":
    random.seed(1)
    unittest.main(verbosity=2)
