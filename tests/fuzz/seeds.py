#!/usr/bin/python3
"""Seeds of the fuzzers whose inputs are sequences or long, the same on every
machine: seeds.py FOLDER writes FOLDER/fuzz_NAME/seed-…"""
import pathlib
import re
import struct
import sys
from json import dumps

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]
sys.dont_write_bytecode = True
import cigi_corpus  # noqa: E402
import cigi_host as cigi  # noqa: E402
import seeds_files  # noqa: E402
import seeds_more  # noqa: E402
import seeds_pictures  # noqa: E402
import seeds_readers  # noqa: E402


def step(what, data=b""):
    """As fuzz_steps.h reads it."""
    if len(data) < 255:
        return bytes([what, len(data)]) + data
    return bytes([what, 255]) + struct.pack("<H", len(data)) + data


# --- CIGI ---------------------------------------------------------------------

FEED, PACKETS, ADD, WAIT, FRAME, OPERATOR, JUMP = range(7)


def layer(number, kind, coverage, base, thickness, scope=0, visibility=9000,
          on=True):
    """A weather layer of a type of cloud, or of fog."""
    return lambda order: struct.pack(
        order + "BBHBBBBffffffffffff", 12, 56, 1, number, 50,
        on | kind % 2 << 3 | kind << 4, scope | 4, 12, visibility, 0, coverage,
        base, thickness, 0, 6, 0, 30, 1010, 0)


def more_weather():
    """What cigi_corpus.sound() has none of."""
    yield [cigi.region(1, 52.6, 5.2, 3000, 2000, 50, 20),
           cigi.weather(0, 700, 6, 30, scope=1, region=1),
           cigi.weather(4, 700, 6, 30, base=5, scope=1, region=1),
           cigi.maritime(20, 14, 1, scope=1, region=1),
           cigi.wave(1, 2, 8, 120, scope=1, region=1),
           cigi.component(7, 4, (2, 9, 100, 12), instance=1, kind=4)]
    yield [cigi.weather(layer, 5000, 9, 200, base=base)
           for layer in range(10) for base in (0, 500, 8000)]
    yield [cigi.weather(layer, 5000, 9, 200, base=3) for layer in (0, 4)]
    yield [cigi.wave(i, 1, 0 if i % 2 else 7, 30, length=60)
           for i in range(12)]
    yield [cigi.wave(i, 1, 7, 30, enable=False) for i in range(12)]
    yield [cigi.celestial(h, 5, 6, 21, 2026, valid=v, ephemeris=e)
           for h in (3, 12) for v in (True, False) for e in (True, False)]
    yield [cigi.celestial(99, 5, 66, 41, 2026)]
    yield [cigi.region(i, 52 + i, 5, 1000, 1000, state=2) for i in range(9)]
    yield [cigi.maritime(60, enable=False), cigi.maritime(5, scope=2)]
    yield [cigi.region(i, 52.6, 5.2, 1e4, 1e4, 50) for i in range(40)]
    yield [cigi.view_definition(0, -20, 20, 10, -10), cigi.entity(2, 52, 5),
           cigi.view_control(0, 1), cigi.sensor(0, 1), cigi.sensor(0, 2)]
    yield [cigi.view_control(0, 1), cigi.entity(2, 52.61, 5.2),
           *(cigi.sensor(v, i, on, track=t, extended=e) for v, i, on, t, e in (
               (0, 1, True, 3, False), (0, 2, True, 4, True),
               (0, 3, True, 1, False), (0, 2, False, 0, False),
               (9, 7, True, 3, True)))]
    yield [cigi.sensor(0, i, True, track=3) for i in range(40)]
    yield [cigi.entity(2, 9, 3, 1, parent=1), cigi.entity(3, 1, 1, parent=2),
           cigi.rate(2, 1, 2, 3, 4, 5, 6), cigi.rate(2, 1, 2, 3, local=True),
           cigi.rate(9, 1), cigi.entity(4, 52.6, 5.2, clamp=1),
           cigi.entity(5, 52.6, 5.2, clamp=2), cigi.rate(4, 400, 0, 9, 99)]
    yield [cigi.entity(3, 1, 1, parent=9), cigi.entity(7, 1, 1, parent=7),
           cigi.entity(2, 52, 5, state=2), cigi.conformal(9, 52, 5)]
    for kind in range(16):
        yield [layer(1 + kind % 4, kind, 80, 900, 100 * (kind % 3), scope=k)
               for k in range(2)]
    for visibility in (200, 900):
        yield [layer(0, 0, 100, 0, 50, visibility=visibility)] * 2
        yield [layer(0, 0, 100, 0, 50, 1, visibility), layer(4, 0, 9, 5, 30)]
    yield [layer(k, 1, 0, 0, 0, on=False) for k in range(9)]
    yield [cigi.raw(bytes([200, 8, 0, 0, 0, 0, 0, 0]))]
    yield [cigi.hat_hot(i, 52.6, 5.2, 9, 1) for i in range(300)]
    for kind in range(8):
        for ident in range(24):
            yield [cigi.component(ident, state, (1 + state, 9, 100, 12),
                                  instance=1, kind=kind)
                   for state in range(4)]


def cigi_seeds():
    whole, number = b"", 1
    groups = [*cigi_corpus.sound().items(),
              *((f"more-{i}", g) for i, g in enumerate(more_weather()))]
    inside = (step(FEED, cigi_corpus.datagram(
        [cigi.entity(1, 52.6, 5.2, 3, yaw=40)], number=1)))
    for i, (name, packets) in enumerate(groups):
        one = inside + b"".join(
            step(FEED, cigi_corpus.datagram(packets, number=2 + k,
                                            **({"stamp": 7 + k} if k else {})))
            + step(FRAME) + step(WAIT, bytes([1])) for k in range(3))
        yield name, one
        number += 1
        whole += step(FEED, cigi_corpus.datagram(packets, number=number))
        whole += step(FRAME) if i % 3 == 0 else b""
        if i % 20 == 19:  # an input has 64 steps
            yield f"all-{i}", inside + whole
            whole = b""
    silent = inside + step(WAIT, b"\2") + step(FRAME) + step(WAIT, b"\4")
    silent += step(FRAME) + step(WAIT, b"\5") + step(FRAME) + inside
    yield "silence", silent
    yield "held", bytes([140]) + silent[1:]
    yield "operator", inside + step(OPERATOR, b"\2") + silent + step(
        OPERATOR, b"\0")
    for how in range(0, 256, 8):
        yield f"control-{how}", b"".join(
            step(what, bytes([how | k])) + step(WAIT, bytes([k]))
            for k, what in enumerate((PACKETS, ADD, ADD, PACKETS))) + step(
                JUMP, b"\xf0") + step(PACKETS, bytes([how])) + step(FRAME)
    yield "batch", b"".join(step(ADD, bytes([i])) for i in range(40))
    yield "other-version", step(FEED, bytes(range(1, 40)))
    yield "cut", step(FEED, cigi_corpus.datagram(
        [cigi.entity(1, 52, 5)], number=1)[:-5])


# --- NMEA ---------------------------------------------------------------------

N_FEED, N_LINES, N_STREAM, N_WAIT, N_REMOVE = range(5)


def nmea_seeds():
    for path in sorted((HERE / "corpus/fuzz_nmea").iterdir()):
        data = path.read_bytes()[1:]
        for what in (N_FEED, N_LINES, N_STREAM):
            yield f"{path.name}-{what}", step(what, data) + step(
                N_WAIT, b"\5") + step(what, data) + step(N_WAIT, b"\10")
    own = step(N_LINES, b"$GPRMC,120000.25,A,5241.60966,N,00517.42961,E,6.00,"
               b"215.00,210626,1.4,E,A\n$HEHDT,215.0,T")
    ttm = [f"$RATTM,{n:02d},{1 + n / 10:.2f},{n * 7.0},{t},9.0,{n * 3.0},{c},"
           f"0.2,5.0,N,{name},{s},,120000,A".encode()
           for n, t, c, name, s in
           [(1, "T", "T", "", "T"), (2, "R", "R", "tug", "Q"),
            (1, "T", "T", "", "L"), (3, "T", "T", "a b", "T")]]
    tll = [f"$RATLL,{n:02d},52{41 + n}.0,N,0051{n}.0,E,{name},120000,{s},"
           .encode() for n, name, s in
           [(1, "", "T"), (9, "buoy", "T"), (9, "", "L"), (99, "x", "Q")]]
    many = b"\n".join(
        b"$RATTM,%02d,1.%02d,%d.0,T,9.0,%d.0,T,0.2,5.0,N,n%d,T,,120000,A"
        % (n, n, n * 3, n * 3, n) for n in range(1, 70))
    yield "radar", own + step(N_LINES, b"\n".join(ttm + tll)) + step(
        N_WAIT, b"\7") + step(N_REMOVE, b"\1") + step(
            N_LINES, b"\n".join(ttm)) + step(N_WAIT, b"\12") + step(
                N_WAIT, b"\12")
    yield "radar-alone", step(N_LINES, b"\n".join(ttm + tll))
    yield "many", own + step(N_LINES, many[:4000]) + step(
        N_LINES, many[4000:]) + step(N_WAIT, b"\7")
    ais = (HERE / "corpus/fuzz_nmea/ais").read_bytes()[1:]
    yield "ais-grows-old", own + step(N_LINES, ais) + step(
        N_REMOVE, b"\1") + step(N_LINES, ais) + step(
            N_LINES, ais.replace(b"13aDp", b"15aDp")) + step(
            N_WAIT, b"\11") + step(N_LINES, ais) + step(N_WAIT, b"\12") + step(
                N_REMOVE, b"\0") + own
    ships = b"\n".join(
        b"!AIVDM,1,1,,B,%c%c`kvwO005wJnb0Lfo:@7P8F05`L,0" % (t, m)
        for t in b"14" for m in b"06>")
    yield "ais-more", own + step(N_LINES, ships) + step(
        N_REMOVE, b"\2") + step(N_WAIT, b"\7") + step(N_LINES, ships) + step(
            N_WAIT, b"\12")
    yield "radar-taken-away", own + step(N_LINES, ttm[0]) + step(
        N_REMOVE, b"\1") + step(N_LINES, ttm[2])
    # What the parser's test reads.
    said = re.findall(r'"([$!][A-Z]{5}[^"*\\]*)', (
        HERE.parents[1] / "server/bridges/nmea_parse_test.c").read_text(
            encoding="utf-8"))
    for i in range(0, len(said), 20):
        yield f"said-{i}", step(N_LINES, "\n".join(
            said[i:i + 20]).encode()) + step(N_WAIT, b"\5")


# --- Modbus -------------------------------------------------------------------

M_FEED, M_PDU, M_HALF, M_WAIT, M_CLOSE = range(5)


def modbus_seeds():
    for path in sorted((HERE / "corpus/fuzz_modbus").iterdir()):
        data = path.read_bytes()
        pdus = [step(M_FEED, data[1:])]
        if data[0] % 2:
            pdus, at = [], 1
            while at < len(data):
                length = data[at] % 253 + 1
                pdus.append(step(M_PDU, data[at + 1:at + 1 + length]))
                at += 1 + length
        yield path.name, b"".join(pdus) + step(M_WAIT, b"\5") + b"".join(pdus)
    for low in range(0, 400, 20):
        yield f"read-{low}", b"".join(
            step(M_PDU, struct.pack(">BHH", code, low + n, 2 if n < 19 else 60))
            for n in range(0, 20, 2 if low else 1) for code in (1, 2, 3, 4))
        for name, words in (("small", (0, 1)), ("real", (0x41A8, 0)),
                            ("large", (0x7F80, 0)), ("minus", (0xC2B4, 3))):
            yield f"write-{name}-{low}", b"".join(
                step(M_PDU, struct.pack(">BHHBHH", 16, low + n, 2, 4, *words))
                + step(M_PDU, struct.pack(">BHH", 6, low + n, words[1]))
                for n in range(0, 20, 2)) + step(
                    M_PDU, struct.pack(">BHH", 6, 5, 1)) + step(
                    M_PDU, struct.pack(">BHH", 3, low, 20))
        yield f"coils-{low}", b"".join(
            step(M_PDU, struct.pack(">BHH", 5, low + n, v))
            for n in range(20) for v in (0xFF00, 0))
    beat = step(M_PDU, struct.pack(">BHH", 6, 4, 1))
    wind = step(M_PDU, struct.pack(">BHHBffH", 16, 10, 5, 10, 14.5, 240, 1))
    ship = (HERE / "corpus/fuzz_modbus/ship").read_bytes()
    yield "heartbeat", step(M_PDU, ship[2:2 + ship[1] % 253 + 1]) + beat + \
        step(M_WAIT, b"\3") + beat + step(M_WAIT, b"\5") + step(
            M_WAIT, b"\6") + wind + step(M_WAIT, b"\7") + beat
    yield "half", step(M_HALF, struct.pack(">BHH", 3, 0, 10)) + step(
        M_FEED, b"\0\1\0\0\0\6") + step(M_WAIT, b"\6") + step(M_CLOSE) + wind
    yield "functions", b"".join(
        step(M_PDU, bytes([code, 0, 10, 0, 2, 0, 10, 0, 2, 4, 0, 0, 0, 0]))
        for code in range(44))
    yield "units", b"".join(step(M_PDU + 128, b"\3\0\0\0\2") + step(
        M_FEED, bytes([0, 1, 0, 0, 0, 6, unit, 3, 0, 0, 0, 2]))
        for unit in (0, 2, 255))


# --- protobuf -----------------------------------------------------------------

def varint(value):
    out = b""
    while value > 127:
        out += bytes([value & 127 | 128])
        value >>= 7
    return out + bytes([value])


def field(number, data):
    return varint(number << 3 | 2) + varint(len(data)) + data


def requests():
    def request(command, data=b"", number=7):
        return b"\x08" + varint(number) + field(command, data)

    point = field(1, b"\x09" + struct.pack("<d", 12) +
                  b"\x11" + struct.pack("<d", 3))
    frame = field(1, b"bridge")
    return [request(2), request(7), request(20, field(1, b"token")),
            request(4, frame), request(10, field(1, frame) * 3),
            request(5, point), request(6, b"\x09" + struct.pack("<d", 1)),
            request(8), request(9), request(11), request(3), b"\x08\5",
            request(4, field(1, b"none")),
            request(3, field(1, field(4, b"\x09" + struct.pack("<d", 900))))]


def protobuf_seeds():
    point = field(1, b"\x09" + struct.pack("<d", 12))
    for count in (10, 400, 4000):
        request = b"\x08\1" + field(5, point * count)
        yield f"points-{count}", varint(len(request)) + request
    # Texts and values of enums that are none.
    wrong = [field(1, b"\x08\x4d")] + [
        field(6, b"\x08\1" + field(2, name))
        for name in (b"\xff\xfe", b"a\1b", b"n" * 70, b"n" * 600)]
    yield "wrong", b"".join(
        varint(len(r)) + r for r in
        (b"\x08\1" + field(3, field(1, part)) for part in wrong))
    text = b"\x08\1" + field(20, field(1, b"x" * 60000))
    yield "long-text", varint(len(text)) + text
    yield "all", b"".join(varint(len(r)) + r for r in requests())
    yield "too-long", b"\xff\xff\xff\x7f"
    yield "no-varint", b"\xff" * 9


def session_seeds():
    # OPEN, RAW, REQUEST, READ, SHUT, CLOSE, ANSWER, WAIT, CHANGED
    def on(who, what, data=b""):
        return step(9 * who + what, data)

    asked = b"".join(on(1, 2, r) for r in requests())
    yield "requests", on(1, 0) + asked + on(1, 3) + on(0, 6, b"\1\20") + on(
        0, 6, b"\0\20") + on(0, 8) + on(1, 3) + on(1, 4)
    yield "crowd", b"".join(on(i, 0) for i in range(4)) + on(
        0, 7, b"\7") + on(3, 0) + asked + on(2, 5) + on(0, 6, b"\1\377")
    yield "half-sent", on(0, 0) + on(0, 1, b"\x20\x08") + on(
        0, 7, b"\6") + on(0, 7, b"\7") + on(0, 1, b"\5")
    yield "malformed", on(0, 0) + on(0, 1, b"\xff" * 6) + on(0, 3) + on(
        0, 7, b"\5")
    get = on(1, 2, b"\x08\1\x12\0")
    yield "no-reader", on(1, 0) + get * 40 + on(0, 7, b"\7") + on(
        0, 7, b"\10") + on(0, 7, b"\11")


# --- WebSocket ----------------------------------------------------------------

def live_seeds():
    # OPEN, RAW, MESSAGE, READ, CLOSE, PICTURE, WAIT
    def on(who, what, data=b""):
        return step(7 * who + what, data)

    def message(kind, data=b""):
        return bytes([kind]) + data.ljust(15, b"\0")

    picture = on(0, 5, b"\1\7\1") + on(0, 6, b"\1")
    ack = message(1, b"\0" * 7 + b"\xff" * 4)
    for codec in (0, 64):
        yield f"acks-{codec}", on(0, 0, bytes([codec | 3])) + (
            picture + on(0, 3) + on(0, 2, ack)) * 9
        yield f"starves-{codec}", on(0, 0, bytes([codec | 1])) + on(
            1, 0, bytes([codec])) + picture * 9 + on(0, 2, ack) + on(
                0, 6, b"\4") + picture * 4
        yield f"wishes-{codec}", on(0, 0, bytes([codec])) + picture + b"".join(
            on(0, 2, message(kind, b"\30\0\0\0\5\0\0\40\0\40\0"))
            + on(0, 6, b"\3") + picture for kind in (2, 3, 4, 3, 9))
    yield "early", on(0, 0, b"\2" + b"\x82\x90\0\0\0\0" + message(2) +
                      b"\x88\x80\0\0\0\0\x82") + picture + on(0, 3)
    yield "goodbye", on(0, 0) + on(0, 1, b"\x88\x82\0\0\0\0\3\xe8") + on(
        0, 3) + on(0, 6, b"\4") + on(0, 6, b"\5")
    yield "silent", on(0, 0) + picture + on(0, 6, b"\6") * 4
    yield "fragments", on(0, 0) + on(0, 1, b"\2\x81\0\0\0\0\1") + on(
        0, 1, b"\0\x81\0\0\0\0\1" * 36) * 8
    yield "ping", on(0, 0) + on(0, 1, b"\x89\x84\0\0\0\0abcd" * 20) + on(0, 4)
    yield "text", on(0, 0) + on(0, 1, b"\x81\x81\0\0\0\0a") + on(0, 3)


# --- HTTP ---------------------------------------------------------------------

def http_seeds():
    host = "Host: localhost:8080\r\n"
    json = "Content-Type: application/json\r\n"
    places = ["/", "/healthz", "/metrics", "/v1/schema", "/v1/openapi.json",
              "/v1/fields", "/v1/state", "/v1/state/sea", "/v1/state/sea/swell",
              "/v1/state/clock/mode", "/v1/state/entities/1/name",
              "/v1/state/nothing", "/v1/state/sky/sunElevation",
              "/v1/views", "/v1/views/bridge", "/v1/views/none",
              "/v1/views/bridge/frame.jpg?width=64&height=48&quality=50",
              "/v1/views/bridge/frame.exr?layers=radiance,depth&float=1&time=3",
              "/v1/views/bridge/frame.gif", "/v1/views/bridge/frame.png?a=b",
              "/v1/frames.jpg?views=bridge", "/v1/frames.exr?views=*",
              "/v1/views/bridge/mjpeg?fps=5&quality=70",
              "/v1/views/bridge/ts?bitrate=900", "/v1/spectrum", "/v1/models",
              "/v1/optics/water", "/v1/optics/sky?sun=3", "/app.js", "/x?y=1",
              "/v1/views/bridge/live?codec=h264&credit=3", "/a/b/c/d/e/f/g/h/i",
              "/%41%2fb%zz", "/v1/state?x", "//", "/v1/fields?a=1&a=2"]
    everything = [f"{method} {place} HTTP/1.1\r\n{host}\r\n"
                  for place in places
                  for method in ("GET", "HEAD", "DELETE", "POST")]
    for i in range(0, len(everything), 16):
        yield f"places-{i}", "\1".join(everything[i:i + 16])
        yield f"strangers-{i}", "#ts\n" + "\1".join(everything[i:i + 16])
    bodies = [("PATCH", "/v1/state", '{"sky":{"visibility":3000}}'),
              ("PATCH", "/v1/state", '{"sky":{"visibility":-1}}'),
              ("PATCH", "/v1/state", '{"nothing":1}'),
              ("PATCH", "/v1/state", '{"views":{"b":{"entity":1}}}'),
              ("PUT", "/v1/views/bow", '{"entity":1,"yaw":9}'),
              ("PUT", "/v1/views/bow", '{"name":"other"}'),
              ("PUT", "/v1/views/bow", 'no json'),
              ("POST", "/v1/clock/step", '{"seconds":1}'),
              ("PATCH", "/v1/state", '{"clock":{"mode":"STEPPED"}}'),
              ("POST", "/v1/clock/step", '{"seconds":1}'),
              ("POST", "/v1/clock/step", ""),
              ("POST", "/v1/clock/step", '{"x":1}'),
              ("POST", "/v1/surface", '{"points":[{"east":1,"north":2}]}'),
              ("POST", "/v1/surface", '{"points":3}'),
              ("POST", "/v1/spectrum", '{"frequencies":8}'),
              ("POST", "/v1/optics", '{"sky":{"elevation":3}}'),
              ("DELETE", "/v1/views/bow", "")]
    heads = ["", 'If-Match: "1"\r\n', 'If-Match: W/"1", "2", *\r\n',
             "Transfer-Encoding: chunked\r\n", "Origin: http://localhost:8080\r\n",
             "Content-Length: 99999999\r\n", "Authorization: Bearer "
             "0123456789abcdef\r\n", "Authorization: Basic eDp5\r\n"]
    for i, head in enumerate(heads):
        yield f"bodies-{i}", ("#t\n" if i >= 6 else "") + "\1".join(
            f"{m} {p} HTTP/1.1\r\n{host}{json}{head}\r\n{b}"
            for m, p, b in bodies)
    one = [f"GET {p} HTTP/1.1\r\n{h}\r\n"
           for p in ("/v1/views/bridge/frame.jpg", "/v1/state")
           for h in (
               "", host + host, "Host: [::1]:80\r\n", "Host: [::1\r\n",
               "Host: evil.example\r\n", "Host: Sea.Example:443\r\n",
               "Host: 127.0.0.1:80x\r\n", host + "Origin: null\r\n",
               host + "Origin: https://other.example\r\n",
               host + "Origin: ftp://x\r\n",
               host + "Referer: https://other.example/page\r\n"
               "Sec-Fetch-Site: cross-site\r\n",
               host + "Sec-Fetch-Site: same-site\r\n",
               host + "Transfer-Encoding: gzip\r\n",
               host + "Content-Length: 3\r\nTransfer-Encoding: chunked\r\n",
               host + "Content-Length: -3\r\n", host + "Bad Name: x\r\n",
               host + 'If-None-Match: W/"1", "2"\r\n')]
    for i in range(0, len(one), 16):
        yield f"heads-{i}", "#ho\n" + "\1".join(one[i:i + 16])
        yield f"heads-closed-{i}", "#t\n" + "\1".join(one[i:i + 16])
    live = ("GET /v1/views/bridge/live{} HTTP/1.1\r\n" + host +
            "Upgrade: websocket\r\nConnection: keep-alive, Upgrade\r\n"
            "Sec-WebSocket-Version: {}\r\nSec-WebSocket-Key: {}\r\n{}\r\n")
    key = "dGhlIHNhbXBsZSBub25jZQ=="
    yield "live", "\1".join(
        [live.format(q, v, k, m) for q, v, k, m in (
            ("", 13, key, ""), ("?credit=99", 13, key, ""),
            ("?codec=jpeg&quality=5&width=64&height=48", 13, key, ""),
            ("?codec=h264&bitrate=500&credit=2", 13, key,
             "Sec-WebSocket-Protocol: pelagos, bearer.0123456789abcdef\r\n"),
            ("?codec=x", 13, key, ""), ("?nothing=1", 13, key, ""),
            ("", 8, key, ""), ("", 13, "x", ""))])
    yield "types", "\1".join(
        f"PATCH /v1/state HTTP/1.1\r\n{host}Content-Type: {t}\r\n\r\n{{}}"
        for t in ("application/merge-patch+json; charset=\"utf-8\"",
                  "APPLICATION/JSON;charset=utf-8", "text/plain",
                  "application/json; charset=latin1", ""))
    yield "page-kept", "\1".join(
        f"GET /app.js HTTP/1.1\r\n{host}If-None-Match: {t}\r\n\r\n"
        for t in ("*", '"x"', "x", 'W/"y'))


# --- paths --------------------------------------------------------------------

def path_seeds():
    paths = ["sea.windSpeed", "sea.swell.0.height", "sea.swell.2.height",
             "sea.swell.9.height", "sea.swell.x", "view.bridge.yaw",
             "views.bow.entity", "entity.1.heading", "entities.new.speed",
             "entities.tug.speed", "entities.7.name", "entities.99.speed",
             "clock.mode", "clock.rate.x", "clock", "sky.haze", "nothing",
             "sea.swell", "entities", "entities.1", "views.bridge",
             "views.bridge.name", "entities.1.id", "sea.seed",
             "entities.1.model.name", "entities.7.wake.on", "sky.clouds.0.cover",
             "sea.areas.0.points.0.east", "..", "views..x",
             "views." + "n" * 70 + ".yaw", "a." * 200,
             "entities.1.afloat", "sky.sunElevation"]
    values = ["1", "-1", "true", "false", "null", "JONSWAP", "FREE", "1e99",
              "nan", "text", "\xff", "3.5", "", "99999999999999999999"]
    yield "read", "*\n" + "\n".join(paths)
    yield "remove", "\n".join("-" + p for p in paths)
    for i, value in enumerate(values):
        yield f"set-{i}", "\n".join(f"{p}={value}" for p in paths)
        yield f"number-{i}", "\n".join(f"?{p}={value}" for p in paths)
    yield "longest", "=".join(["entities." + "9" * 4000, "null"])


# --- the rest -----------------------------------------------------------------

def rtsp_seeds():
    options = "OPTIONS * RTSP/1.0\r\nCSeq: 1\r\n"
    for i, text in enumerate((
            options + "\r\n", options + "Content-Length: 3\r\n\r\nabc",
            options + "Session: 12345678;timeout=60\r\n\r\n",
            options + "Session: 87654321\r\n\r\n",
            "$\1\0\4abcd" + options + "\r\n", "GET / HTTP/1.0\r\n\r\n",
            options + "Content-Length: 99999999999\r\n\r\n",
            options + "X: y\r\n z\r\n\r\n")):
        yield f"{i}", "\7" + text


def metar_seeds():
    for i, text in enumerate((
            "METAR EHAM 211225Z 24015G28KT 200V280 9999 -SHRA FEW012 SCT020CB "
            "BKN040 12/08 Q1009 NOSIG", "KSFO 211256Z 28012KT 1 1/2SM R28L/2400FT "
            "BR OVC004 11/10 A3002 RMK AO2", "EGLL 210020Z AUTO VRB02KT CAVOK "
            "M02/M05 Q1032=", "SPECI LFPG 211230Z 00000MPS 0350 FG VV001 03/03 "
            "Q0998 W12/S4", "EDDF 211220Z 36010KT 350V020 4000NE 6000 +TSRAGR "
            "///015 //////CB 21/18 Q1011 RERA WS R25")):
        yield f"{i}", text


# --- cameras ------------------------------------------------------------------

def camera_seeds():
    here = {"latitude": 52.7, "longitude": 5.1}
    pole, far = {"latitude": 90, "longitude": 7}, {"latitude": -33,
                                                   "longitude": 179.9}
    ways = [dict(p, time=t, height=h, heading=c) for p, t, h, c in (
        (here, 50, 10, 350), (here, 99, 1e3, 10), (far, 101, 4e5, -170),
        (pole, 1e6, -5, 90))]
    places = [{"at": here}, {"at": dict(far, height=1e7)}, {"at": pole},
              {"at": {"latitude": 3}}, {"orbit": here}, {"orbit": {"entity": 1}},
              {"orbit": dict(pole, radius=1e7, elevation=90, period=-60)},
              {"orbit": {"entity": 9}}, {"orbit": dict(here, period=0)},
              {"orbit": dict(here, entity=1)}, {"orbit": {}},
              {"satellite": {}}, {"satellite": {"inclination": 180, "node": 9,
                                                "period": 60, "phase": -3}},
              {"waypoints": ways}, {"waypoints": ways[:1]},
              {"waypoints": ways[::-1]}, {"waypoints": [{"time": 3}]},
              {"waypoints": ways * 17}, {"entity": 1}, {"entity": 1, "at": here},
              {"satellite": {}, "waypoints": ways}]
    looks = [None, here, {"entity": 1, "height": 5}, {"entity": 9},
             dict(here, entity=1), {"height": 3}, dict(far, height=-1e4)]
    for i, place in enumerate(places):
        for k, look in enumerate(looks if i != 19 else looks[:1]):
            view = dict(place, yaw=i, **({"lookAt": look} if look else {}))
            yield f"camera-{i}-{k}", dumps({"views": {"bridge": dict(
                {"entity": None}, **view)}})
    yield "meters", dumps({"views": {
        f"m{i}": dict(places[i], meter="same") for i in (0, 1, 4, 11, 13)}})
    yield "moved", dumps({
        "origin": {"latitude": -89.9, "longitude": 0},
        "views": {f"m{i}": places[i] for i in (0, 1, 2, 4, 6, 12, 13)}})


SEEDS = [("cigi", cigi_seeds), ("nmea", nmea_seeds), ("modbus", modbus_seeds),
         ("protobuf", protobuf_seeds), ("session", session_seeds),
         ("live", live_seeds), ("http", http_seeds), ("path", path_seeds),
         ("rtsp", rtsp_seeds), ("metar", metar_seeds), ("json", camera_seeds),
         *seeds_files.SEEDS, *seeds_more.SEEDS, *seeds_pictures.SEEDS,
         *seeds_readers.SEEDS]


def main():
    for name, seeds in SEEDS:
        folder = pathlib.Path(sys.argv[1]) / f"fuzz_{name}"
        folder.mkdir(parents=True, exist_ok=True)
        for title, data in seeds():
            if isinstance(data, str):
                data = data.encode("utf-8", "surrogateescape")
            (folder / f"seed-{title}").write_bytes(data)


if __name__ == "__main__":
    main()
