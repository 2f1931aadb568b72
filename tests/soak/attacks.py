#!/usr/bin/python3
"""Attacks by holders of a `watch` token (attackers.py), one after the other,
each for ATTACK_SECONDS (10) in two parts with as much quiet between, while an
instructor edits, logs in, watches and asks for /healthz. Prints a Markdown
table of how long the instructor waited, quiet and attacked, of the control
thread's longest dispatch, and of how many of the attackers' requests were
accepted; then every bar that was missed. Status 1 where one was, a request of
the instructor failed, or an attack was not accepted as meant.

    tests/soak/attacks.py [--parent DIR] [NAME…]

--parent DIR: each attack on the programs of DIR first, then on ours. Their bars
are not judged. Attackers are processes of nice 19, since those of real attacks
run on machines of their own.
"""
import contextlib
import multiprocessing
import os
import re
import signal
import socket
import ssl
import statistics
import subprocess
import sys
import tempfile
import threading
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, os.pardir))
sys.path.insert(0, HERE)
import pelagos_daemon  # noqa: E402
from attackers import (ATTACKS, EXERCISE_KIB, EXERCISES, SPARE,  # noqa: E402
                       TALLY, TOKENS, attack, fleet, head, hls_left,
                       hls_reloads, idle, mjpeg, rtsp, sessions, teardown,
                       ts_kinds, websockets)
from pelagos_daemon import ROOT, Daemon, Session, free_port  # noqa: E402

__all__ = ["TOKENS", "attack", "head", "hls_left", "hls_reloads", "idle",
           "mjpeg", "rtsp", "sessions", "teardown", "ts_kinds", "websockets"]
SECONDS = float(os.environ.get("ATTACK_SECONDS", "10"))
BAR_MS = 50.0  # from request to first byte; of streams: added between pictures
DISPATCH_MS = 1.0
DATAGRAMS = 3  # an address of others hears no more of an offer; times its bytes
WAITS = ("edit", "healthz", "login", "stream", "rtsp")


class Instructor:
    """Waits are in ms; what fails is a sentence in `faults`."""

    def __init__(self, daemon, rtsp_port, tls=None):
        self.daemon, self.rtsp_port, self.tls = daemon, rtsp_port, tls
        self.end = threading.Event()
        self.asked = 0
        self.begin()

    def begin(self):
        """From now on others are counted; those so far."""
        before = self.__dict__.get("waits"), self.__dict__.get("gaps")
        self.waits = {what: [] for what in WAITS}
        self.gaps, self.faults = [], []
        return before

    def http(self, method, path, body=None):
        begun = time.monotonic()
        answer = self.daemon.request(method, path, body, headers={
            "Authorization": "Bearer " + TOKENS["instruct"]}, timeout=20)
        if answer.status != 200:
            raise OSError(f"{method} {path}: {answer}")
        return (time.monotonic() - begun) * 1e3

    def edit(self):
        self.asked += 1
        return self.http("PATCH", "/v1/state", {
            "entities": {"1": {"speed": 8 + self.asked % 2 * 0.5}}})

    def healthz(self):
        return self.http("GET", "/healthz")

    def wrapped(self, s):
        return self.tls.wrap_socket(s) if self.tls else s

    def login(self):
        begun = time.monotonic()
        with Session(self.wrapped(self.daemon.connect_tcp(20))) as session:
            reply = session.ask(login={"token": TOKENS["instruct"]})
            if reply is None or reply.HasField("error"):
                raise OSError(f"login: {reply}")
        return (time.monotonic() - begun) * 1e3

    def stream(self):
        """From asking for a live view to its first byte."""
        self.asked += 1
        begun = time.monotonic()
        with self.open_stream(f"quality={60 + self.asked % 20}") as s:
            if b" 200 " not in (first := s.recv(4096)):
                raise OSError(f"stream: {first[:200]}")
        return (time.monotonic() - begun) * 1e3

    def rtsp(self):
        """From connecting to the answer to a question."""
        begun = time.monotonic()
        with self.wrapped(socket.create_connection(
                ("127.0.0.1", self.rtsp_port), 20)) as s:
            s.sendall(f"OPTIONS rtsp://127.0.0.1:{self.rtsp_port}/wing "
                      "RTSP/1.0\r\nCSeq: 1\r\nAuthorization: Bearer "
                      f"{TOKENS['instruct']}\r\n\r\n".encode())
            if not (first := s.recv(4096)).startswith(b"RTSP/1.0 200"):
                raise OSError(f"rtsp: {first[:100]}")
        return (time.monotonic() - begun) * 1e3

    def open_stream(self, query):
        s = self.daemon.connect_http(20)
        s.sendall(head("GET", f"/v1/views/wing/mjpeg?{query}", "instruct"))
        return s

    def watch(self):
        """One live view, open all the time: moments between its pictures."""
        last = None
        with self.open_stream("quality=80") as s:
            rest = b""
            while not self.end.is_set():
                data = s.recv(1 << 16)
                if not data:
                    self.faults.append("the live view ended")
                    return
                rest = rest[-16:] + data
                count = rest.count(b"--pelagos\r\n")
                rest = rest[rest.rfind(b"--pelagos\r\n") + 11:] \
                    if count else rest
                for _ in range(count):
                    now = time.monotonic()
                    if last is not None:
                        self.gaps.append((now - last) * 1e3)
                    last = now

    def work(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            for name in WAITS:
                try:
                    self.waits[name].append(getattr(self, name)())
                except (OSError, ValueError) as fault:
                    self.faults.append(f"{name}: {fault}")
                time.sleep(0.02)


def p99(values):
    if not values:
        return float("nan")
    return sorted(values)[min(len(values) - 1, int(len(values) * 0.99))]


# --- one attack ----------------------------------------------------------------

def longest_dispatch(instructor):
    """[ms], its name and its clock: the thread's own where there is one."""
    found = {}
    answer = instructor.daemon.request("GET", "/metrics", headers={
        "Authorization": "Bearer " + TOKENS["instruct"]})
    for clock, name in (("processor", "(?:processor|cpu)"), ("wall", "stall")):
        found[clock] = [
            (float(value) * 1e3, what, clock) for what, value in re.findall(
                rf'^pelagos_control_{name}_longest\w*{{[^"]*"([^"]*)"}} (\S+)',
                answer.body.decode(), re.M)]
    return max(found["processor"] or found["wall"] or [(0.0, "nothing", "")])


class Place:
    """Files that all daemons of a run use."""

    def __init__(self, folder):
        self.folder = folder
        self.tokens = os.path.join(folder, "tokens")
        self.cert, self.key = (os.path.join(folder, n) for n in
                               ("cert.pem", "key.pem"))
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt",
                        "ec_paramgen_curve:P-256", "-nodes", "-subj",
                        "/CN=localhost", "-days", "2", "-keyout", self.key,
                        "-out", self.cert], check=True, capture_output=True)
        os.chmod(self.key, 0o600)
        self.write(True)
        os.mkdir(os.path.join(folder, "exercises"))
        with open(os.path.join(ROOT, "clients/exercises/crossing.json"),
                  encoding="utf-8") as f:
            text = f.read().rstrip()
        text = text[:-1] + " " * (EXERCISE_KIB * 1024 - len(text)) + "}"
        for i in range(EXERCISES):
            with open(os.path.join(folder, "exercises", f"e{i:03}.json"), "w",
                      encoding="ascii") as f:
                f.write(text)

    def write(self, spare):
        tokens = {**{t: r for r, t in TOKENS.items()},
                  **({SPARE: "watch"} if spare else {})}
        with open(self.tokens + ".new", "w", encoding="ascii") as f:
            f.writelines(f"{t} {r} of-{r}-{len(t)}\n"
                         for t, r in tokens.items())
        os.chmod(self.tokens + ".new", 0o600)
        os.replace(self.tokens + ".new", self.tokens)


@contextlib.contextmanager
def revoking(place, daemon):
    """Takes the spare token back each second, and gives it again."""
    end = threading.Event()

    def run():
        there = True
        while not end.wait(0.5):
            there = not there
            place.write(there)
            daemon.process.send_signal(signal.SIGHUP)
    thread = threading.Thread(target=run)
    thread.start()
    yield
    end.set()
    thread.join()
    place.write(True)


class Ears:
    """Addresses that an offer names, and what they hear."""

    def __init__(self):
        self.port = free_port()
        self.sockets = []
        for i in range(16):
            s = socket.socket(type=socket.SOCK_DGRAM)
            s.bind((f"127.0.7.{i + 1}", self.port))
            s.setblocking(False)
            self.sockets.append(s)

    def heard(self):
        count, where = 0, 0
        for s in self.sockets:
            before = count
            with contextlib.suppress(BlockingIOError):
                while s.recv(4096):
                    count += 1
            where += count > before
        return count, where


def one_attack(name, make, place, folder):
    """Programs of `folder`; what was seen."""
    pelagos_daemon.BIN = folder
    rtsp_port, options, ears = free_port(), [], None
    if name == "tls_stalls":
        options = ["--tls-cert", place.cert, "--tls-key", place.key]
    if name == "ice":
        ears = Ears()
        options = ["--whep-servers", f"stun://127.0.0.1:{free_port()}",
                   "--trust-proxy", "127.0.0.1"]
    tls = None
    if name == "tls_stalls":
        tls = ssl.create_default_context()
        tls.check_hostname, tls.verify_mode = False, ssl.CERT_NONE
    with Daemon("--token-file", place.tokens, "--rtsp",
                f"127.0.0.1:{rtsp_port}", "--exercises",
                os.path.join(place.folder, "exercises"), *options) as daemon:
        one = Instructor(daemon, rtsp_port, tls)
        view = {"entity": 1, "width": 320, "height": 180}
        for change in ({"views": {"bridge": view, "wing": view}},
                       {"entities": fleet(0)}):
            one.http("PATCH", "/v1/state", change)
        watcher = threading.Thread(target=one.watch)
        watcher.start()
        time.sleep(2)  # programs are compiled
        one.work(1)
        quiet, attacked, faults = ({w: [] for w in (*WAITS, "gaps")},
                                   {w: [] for w in (*WAITS, "gaps")}, [])
        ports = {"http": daemon.http_port, "tcp": daemon.tcp_port,
                 "rtsp": rtsp_port, "ice": ears.port if ears else 0}
        TALLY.take()

        def part(into):
            one.begin()
            one.work(SECONDS / 2)
            faults.extend(one.faults)
            for what in WAITS:
                into[what] += one.waits[what]
            into["gaps"] += one.gaps
        try:
            before = longest_dispatch(one)
            for _ in range(2):
                part(quiet)
                attacker = multiprocessing.Process(
                    target=attack, args=(make, ports), daemon=True)
                attacker.start()
                time.sleep(1)
                with revoking(place, daemon) if name == "revoked" \
                        else contextlib.nullcontext():
                    part(attacked)
                resident = daemon.rss() / 1e6
                attacker.kill()
                attacker.join()
                time.sleep(1)
            after = longest_dispatch(one)
        except OSError as fault:
            faults.append(f"{name}: {fault}")
            before = after = (float("nan"), "not told", "")
            resident = 0
        one.end.set()
        watcher.join()
    return {"quiet": quiet, "attacked": attacked, "faults": faults,
            "dispatch": after, "rose": after[0] > before[0],
            "resident": resident, "tally": TALLY.take(),
            "heard": ears.heard() if ears else None}


# --- the table -------------------------------------------------------------------

def seen(r):
    """Cells of one run."""
    asked = sum(len(r["attacked"][w]) + len(r["quiet"][w])
                for w in WAITS) + len(r["faults"])
    added = p99(r["attacked"]["gaps"]) - p99(r["quiet"]["gaps"])
    waits = ", ".join(f"{p99(r['attacked'][w]):.0f}" for w in WAITS)
    quiet = ", ".join(f"{p99(r['quiet'][w]):.0f}" for w in WAITS)
    ms, what, clock = r["dispatch"]
    return (f"{len(r['faults'])} of {asked}", waits, quiet,
            f"{p99(r['attacked']['gaps']):.0f} ({added:+.0f})",
            f"{'' if r['rose'] else '≤ '}{ms:.1f} ({what}, {clock})")


def missed(name, r):
    """A sentence for each bar that this run misses."""
    out = [f"{len(r['faults'])} requests failed"] if r["faults"] else []
    for what in WAITS:
        waits, quiet = r["attacked"][what], r["quiet"][what]
        if waits and p99(waits) > BAR_MS:
            out.append(f"{what} p99 {p99(waits):.0f} ms (quiet "
                       f"{p99(quiet):.0f}, median {statistics.median(waits):.1f})")
    added = p99(r["attacked"]["gaps"]) - p99(r["quiet"]["gaps"])
    if not added <= BAR_MS:
        out.append(f"pictures {added:+.0f} ms")
    ms, what, clock = r["dispatch"]
    if not ms <= DISPATCH_MS and clock != "wall":
        out.append(f"a dispatch of {ms:.2f} ms ({what})"
                   + ("" if r["rose"] else ", while it was quiet"))
    accepted, _, wrong = r["tally"]
    if wrong or not accepted:
        out.append(f"{wrong} of the attackers' requests were refused, "
                   f"{accepted} accepted: "
                   f"{TALLY.first.value.decode(errors='replace')}")
    if r["heard"] and r["heard"][0] > DATAGRAMS * max(accepted, 1):
        out.append(f"{r['heard'][0]} datagrams to others for {accepted} offers")
    return [f"{name}: {each}" for each in out]


def main():
    wanted, parent = sys.argv[1:], None
    if wanted[:1] == ["--parent"]:
        parent, wanted = wanted[1], wanted[2:]
    ours = pelagos_daemon.BIN
    print(f"p99 in ms: {', '.join(WAITS)}; load at the begin "
          f"{os.getloadavg()[0]:.1f}\n")
    print("| attack | programs | failed | attacked | quiet | pictures "
          "| longest dispatch | resident | attackers: accepted, busy, refused |")
    print("|---|---|---|---|---|---|---|---|---|")
    bars = []
    with tempfile.TemporaryDirectory() as folder:
        place = Place(folder)
        for name, words, make in ATTACKS:
            if wanted and name not in wanted:
                continue
            for which, programs in (("before", parent), ("now", ours)):
                if not programs:
                    continue
                TALLY.first.value = b""
                r = one_attack(name, make, place, programs)
                accepted, busy, wrong = r["tally"]
                heard = f"; {r['heard'][0]} datagrams to {r['heard'][1]} " \
                    "addresses" if r["heard"] else ""
                print(f"| {words} | {which} | {' | '.join(seen(r))} | "
                      f"{r['resident']:.0f} MB | {accepted}, {busy}, {wrong}"
                      f"{heard} |", flush=True)
                for fault in dict.fromkeys(r["faults"][:5]):
                    print(f"  {name} {which}: {fault}", file=sys.stderr)
                bars += missed(name, r) if which == "now" else []
    print(f"\nload at the end {os.getloadavg()[0]:.1f}")
    print("\n".join(["bars missed:", *bars] if bars else ["all bars are held"]))
    return 1 if bars else 0


if __name__ == "__main__":
    sys.exit(main())
