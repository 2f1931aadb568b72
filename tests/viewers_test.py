#!/usr/bin/python3
"""Thousands of viewers: HLS through two edges (packaging/nginx/edge.conf) behind
packaging/haproxy/haproxy.cfg, as they ship. READERS (40; `make viewers-check`:
500) players read one view; an edge is killed under them. Prints how often the
daemon was asked for a piece, and how long readers stood still."""
import asyncio
import collections
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from hls_test import LIST, Playlist
from pelagos_daemon import ROOT, SLOW_S, Daemon, free_port, until

for program in "nginx", "haproxy":
    if not shutil.which(program):
        print(f"{program} is not installed")
        sys.exit(77)
READERS = int(os.environ.get("READERS", "40"))
PLAY_S = float(os.environ.get("PLAY_S", "12"))
# Of the design: an edge asks at most once, and there are two; who read from the
# one that is killed goes on with the other.
MOST_ASKED, RESUMED_S = 2, 5.0


def read(path):
    with open(os.path.join(ROOT, path), encoding="ascii") as f:
        return f.read()


def changed(text, *changes):
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    return text


class Edges:
    """The shipped configurations, on ports and folders of their own."""

    def __init__(self, daemon):
        self.folder = tempfile.mkdtemp(prefix="pelagos-edges-")
        os.chmod(self.folder, 0o777)
        self.ports = [free_port(), free_port()]
        self.watch, self.steer = free_port(), free_port()
        self.logs = []
        self.edges = [self.edge(i, port, daemon)
                      for i, port in enumerate(self.ports)]
        config = changed(
            read("packaging/haproxy/haproxy.cfg"),
            ("127.0.0.1:8091", f"127.0.0.1:{self.ports[0]}"),
            ("127.0.0.1:8092", f"127.0.0.1:{self.ports[1]}"),
            ("127.0.0.1:8081", f"127.0.0.1:{daemon.http_port}"),
            ("127.0.0.1:8082", f"127.0.0.1:{daemon.http_port}"),
            ("bind :8090", f"bind 127.0.0.1:{self.watch}"),
            ("bind :8080", f"bind 127.0.0.1:{self.steer}"))
        path = self.write("haproxy.cfg", config)
        subprocess.run(["haproxy", "-c", "-q", "-f", path], check=True)
        self.balancer = subprocess.Popen(["haproxy", "-q", "-f", path],
                                         stderr=subprocess.DEVNULL)
        try:
            for port in *self.ports, self.watch:
                until(f"port {port}", lambda p=port: self.listens(p))
        except AssertionError:
            self.stop()
            raise

    @staticmethod
    def listens(port):
        with socket.socket() as s:
            return s.connect_ex(("127.0.0.1", port)) == 0

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        with open(path, "w", encoding="ascii") as f:
            f.write(text)
        return path

    def edge(self, number, port, daemon):
        home = os.path.join(self.folder, f"edge{number}")
        os.makedirs(home)
        shipped = re.sub(r" *listen \[::\].*\n", "", changed(
            read("packaging/nginx/edge.conf"),
            ("/var/cache/nginx/pelagos", f"{home}/cache"),
            ("127.0.0.1:8080", f"127.0.0.1:{daemon.http_port}"),
            ("listen 80;", f"listen 127.0.0.1:{port};"),
            ("ocean.example", "localhost")))
        temporary = "".join(f"{name}_temp_path {home}/{name};" for name in (
            "client_body", "proxy", "fastcgi", "uwsgi", "scgi"))
        self.write(f"edge{number}/edge.conf", shipped)
        log = os.path.join(home, "asked.log")
        self.logs.append(log)
        # What it asked the daemon for, a line each.
        config = self.write(f"edge{number}/nginx.conf", (
            f"daemon off; master_process off; pid {home}/pid;"
            f"error_log {home}/error.log; user root;"
            "events { worker_connections 4096; } http {"
            "map $upstream_addr $asked { '' 0; default 1; }"
            "log_format asked '$request_uri $upstream_status';"
            f"access_log {log} asked if=$asked; {temporary}"
            f"include {home}/edge.conf; }}"))
        return subprocess.Popen(
            ["nginx", "-p", home, "-c", config, "-e", f"{home}/error.log"],
            stdin=subprocess.DEVNULL)

    def asked(self):
        """How often the daemon was asked for each, by all edges."""
        counts = collections.Counter()
        for log in self.logs:
            with open(log, encoding="ascii") as f:
                counts.update(line.split()[0] for line in f)
        return counts

    def stop(self):
        for process in *self.edges, self.balancer:
            if process.poll() is None:
                process.terminate()
            process.wait()
        shutil.rmtree(self.folder)


class Reader:
    """One player: the newest playlist, then each segment once."""

    def __init__(self, port):
        self.port = port
        self.got, self.stamps, self.faults = {}, [], 0

    async def get(self, path):
        reader, writer = await asyncio.wait_for(
            asyncio.open_connection("127.0.0.1", self.port), 5)
        try:
            writer.write(f"GET {path} HTTP/1.1\r\nHost: localhost\r\n"
                         "Connection: close\r\n\r\n".encode())
            answer = await asyncio.wait_for(reader.read(-1), 10)
        finally:
            writer.close()
        head, _, body = answer.partition(b"\r\n\r\n")
        if b" 200 " not in head.split(b"\r\n")[0]:
            raise OSError(head[:60])
        length = re.search(rb"(?i)content-length: (\d+)", head)
        if length and int(length.group(1)) != len(body):
            raise OSError("cut off")
        if b"chunked" in head.lower():
            raise OSError("of no known length")
        return body

    async def run(self, until_s):
        query, last = "", -1
        while time.monotonic() < until_s:
            try:
                p = Playlist((await self.get(LIST + query)).decode())
                for i, s in enumerate(p.segments):
                    if p.first + i > last:
                        self.got[s["path"]] = await self.get(s["path"])
                        self.stamps.append(time.monotonic())
                        last = p.first + i
                query = f"?_HLS_msn={last + 1}"
            except (OSError, asyncio.TimeoutError):
                self.faults += 1
                query = ""
                await asyncio.sleep(0.2)


class Viewers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon("--quality", "full", "--rtsp", "127.0.0.1:0")
        cls.daemon.patch({"views": [
            {"name": "bridge", "entity": 1, "width": 160, "height": 90}]})
        cls.addClassCleanup(cls.daemon.stop)
        cls.edges = Edges(cls.daemon)
        cls.addClassCleanup(cls.edges.stop)

    def test_an_edge_dies(self):
        begun = time.monotonic()
        readers = [Reader(self.edges.watch) for _ in range(READERS)]

        async def play():
            async def die():
                await asyncio.sleep(PLAY_S / 2)
                self.edges.edges[0].send_signal(signal.SIGKILL)
                return time.monotonic()
            end = begun + PLAY_S
            died, *_ = await asyncio.gather(
                die(), *(r.run(end) for r in readers))
            return died
        died = asyncio.run(play())
        asked = self.edges.asked()
        pieces = {p: n for p, n in asked.items() if p.startswith("/v1/hls/")}
        still = [max(b - a for a, b in zip(
            [s for s in r.stamps if s <= died][-1:] +
            [s for s in r.stamps if s > died],
            [s for s in r.stamps if s > died] + [begun + PLAY_S]))
            for r in readers]
        sent = sum(len(r.got) for r in readers)
        print(f"{READERS} readers, {sent} segments to them, {len(pieces)} "
              f"different; the daemon was asked for one at most "
              f"{max(pieces.values())} times; an edge was killed: readers stood "
              f"still for {max(still):.1f} s at most, "
              f"{sum(r.faults for r in readers)} requests failed")
        self.assertLessEqual(max(pieces.values()), MOST_ASKED)
        self.assertLessEqual(max(still), RESUMED_S)
        # All have seen the same bytes.
        seen = {}
        for r in readers:
            self.assertGreater(len(r.got), 3)
            for path, body in r.got.items():
                self.assertEqual(seen.setdefault(path, body), body)

    @unittest.skipUnless(shutil.which("ffmpeg"), "no ffmpeg")
    def test_relay_takes_rtsp_once(self):
        port = re.search(r"NET-006 .*:(\d+)/VIEW", self.daemon.log()).group(1)
        folder = os.path.join(self.edges.folder, "relay")
        os.makedirs(folder)
        relay = subprocess.Popen(
            [os.path.join(ROOT, "packaging/relay/pelagos-relay"),
             f"rtsp://127.0.0.1:{port}/bridge", folder],
            stderr=subprocess.DEVNULL)
        try:
            def segments():
                try:
                    with open(f"{folder}/index.m3u8", encoding="ascii") as f:
                        return Playlist(f.read(), f"{folder}/index.m3u8")
                except FileNotFoundError:
                    return None
            until("three segments", lambda: (p := segments()) and
                  len(p.segments) >= 3)
            for s in segments().segments[-2:]:
                with open(s["path"], "rb") as f:
                    data = f.read()
                self.assertEqual(data[0], 0x47)
                self.assertIsNotNone(s["at"])
            self.assertEqual(
                self.daemon.metrics()["pelagos_rtsp_clients"], 1)
        finally:
            relay.terminate()
            relay.wait()

    def test_only_watching(self):
        port = self.edges.ports[1]

        def status(method, path):
            with socket.create_connection(("127.0.0.1", port), SLOW_S) as s:
                s.sendall(f"{method} {path} HTTP/1.1\r\nHost: localhost\r\n"
                          "Content-Length: 0\r\nConnection: close\r\n\r\n"
                          .encode())
                return int(s.makefile("rb").readline().split()[1])
        for path in "/", "/v1/state", "/v1/session", "/healthz":
            self.assertEqual(status("GET", path), 200, path)
        for method, path in (("PATCH", "/v1/state"), ("POST", "/v1/clock/step"),
                             ("GET", "/v1/views/bridge/frame.jpg"),
                             ("GET", "/v1/views/bridge/live"),
                             ("PUT", "/v1/views/x"), ("GET", "/metrics"),
                             ("DELETE", LIST)):
            self.assertEqual(status(method, path), 403, path)

    def test_a_browser_stays(self):
        with socket.create_connection(("127.0.0.1", self.edges.steer),
                                      SLOW_S) as s:
            s.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n"
                      b"Connection: close\r\n\r\n")
            head = s.makefile("rb").read().split(b"\r\n\r\n")[0].decode()
        self.assertRegex(head, r"(?i)set-cookie: PELAGOS=daemon\d; path=/; "
                               "HttpOnly")


if __name__ == "__main__":
    unittest.main(verbosity=2)
