#!/usr/bin/python3
"""Views as HLS: what playlists say and what their files hold, read by a reader
of its own and by ffmpeg; reloads that wait; edges that keep copies; the end of a
stream that nobody asks for."""
import datetime
import http.client
import os
import re
import shutil
import subprocess
import sys
import threading
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import SLOW_S, Daemon, until

LIST = "/v1/views/bridge/hls.m3u8"
TYPE = "application/vnd.apple.mpegurl"


class Playlist:
    """RFC 8216 and the parts of its second edition, as a player reads them."""

    def __init__(self, text, base=LIST):
        lines = text.splitlines()
        assert lines[0] == "#EXTM3U", lines[0]
        self.tags, self.segments, self.hint = {}, [], None
        fresh = {"parts": [], "broken": False, "at": None}
        self.open = dict(fresh, parts=[])
        length = None
        for line in lines[1:]:
            name, _, value = line.partition(":")
            if name == "#EXT-X-PART":
                part = dict(re.findall(r'([A-Z-]+)=("[^"]*"|[^,]*)', value))
                self.open["parts"].append(
                    (self.join(base, part["URI"].strip('"')),
                     float(part["DURATION"]), "INDEPENDENT" in part))
            elif name == "#EXT-X-PROGRAM-DATE-TIME":
                self.open["at"] = datetime.datetime.fromisoformat(
                    value.replace("Z", "+00:00")).timestamp()
            elif name == "#EXT-X-DISCONTINUITY":
                self.open["broken"] = True
            elif name == "#EXTINF":
                length = float(value.rstrip(","))
            elif name == "#EXT-X-PRELOAD-HINT":
                self.hint = self.join(base, re.search(
                    r'URI="([^"]*)"', value).group(1))
            elif line.startswith("#"):
                self.tags[name] = value
            else:
                self.segments.append(dict(
                    self.open, length=length, path=self.join(base, line)))
                self.open = dict(fresh, parts=[])
        self.first = int(self.tags["#EXT-X-MEDIA-SEQUENCE"])

    @staticmethod
    def join(base, reference):
        return os.path.normpath(os.path.join(os.path.dirname(base), reference))


def packets(data):
    """Counters of a transport stream, by PID, and where its tables stand."""
    assert len(data) % 188 == 0 and data
    out = {}
    for at in range(0, len(data), 188):
        assert data[at] == 0x47
        pid = (data[at + 1] & 31) << 8 | data[at + 2]
        out.setdefault(pid, []).append(data[at + 3] & 15)
    return out


class Case(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon("--quality", "full")
        cls.daemon.patch({"views": [
            {"name": "bridge", "entity": 1, "width": 160, "height": 90},
            {"name": "other", "entity": 1, "width": 64, "height": 36}]})
        # The first picture waits for the programs: on a loaded machine longer
        # than a stream may stand still, which its list would rightly tell.
        assert cls.daemon.get("/v1/views/bridge/frame.jpg").status == 200

    @classmethod
    def tearDownClass(cls):
        cls.daemon.stop()

    def load(self, query="", place=LIST):
        # A busy machine draws none for so long that it says so: 503, later.
        got = until("a playlist", lambda: (
            r := self.daemon.get(place + query)).status != 503 and r)
        self.assertEqual(got.status, 200, got.body[:200])
        self.assertEqual(got.headers["Content-Type"], TYPE)
        return Playlist(got.body.decode(), place)

    def file(self, path):
        got = self.daemon.get(path)
        self.assertEqual(got.status, 200, path)
        self.assertEqual(got.headers["Content-Type"], "video/mp2t")
        return got.body


class Playlists(Case):
    def test_segments(self):
        p = self.load()
        while p.first + len(p.segments) < 4:
            p = self.load(f"?_HLS_msn={p.first + len(p.segments)}")
        target = int(p.tags["#EXT-X-TARGETDURATION"])
        longest = float(re.search(r"PART-TARGET=([\d.]+)",
                                  p.tags["#EXT-X-PART-INF"]).group(1))
        whole = b""
        for i, s in enumerate(p.segments):
            self.assertLessEqual(round(s["length"]), target)
            self.assertFalse(s["broken"])
            data = self.file(s["path"])
            whole += data
            if s["parts"]:
                # A segment is its parts, one after the other.
                self.assertEqual(
                    b"".join(self.file(part[0]) for part in s["parts"]), data)
                self.assertAlmostEqual(sum(part[1] for part in s["parts"]),
                                       s["length"], delta=1e-4)
                self.assertTrue(s["parts"][0][2], "begins with a key frame")
            # Times go on: what is told of a segment is when its first picture
            # was stamped (ms are rounded down).
            if i > 0:
                before = p.segments[i - 1]
                self.assertAlmostEqual(s["at"] - before["at"],
                                       before["length"], delta=0.005)
        for pid, counters in packets(whole).items():
            for a, b in zip(counters, counters[1:]):
                self.assertEqual(b, (a + 1) & 15, f"PID {pid:#x}")
        self.assertLess(abs(time.time() - p.segments[-1]["at"]), SLOW_S)
        print(f"parts of at most {longest:g} s, segments of "
              f"{[round(s['length'], 2) for s in p.segments]} s")

    def test_reload_waits_for_what_it_asks(self):
        p = self.load()
        msn = p.first + len(p.segments)
        q = self.load(f"?_HLS_msn={msn}")
        self.assertGreaterEqual(q.first + len(q.segments), msn + 1)
        msn = q.first + len(q.segments)
        q = self.load(f"?_HLS_msn={msn}&_HLS_part=0")
        there = q.first + len(q.segments)
        self.assertTrue(there > msn or q.open["parts"])
        data = self.file(q.hint)  # which is made meanwhile
        packets(data)

    def test_once_for_all_who_watch(self):
        before = self.daemon.metrics()["pelagos_video_frames_total"]
        begun = time.monotonic()
        lists = []
        threads = [threading.Thread(target=lambda: lists.append(
            self.load("?_HLS_msn=1").segments)) for _ in range(12)]
        for t in threads:
            t.start()
        for t in threads:
            t.join()
        bodies = {self.file(s[-1]["path"]) for s in lists[:1] * 12}
        self.assertEqual(len(bodies), 1)
        made = self.daemon.metrics()["pelagos_video_frames_total"] - before
        self.assertLess(made, 40 * (time.monotonic() - begun + 1))
        self.assertEqual(self.daemon.metrics()["pelagos_hls_streams"], 1)

    @unittest.skipUnless(shutil.which("ffmpeg"), "no ffmpeg")
    def test_ffmpeg_plays_it(self):
        out = subprocess.run(
            ["ffmpeg", "-v", "error", "-i", self.daemon.url(LIST), "-t", "2.5",
             "-f", "framemd5", "-"], capture_output=True, text=True,
            timeout=3 * SLOW_S)
        self.assertEqual(out.stderr, "")
        pictures = [line for line in out.stdout.splitlines()
                    if line and not line.startswith("#")]
        self.assertGreater(len(pictures), 5)
        self.assertIn("160x90", out.stdout)

    def test_caches_may_keep_it(self):
        got = self.daemon.get(LIST)
        self.assertEqual(got.headers["Cache-Control"], "max-age=1")
        path = Playlist(got.body.decode()).segments[-1]["path"]
        got = self.daemon.get(path)
        self.assertRegex(got.headers["Cache-Control"], "max-age=60, immutable")
        got = self.daemon.get("/v1/hls/00000000-1.ts")
        self.assertEqual(got.status, 404)
        self.assertEqual(got.headers["Cache-Control"], "no-store")

    def test_refusals(self):
        p = self.load()
        for query, path in (("?with=5", "with"), ("?bitrate=1", "bitrate"),
                            ("?_HLS_part=1", "_HLS_part"),
                            ("?_HLS_msn=-1", "_HLS_msn"),
                            (f"?_HLS_msn={p.first + len(p.segments) + 9}",
                             "_HLS_msn")):
            got = self.daemon.get(LIST + query)
            self.assertEqual(got.status, 400, query)
            self.assertIn(path, got.body.decode(), query)
        self.assertEqual(
            self.daemon.get("/v1/views/nothing/hls.m3u8").status, 404)
        last = p.segments[-1]["path"]
        for path in ("/v1/hls/x.ts", "/v1/hls/" + "9" * 47, last + "x",
                     last.replace(".ts", "-99.ts"),
                     re.sub(r"-\d+\.ts", "-99999999999999999999.ts", last),
                     re.sub(r"-\d+\.ts", "-.ts", last),
                     re.sub(r"-\d+\.ts", "--1.ts", last)):
            self.assertEqual(self.daemon.get(path).status, 404, path)


class Ends(Case):
    def test_no_segment_has_number_zero(self):
        """HLS.js appends the parts of segment 0 again and again, each further
        on, and stands seconds behind ever after."""
        place = "/v1/views/other/hls.m3u8"
        for query in ("?_HLS_msn=0", "?_HLS_msn=1", ""):
            p = self.load(query, place)
            self.assertEqual(p.first, 1, query)
            self.assertTrue(p.segments, query)
            self.assertRegex(p.segments[0]["path"], r"-1\.ts$")
            self.assertFalse(p.segments[0]["broken"])

    def test_view_goes_while_it_is_waited_for(self):
        self.daemon.patch({"views": [
            {"name": "bridge", "entity": 1, "width": 160, "height": 90}]})
        self.daemon.request("PUT", "/v1/views/brief", {"entity": 1})
        got = []
        place = "/v1/views/brief/hls.m3u8"
        p = self.load(place=place)
        msn = p.first + len(p.segments) + 1
        t = threading.Thread(target=lambda: got.append(
            self.daemon.get(f"{place}?_HLS_msn={msn}")))
        t.start()
        time.sleep(0.1)
        self.daemon.request("DELETE", "/v1/views/brief")
        t.join()
        self.assertEqual(got[0].status, 404)
        self.assertIn("deleted", got[0].body.decode())

    def test_who_leaves_is_not_waited_for(self):
        p = self.load()
        before = self.daemon.metrics()["pelagos_http_connections"]
        msn = p.first + len(p.segments) + 1
        waiting = []
        for _ in range(40):
            s = self.daemon.connect_http()
            s.sendall(f"GET {LIST}?_HLS_msn={msn} HTTP/1.1\r\n"
                      "Host: localhost\r\n\r\n".encode())
            waiting.append(s)
        for s in waiting:
            s.close()
        until("they are gone", lambda: self.daemon.metrics()[
            "pelagos_http_connections"] <= before)
        self.assertEqual(self.daemon.metrics()["pelagos_hls_waiting"], 0)

    def test_clock_stands(self):
        """A picture that is long in coming begins another programme."""
        p = self.load()
        self.daemon.patch({"clock": {"mode": "STEPPED"}})
        time.sleep(3)
        self.daemon.patch({"clock": {"mode": "FREE"}})
        end = time.monotonic() + SLOW_S
        while time.monotonic() < end:
            p = self.load(f"?_HLS_msn={p.first + len(p.segments)}")
            if any(s["broken"] for s in p.segments):
                break
        broken = [s["broken"] for s in p.segments]
        if not any(broken):  # pictures go on while the clock stands
            self.assertGreater(len(p.segments), 2)
        for s in p.segments:
            self.assertLessEqual(round(s["length"]), 2)

    def test_stops_with_a_reader_waiting(self):
        with Daemon() as daemon:
            daemon.patch({"views": [
                {"name": "bridge", "entity": 1, "width": 64, "height": 36}]})
            answer = until("a playlist", lambda: (
                r := daemon.get(LIST)).status == 200 and r)
            p = Playlist(answer.body.decode())
            msn = p.first + len(p.segments) + 1
            connection = http.client.HTTPConnection(
                "127.0.0.1", daemon.http_port, timeout=SLOW_S)
            connection.request("GET", f"{LIST}?_HLS_msn={msn}")
            time.sleep(0.1)
            self.assertEqual(daemon.stop(), 0)
            connection.close()

    def test_nobody_asks(self):
        self.load()
        self.assertGreaterEqual(self.daemon.metrics()["pelagos_hls_streams"], 1)
        until("it is over", lambda: self.daemon.metrics()[
            "pelagos_hls_streams"] == 0, 15 + SLOW_S, 1)
        self.assertEqual(self.daemon.metrics()["pelagos_frames_subscriptions"],
                         0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
