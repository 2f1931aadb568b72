"""What the demonstration is made of: a daemon, a console, a viewer, pixels."""
import json
import math
import pathlib
import socket
import struct
import subprocess
import threading
import time
import urllib.request
import zlib

SMALL = (320, 180)  # pictures that are compared pixel by pixel
START = time.monotonic()


class Trouble(Exception):
    """Ends the demonstration with a sentence."""


def since_start():
    return time.monotonic() - START


def say(text):
    print(f"[{since_start():5.1f} s] {text}", flush=True)


def free_port(kind=socket.SOCK_STREAM):
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Daemon:
    """pelagosd on the software device and on free ports of its own."""

    def __init__(self, binaries, log):
        self.binaries, self.log_path = binaries, log
        self.http, self.tcp, self.modbus = (free_port() for _ in range(3))
        self.nmea = free_port(socket.SOCK_DGRAM)
        self.process, self.ready_s = None, 0.0

    def start(self):
        begin = time.monotonic()
        with open(self.log_path, "w", encoding="utf-8") as log:
            self.process = subprocess.Popen(
                [self.binaries / "pelagosd", "--device", "software",
                 "--http", f"127.0.0.1:{self.http}",
                 "--tcp", f"127.0.0.1:{self.tcp}", "--rtsp", "off",
                 "--modbus", f"127.0.0.1:{self.modbus}",
                 "--nmea", f"127.0.0.1:{self.nmea}",
                 "--unix", "off", "--state", "off"],
                stdout=log, stderr=log, stdin=subprocess.DEVNULL)
        while not self.answers():
            if self.process.poll() is not None:
                raise Trouble("pelagosd ended at once:\n" + self.tail())
            if time.monotonic() - begin > 20:
                raise Trouble("pelagosd does not answer:\n" + self.tail())
            time.sleep(0.05)
        self.ready_s = time.monotonic() - begin

    def stop(self):
        if self.process and self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(timeout=6)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()

    def answers(self):
        try:
            return self.get("/healthz") is not None
        except OSError:
            return False

    def tail(self):
        lines = pathlib.Path(self.log_path).read_text(errors="replace")
        return "\n".join(lines.splitlines()[-12:])

    def request(self, method, path, body=None):
        data = json.dumps(body).encode() if body is not None else None
        request = urllib.request.Request(
            f"http://127.0.0.1:{self.http}{path}", data=data, method=method)
        if data:
            request.add_header("Content-Type", "application/json")
        with urllib.request.urlopen(request, timeout=20) as answer:
            return answer.read()

    def get(self, path):
        return self.request("GET", path)

    def state(self):
        return json.loads(self.get("/v1/state"))

    def patch(self, change):
        return self.request("PATCH", "/v1/state", change)

    def small(self, view, time_s):
        """The view's pixels at a moment, small, as bytes of RGB."""
        return read_png(self.get(
            f"/v1/views/{view}/frame.png?width={SMALL[0]}&height={SMALL[1]}"
            f"&time={time_s:.3f}"))

    def ctl(self, *words, as_json=True):
        """Runs pelagosctl and returns what it prints."""
        command = [self.binaries / "pelagosctl", "--server",
                   f"tcp:127.0.0.1:{self.tcp}", "--timeout", "60",
                   *map(str, words)]
        if as_json:
            command.append("--json")
        done = subprocess.run(command, capture_output=True, text=True,
                              timeout=90, check=False)
        if done.returncode != 0:
            raise Trouble(f"pelagosctl {words[0]}: {done.stderr.strip()}")
        return json.loads(done.stdout) if as_json else done.stdout

    def resident_mb(self):
        status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        for line in status.splitlines():
            if line.startswith("VmRSS:"):
                return int(line.split()[1]) / 1024
        return 0.0

    def metrics(self):
        values = {}
        for line in self.get("/metrics").decode().splitlines():
            if line and not line.startswith("#"):
                name, _, value = line.rpartition(" ")
                values[name] = float(value)
        return values


class Modbus:
    """A console: writes holding registers of unit 1."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), 5)
        self.number = 0

    def write(self, address, words):
        self.number += 1
        body = struct.pack(">BHHB", 16, address, len(words), 2 * len(words))
        body += struct.pack(f">{len(words)}H", *words)
        self.socket.sendall(struct.pack(">HHHB", self.number, 0,
                                        len(body) + 1, 1) + body)
        head = self.receive(7)
        answer = self.receive(struct.unpack(">H", head[4:6])[0] - 1)
        if answer[0] != 16:
            raise Trouble(f"Modbus exception {answer[1]} at {address}")

    def receive(self, size):
        data = b""
        while len(data) < size:
            more = self.socket.recv(size - len(data))
            if not more:
                raise Trouble("pelagosd closed the Modbus connection")
            data += more
        return data

    def wind(self, speed_mps, from_deg):
        """Speed, direction and commit in one request (registers 10 to 14)."""
        words = struct.unpack(">4H", struct.pack(">ff", speed_mps, from_deg))
        self.write(10, [*words, 1])


class Viewer(threading.Thread):
    """Watches a live view, as a browser would, and notes when frames come."""

    def __init__(self, port, view):
        super().__init__(daemon=True)
        self.port, self.view = port, view
        self.times, self.on = [], True

    def run(self):
        try:
            with socket.create_connection(("127.0.0.1", self.port), 5) as s:
                s.sendall(f"GET /v1/views/{self.view}/mjpeg HTTP/1.1\r\n"
                          f"Host: localhost:{self.port}\r\n\r\n".encode())
                s.settimeout(1)
                self.read(s)
        except OSError:
            pass

    def stop(self):
        self.on = False
        if self.is_alive():
            self.join()

    def read(self, s):
        tail = b""
        while self.on:
            try:
                data = s.recv(1 << 16)
            except socket.timeout:
                continue
            if not data:
                return
            found = (tail + data).count(b"\xff\xd8\xff")
            self.times += [time.monotonic()] * found
            tail = data[-2:]


def placed(ship, things, first_id=100):
    """Things by metres ahead of and to starboard of a ship, as entities."""
    metre = 1 / 111200  # of latitude, in degrees
    sine = math.sin(math.radians(ship["heading"]))
    cosine = math.cos(math.radians(ship["heading"]))
    entities = {}
    for number, thing in enumerate(things, first_id):
        ahead, right = thing["ahead"], thing["right"]
        east, north = (ahead * sine + right * cosine,
                       ahead * cosine - right * sine)
        heading = (ship["heading"] + thing.get("turn", 0)) % 360
        entities[str(number)] = {
            "name": thing["name"], "model": thing["model"], "afloat": True,
            "latitude": ship["latitude"] + north * metre,
            "longitude": ship["longitude"] + east * metre /
            math.cos(math.radians(ship["latitude"])),
            "heading": heading, "course": heading,
            "speed": thing.get("speed", 0)}
    return entities


def percentile(values, part):
    values = sorted(values)
    return values[round(part * (len(values) - 1))] if values else 0.0


def difference(a, b):
    """Mean absolute difference of two pictures, of 255."""
    return sum(abs(x - y) for x, y in zip(a, b)) / max(1, len(a))


def read_png(data):
    """Pixels of an 8-bit RGB or RGBA PNG, rows top to bottom, as RGB."""
    at, packed, width, channels = 8, b"", 0, 0
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        chunk = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width = struct.unpack(">I", chunk[:4])[0]
            channels = {2: 3, 6: 4}[chunk[9]]
        elif kind == b"IDAT":
            packed += chunk
        at += length + 12
    raw, stride = zlib.decompress(packed), width * channels
    above, pixels = bytearray(stride), bytearray()
    for start in range(0, len(raw), stride + 1):
        line = bytearray(raw[start + 1:start + 1 + stride])
        unfilter(raw[start], line, above, channels)
        pixels += line
        above = line
    if channels == 4:
        del pixels[3::4]
    return bytes(pixels)


def paeth(a, b, c):
    p = a + b - c
    pa, pb, pc = abs(p - a), abs(p - b), abs(p - c)
    return a if pa <= pb and pa <= pc else b if pb <= pc else c


def unfilter(kind, line, above, step):
    """Undoes a PNG row filter in place."""
    for i, value in enumerate(line):
        left = line[i - step] if i >= step else 0
        up = above[i]
        corner = above[i - step] if i >= step else 0
        guess = (0, left, up, (left + up) // 2,
                 paeth(left, up, corner) if kind == 4 else 0)[kind]
        line[i] = (value + guess) & 255
