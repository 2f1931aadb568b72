"""Seeds of the fuzzers of files: exercises, and what the readers of files from
people read and hand over. For seeds.py."""
import struct
from json import dumps


# --- coastlines ---------------------------------------------------------------

def coast(pieces, bins=((0, 0),), minutes=1200, across=18, odd=0, level=1):
    """As fuzz_coast.c reads it: (first segment, how many) of each bin; each
    piece a list of (longitude, latitude) in it, 0 to 65535."""
    firsts, points = [], []
    for piece in pieces:
        firsts.append(len(points))
        points += piece
    out = bytes([odd, len(bins) - 1, len(pieces) - 1, len(points) - 1])
    out += struct.pack("<HH", minutes, across)
    out += b"".join(struct.pack("<H", b[0]) for b in bins)
    out += bytes(b[1] for b in bins)
    out += b"".join(struct.pack("<I", len(p) << 9 | level << 6)[:3]
                    for p in pieces)
    out += b"".join(struct.pack("<H", f) for f in firsts)
    return out + b"".join(struct.pack("<H", p[k])
                          for k in range(2) for p in points)


def coast_seeds():
    square = [(9000, 9000), (50000, 9000), (50000, 50000), (9000, 50000),
              (9000, 9000)]
    lake = [(20000, 20000), (30000, 20000), (30000, 30000), (20000, 20000)]
    one = ((0, 1),)
    yield "square", coast([square], one)
    yield "lake", coast([square, lake], ((0, 2),))
    yield "open", coast([square[:3]], one)
    yield "grounded", coast([square], one, level=6)
    # Over the meridian at which lines begin, over the equator, to the pole.
    yield "pacific", coast([square], ((0, 0),) * 80 + one)
    yield "all", coast([square], ((0, 0),) * 8 + one, minutes=10800, across=2)
    yield "world", coast([square], one, minutes=21600, across=1)
    yield "huge", coast([square, lake], ((0, 2),) * 2, minutes=65535)
    yield "beyond", coast([square], ((7, 3),))
    yield "shared", coast([square], one * 9)
    yield "points-beyond", coast([square], one)[:-25]
    for odd in (*range(1, 9), *range(16, 24)):
        yield f"odd-{odd}", coast([square], one, odd=odd)


# --- exercises ----------------------------------------------------------------

def exercise(*events, **more):
    """Three entities on a heading towards each other, and what is given."""
    near = {"latitude": 52.6, "longitude": 5.2, "speed": 6, "heading": 0}
    state = {"clock": {"reckoning": 1e6},
             "origin": {"latitude": 52.6, "longitude": 5.2},
             "sea": {"synthesiser": "TROCHOIDS"}, "water": {"depth": 9},
             "entities": [
                 dict(near, id=1, model={"name": "patrol-boat"}),
                 dict(near, id=2, latitude=52.6001, course=180, heading=45,
                      helm={"on": True, "length": 186, "beam": 26}),
                 dict(near, id=3, longitude=5.201, heading=90,
                      helm={"on": True, "length": 5, "beam": 4})]}
    return dumps({"ownShip": 1, "state": state, "events": list(events), **more})


def event(*when, name="a", patch=None, **more):
    return {"name": name, "when": list(when),
            "patch": patch or {"state": {"sky": {"rain": 2}}}, **more}


def exercise_whens():
    """Conditions that are one, and such as are refused."""
    square = "52.5 5.1, 52.7 5.1, 52.7 5.3, 52.5 5.3"
    circle = {"latitude": 52.6, "longitude": 5.2, "radius": 500}
    for corners in (square, square + " ", "1 1, 2 1, 2 2", "1 1, 2 1", "1",
                    "1 1; 2 2", "91 1, 2 1, 2 2", "1 181, 2 1, 2 2",
                    "nan 1, 2 1, 2 2", ", ".join(["1 2"] * 17), "",
                    "-10 179, 80 -179, 80 1"):
        for key in ("inside", "outside"):
            yield {key: {"corners": corners}}
    yield from ({"inside": circle}, {"outside": circle},
                {"inside": dict(circle, corners=square)}, {"inside": {}},
                {"outside": {"latitude": 1, "radius": 3}})
    for key in ("rangeBelow", "rangeAbove", "cpaBelow", "tcpaBelow"):
        for other in (2, 3):
            yield {key: 50, "other": other}
            yield {key: 1, "entity": 2, "other": 5 - other}
        yield {key: 50}
    yield from ({"other": 2}, {"other": 1, "rangeBelow": 1},
                {"other": 9, "rangeBelow": 1}, {"entity": 9, "at": 1},
                {"entity": 2, "speedBelow": 9}, {"speedAbove": 1},
                {"entity": 2, "underKeelBelow": 2}, {"underKeelBelow": 30},
                {"northOf": 52}, {"northOf": 53}, {"southOf": 53},
                {"eastOf": 5}, {"eastOf": -170, "westOf": 6}, {"westOf": 5},
                {"at": 1, "northOf": 1, "southOf": 80, "inside": circle,
                 "speedAbove": 1, "other": 2, "rangeBelow": 1e6},
                {"at": 1e5}, {"delay": 3}, {}, {"at": -1})


def exercise_seeds():
    for i, when in enumerate(exercise_whens()):
        yield f"when-{i}", exercise(event(when))
    chain = [event({"at": 1})] + [
        event({"after": chr(96 + i), "delay": i}, name=chr(97 + i))
        for i in range(1, 6)]
    yield "chain", exercise(*chain)
    yield "after-itself", exercise(event({"after": "a"}))
    yield "after-none", exercise(event({"after": "b"}))
    yield "no-when", exercise(event())
    yield "many-whens", exercise(event(*[{"at": 1}] * 9))
    one = {"at": 1}
    for name in ("", "a b", "n" * 65, "\u00e9"):
        yield f"name-{len(name)}-{name[:1]!r}", exercise(event(one, name=name))
    yield "names-alike", exercise(event(one), event(one))
    yield "no-name", exercise({"when": [one]})
    yield "many-events", exercise(*[event(one, name=f"e{i}")
                                    for i in range(65)])
    for i, patch in enumerate((
            {"remove": ["clock"]}, {"remove": ["exercise.name"]},
            {"remove": ["sky.rain"]}, {"remove": ["nothing"]},
            {"remove": ["entities.2"], "state": {"sky": {"rain": 1}}},
            {"state": {"exercise": {"name": "x"}}}, {"state": {}},
            {"state": {"clock": {"mode": "FREE"}}},
            {"state": {"clock": {"time": 3}}}, {"state": {"sky": {"rain": -1}}},
            {"state": {"entities": [{"id": 7, "latitude": 52.7}]}},
            {"state": {"sky": {"metar": "nonsense"}}},
            {"state": {"sea": {"beaufort": 5, "douglas": 3}}})):
        yield f"patch-{i}", exercise(event(one, patch=patch))
    yield "no-patch", dumps({"events": [{"name": "a", "when": [one]}]})
    for i, state in enumerate((
            {"clock": {"mode": "FREE"}}, {"exercise": {"name": "x"}},
            {"sky": {"rain": -1}}, {"entities": [{"id": 5}]})):
        yield f"state-{i}", exercise(event(one), state=state)
    for i, text in enumerate(("two\nlines", "bell\x07", "x" * 4097, "\u2026")):
        yield f"title-{i}", exercise(title=text)
        yield f"text-{i}", exercise(event(one, text=text), description=text)
    for i, ships in enumerate((
            [{"id": 2, "draught": 6}, {"id": 3}], [{"id": 1}], [{"id": 9}],
            [{}], [{"id": 2}, {"id": 2}], [{"id": k} for k in range(2, 10)])):
        yield f"ships-{i}", exercise(
            event({"underKeelBelow": 3, "entity": 2}), ships=ships, draught=2)
    yield "own-none", exercise(ownShip=9)
    square = {"corners": "52.5 5.1, 52.7 5.1, 52.7 5.3"}
    for i, limits in enumerate((
            [{"name": "a", "speed": 3, "area": square}],
            [{"name": "a", "speed": 3, "ship": 2}], [{"name": "a"}],
            [{"name": "a", "speed": 3, "ship": 1}],
            [{"name": "a", "speed": 3}] * 2, [{"speed": 3}],
            [{"name": "a", "speed": 3, "area": {}}],
            [{"name": f"l{k}", "speed": 3} for k in range(17)])):
        yield f"limits-{i}", exercise(limits=limits)


# --- what readers hand over ---------------------------------------------------

def handed(reader, data, magic=1):
    """As fuzz_handed.c reads it."""
    return bytes([reader, magic]) + data


def height_fields():
    def field(columns, rows, heights, place=(-50, -50, 10), count=None):
        return struct.pack("<2I3d", columns, rows, *place) + struct.pack(
            f"<{len(heights)}f", *heights)
    hill = [(-3.0 + i % 5) for i in range(25)]
    nan = float("nan")
    return {"whole": field(5, 5, hill), "cut": field(5, 5, hill[:-1]),
            "holes": field(5, 5, [nan if i % 3 else -4 for i in range(25)]),
            "empty": field(4, 4, [nan] * 16), "flat": field(2, 2, [-9.0] * 4),
            "high": field(2, 2, [1e9] * 4), "one": field(1, 1, [1.0]),
            "none": field(0, 0, []), "huge": field(1 << 20, 1 << 20, []),
            "far": field(2, 2, [1.0] * 4, (1e12, 0, 10)),
            "fine": field(2, 2, [1.0] * 4, (0, 0, 1e-9)), "head": b"\1\0"}


def weather_fields():
    def grid(columns=3, rows=3, times=2, has=0xff, west=3, south=51, east=1,
             north=1, start=1.78e9, step=3600, value=100):
        count = bin(has).count("1") * columns * rows * times
        values = [value(i) if callable(value) else value for i in range(count)]
        data = struct.pack("<4I4d", columns, rows, times, has, west, south,
                           east, north)
        data += struct.pack(f"<{times}d", *(start + step * t
                                            for t in range(times)))
        data += struct.pack(f"<{count}h", *values)
        return data + bytes(-len(data) % 8)

    def whole(grids, notes=b""):
        return (struct.pack("<2I", len(grids), len(notes)) + notes
                + bytes(-len(notes) % 8) + b"".join(grids))

    def field(*place, cut=0, **more):
        data = whole([grid(*place, **more)])
        return data[:len(data) - cut]
    some = {"whole": field(), "wind": field(has=3), "waves": field(has=0x1f),
            "no-wind": field(has=1), "part": field(has=7),
            "parts": field(has=0xe3), "cut": field(cut=2), "one": field(times=1),
            "many": field(has=0x1ff), "steps": field(east=0),
            "wide": field(east=90), "coarse": field(east=400),
            "beyond": field(south=89), "west": field(west=500),
            "falling": field(step=-1), "early": field(start=-1e12),
            "nan": field(start=float("nan")), "narrow": field(columns=1),
            "apart": whole([grid(has=3), grid(5, 4, 3, 0x1c)]),
            "apart-parts": whole([grid(has=3), grid(has=0xfc)], b"u10"),
            "apart-both": whole([grid(has=0x1f), grid(has=0x1c)]),
            "apart-wind": whole([grid(has=3), grid(has=3)]),
            "three": whole([grid(has=3), grid(has=0x1c), grid(has=3)]),
            "notes": whole([grid()], b"n" * 1023),
            "notes-long": whole([grid()], b"n" * 1024),
            "holes": field(value=lambda i: -32768 if i % 4 == 0 else i),
            "no-data": field(value=-32768), "huge": struct.pack(
                "<4I4d", 9999, 9999, 9999, 255, 0, 0, 1, 1),
            "shores": field(has=0x1f, value=lambda i: -32768
                            if i > 36 and i % 9 < 6 else 50),
            "large": field(value=32767)}
    some["world"] = field(72, 37, 2, 3, 0, -90, 5, 5)
    some["world-waves"] = field(72, 37, 1, 0xff, 0, -90, 5, 5)
    some["round"] = field(72, 35, 1, 0x1f, -180, -85, 5, 5)
    some["time-hole"] = field(times=3, value=lambda i: -32768
                              if i // 9 % 3 == 1 else 77)
    return some


def panoramas():
    def picture(columns, rows, value=lambda i: 0.5):
        count = 3 * columns * rows
        return struct.pack("<2I", columns, rows) + struct.pack(
            f"<{count}f", *(value(i) for i in range(count)))
    sun = 3 * (28 * 128 + 32)
    return {"grey": picture(16, 8), "cut": picture(16, 8)[:-1],
            "sun": picture(128, 64, lambda i: 9e3 if sun <= i < sun + 3 else .5),
            "no-sun": picture(128, 64, lambda i: 2.0 if i == sun else .5),
            "black": picture(16, 8, lambda i: 0), "square": picture(16, 16),
            "minus": picture(16, 8, lambda i: -1.0), "small": picture(2, 1),
            "nan": picture(16, 8, lambda i: float("nan")),
            "bright": picture(16, 8, lambda i: 3e38), "no": b"\1",
            "huge": struct.pack("<2I", 1 << 31, 1 << 30)}


def spectra():
    def record(count, *rows, unix=1.6e9):
        return struct.pack("<2id", count, 0, unix) + b"".join(
            struct.pack(f"<{len(r)}d", *r) for r in rows)
    f = [0.05, 0.1, 0.2]
    rows = [f, [1, 2, 1], [.5] * 3, [.3] * 3, [1] * 3, [2] * 3]
    yield "whole", record(3, *rows)
    for i, wrong in enumerate(([.1, .05, .2], [-1] * 3, [2] * 3, [-1] * 3,
                               [9] * 3, [float("nan")] * 3)):
        yield f"row-{i}", record(3, *rows[:i], wrong, *rows[i + 1:])
    yield "few", record(2, *(r[:2] for r in rows))
    yield "cut", record(3, *rows)[:-1]
    yield "many", record(1 << 30, *rows)
    yield "timeless", record(3, *rows, unix=float("inf"))
    yield "head", b"\0"


def models():
    """A tetrahedron, by models/modelwire.c's structures."""
    corners = [(0, 0, 0), (4, 0, 0), (0, 2, 0), (0, 0, 1)]
    faces = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]

    def pad(data):
        return data + bytes(-len(data) % 8)

    def model(level=(1, 4, 0.0), part=(0, 12, 0, 0), texture=-1, side=2,
              order=faces, points=corners, levels=1, textures=1, notes=b"n"):
        name = b"hull".ljust(64, b"\0")
        data = struct.pack("<6I", len(points), len(order), 1, textures, 1,
                           levels) + notes.ljust(480, b"\0")
        data = pad(b"pelmodl1" + data)[8:]
        for _ in range(levels):
            data += pad(struct.pack("<2IfI", *level, 0))
            data += pad(struct.pack("<2I2H", *part) * level[0])
        data += pad(b"".join(struct.pack("<8f", *p, 0, 0, 1, 0, 0)
                             for p in points))
        data += pad(struct.pack(f"<{len(order)}I", *order))
        data += pad(name)
        data += pad(name + struct.pack("<6fiI", .5, .4, .3, 0, .5, 0, texture,
                                       1))
        for _ in range(textures):
            data += pad(struct.pack("<2I", side, side))
            data += pad(bytes(range(4 * side * side)))
        return data
    yield "whole", model()
    yield "textured", model(texture=0)
    yield "texture-none", model(texture=5)
    yield "two-levels", model(levels=2)
    yield "levels", model(levels=40)
    yield "flat", model(points=[(x, y, 0) for x, y, z in corners])
    yield "point", model(points=[(1, 1, 1)] * 4)
    yield "vast", model(points=[(1e9 * x, y, z) for x, y, z in corners])
    yield "beyond", model(order=[9] * 12)
    yield "part-beyond", model(part=(9, 12, 0, 0))
    yield "material-beyond", model(part=(0, 12, 3, 0))
    yield "no-texture", model(textures=0)
    yield "wide", model(side=0)
    yield "notes", model(notes=b"n" * 480)
    for cut in (1, 20, 100, 250, 400, 500, 600):
        yield f"cut-{cut}", model()[:-cut]


def handed_seeds():
    kinds = [height_fields().items(), weather_fields().items(),
             panoramas().items(), spectra(), models()]
    for reader, fields in enumerate(kinds):
        first = None
        for name, data in fields:
            first = data if first is None else first
            yield f"{reader}-{name}", handed(reader, data)
            # Two of the readers look at how long it is as well.
            yield f"{reader}-{name}-longer", handed(reader, data + b"\0")
        for place in (3, 5, 7):
            yield f"{reader}-place-{place}", handed(reader, data, place)
            yield f"{reader}-place-{place}-first", handed(
                reader, first, place)
        yield f"{reader}-other", handed(reader, b"other bytes" * 9, magic=0)
    yield "panorama-sun-sought", handed(2, panoramas()["sun"])
    yield "land", handed(5, b"fill")
    yield "land-other", handed(5, b"fill", magic=0)
    yield "land-short", handed(5, b"x")
    yield "land-first", handed(5, b"get")


SEEDS = [("coast", coast_seeds), ("exercise", exercise_seeds),
         ("handed", handed_seeds)]
