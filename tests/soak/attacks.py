#!/usr/bin/python3
"""Attacks by holders of a `watch` token, one after the other, each for
ATTACK_SECONDS (10), while an instructor edits, logs in, watches and asks for
/healthz. Prints a Markdown table of how long the instructor waited and what the
control thread's longest dispatch was; status 1 where a request of the
instructor failed or a bar was missed.

    tests/soak/attacks.py [NAME…]

Attackers are processes of nice 19, since those of real attacks run on machines
of their own. The first row is without an attack.
"""
import asyncio
import base64
import contextlib
import json
import multiprocessing
import os
import re
import socket
import statistics
import sys
import tempfile
import threading
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, os.pardir))
from pelagos_daemon import ROOT, Daemon, Session, free_port  # noqa: E402

SECONDS = float(os.environ.get("ATTACK_SECONDS", "10"))
BAR_MS = 50.0  # from request to first byte; of streams: added between pictures
DISPATCH_MS = 1.0
TOKENS = {role: f"{role}-token-0123456789" for role in
          ("watch", "steer", "instruct")}
EXERCISES, EXERCISE_KIB = 200, 700


# --- attackers ---------------------------------------------------------------

def head(method, path, role="watch", body=b"", more=""):
    kind = "Content-Type: application/json\r\n" if body else ""
    return (f"{method} {path} HTTP/1.1\r\nHost: localhost\r\n"
            f"Authorization: Bearer {TOKENS[role]}\r\n{kind}{more}"
            f"Content-Length: {len(body)}\r\n\r\n").encode() + body


async def ask(port, request, read=True, linger_s=None):
    """One request on a connection of its own, read to the end or left."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    try:
        writer.write(request)
        await writer.drain()
        if linger_s is not None:
            await asyncio.sleep(linger_s)
        elif read:
            while await reader.read(1 << 16):
                pass
        else:
            await asyncio.sleep(3600)
    finally:
        writer.close()


async def again(make, pause_s=0.0):
    """make() for ever; what is refused or closed is tried again."""
    while True:
        with contextlib.suppress(OSError, asyncio.IncompleteReadError):
            await make()
        await asyncio.sleep(pause_s or 0.02)


def close(request):
    return request.replace(b"\r\n\r\n", b"\r\nConnection: close\r\n\r\n", 1)


def points(count):
    return json.dumps({"points": [
        {"east": i % 100, "north": i // 100} for i in range(count)]},
        separators=(",", ":")).encode()


def surface(ports):
    request = close(head("POST", "/v1/surface", body=points(2000)))
    return [again(lambda: ask(ports["http"], request)) for _ in range(16)]


def surface_protobuf(ports):
    from pelagos_daemon import schema, varint
    pb = schema()

    def message(**command):
        data = pb.Request(id=1, **command).SerializeToString()
        return varint(len(data)) + data
    many = message(surface={"points": [
        {"east": i % 100, "north": i // 100} for i in range(3000)]})
    login = message(login={"token": TOKENS["watch"]})
    return [again(lambda: ask(ports["tcp"], login + many * 8, linger_s=1.0))
            for _ in range(16)]


def state(ports):
    return [again(lambda: ask(ports["http"],
                              close(head("GET", "/v1/state"))))
            for _ in range(16)]


def spectrum(ports):
    request = close(head("GET", "/v1/spectrum?format=json"))
    return [again(lambda: ask(ports["http"], request)) for _ in range(16)]


def series(ports):
    request = close(head(
        "GET", "/v1/series/surface?points=0,0;10,0;20,0;30,0&"
        "sweep=time=0:60:0.1"))
    return [again(lambda: ask(ports["http"], request)) for _ in range(8)]


def hls_reloads(ports):
    request = head("GET", "/v1/views/bridge/hls.m3u8?_HLS_msn=1&_HLS_part=0")
    return [again(lambda: ask(ports["http"], request)) for _ in range(150)]


def hls_left(ports):
    def one(i):
        width = 64 + 16 * (i % 64)
        return again(lambda: ask(
            ports["http"],
            head("GET", f"/v1/views/bridge/hls.m3u8?width={width}&height=64"),
            linger_s=0.03))
    return [one(i) for i in range(64)]


def mjpeg(ports):
    return [again(lambda i=i: ask(ports["http"], head(
        "GET", f"/v1/views/bridge/mjpeg?quality={i + 1}"))) for i in range(64)]


def sessions(ports):
    from pelagos_daemon import schema, varint
    pb = schema()
    login = pb.Request(id=1, login={"token": TOKENS["watch"]})
    watch = pb.Request(id=2, watch={})
    data = b"".join(varint(len(d)) + d for d in
                    (login.SerializeToString(), watch.SerializeToString()))
    return [again(lambda: ask(ports["tcp"], data)) for _ in range(64)]


def rtsp(ports):
    basic = base64.b64encode(f"x:{TOKENS['watch']}".encode()).decode()

    async def one():
        reader, writer = await asyncio.open_connection("127.0.0.1",
                                                       ports["rtsp"])
        url = f"rtsp://127.0.0.1:{ports['rtsp']}/bridge"

        async def send(method, at, number, more=""):
            writer.write((f"{method} {at} RTSP/1.0\r\nCSeq: {number}\r\n"
                          f"Authorization: Basic {basic}\r\n{more}\r\n")
                         .encode())
            answer = await reader.readuntil(b"\r\n\r\n")
            if (length := re.search(rb"Content-Length: (\d+)", answer, re.I)):
                answer += await reader.readexactly(int(length[1]))
            return answer
        try:
            sdp = await send("DESCRIBE", url, 1)
            control = re.findall(rb"a=control:(\S+)", sdp)
            at = control[-1].decode() if control else "stream=0"
            at = at if at.startswith("rtsp:") else f"{url}/{at}"
            await send("SETUP", at, 2, "Transport: RTP/AVP/TCP;unicast;"
                       "interleaved=0-1\r\n")
            await asyncio.sleep(3600)
        finally:
            writer.close()
    return [again(one) for _ in range(64)]


def idle(ports):
    return [again(lambda: ask(ports["http"],
                              b"GET /v1/state HTTP/1.1\r\nHost: localhost\r\n"))
            for _ in range(300)]


def unread(ports):
    """Pictures of 2048² that nobody reads."""
    request = head("GET", "/v1/views/bridge/frame.exr?width=2048&height=2048")
    return [again(lambda: ask(ports["http"], request, read=False))
            for _ in range(16)]


def exercises(ports):
    return [again(lambda: ask(ports["http"], close(
        head("GET", "/v1/exercises", role="instruct")))) for _ in range(4)]


def largest_patch(ports):
    """The largest legal edit of an instructor's, again and again."""
    def body():
        return json.dumps({"entities": fleet((time.time() * 7) % 360)},
                          separators=(",", ":")).encode()
    return [again(lambda: ask(ports["http"], close(
        head("PATCH", "/v1/state", role="instruct", body=body()))), 0.1)]


def fleet(heading):
    """As many ships as the state holds beside own ship, in under 64 KiB."""
    return {str(i): {"name": f"ship {i}", "latitude": 52.6 + i * 1e-4,
                     "longitude": 5.2 - i * 1e-4, "speed": i % 20,
                     "heading": round((heading + i * 7) % 360, 3),
                     "course": round((heading + i * 7) % 360, 3)}
            for i in range(2, 257)}


ATTACKS = [
    ("nobody", "no attack", None),
    ("surface", "16 × surface of 2,000 points, JSON", surface),
    ("surface_protobuf", "16 × 8 surfaces of 3,000 points, protobuf",
     surface_protobuf),
    ("state", "16 × the whole state", state),
    ("spectrum", "16 × the spectrum", spectrum),
    ("series", "8 series of 2,400 numbers", series),
    ("hls_reloads", "150 blocking reloads of HLS", hls_reloads),
    ("hls_left", "64 kinds of HLS, left after 30 ms", hls_left),
    ("mjpeg", "64 qualities of Motion-JPEG", mjpeg),
    ("sessions", "64 protobuf sessions that watch", sessions),
    ("rtsp", "64 SETUPs without PLAY", rtsp),
    ("idle", "300 halves of requests", idle),
    ("unread", "16 × an EXR of 2048² that nobody reads", unread),
    ("exercises", f"4 × the list of {EXERCISES} exercises of "
     f"{EXERCISE_KIB} KiB (instruct)", exercises),
    ("largest_patch", "an edit of 255 entities, ten a second (instruct)",
     largest_patch),
]


def attack(make, ports):
    os.nice(19)

    async def run():
        await asyncio.gather(*make(ports))
    asyncio.run(run())


WAITS = ("edit", "healthz", "login", "stream", "rtsp")


# --- the instructor ----------------------------------------------------------

class Instructor:
    """Waits are in ms; what fails is a sentence in `faults`."""

    def __init__(self, daemon, rtsp_port):
        self.daemon, self.rtsp_port = daemon, rtsp_port
        self.waits = {what: [] for what in WAITS}
        self.gaps, self.faults = [], []
        self.end = threading.Event()

    def http(self, method, path, body=None):
        begun = time.monotonic()
        answer = self.daemon.request(method, path, body, headers={
            "Authorization": "Bearer " + TOKENS["instruct"]}, timeout=20)
        if answer.status != 200:
            raise OSError(f"{method} {path}: {answer}")
        return (time.monotonic() - begun) * 1e3

    def edit(self):
        wind = 8 + len(self.waits["edit"]) % 2 * 0.5
        return self.http("PATCH", "/v1/state",
                         {"entities": {"1": {"speed": wind}}})

    def healthz(self):
        return self.http("GET", "/healthz")

    def login(self):
        begun = time.monotonic()
        with Session(self.daemon.connect_tcp(20)) as session:
            reply = session.ask(login={"token": TOKENS["instruct"]})
            if reply is None or reply.HasField("error"):
                raise OSError(f"login: {reply}")
        return (time.monotonic() - begun) * 1e3

    def stream(self):
        """From asking for a live view to its first byte."""
        begun = time.monotonic()
        quality = 60 + len(self.waits["stream"]) % 20
        with self.open_stream(f"quality={quality}") as s:
            if b" 200 " not in (first := s.recv(4096)):
                raise OSError(f"stream: {first[:200]}")
        return (time.monotonic() - begun) * 1e3

    def rtsp(self):
        """From connecting to the answer to a question."""
        begun = time.monotonic()
        with socket.create_connection(("127.0.0.1", self.rtsp_port), 20) as s:
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
            for name in self.waits:
                try:
                    self.waits[name].append(getattr(self, name)())
                except (OSError, ValueError) as fault:
                    self.faults.append(f"{name}: {fault}")
                time.sleep(0.02)


def p99(values):
    if not values:
        return float("nan")
    return sorted(values)[min(len(values) - 1, int(len(values) * 0.99))]


def longest_dispatch(metrics):
    """By processor time where the daemon says so; ms and its name."""
    found = [(v * 1e3, re.search(r'"([^"]*)"', k)[1])
             for k, v in metrics.items()
             if re.match(r"pelagos_control_(processor|cpu)_longest", k)]
    found = found or [(v * 1e3, re.search(r'"([^"]*)"', k)[1])
                      for k, v in metrics.items()
                      if k.startswith("pelagos_control_stall_longest")]
    return max(found, default=(0.0, "nothing"))


def prepare(folder):
    tokens = os.path.join(folder, "tokens")
    with open(tokens, "w", encoding="ascii") as f:
        f.writelines(f"{t} {r} of-{r}\n" for r, t in TOKENS.items())
    os.chmod(tokens, 0o600)
    os.mkdir(os.path.join(folder, "exercises"))
    with open(os.path.join(ROOT, "clients/exercises/crossing.json"),
              encoding="utf-8") as f:
        text = f.read().rstrip()
    text = text[:-1] + " " * (EXERCISE_KIB * 1024 - len(text)) + "}"
    for i in range(EXERCISES):
        with open(os.path.join(folder, "exercises", f"e{i:03}.json"), "w",
                  encoding="ascii") as f:
            f.write(text)
    return tokens


def one_attack(name, words, make, tokens, folder):
    rtsp_port = free_port()
    with Daemon("--token-file", tokens, "--rtsp", f"127.0.0.1:{rtsp_port}",
                "--exercises", os.path.join(folder, "exercises")) as daemon:
        instructor = Instructor(daemon, rtsp_port)
        view = {"entity": 1, "width": 320, "height": 180}
        for change in ({"views": {"bridge": view, "wing": view}},
                       {"entities": fleet(0)}):
            instructor.http("PATCH", "/v1/state", change)
        watcher = threading.Thread(target=instructor.watch)
        watcher.start()
        time.sleep(2)  # programs are compiled
        instructor.work(1)
        instructor.__dict__.update(gaps=[], faults=[], waits={
            k: [] for k in instructor.waits})
        attacker = None
        if make:
            attacker = multiprocessing.Process(target=attack, args=(
                make, {"http": daemon.http_port, "tcp": daemon.tcp_port,
                       "rtsp": rtsp_port}), daemon=True)
            attacker.start()
            time.sleep(1)
        instructor.work(SECONDS)
        resident = daemon.rss() / 1e6
        if attacker:
            attacker.kill()
            attacker.join()
        instructor.end.set()
        watcher.join()
        try:
            metrics = {}
            for line in daemon.request("GET", "/metrics", headers={
                    "Authorization": "Bearer " + TOKENS["instruct"]}
                    ).body.decode().splitlines():
                if line and not line.startswith("#"):
                    key, value = line.rsplit(" ", 1)
                    metrics[key] = float(value)
        except (OSError, ValueError) as fault:
            instructor.faults.append(f"metrics: {fault}")
        return instructor, longest_dispatch(metrics), resident


def main():
    wanted = sys.argv[1:]
    print("| attack | edit | /healthz | login | new live view | RTSP "
          "| pictures | longest dispatch | resident | failed |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    missed, base = False, None
    with tempfile.TemporaryDirectory() as folder:
        tokens = prepare(folder)
        for name, words, make in ATTACKS:
            if wanted and name not in wanted and make:
                continue
            one, (ms, what), resident = one_attack(name, words, make, tokens,
                                                   folder)
            gap = p99(one.gaps)
            base = gap if base is None else base
            cells = [f"{statistics.median(w):.1f}, {p99(w):.1f}" if w else "–"
                     for w in one.waits.values()]
            asked = sum(map(len, one.waits.values())) + len(one.faults)
            print(f"| {words} | {' | '.join(cells)} | {gap:.0f} "
                  f"({gap - base:+.0f}) | {ms:.1f} ({what}) | "
                  f"{resident:.0f} MB | {len(one.faults)} of {asked} |",
                  flush=True)
            for fault in dict.fromkeys(one.faults[:5]):
                print(f"  {name}: {fault}", file=sys.stderr)
            missed |= bool(one.faults) or gap - base > BAR_MS or any(
                p99(w) > BAR_MS for w in one.waits.values())
            missed |= ms > DISPATCH_MS
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
