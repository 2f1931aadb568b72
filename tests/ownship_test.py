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


def place(daemon, entity):
    return next(e for e in daemon.state()["entities"] if e["id"] == entity)


def heard(receiver):
    text = receiver.recv(4096).decode()
    return [line.split("*")[0].split(",") for line in text.split()]


def two_ships(folder):
    """Two helms on two Modbus units, and NMEA of each to its own plotter;
    a third behind the same console as a unit of its own."""
    state, log, table = (os.path.join(folder, n)
                         for n in ("two", "two.pelog", "two-table"))
    with open(table, "w") as f:
        f.write("holding 0 i16 entities.9.helm.rudder scale=0.01 unit=3\n")
    modbus, console_port = free_port(), free_port()
    console = Console(console_port)
    plotters = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
                for _ in range(2)]
    for plotter in plotters:
        plotter.bind(("127.0.0.1", 0))
        plotter.settimeout(60)
    ports = [p.getsockname()[1] for p in plotters]
    pictures = {}
    with Daemon("--modbus", f"127.0.0.1:{modbus}", "--modbus-units",
                "1:abcd:1,2:abcd:7", "--modbus-heartbeat", "60000",
                "--console", f"127.0.0.1:{console_port}", "--console-table",
                table, "--nmea-out",
                f"127.0.0.1:{ports[0]},7@127.0.0.1:{ports[1]}",
                "--nmea-out-rate", "10", "--state", state,
                "--record", log) as daemon:
        daemon.patch({
            "entities": {"7": {"name": "tug", "model": {"name": "tug"}},
                         "9": {"name": "launch", "longitude": 5.21,
                               "helm": {"on": True}}},
            "views": {**VIEW, "tug": {"entity": 7, **VIEW["bridge"]}},
            "clock": {"rate": 2}, "sea": {"windSpeed": 10}})
        client = ModbusTcpClient("127.0.0.1", port=modbus)
        client.connect()
        for unit, rudder in ((1, 20), (2, -20)):
            client.write_register(90, 1, slave=unit)
            client.write_registers(RUDDER, floats(rudder, 0.9), slave=unit)
            answer = client.write_register(COMMIT, 1, slave=unit)
            check(not answer.isError(), f"{answer}")
        console.set("holding", 0, 1500)
        until("to starboard", lambda: 5 < place(daemon, 1)["heading"] < 180)
        until("to port", lambda: 180 < place(daemon, 7)["heading"] < 355)
        until("the console's unit",
              lambda: place(daemon, 9)["helm"]["rudder"] == 15)
        check(daemon.state()["ownShip"]["rudder"] == 20, "own ship's orders")
        check(place(daemon, 7)["helm"]["rudder"] == -20, "the tug's")
        rudder = client.read_holding_registers(RUDDER, 2, slave=2).registers
        check(rudder == floats(-20), f"read back {rudder}")
        client.close()
        for plotter, order in zip(plotters, ("20.0", "-20.0")):
            until(f"its plotter hears {order}", lambda p=plotter, o=order: any(
                s[:2] == ["$AGRSA", o] for s in heard(p)))
        # Behind what waited in the sockets no other ship's.
        for plotter, order in zip(plotters, ("20.0", "-20.0")):
            rudders = {s[1] for _ in range(5) for s in heard(plotter)
                       if s[0] == "$AGRSA"}
            check(rudders <= {order}, f"{rudders}")
        # A moment long past is not kept: no frame may come late.
        daemon.patch({"clock": {"mode": "STEPPED"}})
        for i in range(3):
            daemon.request("POST", "/v1/clock/step", {"seconds": 0.7})
            at = daemon.state()["clock"]["time"]
            for view in ("bridge", "tug"):
                answer = daemon.get(f"/v1/views/{view}/frame.png?time={at!r}")
                check(answer.status == 200, f"{answer}")
                pictures.setdefault(view, {})[at] = answer.body
            # Another's edit leaves the tug on her way.
            daemon.patch({"ownShip": {"rudder": 15 - i}})
    for plotter in plotters:
        plotter.close()
    console.stop()
    with Daemon("--state", state) as daemon:
        check(place(daemon, 7)["helm"]["on"] and
              place(daemon, 7)["helm"]["rudder"] == -20, "the helm is kept")
        daemon.patch({"clock": {"mode": "FREE"}})
        moved = place(daemon, 7)["longitude"]
        until("she goes on", lambda: place(daemon, 7)["longitude"] != moved)
    with Daemon() as daemon:
        for _ in range(2):  # the second finds the ships under way
            for view, drawn in pictures.items():
                again = replayed(daemon, log, folder, "--view", view, "--at",
                                 ",".join(repr(t) for t in drawn))
                check(again == list(drawn.values()), f"frames of {view}")


def main():
    logging.disable(logging.CRITICAL)
    with tempfile.TemporaryDirectory(prefix="pelagos-ownship-") as folder:
        for part in (console_alone, restart, two_ships):
            print(f"== {part.__name__}", flush=True)
            part(folder)


if __name__ == "__main__":
    sys.exit(main())
