#!/usr/bin/python3
"""--record and pelagosctl replay: the same frames again, bit for bit."""
import glob
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time

from pymodbus.client import ModbusTcpClient

import cigi_host as cigi
from modbus_test import check, floats
from pelagos_daemon import (BIN, SLOW_S, Daemon, free_port, log_entries, schema,
                            until)

VIEW = {"views": {"bridge": {"width": 160, "height": 90, "up": 12}}}
WIND, COMMIT = 10, 5


def sentence(body):
    total = 0
    for c in body.encode():
        total ^= c
    return f"${body}*{total:02X}\r\n".encode()


def ctl(daemon, *words, status=0):
    done = subprocess.run(
        [os.path.join(BIN, "pelagosctl"), "--timeout", f"{SLOW_S:.0f}", "--server",
         f"tcp:127.0.0.1:{daemon.tcp_port}", *words],
        capture_output=True, text=True, timeout=300, check=False)
    check(done.returncode == status,
          f"{words}: {done.returncode} {done.stdout} {done.stderr}")
    return done.stdout + done.stderr


def entries(path):
    pb = schema()
    with open(path, "rb") as f:
        return [pb.LogEntry.FromString(entry) for entry in log_entries(f.read())]


def segments(log):
    """The files of a recording, the oldest first."""
    return sorted(glob.glob(log + ".0*")) + [log]


def settle(daemon):
    """Seas are built beside: one that is committed between the question for
    the time and that for a picture of it is in the picture, and later than it
    in the log."""
    until("its sea is built", lambda:
          daemon.metrics()["pelagos_scene_waiting"] == 0)


def session(log):
    """A free-running session by three inputs, ended by kill -9. Returns
    pictures taken on the way: {simulated time: PNG}."""
    modbus, nmea = free_port(), free_port(socket.SOCK_DGRAM)
    pictures = {}
    daemon = Daemon("--record", log, "--modbus", f"127.0.0.1:{modbus}",
                    "--nmea", f"127.0.0.1:{nmea}")
    try:
        daemon.patch(VIEW)
        client = ModbusTcpClient("127.0.0.1", port=modbus)
        client.connect()
        sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        for i in range(8):
            daemon.patch({"sky": {"sunElevation": 10 + 3 * i},
                          "entities": {"1": {"speed": 6, "turnRate": 3.3}}})
            sender.sendto(sentence(f"HEHDT,{40 + 3.3 * i:.1f},T"),
                          ("127.0.0.1", nmea))
            client.write_registers(WIND, floats(6 + i, 200 + i), slave=1)
            client.write_register(COMMIT, 1, slave=1)
            # The sentence comes by UDP: it may be read last.
            until("its heading is there", lambda n=i + 1: daemon.metrics()[
                "pelagos_nmea_edits_total"] >= n)
            settle(daemon)
            # Later than every command until now, earlier than the next one.
            at = daemon.state()["clock"]["time"]
            answer = daemon.get(f"/v1/views/bridge/frame.png?time={at!r}")
            check(answer.status == 200, f"{answer}")
            pictures[at] = answer.body
            time.sleep(0.05)
        check(daemon.patch({"sea": {"windSpeed": 99}}).status == 400, "refused")
        client.close()
        sender.close()
        revision = int(daemon.state()["revision"])
    finally:
        daemon.stop(signal.SIGKILL)
    read = entries(log)
    patches = [e for e in read if e.HasField("patch")]
    check(read[0].head.device and read[0].head.waves == 60, "the head")
    check(patches[-1].revision == revision,
          "what was accepted before kill -9 is there")
    check(len(patches) == revision - read[0].revision, "every edit, once")
    tell_size(log, read)
    return pictures


def tell_size(log, read):
    size = os.path.getsize(log)
    head = len(read[0].SerializeToString())
    print(f"  {len(read) - 1} commands in {size} bytes: "
          f"{(size - head) / (len(read) - 1):.1f} bytes a command behind a "
          f"head of {head}")


def session_of_a_host(log):
    """A CIGI host leads; Modbus and HTTP edit too. Ended by kill -9. Its frames
    are nine seconds long: while the machine is busy time goes on by itself for
    one, which is before the next."""
    modbus, cigi_port = free_port(), free_port(socket.SOCK_DGRAM)
    pictures, revisions = {}, {}
    daemon = Daemon("--record", log, "--modbus", f"127.0.0.1:{modbus}",
                    "--cigi", f"127.0.0.1:{cigi_port}",
                    "--cigi-silence", "3600")
    host = cigi.Host(("127.0.0.1", cigi_port), big=False, stamped=True)
    try:
        daemon.patch(VIEW)
        client = ModbusTcpClient("127.0.0.1", port=modbus)
        client.connect()
        host.ask(cigi.entity(1, 52.6, 5.2), cigi.atmosphere(20000, 7, 250),
                 cigi.view_control(0, 1, z=-11, yaw=10))
        for i in range(8):
            host.send(cigi.entity(1, 52.6 + 1e-4 * i, 5.2, 1, yaw=8 * i,
                                  pitch=i / 2, roll=-i),
                      cigi.rate(1, x=6, yaw=2),
                      cigi.wave(i % 3, 0.5 + i / 10, 6 + i, 30 * i),
                      cigi.maritime(60, height=i / 8),
                      *([cigi.component(5, 1)] if i == 4 else []),
                      cigi.hat_hot(i, 52.6, 5.2), ticks=900000)
            host.settle()
            settle(daemon)
            client.write_registers(WIND, floats(6 + i, 200 + i), slave=1)
            client.write_register(COMMIT, 1, slave=1)
            daemon.patch({"sky": {"sunElevation": 10 + 3 * i}})
            answer = daemon.get("/v1/views/bridge/frame.png")
            check(answer.status == 200, f"{answer}")
            at = float(answer.headers["X-Pelagos-Time"])
            pictures[at] = answer.body
            revisions[at] = int(answer.headers["X-Pelagos-Revision"])
        client.close()
        state = daemon.state()
    finally:
        daemon.stop(signal.SIGKILL)
        host.close()
    read = entries(log)
    for e in read:
        if e.HasField("patch"):
            check(e.revision <= revisions.get(e.time, e.revision),
                  f"revision {e.revision}, behind the picture of its time")
    check(len(pictures) == 8, f"pictures of {list(pictures)}")
    check(state["clock"]["mode"] == "HOST", "session")
    check(read[-1].revision == int(state["revision"]), "all of it is there")
    tell_size(log, read)
    return pictures


def replayed(daemon, log, folder, *options):
    """log: a file, or several"""
    out = os.path.join(folder, "frames")
    logs = [log] if isinstance(log, str) else log
    ctl(daemon, "replay", *logs, "--frames", out, *options)
    files = sorted(glob.glob(out + "/*.png"))
    pictures = []
    for name in files:
        with open(name, "rb") as f:
            pictures.append(f.read())
        os.unlink(name)
    return pictures


def same_frames(folder):
    log = os.path.join(folder, "session.pelog")
    pictures = session(log)
    at = ["--at", ",".join(repr(t) for t in pictures)]
    with Daemon() as daemon:
        first = replayed(daemon, log, folder, *at)
        check(len(first) == len(pictures), f"{len(first)} frames")
        check(len(set(first)) == len(first), "every frame differs")
        for i, (time_s, picture) in enumerate(pictures.items()):
            check(first[i] == picture, f"the frame of {time_s} s")
        # On top of what the first replay left, and of something else.
        daemon.patch({"entities": {"7": {"name": "other"}},
                      "sky": {"visibility": 900}, "clock": {"mode": "FREE"}})
        check(replayed(daemon, log, folder, *at) == first, "a second time")
        rows = replayed(daemon, log, folder, "--every", "0.25")
        check(len(rows) >= 3 and len(set(rows)) == len(rows), "frames in a row")
    with Daemon("--encoder-threads", "1", "--unix", "off") as daemon:
        check(replayed(daemon, log, folder, *at) == first, "another daemon")
        paced = replayed(daemon, log, folder, "--every", "0.25", "--speed",
                         "2")
        check(paced == rows, "paced")


def same_frames_of_a_host(folder):
    """Again bit for bit, whatever the number of threads that draw."""
    log = os.path.join(folder, "host.pelog")
    pictures = session_of_a_host(log)
    at = ["--at", ",".join(repr(t) for t in pictures)]
    for threads in ("1", "2", "8"):
        os.environ["LP_NUM_THREADS"] = threads
        try:
            with Daemon("--encoder-threads", threads) as daemon:
                again = replayed(daemon, log, folder, *at)
        finally:
            del os.environ["LP_NUM_THREADS"]
        check(len(set(again)) == 8, "every frame differs")
        for i, (time_s, picture) in enumerate(pictures.items()):
            check(again[i] == picture,
                  f"the frame of {time_s} s with {threads} threads")


def long_session(log):
    """Own ship sails among sixty others: first on a clock that is stepped,
    then on one that runs, over several segments. Ended by kill -9."""
    modbus = free_port()
    pictures = {}
    daemon = Daemon("--record", log, "--record-segment", "0.0625",
                    "--modbus", f"127.0.0.1:{modbus}")

    def edit(i):
        daemon.patch({"entities": {
            str(100 + k): {"latitude": 52.6 + 2e-4 * k, "speed": 5 + k % 7,
                           "longitude": 5.2 + 1e-5 * i, "heading": i % 360}
            for k in range(60)}})

    try:
        daemon.patch({**VIEW, "clock": {"mode": "STEPPED"},
                      "ownShip": {"on": True, "throttle": 0.7, "rudder": 5}})
        client = ModbusTcpClient("127.0.0.1", port=modbus)
        client.connect()
        for i in range(150):
            if i < 100:
                daemon.request("POST", "/v1/clock/step", {"seconds": 0.137})
            edit(i)
            if i == 100:
                # A moment just past would be another one of own ship.
                daemon.patch({"clock": {"mode": "FREE"},
                              "ownShip": {"on": False}})
            if i % 10 == 0:
                client.write_registers(WIND, floats(6 + i / 20, i), slave=1)
                client.write_register(COMMIT, 1, slave=1)
                settle(daemon)
                at = daemon.state()["clock"]["time"]
                answer = daemon.get(
                    f"/v1/views/bridge/frame.png?time={at!r}")
                check(answer.status == 200, f"{answer}")
                pictures[at] = answer.body
        client.close()
        revision = int(daemon.state()["revision"])
        metrics = daemon.metrics()
    finally:
        daemon.stop(signal.SIGKILL)
    check(metrics["pelagos_record_lost_total"] == 0
          and metrics["pelagos_record_segments_total"] == len(segments(log)),
          f"{metrics}")
    return pictures, revision


def turns(folder):
    """A session over several segments: all of them, and each alone, give its
    frames again bit for bit."""
    log = os.path.join(folder, "turns.pelog")
    pictures, revision = long_session(log)
    names = segments(log)
    heads = [entries(name)[0] for name in names]
    check(len(names) >= 5, f"only {len(names)} segments")
    check([h.head.segment for h in heads] == list(range(1, len(names) + 1)),
          "numbered")
    read = [e for name in names for e in entries(name)]
    edits = [e.revision for e in read if e.HasField("patch")]
    check(edits == list(range(edits[0], revision + 1)),
          "an edit lost at a turn, or twice there")
    sizes = [os.path.getsize(name) for name in names]
    print(f"  {len(edits)} edits in segments of {sizes} bytes; heads of "
          f"{[len(h.SerializeToString()) for h in heads]}")
    alone = 0
    with Daemon() as daemon:
        again = replayed(daemon, names[::-1], folder, "--at",
                         ",".join(repr(t) for t in pictures))
        for got, (time_s, picture) in zip(again, pictures.items(),
                                          strict=True):
            check(got == picture, f"the frame of {time_s} s, all segments")
        for i, name in enumerate(names):
            end = heads[i + 1].time if i + 1 < len(names) else float("inf")
            own = {t: p for t, p in pictures.items()
                   if heads[i].time <= t < end}
            alone += len(own)
            if own:
                got = replayed(daemon, name, folder, "--at",
                               ",".join(repr(t) for t in own))
                check(got == list(own.values()), f"{name} alone")
        check(alone == len(pictures), "each picture is of a segment")
        before = daemon.state()["revision"]
        said = ctl(daemon, "replay", names[0], names[2], status=1)
        check("segment 2 is missing" in said, said)
        said = ctl(daemon, "replay", names[0], names[0], status=1)
        check("both segment 1" in said, said)
        other = os.path.join(folder, "session.pelog")
        said = ctl(daemon, "replay", names[0], other, status=1)
        check("two recordings" in said, said)
        check(daemon.state()["revision"] == before, "nothing was changed")


def clock_set_back(folder):
    """Steps by a client, a clock set back and forth, an edit at one moment."""
    log = os.path.join(folder, "steps.pelog")
    with Daemon("--record", log) as daemon:
        daemon.patch({**VIEW, "clock": {"mode": "STEPPED", "time": 100}})
        for seconds in (0.1, 0.2, 1 / 3):
            daemon.request("POST", "/v1/clock/step", {"seconds": seconds})
        daemon.patch({"clock": {"time": 20}, "sea": {"windSpeed": 15}})
        daemon.request("POST", "/v1/clock/step", {"until": 21.7})
        answer = daemon.request("POST", "/v1/clock/step", {"until": 21})
        check(answer.status == 400
              and answer.json()["path"] == "step.until", f"{answer}")
        daemon.patch({"entities": {"1": {"speed": 9, "heading": 50}}})
        daemon.request("POST", "/v1/clock/step", {"seconds": 2})
        picture = daemon.get("/v1/views/bridge/frame.png").body
        state = daemon.state()
        check(state["clock"]["time"] == 23.7, "time")
    with Daemon() as daemon:
        check(replayed(daemon, log, folder, "--at", "23.7")[0] == picture,
              "the last frame")
        again = daemon.state()
        for part in ("sea", "sky", "entities", "views", "clock"):
            check(again[part] == state[part], part)
        said = json.loads(ctl(daemon, "replay", log, "--json", "--quiet"))
        check(said == {"commands": 9, "time": 23.7, "frames": 0}, said)


def refused(folder):
    log = os.path.join(folder, "steps.pelog")
    with open(log, "rb") as f:
        good = f.read()
    bad = os.path.join(folder, "bad.pelog")

    def write(data):
        with open(bad, "wb") as f:
            f.write(data)

    with Daemon() as daemon:
        write(good + b"\xff" * 6)
        check("entry 11" in ctl(daemon, "replay", bad, status=1), "no length")
        before = daemon.state()["revision"]
        write(good[:-5] + b"\xff" * 5)
        check("entry" in ctl(daemon, "replay", bad, status=1), "garbage")
        write(good[:40])
        ctl(daemon, "replay", bad, status=1)
        write(good.replace(b"PELOG2", b"PELOG3", 1))
        check("version 3" in ctl(daemon, "replay", bad, status=1), "newer")
        middle = len(good) // 2
        write(good[:middle] + bytes([good[middle] ^ 4]) + good[middle + 1:])
        check("checksum" in ctl(daemon, "replay", bad, status=1), "flipped")
        ctl(daemon, "replay", log, "--loop", status=2)
        ctl(daemon, "replay", log, "--at", "3,2", status=2)
        check(daemon.state()["revision"] == before, "nothing was changed")
        write(good[:-3])
        check("left out" in ctl(daemon, "replay", bad), "a torn end")


def kept(folder):
    """A restart keeps the earlier log."""
    log = os.path.join(folder, "steps.pelog")
    size = os.path.getsize(log)
    with Daemon("--record", log) as daemon:
        check(daemon.metrics()["pelagos_record_active"] == 1, "active")
        check(os.path.getsize(log + ".000001") == size, "kept")
    try:
        Daemon("--record", "/proc/nowhere/log")
    except RuntimeError as error:
        check("--record" in str(error), f"{error}")
    else:
        raise AssertionError("a log that cannot be written")


def main():
    with tempfile.TemporaryDirectory(prefix="pelagos-replay-") as folder:
        for part in (same_frames, same_frames_of_a_host, turns,
                     clock_set_back, refused, kept):
            print(f"== {part.__name__}", flush=True)
            part(folder)


if __name__ == "__main__":
    sys.exit(main())
