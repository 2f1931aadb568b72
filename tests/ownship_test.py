#!/usr/bin/python3
"""Own ship without a simulator: a console's wheel and lever sail it."""
import logging
import math
import os
import socket
import sys
import tempfile
import time

from pymodbus.client import ModbusTcpClient

from console_test import Console, ship
from modbus_test import check, floats
from pelagos_daemon import Daemon, free_port, until
from replay_test import replayed, sentence

TABLE = """
holding 0 i16 ownShip.rudder   scale=0.01 min=-35 max=35
holding 1 i16 ownShip.throttle scale=0.001 stale=0
"""
VIEW = {"bridge": {"width": 160, "height": 90, "up": 12}}
RUDDER, COMMIT = 92, 96


def console_alone(folder):
    """The frames of the session are those of its replay, bit for bit."""
    table, log = (os.path.join(folder, n) for n in ("table", "sail.pelog"))
    with open(table, "w") as f:
        f.write(TABLE)
    console_port, nmea = free_port(), free_port(socket.SOCK_DGRAM)
    modbus = free_port()
    console = Console(console_port)
    pictures = {}
    with Daemon("--console", f"127.0.0.1:{console_port}", "--console-table",
                table, "--console-unit", "3", "--console-stale", "3000",
                "--nmea", f"127.0.0.1:{nmea}", "--modbus",
                f"127.0.0.1:{modbus}", "--record", log) as daemon:
        start = ship(daemon)
        daemon.patch({"ownShip": {"on": True}, "views": VIEW,
                      "sea": {"windSpeed": 12}, "clock": {"rate": 3}})
        console.set("holding", 0, 1000)
        console.set("holding", 1, 900)
        until("under way", lambda: ship(daemon)["speed"] > 1)
        until("turning", lambda: 2 < ship(daemon)["heading"] < 180)
        attitudes = []
        for i in range(6):
            console.set("holding", 0, (1000 - 400 * i) & 0xFFFF)
            time.sleep(0.25)
            own = ship(daemon)
            attitudes.append((own["roll"], own["pitch"], own["altitude"]))
            at = daemon.state()["clock"]["time"]
            answer = daemon.get(f"/v1/views/bridge/frame.png?time={at!r}")
            check(answer.status == 200, f"{answer}")
            pictures[at] = answer.body
        moved = math.hypot(own["latitude"] - start["latitude"],
                           own["longitude"] - start["longitude"])
        check(moved * 111e3 > 3, "it sails")
        for values in zip(*attitudes):
            check(len(set(values)) == 6 and max(map(abs, values)) > 0.01,
                  f"the sea moves it: {values}")
        print("== orders by NMEA and Modbus", flush=True)
        sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        sender.sendto(sentence("ERRSA,-12.5,A,,"), ("127.0.0.1", nmea))
        until("RSA", lambda: daemon.state()["ownShip"]["rudder"] == -12.5)
        check(daemon.state()["ownShip"]["on"], "an order is no pose")
        client = ModbusTcpClient("127.0.0.1", port=modbus)
        client.connect()
        client.write_registers(RUDDER, floats(7.5, 0.25), slave=1)
        client.write_register(COMMIT, 1, slave=1)
        until("registers", lambda: daemon.state()["ownShip"]["rudder"] == 7.5)
        check(daemon.state()["ownShip"]["throttle"] == 0.25, "throttle")
        client.close()
        print("== the console falls silent, a host takes the lead", flush=True)
        console.stop()
        until("the lever's safe value",
              lambda: daemon.state()["ownShip"].get("throttle") == 0)
        sender.sendto(sentence("HEHDT,123.0,T"), ("127.0.0.1", nmea))
        until("NMEA leads", lambda: not daemon.state()["ownShip"]["on"])
        check(abs(ship(daemon)["heading"] - 123) < 60, "its heading")
        sender.close()
    print("== replay", flush=True)
    with Daemon() as daemon:
        again = replayed(daemon, log, folder, "--at",
                         ",".join(repr(t) for t in pictures))
        for i, (time_s, picture) in enumerate(pictures.items()):
            check(again[i] == picture, f"the frame of {time_s} s")
        check(replayed(daemon, log, folder, "--every", "0.5") ==
              replayed(daemon, log, folder, "--every", "0.5"), "in a row")


def restart(folder):
    """The state file carries the motion over a restart."""
    state = os.path.join(folder, "state")
    with Daemon("--state", state) as daemon:
        daemon.patch({"ownShip": {"on": True, "throttle": 1},
                      "clock": {"mode": "STEPPED"}})
        for _ in range(3):
            daemon.request("POST", "/v1/clock/step", {"seconds": 9})
        answer = daemon.request("POST", "/v1/clock/step", {"seconds": 11})
        check(answer.status == 400, "no longer step")
        before = daemon.state()
    with Daemon("--state", state) as daemon:
        check(daemon.state()["entities"] == before["entities"], "the pose")
        check(daemon.state()["ownShip"] == before["ownShip"], "the rates")
        daemon.patch({"clock": {"mode": "FREE"}, "views": VIEW})
        time.sleep(0.3)
    # A recording that begins under way, in the middle of a roll.
    log = os.path.join(folder, "under-way.pelog")
    with Daemon("--state", state, "--record", log) as daemon:
        time.sleep(0.5)
        daemon.patch({"sky": {"sunElevation": 30}})
        at = daemon.state()["clock"]["time"]
        picture = daemon.get(f"/v1/views/bridge/frame.png?time={at!r}").body
    with Daemon() as daemon:
        check(replayed(daemon, log, folder, "--at", repr(at)) == [picture],
              "the frame under way")


def main():
    logging.disable(logging.CRITICAL)
    with tempfile.TemporaryDirectory(prefix="pelagos-ownship-") as folder:
        for part in (console_alone, restart):
            print(f"== {part.__name__}", flush=True)
            part(folder)


if __name__ == "__main__":
    sys.exit(main())
