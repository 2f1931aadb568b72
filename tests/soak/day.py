#!/usr/bin/python3
"""A day at 30 Hz is 2.6 million pictures: DAY_FRAMES (2,600,000) of 64x36, each
of another moment, and what they leave: bytes of heap and of memory a frame,
descriptors, threads. Bars: 0.1 byte a frame of heap, and no growth of the
others; fewer frames than 1,000,000 show more by the grain of caches.
"""
import itertools
import os
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)),
                                os.pardir))
from pelagos_daemon import Daemon, Session

FRAMES = int(os.environ.get("DAY_FRAMES", "2600000"))
WARM_UP = min(20000, FRAMES // 4)
AHEAD = 4
MOST_A_FRAME = 0.1
# Caches of moments, by which a figure at one instant varies.
GRAIN = 200e3


def figures(daemon):
    folder = f"/proc/{daemon.process.pid}"
    return (daemon.metrics()["process_heap_bytes"], daemon.rss(),
            len(os.listdir(f"{folder}/fd")), len(os.listdir(f"{folder}/task")))


def take(session, count, moments):
    """Pictures of moments one after the other, some asked for ahead."""
    asked = got = 0
    while got < count:
        while asked < count and asked - got < AHEAD:
            asked += 1
            session.send(session.pb.Request(id=asked, frame={
                "view": "bridge", "time": next(moments) / 30}))
        reply = session.receive()
        assert reply is not None and reply.frame.data, "no picture"
        got += 1


def main():
    with Daemon(unix=True) as daemon:
        daemon.patch({"views": {"bridge": {"width": 64, "height": 36}},
                      "clock": {"mode": "STEPPED"}})
        moments = itertools.count()
        with Session(daemon.connect_unix()) as session:
            take(session, WARM_UP, moments)
            first = figures(daemon)
            began, done = time.monotonic(), 0
            while done < FRAMES:
                some = min(max(FRAMES // 20, 1000), FRAMES - done)
                take(session, some, moments)
                done += some
                now = figures(daemon)
                rate = done / (time.monotonic() - began)
                print(f"{done:9} frames {rate:6.0f}/s  "
                      f"heap {(now[0] - first[0]) / 1e3:+8.1f} kB  "
                      f"memory {(now[1] - first[1]) / 1e3:+8.1f} kB  "
                      f"{now[2]} descriptors  {now[3]} threads", flush=True)
        heap, memory = (now[i] - first[i] for i in (0, 1))
        print(f"{FRAMES} frames: {heap / FRAMES:.3f} byte of heap a frame, "
              f"{memory / FRAMES:.3f} of memory (bar {MOST_A_FRAME})")
        bad = [text for text, wrong in (
            ("heap", heap > MOST_A_FRAME * FRAMES + GRAIN),
            ("descriptors", now[2] > first[2]),
            ("threads", now[3] > first[3])) if wrong]
    print("day of frames: " + (f"failed: {', '.join(bad)}" if bad else "good"))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
