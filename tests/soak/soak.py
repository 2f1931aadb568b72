#!/usr/bin/python3
"""Keeps a daemon under load for SOAK_SECONDS (600) and prints how its memory,
descriptors and threads grow: viewers of which a quarter never read, edits,
views that come, change their size and go, pictures of every format, surface
queries, a CIGI host at 60 Hz, NMEA, Modbus, and garbage on every port.

Every ten seconds a line, with the memory that is resident and the part of it
that malloc has given out. After the first ten minutes, and at the end, the load
stops, and the same state is shown for a while: what is held then may not have
grown, whatever views and seas there were. At the end the verdict, status 1 if a
bar is missed.
"""
import contextlib
import math
import os
import random
import socket
import struct
import sys
import threading
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)),
                                os.pardir))
from cigi_host import Host, entity, hat_hot  # noqa: E402
from pelagos_daemon import (SANITIZED, Daemon, Session,  # noqa: E402
                            free_port)

SECONDS = float(os.environ.get("SOAK_SECONDS", "600"))
# By then every kind of picture has been drawn in every size of this load.
WARM_UP_S = min(600.0, SECONDS / 3)
VIEWERS, STALLED = 12, 4
# After ten minutes; a shorter load is still learning what it needs.
MOST_GROWTH = (8 if WARM_UP_S >= 600 else 64) << 20
# Longer than what nobody asks for is kept, of programs PEL_PROGRAM_IDLE_S: there
# are as many beyond 32 as two minutes have needed, 1.7 MB each.
REST_S = 130
# Two cores draw, encode and run all clients; nobody waits for a picture here.
SLOWEST_HEALTHZ_S = 0.25


class Load:
    def __init__(self, daemon, modbus, nmea, cigi):
        self.daemon, self.modbus, self.nmea = daemon, modbus, nmea
        self.cigi = cigi
        self.end = threading.Event()
        self.lock = threading.Lock()
        self.counts = {}
        self.waits = []
        self.faults = []
        self.threads = []

    def count(self, what, by=1):
        with self.lock:
            self.counts[what] = self.counts.get(what, 0) + by

    def start(self, work, *arguments):
        def run():
            chance = random.Random(work.__name__ + repr(arguments))
            while not self.end.is_set():
                try:
                    work(chance, *arguments)
                except OSError as error:
                    # Pictures of a view that has just gone, an evicted idler.
                    self.count(f"{work.__name__}: {type(error).__name__}")
                    self.end.wait(0.05)
                except Exception as error:  # noqa: BLE001: told at the end
                    self.faults.append(f"{work.__name__}: {error!r}")
                    return
        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        self.threads.append(thread)

    def expect(self, response, *statuses):
        if response.status not in statuses:
            self.faults.append(repr(response))

    # --- one turn of each kind of client ------------------------------------

    def viewer(self, _):
        with self.daemon.connect_http(20) as s:
            s.sendall(b"GET /v1/views/bridge/mjpeg HTTP/1.1\r\n"
                      b"Host: localhost\r\n\r\n")
            while not self.end.is_set():
                data = s.recv(1 << 16)
                if not data:
                    return
                self.count("pictures seen", data.count(b"image/jpeg"))

    def stalled(self, _):
        with socket.socket() as s:
            s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            s.connect(("127.0.0.1", self.daemon.http_port))
            s.sendall(b"GET /v1/views/bridge/mjpeg HTTP/1.1\r\n"
                      b"Host: localhost\r\n\r\n")
            self.end.wait(30)

    def edits(self, chance):
        self.expect(self.daemon.patch({
            "sea": {"windSpeed": chance.uniform(0, 30),
                    "seed": chance.randrange(1 << 32),
                    "swell": [[chance.uniform(0, 6), 9, 200, 20]]},
            "sky": {"visibility": chance.choice([2000, 40000])}}), 200)
        self.count("edits")
        self.end.wait(0.02)

    def views(self, chance):
        name = f"v{chance.randrange(20)}"
        if chance.random() < 0.3:
            self.expect(self.daemon.request("DELETE", f"/v1/views/{name}"),
                        204, 404)
        else:
            self.expect(self.daemon.request("PUT", f"/v1/views/{name}", {
                "entity": 1, "yaw": chance.uniform(-180, 180),
                "up": 10 ** chance.uniform(0, 3),
                "width": chance.choice([16, 64, 333, 640]),
                "height": chance.choice([16, 64, 200, 360])}), 200, 201)
        self.count("views made and removed")
        self.end.wait(0.05)

    def pictures(self, chance):
        name = chance.choice(["bridge", f"v{chance.randrange(20)}"])
        kind = chance.choice(["jpg", "png", "exr"])
        response = self.daemon.get(
            f"/v1/views/{name}/frame.{kind}?width={chance.randrange(16, 320)}"
            f"&height={chance.randrange(16, 200)}")
        self.expect(response, 200, 404)
        self.count("pictures asked for")

    def sessions(self, chance):
        with Session(self.daemon.connect_tcp()) as session:
            for _ in range(20):
                points = [{"east": chance.uniform(-1e6, 1e6),
                           "north": chance.uniform(-1e6, 1e6)}] * 50
                reply = session.ask(surface={"points": points})
                if not all(math.isfinite(p.height)
                           for p in reply.surface.points):
                    self.faults.append("a height is not finite")
                session.ask(get={})
                self.count("surface queries")
                self.end.wait(0.02)

    def ships(self, chance):
        heading = chance.randrange(360)
        body = f"HEHDT,{heading}.0,T"
        checksum = 0
        for c in body.encode():
            checksum ^= c
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
            s.sendto(f"${body}*{checksum:02X}\r\n".encode(),
                     ("127.0.0.1", self.nmea))
            s.sendto(chance.randbytes(chance.randrange(1, 500)),
                     ("127.0.0.1", self.nmea))
        self.count("datagrams", 2)
        self.end.wait(0.02)

    def consoles(self, chance):
        with socket.create_connection(("127.0.0.1", self.modbus), 5) as s:
            wind = struct.pack(">f", chance.uniform(0, 30))
            s.sendall(struct.pack(">HHHBBHHB", 1, 0, 11, 1, 16, 10, 2, 4)
                      + wind)
            s.recv(260)
            s.sendall(struct.pack(">HHHBBHH", 2, 0, 6, 1, 6, 5, 1))
            s.recv(260)
        self.count("Modbus commits")
        self.end.wait(0.1)

    def host(self, chance):
        """Unanswered frames are counted; that they may be is another test."""
        host = Host(("127.0.0.1", self.cigi))
        try:
            for i in range(600):
                begun = time.monotonic()
                host.send(entity(2, 52.601, 5.201, yaw=i % 360), *(
                    hat_hot(k, chance.uniform(52.59, 52.61), 5.2)
                    for k in range(4)))
                self.count("CIGI frames answered" if host.receive(1.0)
                           else "CIGI frames unanswered")
                if self.end.wait(max(0, begun + 1 / 60 - time.monotonic())):
                    return
        finally:
            host.socket.close()

    def garbage(self, chance):
        port = chance.choice([self.daemon.http_port, self.daemon.tcp_port,
                              self.modbus])
        with socket.create_connection(("127.0.0.1", port), 5) as s:
            s.sendall(chance.randbytes(chance.randrange(1, 3000)))
            if chance.random() < 0.5:
                s.shutdown(socket.SHUT_WR)
            s.settimeout(0.1)
            with contextlib.suppress(OSError):
                s.recv(4096)
        self.count("garbage")

    def health(self, _):
        start = time.monotonic()
        self.expect(self.daemon.get("/healthz"), 200)
        self.waits.append(time.monotonic() - start)
        self.end.wait(0.1)


def figures(daemon):
    folder = f"/proc/{daemon.process.pid}"
    return (daemon.rss(), len(os.listdir(f"{folder}/fd")),
            len(os.listdir(f"{folder}/task")),
            daemon.metrics()["process_heap_bytes"])


def rest(daemon):
    """Shows one state until what others needed has been given back."""
    for i in range(20):
        daemon.request("DELETE", f"/v1/views/v{i}")
    daemon.patch({"sea": {"windSpeed": 8, "seed": 1, "swell": []},
                  "sky": {"visibility": 40000}})
    for _ in range(REST_S):
        daemon.get("/v1/views/bridge/frame.jpg")
        time.sleep(1)
    return figures(daemon)


def line(at, figures_of, more=""):
    rss, fds, threads, heap = figures_of
    print(f"{at:>6}{rss / 1e6:8.1f}{heap / 1e6:8.1f}{fds:5}{threads:9}{more}",
          flush=True)


class Run:
    """The load, in parts; its lines go on from one part to the next."""

    def __init__(self, *arguments):
        self.arguments = arguments
        self.daemon = arguments[0]
        self.counts, self.waits, self.faults = {}, [], []
        self.began = time.monotonic()
        self.peak = 0

    def part(self, seconds):
        load = Load(*self.arguments)
        for _ in range(VIEWERS - STALLED):
            load.start(load.viewer)
        for _ in range(STALLED):
            load.start(load.stalled)
        for work in (load.edits, load.views, load.pictures, load.sessions,
                     load.ships, load.consoles, load.host, load.garbage,
                     load.health):
            load.start(work)
        end = time.monotonic() + seconds
        last, last_counts = time.monotonic(), {}
        while time.monotonic() < end and self.daemon.alive():
            time.sleep(min(10.0, seconds / 6))
            if not self.daemon.alive():
                break
            now, got = time.monotonic(), figures(self.daemon)
            self.peak = max(self.peak, got[0])
            with load.lock:
                counts = dict(load.counts)
            rate = [(counts.get(k, 0) - last_counts.get(k, 0)) / (now - last)
                    for k in ("pictures seen", "edits")]
            line(f"{now - self.began:.0f}", got,
                 f"{rate[0]:12.1f}{rate[1]:9.1f}")
            last, last_counts = now, counts
        load.end.set()
        for thread in load.threads:
            thread.join(40)
        for name, count in load.counts.items():
            self.counts[name] = self.counts.get(name, 0) + count
        self.waits += load.waits
        self.faults += load.faults
        if not self.daemon.alive():
            self.faults.append("the daemon has ended")
            return None
        got = rest(self.daemon)
        programs = self.daemon.metrics()["pelagos_render_programs"]
        line("rest", got, f", {programs:.0f} programs of the device")
        return got


def main():
    modbus = free_port()
    nmea = free_port(socket.SOCK_DGRAM)
    cigi = free_port(socket.SOCK_DGRAM)
    daemon = Daemon("--modbus", f"127.0.0.1:{modbus}",
                    "--nmea", f"127.0.0.1:{nmea}",
                    "--cigi", f"127.0.0.1:{cigi}")
    daemon.patch({"views": {"bridge": {"width": 480, "height": 270}},
                  "sea": {"seed": 2}})  # one thread is there from an edit on
    print("   t s  rss MB heap MB  fds  threads  pictures/s  edits/s", flush=True)
    idle = rest(daemon)
    line("idle", idle)
    run = Run(daemon, modbus, nmea, cigi)
    warm = run.part(WARM_UP_S)
    after = run.part(SECONDS - WARM_UP_S) if warm else None
    bad = list(dict.fromkeys(run.faults))
    if after:
        print(f"at most {run.peak / 1e6:.0f} MB; what is held grew by "
              f"{(after[0] - warm[0]) / 1e6:.1f} MB, of malloc's by "
              f"{(after[3] - warm[3]) / 1e6:.1f} MB")
        for name, at in (("resident", 0), ("malloc's", 3)):
            if not SANITIZED and after[at] - warm[at] > MOST_GROWTH:
                bad.append(f"{name} memory that is held grew by "
                           f"{(after[at] - warm[at]) / 1e6:.0f} MB")
        if after[1] > idle[1]:
            bad.append(f"{after[1] - idle[1]} descriptors are left over")
        if after[2] > idle[2]:
            bad.append(f"{after[2] - idle[2]} threads are left over")
    for name, count in sorted(run.counts.items()):
        print(f"{count:10} {name}")
    waits = sorted(run.waits) or [math.inf]
    p99 = waits[int(0.99 * (len(waits) - 1))]
    print(f"healthz: median {1e3 * waits[len(waits) // 2]:.1f} ms, "
          f"p99 {1e3 * p99:.1f} ms")
    if not SANITIZED and p99 > SLOWEST_HEALTHZ_S:
        bad.append(f"healthz took {p99:.2f} s")
    log = daemon.log()
    bad += [text for text in log.splitlines() if text.split(" ", 2)[1:2] == ["error"]][:5]
    status = daemon.stop()
    if status != 0:
        bad.append(f"pelagosd ended with {status}")
    for text in bad[:10]:
        print("BAD", text)
    print("soak: " + ("failed" if bad else "good"))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
