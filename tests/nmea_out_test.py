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


def checksums(data):
    lines = data.split(b"\r\n")
    check(lines.pop() == b"", "ends with CR LF")
    for line in lines:
        body, given = line[1:].split(b"*")
        total = 0
        for byte in body:
            total ^= byte
        check(line[:1] == b"$" and int(given, 16) == total, f"{line}")
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
