#!/usr/bin/python3
"""The limits of the proxy that ships (packaging/nginx/pelagos.conf), with the
real nginx before a daemon with a token: what is slow, large or ambiguous ends
there, and what is not comes through. The page and live views through it are in
page_test.mjs."""
import contextlib
import os
import re
import shutil
import socket
import ssl
import subprocess
import sys
import tempfile
import threading
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import (ROOT, SLOW_S, Daemon, free_port, receive_all,
                            until)
from security_test import KEY, TOKEN, make_certificate, write

if not shutil.which("nginx"):
    print("nginx is not installed")
    sys.exit(77)
BEARER = f"Authorization: Bearer {TOKEN}\r\n"


class Proxied(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="pelagos-nginx-")
        token = write(os.path.join(cls.folder, "token"), TOKEN)
        cls.cert, key = make_certificate(cls.folder)
        cls.daemon = Daemon("--token-file", token, "--http-hosts",
                            "localhost", "--trust-proxy", "127.0.0.1")
        cls.port = free_port()
        with open(os.path.join(ROOT, "packaging/nginx/pelagos.conf"),
                  encoding="ascii") as f:
            shipped = f.read()
        for old, new in (
                ("127.0.0.1:8080", f"127.0.0.1:{cls.daemon.http_port}"),
                ("listen 80;", f"listen 127.0.0.1:{free_port()};"),
                ("listen 443 ssl;", f"listen 127.0.0.1:{cls.port} ssl;"),
                ("ocean.example", "localhost"),
                ("/etc/pelagos/tls/fullchain.pem", cls.cert),
                ("/etc/pelagos/tls/privkey.pem", key)):
            assert old in shipped, old
            shipped = shipped.replace(old, new)
        shipped = re.sub(r" *listen \[::\].*\n", "", shipped)
        write(os.path.join(cls.folder, "pelagos.conf"), shipped)
        temporary = "".join(
            f"{name}_temp_path {cls.folder}/{name};" for name in (
                "client_body", "proxy", "fastcgi", "uwsgi", "scgi"))
        config = write(os.path.join(cls.folder, "nginx.conf"), (
            f"daemon off; master_process off; pid {cls.folder}/pid;"
            f"error_log {cls.folder}/error.log;"
            "events { worker_connections 512; }"
            f"http {{ access_log off; {temporary}"
            f"include {cls.folder}/pelagos.conf; }}"))
        cls.nginx = subprocess.Popen(
            ["nginx", "-p", cls.folder, "-c", config, "-e",
             f"{cls.folder}/error.log"], stdin=subprocess.DEVNULL)
        end = time.monotonic() + SLOW_S
        while True:
            with socket.socket() as s:
                if s.connect_ex(("127.0.0.1", cls.port)) == 0:
                    break
            assert time.monotonic() < end and cls.nginx.poll() is None
            time.sleep(0.05)

    @classmethod
    def tearDownClass(cls):
        cls.nginx.terminate()
        cls.nginx.wait()
        cls.daemon.stop()
        shutil.rmtree(cls.folder)

    def connect(self, timeout=SLOW_S):
        raw = socket.create_connection(("127.0.0.1", self.port),
                                       timeout=timeout)
        s = ssl.create_default_context(cafile=self.cert).wrap_socket(
            raw, server_hostname="localhost")
        self.addCleanup(s.close)
        return s

    def ask(self, text, body=b""):
        """Status of a request, written as it is."""
        s = self.connect()
        with contextlib.suppress(OSError):  # it has heard enough
            s.sendall(text.encode() + body)
        answer = receive_all(s)
        return int(answer.split(b" ")[1]) if answer else 0

    def head(self, method="GET", path="/v1/state", more=""):
        return (f"{method} {path} HTTP/1.1\r\nHost: localhost:{self.port}\r\n"
                f"{BEARER}Connection: close\r\n{more}\r\n")

    def test_what_is_right_comes_through(self):
        self.assertEqual(self.ask(self.head()), 200)
        self.assertEqual(self.ask(self.head().replace(BEARER, "")), 401)
        json = "Content-Type: application/json\r\n"
        points = b'{"points":[' + b",".join(
            b"[%d.25,%d.75]" % (i, -i) for i in range(10000)) + b"]}"
        self.assertGreater(len(points), 1 << 16)
        self.assertEqual(self.ask(self.head(
            "POST", "/v1/surface", f"{json}Content-Length: {len(points)}\r\n"),
            points), 200, "10,000 points")
        self.assertEqual(self.ask(self.head(
            path="/v1/views/bridge/frame.jpg?width=64&height=36")), 200)

    def test_too_large(self):
        json = "Content-Type: application/json\r\n"
        for size in (1 << 17, 300 << 20):
            self.assertEqual(self.ask(self.head(
                "PATCH", more=f"{json}Content-Length: {size}\r\n")), 413)
        self.assertIn(self.ask(self.head(more=f"X: {'x' * 40000}\r\n")),
                      (0, 400, 414, 431))
        # 0: the end came before the answer could be read.
        self.assertIn(self.ask(self.head(path="/" + "x" * 40000)),
                      (0, 400, 414))

    def test_ambiguous(self):
        self.assertEqual(self.ask(self.head(
            "PATCH", more="Content-Type: application/json\r\n"
            "Content-Length: 2\r\nTransfer-Encoding: chunked\r\n"),
            b"0\r\n\r\n"), 400)
        self.assertEqual(self.ask(self.head(
            "PATCH", more="Content-Type: application/json\r\n"
            "Content-Length: 2\r\nContent-Length: 3\r\n"), b"{}"), 400)
        self.assertEqual(self.ask(self.head(more="Host: other\r\n")), 400)
        self.assertEqual(self.ask(self.head().replace(
            f"localhost:{self.port}", "evil.example")), 403)
        # An upgrade to anything but WebSocket, or anywhere else, is none.
        for path, protocol in (("/v1/views/bridge/live", "h2c"),
                               ("/v1/state", "websocket")):
            status = self.ask(self.head(path=path, more=(
                f"Upgrade: {protocol}\r\n")).replace(
                    "Connection: close", "Connection: close, Upgrade"))
            self.assertIn(status, (200, 426), path)

    def test_slow(self):
        """Half a head, half a body, a dripping head: all are sent away; a good
        client is served meanwhile."""
        half = self.connect()
        half.sendall(b"GET /v1/state HTTP/1.1\r\nHost: localh")
        body = self.connect()
        body.sendall(self.head(
            "PATCH", more="Content-Type: application/json\r\n"
            "Content-Length: 100\r\n").encode() + b'{"sea"')
        drip = self.connect()
        over = threading.Event()

        def dripping():
            with contextlib.suppress(OSError):
                drip.sendall(b"GET / HTTP/1.1\r\n")
                while not over.wait(0.5):
                    drip.sendall(b"X")
        thread = threading.Thread(target=dripping)
        thread.start()
        try:
            for s in half, body, drip:
                # Until the other side ends it; a timeout of this one raises.
                with contextlib.suppress(ConnectionError):
                    while s.recv(65536):
                        pass
                self.assertEqual(self.ask(self.head()), 200)
        finally:
            over.set()
            thread.join()

    def test_many_of_one_source(self):
        """32 requests at a time: the next is told so, and others go on when
        one of them ends."""
        watching = []
        for _ in range(32):
            s = self.connect()
            s.sendall(self.head(path="/v1/views/bridge/mjpeg?fps=1").encode())
            s.recv(100)
            watching.append(s)
        self.assertEqual(self.ask(self.head()), 429)
        for s in watching:
            s.close()
        until("others go on", lambda: self.ask(self.head()) == 200)

    def test_websocket(self):
        s = self.connect()
        s.sendall((f"GET /v1/views/bridge/live?codec=jpeg HTTP/1.1\r\n"
                   f"Host: localhost:{self.port}\r\nUpgrade: websocket\r\n"
                   f"Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                   f"Sec-WebSocket-Key: {KEY}\r\n"
                   f"Origin: https://localhost:{self.port}\r\n"
                   f"Sec-WebSocket-Protocol: pelagos, bearer.{TOKEN}\r\n\r\n"
                   ).encode())
        data = b""
        while b"\xff\xd8\xff" not in data:
            chunk = s.recv(65536)
            self.assertTrue(chunk, data[:200])
            data += chunk
        self.assertTrue(data.startswith(b"HTTP/1.1 101"))

    def test_metrics_stay_inside(self):
        self.assertEqual(self.ask(self.head(path="/metrics")), 200,
                         "from this machine")


if __name__ == "__main__":
    unittest.main(verbosity=2)
