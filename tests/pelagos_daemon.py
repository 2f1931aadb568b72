"""Starts pelagosd for a test and talks to it. Standard library only.

    with Daemon() as daemon:
        state = daemon.get("/v1/state").json()

Ports are the kernel's choice, read from the daemon's log. PELAGOS_BIN names
the folder of the program (build/release/bin).
"""
import collections
import contextlib
import http.client
import json
import os
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
BIN = os.environ.get("PELAGOS_BIN", os.path.join(ROOT, "build/release/bin"))
# Sanitizers keep freed memory back: figures of growth mean nothing then.
SANITIZED = "asan" in BIN or "tsan" in BIN
# What "at once" may take: a shared machine, half a core, sanitizers. Tests
# wait for events, at most this long, and assert no times.
SLOW_S = 240.0 if SANITIZED else 60.0
# For a user's program that is compiled against the libraries of the build.
CC_FLAGS = os.environ.get("PELAGOS_CC_FLAGS", "").split()


given_ports = collections.deque(maxlen=50)


def free_port(kind=socket.SOCK_STREAM):
    """A port that nobody uses now (for services that do not log theirs): of
    those that tests/run keeps for this test. Not the kernel's choice: it gives
    those ports to every client as well, of this test or of one beside it. Not
    one that was given of late: its service may not have bound it yet."""
    first, last = map(int, os.environ.get("PELAGOS_TEST_PORTS",
                                          "10000-32767").split("-"))
    while True:
        with socket.socket(socket.AF_INET, kind) as s:
            port = random.SystemRandom().randint(first, last)
            with contextlib.suppress(OSError):
                s.bind(("127.0.0.1", port))
                if port not in given_ports:
                    given_ports.append(port)
                    return port


def until(what, test, seconds=SLOW_S, pause_s=0.03):
    """Waits until test() is true; what it gave."""
    end = time.monotonic() + seconds
    while True:
        if result := test():
            return result
        if time.monotonic() > end:
            raise AssertionError(f"not within {seconds:.0f} s: {what}")
        time.sleep(pause_s)


class Response:
    def __init__(self, status, headers, body):
        self.status, self.headers, self.body = status, headers, body

    def json(self):
        return json.loads(self.body)

    def __repr__(self):
        return f"<{self.status} {self.body[:200]!r}>"


def log_entries(data):
    """The entries of a command log (proto/pelog.md), as bytes."""
    assert data[:8] == b"PELOG2\r\n", data[:8]
    at = 32
    while data[at:at + 4] == data[8:12]:
        length = int.from_bytes(data[at + 8:at + 12], "little")
        if at + 16 + length > len(data):
            break
        yield data[at + 16:at + 16 + length]
        at += 16 + length


class Daemon:
    """options: further command-line arguments; http_port: 0 for any;
    unix: a Unix socket in the daemon's own folder; log_level: of the daemon."""

    PROGRAM = "pelagosd"

    token = None  # that requests give

    def __init__(self, *options, http_port=0, tcp_port=0, unix=False,
                 log_level="info", wait_s=SLOW_S):
        self.folder = tempfile.mkdtemp(prefix="pelagos-test-")
        self.unix_path = os.path.join(self.folder, "socket") if unix else None
        self.log_path = os.path.join(self.folder, "log")
        given = {option.split("=")[0] for option in options}
        command = [os.path.join(BIN, self.PROGRAM),
                   "--http", f"127.0.0.1:{http_port}",
                   "--tcp", f"127.0.0.1:{tcp_port}",
                   "--unix", self.unix_path or "off",
                   "--log-level", log_level]
        for name, value in (("--device", "software"), ("--modbus", "off"),
                            ("--rtsp", "off"),
                            ("--nmea", "off")):
            if name not in given:
                command += [name, value]
        self.command = command + list(options)
        with open(self.log_path, "wb") as log:
            self.process = subprocess.Popen(
                self.command, stderr=log, stdout=log,
                stdin=subprocess.DEVNULL)
        try:
            self._find_ports(wait_s)
        except Exception:
            self.stop()
            raise

    def _find_ports(self, wait_s):
        end = time.monotonic() + wait_s
        while time.monotonic() < end:
            log = self.log()
            http_line = re.search(r"NET-002 .*:(\d+)/", log)
            tcp_line = re.search(r"NET-003 .* port (\d+)", log)
            if http_line and tcp_line:
                self.http_port = int(http_line.group(1))
                self.tcp_port = int(tcp_line.group(1))
                self._await_all(end)
                return
            if self.process.poll() is not None:
                raise RuntimeError(f"pelagosd ended at start:\n{log}")
            time.sleep(0.02)
        raise RuntimeError(f"pelagosd does not listen:\n{self.log()}")

    def _await_all(self, end):
        """HTTP is answered once everything listens, UDP too."""
        while time.monotonic() < end:
            try:
                self.get("/healthz")
                return
            except OSError:  # it may end before it answers
                if self.process.poll() is not None:
                    raise RuntimeError("pelagosd ended at start:\n"
                                       + self.log()) from None
                time.sleep(0.02)
        raise RuntimeError(f"pelagosd does not answer:\n{self.log()}")

    def log(self):
        with open(self.log_path, encoding="utf-8", errors="replace") as f:
            return f.read()

    # --- HTTP ---------------------------------------------------------------

    def url(self, path="/"):
        return f"http://127.0.0.1:{self.http_port}{path}"

    def request(self, method, path, body=None, headers=None, timeout=SLOW_S):
        """One request on a connection of its own. body: bytes, str, or
        anything else as JSON (Content-Type set unless given)."""
        headers = dict(headers or {})
        if self.token:
            headers.setdefault("Authorization", "Bearer " + self.token)
        if body is not None and not isinstance(body, (bytes, str)):
            body = json.dumps(body)
        if body is not None and "Content-Type" not in headers:
            headers["Content-Type"] = "application/json"
        connection = http.client.HTTPConnection("127.0.0.1", self.http_port,
                                                timeout=timeout)
        with contextlib.closing(connection):
            connection.request(method, path, body, headers)
            answer = connection.getresponse()
            return Response(answer.status, answer.headers, answer.read())

    def get(self, path, **more):
        return self.request("GET", path, **more)

    def patch(self, change, **more):
        return self.request("PATCH", "/v1/state", change, **more)

    def state(self):
        return self.get("/v1/state").json()

    def metrics(self):
        """{'name{labels}': value}"""
        out = {}
        # Where every connection is taken it is told to come later.
        answer = until("/metrics answers", lambda: (
            r := self.get("/metrics")).status == 200 and r)
        for line in answer.body.decode().splitlines():
            if line and not line.startswith("#"):
                name, value = line.rsplit(" ", 1)
                out[name] = float(value)
        return out

    def raw(self, data, timeout=SLOW_S):
        """Sends bytes on a new HTTP connection; what comes until it closes or
        goes silent."""
        with self.connect_http(timeout) as s:
            with contextlib.suppress(OSError):
                s.sendall(data)
            return receive_all(s)

    def connect_http(self, timeout=SLOW_S):
        return socket.create_connection(("127.0.0.1", self.http_port), timeout)

    # --- protobuf -----------------------------------------------------------

    def connect_tcp(self, timeout=SLOW_S):
        return socket.create_connection(("127.0.0.1", self.tcp_port), timeout)

    def connect_unix(self, timeout=SLOW_S):
        s = socket.socket(socket.AF_UNIX)
        s.settimeout(timeout)
        s.connect(self.unix_path)
        return s

    # --- life ---------------------------------------------------------------

    def rss(self):
        """Resident memory in bytes."""
        with open(f"/proc/{self.process.pid}/statm") as f:
            return int(f.read().split()[1]) * os.sysconf("SC_PAGESIZE")

    def control_cpu(self):
        """Seconds that the control thread, which serves all clients, ran."""
        pid = self.process.pid
        with open(f"/proc/{pid}/task/{pid}/schedstat") as f:
            return int(f.read().split()[0]) * 1e-9

    def alive(self):
        return self.process.poll() is None

    def stop(self, how=signal.SIGTERM, wait_s=SLOW_S):
        """Ends the daemon; its exit status. The log is shown when it was not
        0 and the signal was SIGTERM."""
        if self.process.poll() is None:
            self.process.send_signal(how)
        try:
            status = self.process.wait(wait_s)
        except subprocess.TimeoutExpired:
            self.process.kill()
            status = self.process.wait()
        if os.path.isdir(self.folder):
            if status != 0 and how == signal.SIGTERM:
                print(f"pelagosd ended with {status}:\n{self.log()[-4000:]}",
                      file=sys.stderr)
            shutil.rmtree(self.folder, ignore_errors=True)
        return status

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stop()


def receive_all(s):
    data = b""
    with contextlib.suppress(OSError):
        while chunk := s.recv(65536):
            data += chunk
    return data


# --- the schema in Python ---------------------------------------------------

def schema():
    """The module pelagos_pb2, made by protoc."""
    folder = os.path.join(ROOT, "build", "python")
    os.makedirs(folder, exist_ok=True)
    source = os.path.join(ROOT, "proto", "pelagos.proto")
    made = os.path.join(folder, "pelagos_pb2.py")
    if (not os.path.exists(made)
            or os.path.getmtime(made) < os.path.getmtime(source)):
        with tempfile.TemporaryDirectory(dir=folder) as fresh:
            subprocess.run(["protoc",
                            f"--proto_path={os.path.dirname(source)}",
                            f"--python_out={fresh}", source], check=True)
            # At once: a test beside this one may be reading it.
            os.replace(os.path.join(fresh, "pelagos_pb2.py"), made)
    if folder not in sys.path:
        sys.path.insert(0, folder)
    import pelagos_pb2
    return pelagos_pb2


class Session:
    """Length-delimited protobuf over a connected socket."""

    def __init__(self, connection):
        self.socket = connection
        self.buffer = b""
        self.pb = schema()
        self.last_id = 0

    def send(self, request):
        data = request.SerializeToString()
        self.socket.sendall(varint(len(data)) + data)

    def receive(self):
        """The next Reply, or None at the end."""
        while True:
            length, used = read_varint(self.buffer)
            if used and len(self.buffer) - used >= length:
                data = self.buffer[used:used + length]
                self.buffer = self.buffer[used + length:]
                return self.pb.Reply.FromString(data)
            chunk = self.socket.recv(1 << 20)
            if not chunk:
                return None
            self.buffer += chunk

    def ask(self, **command):
        """ask(get={}), ask(patch={...}): sends a command, awaits its reply."""
        self.last_id += 1
        self.send(self.pb.Request(id=self.last_id, **command))
        while (reply := self.receive()) is not None:
            if reply.id == self.last_id:
                return reply
        return None

    def close(self):
        self.socket.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def varint(value):
    out = b""
    while value >= 0x80:
        out += bytes([value & 0x7F | 0x80])
        value >>= 7
    return out + bytes([value])


def read_varint(data):
    """(value, bytes used); (0, 0) if it is not all there."""
    value = 0
    for i, byte in enumerate(data[:10]):
        value |= (byte & 0x7F) << (7 * i)
        if byte < 0x80:
            return value, i + 1
    return 0, 0
