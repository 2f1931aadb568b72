#!/usr/bin/python3
"""NMEA into a running pelagosd, by `pelagosctl replay`.

The logs of real devices are in ../shared/data/nmea beside the checkout; where
they are absent their part is left out. The voyage of the demonstration ships
with the project.

A tap stands between pelagosctl and the daemon: it forwards each datagram, and
before and after each RMC asks the daemon where own ship is.
"""
import json
import math
import os
import pathlib
import queue
import socket
import subprocess
import sys
import threading
import time

from pelagos_daemon import BIN, Daemon, free_port, receive_all, until

ROOT = pathlib.Path(__file__).resolve().parents[1]
DATA = pathlib.Path(os.environ.get("PELAGOS_DATA", ROOT / "../shared/data"))
VOYAGE = ROOT / "clients/voyage/voyage.nmea"
KNOT = 1852 / 3600
SMALL = [{"name": "bridge", "width": 320, "height": 180}]


def check(condition, text):
    if not condition:
        raise AssertionError(text)


def angle_between(a, b):
    return abs((a - b + 180) % 360 - 180)


def coordinate(value, side, digits):
    angle = float(value[:digits]) + float(value[digits:]) / 60
    return -angle if side in "SW" else angle


def metres_between(a, b):
    """On a sphere of the mean radius: 0.3 % of a few metres is nothing."""
    north = math.radians(b[0] - a[0]) * 6371000
    east = (math.radians(b[1] - a[1]) * 6371000 *
            math.cos(math.radians(a[0])))
    return math.hypot(north, east)


def sum_of(body):
    total = 0
    for c in body:
        total ^= ord(c)
    return f"${body}*{total:02X}\r\n".encode()


class Ship:
    """Own ship as the daemon has it, reckoned to a simulated time (now)."""

    def __init__(self, state, at=None):
        e = next(e for e in state["entities"] if int(e["id"]) == 1)
        self.pose_time = e.get("poseTime", 0)
        seconds = (state["clock"]["time"] if at is None else
                   at) - self.pose_time
        self.turn_rate = e.get("turnRate", 0)
        rate = math.radians(e.get("turnRate", 0))
        course = math.radians(e.get("course", 0)) + rate * seconds / 2
        x = rate * seconds / 2
        metres = e.get("speed", 0) * seconds * (math.sin(x) / x if x else 1)
        self.place = (
            e["latitude"] + math.degrees(metres * math.cos(course) / 6371000),
            e["longitude"] + math.degrees(
                metres * math.sin(course) / 6371000 /
                math.cos(math.radians(e["latitude"]))))
        self.heading = e.get("heading", 0) + math.degrees(rate) * seconds
        self.roll, self.pitch = e.get("roll", 0), e.get("pitch", 0)
        self.wind = (state["sea"].get("windSpeed", 0),
                     state["sea"].get("windDirection", 0))


class Told:
    """What the sentences said last."""

    def __init__(self):
        self.place = self.heading = self.heel = self.trim = self.wind = None
        self.time = self.headed = None  # of the fix, of our passing HDT on

    def take(self, line):
        field = line.split("*")[0].split(",")
        kind = field[0][3:]
        if kind == "RMC" and field[2] == "A":
            self.time = (3600 * int(field[1][:2]) + 60 * int(field[1][2:4]) +
                         float(field[1][4:]))
            self.place = (coordinate(field[3], field[4], 2),
                          coordinate(field[5], field[6], 3))
        elif kind == "HDT" and field[1]:
            self.heading, self.headed = float(field[1]), time.monotonic()
        elif kind == "HDG" and field[4]:
            self.heading = float(field[1]) + float(field[4])
            self.headed = time.monotonic()
        elif kind == "MWD" and field[1]:
            self.wind = (float(field[5]) * KNOT, float(field[1]))
        elif kind == "XDR":
            for i in range(1, len(field) - 3, 4):
                if field[i + 3] == "HEEL" and field[i + 1]:
                    self.heel = float(field[i + 1])
                if field[i + 3] == "TRIM" and field[i + 1]:
                    self.trim = float(field[i + 1])


class Tap:
    """Passes on what is replayed; looks at own ship before and after each fix.
    Everything is compared at simulated times, so that it makes no difference
    when this script gets a core."""

    def __init__(self, daemon, nmea_port, speed):
        self.daemon, self.to = daemon, ("127.0.0.1", nmea_port)
        self.speed = speed
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.port = self.socket.getsockname()[1]
        # Read by a thread: the system's buffer holds a second of a log.
        self.waiting = queue.SimpleQueue()
        threading.Thread(target=self.read, daemon=True).start()
        self.told, self.fixes = Told(), 0
        self.before_m, self.after_m = [], []
        self.fix = None  # (simulated time it was taken at, its own time)
        self.worst = {"heading": 0, "heel": 0, "trim": 0, "wind": 0,
                      "wind from": 0}

    def ship(self, at=None):
        return Ship(self.daemon.state(), at)

    def read(self):
        while True:
            self.waiting.put(self.socket.recv(4096))

    def run(self, process):
        while True:
            try:
                datagram = self.waiting.get(timeout=0.2)
            except queue.Empty:
                if process.poll() is not None:
                    return
                continue
            line = datagram.decode().strip()
            fix = line[3:6] == "RMC" and ",A," in line
            self.told.take(line)
            if fix and self.fix:
                due = self.fix[0] + self.told.time - self.fix[1]
                self.before_m.append(
                    metres_between(self.ship(due).place, self.told.place))
            self.socket.sendto(datagram, self.to)
            if fix:
                self.fixes += 1
                self.compare()

    def compare(self):
        # The state once, with its ship; the wind's sea may take longer.
        told, state = self.told, self.daemon.state()
        until("its sea is built", lambda: self.daemon.metrics()[
            "pelagos_scene_waiting"] == 0)
        wind = Ship(self.daemon.state()).wind
        ship = Ship(state)
        self.fix = ship.pose_time, told.time
        ship = Ship(state, ship.pose_time)
        self.after_m.append(metres_between(ship.place, told.place))
        if told.heading is not None:
            # It turned on since it was told.
            turned = (abs(ship.turn_rate) * self.speed *
                      (time.monotonic() - told.headed))
            self.worst["heading"] = max(
                self.worst["heading"],
                angle_between(ship.heading, told.heading) - turned)
        for name, value, wanted in (
                ("heel", ship.roll, told.heel),
                ("trim", ship.pitch, told.trim),
                ("wind from", wind[1], told.wind and told.wind[1])):
            if wanted is not None:
                self.worst[name] = max(self.worst[name],
                                       angle_between(value, wanted))
        if told.wind:
            self.worst["wind"] = max(self.worst["wind"],
                                     abs(wind[0] - told.wind[0]))


class Frames(threading.Thread):
    """Counts the parts of the live view."""

    def __init__(self, daemon):
        super().__init__(daemon=True)
        self.daemon_under_test, self.times, self.stopped = daemon, [], False

    def run(self):
        with self.daemon_under_test.connect_http() as s:
            s.sendall(b"GET /v1/views/bridge/mjpeg HTTP/1.1\r\n"
                      b"Host: localhost\r\n\r\n")
            tail = b""
            while not self.stopped:
                data = s.recv(1 << 16)
                if not data:
                    return
                found = (tail + data).count(b"\xff\xd8\xff")
                self.times += [time.monotonic()] * found
                tail = data[-2:]


def replay(port, daemon, path, speed):
    return subprocess.Popen(
        [os.path.join(BIN, "pelagosctl"), "--timeout", "60", "--server",
         f"tcp:127.0.0.1:{daemon.tcp_port}", "replay", str(path), "--speed",
         str(speed), "--to", f"127.0.0.1:{port}", "--json"],
        stdout=subprocess.PIPE, text=True)


def follow(path, speed, limit_m):
    """Replays; own ship is where each RMC says, and was almost there before
    it came."""
    nmea = free_port(socket.SOCK_DGRAM)
    with Daemon("--nmea", f"127.0.0.1:{nmea}", "--state", "off") as daemon:
        check(daemon.patch({"views": SMALL}).status == 200, "view size")
        frames = Frames(daemon)
        frames.start()
        until("live pictures", lambda: len(frames.times) > 5)
        frames.times.clear()
        tap = Tap(daemon, nmea, speed)
        sender = replay(tap.port, daemon, path, speed)
        tap.run(sender)
        times = list(frames.times)
        until("pictures go on", lambda: len(frames.times) > len(times) + 2)
        frames.stopped = True
        sent = json.loads(sender.communicate()[0])["sentences"]
        check(sender.returncode == 0, "pelagosctl replay failed")
        metrics = daemon.metrics()
        taken = sum(v for k, v in metrics.items()
                    if k.startswith("pelagos_nmea_sentences_total"))
        dropped = sum(v for k, v in metrics.items()
                      if k.startswith("pelagos_nmea_dropped_total"))
        rate = daemon.state()["clock"].get("rate", 1)
    gaps = sorted(b - a for a, b in zip(times, times[1:]))
    before = sorted(tap.before_m)
    print(f"{path.name} at {speed}x: {tap.fixes} fixes, {sent} sentences; "
          f"after RMC {max(tap.after_m):.2f} m, before it median "
          f"{before[len(before) // 2]:.2f}, worst {before[-1]:.2f} m; worst "
          + ", ".join(f"{k} {v:.3f}" for k, v in tap.worst.items())
          + f"; {len(times)} frames, gap median "
          f"{1000 * gaps[len(gaps) // 2]:.0f}, worst {1000 * gaps[-1]:.0f} ms")
    check(max(tap.after_m) < limit_m, "own ship is off the track")
    check(before[-1] < limit_m, "dead reckoning is off the track")
    check(tap.worst["heading"] < 1, "heading")
    # One float in JSON, no arithmetic: the text's digits.
    check(tap.worst["heel"] < 1e-6 and tap.worst["trim"] < 1e-6, "attitude")
    check(tap.worst["wind"] < 1e-6 and tap.worst["wind from"] < 1e-6, "wind")
    check(taken + dropped == sent, f"{taken} + {dropped} counted of {sent}")
    check(rate == 1, "the clock's rate is not restored")
    check(len(times) > 2, "no frames meanwhile")


def pour(daemon, port, lines):
    """Sends lines, not faster than a socket's buffer is read; what that
    added to the metrics of NMEA."""
    before = daemon.metrics()

    def rose():
        now = daemon.metrics()
        return {k[len("pelagos_nmea_"):]: now[k] - before.get(k, 0)
                for k in now if k.startswith("pelagos_nmea_")
                and now[k] != before.get(k, 0)}

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for i, line in enumerate(lines):
            sender.sendto(line + b"\r\n", ("127.0.0.1", port))
            if i % 64 == 63 or i == len(lines) - 1:
                until(f"{i + 1} datagrams are read", lambda n=i: rose().get(
                    "datagrams_total", 0) >= n + 1)
    check(daemon.alive(), "the daemon died")
    return rose()


def counted(rose, name):
    return sum(v for k, v in rose.items() if k.startswith(name))


def read_log(name):
    lines = (DATA / "nmea" / name).read_bytes().splitlines()
    return [line for line in lines if line[:1] in (b"$", b"!")]


def survive(daemon, port, lines):
    rose = pour(daemon, port, lines)
    taken = counted(rose, "sentences_total")
    dropped = counted(rose, "dropped_total")
    check(taken + dropped == len(lines),
          f"{taken} + {dropped} counted of {len(lines)}")
    return rose


def odd_logs():
    nmea = free_port(socket.SOCK_DGRAM)
    with Daemon("--nmea", f"127.0.0.1:{nmea}", "--nmea-ais",
                "--state", "off") as daemon:
        before = daemon.state()
        lines = read_log("hemi.log")
        first = next(i for i, line in enumerate(lines)
                     if line.startswith(b"$GPGGA,1"))
        rose = survive(daemon, nmea, lines[:first])
        check(daemon.state()["entities"] == before["entities"],
              "no-fix data moved the ship")
        check(rose["void_fixes_total"] == 194, f"void fixes: {rose}")
        check("edits_total" not in rose, "no-fix data edited")
        survive(daemon, nmea, lines[first:])
        check(metres_between(Ship(daemon.state()).place,
                             (42.36373, -71.03235)) < 100, "hemi's place")

        rose = survive(daemon, nmea, read_log("tnt-revolution.log"))
        check(rose["out_of_range_total"] == 10, f"PITCH of 171: {rose}")
        check(Ship(daemon.state()).pitch == 0, "PITCH of 171 was taken")
        survive(daemon, nmea, read_log("humminbird-M37.log"))
        check(metres_between(Ship(daemon.state()).place,
                             (44.4378, -71.6572)) < 2000, "humminbird's place")
        survive(daemon, nmea, read_log("saab-r4.log"))
        check(angle_between(Ship(daemon.state()).heading, 4) < 1, "saab's HDT")
        rose = survive(daemon, nmea, read_log("ais-nmea.log"))
        check(rose["ais_messages_total"] > 150, f"AIS messages: {rose}")
        targets = [e for e in daemon.state()["entities"]
                   if int(e["id"]) >= 20000]
        check(len(targets) > 10, f"{len(targets)} AIS targets")
        print(f"odd logs: every line counted, {len(targets)} AIS targets")


def malformed():
    """1,000 datagrams of nonsense: counted, nothing changed, still there."""
    nmea = free_port(socket.SOCK_DGRAM)
    with Daemon("--nmea", f"127.0.0.1:{nmea}", "--state", "off") as daemon:
        good = sum_of("GPRMC,094737,A,5251.0093,N,00518.8170,E,5.6,230.5,"
                      "200818,1.4,E,A").strip()
        revision = daemon.state().get("revision")
        lines = []
        for i in range(1000):
            bad = bytearray(good)
            if i % 3 == 0:
                bad[i % (len(good) - 2)] ^= 1 + i % 31
            elif i % 3 == 1:
                bad = bad[:1 + i % (len(good) - 1)]
            else:
                bad = bytearray((i * 7 + k) % 128 + 128 for k in range(i % 250))
                bad += b"!"
            lines.append(bytes(bad))
        dropped = counted(pour(daemon, nmea, lines), "dropped_total")
        check(daemon.state().get("revision") == revision, "state changed")
        check(dropped >= 1000, f"{dropped} of 1000 counted")
        print(f"malformed: 1000 datagrams, {dropped:.0f} bad lines counted")


def by_tcp():
    """The yacht's log by TCP, in odd pieces; the places are taken and given
    back; a line without end, bytes that drip and a flood delay nobody."""
    tcp = free_port()
    log = DATA / "nmea/bundg_zeus_9.log"
    with Daemon("--nmea-tcp", f"127.0.0.1:{tcp}") as daemon:
        def metric(name):
            return daemon.metrics()["pelagos_nmea_" + name]

        def heads(degrees):  # it may be turning
            ship = daemon.state()["entities"][0]
            return angle_between(ship["heading"], degrees) < 20

        whole = log.read_bytes() if log.exists() else VOYAGE.read_bytes()
        whole = b"".join(line + b"\r\n" for line in whole.splitlines()
                         if line.startswith((b"$", b"!")))
        drip = socket.create_connection(("127.0.0.1", tcp), 5)
        drip.sendall(b"$GPRMC,1")
        endless = socket.create_connection(("127.0.0.1", tcp), 5)
        endless.sendall(b"x" * 500000)
        with socket.create_connection(("127.0.0.1", tcp), 5) as sender:
            for i in range(0, len(whole), 997):
                sender.sendall(whole[i:i + 997])
            sender.sendall(sum_of("HEHDT,77.0,T"))
            until("the last sentence", lambda: heads(77))
        lines = whole.count(b"\n")
        until("every sentence",
              lambda: metric_sum(daemon, "sentences_total") +
              metric_sum(daemon, "dropped_total") == lines + 1)
        until("gone", lambda: metric("tcp_clients") == 2)
        drip.sendall(sum_of("HEHDT,12.0,T")[:6])
        endless.sendall(b"\r\n" + sum_of("HEHDT,177.0,T"))
        until("after an endless line", lambda: heads(177))
        check(metric('dropped_total{reason="too_long"}') == 1,
              "the endless line")
        with socket.create_connection(("127.0.0.1", tcp), 5) as page:
            page.sendall(b"POST / HTTP/1.1\r\nOrigin: http://a.example\r\n\r\n"
                         + sum_of("HEHDT,12.0,T"))
            check(receive_all(page) == b"", "a browser is hung up on")
        check(heads(177), "a browser's lines")
        many = [socket.create_connection(("127.0.0.1", tcp), 5)
                for _ in range(20)]
        until("16 places", lambda: metric("tcp_refused_total") == 7)
        for s in [*many, drip, endless]:
            s.close()
        until("all are free", lambda: metric("tcp_clients") == 0)
        check(daemon.alive(), "alive")
        print(f"TCP: {lines} sentences in pieces of 997 bytes, an endless "
              "line, 22 connections")


def metric_sum(daemon, name):
    return sum(v for k, v in daemon.metrics().items()
               if k.startswith("pelagos_nmea_" + name))


def silence():
    """After 10 s without sentences the fix is stale and the turn is over;
    position and heading stay, and the next fix ends it."""
    nmea = free_port(socket.SOCK_DGRAM)
    fix = sum_of("GPRMC,120000,A,5241.0,N,00517.0,E,0.0,,210626,,,A").strip()
    with Daemon("--nmea", f"127.0.0.1:{nmea}", "--state", "off") as daemon:
        pour(daemon, nmea, [fix, sum_of("HEHDT,90.0,T").strip(),
                            sum_of("HEROT,60.0,A").strip()])
        state = daemon.state()
        check(state["entities"][0]["turnRate"] == 1, "turn rate")
        check(daemon.metrics()["pelagos_nmea_stale"] == 0, "stale at once")
        until("stale", lambda: daemon.metrics()["pelagos_nmea_stale"] == 1)

        def at_rest():
            now = daemon.state()
            return now["entities"][0].get("turnRate", 0) == 0 and now
        now = until("it turns no more", at_rest)
        entity = now["entities"][0]
        # It turned for 10 s, told once a second, or until that was noticed.
        spent = now["clock"]["time"] - state["clock"]["time"]
        check(99 < entity["heading"] < 91 + max(spent, 11),
              f"{entity['heading']}")
        check(metres_between((entity["latitude"], entity["longitude"]),
                             (52 + 41 / 60, 5 + 17 / 60)) < 0.01, "it moved")
        pour(daemon, nmea, [fix])
        check(daemon.metrics()["pelagos_nmea_stale"] == 0, "stale for ever")
        print("silence: stale after 10 s, fresh again with the next fix")


def voyage_is_current():
    made = subprocess.run([ROOT / "clients/voyage/voyage.py"], check=True,
                          capture_output=True).stdout
    check(made == VOYAGE.read_bytes(),
          "clients/voyage/voyage.nmea is not what voyage.py writes")


def main():
    voyage_is_current()
    malformed()
    by_tcp()
    silence()
    # Our own voyage keeps what it tells; a yacht's instruments do not.
    follow(VOYAGE, 2, 0.2)
    if not (DATA / "nmea").is_dir():
        print(f"no {DATA}/nmea: the logs of real devices are left out")
        return
    follow(DATA / "nmea/bundg_zeus_9.log", 10, 3.0)
    odd_logs()


if __name__ == "__main__":
    try:
        main()
    except AssertionError as failure:
        sys.exit(f"FAILED: {failure}")
