#!/usr/bin/python3
"""Views by WebRTC: GStreamer's webrtcbin as a player asks by WHEP, and strangers
who offer nonsense."""
import concurrent.futures
import contextlib
import io
import os
import socket
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import Daemon, until
from whep_offer import OFFER

try:
    from PIL import Image
    from whep_client import Lossy, Player
except (ImportError, ValueError) as error:
    print(f"no GStreamer for Python to play with: {error}")
    sys.exit(77)

VIEW = "/v1/views/bridge/whep"
TYPE = {"Content-Type": "application/sdp"}
SIZE = (320, 180)
# Of 255, the mean over the picture's points of how far grey is from that of the
# PNG: 8 Mbit/s leave 0.4, the same sea 3 s later is 6 away.
GREY = 1.5


class Case(unittest.TestCase):
    options = ()

    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon("--quality", "full", *cls.options)
        cls.daemon.patch({
            "sea": {"windSpeed": 12}, "views": [
                {"name": "bridge", "entity": 1, "width": SIZE[0],
                 "height": SIZE[1]}]})

    @classmethod
    def tearDownClass(cls):
        status = cls.daemon.stop()
        assert status == 0, f"the daemon ended with {status}"

    def ask(self, offer, path=VIEW, headers=None):
        return self.daemon.request("POST", path, offer, headers or TYPE)

    def play(self, path=VIEW, codec="H264"):
        player = Player(codec=codec)
        self.addCleanup(player.close)
        answer = self.ask(player.offer(), path)
        self.assertEqual(answer.status, 201, answer)
        self.assertEqual(answer.headers["Content-Type"], "application/sdp")
        player.answered(answer.body.decode())
        return player, answer.headers["Location"]

    def metric(self, name):
        return self.daemon.metrics()[f"pelagos_whep_{name}"]


def difference(frame, png):
    width, height, grey = frame
    image = Image.open(io.BytesIO(png)).convert("L").resize((width, height))
    stride = len(grey) // height
    return sum(abs((grey[y * stride + x] - 16) * 255 / 219 -
                   image.getpixel((x, y)))
               for y in range(height) for x in range(width)) / width / height


class Players(Case):
    def test_pictures(self):
        """Those that the view has, one after the other, until DELETE."""
        player, place = self.play(VIEW + "?bitrate=8000")
        for _ in range(5):
            frame = player.frame()
            self.assertEqual(frame[:2], SIZE)
        self.daemon.patch({"clock": {"mode": "STEPPED"}})
        self.addCleanup(self.daemon.patch, {"clock": {"mode": "FREE"}})
        png = self.daemon.get("/v1/views/bridge/frame.png").body
        found = []

        def alike():
            seen = player.frame(1)
            found.append(difference(seen, png) if seen else 255)
            return found[-1] < GREY
        self.daemon.request("POST", "/v1/clock/step", {"seconds": 0.001})
        until("the picture of now", lambda: alike() or self.daemon.request(
            "POST", "/v1/clock/step", {"seconds": 0.001}) and False)
        self.daemon.request("POST", "/v1/clock/step", {"seconds": 3})
        other = self.daemon.get("/v1/views/bridge/frame.png").body
        print(f"grey: {found[-1]:.2f} from the PNG's (bar {GREY}); a PNG 3 s "
              f"later: {difference(player.last, other):.2f}")
        self.assertEqual(
            self.daemon.request("DELETE", place).status, 204)
        self.assertEqual(
            self.daemon.request("DELETE", place).status, 404)
        until("it is over", lambda: self.metric("sessions") == 0)

    def test_lost_packets_are_sent_again(self):
        """Two of a hundred are lost: nearly all come when they are asked for,
        where a key frame would have been asked for otherwise."""
        relay, player = Lossy(1), Player(asks_again=True)
        self.addCleanup(player.close)
        answer = self.ask(player.offer())
        self.assertEqual(answer.status, 201, answer)
        text = answer.body.decode()
        self.assertIn("rtx/90000", text)
        player.answered(relay.answer(text))
        for _ in range(10):
            self.assertEqual(player.frame()[:2], SIZE)
        before, relay.share = self.metric("key_wishes_total"), 0.02
        pictures = 0
        while relay.dropped < 25:
            pictures += player.frame(5) is not None
        relay.share = 0
        wishes = self.metric("key_wishes_total") - before
        until("the last that was lost", lambda: relay.again >=
              0.8 * relay.dropped, 20)
        print(f"{relay.dropped} packets lost, {relay.again} sent again, "
              f"{wishes:.0f} key frames asked for, {pictures} pictures")

    def test_data_that_nobody_takes(self):
        """A player that begins a channel of data, though its line was refused,
        keeps its pictures."""
        player = Player(data=True)
        self.addCleanup(player.close)
        answer = self.ask(player.offer())
        self.assertEqual(answer.status, 201, answer)
        player.answered(answer.body.decode())
        self.assertEqual(player.frame()[:2], SIZE)
        for _ in range(60):
            self.assertIsNotNone(player.frame())
        self.assertEqual(self.daemon.request(
            "DELETE", answer.headers["Location"]).status, 204)

    def test_one_encoder(self):
        """Two peers of a profile and an MPEG-TS reader share it; another
        profile is another."""
        one, first = self.play()
        two, second = self.play()
        self.assertEqual(one.frame()[:2], SIZE)
        self.assertEqual(two.frame()[:2], SIZE)
        with self.daemon.connect_http() as reader:
            reader.sendall(b"GET /v1/views/bridge/ts HTTP/1.1\r\n"
                           b"Host: localhost\r\n\r\n")
            reader.recv(1000)
            self.assertEqual(self.pixels(), 320 * 180)
            before = self.daemon.metrics()
            for _ in range(20):
                one.frame()
                two.frame()
            after = self.daemon.metrics()
            sent, encoded = (after[n] - before[n] for n in (
                "pelagos_whep_frames_sent_total", "pelagos_video_frames_total"))
            # Each picture that was encoded went to both.
            self.assertGreater(sent, 1.8 * encoded)
        small, third = self.play(VIEW + "?width=160&height=90")
        self.assertEqual(small.frame()[:2], (160, 90))
        self.assertEqual(self.pixels(), 320 * 180 + 160 * 90)
        for place in (first, second, third):
            self.assertEqual(self.daemon.request("DELETE", place).status, 204)
        until("no encoder is left", lambda: self.pixels() == 0)

    def test_vp8(self):
        """For a player without H.264, by an encoder of its own."""
        both = [self.play(), self.play(VIEW, codec="VP8"),
                self.play(VIEW, codec="VP8")]
        for player, _ in both:
            self.assertEqual(player.frame()[:2], SIZE)
        self.assertEqual(self.pixels(), 2 * SIZE[0] * SIZE[1])
        self.assertIn("VP8 of 320x180", self.daemon.log())
        for _, place in both:
            self.daemon.request("DELETE", place)
        until("no encoder is left", lambda: self.pixels() == 0)

    def pixels(self):
        return self.daemon.metrics()["pelagos_frames_live_pixels"]

    def test_a_view_that_goes(self):
        self.daemon.request("PUT", "/v1/views/short", {
            "entity": 1, "width": 64, "height": 64})
        player, place = self.play("/v1/views/short/whep")
        self.assertEqual(player.frame()[:2], (64, 64))
        self.daemon.request("DELETE", "/v1/views/short")
        until("it is over", lambda: self.metric("sessions") == 0)
        self.assertEqual(self.daemon.request("DELETE", place).status, 404)

    def test_a_peer_that_leaves_without_a_word(self):
        player, _ = self.play()
        self.assertEqual(player.frame()[:2], SIZE)
        player.close()
        until("it is missed", lambda: self.metric("sessions") == 0)


class Strangers(Case):
    def refused(self, offer, code, path, status=400):
        answer = self.ask(offer)
        self.assertEqual(answer.status, status, answer)
        problem = answer.json()
        self.assertEqual(problem["code"], code, problem)
        self.assertEqual(problem.get("path", ""), path, problem)
        return problem

    def test_nonsense(self):
        for offer in (b"", b"v=0", b"hello", b"\0" * 900, b"v=0\r\n" * 9000,
                      b"v=0\r\nm=video\r\n", b"v=0\nm=video 9 X 1\n" * 99,
                      OFFER.encode()[:200] + b"\xff\xfe=\r\n",
                      b"v=0\r\n" + b"m=audio 9 RTP/AVP 0\r\n" * 17):
            answer = self.ask(offer)
            self.assertEqual(answer.status, 400, (offer[:40], answer))
            self.assertIn(answer.json()["code"], ("MALFORMED", "INVALID"))
        self.assertEqual(self.metric("sessions"), 0)
        self.assertGreater(
            self.daemon.metrics()['pelagos_malformed_total{input="whep"}'], 8)

    def test_what_is_missing_is_named(self):
        for gone, path in (("a=recvonly", "m=video"),
                           ("a=ice-ufrag:Ab12", "a=ice-ufrag"),
                           ("a=ice-pwd:abcdefghij", "a=ice-pwd"),
                           ("a=fingerprint:sha-256 AB", "a=fingerprint")):
            put = "a=sendonly" if gone == "a=recvonly" else "a=other:"
            said = self.refused(OFFER.replace(gone, put), "INVALID", path)
            self.assertGreater(len(said["detail"]), 30)
        for gone in ("packetization-mode=1", "H264"):
            self.refused(OFFER.replace(gone, "x=1").replace("VP8", "VP9"),
                         "INVALID", "m=video")

    def test_huge(self):
        self.assertEqual(self.ask(OFFER + "a=x\r\n" * 20000).status, 413)
        self.assertEqual(self.ask(OFFER, headers={
            "Content-Type": "application/json"}).status, 415)
        self.assertEqual(self.ask(OFFER, "/v1/views/none/whep").status, 404)
        said = self.ask(OFFER, VIEW + "?width=5").json()
        self.assertEqual((said["path"], said["minimum"]), ("width", 16))

    def test_lines_that_are_not_wanted(self):
        """Sound of a group stays inactive, first or not, data are refused;
        nothing of a stranger's line comes back but what a line may be."""
        more = OFFER.replace("a=group:BUNDLE 0", "a=group:BUNDLE a 0 d").replace(
            "m=video", "m=audio 9 UDP/TLS/RTP/SAVPF 111\r\na=mid:a\r\n"
            "a=rtpmap:111 opus/48000/2\r\na=x:secret\r\nm=video"
        ) + "m=application 9 UDP/DTLS/SCTP webrtc-datachannel\r\na=mid:d\r\n"
        answer = self.ask(more)
        self.assertEqual(answer.status, 201, answer)
        lines = answer.body.decode().split("\r\n")
        media = [line for line in lines if line.startswith("m=")]
        self.assertEqual([m.split()[0] for m in media],
                         ["m=audio", "m=video", "m=application"])
        self.assertEqual([m.split()[1] == "0" for m in media],
                         [False, False, True])
        self.assertIn("a=group:BUNDLE a 0", lines)
        self.assertIn("a=rtpmap:111 opus/48000/2", lines)
        self.assertNotIn("a=x:secret", lines)
        # The profile most like the encoder's, as it was offered.
        self.assertEqual(media[1].split()[3:], ["106"])
        self.assertTrue(any("profile-level-id=42e01f" in n for n in lines))
        # Nothing but the address that the daemon listens on, told once, where
        # the group's transport is.
        sound = lines[lines.index(media[0]):lines.index(media[1])]
        for part, there in ((sound, True), (lines[len(sound):], False)):
            candidates = [n.split()[4] for n in part
                          if n.startswith("a=candidate")]
            self.assertTrue(not there or set(candidates) == {"127.0.0.1"})
        self.assertEqual(sum(n.startswith("a=ice-pwd:") for n in lines), 2)
        self.daemon.request("DELETE", answer.headers["Location"])

    def test_many_who_never_connect(self):
        """Nothing is drawn for them; a true one gets in all the same."""
        before = self.daemon.metrics()["pelagos_frames_drawn_total"]
        with concurrent.futures.ThreadPoolExecutor(16) as pool:
            answers = list(pool.map(lambda _: self.ask(OFFER), range(64)))
        self.assertLessEqual({a.status for a in answers}, {201, 503})
        self.assertEqual(self.metric("connected"), 0)
        self.assertEqual(self.daemon.metrics()["pelagos_frames_drawn_total"],
                         before)
        self.assertEqual(
            self.daemon.metrics()["pelagos_frames_live_pixels"], 0)
        places = {a.headers["Location"] for a in answers if a.status == 201}
        self.assertEqual(len(places),
                         sum(a.status == 201 for a in answers))
        until("a true one", lambda: self.ask(OFFER).status == 201)
        until("they are over", lambda: self.metric("sessions") == 0)

    def test_who_leaves_before_the_answer(self):
        head = (f"POST {VIEW} HTTP/1.1\r\nHost: localhost\r\nContent-Type: "
                f"application/sdp\r\nContent-Length: {len(OFFER)}\r\n\r\n")
        for _ in range(8):
            with self.daemon.connect_http() as s:
                s.sendall((head + OFFER).encode())
        until("they are withdrawn", lambda: self.metric("sessions") == 0)

    def test_sessions_of_others(self):
        answer = self.ask(OFFER)
        place = answer.headers["Location"]
        for guess in ("0" * 32, place[10:-1], "..", "x" * 200):
            self.assertEqual(self.daemon.request(
                "DELETE", "/v1/whep/" + guess).status, 404, guess)
        self.assertEqual(self.metric("sessions"), 1)
        self.assertEqual(self.daemon.get(place).status, 405)
        self.assertEqual(self.daemon.request("DELETE", place).status, 204)

    def test_control_does_not_wait(self):
        with concurrent.futures.ThreadPoolExecutor(8) as pool:
            for answer in pool.map(lambda _: self.ask(OFFER), range(8)):
                self.daemon.request("DELETE",
                                    answer.headers.get("Location", "/v1/x"))
        until("they are over", lambda: self.metric("sessions") == 0)
        metrics = self.daemon.metrics()
        self.assertGreater(
            metrics['pelagos_control_work_total{what="whep"}'], 7)
        print("control thread: WHEP held it longest for {:.2f} ms".format(1e3 *
              metrics['pelagos_control_stall_longest_seconds{what="whep"}']))


class Ports(Case):
    @classmethod
    def setUpClass(cls):
        with contextlib.closing(socket.socket(type=socket.SOCK_DGRAM)) as s:
            s.bind(("127.0.0.1", 0))
            cls.port = s.getsockname()[1]
        cls.options = ("--whep-ports", f"{cls.port}-{cls.port}")
        super().setUpClass()

    def test_range(self):
        answer = self.ask(OFFER)
        self.assertEqual(answer.status, 201, answer)
        self.assertIn(f" 127.0.0.1 {self.port} typ host",
                      answer.body.decode())
        late = self.ask(OFFER)  # there is one port
        self.assertEqual(late.status, 503, late)
        self.assertIn("--whep-ports", late.json()["detail"])


class Checks(unittest.TestCase):
    """Where there are servers of STUN, checks of ICE go out before the peer has
    proved anything: to few addresses, and those of who asked."""

    @staticmethod
    def sockets(first):
        """16 that nobody else sends to."""
        out = []
        for i in range(16):
            s = socket.socket(type=socket.SOCK_DGRAM)
            s.bind((f"127.0.{first}.{i + 1}", 0))
            s.setblocking(False)
            out.append(s)
        return out

    @staticmethod
    def heard(sockets):
        """Datagrams and bytes by socket, of those that heard any."""
        out = {}
        for i, s in enumerate(sockets):
            with contextlib.suppress(BlockingIOError):
                while True:
                    size = len(s.recv(4096))
                    count, whole = out.get(i, (0, 0))
                    out[i] = (count + 1, whole + size)
        return out

    def test_few_are_sent(self):
        server = socket.socket(type=socket.SOCK_DGRAM)
        server.bind(("127.0.0.1", 0))
        daemon = Daemon(
            "--whep-servers", f"stun://127.0.0.1:{server.getsockname()[1]}",
            "--trust-proxy", "127.0.0.1", "--whep-peers", "127.0.9.0/30")
        self.addCleanup(daemon.stop)
        self.addCleanup(server.close)
        daemon.patch({"views": [{"name": "bridge", "entity": 1, "width": 64,
                                 "height": 64}]})
        sent = {}
        for first, asker in ((7, None), (8, "198.51.100.7"),
                             (9, "198.51.100.7")):
            sent[first] = self.sockets(first)
            for s in sent[first]:
                self.addCleanup(s.close)
            offer = OFFER + "".join(
                f"a=candidate:{i} 1 UDP {900 - i} {{}} {{}} typ host\r\n".format(
                    *s.getsockname()) for i, s in enumerate(sent[first]))
            answer = daemon.request("POST", VIEW, offer, dict(
                TYPE, **({"X-Forwarded-For": asker} if asker else {})))
            self.assertEqual(answer.status, 201, answer)
        size = len(offer)
        until("they are over", lambda: daemon.metrics()[
            "pelagos_whep_sessions"] == 0)
        own, strange, named = (self.heard(sent[n]) for n in (7, 8, 9))
        for heard in (own, named):
            count, whole = (sum(h[i] for h in heard.values()) for i in (0, 1))
            print(f"{len(heard)} of 16 addresses were sent {count} datagrams, "
                  f"{whole} bytes, for an offer of {size} bytes")
            self.assertTrue(heard)
            self.assertLessEqual(len(heard), 3)
            self.assertLessEqual(whole, 3 * size)
        self.assertEqual(strange, {})
        self.assertLessEqual(set(named), {0, 1})  # 127.0.9.1 and .2


class Tokens(unittest.TestCase):
    def test_token(self):
        with tempfile.NamedTemporaryFile("w") as file:
            file.write("watch-token-0123456789 watch desk\n")
            file.flush()
            daemon = Daemon("--token-file", file.name)
        self.addCleanup(daemon.stop)
        view = "/v1/views/main/whep"
        self.assertEqual(daemon.request("POST", view, OFFER, TYPE).status, 401)
        self.assertEqual(daemon.request("DELETE", "/v1/whep/1").status, 401)
        given = dict(TYPE, Authorization="Bearer watch-token-0123456789")
        answer = daemon.request("POST", view, OFFER, given)
        self.assertIn(answer.status, (201, 404))
        self.assertEqual(daemon.request("DELETE", "/v1/whep/1", None,
                                        given).status, 404)
        foreign = dict(given, Origin="http://elsewhere.example")
        self.assertEqual(
            daemon.request("POST", view, OFFER, foreign).status, 403)

    def test_whose_session_it_is(self):
        """Its token may end it, or one of a higher role; who may watch ends no
        instructor's, whatever he knows."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        tokens = {role: f"{role}-token-0123456789" for role in
                  ("watch", "instruct", "other")}
        path = os.path.join(folder.name, "tokens")
        with open(path, "w", encoding="ascii") as f:
            f.writelines(f"{t} {r if r != 'other' else 'watch'}\n"
                         for r, t in tokens.items())
        os.chmod(path, 0o600)
        daemon = Daemon("--token-file", path)
        self.addCleanup(daemon.stop)

        def of(role):
            return {"Authorization": "Bearer " + tokens[role]}

        def begin(role):
            answer = daemon.request("POST", "/v1/views/main/whep", OFFER,
                                    dict(TYPE, **of(role)))
            self.assertEqual(answer.status, 201, answer)
            return answer.headers["Location"]

        def end(at, role):
            return daemon.request("DELETE", at, None, of(role)).status
        daemon.token = tokens["instruct"]
        daemon.patch({"views": {"main": {"entity": 1, "width": 64,
                                         "height": 64}}})
        instructors, watched = begin("instruct"), begin("watch")
        self.assertEqual(end(instructors, "watch"), 403)
        self.assertEqual(end(watched, "other"), 403)
        self.assertEqual(end(watched, "instruct"), 204)
        self.assertEqual(end(watched, "instruct"), 404)
        self.assertEqual(end(instructors, "instruct"), 204)


if __name__ == "__main__":
    unittest.main(verbosity=2)
