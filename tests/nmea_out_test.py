#!/usr/bin/python3
"""--nmea-out: own ship as NMEA 0183, read by gpsd's gpsdecode."""
import json
import shutil
import socket
import subprocess
import sys

from modbus_test import check
from pelagos_daemon import SLOW_S, Daemon, free_port, until


def receive(receiver, count):
    data = b""
    for _ in range(count):
        data += receiver.recv(4096)
    return data


def others():
    """Ships and marks as a radar and AIS have them: gpsdecode and another
    pelagosd read where they are and what."""
    receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    receiver.bind(("127.0.0.1", 0))
    receiver.settimeout(SLOW_S)
    port = receiver.getsockname()[1]
    with Daemon("--nmea-out", f"127.0.0.1:{port}", "--nmea-out-rate", "5",
                "--nmea-out-targets", "both") as daemon:
        daemon.patch({"clock": {"mode": "STEPPED"}, "entities": {
            "1": {"latitude": 52.6, "longitude": 5.2},
            "7": {"name": "Blue Star", "latitude": 52.61, "longitude": 5.21,
                  "speed": 6, "course": 270, "heading": 268,
                  "model": {"name": "tanker", "length": 200}},
            "40": {"name": "N 3", "latitude": 52.59, "longitude": 5.2,
                   "model": {"name": "cardinal-north"}},
            "41": {"name": "raft", "latitude": 52.6, "longitude": 5.21,
                   "model": {"name": "life-raft"}},
            "20003": {"name": "mmsi-1", "latitude": 52.6, "longitude": 5.22,
                      "model": {"name": "tug"}}}})
        data = receive(receiver, 120)  # 12 s of them: aids are due
        checksums(data)
        # Range and bearing on a sphere of 1852 m a minute would be 0.6 and
        # 0.36 miles north and east; on the ellipsoid within 1 %.
        ttm = [line.split(b",") for line in data.split(b"\r\n")
               if line.startswith(b"$RATTM")]
        star = next(t for t in ttm if t[11] == b"Blue Star")
        check(abs(float(star[2]) - 0.70) < 0.01
              and abs(float(star[3]) - 31.3) < 0.5, f"{star}")
        check(star[5:8] == [b"11.7", b"270.0", b"T"], f"{star}")
        check({t[11] for t in ttm} == {b"Blue Star", b"N 3", b"raft"},
              f"{ttm[:6]}")
        ais_by_gpsdecode(data)
    receiver.close()
    with Daemon("--nmea", f"127.0.0.1:{port}", "--nmea-ais") as other:
        sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        for line in data.split(b"\r\n"):
            if line.startswith(b"!AIVDM"):
                sender.sendto(line + b"\r\n", ("127.0.0.1", port))

        def there():
            found = {e["name"]: e for e in other.state()["entities"]}
            return all("model" in found.get(name, {})
                       for name in ("BLUE STAR", "N 3")) and found
        found = until("targets", there)
        star = found["BLUE STAR"]
        check(abs(star["latitude"] - 52.61) < 2e-6 and star["heading"] == 268
              and star["model"]["name"] == "tanker"
              and star["model"]["length"] == 200, f"{star}")
        check(found["N 3"]["model"]["name"] == "cardinal-north", f"{found}")


def ais_by_gpsdecode(data):
    if not shutil.which("gpsdecode"):
        print("gpsdecode is not installed: left out")
        return
    data = b"".join(line + b"\r\n" for line in data.split(b"\r\n")
                    if line.startswith(b"!"))
    done = subprocess.run(["gpsdecode", "-j", "-D", "1"], input=data,
                          capture_output=True, timeout=SLOW_S, check=False)
    # Message 1 has 168 bits (M.1371-5, table 48); gpsd 3.22 warns above 163.
    warned = {line for line in done.stderr.splitlines()
              if b"message type 1 size > 163 bits (168)" not in line}
    check(done.returncode == 0 and not warned, f"{warned}")
    said = [r for r in (json.loads(line) for line in done.stdout.splitlines()
                        if line.startswith(b"{")) if r["class"] == "AIS"]
    check({(r["type"], r["mmsi"]) for r in said} ==
          {(1, 200000007), (5, 200000007), (21, 992000040)}, f"{said[:4]}")
    at = next(r for r in said if r["type"] == 1)
    check(abs(at["lat"] - 52.61) < 2e-6 and abs(at["lon"] - 5.21) < 2e-6
          and abs(at["speed"] - 11.7) < 0.01 and at["course"] == 270
          and at["heading"] == 268, f"{at}")
    ship = next(r for r in said if r["type"] == 5)
    check(ship["shipname"] == "BLUE STAR" and ship["shiptype"] == 80
          and ship["to_bow"] + ship["to_stern"] == 200, f"{ship}")
    mark = next(r for r in said if r["type"] == 21)
    check(mark["name"] == "N 3" and mark["aid_type"] == 20
          and abs(mark["lat"] - 52.59) < 2e-6 and not mark["virtual_aid"],
          f"{mark}")
    print(f"  gpsdecode: {len(said)} AIS messages, no error")


def checksums(data):
    lines = data.split(b"\r\n")
    check(lines.pop() == b"", "ends with CR LF")
    for line in lines:
        body, given = line[1:].split(b"*")
        total = 0
        for byte in body:
            total ^= byte
        check(line[:1] in b"$!" and int(given, 16) == total, f"{line}")
        check(len(line) <= 80, f"{line}")
    return {line[3:6].decode() for line in lines}


def by_gpsdecode(data, steered=False):
    if not shutil.which("gpsdecode"):
        print("gpsdecode is not installed: left out")
        return
    done = subprocess.run(["gpsdecode", "-j", "-D", "1"], input=data,
                          capture_output=True, timeout=SLOW_S, check=False)
    check(done.returncode == 0, f"{done}")
    check(done.stderr == b"", f"gpsdecode says {done.stderr[:400]}")
    reports = [json.loads(line) for line in done.stdout.splitlines()
               if line.startswith(b"{")]
    check(not [r for r in reports if r["class"] == "ERROR"], "an error")
    fixes = [r for r in reports if r["class"] == "TPV" and "lat" in r
             and "speed" in r]
    check(fixes, f"no fix in {done.stdout[:2000]}")
    last = fixes[-1]
    check(abs(last["lat"] - 52.6) < 0.01 and abs(last["lon"] - 5.2) < 0.01,
          f"{last}")
    check(steered or (abs(last["speed"] - 6) < 0.05 and
                      abs(last["track"] - 40) < 0.5), f"{last}")
    check(last["time"].startswith("2026-06-21T12:0"), f"{last}")
    print(f"  gpsdecode: {len(reports)} reports, no error")


def other_daemon(first, port):
    """Another pelagosd follows: our own input reads our output."""
    with Daemon("--nmea", f"127.0.0.1:{port}") as daemon:
        def ship_now():
            ship = daemon.state()["entities"][0]
            return ship["speed"] > 5.9 and ship["roll"] == 2.5 and ship
        ship = until("own ship follows", ship_now)
        check(abs(ship["speed"] - 6) < 0.05 and ship["roll"] == 2.5, f"{ship}")
        # An edit of its own, applied when its sea is built.
        until("the wind", lambda: daemon.state()["sea"]["windSpeed"] > 8.9)
        dropped = {k: v for k, v in daemon.metrics().items()
                   if k.startswith("pelagos_nmea_dropped_total") and v}
        check(not dropped, f"{dropped}")
        check(first.alive(), "alive")


def main():
    others()
    receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    receiver.bind(("127.0.0.1", 0))
    receiver.settimeout(SLOW_S)
    port = receiver.getsockname()[1]
    with Daemon("--nmea-out", f"127.0.0.1:{port}", "--nmea-out-rate",
                "20") as daemon:
        daemon.patch({"entities": {"1": {
            "speed": 6, "course": 40, "heading": 38, "roll": 2.5}},
            "sea": {"windSpeed": 9}})
        receive(receiver, 5)
        data = receive(receiver, 20)
        kinds = checksums(data)
        check(kinds == {"RMC", "GGA", "VTG", "ZDA", "HDT", "ROT", "MWD", "MWV",
                        "XDR"}, f"{kinds}")
        by_gpsdecode(data)
        daemon.patch({"ownShip": {"on": True, "rudder": 3}})
        receive(receiver, 5)
        daemon.patch({"sea": {"depth": 31, "level": 1.5}})
        receive(receiver, 5)
        data = receive(receiver, 20)
        check(checksums(data) >= {"RSA", "DPT"}, "rudder and depth")
        check(b"$SDDPT,32.5," in data, "the depth with the tide")
        by_gpsdecode(data, steered=True)
        check(daemon.metrics()["pelagos_nmea_out_sentences_total"] > 200,
              "counted")
        receiver.close()  # nobody listens: no error
        daemon.patch({"ownShip": {"on": False}, "entities": {"1": {
            "speed": 6, "course": 40, "roll": 2.5}}})
        other_daemon(daemon, port)
    here = free_port(socket.SOCK_DGRAM)
    try:
        Daemon("--nmea", f"127.0.0.1:{here}", "--nmea-out",
               f"127.0.0.1:{here}").stop()
    except RuntimeError as error:
        check("--nmea-out" in str(error), f"{error}")
    else:
        raise AssertionError("it talks to itself")


if __name__ == "__main__":
    sys.exit(main())
