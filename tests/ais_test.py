#!/usr/bin/python3
"""AIS targets against gpsd's gpsdecode: what pelagosd shows of messages of
every type that it reads is what gpsdecode reads in them; so is what it shows
of real logs, where ../shared/data/ais lies beside the checkout."""
import json
import math
import os
import pathlib
import random
import shutil
import socket
import subprocess
import sys

from modbus_test import check
from pelagos_daemon import SLOW_S, Daemon, free_port, until

ROOT = pathlib.Path(__file__).resolve().parents[1]
DATA = pathlib.Path(os.environ.get("PELAGOS_DATA", ROOT / "../shared/data"))
KNOT = 1852 / 3600
LATITUDE, LONGITUDE = 52.6, 5.2  # own ship of the default scene
PLACES = {}  # by MMSI: what messages() said


def six_bits(text):
    codes = [ord(c) - 64 if ord(c) >= 64 else ord(c) for c in text.ljust(20,
                                                                          "@")]
    return [(c, 6) for c in codes]


def sentences(fields):
    """!AIVDM of (value, width) pairs, negative values in two's complement: one,
    or two where it is long."""
    bits = "".join(format(v & ((1 << w) - 1), f"0{w}b") for v, w in fields)
    fill = -len(bits) % 6
    bits += "0" * fill
    payload = "".join(chr(v + 48 if v < 40 else v + 56) for v in
                      (int(bits[i:i + 6], 2) for i in range(0, len(bits), 6)))
    parts = [payload[i:i + 56] for i in range(0, len(payload), 56)]
    for i, part in enumerate(parts):
        body = (f"AIVDM,{len(parts)},{i + 1},{'3' if len(parts) > 1 else ''},"
                f"A,{part},{fill if part is parts[-1] else 0}")
        total = 0
        for c in body:
            total ^= ord(c)
        yield f"!{body}*{total:02X}"


def messages():
    """One of each type and then some, at random within 30' of own ship."""
    rng = random.Random(1371)

    def size():
        return [(rng.randrange(1, 200), 9), (rng.randrange(1, 200), 9),
                (rng.randrange(1, 30), 6), (rng.randrange(1, 30), 6)]

    for i in range(60):
        kind = (1, 2, 3, 4, 9, 18, 19, 21, 27, 24)[i % 10]
        mmsi = 244000000 + i
        lon, lat = (LONGITUDE + rng.uniform(-.5, .5),
                    LATITUDE + rng.uniform(-.5, .5))
        if kind != 24:
            PLACES[mmsi] = (lat, lon)
        fine = [(round(lon * 600000), 28), (round(lat * 600000), 27)]
        course = rng.choice([3600, rng.randrange(3600)])
        heading = rng.choice([511, rng.randrange(360)])
        knots10 = rng.choice([1023, rng.randrange(400)])
        head = [(kind, 6), (0, 2), (mmsi, 30)]
        name = six_bits(f"SHIP {i}")
        if kind <= 2:  # its size comes first
            yield [(5, 6), (0, 2), (mmsi, 30), (0, 2), (9000000 + i, 30),
                   (0, 42), *name, (rng.randrange(20, 100), 8), *size(), (1, 4),
                   (0, 20), (rng.randrange(0, 150), 8), (0, 120), (0, 1),
                   (0, 1)]
        if kind <= 3:
            turn = rng.choice([-128, rng.randrange(-126, 127)])
            yield head + [(i * 11 // 3 % 16, 4), (turn, 8), (knots10, 10), (1, 1), *fine,
                          (course, 12), (heading, 9), (30, 6), (0, 2), (0, 3),
                          (0, 1), (0, 19)]
        elif kind == 4:
            yield head + [(2026, 14), (6, 4), (21, 5), (12, 5), (0, 6), (0, 6),
                          (1, 1), *fine, (7, 4), (0, 10), (0, 1), (0, 19)]
        elif kind == 9:
            yield head + [(rng.choice([4095, 300]), 12), (90, 10), (1, 1),
                          *fine, (course, 12), (30, 6), (0, 8), (0, 1), (0, 3),
                          (0, 1), (0, 1), (0, 20)]
        elif kind == 18:
            yield head + [(0, 8), (knots10, 10), (1, 1), *fine, (course, 12),
                          (heading, 9), (30, 6), (0, 2), (0, 6), (0, 1),
                          (0, 20)]
        elif kind == 19:
            yield head + [(0, 8), (knots10, 10), (1, 1), *fine, (course, 12),
                          (heading, 9), (30, 6), (0, 4), *name,
                          (rng.randrange(20, 100), 8), *size(), (1, 4), (0, 1), (0, 1), (0, 1), (0, 4)]
        elif kind == 21:
            long = f"BUOY NUMBER {i} AND MORE"  # 20 characters and the rest
            yield head + [(14, 5), *six_bits(long[:20]), (1, 1), *fine, (0, 30), (7, 4),
                          (60, 6), (0, 1), (0, 8), (0, 1), (0, 1), (0, 1),
                          (0, 1), *six_bits(long[20:])[:len(long) - 20]]
        elif kind == 27:
            yield head + [(1, 1), (0, 1), (i * 11 // 3 % 16, 4),
                          (round(lon * 600), 18),
                          (round(lat * 600), 17),
                          (rng.choice([63, rng.randrange(60)]), 6),
                          (rng.choice([511, rng.randrange(360)]), 9), (0, 1),
                          (0, 1)]
        else:  # the name of the first of the round, in two parts
            head = [(24, 6), (0, 2), (mmsi - 9, 30)]
            yield head + [(0, 2), *name, (0, 8)]
            yield head + [(1, 2), (36, 8), (0, 42), (0, 42), *size(), (0, 6)]


def gpsdecode(lines):
    done = subprocess.run(["gpsdecode", "-j"], timeout=SLOW_S, check=True,
                          input="\n".join(lines).encode() + b"\n",
                          capture_output=True)
    return [json.loads(line) for line in done.stdout.splitlines()
            if line.startswith(b'{"class":"AIS"')]


SIZES = ("to_bow", "to_stern", "to_port", "to_starboard")


def to_middle(ship):
    """From the antenna to the middle of the ship, on a sphere."""
    bow, stern, port, starboard = (ship.get(k, 0) for k in SIZES)
    known = [h for h in (ship["heading"], ship["course"])
             if isinstance(h, (int, float)) and h < 360]
    if ship["heading"] not in known and not (
            isinstance(ship["speed"], (int, float)) and
            .5 / KNOT < ship["speed"] < 102.3):
        known = []
    ship["bearing"] = known[0] if known else ship.get("bearing")
    if (bow == 0 and port == 0) or ship["bearing"] is None:
        return
    turn = math.radians(ship["bearing"])
    ahead, right = (bow - stern) / 2, (starboard - port) / 2
    north = ahead * math.cos(turn) - right * math.sin(turn)
    east = ahead * math.sin(turn) + right * math.cos(turn)
    lat = math.radians(ship["lat"])
    ship["lat"] += north / 111194
    ship["lon"] += east / 111194 / math.cos(lat)


def compare_shape(entity, ship, what):
    """The size that gpsdecode reads is the model's, where a model can have
    it (a factor of 10 from its own)."""
    model = entity.get("model")
    if ship["type"] in (4, 9):
        check(model is None, what)
    if ship["type"] in (4, 9, 21):
        return
    check(model and entity.get("afloat"), what)
    length = ship.get("to_bow", 0) + ship.get("to_stern", 0)
    beam = ship.get("to_port", 0) + ship.get("to_starboard", 0)
    if 30 <= length <= 170:  # every row of the table can have it
        check(model.get("length") == length, what)
        if length / 10 < beam < length / 4:
            check(model.get("beam") == beam, what)
    kind = ship.get("shiptype", 0) // 10
    if 30 <= length < 200 and kind in (6, 7, 8):
        check(model["name"] == {6: "ferry", 7: "bulk-carrier",
                                8: "tanker"}[kind], what)


def expected(reports):
    """Of each MMSI the last position and what came with it, and its name."""
    ships = {}
    for r in reports:
        ship = ships.setdefault(r["mmsi"], {})
        if r.get("name") or r.get("shipname"):
            ship["name"] = (r.get("name") or r.get("shipname")).strip()
        if r["type"] in (5, 19, 24) and "to_bow" in r:
            ship.update({k: r[k] for k in SIZES}, shiptype=r["shiptype"],
                        draught=r.get("draught", 0))
        fine = ship.get("type", 27) != 27
        if "lat" in r and abs(r["lat"]) <= 85 and abs(r["lon"]) <= 180 and \
                r["type"] in (1, 2, 3, 4, 9, 18, 19, 21, 27) and \
                not (r["type"] == 27 and fine):
            ship.update(type=r["type"], lat=r["lat"], lon=r["lon"],
                        speed=r.get("speed"), course=r.get("course"),
                        heading=r.get("heading"), alt=r.get("alt"),
                        status=r.get("status"))
            to_middle(ship)
    return {m: s for m, s in ships.items() if "lat" in s}


def overlong(line):
    """Noise that reads as a type 27 of 168 bits, which gpsdecode takes."""
    payload = line.split(",")[5:6]
    return payload and payload[0][:1] == "K" and len(payload[0]) == 28


# By the schema; reserved ones are not kept.
STATUS = {0: "UNDER_WAY", 1: "AT_ANCHOR", 2: "NOT_UNDER_COMMAND",
          3: "RESTRICTED", 4: "CONSTRAINED", 5: "MOORED", 6: "AGROUND",
          7: "FISHING", 8: "SAILING", 11: "TOWING", 12: "PUSHING"}
# gpsdecode's words for it, of type 27; 11 and 12, which are for regional use,
# are "Reserved" there as others are.
WORDS = {"Under way using engine": 0, "At anchor": 1, "Not under command": 2,
         "Restricted manoeuverability": 3, "Constrained by her draught": 4,
         "Moored": 5, "Aground": 6, "Engaged in fishing": 7,
         "Under way sailing": 8}


def near(a, b, tolerance):
    return abs(a - b) <= tolerance


def compare(entity, ship, mmsi):
    what = f"{mmsi}: {entity} is not {ship}"
    if "name" in ship:
        check(entity["name"] == ship["name"], what)
    elif mmsi in PLACES:  # gpsdecode waits for a second part of a type 24
        check(entity["name"] == f"mmsi-{mmsi:09d}", what)
    if ship["type"] in (1, 2, 3, 27) and ship["status"] != "Reserved":
        check(entity["navigationStatus"] ==
              STATUS.get(WORDS.get(ship["status"], ship["status"]),
                         "UNDEFINED"), what)
    check(entity["lights"] == "AUTO", what)
    # gpsdecode prints six decimals, of type 27 one.
    compare_shape(entity, ship, what)
    step = 0.0501 if ship["type"] == 27 else 1e-6
    if "to_bow" in ship:  # the sphere's metres are up to 0.7 % off, of 256 m
        step = max(step, 2e-5 / math.cos(math.radians(ship["lat"])))
    check(near(entity["latitude"], ship["lat"], step) and
          near(entity["longitude"], ship["lon"], step), what)
    if mmsi in PLACES and "to_bow" not in ship:  # rounded to the unit of the message
        unit = (1 / 600 if ship["type"] == 27 else 1 / 600000) * 0.51
        check(near(entity["latitude"], PLACES[mmsi][0], unit) and
              near(entity["longitude"], PLACES[mmsi][1], unit), what)
    course = ship["course"]
    known = course is not None and course < 360
    knots = ship["speed"] if isinstance(ship["speed"], (int, float)) else None
    unknown = {27: 63, 9: 1023}.get(ship["type"], 102.3)
    moves = known and knots is not None and knots < unknown
    check(near(entity.get("speed", 0), knots * KNOT if moves else 0, 1e-3),
          what)
    check(not known or near(entity.get("course", 0), course, 1e-3), what)
    heading = ship["heading"]
    if heading is not None and heading < 360:
        check(entity.get("heading", 0) == heading, what)
    if ship["type"] == 9:
        known = isinstance(ship["alt"], (int, float))  # else "nan"
        check(entity.get("altitude", 0) == (ship["alt"] if known else 0), what)


def shapes_made(daemon):
    """Shapes are made on a thread, a few
    at a time."""
    seen = [daemon.metrics()["pelagos_nmea_edits_total"]]

    def still():
        seen.append(daemon.metrics()["pelagos_nmea_edits_total"])
        return len(seen) > 29 and len(set(seen[-30:])) == 1
    until("shapes", still, 300, pause_s=0.5)


def shown(lines):
    """What the daemon has of the lines, with its clock standing."""
    port = free_port(socket.SOCK_DGRAM)
    with Daemon("--nmea", f"127.0.0.1:{port}", "--nmea-ais", "--state",
                "off") as daemon:
        daemon.patch({"clock": {"mode": "STEPPED"}})
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            for i, line in enumerate(lines):
                sender.sendto(line.encode() + b"\r\n", ("127.0.0.1", port))
                if i % 32 == 31 or i == len(lines) - 1:
                    until(f"{i + 1} datagrams", lambda n=i: daemon.metrics()[
                        "pelagos_nmea_datagrams_total"] == n + 1)
        shapes_made(daemon)
        return {int(e["id"]): e for e in daemon.state()["entities"]
                if int(e["id"]) >= 20000}, daemon.metrics()


def by_position(entities, ship):
    return [e for e in entities.values()
            if near(e["latitude"], ship["lat"], 1e-6) and
            near(e["longitude"], ship["lon"], 1e-6)]


def agree(lines, most=100):
    ships = expected(gpsdecode(lines))
    entities, metrics = shown(lines)
    if len(ships) <= most:
        check(len(entities) == len(ships),
              f"{len(entities)} targets of {len(ships)}")
    else:
        check(len(entities) == most, f"{len(entities)} targets of {most}")
    found = 0
    for mmsi, ship in ships.items():
        name = ship.get("name", f"mmsi-{mmsi:09d}")
        matching = [e for e in entities.values() if e["name"] == name] or \
            by_position(entities, ship)
        if len(matching) == 1:
            compare(matching[0], ship, mmsi)
            found += 1
        else:
            check(len(ships) > most or len(matching) > 1,
                  f"{mmsi} {ship} is not shown")
    return found, len(ships), metrics


def main():
    if not shutil.which("gpsdecode"):
        print("gpsdecode is not installed (gpsd-clients)")
        return 77
    made = [s for m in messages() for s in sentences(m)]
    found, ships, _ = agree(made)
    check(found == ships == 54, f"{found} of {ships}")
    print(f"10 types: {found} targets as gpsdecode reads them")
    for log in ("libais-typeexamples.nmea", "pyais-nmea_data_sample.txt",
                "libais-test.aivdm", "pyais-mixed.txt"):
        if not (DATA / "ais" / log).is_file():
            print(f"{DATA}/ais/{log} is not there: left out")
            continue
        text = (DATA / "ais" / log).read_text(errors="replace")
        lines = [line for line in text.splitlines() if line.startswith("!")
                 and not overlong(line)]
        found, ships, metrics = agree(lines)
        print(f"{log}: {len(lines)} lines, {ships} ships by gpsdecode, "
              f"{found} alike; dropped " +
              str({k.split('"')[1]: int(v) for k, v in metrics.items()
                   if k.startswith("pelagos_nmea_dropped") and v}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
