"""What holders of a token may ask for, and ask for too often: each attack is a
function from where the daemon listens to tasks that go on until the process is
killed. What comes back is counted: an attack that is refused where it should be
accepted says nothing about how it is withstood."""
import asyncio
import base64
import contextlib
import json
import multiprocessing
import os
import re
import ssl
import struct
import time

TOKENS = {role: f"{role}-token-0123456789" for role in
          ("watch", "steer", "instruct")}
SPARE = "spare-token-0123456789"  # that is taken back and given again
EXERCISES, EXERCISE_KIB = 200, 700
POINTS = 10000  # the most of a question about the surface


class Tally:
    """Requests accepted, refused since a share is taken, refused otherwise; and
    the first of these last. An attacker counts, whoever started it reads; no
    lock, since attackers are killed."""

    def __init__(self):
        self.counts = multiprocessing.RawArray("Q", 3)
        self.first = multiprocessing.RawArray("c", 200)

    def add(self, which, what=b""):
        self.counts[which] += 1
        if which == 2 and not self.first.value:
            self.first.value = bytes(what[:199]).replace(b"\0", b"")

    def take(self):
        out = list(self.counts)
        self.counts[:] = [0, 0, 0]
        return out


TALLY = Tally()


def judge(status, what=b"", meant=()):
    if status in (200, 201, 101, 204, 304) or status in meant:
        TALLY.add(0)
    elif status in (429, 503):
        TALLY.add(1)
    else:
        TALLY.add(2, what or str(status).encode())


def judge_head(head, meant=()):
    parts = head.split(b" ", 2)
    judge(int(parts[1]) if len(parts) > 1 and parts[1].isdigit() else 0,
          head.replace(b"\r\n", b" "), meant)


def head(method, path, role="watch", body=b"", more="", token=None):
    kind = "Content-Type: application/json\r\n" if body else ""
    return (f"{method} {path} HTTP/1.1\r\nHost: localhost\r\n"
            f"Authorization: Bearer {token or TOKENS[role]}\r\n{kind}{more}"
            f"Content-Length: {len(body)}\r\n\r\n").encode() + body


async def ask(port, request, read=True, linger_s=None, meant=()):
    """One request on a connection of its own, read to the end; read=False: no
    more than the head; linger_s: left after that, whatever there is. No answer
    within a second: the daemon is at work on it."""
    reader, writer = await asyncio.open_connection(
        "127.0.0.1", port, limit=1 << 16 if read else 256)
    answer = None
    try:
        writer.write(request)
        await writer.drain()
        answer = asyncio.ensure_future(
            reader.readuntil(b"\r\n\r\n" if read else b"\r\n"))
        await asyncio.wait({answer}, timeout=linger_s or 1.0)
        if not answer.done():
            TALLY.add(0)
        else:
            judge_head(answer.result(), meant)
        if linger_s is not None:
            return
        await answer
        while read and await reader.read(1 << 16):
            pass
        if not read:
            await asyncio.sleep(3600)
    except asyncio.IncompleteReadError as end:
        judge_head(end.partial or b"- 0 closed")
    finally:
        if answer:
            answer.cancel()
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
    return json.dumps({"points": [[i % 100, i // 100] for i in range(count)]},
                      separators=(",", ":")).encode()


def http(count, request, **how):
    def make(ports):
        return [again(lambda: ask(ports["http"], request, **how))
                for _ in range(count)]
    return make


# --- answers whose size the asker chooses ------------------------------------

surface = http(16, close(head("POST", "/v1/surface", body=points(POINTS))))
state = http(16, close(head("GET", "/v1/state")))
spectrum = http(16, close(head("GET", "/v1/spectrum?format=json")))
series = http(8, close(head(
    "GET", "/v1/series/surface?points=0,0;10,0;20,0;30,0&"
    "sweep=time=0:60:0.1")))
truth = http(16, close(head("GET", "/v1/views/bridge/frame.json")))
boxes = http(8, close(head(
    "GET", "/v1/views/bridge/frame.exr?layers=id&width=640&height=360")))


def message(**command):
    from pelagos_daemon import schema, varint
    data = schema().Request(**command).SerializeToString()
    return varint(len(data)) + data


async def replies(reader, meant):
    """Judges each Reply of a session; meant: codes of errors."""
    from pelagos_daemon import read_varint, schema
    pb, rest = schema(), b""
    while data := await reader.read(1 << 16):
        rest += data
        while True:
            length, used = read_varint(rest)
            if not used or len(rest) - used < length:
                break
            reply = pb.Reply.FromString(rest[used:used + length])
            rest = rest[used + length:]
            if not reply.HasField("error") or reply.error.code in meant:
                TALLY.add(0)
            else:
                TALLY.add(1 if reply.error.code == pb.BUSY else 2,
                          str(reply.error).encode())


def session(data, stays_s, meant=()):
    async def one(ports):
        reader, writer = await asyncio.open_connection("127.0.0.1",
                                                       ports["tcp"])
        try:
            writer.write(data)
            await asyncio.wait_for(replies(reader, meant), stays_s)
        except asyncio.TimeoutError:
            pass
        finally:
            writer.close()
    return one


def surface_protobuf(ports):
    one = session(message(id=1, login={"token": TOKENS["watch"]}) + message(
        id=2, surface={"points": [{"east": i % 100, "north": i // 100}
                                  for i in range(3000)]}) * 8, 1.0)
    return [again(lambda: one(ports)) for _ in range(16)]


# --- places --------------------------------------------------------------------

hls_reloads = http(150, head(
    "GET", "/v1/views/bridge/hls.m3u8?_HLS_msn=1&_HLS_part=0"))
# 0: closed, which they are for.
idle = http(300, b"GET /v1/state HTTP/1.1\r\nHost: localhost\r\n",
            meant=(0, 408))


def kinds(path, linger_s=None, least=64, height=64):
    def make(ports):
        return [again(lambda w=least + 16 * i: ask(
            ports["http"], head("GET", f"/v1/views/bridge/{path}?"
                                f"width={w}&height={height}"),
            linger_s=linger_s)) for i in range(64)]
    return make


hls_left = kinds("hls.m3u8", 0.03)
hls_left_later = kinds("hls.m3u8", 0.3)
ts_kinds = kinds("ts")
ts_large = kinds("ts", least=640, height=360)


def mjpeg(ports):
    return [again(lambda i=i: ask(ports["http"], head(
        "GET", f"/v1/views/bridge/mjpeg?quality={i + 1}"))) for i in range(64)]


def sessions(ports):
    one = session(message(id=1, login={"token": TOKENS["watch"]}) +
                  message(id=2, watch={}), 3600)
    return [again(lambda: one(ports)) for _ in range(64)]


def rtsp_client(ports, tears_down):
    basic = base64.b64encode(f"x:{TOKENS['watch']}".encode()).decode()
    url = f"rtsp://127.0.0.1:{ports['rtsp']}/bridge"

    async def one():
        reader, writer = await asyncio.open_connection("127.0.0.1",
                                                       ports["rtsp"])

        async def send(method, at, number, more=""):
            writer.write((f"{method} {at} RTSP/1.0\r\nCSeq: {number}\r\n"
                          f"Authorization: Basic {basic}\r\n{more}\r\n")
                         .encode())
            answer = await reader.readuntil(b"\r\n\r\n")
            if (length := re.search(rb"Content-Length: (\d+)", answer, re.I)):
                answer += await reader.readexactly(int(length[1]))
            judge_head(answer[:100])
            return answer
        try:
            sdp = await send("DESCRIBE", url, 1)
            control = re.findall(rb"a=control:(\S+)", sdp)
            at = control[-1].decode() if control else "stream=0"
            at = at if at.startswith("rtsp:") else f"{url}/{at}"
            setup = await send("SETUP", at, 2, "Transport: RTP/AVP/TCP;"
                               "unicast;interleaved=0-1\r\n")
            found = re.search(rb"Session: ?([^;\r]+)", setup)
            if not tears_down:
                await asyncio.sleep(3600)
            elif found:
                await send("TEARDOWN", url, 3,
                           f"Session: {found[1].decode()}\r\n")
        finally:
            writer.close()
    return one


def rtsp(ports):
    return [again(rtsp_client(ports, False)) for _ in range(64)]


def teardown(ports):
    return [again(rtsp_client(ports, True)) for _ in range(64)]


def websockets(ports):
    """Each of a rate of its own, and nothing of them is read."""
    def one(i):
        key = base64.b64encode(os.urandom(16)).decode()
        return ask(ports["http"], head(
            "GET", f"/v1/views/bridge/live?bitrate={500 + i}&credit=8",
            more="Upgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n"),
            read=False)
    return [again(lambda i=i: one(i)) for i in range(64)]


def whep_offers(ports):
    """Offers of nobody, whose answers take the daemon some work."""
    from whep_offer import OFFER
    request = close(head("POST", "/v1/views/bridge/whep",
                         body=OFFER.encode())).replace(
                             b"application/json", b"application/sdp")
    return [again(lambda: ask(ports["http"], request)) for _ in range(16)]


def whep_delete(ports):
    """Sessions of others, by guessed names."""
    return [again(lambda: ask(ports["http"], close(head(
        "DELETE", "/v1/whep/" + os.urandom(16).hex())), meant=(404,)))
        for _ in range(16)]


def tls_stalls(ports):
    """A handshake that stops within its first message, on every port; HTTP
    takes it for garbage."""
    incoming, outgoing = ssl.MemoryBIO(), ssl.MemoryBIO()
    hello = ssl.create_default_context().wrap_bio(
        incoming, outgoing, server_hostname="localhost")
    with contextlib.suppress(ssl.SSLWantReadError):
        hello.do_handshake()
    data = outgoing.read()[:120]

    async def one(port):
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        try:
            writer.write(data)
            TALLY.add(0)
            await reader.read()
        finally:
            writer.close()
    return [again(lambda p=p: one(p)) for p in
            [ports["tcp"], ports["rtsp"]] * 200 + [ports["http"]] * 100]


# --- readers that do not read, writers that do not stop --------------------------

unread = http(16, head(
    "GET", "/v1/views/bridge/frame.exr?width=2048&height=2048"), read=False)


def slow_readers(ports):
    """Every kind of answer, of which nobody reads more than the first bytes."""
    paths = ["/v1/state", "/v1/schema", "/v1/openapi.json", "/metrics",
             "/v1/spectrum?format=json", "/v1/models",
             "/v1/views/bridge/frame.png?width=1024&height=1024",
             "/v1/views/bridge/mjpeg?quality=99", "/v1/views/bridge/ts",
             "/v1/series/surface?points=0,0;10,0;20,0;30,0&"
             "sweep=time=0:60:0.1"]
    return [again(lambda p=p: ask(ports["http"], head("GET", p), read=False))
            for p in paths * 6]


def pipelining(ports):
    """Thousands of legal requests in one piece."""
    many = head("GET", "/healthz") * 2000

    async def one():
        reader, writer = await asyncio.open_connection("127.0.0.1",
                                                       ports["http"])
        try:
            writer.write(many)
            rest = b""
            while data := await asyncio.wait_for(reader.read(1 << 16), 2):
                rest = rest[-11:] + data
                for status in re.findall(rb"HTTP/1.1 (\d{3})", rest):
                    judge(int(status))
                rest = rest[-8:]
        except asyncio.TimeoutError:
            pass
        finally:
            writer.close()
    return [again(one) for _ in range(16)]


def patches(ports):
    """10,000 small edits by who may only watch."""
    request = head("PATCH", "/v1/state", body=b'{"sea":{"windSpeed":9}}')

    async def one():
        reader, writer = await asyncio.open_connection("127.0.0.1",
                                                       ports["http"])
        try:
            while True:
                writer.write(request)
                answer = await reader.readuntil(b"\r\n\r\n")
                judge_head(answer, (403,))
                length = re.search(rb"Content-Length: (\d+)", answer)
                await reader.readexactly(int(length[1]))
        finally:
            writer.close()
    return [again(one) for _ in range(16)]


def revoked(ports):
    """Sessions and streams of a token that is taken back each second
    (attacks.py does that)."""
    from pelagos_daemon import schema
    one = session(message(id=1, login={"token": SPARE}) +
                  message(id=2, watch={}), 3600,
                  (schema().UNAUTHORIZED, schema().FORBIDDEN))
    stream = head("GET", "/v1/views/bridge/mjpeg?quality=50", token=SPARE)
    return [again(lambda: ask(ports["http"], stream, meant=(401,)))
            for _ in range(32)] + [again(lambda: one(ports))
                                   for _ in range(32)]


def ice(ports):
    """Offers that name 16 addresses of others; attacks.py counts what these
    hear."""
    from whep_offer import OFFER
    offer = (OFFER + "".join(
        f"a=candidate:{i} 1 UDP {900 - i} 127.0.7.{i + 1} {ports['ice']} typ "
        "host\r\n" for i in range(16))).encode()
    request = close(head("POST", "/v1/views/bridge/whep", body=offer)).replace(
        b"application/json", b"application/sdp")
    return [again(lambda: ask(ports["http"], request)) for _ in range(4)]


# --- of an instructor's token ------------------------------------------------------

exercises = http(4, close(head("GET", "/v1/exercises", role="instruct")))
exercises_watched = http(16, close(head("GET", "/v1/exercises")),
                         meant=(403,))


def fleet(heading):
    """As many ships as the state holds beside own ship, in under 64 KiB."""
    return {str(i): {"name": f"ship {i}", "latitude": 52.6 + i * 1e-4,
                     "longitude": 5.2 - i * 1e-4, "speed": i % 20,
                     "heading": round((heading + i * 7) % 360, 3),
                     "course": round((heading + i * 7) % 360, 3)}
            for i in range(2, 257)}


def largest_patch(ports):
    """The largest legal edit of an instructor's, again and again."""
    def body():
        return json.dumps({"entities": fleet((time.time() * 7) % 360)},
                          separators=(",", ":")).encode()
    return [again(lambda: ask(ports["http"], close(
        head("PATCH", "/v1/state", role="instruct", body=body()))), 0.1)]


# By the number of what it attacks: 1 answers, 2 places, 4 exercises, 5 tokens,
# 9 checks of ICE, 10 memory, 12 what was added.
ATTACKS = [
    ("surface", f"1: 16 × surface of {POINTS:,} points, JSON", surface),
    ("surface_protobuf", "1: 16 × 8 surfaces of 3,000 points, protobuf",
     surface_protobuf),
    ("state", "1: 16 × the whole state", state),
    ("spectrum", "1: 16 × the spectrum", spectrum),
    ("series", "1: 8 series of 2,400 numbers", series),
    ("truth", "1: 16 × truth", truth),
    ("boxes", "1: 8 × ids of 640 × 360 (boxes)", boxes),
    ("largest_patch", "1: an edit of 255 entities, ten a second (instruct)",
     largest_patch),
    ("hls_reloads", "2: 150 blocking reloads of HLS", hls_reloads),
    ("hls_left", "2: 64 kinds of HLS, left after 30 ms", hls_left),
    ("hls_left_later", "2: the same, left after 300 ms", hls_left_later),
    ("ts_kinds", "2: 64 kinds of MPEG-TS that stay", ts_kinds),
    ("ts_large", "2: the same of 640 to 1,648 × 360", ts_large),
    ("mjpeg", "2: 64 qualities of Motion-JPEG", mjpeg),
    ("websockets", "2: 64 rates of WebSocket, unread", websockets),
    ("sessions", "2: 64 protobuf sessions that watch", sessions),
    ("rtsp", "2: 64 SETUPs without PLAY", rtsp),
    ("teardown", "2: 64 that SETUP and TEARDOWN at once", teardown),
    ("whep_offers", "2: 16 × an offer of WebRTC", whep_offers),
    ("idle", "2: 300 halves of requests", idle),
    ("tls_stalls", "2: 500 handshakes of TLS that stop", tls_stalls),
    ("exercises", f"4: 4 × the list of {EXERCISES} exercises of "
     f"{EXERCISE_KIB} KiB (instruct)", exercises),
    ("exercises_watched", "4, 11: 16 × the same by `watch`",
     exercises_watched),
    ("revoked", "5: 64 of a token that is taken back each second", revoked),
    ("ice", "9: 4 × an offer with 16 addresses of others", ice),
    ("unread", "10: 16 × an EXR of 2048² that nobody reads", unread),
    ("slow_readers", "10: 60 readers of every answer who do not read",
     slow_readers),
    ("pipelining", "12: 16 × 2,000 requests in one piece", pipelining),
    ("patches", "12: 16 × edits by `watch`, one after the other", patches),
    ("whep_delete", "12: 16 × DELETE of guessed WebRTC sessions",
     whep_delete),
]

def attack(make, ports):
    os.nice(19)

    async def run():
        await asyncio.gather(*make(ports))
    asyncio.run(run())
