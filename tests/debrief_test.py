#!/usr/bin/python3
"""Recordings begun by clients, and the debrief: the pictures of any moment
again, bit for bit, while the live ones go on."""
import json
import os
import struct
import subprocess
import sys
import tempfile
import threading

from live_client import Live
from modbus_test import check
from pelagos_daemon import BIN, SANITIZED, Daemon, until

SIZE = {"width": 160, "height": 90, "up": 12}


def post(daemon, path, body, method="POST", status=200):
    answer = daemon.request(method, path, body)
    check(answer.status == status, f"{path} {body}: {answer}")
    return answer.json()


def record(daemon, **command):
    return post(daemon, "/v1/recording", command)


def debrief(daemon, status=200, **command):
    return post(daemon, "/v1/debrief", command, "PATCH", status)


def settled(daemon):
    """What the debrief is when it is neither busy nor on its way."""
    def look():
        now = daemon.get("/v1/debrief").json()
        return now if not now["busy"] and now["state"] not in (
            "OPENING", "CLOSING") else None
    return until("the debrief is there", look)


def opened(daemon, name):
    debrief(daemon, recording=name)
    now = settled(daemon)
    check(now["state"] == "OPEN", f"opened: {now}")
    return now


def at(daemon, **where):
    debrief(daemon, **where)
    now = settled(daemon)
    check("error" not in now, f"{now}")
    return now


def picture(daemon, place="", view="bridge", query=""):
    answer = daemon.get(f"/v1{place}/views/{view}/frame.png{query}")
    check(answer.status == 200, f"{place} {answer}")
    return answer.body


def step(daemon, until_s):
    post(daemon, "/v1/clock/step", {"until": until_s})


def voyage(daemon):
    """Recorded with a clock that is stepped; {time: picture}, and at the end
    the clock is set back."""
    pictures = {}
    daemon.patch({"clock": {"mode": "STEPPED", "time": 100},
                  "views": {"bridge": SIZE}})
    check(record(daemon, start="voyage")["writing"] == "voyage.pelog", "begun")
    post(daemon, "/v1/state", {"ownShip": {"on": True, "rudder": 5,
                                           "throttle": 0.5}}, "PATCH")
    for i in range(12):
        daemon.patch({"sky": {"sunElevation": 10 + 2 * i},
                      "sea": {"windSpeed": 6 + (i > 5) * 3}})
        until("its sea is built", lambda: daemon.metrics()[
            "pelagos_scene_waiting"] == 0)
        step(daemon, 101.0 + 1.7 * i)
        pictures[daemon.state()["clock"]["time"]] = picture(daemon)
        step(daemon, 101.1 + 1.7 * i)  # what comes next is later
    daemon.patch({"views": {"bow": {**SIZE, "yaw": 20}},
                  "entities": {"7": {"name": "tug", "model": {"name": "tug"},
                                     "latitude": 52.601, "longitude": 5.2}}})
    daemon.patch({"clock": {"time": 50}})
    step(daemon, 53)
    return pictures


def same_bits(daemon):
    pictures = voyage(daemon)
    back = picture(daemon)
    lists = record(daemon, stop=True)
    check("writing" not in lists, "ended")
    one = daemon.get("/v1/recordings").json()["recordings"][0]
    check(one["name"] == "voyage.pelog" and one["segments"] == 1
          and one["from"] == 100 and one["to"] == 53, f"{one}")
    now = opened(daemon, "voyage.pelog")
    check(now["time"] == 100 and now["sameDevice"], f"{now}")
    times = sorted(pictures)
    whole = times[-1] + 0.1 - 100 + 3
    check(abs(now["length"] - whole) < 1e-9, f"length {now['length']}")
    # To and fro: by what was kept on the way, and from the beginning.
    for t in times[::-1] + times[::3] + [times[1]]:
        check(at(daemon, time=t)["time"] == t, "its time")
        check(picture(daemon, "/debrief") == pictures[t],
              f"the picture of {t} is the live one")
    check(daemon.get("/v1/debrief/state").json()["sky"]["sunElevation"] == 12,
          "the state of then")
    now = at(daemon, position=whole)
    check(now["time"] == 53, f"{now}")
    check(picture(daemon, "/debrief") == back, "after the clock was set back")
    check(len(daemon.get("/v1/debrief/state").json()["views"]) == 2, "views")
    check(at(daemon, time=52)["position"] == whole - 1, "the last one of 52")
    print(f"  {len(times)} moments, to and fro: the same bits", flush=True)
    return pictures


def live_goes_on(daemon):
    """Streams of both, while the debrief plays: neither stops, and the live
    scene has its clock, its inputs and its revision to itself."""
    daemon.patch({"clock": {"mode": "FREE"}})
    before = int(daemon.state()["revision"])
    live = Live(daemon, "bridge")
    opened(daemon, "voyage.pelog")
    debrief(daemon, playing=True, rate=4)
    seen, ends = [], threading.Event()

    def watch():
        while not ends.is_set():
            head, _ = live.picture()
            live.ack(head)
            seen.append(head.time)
    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    moments = set()

    def both():
        now = daemon.get("/v1/debrief").json()
        moments.add(now["time"])
        return len(moments) >= 5 and len(set(seen)) >= 10
    until("live pictures and moments of the debrief", both)
    debrief(daemon, playing=False)
    then = settled(daemon)
    picture(daemon, "/debrief")
    check(picture(daemon, "/debrief") == picture(daemon, "/debrief"), "stands")
    check(settled(daemon)["time"] == then["time"], "it stands")
    check(int(daemon.state()["revision"]) == before, "live is untouched")
    ends.set()
    watcher.join()
    check(all(a <= b for a, b in zip(seen, seen[1:])), "live time goes on")
    print(f"  {len(seen)} live pictures, {len(moments)} moments looked at",
          flush=True)


def streams_end(daemon):
    """A viewer of the debrief is told when it closes; its memory comes back."""
    opened(daemon, "voyage.pelog")
    raw = daemon.connect_http()
    raw.sendall(b"GET /v1/debrief/views/bridge/mjpeg HTTP/1.1\r\n"
                b"Host: localhost\r\n\r\n")
    check(b"200" in raw.recv(64), "its stream")
    debrief(daemon, close=True)
    while raw.recv(65536):
        pass
    raw.close()
    check(settled(daemon)["state"] == "CLOSED", "closed")
    answer = daemon.get("/v1/debrief/views/bridge/frame.png")
    check(answer.status == 404 and b"no recording is open" in answer.body,
          f"{answer}")
    first = None
    for _ in range(4):
        opened(daemon, "voyage.pelog")
        picture(daemon, "/debrief")
        debrief(daemon, close=True)
        settled(daemon)
        first = first or daemon.rss()
    def grown():
        return (daemon.rss() - first) / 1e6
    # A renderer has over a hundred; what is freed goes back to the system every
    # ten seconds (PEL_HEAP_PAUSE_S), and a fourth renderer's may be on its way.
    until("closing gives its memory back", lambda: grown() < 60)
    print(f"  opened and closed again and again: {grown():+.1f} MB", flush=True)


def refused(daemon, folder):
    whole = os.path.join(folder, "voyage.pelog")
    with open(whole, "rb") as f:
        data = f.read()

    def made(name, bytes_):
        with open(os.path.join(folder, name), "wb") as f:
            f.write(bytes_)
    made("newer.pelog", b"PELOG9\r\n" + data[8:])
    middle = len(data) // 2
    made("damaged.pelog", data[:middle] + b"\xff" * 16 + data[middle + 16:])
    made("torn.pelog", data[:-3])
    with open(os.path.join(folder, "long.pelog"), "wb") as f:
        f.write(data)
        f.truncate((1 << 30) + 1)
    for name, words in (("none.pelog", "there is no recording"),
                        ("../voyage.pelog", "is no name of a recording"),
                        ("newer.pelog", "of version 9"),
                        ("damaged.pelog", "damaged.pelog: entry"),
                        ("long.pelog", "a debrief reads up to")):
        debrief(daemon, recording=name)
        now = settled(daemon)
        check(now["state"] == "FAILED" and words in now["error"],
              f"{name}: {now}")
        os.path.exists(os.path.join(folder, name)) and name[0] != "." and \
            os.remove(os.path.join(folder, name))
    with tempfile.TemporaryDirectory(prefix="pelagos-outside-") as outside:
        away = os.path.join(outside, "away.pelog")
        with open(away, "wb") as f:
            f.write(data)
        link = os.path.join(folder, "away.pelog")
        os.symlink(away, link)
        debrief(daemon, recording="away.pelog")
        now = settled(daemon)
        check(now["state"] == "FAILED" and
              "away.pelog is a link out of" in now["error"], f"{now}")
        names = [r["name"] for r in daemon.get(
            "/v1/recordings").json()["recordings"]]
        check("away.pelog" not in names, f"{names}")
        os.remove(link)
    link = os.path.join(folder, "within.pelog")
    os.symlink("torn.pelog", link)
    check("error" not in opened(daemon, "within.pelog"), "a link within")
    os.remove(link)
    answer = post(daemon, "/v1/recording", {"start": "-rf"}, status=400)
    check("neither . nor - first" in answer["detail"], f"{answer}")
    check("error" not in opened(daemon, "torn.pelog"), "up to where it is torn")
    os.remove(os.path.join(folder, "torn.pelog"))
    check("rate" in str(debrief(daemon, 400, rate=99)), "its range")
    debrief(daemon, 400, time=1, position=1)
    debrief(daemon, close=True)
    settled(daemon)
    check("no recording is open" in debrief(daemon, 409, time=1)["detail"],
          "nothing is open")
    post(daemon, "/v1/recording", {"start": "voyage"}, status=409)
    post(daemon, "/v1/recording", {"start": "../x"}, status=400)
    post(daemon, "/v1/recording", {"stop": True}, status=409)
    post(daemon, "/v1/recording", {}, status=400)
    record(daemon, start="second")
    answer = post(daemon, "/v1/recording", {"start": "third"}, status=409)
    check("second.pelog" in answer["detail"], f"{answer}")
    record(daemon, stop=True)


def by_pelagosctl(daemon, folder, pictures):
    def ctl(*words, status=0):
        done = subprocess.run(
            [os.path.join(BIN, "pelagosctl"), "--timeout", "60", "--server",
             f"tcp:127.0.0.1:{daemon.tcp_port}", *words],
            capture_output=True, text=True, timeout=300, check=False)
        check(done.returncode == status,
              f"{words}: {done.returncode} {done.stdout} {done.stderr}")
        return done.stdout
    check("voyage.pelog" in ctl("recordings"), "listed")
    ctl("recordings", "start", "by-hand")
    check("being written" in ctl("recordings"), "begun")
    ctl("recordings", "stop")
    ctl("debrief", "open", "nothing.pelog", status=4)
    ctl("debrief", "open", "voyage.pelog")
    time_s, expected = sorted(pictures.items())[4]
    told = json.loads(ctl("--json", "debrief", "go", repr(time_s)))
    check(told["time"] == time_s, f"{told}")
    out = os.path.join(folder, "then.png")
    ctl("frame", "bridge", out, "--debrief")
    with open(out, "rb") as f:
        check(f.read() == expected, "the same picture by pelagosctl")
    os.remove(out)
    ctl("debrief", "close")


def many_segments(daemon, folder):
    """A recording of several segments, played while it is still written."""
    daemon.patch({"clock": {"mode": "STEPPED", "time": 10},
                  "views": {"bow": None}})
    record(daemon, start="long-one")
    pictures = {}
    for i in range(40):
        for k in range(40):
            daemon.patch({"entities": {"1": {
                "heading": (i + k) % 360, "name": "x" * 50}}})
        step(daemon, 11.0 + i)
        if i % 9 == 0:
            pictures[11.0 + i] = picture(daemon)
        step(daemon, 11.5 + i)
    files = [n for n in os.listdir(folder) if n.startswith("long-one")]
    check(len(files) >= 3, f"segments: {files}")
    now = opened(daemon, "long-one.pelog")
    check(now["commands"] and now["length"] >= 39, f"{now}")
    for t in list(pictures)[::-1]:
        at(daemon, time=t)
        check(picture(daemon, "/debrief") == pictures[t], f"picture of {t}")
    # It goes on, and files get other names.
    for k in range(900):
        daemon.patch({"entities": {"1": {"heading": k % 360,
                                         "name": "y" * 50}}})
    t = min(pictures)
    at(daemon, time=t)
    check(picture(daemon, "/debrief") == pictures[t], "after other segments")
    record(daemon, stop=True)
    debrief(daemon, close=True)
    print(f"  {len(files)} segments", flush=True)


def varint(n):
    out = b""
    while n > 127:
        out += bytes([n & 127 | 128])
        n >>= 7
    return out + bytes([n])


def long_log(source, path, mib):
    """The head of a log, and steps of 64 KiB each (a field that nobody knows),
    in the form without checksums."""
    with open(source, "rb") as f:
        data = f.read()
    length = struct.unpack_from("<I", data, 40)[0]
    head = data[48:48 + length]
    rest = varint(1000 << 3 | 2) + varint(65536) + b"p" * 65536
    with open(path, "wb") as f:
        f.write(b"PELOG1\r\n" + varint(len(head)) + head)
        for k in range(16 * mib):
            t = struct.pack("<d", 100 + (k + 1) / 64)
            entry = b"\x09" + t + b"\x2a\x09\x11" + t + rest
            f.write(varint(len(entry)) + entry)


def most_resident(daemon, reset=False):
    """The most that was resident since the last reset, in MB."""
    if reset:
        with open(f"/proc/{daemon.process.pid}/clear_refs", "w") as f:
            f.write("5")
    with open(f"/proc/{daemon.process.pid}/status") as f:
        return next(int(line.split()[1]) for line in f
                    if line.startswith("VmHWM")) * 1024e-6


def long_segment():
    """Listing, opening and going to and fro take a window of the log and the
    second renderer (95 MB here), however long the log is: it was twice the
    log beside that."""
    with tempfile.TemporaryDirectory(prefix="pelagos-long-") as folder:
        with Daemon("--recordings", folder) as daemon:
            daemon.patch({"clock": {"mode": "STEPPED", "time": 100},
                          "views": {"bridge": SIZE}})
            record(daemon, start="short")
            record(daemon, stop=True)
            short = os.path.join(folder, "short.pelog")
            long_log(short, os.path.join(folder, "long.pelog"), 200)
            os.remove(short)
            picture(daemon)
            before = most_resident(daemon, reset=True)
            listed = daemon.get("/v1/recordings").json()["recordings"][0]
            check(listed["to"] == 150, f"{listed}")
            by_list = most_resident(daemon)
            check(opened(daemon, "long.pelog")["length"] == 50, "its length")
            picture(daemon, "/debrief")
            for position in (40, 7, 45):
                at(daemon, position=position)
                daemon.get("/v1/recordings")
            picture(daemon, "/debrief")
            most = most_resident(daemon)
            debrief(daemon, close=True)
            settled(daemon)
            print(f"  {before:.0f} MB, {by_list:.0f} with a list, "
                  f"{most:.0f} with a debrief of 210 MB", flush=True)
            if not SANITIZED:
                check(by_list - before < 30, "a list reads no logs")
                check(most - before < 160, "a debrief reads by a window")
                until("what a debrief took goes back",
                      lambda: daemon.rss() / 1e6 < before + 30)


def control_never_waits(daemon):
    """Opening, going and closing: nothing in the control thread's loop took
    its time for the debrief."""
    stalls = {k: v for k, v in daemon.metrics().items()
              if k.startswith("pelagos_control_stalls_total")
              and '"debrief"' in k or '"recordings"' in k}
    print(f"  stalls: {stalls}", flush=True)


def without_a_place():
    with Daemon() as daemon:
        check(daemon.get("/v1/recordings").json()["possible"] is False, "none")
        answer = post(daemon, "/v1/recording", {"start": ""}, status=409)
        check("--recordings DIRECTORY" in answer["detail"], f"{answer}")
        answer = debrief(daemon, 409, recording="x")
        check("--recordings DIRECTORY" in answer["detail"], f"{answer}")


def main():
    with tempfile.TemporaryDirectory(prefix="pelagos-debrief-") as folder:
        daemon = Daemon("--recordings", folder, "--record-segment", "0.0625")
        try:
            print("== same bits", flush=True)
            pictures = same_bits(daemon)
            for part in (live_goes_on, streams_end):
                print(f"== {part.__name__}", flush=True)
                part(daemon)
            print("== refused", flush=True)
            refused(daemon, folder)
            print("== pelagosctl", flush=True)
            by_pelagosctl(daemon, folder, pictures)
            print("== many segments", flush=True)
            many_segments(daemon, folder)
            control_never_waits(daemon)
        finally:
            status = daemon.stop()
        check(status == 0, "an orderly end")
    print("== a long segment", flush=True)
    long_segment()
    print("== without a place", flush=True)
    without_a_place()


if __name__ == "__main__":
    sys.exit(main())
