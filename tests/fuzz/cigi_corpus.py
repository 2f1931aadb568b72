#!/usr/bin/python3
"""Datagrams for the CIGI bridge, the same on every machine.

    cigi_corpus.py malformed FOLDER [N]  N (2000) datagrams that are no CIGI
    cigi_corpus.py archive               writes cigi_malformed.z anew
    cigi_corpus.py unpack FOLDER         the files of cigi_malformed.z

cigi_malformed.z holds 2,000 malformed datagrams; tests/cigi_test.py sends them
to a running daemon. Each is wrong by its making, and says how in its name. It
is a zlib stream of records: a byte of length and the name, two bytes of length
(most significant first) and the datagram.
"""
import pathlib
import random
import struct
import sys
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import cigi_host as cigi  # noqa: E402


def sound():
    """Packets of every kind, by name."""
    return {
        "entity": [cigi.entity(1, 52.61, 5.21, 3, yaw=40),
                   cigi.entity(2, 5, 1, -3, parent=1),
                   cigi.entity(3, 52.6, 5.2, clamp=2)],
        "destroy": [cigi.entity(1, 0, 0, state=2)],
        "conformal": [cigi.conformal(9, 52.6, 5.2, 10)],
        "component": [cigi.component(1, 1, (12, 270, 1e5, 3.3), seed=4)],
        "swell": [cigi.component(3, 1, (2, 9, 100, 12), instance=2)],
        "short": [cigi.short_component(2, 6, 200)],
        "rate": [cigi.rate(1, 5, 1, yaw=3, local=True)],
        "celestial": [cigi.celestial(14, 30, 6, 21, 2026)],
        "atmosphere": [cigi.atmosphere(9000, 9, 45)],
        "region": [cigi.region(1, 52.6, 5.2, 1000, 1000, 50, 20),
                   cigi.weather(0, 700, 6, 30, scope=1, region=1)],
        "maritime": [cigi.maritime(60), cigi.wave(1, 2, 8, 120),
                     cigi.wave(2, 1, 0, 60, length=90)],
        "view": [cigi.view_control(0, 1, 1, 2, -15, 1, -3, 20),
                 cigi.view_definition(3, -20, 20, 10, -10, group=1),
                 cigi.view_control(0, 1, yaw=5, group=1)],
        "sensor": [cigi.sensor(0, 1)],
        "heights": [cigi.hat_hot(1, 52.6, 5.2, 9, kind) for kind in range(3)]
        + [cigi.hat_hot(4, 5, 0, 0, entity=1, period=2)],
        "sight": [cigi.los_segment(1, (52.6, 5.2, 9), (52.61, 5.2, -9)),
                  cigi.los_vector(2, (52.6, 5.2, 9), 30, -4, 500,
                                  extended=True, period=1)],
        "position": [cigi.position(1), cigi.position(0, 2, True)],
        "conditions": [cigi.conditions(1, 52.6, 5.2, 5)],
    }


def datagram(packets, order=">", number=1, **head):
    return (cigi.ig_control(order, number, 0, **head) +
            b"".join(p(order) for p in packets))


def _cut(pick, whole):
    boundaries = {0}
    at = 0
    while at < len(whole):
        at += whole[at + 1]
        boundaries.add(at)
    return "cut", whole[:pick.choice(
        [n for n in range(len(whole)) if n not in boundaries or n < 24])]


def _resized(pick, whole):
    """A packet whose size is 0, odd, too small, or beyond the end."""
    out = bytearray(whole)
    places = []
    at = 0
    while at < len(out):
        places.append(at)
        at += out[at + 1]
    at = pick.choice(places)
    out[at + 1] = pick.choice(
        [0, 1, 7, out[at + 1] - 1, out[at + 1] + 3] +
        ([8] if out[at + 1] > 8 else []) +
        ([248] if len(out) - at < 248 else []))
    return "size", bytes(out)


def _headless(pick, whole):
    how = pick.randrange(5)
    out = bytearray(whole)
    if how == 0:
        return "first", whole[24:] or b"\x02\x30"
    if how == 1:
        out[2] = pick.choice([0, 1, 2, 4, 255])
        return "version", bytes(out)
    if how == 2:
        out[4] = pick.choice([0, 1, 4, 15]) << 4 | 1
        return "minor", bytes(out)
    if how == 3:
        struct.pack_into(">H", out, 6, pick.choice([0, 1, 0x8080, 0xFFFF]))
        return "order", bytes(out)
    return "twice", whole + whole


def _not_a_number(pick, whole):
    value = pick.choice(["nan", "inf", "-inf"])
    bad = pick.choice([
        cigi.entity(1, float(value), 5), cigi.entity(1, 5, 5, yaw=float(value)),
        cigi.atmosphere(float(value), 5, 5), cigi.wave(1, float(value), 8, 0),
        cigi.hat_hot(1, 52, float(value)), cigi.rate(1, float(value)),
        cigi.conditions(1, float(value), 5), cigi.maritime(float(value))])
    order = ">" if whole[6] else "<"
    return "number", whole + bad(order)


def _noise(pick, _):
    data = bytearray(pick.randbytes(pick.choice((0, 1, 7, 8, 24, 300, 1400))))
    if data and data[0] == 1:
        data[0] = 2
    return "noise", bytes(data)


def malformed(count=2000, seed=20260621):
    """(name, datagram), each wrong."""
    pick = random.Random(seed)
    kinds = list(sound().items())
    makers = [_cut, _resized, _headless, _not_a_number, _noise]
    for i in range(count):
        name, packets = pick.choice(kinds)
        order = pick.choice("><")
        whole = datagram(packets, order, pick.randrange(1 << 32))
        how, data = makers[i % len(makers)](pick, whole)
        yield f"{i:04}-{how}-{name}", data


ARCHIVE = pathlib.Path(__file__).with_name("cigi_malformed.z")


def pack(made):
    return zlib.compress(b"".join(
        struct.pack(">B", len(name)) + name.encode() +
        struct.pack(">H", len(data)) + data for name, data in made), 9)


def committed():
    """(name, datagram) of the archive."""
    left = zlib.decompress(ARCHIVE.read_bytes())
    out = []
    while left:
        name, left = left[1:1 + left[0]].decode(), left[1 + left[0]:]
        size = int.from_bytes(left[:2], "big")
        out.append((name, left[2:2 + size]))
        left = left[2 + size:]
    return out


def main():
    makers = {"unpack": committed,
              "malformed": lambda: malformed(*map(int, sys.argv[3:4]))}
    if sys.argv[1:] == ["archive"]:
        ARCHIVE.write_bytes(pack(malformed()))
        return
    if len(sys.argv) < 3 or sys.argv[1] not in makers:
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    made = makers[sys.argv[1]]()
    count = 0
    for name, data in made:
        (folder / name).write_bytes(data)
        count += 1
    print(f"{count} files in {folder}")


if __name__ == "__main__":
    main()
