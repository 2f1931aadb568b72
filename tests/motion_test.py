#!/usr/bin/python3
"""Ships in motion of every kind, under helms, adrift, moored, reckoned: the same
bits of a moment in any order of frames, in a replay, and after a restart."""
import os
import random
import shutil
import sys
import tempfile

from modbus_test import check
from pelagos_daemon import Daemon
from replay_test import replayed


def thing(model, north_m, east_m, **more):
    return {"model": {"name": model}, "latitude": 52.6 + north_m / 111194,
            "longitude": 5.2 + east_m / 67600, **more}


STATE = {
    "clock": {"mode": "STEPPED", "time": 100},
    "sea": {"windSpeed": 12}, "sky": {"sunElevation": 30, "sunAzimuth": 140},
    "ownShip": {"on": True, "throttle": 0.8, "rudder": 6},
    "views": {"bridge": {"width": 192, "height": 108, "up": 12}},
    "entities": {
        "7": thing("tug", 70, -30, heading=80, course=80,
                   helm={"on": True, "throttle": 1, "rudder": -15}),
        "8": thing("rib", 60, 20, afloat=True, leeway=0.05),
        "9": thing("sailing-yacht", 120, 30, afloat=True, mooring=30),
        "10": thing("safe-water", 50, -8, afloat=True, mooring=8),
        "11": thing("pilot-launch", 110, -10, afloat=True, speed=7, course=200,
                    heading=200, turnRate=3)}}


def frame(daemon, time_s):
    answer = daemon.get(f"/v1/views/bridge/frame.png?time={time_s!r}")
    check(answer.status == 200, f"{answer}")
    return answer.body


def any_order(daemon):
    """From now back and ahead, as far as own ships are kept and looked."""
    now = daemon.state()["clock"]["time"]
    times = [now + 0.31 * i for i in range(-5, 6)]
    first = {t: frame(daemon, t) for t in times}
    check(len(set(first.values())) == len(times), "all move")
    for seed in range(2):
        order = times[::-1]
        random.Random(seed).shuffle(order)
        for t in order:
            check(frame(daemon, t) == first[t], f"{t} s, order {seed}")
    return first


def main():
    with tempfile.TemporaryDirectory(prefix="pelagos-motion-") as folder:
        state, log = (os.path.join(folder, n) for n in ("state", "log.pelog"))
        drawn = {}
        with Daemon("--state", state, "--record", log) as daemon:
            daemon.patch(STATE)
            for i in range(4):
                daemon.request("POST", "/v1/clock/step", {"seconds": 2.3})
                drawn.update(any_order(daemon) if i == 2 else {})
                daemon.patch([{"entities": {"7": {"helm": {"rudder": 20}}}},
                              {"sea": {"level": 0.3}},
                              {"entities": {"8": {"leeway": 0.1}}},
                              {"clock": {"reckoning": 50}}][i])
                # A replay draws a moment with all that was said at it: the level
                # is in a frame's place, if not in its pixels.
                now = daemon.state()["clock"]["time"]
                drawn[now] = frame(daemon, now)
            before = daemon.state()
        last = max(drawn)
        print("== restart", flush=True)
        again = os.path.join(folder, "again")
        shutil.copy(state, again)
        pictures = []
        for path in (state, again):
            with Daemon("--state", path) as daemon:
                after = daemon.state()
                check(after["entities"] == before["entities"] and
                      after["ownShip"] == before["ownShip"], "the state")
                pictures.append(any_order(daemon))
        check(pictures[0] == pictures[1], "after a restart")
        print("== replay", flush=True)
        at = [100 + 2.3 * (i + 1) for i in range(4)]
        at = [min(drawn, key=lambda t, a=a: abs(t - a)) for a in at]
        check(last == at[-1], "the moments")
        with Daemon() as daemon:
            for _ in range(2):
                check(replayed(daemon, log, folder, "--at",
                               ",".join(map(repr, at))) ==
                      [drawn[t] for t in at], "frames")


if __name__ == "__main__":
    sys.exit(main())
