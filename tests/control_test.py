#!/usr/bin/python3
"""The control thread builds no sea and reads none while everybody asks for
other ones: spectra by random seed, a slider of the wind, light of other seas.
What it does is told by its own counters: load does not change what they say."""
import random
import sys
import threading
import time

from pymodbus.client import ModbusTcpClient

from modbus_test import COMMIT, WIND, check, floats
from pelagos_daemon import SANITIZED, Daemon, free_port, until


def work(daemon):
    """name: how often the control thread did it."""
    text = daemon.get("/metrics").body.decode()
    found = {}
    for line in text.splitlines():
        if line.startswith("pelagos_control_work_total{"):
            name, value = line.rsplit(" ", 1)
            found[name.split('"')[1]] = float(value)
    return found


def side_by_side(*jobs):
    faults = []

    def run(job):
        try:
            job()
        except Exception as e:  # noqa: BLE001
            faults.append(e)

    threads = [threading.Thread(target=run, args=(job,)) for job in jobs]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    check(not faults, f"{faults[:1]}")


def spectra(daemon, seed):
    def run():
        choice = random.Random(seed)
        for _ in range(8):
            answer = daemon.request("POST", "/v1/spectrum", {"patch": {
                "state": {"sea": {"seed": choice.randrange(1 << 31)}}}})
            check(answer.status == 200, f"{answer.body[:200]}")
    return run


def slider(daemon):
    def run():
        for i in range(30):
            wind = 5 + 0.2 * i
            answer = daemon.request("PATCH", "/v1/state",
                                    {"sea": {"windSpeed": wind}})
            check(answer.status == 200, f"{answer.body[:200]}")
            check(answer.json()["sea"]["windSpeed"] == wind,
                  "a reply shows the patch that it is the reply to")
    return run


def light(daemon):
    def run():
        for i in range(8):
            answer = daemon.get(f"/v1/optics/brdf?viewZenith=70&sea.seed={i}")
            check(answer.status == 200, f"{answer.body[:200]}")
    return run


def own_ship(daemon):
    """It sails on a sea of FFT: a thread takes its steps, five a second, ahead
    of the control thread, which may have to take the first."""
    answer = daemon.request("PATCH", "/v1/state", {
        "clock": {"mode": "FREE", "rate": 1},
        "ownShip": {"on": True, "throttle": 0.8}})
    check(answer.status == 200, f"{answer.body[:200]}")
    before = daemon.state()
    until("it is ahead", lambda: work(daemon).get("own ship ahead", 0) > 0)
    first = work(daemon).get("own ship", 0)
    time.sleep(4)
    now = daemon.state()
    took = work(daemon).get("own ship", 0) - first
    seconds = now["clock"]["time"] - before["clock"]["time"]
    check(now["entities"][0]["pitch"] != before["entities"][0]["pitch"],
          "it pitches")
    print(f"  own ship: {took:.0f} steps of {seconds / 0.2:.0f} on the control "
          "thread")
    # A sanitizer's thread does not keep ahead of it.
    check(SANITIZED or took < 0.2 * seconds / 0.2, f"{took} in {seconds} s")


def winds_by_modbus(daemon, port):
    """Own ship sails on: its next sea is built before the commit, and answers
    tell what is in effect."""
    client = ModbusTcpClient("127.0.0.1", port=port)
    client.connect()
    for i in range(5):
        client.write_registers(WIND, floats(6 + i, 200), slave=1)
        check(not client.write_register(COMMIT, 1, slave=1).isError(), "commit")
        check(daemon.state()["sea"]["windSpeed"] == 6 + i, "it is in effect")
    client.close()
    check("sea" not in work(daemon), f"{work(daemon)}")


def main():
    modbus = free_port()
    with Daemon("--modbus", f"127.0.0.1:{modbus}") as daemon:
        daemon.request("PATCH", "/v1/state", {"sea": {"synthesiser": "FFT"}})
        side_by_side(*(spectra(daemon, i) for i in range(8)), slider(daemon),
                     light(daemon))
        did = work(daemon)
        print(did)
        check(did["http"] > 100, "the control thread is watched")
        check(did["spectra"] == 64, f"{did}")
        check("sea" not in did, f"{did}")
        check("surface" not in did, f"{did}")
        own_ship(daemon)
        winds_by_modbus(daemon, modbus)
    print("control_test: the control thread built none of some 100 seas")
    return 0


if __name__ == "__main__":
    sys.exit(main())
