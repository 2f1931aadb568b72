#!/usr/bin/python3
"""One sea: what is drawn, what HTTP, protobuf and CIGI answer, for trochoids
and FFT, now and later, by the number of a frame; and the tide."""
import io
import os
import socket
import sys
import time

import numpy as np
from PIL import Image

import cigi_host as cigi
from cigi_test import metrics, places
from modbus_test import check
from pelagos_daemon import ROOT, SLOW_S, Daemon, Session, free_port

sys.path.insert(0, os.path.join(ROOT, "clients", "python"))
import pelagos  # noqa: E402
from pelagos.camera import Camera  # noqa: E402

# A long swell and a crossing one: both are many cells of the mesh long, which
# is what "the grid resolves the waves" asks for.
SEA = {"windSpeed": 0, "seed": 4, "swell": [
    {"height": 2.5, "period": 9, "direction": 300, "spread": 20},
    {"height": 1, "period": 6, "direction": 210, "spread": 15}]}
VIEW = {"views": [{"name": "bridge", "width": 320, "height": 240, "up": 9,
                   "forward": 3, "pitch": -50, "yaw": 20, "fieldOfView": 30}]}
BOUND_M = 1e-3  # as published in docs/physics/waves.md


def ask(daemon, points, **more):
    body = {"points": [{"east": float(e), "north": float(n)}
                       for e, n in points], **more}
    answer = daemon.request("POST", "/v1/surface", body)
    check(answer.status == 200, f"{answer.status} {answer.body[:300]}")
    return answer.json()


def heights(answer):
    return np.array([p.get("height", 0) for p in answer["points"]])


def vectors(answer, name):
    return np.array([[p[name].get(axis, 0) for axis in ("east", "north", "up")]
                     for p in answer["points"]])


def seen(ocean, at=None):
    """(frame, 1,000 points of the surface as the depth layer has it)."""
    frame = ocean.frame("bridge", "exr", layers=("depth",), float_samples=True,
                        time=at)
    picture = frame.exr()
    points = Camera.of_exr(picture).unproject(picture["depth"]).reshape(-1, 3)
    pick = np.random.default_rng(7).choice(len(points), 1000, replace=False)
    return frame, points[pick]


def compare(what, frame, points, answer):
    error = np.abs(heights(answer) - points[:, 2])
    print(f"  {what}, frame {frame.number} at {frame.time:.3f} s: 1,000 "
          f"pixels, rms {1e3 * np.sqrt(np.mean(error ** 2)):.3f} mm, worst "
          f"{1e3 * error.max():.3f} mm")
    # The header has nine digits of the time.
    check(abs(answer["time"] - frame.time) <= 1e-8 * max(1, frame.time), "time")
    check(error.max() <= BOUND_M, f"{error.max()} m")
    # Some metres of sea: flat on a crest, but not as flat as the bound.
    check(np.ptp(points[:, 2]) > 5 * BOUND_M, "no waves in the picture")


def drawn_is_answered():
    """The clock runs meanwhile: the number says which surface is meant."""
    with Daemon() as daemon:
        ocean = pelagos.Ocean(daemon.url())
        daemon.patch(VIEW)
        for synthesiser in ("TROCHOIDS", "FFT"):
            daemon.patch({"sea": {**SEA, "synthesiser": synthesiser,
                                  "level": 0}})
            frame, points = seen(ocean)
            time.sleep(0.1)
            compare(synthesiser, frame, points,
                    ask(daemon, points[:, :2], frame=frame.number))
            frame, points = seen(ocean, daemon.state()["clock"]["time"] + 1e3)
            compare(synthesiser + ", to come", frame, points,
                    ask(daemon, points[:, :2], frame=frame.number))
            compare(synthesiser + ", to come, by its time", frame, points,
                    ask(daemon, points[:, :2], time=frame.time))
            # After the sea was changed the number still means the old one.
            daemon.patch({"sea": {"level": 1.5, "seed": 5}})
            compare(synthesiser + ", of before", frame, points,
                    ask(daemon, points[:, :2], frame=frame.number))
            frame, points = seen(ocean)
            compare(synthesiser + ", with the tide", frame, points,
                    ask(daemon, points[:, :2], frame=frame.number))
        daemon.patch({"sea": {"seed": 6}})
        seen(ocean)
        daemon.patch({"sea": {"seed": 7}})
        seen(ocean)
        for number in (frame.number, 10 ** 9):
            answer = daemon.request("POST", "/v1/surface",
                                    {"points": [], "frame": number})
            check(answer.status == 404 and answer.json()["path"] == "frame",
                  f"{answer}")


def hull_points_by_every_way():
    port = free_port(socket.SOCK_DGRAM)
    where = places(1000)
    plane = np.array([p[2:] for p in where])
    with Daemon("--cigi", f"127.0.0.1:{port}", "--cigi-silence",
                f"{SLOW_S:g}") as daemon, \
            cigi.Host(("127.0.0.1", port)) as host, \
            Session(daemon.connect_tcp()) as session:
        host.ask()
        for synthesiser in ("TROCHOIDS", "FFT"):
            daemon.patch({"sea": {"synthesiser": synthesiser, "windSpeed": 11,
                                  "level": -0.5}})
            host.send(*(cigi.hat_hot(i, *p[:2], kind=2)
                        for i, p in enumerate(where)))
            frames = host.settle()
            at = metrics(daemon)["pelagos_cigi_host_time_seconds"]
            answers = [a for f in frames for a in f.answers]
            host.gather(answers, 1000)
            by_cigi = {a["id"]: a for _, a in answers}
            check(len(by_cigi) == 1000, f"{len(by_cigi)} answers of CIGI")
            begin = time.monotonic()
            answer = ask(daemon, plane, time=at, acceleration=True, foam=True)
            took = time.monotonic() - begin
            pb = session.pb
            wire = session.ask(surface=pb.SurfaceQuery(
                points=[pb.Point(east=e, north=n) for e, n in plane], time=at,
                acceleration=True, foam=True)).surface
            height = heights(answer)
            velocity = vectors(answer, "velocity")
            acceleration = vectors(answer, "acceleration")
            normal = vectors(answer, "normal")
            for i, p in enumerate(wire.points):
                check(p.height == height[i], "height by protobuf")
                check(p.foam == answer["points"][i]["foam"], "foam")
                for name, row in (("normal", normal), ("velocity", velocity),
                                  ("acceleration", acceleration)):
                    v = getattr(p, name)
                    check((v.east, v.north, v.up) == tuple(row[i]), name)
            hot = np.array([by_cigi[i]["hot"] for i in range(1000)])
            # The test's geodesy at 50 m.
            check(np.abs(hot - height).max() <= 1e-3, "height by CIGI")
            tilt = np.radians([by_cigi[i]["elevation"] for i in range(1000)])
            check(np.abs(np.sin(tilt) - normal[:, 2]).max() < 1e-3,
                  "normal by CIGI")
            follow(daemon, plane, at, velocity, acceleration, height)
            plain = ask(daemon, plane[:1], time=at)["points"][0]
            check("acceleration" not in plain and "foam" not in plain,
                  "asked for nothing")
            print(f"  {synthesiser}: 1,000 hull points in {took * 1e3:.0f} ms "
                  "by HTTP, the same by protobuf and CIGI")


def foreseen_answers_are_the_seas():
    """In step and about now, while the clock runs and pictures are drawn: what
    is answered is what another daemon answers about the same time, to the bit,
    whether the moment was prefetched, prepared in part, or not."""
    sea = {"sea": {"synthesiser": "FFT", "windSpeed": 9, "seed": 5}}
    plane = [(0.7 * i, 3.1 * (i % 40)) for i in range(400)]
    with Daemon() as daemon, Daemon() as other, \
            Session(daemon.connect_tcp()) as session, \
            Session(other.connect_tcp()) as judge:
        pb = session.pb
        points = [pb.Point(east=e, north=n) for e, n in plane]
        for each in (daemon, other):
            each.patch({**sea, **VIEW})
        answers = []
        for turn in range(60):
            if turn % 10 == 0:
                daemon.request("GET", "/v1/views/bridge/frame?width=64&height=48")
            moving = turn % 20 == 13
            reply = session.ask(surface=pb.SurfaceQuery(
                points=points, acceleration=moving)).surface
            answers.append((moving, reply))
            time.sleep(1 / 60)
        times = [reply.time for _, reply in answers]
        check(times == sorted(times), "time goes on")
        for moving, reply in answers:
            again = judge.ask(surface=pb.SurfaceQuery(
                points=points, time=reply.time, acceleration=moving)).surface
            check(again.SerializeToString() == reply.SerializeToString(),
                  f"the answer about {reply.time} s")
        prefetched = metrics(daemon)["pelagos_surface_prefetched_total"]
        check(metrics(other)["pelagos_surface_prefetched_total"] == 0,
              "a time that is named is the time that is answered")
        check(prefetched > 0, "nothing was prefetched")
        print(f"  60 answers about now, {prefetched:.0f} of them prefetched, are "
              "those about their times")


def follow(daemon, plane, at, velocity, acceleration, height):
    """A particle is a moment later where its velocity says, as fast as its
    acceleration says."""
    step = 0.002
    moved = plane + step * velocity[:, :2] + step ** 2 / 2 * acceleration[:, :2]
    later = ask(daemon, moved, time=at + step)
    rise = heights(later) - height
    expected = step * velocity[:, 2] + step ** 2 / 2 * acceleration[:, 2]
    # Ripples of 10 Hz turn by 0.1 rad in a step, and single precision.
    check(np.sqrt(np.mean((rise - expected) ** 2)) < 2e-5, "height later")
    change = (vectors(later, "velocity") - velocity) / step
    error = np.sqrt(np.mean((change - acceleration) ** 2))
    size = np.sqrt(np.mean(acceleration ** 2))
    check(error < 0.1 * size and size > 0.3, f"{error} of {size} m/s2")


def the_tide_lifts_the_sea():
    """2 m more of water are 2 m less of height above it, to the bit."""
    url = "/v1/views/bridge/frame.png?time=50&width=320&height=180"
    with Daemon() as daemon:
        def picture(level, up):
            daemon.patch({"sea": {"level": level},
                          "views": [{"name": "bridge", "up": up}]})
            return np.asarray(Image.open(io.BytesIO(daemon.get(url).body)))
        low, high = picture(0, 10), picture(2, 12)
        check((low == high).all(), "2 m of tide")
        check((low != picture(2, 10)).any(), "the tide shows")


def main():
    for part in (drawn_is_answered, hull_points_by_every_way,
                 foreseen_answers_are_the_seas, the_tide_lifts_the_sea):
        print(f"== {part.__name__}", flush=True)
        part()


if __name__ == "__main__":
    sys.exit(main())
