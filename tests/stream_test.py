#!/usr/bin/python3
"""Live streams: WebSocket and RTSP end to end, with slow, late and hostile clients.

Figures are printed; what is asserted has room for a machine that is busy.
SOAK=1 runs the crowd for 60 s instead of a few.
"""
import os
import re
import selectors
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import unittest.mock

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from live_client import Closed, Live, Refused
from pelagos_daemon import SANITIZED, SLOW_S, Daemon, until
from rtsp_client import RtspClient

SOAK = os.environ.get("SOAK") == "1"
CREDIT = 12
JPEG_START = b"\xff\xd8\xff"


def nal_types(data):
    """Types of the NAL units of an Annex B access unit."""
    types, at = [], data.find(b"\0\0\1")
    while at >= 0:
        types.append(data[at + 3] & 31)
        at = data.find(b"\0\0\1", at + 3)
    return types


VIEW = {"views": [
    {"name": "bridge", "entity": 1, "width": 320, "height": 180}]}


class Case(unittest.TestCase):
    options = ()

    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(*cls.options)
        cls.daemon.patch(VIEW)

    @classmethod
    def tearDownClass(cls):
        cls.status = cls.daemon.stop()
        assert cls.status == 0, f"the daemon ended with {cls.status}"

    def metric(self, name):
        return self.daemon.metrics()[name]

    def no_viewers(self):
        until("no viewer left",
              lambda: self.metric("pelagos_live_viewers") == 0)


class Pictures(Case):
    def test_h264_begins_with_a_key_frame(self):
        begun = time.time()
        with Live(self.daemon, "bridge") as live:
            head, data = live.picture()
            print(f"first picture after "
                  f"{1e3 * (time.monotonic() - live.opened):.0f} ms")
            self.assertEqual((head.version, head.kind, head.size), (1, 1, 80))
            self.assertTrue(head.key)
            self.assertFalse(head.gap)
            self.assertEqual((head.width, head.height), (320, 180))
            self.assertEqual({7, 8, 5} - set(nal_types(data)), set())
            stream = live.texts[0]
            self.assertEqual((stream["type"], stream["codec"]),
                             ("stream", "h264"))
            numbers, times = [head.number], [head.time]
            followed = 0
            while followed < 20:
                live.ack(head)
                head, data = live.picture()
                # Nobody asks for one, unless this reader was too slow.
                self.assertEqual(head.key, head.gap)
                self.assertEqual(set(nal_types(data)) & {1, 5},
                                 {5} if head.key else {1})
                followed += not head.key
                self.assertTrue(head.drawn <= head.encoded <= head.queued)
                # One machine, one clock; stamps have microseconds.
                self.assertLessEqual(begun - 1e-5, head.stamp * 1e-6)
                begun = head.stamp * 1e-6
                self.assertLessEqual(begun + head.queued * 1e-6,
                                     time.time() + 1e-5)
                numbers.append(head.number)
                times.append(head.time)
            self.assertEqual(numbers, sorted(set(numbers)))
            self.assertEqual(times, sorted(set(times)))
        self.no_viewers()

    @unittest.skipUnless(shutil.which("ffmpeg"), "no ffmpeg")
    def test_ffmpeg_decodes_it(self):
        data = b""
        with Live(self.daemon, "bridge", "?width=322&height=182") as live:
            for _ in range(15):
                head, part = live.picture()
                live.ack(head)
                data += part
        with tempfile.NamedTemporaryFile(suffix=".h264") as f:
            f.write(data)
            f.flush()
            out = subprocess.run(
                ["ffprobe", "-v", "error", "-count_frames",
                 "-show_entries", "stream=width,height,nb_read_frames,profile",
                 "-of", "default=nk=0:nw=1", f.name],
                capture_output=True, text=True, check=True).stdout
        self.assertIn("width=322", out)
        self.assertIn("height=182", out)
        self.assertIn("nb_read_frames=15", out)
        self.assertIn("Constrained Baseline", out)

    def test_jpeg(self):
        with Live(self.daemon, "bridge", "?codec=jpeg&quality=50") as live:
            for _ in range(5):
                head, data = live.picture()
                self.assertEqual(head.kind, 2)
                self.assertTrue(head.key)
                self.assertTrue(data.startswith(JPEG_START))
                live.ack(head)

    def test_encoded_once_for_all(self):
        lives = [Live(self.daemon, "bridge") for _ in range(8)]
        try:
            before = self.metric("pelagos_video_frames_total")
            sent = self.metric("pelagos_live_frames_sent_total")
            payloads = {}
            for _ in range(20):
                for live in lives:
                    head, data = live.picture()
                    live.ack(head)
                    self.assertEqual(payloads.setdefault(head.number, data),
                                     data)
            encoded = self.metric("pelagos_video_frames_total") - before
            sent = self.metric("pelagos_live_frames_sent_total") - sent
            print(f"8 viewers: {encoded:.0f} encoded, {sent:.0f} sent")
            self.assertGreater(sent, 4 * encoded)
        finally:
            for live in lives:
                live.close()
        self.no_viewers()

    def test_nobody_watches_nothing_is_drawn(self):
        self.no_viewers()
        until("the last frames", lambda: self.still("pelagos_frames_drawn"
                                                    "_total"))
        self.assertTrue(self.still("pelagos_video_frames_total"))

    def still(self, name):
        before = self.metric(name)
        time.sleep(0.3)
        return self.metric(name) == before

    def test_profile_changes_while_it_runs(self):
        with Live(self.daemon, "bridge", "?bitrate=800") as live:
            head, _ = live.picture()
            live.ack(head)
            live.profile(bitrate=400)  # the only viewer: the same encoder
            # A stream that had to slow down has described itself before.
            until("the new bit rate",
                  lambda: live.text("stream")["bitrate"] == 400)
            head, _ = live.picture()
            live.ack(head)
            self.assertFalse(head.key)
            time.sleep(0.6)
            live.profile(width=160, height=90, bitrate=400)
            end = time.monotonic() + SLOW_S
            while head.width != 160 and time.monotonic() < end:
                head, data = live.picture()
                live.ack(head)
            self.assertEqual((head.width, head.height), (160, 90))
            self.assertTrue(head.key)
            # As fast as they can be read: the first may be taken.
            for _ in range(20):
                live.profile(width=160, height=90, bitrate=400)
            self.assertIn("two profiles a second",
                          live.text("error")["message"])
            time.sleep(0.6)
            live.profile(width=5)
            until("the other answer",
                  lambda: "outside" in live.text("error")["message"])
            live.ack(head)
            self.assertEqual(live.picture()[0].width, 160)

    def test_size_of_the_view_changes_under_three(self):
        """Each goes on with a key frame of the new size, at the same frame."""
        lives = [Live(self.daemon, "bridge", "?credit=12") for _ in range(3)]
        try:
            for size in (64, 48), (401, 99), (320, 180):
                answer = self.daemon.patch({"views": {"bridge": {
                    "width": size[0], "height": size[1]}}})
                revision = int(answer.json()["revision"])
                first = set()
                for live in lives:
                    head, _ = live.picture()
                    while head.revision < revision:
                        live.ack(head)
                        head, _ = live.picture()
                    live.ack(head)
                    self.assertEqual((head.width, head.height),
                                     (size[0] & ~1, size[1] & ~1))
                    self.assertTrue(head.key)
                    first.add(head.number)
                self.assertEqual(len(first), 1)
        finally:
            for live in lives:
                live.close()
        self.no_viewers()

    def test_key_frames_at_most_one_a_second(self):
        with Live(self.daemon, "bridge") as live:
            keys, pictures = 0, 0
            while keys < 4:
                head, _ = live.picture()
                live.ack(head)
                live.want_key()
                keys += head.key
                pictures += 1
            spent = time.monotonic() - live.opened
            print(f"{keys} key frames among {pictures} in {spent:.1f} s")
            # What is late here was in time there.
            self.assertLessEqual(keys, spent + 2)

    def test_time(self):
        with Live(self.daemon, "bridge") as live:
            asked = time.time()
            live.ask_time(0x123456789abcdef0)
            answer = live.text("time")
            self.assertEqual(answer["echo"], "123456789abcdef0")
            # One machine, one clock, written to microseconds.
            self.assertLessEqual(asked - 1e-5, answer["unix"])
            self.assertLessEqual(answer["unix"], time.time() + 1e-5)

    def test_view_deleted(self):
        self.daemon.request("PUT", "/v1/views/gone", {"width": 64,
                                                      "height": 64})
        with Live(self.daemon, "gone") as live:
            live.picture()
            self.daemon.request("DELETE", "/v1/views/gone")
            self.assertIn("deleted", live.text("end")["message"])
            with self.assertRaises(Closed) as closed:
                live.picture()
            self.assertEqual(closed.exception.code, 4404)


class Crowd(Case):
    def test_patch_is_in_every_frame_begun_after_it(self):
        """However late the frames are: what was answered is in the next."""
        late = []
        with Live(self.daemon, "bridge") as live:
            for _ in range(10):
                head, _ = live.picture()
                live.ack(head)
            for i in range(8):
                answer = self.daemon.patch({"views": {"bridge": {
                    "pitch": -1 - 0.5 * i}}})
                answered = time.time()
                revision = int(answer.json()["revision"])
                begun_after = False
                while not begun_after:
                    head, _ = live.picture()
                    live.ack(head)
                    begun_after = head.stamp * 1e-6 > answered
                self.assertGreaterEqual(head.revision, revision)
                late.append(time.time() - answered)
        late.sort()
        print(f"patch to the frame that shows it: there after "
              f"{1e3 * late[len(late) // 2]:.0f} ms (median), two frame times "
              f"are 67 ms")

    def test_late_joiner(self):
        with Live(self.daemon, "bridge") as early:
            for _ in range(30):
                head, _ = early.picture()
                early.ack(head)
            figures = []
            for _ in range(3):
                asked = time.time()
                with Live(self.daemon, "bridge") as late:
                    head, _ = late.picture()
                    figures.append(time.monotonic() - late.opened)
                    # None from before it came.
                    self.assertTrue(head.key)
                    self.assertGreater(
                        head.stamp * 1e-6 + head.encoded * 1e-6, asked)
        print("late joiners: first picture after " +
              ", ".join(f"{1e3 * f:.0f} ms" for f in figures))

    def test_slow_client_is_skipped_and_comes_back(self):
        with Live(self.daemon, "bridge") as live:
            heads = [live.picture()[0] for _ in range(3)]
            live.socket.settimeout(1.0)
            with self.assertRaises(TimeoutError):  # credit is 3
                while True:
                    heads.append(live.picture()[0])
            self.assertEqual(len(heads), 3)
            with Live(self.daemon, "bridge") as other:
                for _ in range(5):
                    other.ack(other.picture()[0])
            live.socket.settimeout(SLOW_S)
            live.ack(heads[-1])
            head, _ = live.picture()
            self.assertTrue(head.key and head.gap)
            print(f"missed {head.missed} while it slept")
            self.assertLess(live.texts[-1]["bitrate"],
                            live.texts[0]["bitrate"])  # it follows the client

    def one_viewer(self, seconds):
        """The control thread's time with one viewer, s a picture."""
        with Live(self.daemon, "bridge") as live:
            live.picture()
            cpu, count = self.daemon.control_cpu(), 0
            end = time.monotonic() + seconds
            while time.monotonic() < end:
                live.ack(live.picture()[0])
                count += 1
            return (self.daemon.control_cpu() - cpu) / count

    def test_stalled_among_good(self):
        """16 of 64 viewers stall; the others miss nothing but by their own
        lateness."""
        seconds = 60 if SOAK else 4
        alone = self.one_viewer(seconds / 4)
        # This script serves 48 viewers beside the daemon: more credit keeps its
        # own lateness out of the figures.
        good = [Live(self.daemon, "bridge", f"?credit={CREDIT}")
                for _ in range(48)]
        stalled = [Live(self.daemon, "bridge", buffer=4096)
                   for _ in range(16)]
        chosen = selectors.DefaultSelector()
        for live in good:
            live.heads, live.acknowledged = [], []
            self.take_picture(live)
            live.socket.settimeout(SLOW_S)
            chosen.register(live.socket, selectors.EVENT_READ, live)
        before, drawn = self.daemon.rss(), self.frames()
        cpu = self.metric("process_cpu_seconds_total")
        control = self.daemon.control_cpu()
        begun = time.monotonic()
        got = 0
        # On a busy machine until it came round to each of them: at least twice
        # what was in flight.
        while ((now := time.monotonic()) < begun + seconds or
               now < begun + SLOW_S and
               any(len(live.heads) < 2 * CREDIT for live in good)):
            for key, _ in chosen.select(0.5):
                self.take_picture(key.data)
                got += 1
        seconds = time.monotonic() - begun
        control = self.daemon.control_cpu() - control
        drawn = self.frames() - drawn
        growth = self.daemon.rss() - before
        cpu = self.metric("process_cpu_seconds_total") - cpu
        gaps = sum(head.gap for live in good for head in live.heads)
        print(f"{seconds:.0f} s, 48 good and 16 stalled viewers: {drawn:.0f} "
              f"frames drawn, {got / 48:.0f} received by each, {gaps} gaps, "
              f"growth {growth / 1e6:.1f} MB, {100 * cpu / seconds:.1f} % of a "
              f"core in all, {30 * 100 * (control / drawn - alone) / 63:.3f} % "
              f"a viewer more at 30 Hz")
        for live in good + stalled:
            live.close()
        if not SANITIZED:
            self.assertLess(growth, 64e6)
        for live in good:
            self.assertGreaterEqual(len(live.heads), 2 * CREDIT)
            self.explain_gaps(live)
        self.no_viewers()

    def take_picture(self, live):
        head, _ = live.picture()
        live.heads.append(head)
        live.acknowledged.append(time.time())
        live.ack(head)

    def explain_gaps(self, live):
        """A picture is left out for a viewer only where CREDIT others are not
        acknowledged. Of those the first was acknowledged too late if half of
        them had been queued before that: the daemon's own pictures are the
        measure, so a busy machine stretches both."""
        for i, head in enumerate(live.heads):
            if i > 0:
                lost = head.number - live.heads[i - 1].number - 1
                missed = head.missed - live.heads[i - 1].missed
                self.assertEqual(missed, lost if head.gap else 0)
            if head.gap and i >= CREDIT:
                half = live.heads[i - CREDIT // 2]
                self.assertGreater(
                    live.acknowledged[i - CREDIT],
                    (half.stamp + half.queued) * 1e-6,
                    f"picture {i} of {len(live.heads)}")

    def frames(self):
        return self.metric("pelagos_video_frames_total")


class Hostile(Case):
    def refused(self, status, **more):
        with self.assertRaises(Refused) as refused:
            Live(self.daemon, more.pop("view", "bridge"), **more)
        self.assertEqual(refused.exception.status, status)
        return refused.exception

    def test_handshake(self):
        self.refused(404, view="nothing")
        plain = self.refused(426, headers={"Upgrade": None})
        self.assertIn("Upgrade: websocket", plain.head)
        self.refused(426, headers={"Sec-WebSocket-Version": "8"})
        self.refused(400, headers={"Sec-WebSocket-Key": "short"})
        self.refused(403, headers={"Origin": "http://evil.example"})
        for query in ("?codec=av1", "?bitrate=5", "?width=-1", "?quality=",
                      "?credit=99", "?widht=1", "?width=1e3"):
            self.assertIn("code", self.refused(400, query=query).body)
        with Live(self.daemon, "bridge", "?nothing=1") as live:
            self.assertIn("X-Pelagos-Ignored: nothing", live.head)
            live.picture()
        own = f"http://127.0.0.1:{self.daemon.http_port}"
        with Live(self.daemon, "bridge", headers={"Origin": own}) as live:
            live.picture()

    def closes(self, code, send):
        with Live(self.daemon, "bridge") as live:
            live.picture()
            live.socket.settimeout(SLOW_S)
            try:
                send(live)
                while True:
                    live.message()
            except Closed as closed:
                self.assertIn(closed.code, (code, None))
            except (BrokenPipeError, ConnectionResetError):
                pass  # it did not wait for the rest
        self.no_viewers()
        self.assertTrue(self.daemon.alive())

    def test_messages_that_are_none(self):
        self.closes(1008, lambda live: live.send(b"x"))
        self.closes(1008, lambda live: live.send(bytes([9]) + bytes(15)))
        self.closes(1003, lambda live: live.send_frame(1, b"{}"))
        self.closes(1002, lambda live: live.send_frame(3, b"reserved"))
        self.closes(1002, lambda live: live.send_frame(2, bytes(16),
                                                       masked=False))
        self.closes(1009, lambda live: live.send(bytes(70000)))

    def test_endless_fragments(self):
        before = self.daemon.rss()

        def send(live):
            live.send_frame(2, bytes(1000), final=False)
            for _ in range(300):
                live.send_frame(0, bytes(1000), final=False)
        self.closes(1009, send)
        if not SANITIZED:
            self.assertLess(self.daemon.rss() - before, 8e6)

    def test_flood_of_control(self):
        """Answers that nobody reads end the connection."""
        with Live(self.daemon, "bridge", buffer=4096) as live:
            live.socket.settimeout(SLOW_S)
            end = time.monotonic() + 3 * SLOW_S
            with self.assertRaises((BrokenPipeError, ConnectionResetError)):
                while time.monotonic() < end:
                    live.ask_time(0)
        self.no_viewers()

    def test_empty_frames_hold_up_nobody(self):
        with Live(self.daemon, "bridge") as good, \
                Live(self.daemon, "bridge") as bad:
            good.picture()
            bad.socket.settimeout(0.2)
            flood = b"\x80\x80\0\0\0\0" * 2000  # empty continuations: an error
            pings = b"\x89\x80\0\0\0\0" * 100
            begun, count = time.monotonic(), 0
            good.socket.settimeout(SLOW_S)
            while count < 30:
                try:
                    bad.socket.sendall(pings)
                except OSError:
                    pass
                head, _ = good.picture()
                good.ack(head)
                count += 1
            print(f"{count} pictures in {time.monotonic() - begun:.1f} s "
                  "beside a flood of pings")
            try:
                bad.socket.sendall(flood)
            except OSError:
                pass
        self.no_viewers()

    def test_wrong_acknowledgements(self):
        with Live(self.daemon, "bridge") as live:
            head, _ = live.picture()
            live.send(struct.pack("<B7xQ", 1, 2 ** 64 - 1))
            live.send(struct.pack("<B7xQ", 1, 0))
            for _ in range(5):
                head, _ = live.picture()
                live.ack(head)


class Motion(Case):
    @unittest.skipUnless(shutil.which("ffprobe"), "no ffprobe")
    def test_times_of_arrival(self):
        """As live.md says how: ffmpeg's 25 Hz are not the stream's."""
        def span(*options):
            shown = subprocess.run(
                ["ffprobe", "-v", "error", *options, "-f", "mpjpeg",
                 "-read_intervals", "%+#20", "-show_entries",
                 "packet=pts_time", "-of", "csv=p=0",
                 self.daemon.url("/v1/views/bridge/mjpeg?fps=5")],
                capture_output=True, text=True, timeout=SLOW_S).stdout.split()
            self.assertEqual(len(shown), 20)
            return float(shown[-1].strip(",")) - float(shown[0].strip(","))
        self.assertAlmostEqual(span(), 19 / 25, delta=0.01)
        begun = time.monotonic()
        known = span("-use_wallclock_as_timestamps", "1")
        took = time.monotonic() - begun
        print(f"20 pictures at 5 Hz: {known:.2f} s by their arrival")
        # Pictures may be late on a busy machine, never early.
        self.assertGreater(known, 19 / 5 * 0.8)
        self.assertLess(known, took + 0.1)

    def test_parts_tell_their_time(self):
        with self.daemon.connect_http() as s:
            s.sendall(b"GET /v1/views/bridge/mjpeg HTTP/1.1\r\n"
                      b"Host: localhost\r\n\r\n")
            f = s.makefile("rb")
            stamps = {}
            while len(stamps) < 2:
                name, _, value = f.readline().partition(b": ")
                if name in (b"X-Timestamp", b"X-Pelagos-Stamp"):
                    stamps[name] = float(value)
        self.assertAlmostEqual(stamps[b"X-Timestamp"],
                               stamps[b"X-Pelagos-Stamp"] * 1e-6, delta=1e-3)


class Ts(Case):
    @unittest.skipUnless(shutil.which("ffprobe"), "no ffprobe")
    def test_ffprobe_opens_it(self):
        begun = time.monotonic()
        out = subprocess.run(
            ["ffprobe", "-v", "error", "-read_intervals", "%+#20",
             "-count_frames", "-show_entries",
             "format=format_name:stream=codec_name,width,nb_read_frames",
             "-of", "default=nk=0:nw=1",
             self.daemon.url("/v1/views/bridge/ts?width=480&bitrate=900")],
            capture_output=True, text=True, timeout=3 * SLOW_S)
        print(f"ffprobe, 20 packets of it: {time.monotonic() - begun:.1f} s")
        self.assertEqual(out.stderr, "")
        for text in "mpegts", "codec_name=h264", "width=480":
            self.assertIn(text, out.stdout)
        frames = int(re.search(r"nb_read_frames=(\d+)", out.stdout).group(1))
        self.assertGreater(frames, 1)

    def test_packets(self):
        with self.daemon.connect_http() as s:
            s.sendall(b"GET /v1/views/bridge/ts HTTP/1.0\r\n"
                      b"Host: localhost\r\n\r\n")
            data = b""
            while len(data) < 60000:
                data += s.recv(65536)
        head, body = data.split(b"\r\n\r\n", 1)
        self.assertIn(b"video/mp2t", head)
        counters = {}
        for at in range(0, len(body) - 187, 188):
            self.assertEqual(body[at], 0x47)
            pid = (body[at + 1] & 31) << 8 | body[at + 2]
            count = body[at + 3] & 15
            self.assertEqual(count, (counters.get(pid, count - 1) + 1) & 15)
            counters[pid] = count
        self.assertEqual(set(counters), {0, 0x100, 0x101})

    def test_stalled_reader_costs_nothing(self):
        stalled = self.daemon.connect_http()
        stalled.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        stalled.sendall(b"GET /v1/views/bridge/ts?width=1280&height=720"
                        b"&bitrate=20000 HTTP/1.0\r\n"
                        b"Host: localhost\r\n\r\n")
        until("it falls behind",
              lambda: self.metric("pelagos_ts_starved_total") > 0, 60)
        before = self.daemon.rss()
        drawn = self.metric("pelagos_video_frames_total")
        time.sleep(2)
        if not SANITIZED:
            self.assertLess(self.daemon.rss() - before, 8e6)
        # Some were under way; it may have taken a few more.
        self.assertLess(self.metric("pelagos_video_frames_total") - drawn, 20)
        while stalled.recv(65536):  # it goes on
            if self.metric("pelagos_ts_sent_bytes_total") > 3e6:
                break
        stalled.close()
        until("it is gone", lambda: self.metric("pelagos_ts_viewers") == 0)

    def test_refusals(self):
        # `quality` and `codec` are no parameters here: ignored, like any other.
        for query in "?bitrat=500", "?bitrate=1", "?width=x", "?widht=64":
            self.assertEqual(
                self.daemon.get("/v1/views/bridge/ts" + query).status, 400)
        self.assertEqual(self.daemon.get("/v1/views/nothing/ts").status, 404)


class Rtsp(Case):
    options = ("--rtsp", "127.0.0.1:0")

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.port = int(re.search(r"NET-006 .*:(\d+)/VIEW",
                                 cls.daemon.log()).group(1))

    def probe(self, *options):
        return subprocess.run(
            ["ffprobe", "-v", "error", *options, "-select_streams", "v",
             "-read_intervals", "%+#20", "-count_frames", "-show_entries",
             "stream=codec_name,width,height,nb_read_frames", "-of",
             "default=nk=0:nw=1"],
            capture_output=True, text=True, timeout=3 * SLOW_S).stdout

    @unittest.skipUnless(shutil.which("ffprobe"), "no ffprobe")
    def test_ffprobe_by_udp_and_tcp(self):
        for transport in "udp", "tcp":
            out = self.probe("-rtsp_transport", transport,
                             f"rtsp://127.0.0.1:{self.port}/bridge")
            self.assertIn("codec_name=h264", out)
            self.assertIn("width=320", out)
            frames = int(re.search(r"nb_read_frames=(\d+)", out).group(1))
            print(f"{transport}: {frames} frames decoded")
            self.assertGreater(frames, 1)

    @unittest.skipUnless(shutil.which("gst-launch-1.0"), "no gst-launch-1.0")
    def test_gstreamer_by_udp_and_tcp(self):
        for transport in "udp", "tcp":
            begun = time.monotonic()
            out = subprocess.run(
                ["gst-launch-1.0", "-q", "rtspsrc", "latency=0",
                 f"location=rtsp://127.0.0.1:{self.port}/bridge",
                 f"protocols={transport}", "!", "rtph264depay", "!",
                 "h264parse", "!", "openh264dec", "!", "identity",
                 "eos-after=15", "!", "fakesink", "sync=false"],
                capture_output=True, text=True, timeout=3 * SLOW_S)
            self.assertEqual(out.returncode, 0, out.stderr)
            print(f"gst-launch by {transport}: 15 frames decoded "
                  f"{time.monotonic() - begun:.1f} s after its start")

    def test_late_joiner_gets_a_key_frame_after_play(self):
        early = RtspClient(self.port, "bridge")
        early.play()
        figures = []
        for _ in range(3):
            for _ in range(10):
                early.picture()
            late = RtspClient(self.port, "bridge")
            late.play()
            waited = 0
            while not late.picture():
                waited += 1
            figures.append((time.monotonic() - late.asked, waited))
            late.close()
        early.close()
        print("first key frame after PLAY: " + ", ".join(
            f"{1e3 * f:.0f} ms and {n} pictures" for f, n in figures))
        # A joiner may ask for one every 200 ms, six pictures at 30 Hz, and as
        # many may be on their way.
        self.assertLessEqual(max(n for _, n in figures), 12)

    def test_stalled_client_delays_nobody(self):
        stalled = [RtspClient(self.port, "bridge", buffer=4096)
                   for _ in range(2)]
        good = RtspClient(self.port, "bridge")
        for client in stalled + [good]:
            client.play()
        before = self.daemon.rss()
        seconds = 60 if SOAK else 5
        end, count, longest = time.monotonic() + seconds, 0, 0.0
        begun = last = time.monotonic()
        while time.monotonic() < end or count < 20:
            good.picture()
            now = time.monotonic()
            longest, last = max(longest, now - last), now
            count += 1
        growth = self.daemon.rss() - before
        print(f"beside two stalled clients: {count / (last - begun):.1f} "
              f"frames a second, longest wait {1e3 * longest:.0f} ms, growth "
              f"{growth / 1e6:.1f} MB")
        if not SANITIZED:
            self.assertLess(growth, 32e6)
        for client in stalled + [good]:
            client.close()
        until("no stream left",
              lambda: self.metric("pelagos_rtsp_streams") == 0)

    def test_many_come_and_go(self):
        """80 that leave without a word: more than there are places, and each
        is served; nothing of them stays."""
        failed = []

        def visit():
            try:
                client = RtspClient(self.port, "bridge", timeout=2 * SLOW_S)
                client.play()
                client.close()
            except (AssertionError, OSError) as error:
                failed.append(error)
        for _ in range(5):
            visitors = [threading.Thread(target=visit) for _ in range(16)]
            for visitor in visitors:
                visitor.start()
            for visitor in visitors:
                visitor.join()
        self.assertEqual(failed, [])
        until("no client left",
              lambda: self.metric("pelagos_rtsp_clients") == 0 and
              self.metric("pelagos_rtsp_streams") == 0)

    def test_refusals(self):
        client = RtspClient(self.port, "nothing")
        self.assertEqual(client.ask("DESCRIBE", client.url)[0], 404)
        client.close()
        for junk in b"GET / HTTP/1.1\r\n\r\n", os.urandom(5000):
            with socket.create_connection(("127.0.0.1", self.port)) as s:
                s.sendall(junk)
        self.assertTrue(self.daemon.alive())
        self.daemon.request("PUT", "/v1/views/gone", {"width": 64,
                                                      "height": 64})
        client = RtspClient(self.port, "gone")
        client.play()
        client.picture()
        self.daemon.request("DELETE", "/v1/views/gone")
        until("no stream left",
              lambda: self.metric("pelagos_rtsp_streams") == 0 or
              client.close())
        other = RtspClient(self.port, "gone")
        self.assertEqual(other.ask("DESCRIBE", other.url)[0], 404)
        other.close()


class Without(Case):
    """A machine where GStreamer has no encoder at all."""

    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as empty, unittest.mock.patch.dict(
                os.environ, {"GST_PLUGIN_SYSTEM_PATH_1_0": empty,
                             "GST_REGISTRY": os.path.join(empty, "none")}):
            super().setUpClass()

    def test_no_encoder_is_said(self):
        with Live(self.daemon, "bridge") as live:
            end = live.text("end")
            self.assertIn("no H.264 encoder", end["message"])
            with self.assertRaises(Closed):
                live.picture()
        with Live(self.daemon, "bridge", "?codec=jpeg") as live:
            live.picture()


class Stop(unittest.TestCase):
    def test_end_with_viewers(self):
        daemon = Daemon()
        daemon.patch({"views": [{"name": "bridge", "width": 64,
                                 "height": 64}]})
        lives = [Live(daemon, "bridge") for _ in range(3)]
        for live in lives:
            live.picture()
        self.assertEqual(daemon.stop(), 0)
        for live in lives:
            with self.assertRaises((Closed, ConnectionResetError)) as closed:
                while True:
                    live.picture()
            self.assertIn(getattr(closed.exception, "code", None),
                          (1001, None))
            live.close()


if __name__ == "__main__":
    unittest.main(verbosity=2)
