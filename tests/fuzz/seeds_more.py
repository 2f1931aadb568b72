"""More seeds for seeds.py: AIS, JSON, logs, tables of consoles, views."""
import struct
from json import dumps


def step(what, data=b""):
    """As fuzz_steps.h reads it."""
    if len(data) < 255:
        return bytes([what, len(data)]) + data
    return bytes([what, 255]) + struct.pack("<H", len(data)) + data


# --- AIS ----------------------------------------------------------------------

N_LINES, N_WAIT, N_REMOVE = 1, 3, 4


def sixes(text, count):
    """Text in AIS's six bits a letter."""
    out = 0
    for c in text.ljust(count, "@"):
        out = out << 6 | ord(c) & 63
    return out, 6 * count


def ais(*fields):
    """Sentences of a message: each field (value, bits)."""
    bits = "".join(format(v & ((1 << n) - 1), f"0{n}b") for v, n in fields)
    fill = -len(bits) % 6
    bits += "0" * fill
    letters = [int(bits[i:i + 6], 2) for i in range(0, len(bits), 6)]
    text = "".join(chr(v + 48 if v < 40 else v + 56) for v in letters)
    parts = [text[i:i + 56] for i in range(0, len(text), 56)]
    return "\n".join(
        f"!AIVDM,{len(parts)},{k + 1},{3 if len(parts) > 1 else ''},A,{p},"
        f"{fill if k + 1 == len(parts) else 0}" for k, p in enumerate(parts))


def place(lat, lon):
    return (round(lon * 600000), 28), (round(lat * 600000), 27)


def ais_position(mmsi, lat=52.7, lon=5.2, kind=1, speed=60, heading=40):
    return ais((kind, 6), (0, 2), (mmsi, 30), (0, 4), (0, 8), (speed, 10),
               (1, 1), *place(lat, lon), (400, 12), (heading, 9), (10, 6),
               (0, 2), (0, 3), (0, 1), (0, 19))


def ais_static(mmsi, name="SHIP", kind=70, sides=(60, 20, 8, 8), draught=50):
    return ais((5, 6), (0, 2), (mmsi, 30), (0, 2), (0, 30), sixes("CALL", 7),
               sixes(name, 20), (kind, 8), (sides[0], 9), (sides[1], 9),
               (sides[2], 6), (sides[3], 6), (1, 4), (0, 20), (draught, 8),
               sixes("", 20), (0, 1), (0, 1))


def ais_aid(mmsi, name, kind=9, virtual=0):
    return ais((21, 6), (0, 2), (mmsi, 30), (kind, 5), sixes(name, 20), (0, 1),
               *place(52.65, 5.25), (2, 9), (2, 9), (1, 6), (1, 6), (1, 4),
               (10, 6), (0, 1), (0, 8), (0, 1), (virtual, 1), (0, 1), (0, 1))


def ais_far(mmsi, lat=52.7, lon=5.2):
    return ais((27, 6), (0, 2), (mmsi, 30), (0, 1), (0, 1), (0, 4),
               (round(lon * 600), 18), (round(lat * 600), 17), (6, 6), (40, 9),
               (0, 1), (0, 1))


def ais_class_b(mmsi, part, name="SMALL"):
    if part == 0:
        return ais((24, 6), (0, 2), (mmsi, 30), (0, 2), sixes(name, 20))
    return ais((24, 6), (0, 2), (mmsi, 30), (1, 2), (36, 8), sixes("V", 7),
               sixes("CALL", 7), (6, 9), (4, 9), (2, 6), (2, 6), (0, 6))


def nmea_seeds():
    own = step(N_LINES, b"$GPRMC,120000.25,A,5241.60966,N,00517.42961,E,6.00,"
               b"215.00,210626,1.4,E,A\n$HEHDT,215.0,T")

    def said(*lines):
        return step(N_LINES, "\n".join(lines).encode())

    wait, long, hour = (step(N_WAIT, bytes([k])) for k in (5, 8, 10))
    one = said(ais_position(244000001)) + wait
    yield "ais-named", own + said(ais_static(244000001)) + one + said(
        ais_static(244000001, "OTHER", sides=(100, 20, 9, 9))) + wait + one
    yield "ais-shapes", own + one + said(
        *(ais_static(244000001, kind=k) for k in (30, 60, 70, 80, 0))
    ) + wait + said(ais_static(244000001, sides=(0, 0, 0, 0))) + wait + one
    yield "ais-renamed", own + one + said(ais_static(244000001)) + wait + step(
        N_REMOVE, b"\1") + said(ais_static(244000001, "LATER")) + wait + one
    yield "aids", own + said(ais_aid(992440001, "BUOY"), ais_aid(
        992440001, "BUOY 2", 14), ais_aid(992440002, "V", 3, 1)) + wait
    yield "class-b", own + said(
        ais_class_b(244000009, 0), ais_class_b(244000009, 1),
        ais_position(244000009, kind=18)) + wait + said(
            ais_class_b(244000009, 0, "X"), ais_class_b(244000009, 1)) + wait
    yield "far", own + said(ais_far(244000001)) + wait + one + said(
        ais_far(244000001, 52.9)) + long + said(ais_far(244000001, 52.8)) + wait
    yield "nowhere", own + said(ais_position(244000001, 91, 181)) + one + said(
        ais_position(244000001, 91, 181)) + wait
    crowd = [ais_position(244000100 + i, 52.6 + i / 400) for i in range(80)]
    yield "crowd", own + b"".join(said(*crowd[i:i + 20]) + wait
                                  for i in range(0, 80, 20)) + hour + said(
        *(ais_position(244000300 + i, 52.9) for i in range(9))) + wait
    yield "crowd-names", own + said(*(
        ais_static(244000500 + i, f"N{i}") for i in range(20))) * 8 + wait
    yield "crowd-nobody", b"".join(said(*crowd[i:i + 20]) + wait
                                   for i in range(0, 80, 20))


# --- JSON ---------------------------------------------------------------------

def json_seeds():
    texts = ["", "{", "[", "{]", "[1,]", '{"a"}', '{"a":}', '{"a" 1}', "{a:1}",
             '{"sea":{"windSpeed":01}}', '{"sea":{"windSpeed":1.}}',
             '{"sea":{"windSpeed":1e}}', '{"sea":{"windSpeed":1e+3}}',
             '{"sea":{"windSpeed":-}}', '{"sea":{"windSpeed":"x"}}',
             '{"sea":{"windSpeed":true}}', '{"sea":{"windSpeed":[]}}',
             '{"sea":{"windSpeed":{}}}', '{"sea":{"windSpeed":null}}',
             '{"sea":3}', '{"sea":[]}', '{"sea":null}', '{"nothing":1}',
             '{"sea":{"windSpeed":1},"sea":{}}', '{"views":3}', '{"views":[3]}',
             '{"views":{"b":3}}', '{"views":{"b":null}}', '{"views":{"":{}}}',
             '{"views":{"b":{"name":"c"}}}', '{"views":[{"name":"b"}]}',
             '{"entities":{"x":{}}}', '{"entities":{"1":{"id":2}}}',
             '{"entities":{"1":null,"70000":null}}', '{"entities":[null]}',
             '{"sky":{"visibility":-1}}', '{"clock":{"mode":"NONE"}}',
             '{"clock":{"mode":3}}', '{"clock":{"rate":1e999}}', "\n\n  {x",
             '{"entities":{"1":{"name":"\\u00e9\\ud83d\\ude00\\n\\/\\""}}}',
             *('{"entities":{"1":{"name":"%s"}}}' % t for t in (
                 "\\u12", "\\ud800", "\\ud800\\u0041", "\\x", "\\", "\1",
                 "\\u0000", "\\udc00", "\udcff", "n" * 200)),
             '{"sky":{"metar":"EHAM 211225Z 24015KT 9999 FEW012 12/08 Q1009"}}',
             '{"a":' + "[" * 200, '{"sea":' * 200, "[]", "3", "true", "nul",
             '{"clock":{"running":true}}', '{"clock":{"mode":tru}}',
             '{"water":{"depth":9}} x', '{"views":{%s}}' % ",".join(
                 f'"v{i}":{{"entity":1}}' for i in range(70)),
             '{"views":{%s}}' % ",".join(f'"v{i}":null' for i in range(300)),
             '{"entities":{%s}}' % ",".join(
                 f'"{i}":{{"speed":1}}' for i in range(300))]
    for i, text in enumerate(texts):
        yield f"text-{i}", text
    yield "long", '{"sea":{}}' + " " * 70000
    parts = {
        "light": {"on": True, "sectors": [{"from": 10, "to": 90}]},
        "searchlight": {"on": True}, "signal": {}, "helm": {"on": True},
        "model": {"name": "ferry"}, "wake": {"on": True},
        "track": {"points": [{"time": 1, "latitude": 52, "longitude": 5}]}}
    for name, part in parts.items():
        yield f"entity-{name}", dumps({"entities": {"1": {name: part}}})
    yield "sea", dumps({"sea": {
        "swell": [{"height": 1, "period": 9}], "wave": [{"amplitude": 1}],
        "areas": [{"corners": "0 0, 100 0, 100 100"}],
        "field": {"file": "x.nc"}, "beaufort": 4}})
    yield "lists", dumps({"sea": {"swell": {"0": {"height": 2}}},
                          "sky": {"fog": [{"corners": "0 0, 9 0, 9 9"}],
                                  "clouds": [{"cover": 0.5}, [0.3], []]}})
    yield "views", dumps({"views": {"r": {"radar": {"range": 3000}},
                                    "s": {"sensor": {"noise": 1}}}})
    for lat in (52.61, 89, -89.5):
        yield f"origin-{lat}", dumps({
            "clock": {"time": 50},
            "origin": {"latitude": lat, "longitude": -120},
            "entities": {"1": {"latitude": lat, "longitude": -120, "speed": 9,
                               "turnRate": 3, "heading": 350}}})
    yield "moves", dumps({"clock": {"time": 50, "reckoning": 1000}, "entities": {
        "1": {"latitude": 88, "longitude": 5, "speed": 200, "turnRate": -9}}})


# --- logs ---------------------------------------------------------------------

def varint(value):
    out = b""
    while value > 127:
        out += bytes([value & 127 | 128])
        value >>= 7
    return out + bytes([value])


def field(number, data):
    return varint(number << 3 | 2) + varint(len(data)) + data


def double(number, value):
    return varint(number << 3 | 1) + struct.pack("<d", value)


def entry(*parts):
    data = b"".join(parts)
    return varint(len(data)) + data


def log_seeds():
    clock = field(1, double(1, 1))
    head = entry(double(1, 1), b"\x10\1",
                 field(3, b"\x08\1\x12\1p" + field(4, clock)))
    magic = b"\0PELOG1\r\n"
    heads = {"newer": field(3, b"\x08\x63"), "none": field(4, b""),
             "stateless": field(3, b"\x08\1"), "old": field(3, b"\x08\0"),
             "empty": b""}
    for name, part in heads.items():
        yield f"head-{name}", b"\1" + entry(double(1, 1), part)
    after = {"no-command": entry(double(1, 2)), "second-head": head,
             "timeless": entry(field(4, b"")),
             "back": entry(double(1, 0.5), field(4, b"")),
             "nan": entry(double(1, float("nan")), field(4, b"")),
             "other-step": entry(double(1, 2), field(5, double(1, 3))),
             "step": entry(double(1, 2), field(5, double(1, 2))),
             "no-entry": entry(b"\xff\xff"), "torn": b"\x40\1",
             "long": b"\xff\xff\xff\x7f", "no-length": b"\xff" * 10,
             "clock": entry(double(1, 2), field(4, field(2, b"clock.time"))) +
             entry(double(1, 0), field(4, field(1, clock)))}
    for start, name in ((b"\1" + head, "session"),):
        for what, data in after.items():
            yield f"{name}-{what}", start + data
    yield "newer-magic", magic.replace(b"1\r", b"9\r") + head
    yield "no-magic", b"\0PELOG"
    yield "other-magic", b"\0" + b"x" * 20


# --- tables of consoles -------------------------------------------------------

def console_seeds():
    row = "holding 5 f32 sea.windSpeed"
    rows = [row + " " + more for more in (
        "order=abcd", "order=x", "unit=3", "unit=256", "unit=x", "unit=",
        "scale", "scale=x", "what=1", "min=3 max=1", "deadband=-1", "stale=x",
        "order=badc unit=7 scale=2 offset=1 min=0 max=9 deadband=1 stale=3")]
    rows += ["holding 5 bit sea.windSpeed", "coil 5 f32 sea.windSpeed", "x",
             "input 65535 f64 sea.windSpeed", "holding", "tape 5 f32 sea.gamma",
             "holding x f32 sea.gamma", "holding 70000 u16 sea.gamma",
             "holding 5 f16 sea.gamma", "holding 5 f32 nothing",
             "holding 5 f32 clock.mode", row + "\n" + row, "# nothing", "",
             row + " #", "\t" + row + "\r", row + " " + "x" * 300,
             row + "\n".join([""] + [f"input {i} i16 entities.{i}.speed unit="
                                     f"{i % 3}" for i in range(1, 40)]),
             "\n".join(f"coil {i} bit entities.{i}.heading"
                       for i in range(300)),
             "\n".join(f"{space} {9 * k} {kind} entities.{k + 1}.heading"
                       for k, (space, kind) in enumerate(
                           [("holding", "u32"), ("holding", "i32"),
                            ("input", "f64"), ("discrete", "bit")]))]
    for i, text in enumerate(rows):
        yield f"row-{i}", "\0" + text
    # The four rows' groups: one coil group, two of registers.
    for name, data in (
            ("words", b"\0\1\0\0\0\x0b\1\3\x08" + struct.pack(">fhh", 3, 0, 7)),
            ("short", b"\0\1\0\0\0\7\1\3\4" + struct.pack(">f", 3)),
            ("word", b"\0\1\0\0\0\5\1\3\2\0\7"),
            ("three", b"\0\1\0\0\0\x09\1\3\6" + struct.pack(">fh", 3, 7)),
            ("cut", b"\0\1\0\0\0\x09\1\3\6\0"), ("tiny", b"\0\1"),
            ("bits", b"\0\1\0\0\0\4\1\1\1\3"),
            ("refused", b"\0\1\0\0\0\3\1\x83\2"),
            ("refused-bits", b"\0\1\0\0\0\3\1\x81\2")):
        yield f"answer-{name}", b"\1" + data


# --- views over HTTP ----------------------------------------------------------

def http_seeds():
    host = "Host: localhost:8080\r\n"
    json = "Content-Type: application/json\r\n"

    def ask(method, path, body=""):
        return f"{method} {path} HTTP/1.1\r\n{host}{json}\r\n{body}"

    yield "views", "\1".join([
        ask("PUT", "/v1/views/bridge", '{"entity":1,"yaw":9}'),
        ask("PUT", "/v1/views/bow", '{"entity":1}'),
        ask("PUT", "/v1/views/bow", '{"entity":99}'),
        ask("DELETE", "/v1/views/bow"), ask("DELETE", "/v1/views/bow"),
        ask("DELETE", "/v1/views/b.w"),
        *(ask("GET", "/v1/views/bridge/frame.exr?" + q) for q in (
            "layers=nothing", "float=2", "float=1", "time=x", "width=-1")),
        *(ask("GET", "/v1/views/bridge/mjpeg?" + q) for q in (
            "fps=x", "fps=0", "size=1", "fps=1&quality=900"))])
    yield "views-none", "\1".join(
        ask("GET", "/v1/views/none/" + what) for what in (
            "frame.png", "mjpeg", "ts", "live", "hls.m3u8", "frame.exr"))
    yield "hls", "\1".join(
        ask("GET", "/v1/views/bridge/hls.m3u8" + q) for q in (
            "", "?_HLS_msn=3", "?_HLS_msn=3&_HLS_part=1", "?_HLS_part=1",
            "?_HLS_msn=x", "?bitrate=900&width=64&height=48", "?bitrate=x",
            "?_HLS_msn=99999999999999999999", "?what=1")) + "\1" + "\1".join(
        ask("GET", "/v1/hls/" + f) for f in ("00000000-1.ts", "x", "../x"))
    yield "presets", "\1".join([
        ask("PUT", "/v1/presets/calm", dumps({
            "title": "x", "patch": dumps({"sky": {"rain": 1}})})),
        ask("PUT", "/v1/presets/calm", '{"name":"calm","patch":"{}"}'),
        ask("PUT", "/v1/presets/wrong", '{"patch":"{"}'),
        ask("PUT", "/v1/presets/calm", '{"name":"other"}'),
        ask("PUT", "/v1/presets/calm", "{}"), ask("GET", "/v1/presets"),
        ask("PUT", "/v1/presets/a.b", "{}"), ask("PUT", "/v1/presets/c", "x"),
        ask("POST", "/v1/presets/calm"), ask("POST", "/v1/presets/none"),
        ask("POST", "/v1/presets/calm", '{"x":1}'),
        ask("GET", "/v1/presets/calm"), ask("GET", "/v1/presets/none"),
        ask("DELETE", "/v1/presets/calm"), ask("DELETE", "/v1/presets/calm")])
    live = ("GET /v1/views/bridge/live HTTP/1.1\r\n" + host + "Upgrade: websocket"
            "\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket"
            "-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: {}\r\n\r\n")
    yield "live-token", "#t\n" + "\1".join(live.format(p) for p in (
        "pelagos, bearer.0123456789abcdef", "bearer.", "bearer.x, , y"))
    patches = [{"presets": [{"name": n, "patch": p}]} for n, p in (
        ("a b", "{}"), ("a", '{"presets":{}}'), ("a", '{"x":1}'),
        ("a", '{"sky":{"rain":"x"}}'), ("a", "{}" + " " * 5000))]
    patches += [{"presets": [{"name": "a", "patch": "{}"}] * 2},
                {"presets": [{"patch": "{}"}]}, {"presets": [{"name": "a"}]},
                {"presets": [{"name": f"p{k}", "patch": "{}"}
                             for k in range(99)]}, {"presets": {"a": None}}]
    yield "presets-state", "\1".join(ask("PATCH", "/v1/state", dumps(p))
                                     for p in patches)
    queries = {
        "optics/sky": ("elevation=3", "sky.sunElevation=20&from=bridge",
                       "time=x", "nothing=1", "sky.x=1", "elevation=x"),
        "optics/water": ("",), "optics/nothing": ("",), "optics/from": ("",),
        "almanac": ("", "latitude=3&longitude=5", "latitude=300", "x=1",
                    "latitude=x"),
        "spectrum": ("", "format=ww3", "format=x", "sea.windSpeed=9",
                     "sea.x=9", "x=1", "frequencies=8"),
        "series/sky": ("sweep=elevation=0:90:5", "sweep=x", "format=csv",
                       "sweep=elevation=0:90:5&from=x", "format=x",
                       "sweep=sky.sunElevation=0:90:5&sky.haze=1"),
        "series/surface": ("points=1,2,3,4", "points=1", "points=x", "x=1",
                           "points=0,0&sweep=time=0:10:1&format=netcdf"),
        "series/spectrum": ("sweep=sea.windSpeed=1:20:1", "sea.windSpeed=9"),
        "series/nothing": ("",), "series/brdf": ("sweep=a=0:1:1:1:1",),
        "frames.exr": ("", "views=bridge,bow&layers=depth", "views=&time=3",
                       "views=" + ",".join("v" * 9 for _ in range(70)), "x=1"),
        "exercise.csv": ("", "ship=1", "ship=x", "x=1")}
    for name, several in queries.items():
        yield "query-" + name.replace("/", "-"), "\1".join(
            ask("GET", f"/v1/{name}?{q}") for q in several)
    sweep = {"over": "elevation", "first": 0, "last": 90, "step": 30}
    wind, list_ = dict(sweep, over="sea.windSpeed"), {"values": [1, 2, 3]}
    axes = [[sweep], [sweep] * 5, [sweep, sweep], [{"over": "elevation"}],
            [dict(sweep, step=-1)], [dict(sweep, step=1e-7)], [wind], [{}],
            [dict(list_, over="windSpeed")], [dict(list_, over="nothing")],
            [dict(list_, over="sky.nothing")], [dict(list_, over="from")],
            [dict(sweep, step=.01), dict(wind, step=.01)], [dict(
                list_, over="wavelength")], [dict(list_, over="time")],
            [dict(list_, over="clock.mode")], [dict(sweep, over="entities.1."
                                                    "speed")]]
    questions = [{"optics": {"sky": {}}}, {"spectrum": {}}, {
        "surface": {"points": [{"east": 0, "north": 0}]}}, {"optics": {
            "water": {"wavelengthLast": 700}}}, {"surface": {}}, {"optics": {}},
        {"spectrum": {"format": "WW3"}}]
    for i, question in enumerate(questions):
        for k in range(0, len(axes), 12):
            yield f"series-{i}-{k}", "\1".join(
                ask("POST", "/v1/series", dumps(dict(question, sweep=a)))
                for a in axes[k:k + 12])
    series = [{}, {"what": "x"}, {"optics": {"sky": {}}, "sweep": [sweep]},
              {"surface": {"points": [{"east": 0, "north": 0}]}, "sweep": [
                  dict(sweep, over="time")]}, {"spectrum": {}, "format": "CSV"},
              {"optics": {"water": {}}, "sweep": [sweep] * 5},
              {"optics": {"brdf": {}}, "sweep": [dict(sweep, over="x")]}]
    yield "series", "\1".join(
        [ask("POST", "/v1/series", dumps(s)) for s in series] +
        [ask("POST", "/v1/series?x=1", "{}"), ask("POST", "/v1/series", "x"),
         ask("POST", "/v1/series?format=csv", dumps(series[2])),
         ask("POST", "/v1/optics", '{"water":{}}'), ask("POST", "/v1/optics", "x")])
    drill = dumps({"state": {"entities": [{"id": 1}]}, "events": [{"name": "a", "when": [{"at": 1}], "patch": {
        "state": {"sky": {"rain": 1}}}}]})
    for letters in ("#e\n", ""):
        yield "exercises" + letters[1:2], letters + "\1".join([
            ask("GET", "/v1/exercise"), ask("PUT", "/v1/exercises/d", drill),
            ask("PUT", "/v1/exercises/x", "{"), ask("GET", "/v1/exercises"),
            ask("PUT", "/v1/exercises/x", '{"events":[{}]}'),
            ask("GET", "/v1/exercises/d"), ask("GET", "/v1/exercises/none"),
            ask("POST", "/v1/exercise", '{"action":"LOAD","name":"d"}'),
            ask("POST", "/v1/exercise", '{"action":"START"}'),
            ask("GET", "/v1/exercise.csv?ship=1"), ask("GET", "/v1/exercise.csv"),
            ask("POST", "/v1/exercise", '{"x":1}'), ask("GET", "/v1/exercise"),
            ask("POST", "/v1/exercise", '{"action":"STOP"}'),
            ask("DELETE", "/v1/exercises/d"), ask("DELETE", "/v1/exercises/d")])
    yield "debrief", "\1".join([
        ask("GET", "/v1/recordings"), ask("GET", "/v1/debrief"), ask(
            "POST", "/v1/recording", "{}"), ask("PATCH", "/v1/debrief", "{}"),
        ask("GET", "/v1/debrief/state"), ask("GET", "/v1/cluster")])


# --- descriptions of models ----------------------------------------------------

def model_seeds():
    eye, lamp = {"name": "e", "up": 9}, {"name": "l", "colour": 255, "range": 3}
    for i, more in enumerate((
            {}, {"eyes": [eye] * 17}, {"lights": [lamp] * 65}, {"beam": 0},
            {"bow": "X", "up": "MINUS_X"}, {"scale": 2, "beam": 9, "height": 9},
            {"eyes": [{}], "lights": [{}]}, {"class": "NONE"}, {"x": 1})):
        yield f"described-{i}", dumps(more)


SEEDS = [("model", model_seeds), ("nmea", nmea_seeds), ("json", json_seeds), ("log", log_seeds),
         ("console", console_seeds), ("http", http_seeds)]
