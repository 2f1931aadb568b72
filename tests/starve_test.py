#!/usr/bin/python3
"""Memory that the daemon's own code asks for is refused, one call after the
other: it answers or refuses, applies nothing by halves, keeps nothing, and
goes on. (Memory that GLib or Mesa ask for is theirs: GLib ends the process.)

STARVE_ALL=1, for `make soak`: every call in turn; else the first of each place
in the code, of some. STARVE_AT: begin with this operation.
"""
import collections
import contextlib
import mmap
import os
import random
import struct
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import BIN, SANITIZED, Daemon, Session

ALL = os.environ.get("STARVE_ALL") == "1"
SITES = 1 << 18
HEAD = 32
# Of each operation, in the short form; and of the start.
SHORT, SHORT_START = 12, 6
REST_S = 9
MOST_GROWTH = 4 << 20  # 0.0 to 0.7 are seen
# Their refusals take seconds: STARVE_ALL alone.
SLOW = ("optics", "stream", "video")


class Starve:
    """The file that tests/lib/starve.c shares."""

    def __init__(self, folder):
        self.path = os.path.join(folder, "starve")
        with open(self.path, "wb") as f:
            f.truncate(HEAD + 4 * SITES)
        with open(self.path, "r+b") as f:
            self.map = mmap.mmap(f.fileno(), 0)

    def _get(self, at):
        return struct.unpack_from("<Q", self.map, 8 * at)[0]

    def calls(self):
        return self._get(0)

    def failed(self):
        return self._get(3)

    def fail(self, at, count=1):
        struct.pack_into("<Q", self.map, 16, 0)
        struct.pack_into("<Q", self.map, 8, at)
        struct.pack_into("<Q", self.map, 16, count)

    def feed(self):
        struct.pack_into("<Q", self.map, 16, 0)

    def reset(self):
        self.map[:HEAD] = bytes(HEAD)

    def site(self, call):
        return struct.unpack_from("<I", self.map, HEAD + 4 * (call % SITES))[0]


def where(site):
    """The place in the code, for people."""
    out = subprocess.run(["addr2line", "-sfe", os.path.join(
        BIN, StarvedDaemon.PROGRAM), hex(site - 1)],
                         capture_output=True, text=True, check=False)
    return " ".join(out.stdout.split())


VOLATILE = ("revision", "clock", "sources")


def plain(state):
    return {k: v for k, v in state.items() if k not in VOLATILE}


def target(state):
    """The name of entity 9."""
    return next((e.get("name") for e in state["entities"] if e["id"] == 9),
                None)


class StarvedDaemon(Daemon):
    PROGRAM = "pelagosd-starved"

    def __init__(self, starve, *options, **more):
        os.environ["STARVE"] = starve.path
        try:
            super().__init__(*options, **more)
        finally:
            del os.environ["STARVE"]


class Starved(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.starve = Starve(self.folder.name)
        self.random = random.Random(1)

    def chosen(self, first, last, most):
        """The calls to refuse, of first to last: the first from each place."""
        if ALL:
            return list(range(first, last)), last - first
        places = collections.OrderedDict()
        for call in range(first, last):
            places.setdefault(self.starve.site(call), call)
        calls = list(places.values())
        if len(calls) > most:
            calls = sorted(self.random.sample(calls, most))
        return calls, len(places)

    # --- what is asked of a daemon that runs --------------------------------

    def edit(self, d):
        self.turn = getattr(self, "turn", 0) + 1
        change = {"sky": {"visibility": 5000 + self.turn},
                  "entities": {"1": {"speed": self.turn % 7},
                               "9": {"name": f"t{self.turn}",
                                     "latitude": 52.6, "longitude": 5.2}}}
        before = plain(d.state()) if self.fed_state else None
        answer = d.patch(change)
        return answer.status, before, change

    def sea(self, d):
        self.turn = getattr(self, "turn", 0) + 1
        return d.patch({"sea": {"windSpeed": 5 + self.turn % 9,
                                "synthesiser": "FFT"}}).status

    def remove(self, d):
        d.request("PUT", "/v1/views/gone", {"entity": 1, "width": 32,
                                            "height": 32})
        return d.request("DELETE", "/v1/views/gone").status

    @staticmethod
    def state(d):
        return d.get("/v1/state").status

    @staticmethod
    def jpeg(d):
        return d.get("/v1/views/bridge/frame.jpg?width=64&height=36").status

    @staticmethod
    def png(d):
        return d.get("/v1/views/bridge/frame.png?width=64&height=36").status

    @staticmethod
    def exr(d):
        return d.get("/v1/views/bridge/frame.exr?width=64&height=36"
                     "&layers=radiance,depth,id").status

    @staticmethod
    def surface(d):
        with Session(d.connect_unix()) as session:
            reply = session.ask(surface={"points": [
                {"east": 3.0 * i, "north": i} for i in range(40)]})
            return 200 if reply and reply.surface.points else 500

    @staticmethod
    def frames(d):
        with Session(d.connect_unix()) as session:
            reply = session.ask(frames={"frames": [
                {"view": "bridge", "width": 64, "height": 36}]})
            return 200 if reply and reply.frames.frames else 500

    @staticmethod
    def session_patch(d):
        with Session(d.connect_unix()) as session:
            reply = session.ask(patch={"state": {"sky": {"visibility": 9000}}})
            return 200 if reply and not reply.HasField("error") else 500

    @staticmethod
    def stream(d):
        with d.connect_http(20) as s:
            s.sendall(b"GET /v1/views/bridge/mjpeg HTTP/1.1\r\n"
                      b"Host: localhost\r\n\r\n")
            data = b""
            while data.count(b"image/jpeg") < 2:
                more = s.recv(1 << 16)
                if not more:
                    return 500
                data += more
        return 200

    @staticmethod
    def video(d):
        with d.connect_http(20) as s:
            s.sendall(b"GET /v1/views/bridge/ts HTTP/1.1\r\n"
                      b"Host: localhost\r\n\r\n")
            data = b""
            while len(data) < 3000:
                more = s.recv(1 << 16)
                if not more:
                    return 500
                data += more
            return int(data.split()[1])

    @staticmethod
    def optics(d):
        return d.get("/v1/optics/sky").status

    def heap(self, d):
        return d.metrics().get("process_heap_bytes", 0)

    def at_rest(self, d):
        """What stays when moments of the sea, 14 MB each, have gone back, which
        takes 5 s from the last question about them."""
        least = self.heap(d)
        for _ in range(REST_S):
            time.sleep(1)
            least = min(least, self.heap(d))
        return least

    # --- the walk -----------------------------------------------------------

    OPERATIONS = ("edit", "state", "session_patch", "remove", "surface",
                  "jpeg", "png", "exr", "frames", "stream", "optics", "sea",
                  "video")

    def test_operations(self):
        with StarvedDaemon(self.starve, "--state",
                           os.path.join(self.folder.name, "state.json"),
                           unix=True) as d:
            self.fed_state = False
            d.patch({"sea": {"synthesiser": "FFT"}, "views": {
                "bridge": {"width": 64, "height": 36}}})
            names = [n for n in self.OPERATIONS if ALL or n not in SLOW]
            for name in names:
                work = getattr(self, name)
                for _ in range(2):
                    good = work(d)
                    good = good[0] if isinstance(good, tuple) else good
                    self.assertIn(good, (200, 204), name)
            for name in names:
                self.walk(d, name)
            # The seas that were asked for fill caches for some rounds; what
            # grows after them was lost.
            self.rounds(d, 3)
            grown = self.at_rest(d)
            self.rounds(d, 3)
            grown = self.at_rest(d) - grown
            print(f"{grown / 1e3:.0f} kB of heap more")
            if not SANITIZED:
                self.assertLess(grown, MOST_GROWTH)

    def rounds(self, d, count):
        for _ in range(count):
            for name in ("edit", "remove", "surface", "jpeg", "png", "frames"):
                self.walk(d, name)

    def walk(self, d, name):
        work = getattr(self, name)
        first = self.starve.calls()
        work(d)
        calls, of = self.chosen(first, self.starve.calls(), SHORT)
        counts = collections.Counter()
        begun = time.monotonic()
        for call in calls:
            site = self.starve.site(call)
            self.starve.fail(self.starve.calls() + call - first)
            self.fed_state = name == "edit"
            before = plain(d.state()) if name == "edit" and d.alive() else None
            self.starve.fail(self.starve.calls() + call - first)
            refused = self.starve.failed()
            self.fed_state = False
            try:
                status = work(d)
            except (OSError, ValueError) as error:
                status = type(error).__name__
            except Exception as error:  # noqa: BLE001: http.client's
                status = type(error).__name__
            self.starve.feed()
            happened = self.starve.failed() > refused
            time.sleep(0.02)
            if not d.alive():
                self.fail(f"{name}: the daemon ended; refused at "
                          f"{where(site)}\n{d.log()[-1500:]}")
            counts[str(status[0] if isinstance(status, tuple) else status)
                   if happened else "not met"] += 1
            if before is not None and isinstance(status, tuple):
                now = plain(d.state())
                if status[0] == 200:
                    self.assertEqual(now["sky"]["visibility"],
                                     status[2]["sky"]["visibility"])
                    self.assertEqual(target(now),
                                     status[2]["entities"]["9"]["name"])
                else:
                    for part in ("sky", "sea", "views"):
                        self.assertEqual(now[part], before[part], where(site))
                    self.assertEqual(target(now), target(before), where(site))
            try:
                again = work(d)
            except Exception:  # noqa: BLE001: with the place
                self.fail(f"{name}: refused at {where(site)}, and again fed\n"
                          f"{d.log()[-1500:]}")
            again = again[0] if isinstance(again, tuple) else again
            self.assertIn(again, (200, 201, 204), (name, where(site)))
        print(f"{name:14} {len(calls)} of {of}: {dict(counts)}, "
              f"{time.monotonic() - begun:.1f} s", flush=True)

    def test_start(self):
        """Starts, or says why not and ends."""
        def begin(fail=None):
            self.starve.reset()
            if fail is not None:
                self.starve.fail(fail)
            try:
                d = StarvedDaemon(self.starve)
            except RuntimeError as error:
                return str(error)
            calls = self.starve.calls()
            picture = 0
            with contextlib.suppress(OSError):
                picture = self.jpeg(d)
            alive = d.alive()
            self.starve.feed()
            text = d.log()
            status = d.stop()
            self.assertTrue(alive, text)
            self.assertEqual(status, 0, text)
            return calls, picture
        last, picture = begin()
        self.assertEqual(picture, 200)
        calls, of = self.chosen(0, last, SHORT_START)
        sites = [(c, self.starve.site(c)) for c in calls]
        counts = collections.Counter()
        for call, site in sites:
            result = begin(call)
            if isinstance(result, str):
                self.assertIn("DMN-009", result, where(site))
                counts["refused"] += 1
            else:
                counts[f"picture {result[1]}"] += 1
        print(f"start {len(calls)} of {of} places, {last} calls: "
              f"{dict(counts)}")


if __name__ == "__main__":
    unittest.main(verbosity=2)
