#!/usr/bin/python3
"""The control thread builds no sea and reads none while everybody asks for
other ones: spectra by random seed, a slider of the wind, light of other seas.
Nor does it read long bodies, write long answers or read files of exercises:
while others ask for as much as they may, and an instructor edits, nothing takes it more than about a millisecond of its own processor time.
What it does is told by its own counters: load does not change what they say."""
import json
import os
import random
import shutil
import sys
import tempfile
import threading
import time

from pymodbus.client import ModbusTcpClient

from modbus_test import COMMIT, WIND, check, floats
from pelagos_daemon import ROOT, SANITIZED, SLOW_S, Daemon, free_port, until


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


def clock(daemon):
    return daemon.state()["clock"]["time"]


def own_ship(daemon):
    """It sails on a sea of FFT: a thread takes its steps, five a second, ahead
    of the control thread, which may have to take the first."""
    answer = daemon.request("PATCH", "/v1/state", {
        "clock": {"mode": "FREE", "rate": 1},
        "ownShip": {"on": True, "throttle": 0.8}})
    check(answer.status == 200, f"{answer.body[:200]}")
    before = daemon.state()
    until("it is ahead", lambda: work(daemon).get("own ship ahead", 0) > 0)
    until("it pitches", lambda: daemon.state()["entities"][0]["pitch"] !=
          before["entities"][0]["pitch"])

    def is_ahead():
        """For two seconds. A machine that gives the thread no processor for
        longer than it is ahead leaves steps to the control thread meanwhile."""
        first, begun = work(daemon).get("own ship", 0), clock(daemon)
        time.sleep(2)
        took = work(daemon).get("own ship", 0) - first
        steps = (clock(daemon) - begun) / 0.2
        print(f"  own ship: {took:.0f} steps of {steps:.0f} on the control "
              "thread")
        # A sanitizer's thread does not keep ahead of it.
        return SANITIZED or took < 0.2 * steps
    until("the steps are taken ahead", is_ahead)


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


# --- what others may ask for -------------------------------------------------

# A millisecond is what a dispatch may take. The test lets four pass, since the
# processor's clock counts what a virtual machine takes away and what another
# thread of the same core slows down; before, the least of these took 6.6, the
# most 5,900 ms.
MOST_MS = 4.0
# This loop takes 25 ms of a core of 2024; on a slower one all takes longer.
LOOP, LOOP_MS = 1_000_000, 25.0
TOKENS = {role: role + "-token-0123456789" for role in ("watch", "instruct")}


def slower():
    begun = time.thread_time()
    total = 0
    for i in range(LOOP):
        total += i
    took_ms = (time.thread_time() - begun) * 1e3
    return max(1.0, took_ms / LOOP_MS)


def asked(daemon, role, *request, timeout=SLOW_S):
    return daemon.request(*request, timeout=timeout, headers={
        "Authorization": "Bearer " + TOKENS[role]})


def largest_patch(turn):
    """As much as a body may hold: every entity and view that there can be."""
    change = {
        "entities": {str(i): {
            "name": f"ship {i}", "latitude": 52.6 + i * 1e-4,
            "longitude": 5.2 - i * 1e-4, "speed": i % 20,
            "heading": (turn + 1.375 * i) % 360,
            "course": (turn + 1.375 * i) % 360, "model": {"name": "tug"},
            "afloat": True, "wake": i < 8, "turnRate": i % 3,
            "climbRate": 0, "rollRate": 0.5} for i in range(1, 257)},
        "views": {f"v{i}": {"entity": 1 + i, "yaw": (turn + i) % 360,
                            "width": 64, "height": 48} for i in range(63)}}
    body = json.dumps(change, separators=(",", ":"))
    check(50000 < len(body) <= 65536, f"{len(body)} bytes")
    return body


def longest(daemon):
    """ms of processor of the longest dispatch, and whose it was."""
    text = asked(daemon, "instruct", "GET", "/metrics").body.decode()
    name = "pelagos_control_processor_longest_seconds{"
    return max((float(line.rsplit(" ", 1)[1]) * 1e3, line.split('"')[1])
               for line in text.splitlines() if line.startswith(name))


def flood(daemon, role, *request):
    def run():
        for _ in range(6):
            # Questions behind pictures get what others leave of the machine.
            answer = asked(daemon, role, *request, timeout=10 * SLOW_S)
            check(answer.status in (200, 429, 503), f"{answer}")
    return run


def edits(daemon, waits, body=None):
    def run():
        for i in range(12):
            begun = time.monotonic()
            answer = asked(daemon, "instruct", "PATCH", "/v1/state",
                           body(i) if body else
                           {"entities": {"1": {"speed": i}}})
            waits.append((time.monotonic() - begun) * 1e3)
            check(answer.status == 200, f"{answer}")
            check(body or answer.json()["entities"][0]["speed"] == i,
                  "an answer shows its own edit")
            check(asked(daemon, "watch", "GET", "/healthz").status == 200,
                  "/healthz")
    return run


def behind_pictures(daemon):
    """A watcher's questions beyond its share are answered behind pictures."""
    text = asked(daemon, "instruct", "GET", "/metrics").body.decode()
    name = 'pelagos_surface_processor_seconds_total{lane="'
    used = {line.split('"')[1]: float(line.rsplit(" ", 1)[1])
            for line in text.splitlines() if line.startswith(name)}
    print(f"  surface, seconds of processor: {used}")
    check(used["behind"] > 0, f"{used}")


def under_flood(tokens, folder, name, attacks, body=None):
    """Each kind has a daemon of its own, whose longest dispatch it is."""
    with Daemon("--token-file", tokens, "--exercises", folder) as daemon:
        waits = []
        asked(daemon, "instruct", "PATCH", "/v1/state", largest_patch(0))
        side_by_side(*(flood(daemon, *one) for one in attacks),
                     edits(daemon, waits, body))
        took, what = longest(daemon)
        if any("/v1/surface" in one for one in attacks):
            behind_pictures(daemon)
        waits.sort()
        print(f"  {name}: longest dispatch {took:.2f} ms ({what}); edits "
              f"{waits[len(waits) // 2]:.0f} ms, {waits[-1]:.0f} at most")
        return name, took, what


def nobody_is_kept_waiting():
    folder = tempfile.mkdtemp(prefix="pelagos-control-")
    tokens = os.path.join(folder, "tokens")
    with open(tokens, "w", encoding="ascii") as f:
        f.writelines(f"{t} {r} of-{r}\n" for r, t in TOKENS.items())
    os.chmod(tokens, 0o600)
    exercises = os.path.join(folder, "exercises")
    os.mkdir(exercises)
    with open(os.path.join(ROOT, "clients/exercises/crossing.json"),
              encoding="utf-8") as f:
        text = f.read().rstrip()
    for i in range(20):
        with open(f"{exercises}/e{i}.json", "w", encoding="utf-8") as f:
            f.write(text[:-1] + " " * (700_000 - len(text)) + "}")
    points = {"points": [[i % 100, i // 100] for i in range(10000)]}
    slow = slower()
    found = [under_flood(tokens, exercises, *one) for one in (
        ("surface of 10,000 points",
         [("watch", "POST", "/v1/surface", points)] * 6),
        ("the whole state", [("watch", "GET", "/v1/state"),
                             ("watch", "GET", "/v1/views"),
                             ("watch", "GET", "/v1/state/entities")] * 3),
        ("exercises", [("instruct", "GET", "/v1/exercises"),
                       ("instruct", "GET", "/v1/exercises/e3")] * 2),
        ("the largest patch", [], largest_patch))]
    shutil.rmtree(folder)
    # The slower of before and after: others may come meanwhile.
    bar = MOST_MS * max(slow, slower()) * (40 if SANITIZED else 1)
    for name, took, what in found:
        check(took < bar, f"{name}: {took:.1f} ms of the control thread by "
                          f"\"{what}\", {bar:.1f} at most")


def main():
    nobody_is_kept_waiting()
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
    print("control_test: the control thread built none of some 100 seas, and "
          "waited for nobody's questions")
    return 0


if __name__ == "__main__":
    sys.exit(main())
