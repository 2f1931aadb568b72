#!/usr/bin/python3
"""pelagosd as a CIGI 3.3 image generator, with the host of cigi_host.py.

The last part has tshark dissect both directions of everything that was sent;
where there is no tshark it is left out, with a message.
"""
import collections
import io
import json
import math
import os
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

from PIL import Image

import cigi_host as cigi
from pelagos_daemon import SANITIZED, SLOW_S, Daemon, free_port, until

LATITUDE, LONGITUDE = 52.6, 5.2  # the scene's origin
LOGS = []  # (host port, generator port, log) of every host


def check(condition, text):
    if not condition:
        raise AssertionError(text)


def near(a, b, tolerance, text):
    check(abs(a - b) <= tolerance, f"{text}: {a} is not {b}")


class Stand:
    """A daemon with CIGI and a host for it, which a busy machine may hold up
    for long: nobody takes it for silent before silence_s."""

    def __init__(self, *options, silence_s=SLOW_S, **host):
        self.port = free_port(socket.SOCK_DGRAM)
        self.daemon = Daemon("--cigi", f"127.0.0.1:{self.port}",
                             "--cigi-silence", f"{silence_s:g}", *options)
        self.host = cigi.Host(("127.0.0.1", self.port), **host)

    def metric(self, name):
        return metrics(self.daemon)["pelagos_cigi_" + name]

    def state(self):
        """When no sea is being built for the host any more."""
        until("seas are built", lambda:
              metrics(self.daemon)["pelagos_scene_waiting"] == 0)
        return self.daemon.state()

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        if kind:
            print(f"alive: {self.daemon.alive()}\n{self.daemon.log()[-4000:]}")
        LOGS.append((self.host.socket.getsockname()[1], self.port,
                     self.host.log))
        self.host.close()
        self.daemon.stop()


def metrics(daemon):
    page = {}
    for line in daemon.get("/metrics").body.decode().splitlines():
        if not line.startswith("#"):
            name, value = line.rsplit(" ", 1)
            page[name] = float(value)
    return page


def ship(state, id=1):
    return next((e for e in state["entities"] if int(e["id"]) == id), None)


def places(count, seed=1):
    """(latitude, longitude, east, north) within 50 m of the origin: the
    radii of curvature there are exact to 0.2 mm, see below."""
    a, e2 = 6378137.0, 6.69437999014e-3
    phi = math.radians(LATITUDE)
    w = 1 - e2 * math.sin(phi) ** 2
    meridian, normal = a * (1 - e2) / w ** 1.5, a / w ** 0.5
    pick = random.Random(seed)
    out = []
    for _ in range(count):
        east, north = pick.uniform(-50, 50), pick.uniform(-50, 50)
        # The second-order terms of the geodesic, east^2 tan(phi) / (2 N) and
        # east north tan(phi) / N: 0.25 mm and 0.5 mm at 50 m, kept.
        turn = math.tan(phi) / normal
        latitude = north / meridian - east * east * turn / (2 * meridian)
        longitude = east / (normal * math.cos(phi)) * (1 + north * turn)
        out.append((LATITUDE + math.degrees(latitude),
                    LONGITUDE + math.degrees(longitude), east, north))
    return out


def surface(daemon, points, at):
    body = {"time": at, "points": [{"east": e, "north": n}
                                   for e, n in points]}
    answer = daemon.request("POST", "/v1/surface", body)
    check(answer.status == 200, answer)
    return [p.get("height", 0) for p in answer.json()["points"]]


# --- tests ------------------------------------------------------------------


def scene_follows_in_both_orders():
    for big, minor in ((True, 3), (False, 2)):
        with Stand(big=big, minor=minor) as s:
            s.host.ask(cigi.entity(1, 52.61, 5.25, 3, yaw=123, pitch=2,
                                   roll=-4),
                       cigi.entity(40, 52.62, 5.2, clamp=1),
                       cigi.atmosphere(7000, 11, 210),
                       cigi.celestial(17, 5, 3, 1, 2026),
                       cigi.view_control(0, 1, x=5, z=-18, yaw=30),
                       cigi.view_definition(2, -20, 25, 12, -13),
                       cigi.maritime(50, 8, height=-1.25), cigi.wave(4, 1.5, 8, 100),
                       cigi.sensor(0, 3), cigi.raw(bytes([240, 16] + [7] * 14)))
            state = s.state()
            e = ship(state)
            check((e["latitude"], e["longitude"], e["altitude"]) ==
                  (52.61, 5.25, 3), e)
            check((e["heading"], e["pitch"], e["roll"]) == (123, 2, -4), e)
            check(ship(state, 40), state["entities"])
            check(state["clock"]["mode"] == "HOST", state["clock"])
            check(state["clock"]["utc"].startswith("2026-03-01T17:0"),
                  state["clock"])
            near(state["sky"]["visibility"], 7000, 0, "visibility")
            check((state["sea"]["windSpeed"], state["sea"]["windDirection"])
                  == (11, 210), state["sea"])
            near(state["sea"]["wave"][0]["height"], 1.5, 0, "wave")
            near(state["sea"]["level"], -1.25, 0, "tide")
            near(state["water"]["chlorophyll"], 30 * 10 ** -1.5, 1e-6,
                 "chlorophyll")
            views = {v["name"]: v for v in state["views"]}
            check((views["bridge"]["up"], views["bridge"]["yaw"]) == (18, 30),
                  views)
            check(views["cigi-2"]["frustum"] ==
                  {"left": -20, "right": 25, "top": 12, "bottom": -13}, views)
            check(s.metric("unknown_packets_total") == 1, "unknown id")
            check(s.metric("sensors_on") == 1, "sensor")
            frame = s.host.receive()
            check(frame.sof["minor"] == minor and frame.sof["mode"] == 1 and
                  frame.sof["magic"] == 0x8000, frame.sof)


def answers_are_of_the_sea_drawn():
    with Stand() as s:
        s.host.ask(cigi.component(1, 1, (14, 300, 150000, 3.3), seed=9))
        state = s.state()["sea"]
        check((state["windSpeed"], state["spectrum"], state["seed"]) ==
              (14, "JONSWAP", 9), state)
        points = places(100)
        for round_ in range(3):
            answers = s.host.ask(*(cigi.hat_hot(i, p[0], p[1], kind=i % 3)
                                   for i, p in enumerate(points)))
            at = s.metric("host_time_seconds")
            want = surface(s.daemon, [p[2:] for p in points], at)
            check(len(answers) == 100, f"{len(answers)} answers")
            for kind, a in answers:
                check(a["valid"] and a["frame"] == s.host.frame & 15, a)
                height = a["hot"] if kind == "extended" else a["height"]
                if a["id"] % 3 == 0:
                    height = -height  # HAT of altitude 0
                near(height, want[a["id"]], 1e-3, "height, m")
        answers = dict(s.host.ask(
            cigi.conditions(9, *points[0][:2], kind=5), cigi.position(1),
            cigi.los_vector(8, (LATITUDE, LONGITUDE, 30), 0, -90, 100,
                            extended=True),
            cigi.los_segment(7, (LATITUDE, LONGITUDE, 30),
                             (LATITUDE, LONGITUDE, -30))))
        at = s.metric("host_time_seconds")
        first, origin = surface(s.daemon, [points[0][2:], (0, 0)], at)
        near(answers["maritime"]["height"], first, 1e-3, "maritime height, m")
        near(answers["los_extended"]["range"], 30 - origin, 1e-3, "range, m")
        near(answers["los"]["range"], 30 - origin, 1e-3, "range, m")
        check(not answers["los"]["visible"], answers["los"])
        near(answers["weather"]["wind"], 14, 1e-5, "wind")
        near(answers["position"]["latitude"], LATITUDE, 1e-9, "latitude")


def answers_of_fft_come_later():
    """Its moments take longer than a frame; the heights are the same sea's."""
    with Stand() as s:
        s.host.ask(cigi.component(5, 1), cigi.component(1, 3, (10, 90)))
        state = s.state()["sea"]
        check((state["synthesiser"], state["spectrum"]) ==
              ("FFT", "ELFOUHAILY"), state)
        points = places(20)
        s.host.send(*(cigi.hat_hot(i, p[0], p[1])
                      for i, p in enumerate(points)))
        answers = [a for frame in s.host.settle() for a in frame.answers]
        at = s.metric("host_time_seconds")
        s.host.gather(answers, 20)
        want = surface(s.daemon, [p[2:] for p in points], at)
        check(len(answers) == 20, f"{len(answers)} answers")
        for _, a in answers:
            near(a["height"], want[a["id"]], 1e-3, "height, m")


def frames_faster_than_seas():
    """Each host frame asks of another moment of an FFT sea, and none waits for
    the sea of the one before: every request is answered, in their order."""
    frames, each = 30, 60
    with Stand() as s:
        s.host.ask(cigi.entity(1, LATITUDE, LONGITUDE), cigi.component(5, 1))
        s.state()
        points = places(each)
        first = s.host.frame + 1
        for _ in range(frames):
            s.host.send(*(cigi.hat_hot(i, p[0], p[1])
                          for i, p in enumerate(points)))
        got, end = [], time.monotonic() + SLOW_S
        while len(got) < frames * each and time.monotonic() < end:
            for frame in s.host.drain(0.1):
                got += [a for _, a in frame.answers]
        check([a["id"] for a in got] == list(range(each)) * frames,
              f"{len(got)} of {frames * each} answers")
        check((got[-1]["frame"] - first - frames + 1) % 16 == 0,
              "the last is of the newest frame")
        check(s.metric("dropped_answers_total") == 0, "none is dropped")


def frame_headers(daemon, url, out, stop):
    """(time of receipt, the host's frame shown) of live pictures."""
    with daemon.connect_http() as c:
        c.sendall(f"GET {url} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
        file = c.makefile("rb")
        now = {}
        while not stop.is_set():
            line = file.readline()
            if not line:
                return
            name, _, value = line.decode("latin-1").strip().partition(": ")
            if name == "X-Pelagos-Host-Frame":
                now["frame"] = int(value)
            if name == "Content-Length":
                size = int(value)
            if not name and "frame" in now:
                file.read(size)
                out.append((time.monotonic(), now["frame"]))
                now = {}


def next_frames(host, due):
    """What has come when the host's next frame is due: in synchronous mode
    the next Start of Frame, else what comes until the time `due`."""
    if not host.stamped:
        frame = host.receive()
        check(frame, "no Start of Frame")
        # A host that was held up answers the newest.
        return [frame] + host.drain(0)
    frames = []
    while (left := due - time.monotonic()) > 0:
        if (frame := host.receive(left)) is not None:
            frames.append(frame)
    return frames


def dropped(daemon):
    return metrics(daemon)["pelagos_cigi_dropped_answers_total"]


def host_at_sixty_hertz(seconds, requests=100, late=1.0, fft=False, **kind):
    """A host at 60 Hz, by Start of Frame or by its own clock (stamped), with
    HAT/HOT requests in every frame. late: the share of pictures that may come
    more than 2 host frames after theirs, and of host frames that may be
    answered later than in the next frame, which a busy machine decides:
    `make soak` sets them. fft: a sea whose moments cost milliseconds of a core
    each, so that answers may be of a later host frame.
    Returns the daemon's growth in bytes after a warm-up."""
    with Stand("--fps", "60", **kind) as s:
        s.host.log = collections.deque(maxlen=20000)
        s.daemon.patch({"views": [{"name": "bridge", "width": 64,
                                   "height": 36}]})
        s.host.ask(cigi.entity(1, LATITUDE, LONGITUDE),
                   cigi.component(5, int(fft)))
        pictures, stop = [], threading.Event()
        viewer = threading.Thread(target=frame_headers, args=(
            s.daemon, "/v1/views/bridge/mjpeg", pictures, stop), daemon=True)
        viewer.start()
        until("live pictures", lambda: pictures)
        points = places(requests)
        sent, answered = {}, {}

        def take(frame):
            for _, a in frame.answers:
                # The newest host frame with these low 4 bits.
                host_frame = s.host.frame - (s.host.frame - a["frame"]) % 16
                answered.setdefault(host_frame, []).append(frame.sof["frame"])

        before = metrics(s.daemon)
        dropped_before = dropped(s.daemon)
        start_of_load = due = time.monotonic()
        warm = grown = 0
        while time.monotonic() < start_of_load + seconds:
            if not warm and time.monotonic() > start_of_load + seconds / 5:
                warm = s.daemon.rss()
            due = max(due + 1 / 60, time.monotonic())
            for frame in next_frames(s.host, due):
                take(frame)
            number = s.host.frame + 1
            s.host.send(
                cigi.entity(1, LATITUDE + 1e-6 * number, LONGITUDE, 0,
                            yaw=number / 10 % 360),
                *(cigi.hat_hot(i, p[0], p[1]) for i, p in enumerate(points)))
            sent[number] = (time.monotonic(), s.host.last_ig)
        for frame in s.host.settle():
            take(frame)
        # The answers of the last one may be in a frame after that.

        def is_over():
            if (frame := s.host.receive(0.1)) is not None:
                take(frame)
            made = sum(map(len, answered.values()))
            lost = dropped(s.daemon) - dropped_before
            check(made + lost <= requests * len(sent), f"{made} + {lost}")
            return made + lost == requests * len(sent)
        until("each request is answered or counted", is_over, pause_s=0)
        grown = s.daemon.rss() - warm
        stop.set()
        viewer.join(SLOW_S)
        after = metrics(s.daemon)

        check(sum(map(len, answered.values())) == requests * len(sent),
              "a request is not answered")
        behind = []
        for number, (_, ig) in sent.items():
            got = answered.get(number, [])
            if len(got) != requests:
                behind.append(1000)
                continue
            # "In that frame or the next": the Start of Frame that follows the
            # request, or the one after.
            behind.append(max(got) - ig)
        for name in ("refused_edits", "late", "duplicate", "lost_frames"):
            name = f"pelagos_cigi_{name}_total"
            check(after[name] == before[name], name)

        # Latency of pictures in host frames: how many the host had sent when
        # the picture of one came.
        latencies = []
        times = sorted((t, n) for n, (t, _) in sent.items())
        for at, number in pictures:
            newest = sum(1 for t, _ in times if t <= at) + times[0][1] - 1
            if number in sent:
                latencies.append(newest - number)
        latencies.sort()
        check(latencies, "no pictures of host frames")
        median = latencies[len(latencies) // 2]
        print(f"  {len(sent)} host frames in {seconds} s, "
              f"{sum(map(len, answered.values()))} answers, "
              f"{len(pictures)} pictures, latency of pictures in host "
              f"frames: median {median}, p95 "
              f"{latencies[int(len(latencies) * 0.95)]}; frames skipped "
              f"{after['pelagos_cigi_skipped_frames_total']:.0f}")
        slow = sum(x > 2 for x in behind) / len(behind)
        print(f"  answers later than the next frame: {slow:.2%} of the frames")
        share = sum(x > 2 for x in latencies) / len(latencies)
        if not SANITIZED:
            check(share <= late, f"{share:.1%} of the pictures are late")
            check(slow <= late, f"{slow:.1%} of the answers are late")
        return grown


def synchronous_sixty_hertz():
    host_at_sixty_hertz(5)


def asynchronous_sixty_hertz():
    host_at_sixty_hertz(3, stamped=True, big=False, minor=2)


def asynchronous_host():
    with Stand(stamped=True) as s:
        s.host.ask(cigi.entity(1, LATITUDE, LONGITUDE), cigi.rate(1, x=10))
        start = s.metric("host_time_seconds")
        for _ in range(25):
            s.host.send(ticks=4000)  # 25 Hz
            time.sleep(0.005)  # faster than its time, so that none is late
        s.host.settle()
        near(s.metric("host_time_seconds") - start, 1.0, 1e-9, "25 x 40 ms")
        e = dict(s.host.ask(cigi.position(1)))["position"]
        metres = (e["latitude"] - LATITUDE) * 111270
        # One more frame of 16.67 ms came with the question.
        near(metres, 10 * (1 + 0.01667), 0.7, "metres at 10 m/s")


def sea_state_shows_in_the_next_frame():
    with Stand() as s:
        s.host.ask(cigi.hat_hot(1, LATITUDE, LONGITUDE))
        for change, wind in ((cigi.atmosphere(9000, 20, 90), 20),
                             (cigi.short_component(2, 9, 90), 0.836 * 27)):
            s.host.send(change)
            s.host.settle()
            state = s.state()
            shown = s.daemon.get("/v1/views/bridge/frame.jpg"
                                 "?width=64&height=36")
            near(state["sea"]["windSpeed"], wind, 1e-9, "wind")
            check(shown.status == 200, shown)
            check(int(shown.headers["X-Pelagos-Revision"]) >=
                  int(state["revision"]), "the picture is older")


def components_switch_lights():
    with Stand() as s:
        s.host.send(cigi.entity(40, 52.61, 5.2),
                    cigi.short_component(1, 2, instance=40, kind=0),
                    cigi.component(2, 1, instance=40, kind=0),
                    cigi.short_component(3, 1, instance=40, kind=0),
                    cigi.component(4, 1, (-30, 2, 6, 5e5), 40, 0))
        s.host.settle()
        e = {int(e["id"]): e for e in s.state()["entities"]}[40]
        check((e["lights"], e["navigationStatus"], e["deckLights"]) ==
              ("ON", "AT_ANCHOR", True), e)
        check(e["searchlight"] == {"on": True, "bearing": -30, "elevation": 2,
                                   "width": 6, "intensity": 5e5}, e)
        s.host.send(cigi.short_component(1, 1, instance=40, kind=0),
                    cigi.short_component(4, 0, instance=40, kind=0))
        s.host.settle()
        e = {int(e["id"]): e for e in s.state()["entities"]}[40]
        check(e["lights"] == "AUTO" and not e["searchlight"]["on"], e)


FOG = {
    "title": "Fog at 20 s",
    "state": {"ownShip": {"on": True}, "entities": [
        {"id": 1, "latitude": 52.6, "longitude": 5.2}]},
    "events": [{"name": "fog", "when": [{"at": 20}],
                "patch": {"state": {"sky": {"visibility": 800}}}}]}
NOTHING, LOAD, START, PAUSE, REWIND, STOP = 0, 6, 7, 8, 9, 10


def components_lead_exercises():
    """Started, paused, rewound and stopped by number; said twice is done once;
    what cannot be is refused, and the rest of the datagram stands."""
    folder = tempfile.TemporaryDirectory()
    for name in ("b-fog", "a-other"):
        with open(os.path.join(folder.name, name + ".json"), "w") as file:
            json.dump(FOG, file)
    with Stand(f"--exercises={folder.name}", stamped=True) as s:
        def run():
            return s.state()["exercise"]

        def say(state, value=0.0, *more, instance=1):
            s.host.send(cigi.short_component(1, state, value, 0, instance, 13),
                        *more)
            return s.host.settle()[-1]

        def go(seconds):
            while seconds > 0:
                s.host.send(ticks=int(1e5 * min(seconds, 5)))
                s.host.settle()
                seconds -= 5

        def fired():
            return [e["event"] for e in run().get("events", []) if e["count"]]
        go(5)
        say(START)
        until("it runs", lambda: run()["phase"] == "RUNNING")
        check(run()["name"] == "b-fog", f"{run()}")
        check(s.state()["clock"]["mode"] == "HOST", "the host leads on")
        go(15)
        check(not fired(), "too early")
        go(10)
        check(fired() == ["fog"] and s.state()["sky"]["visibility"] == 800,
              f"{run()}")
        say(PAUSE)
        check(run()["phase"] == "PAUSED", f"{run()}")
        # Another goes on with it: what the host repeats is not said anew.
        s.daemon.request("POST", "/v1/exercise", {"action": "START"})
        say(PAUSE)
        check(run()["phase"] == "RUNNING", "repeated")
        say(NOTHING)
        say(PAUSE)
        check(run()["phase"] == "PAUSED", "said anew")
        before = s.state()["clock"]["time"]
        say(REWIND, 10.0)
        check((run()["time"], fired()) == (10, []), f"{run()}")
        say(START)
        go(2)
        # Time has gone back, and goes on from there; extrapolated by 1 s.
        now = s.state()["clock"]["time"] - run()["offset"]
        check(11.9 < now < 14, f"{now} s")
        check(s.state()["clock"]["time"] < before - 8, "time goes back")
        # By less than a jump of the host's own would be, too.
        say(REWIND, 6.0)
        go(1)
        now = s.state()["clock"]["time"] - run()["offset"]
        check(6.9 < now < 9, f"{now} s")
        say(START)

        edits = s.metric("refused_edits_total")
        frame = say(PAUSE, 0.0, cigi.entity(55, 52.6, 5.2), instance=0)
        check(frame.sof["status"] == 1, f"{frame.sof}")
        check(s.metric("refused_edits_total") == edits + 1, "not counted")
        check("CIG-002 an edit by CIGI was refused" in s.daemon.log() and
              "(a-other) is not the one that is loaded" in s.daemon.log(),
              s.daemon.log())
        check(ship(s.state(), 55), "the rest stands")
        skipped = s.metric("skipped_packets_total")
        say(START, instance=9)
        say(42)
        check(s.metric("skipped_packets_total") == skipped + 2, "not skipped")
        say(REWIND, float("nan"), cigi.entity(56, 52.6, 5.2))
        check(s.metric("refused_edits_total") == edits + 2, "no number")
        check(all(int(e["id"]) != 56 for e in s.state()["entities"]),
              "a bad number is the whole datagram's")
        check(run()["phase"] == "RUNNING", "nothing of it took effect")
        say(STOP)
        check(run()["phase"] == "ENDED", f"{run()}")
        say(START)
        until("it begins anew", lambda: run()["phase"] == "RUNNING" and
              run()["time"] == 0 and not fired())


def sensors_change_the_picture():
    """On, off, polarity, gain and level, by the picture; trackers by their
    responses, which tshark dissects too."""
    url = "/v1/views/bridge/frame.png?width=96&height=54&time=100"
    with Stand() as s:

        def light(**kind):
            s.host.ask(cigi.sensor(0, 1, **kind))
            picture = pixels(s.daemon.get(url)).convert("RGB")
            bands = [list(band.getdata()) for band in picture.split()]
            if kind:
                check(bands[0] == bands[1] == bands[2] or "eye" in kind,
                      "a sensor's picture is grey")
            return bands[1]

        s.host.ask(cigi.entity(1, LATITUDE, LONGITUDE, yaw=90))
        eye = pixels(s.daemon.get(url))
        white = light(auto=True)
        black = light(auto=True, black_hot=True)
        # To the dither of half a step on either side, twice.
        check(all(abs(a + b - 255) <= 2 for a, b in zip(white, black)),
              "black hot is not the negative")
        bright = light(level=0.6)
        check(all(abs(b - min(a + 25.5, 255)) <= 2
                  for a, b in zip(white, bright)), "level")
        strong = light(gain=0.75, level=0.5)
        check(all(abs(b - min(2 * a, 255)) <= 3
                  for a, b in zip(white, strong)), "gain")
        check(light(noise=0.5) != white, "noise")
        check(max(light(on=False)) == 0, "off is not black")
        s.host.ask(cigi.sensor(0, 2, on=False))
        s.host.ask(cigi.sensor(0, 1, auto=True))
        check(s.metric("sensors_on") == 1, "one is on")
        # Mode 0, Reset: the eye's picture again.
        s.host.mode = 0
        s.host.ask()
        s.host.mode = 1
        check(list(pixels(s.daemon.get(url)).getdata()) ==
              list(eye.getdata()), "reset")
        tracked(s)


def tracked(s):
    def answers(name, *packets):
        s.host.send(*packets)
        return s.host.settle()[-1].all(name)[0]

    # 0.03 degrees of longitude to the east, a little north of the axis.
    s.host.ask(cigi.entity(1, LATITUDE, LONGITUDE, yaw=90),
               cigi.entity(9, LATITUDE + 0.002, LONGITUDE + 0.03))
    plain = answers("sensor", cigi.sensor(0, 1, track=4))
    check(plain["status"] == 1 and plain["frame"] == s.host.frame, plain)
    near(plain["x"], -math.degrees(math.atan2(222.5, 2033)), 0.05, "gate")
    check(plain["size"][0] > 8, plain)
    far = answers("sensor_extended",
                  cigi.sensor(0, 1, track=4, extended=True))
    check((far["valid"], far["entity"]) == (1, 9), far)
    near(far["latitude"], LATITUDE + 0.002, 1e-9, "track point")
    lost = answers("sensor_extended", cigi.entity(9, LATITUDE, LONGITUDE - 1))
    check(lost["status"] == 3 and not lost["valid"], lost)
    s.host.send(cigi.sensor(0, 1))
    check(not s.host.settle()[-1].answers, "track off")


def ended_while_a_host_leads():
    """Nobody leads a daemon that starts again: its clock is not left standing,
    whether it ended in order or was killed."""
    for end, mode in ((signal.SIGTERM, "PACED"), (signal.SIGKILL, "FREE")):
        with tempfile.TemporaryDirectory() as folder:
            state = os.path.join(folder, "state.json")
            with Stand("--state", state) as s:
                s.daemon.patch({"clock": {"mode": "PACED"}})
                s.host.ask(cigi.entity(1, LATITUDE, LONGITUDE),
                           cigi.rate(1, x=5))
                check(s.state()["clock"]["mode"] == "HOST", "leads")
                written = time.monotonic() + 10
                while "HOST" not in open(state).read():
                    check(time.monotonic() < written, "no state file")
                    time.sleep(0.05)
                s.daemon.stop(end)
            with Daemon("--state", state) as daemon:
                after = daemon.state()
                check(after["clock"]["mode"] == mode, after["clock"])
                check((ship(after)["speed"] == 0) == (mode == "PACED"),
                      ship(after))


def database_and_refusals():
    with Stand("--cigi-database", "3") as s:
        def told(asked):
            s.host.database = asked
            s.host.send()
            return s.host.settle()[-1].sof["database"]
        check([told(n) for n in (0, 3, 0, 7, 0)] == [0, -3, 3, -128, -128],
              "databases")
        other = cigi.Host(("127.0.0.1", s.port))
        other.send(cigi.entity(1, 10, 10))
        s.host.ask()
        check(s.metric("refused_datagrams_total") == 1, "a second host")
        check(s.metric("connected") == 1, "connected")
        other.close()


AMBER = (255, 176, 0)


def pixels(answer):
    return Image.open(io.BytesIO(answer.body)).convert("RGB")


def a_silent_host_is_noticed():
    """Time is held, or given back with all at rest; the picture says so, and
    another host may lead."""
    for gone in ("hold", "resume"):
        with Stand("--cigi-gone", gone, silence_s=2) as s:
            url = "/v1/views/bridge/frame.png?width=320&height=180"
            s.daemon.patch({"sources": {"mark": True}})
            s.host.ask(cigi.entity(1, LATITUDE, LONGITUDE), cigi.rate(1, x=9))

            def in_time():  # else it was drawn after the host was given up
                s.host.ask(cigi.entity(1, LATITUDE, LONGITUDE),
                           cigi.rate(1, x=9))
                answer = s.daemon.get(url)
                return answer.headers["X-Pelagos-Stale"] == "none" and answer
            fresh = until("a picture while the host is there", in_time)
            check(int(fresh.headers["X-Pelagos-Host-Frame"]) == s.host.frame,
                  fresh.headers)
            check(pixels(fresh).getpixel((0, 0)) != AMBER, "a mark")
            at = s.metric("host_time_seconds")
            until("gone", lambda: s.metric("connected") == 0)
            until("the log says so", lambda: "CIG-008" in s.daemon.log())
            state = s.state()
            check(state["sources"]["cigiStale"], state["sources"])
            moved = (ship(state)["latitude"] - LATITUDE) * 111270
            if gone == "hold":
                stands = state["clock"]["time"] - at
                # For 1 s from its last frame; `at` is a little later.
                check(0 <= stands < 1.3, f"went on for {stands} s")
                time.sleep(0.1)
                near(s.state()["clock"]["time"], at + stands, 1e-9,
                     "stands")
                check(state["clock"]["mode"] == "HOST", state["clock"])
            else:
                check(state["clock"]["mode"] == "FREE", state["clock"])
                check(ship(state)["speed"] == 0, ship(state))
                # Extrapolated for 1 s, then at rest.
                check(0 < moved < 9 * 1.1, f"moved by {moved} m")
            old = s.daemon.get(url)
            check(old.headers["X-Pelagos-Stale"] == "cigi", old.headers)
            check("X-Pelagos-Host-Frame" not in old.headers, old.headers)
            corners = [pixels(old).getpixel(p)
                       for p in ((0, 0), (319, 0), (0, 179), (319, 179))]
            check(corners == [AMBER] * 4, corners)
            check(pixels(old).getpixel((160, 120)) != AMBER, "the middle")
            s.daemon.patch({"sources": {"mark": False}})
            check(pixels(s.daemon.get(url)).getpixel((0, 0)) != AMBER, "mark")
            other = cigi.Host(("127.0.0.1", s.port))
            other.ask(cigi.entity(1, LATITUDE + 0.1, LONGITUDE))
            state = s.state()
            near(ship(state)["latitude"], LATITUDE + 0.1, 0, "anew")
            check(not state["sources"]["cigiStale"], state["sources"])
            check(state["clock"]["mode"] == "HOST", state["clock"])
            other.close()


def start_of_frame_before_any_host():
    with cigi.Host(("127.0.0.1", 1)) as host:
        port = host.socket.getsockname()[1]
        there = free_port(socket.SOCK_DGRAM)
        with Daemon("--cigi", f"127.0.0.1:{there}", "--cigi-host",
                    f"127.0.0.1:{port}", "--cigi-rate", "100") as daemon:
            host.to = ("127.0.0.1", there)
            first = host.receive(SLOW_S)
            check(first and first.sof["last_host"] == 0, "Start of Frame")
            host.send(cigi.entity(1, LATITUDE, LONGITUDE))
            host.settle()
            LOGS.append((port, there, host.log))
            state = daemon.state()
            check(state["clock"]["mode"] == "HOST", state["clock"])
    with Daemon() as daemon:  # off: nothing of it is to be seen
        check("cigi" not in daemon.get("/metrics").body.decode(), "metrics")


def tshark_understands_both_directions(limit=300):
    if not shutil.which("tshark"):
        print("  left out: there is no tshark")
        return
    fields = ["frame.protocols", "_ws.malformed", "_ws.expert.message",
              "cigi.packet_id", "cigi.sof.ig_frame_number",
              "cigi.sof.last_host_frame_number",
              "cigi.hat_hot_response.height", "cigi.pos_response.yaw",
              "cigi.ig_control.host_frame_number"]
    logs = [(a, b, list(log)[:limit]) for a, b, log in LOGS]
    both = [(sent, data) for _, _, log in logs for sent, data in log]
    with tempfile.TemporaryDirectory() as folder:
        lines = []
        for host_port, port, log in logs:
            path = os.path.join(folder, "pcap")
            cigi.write_pcap(path, host_port, port, log)
            command = ["tshark", "-n", "-r", path, "-d",
                       f"udp.port=={port},cigi", "-T", "fields"]
            for field in fields:
                command += ["-e", field]
            run = subprocess.run(command, capture_output=True, text=True,
                                 check=True)
            lines += run.stdout.splitlines()
    check(len(lines) == len(both), f"{len(lines)} of {len(both)}")
    for (sent, data), line in zip(both, lines):
        (protocols, malformed, expert, ids, frame, last, heights, yaws,
         host_frame) = line.split("\t")
        # A port that is free may be one that traceroute uses: no fault.
        note = expert and not expert.startswith("Possible traceroute")
        check(protocols.endswith("cigi") and not malformed and not note, line)
        check(ids.split(",") == [str(id) for id in ids_of(data)],
              f"{ids} is not {ids_of(data)}")
        order = ">" if data[6] else "<"
        if sent:
            check(int(host_frame) ==
                  int.from_bytes(data[8:12], "big" if data[6] else "little"),
                  line)
            continue
        packets = cigi.parse(order, data)
        check((int(frame), int(last)) ==
              (packets[0][1]["frame"], packets[0][1]["last_host"]), line)
        same(heights, [a["height"] for n, a in packets if n == "hat_hot"])
        same(yaws, [a["yaw"] for n, a in packets if n == "position"])
    print(f"  {len(lines)} datagrams without a note")


def same(text, values):
    """tshark prints six digits or more."""
    told = [float(v) for v in text.split(",") if v]
    check(len(told) == len(values), (text, values))
    for a, b in zip(told, values):
        near(a, b, 1e-5 * max(1, abs(b)), "tshark's value")


def ids_of(data):
    out = []
    while data:
        out.append(data[0])
        data = data[data[1]:]
    return out


def run(tests):
    """Those that the command line names; none: all."""
    names = sys.argv[1:]
    for test in tests:
        if not names or test.__name__ in names:
            begin = time.monotonic()
            test()
            print(f"ok  {test.__name__}, {time.monotonic() - begin:.1f} s",
                  flush=True)


TESTS = [scene_follows_in_both_orders, answers_are_of_the_sea_drawn,
         answers_of_fft_come_later, frames_faster_than_seas,
         synchronous_sixty_hertz, asynchronous_sixty_hertz,
         asynchronous_host,
         sea_state_shows_in_the_next_frame, components_switch_lights,
         components_lead_exercises,
         sensors_change_the_picture,
         ended_while_a_host_leads, database_and_refusals, a_silent_host_is_noticed,
         start_of_frame_before_any_host, tshark_understands_both_directions]

if __name__ == "__main__":
    run(TESTS)
