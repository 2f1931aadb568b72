#!/usr/bin/python3
"""Every limit that a client can reach (proto/bounds.def) is reached, and its
counter rises. SOAK=1 waits for the long ones and takes the large ones too."""
import concurrent.futures
import contextlib
import os
import socket
import ssl
import sys
import tempfile
import threading
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import cigi_host as cigi
import cluster_case
from ais_test import sentences
from live_client import Closed, Live
from pelagos_daemon import (ROOT, Daemon, Session, free_port, receive_all,
                            schema, until, varint)
from security_test import TOKEN, client_hello, make_certificate, write
from whep_offer import OFFER

sys.path.insert(0, os.path.join(ROOT, "proto"))
import deffile

SOAK = bool(os.environ.get("SOAK"))
LONG = unittest.skipUnless(SOAK, "see make soak")
ROWS = {row[0]: row for row in
        deffile.rows(os.path.join(ROOT, "proto/bounds.def"), "PEL_BOUND")}
VALUE = {name: int(row[1]) for name, row in ROWS.items()}
COUNTERS = {name: row[6].replace('\\"', '"').split(", ")
            for name, row in ROWS.items()}
HOST = b"Host: localhost\r\n"


class Case(unittest.TestCase):
    options = ()

    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(*cls.options, unix=True)
        cls.daemon.patch({"views": [{"name": "bridge", "entity": 1,
                                     "width": 64, "height": 36}],
                          "sea": {"synthesiser": "TROCHOIDS"}})
        cls.daemon.get("/v1/views/bridge/frame.jpg")

    @classmethod
    def tearDownClass(cls):
        status = cls.daemon.stop()
        assert status == 0, f"the daemon ended with {status}"

    def counted(self, bound):
        metrics = self.daemon.metrics()
        return sum(metrics.get(name, 0) for name in COUNTERS[bound])

    @contextlib.contextmanager
    def rises(self, bound):
        before = self.counted(bound)
        yield VALUE[bound]
        until(f"{COUNTERS[bound]} rises", lambda: self.counted(bound) > before)

    def session(self):
        session = Session(self.daemon.connect_unix())
        self.addCleanup(session.close)
        return session

    def tcp(self):
        session = Session(self.daemon.connect_tcp())
        self.addCleanup(session.close)
        return session

    def status(self, data):
        return int(self.daemon.raw(data)[9:12] or 0)

    def ask_many(self, count, **command):
        """That many of a command at once, over as many sessions as it takes;
        the codes of the errors among the answers."""
        sessions = [self.session() for _ in range((count + 15) // 16)]
        pb = schema()
        for i in range(count):
            sessions[i // 16].send(pb.Request(id=i, **command))
        codes = []
        for i in range(count):
            reply = sessions[i // 16].receive()
            if reply.HasField("error"):
                codes.append(pb.ErrorCode.Name(reply.error.code))
        for session in sessions:
            session.close()
        return codes


class Requests(Case):
    options = ("--rtsp", "127.0.0.1:0")

    def test_HTTP_HEAD_BYTES(self):
        with self.rises("HTTP_HEAD_BYTES") as most:
            self.assertIn(self.status(
                b"GET /v1/state HTTP/1.1\r\n" + HOST + b"X: " + b"y" * most +
                b"\r\n\r\n"), (400, 413, 431))

    def test_HTTP_HEADERS(self):
        with self.rises("HTTP_HEADERS") as most:
            for more, wanted in ((0, 200), (1, 400)):
                lines = b"".join(b"X%d: y\r\n" % i
                                 for i in range(most - 2 + more))
                self.assertEqual(self.status(
                    b"GET /v1/state HTTP/1.1\r\n" + HOST +
                    b"Connection: close\r\n" + lines + b"\r\n"), wanted)

    def test_HTTP_TARGET_BYTES(self):
        with self.rises("HTTP_TARGET_BYTES") as most:
            for size, wanted in ((most, 200), (most + 1, 414)):
                target = "/v1/views/bridge/frame.jpg?width="
                target += "0" * (size - len(target) - 2) + "64"
                self.assertEqual(self.daemon.get(target).status, wanted)

    def test_HTTP_QUERY(self):
        with self.rises("HTTP_QUERY") as most:
            self.assertEqual(self.daemon.get("/v1/state?" + "&".join(
                f"a{i}=1" for i in range(most + 1))).status, 400)

    def test_HTTP_BODY_BYTES(self):
        with self.rises("HTTP_BODY_BYTES") as most:
            for size, wanted in ((most, 200), (most + 1, 413)):
                self.assertEqual(self.daemon.patch(
                    b"{" + b" " * (size - 2) + b"}").status, wanted)

    def test_JSON_DEPTH(self):
        with self.rises("JSON_DEPTH") as most:
            self.assertEqual(self.daemon.patch(
                b'{"sea":' + b"[" * most + b"]" * most + b"}").status, 400)

    def test_SESSION_MESSAGE_BYTES(self):
        with self.rises("SESSION_MESSAGE_BYTES") as most:
            session = self.tcp()
            session.socket.sendall(varint(most + 1))
            reply = session.receive()
            self.assertEqual(reply.error.code, schema().MALFORMED)
            self.assertIsNone(session.receive())

    def test_SESSION_REQUESTS(self):
        with self.rises("SESSION_REQUESTS") as most:
            session = self.session()
            pb = schema()
            for i in range(most + 1):
                session.send(pb.Request(id=i, frame={
                    "view": "bridge", "width": 640, "height": 360}))
            codes = [session.receive().error.code for _ in range(most + 1)]
            self.assertIn(pb.BUSY, codes)

    def test_SURFACE_POINTS(self):
        with self.rises("SURFACE_POINTS") as most:
            session = self.session()
            reply = session.ask(surface={"points": [{}] * (most + 1)})
            self.assertEqual(reply.error.code, schema().OUT_OF_RANGE)

    def test_TEXT_BYTES(self):
        with self.rises("TEXT_BYTES") as most:
            session = self.session()
            for size, good in ((most, True), (most + 1, False)):
                reply = session.ask(patch={"state": {"entities": [
                    {"id": 1, "name": "a" * size}]}})
                self.assertEqual(reply.HasField("state"), good, reply)

    def long_text(self, bound, state, good, more="x"):
        """state(text): a text of this many bytes is taken as one."""
        with self.rises(bound) as most:
            session = self.session()
            for size in (most, most + 1):
                message = session.ask(patch={"state": state(
                    good + more * (size - len(good)))}).error.message
                self.assertEqual(f"{size} bytes long; at most {most}"
                                 in message, size > most, message)

    def test_FILE_BYTES(self):
        for state in (lambda t: {"seabed": {"file": t}},
                      lambda t: {"sky": {"file": t}},
                      lambda t: {"sea": {"synthesiser": "FFT",
                                         "spectrum": "JONSWAP",
                                         "field": {"file": t}}},
                      lambda t: {"sea": {"measured": t}},
                      lambda t: {"entities": [{"id": 9,
                                               "model": {"name": t}}]}):
            self.long_text("FILE_BYTES", state, "folder/")

    def test_METAR_BYTES(self):
        self.long_text("METAR_BYTES", lambda t: {"sky": {"metar": t}},
                       "EHAM 231355Z 24020KT RMK ")

    def test_NUMBERS_BYTES(self):
        self.long_text("NUMBERS_BYTES", lambda t: {"sea": {"areas": [
            {"corners": t}]}}, "0 0, 400 0, 300 150", " ")

    def test_VIEWS(self):
        with self.rises("VIEWS") as most:
            session = self.session()
            for count, good in ((most - 1, True), (most, False)):
                reply = session.ask(patch={"state": {"views": [
                    {"name": f"v{i}"} for i in range(count)]}})
                self.assertEqual(reply.HasField("state"), good)
            session.ask(patch={"remove": [f"views.v{i}"
                                          for i in range(most - 1)]})

    def test_PRESETS(self):
        with self.rises("PRESETS") as most:
            session = self.session()
            for count, good in ((most, True), (most + 1, False)):
                reply = session.ask(patch={"state": {"presets": [
                    {"name": f"p{i}", "patch": "{}"} for i in range(count)]}})
                self.assertEqual(reply.HasField("state"), good, reply)
            session.ask(patch={"remove": ["presets"]})

    def test_PRESET_BYTES(self):
        with self.rises("PRESET_BYTES") as most:
            session = self.session()
            for size, good in ((most, True), (most + 1, False)):
                reply = session.ask(patch={"state": {"presets": [
                    {"name": "a", "patch": "{" + " " * (size - 2) + "}"}]}})
                self.assertEqual(reply.HasField("state"), good, reply)
            session.ask(patch={"remove": ["presets"]})

    def test_ENTITIES(self):
        with self.rises("ENTITIES") as most:
            session = self.session()
            for count, good in ((most - 1, True), (most, False)):
                reply = session.ask(patch={"state": {"entities": [
                    {"id": 1000 + i} for i in range(count)]}})
                self.assertEqual(reply.HasField("state"), good)
            session.ask(patch={"remove": [f"entities.{1000 + i}"
                                          for i in range(most - 1)]})

    def test_EXERCISE_EVENTS(self):
        with self.rises("EXERCISE_EVENTS") as most:
            session = self.session()
            for count, good in ((most, True), (most + 1, False)):
                reply = session.ask(patch={"state": {"exercise": {"events": [
                    {"event": f"e{i}"} for i in range(count)]}}})
                self.assertEqual(reply.HasField("state"), good)
            session.ask(patch={"remove": ["exercise"]})

    def test_LIVE_MESSAGE_BYTES(self):
        with self.rises("LIVE_MESSAGE_BYTES") as most, \
                Live(self.daemon, "bridge", "?codec=jpeg") as live:
            live.send_frame(2, b"\1" * (most + 1))
            with self.assertRaises(Closed) as caught:
                while True:
                    live.message()
            self.assertEqual(caught.exception.code, 1009)


    def test_LIVE_FRAGMENTS(self):
        with self.rises("LIVE_FRAGMENTS") as most, \
                Live(self.daemon, "bridge", "?codec=jpeg") as live:
            live.send_frame(2, b"", final=False)
            for _ in range(most):
                live.send_frame(0, b"", final=False)
            with self.assertRaises(Closed) as caught:
                while True:
                    live.message()
            self.assertEqual(caught.exception.code, 1009)


class Work(Case):
    """What is under way."""

    def test_PICTURES(self):
        with self.rises("PICTURES") as most:
            codes = self.ask_many(most + 32, frame={
                "view": "bridge", "width": 640, "height": 360})
            self.assertEqual(set(codes), {"BUSY"})

    def test_SURFACE_QUERIES(self):
        """Of moments that all have to be computed."""
        self.daemon.patch({"sea": {"synthesiser": "FFT"}})
        with self.rises("SURFACE_QUERIES") as most:
            pb = schema()
            sessions = [self.session() for _ in range(3 * most)]
            requests = [pb.Request(id=1, surface={
                "points": [{"east": 9 * k, "north": k} for k in range(2500)],
                "time": 10 + i}).SerializeToString()
                for i in range(len(sessions))]
            for session, request in zip(sessions, requests):
                session.socket.sendall(varint(len(request)) + request)
            codes = [session.receive().error.code for session in sessions]
            self.assertIn(pb.BUSY, codes)
        self.daemon.patch({"sea": {"synthesiser": "TROCHOIDS"}})

    def test_OPTICS_QUERIES(self):
        """In an air whose table has to be made: half a second for the first."""
        with self.rises("OPTICS_QUERIES") as most:
            codes = self.ask_many(4 * most, optics={
                "sky": {}, "patch": {"state": {"sky": {"visibility": 9000}}}})
            self.assertEqual(set(codes), {"BUSY"})

    def test_QUESTIONS(self):
        """A process writes files, one after the other."""
        with self.rises("QUESTIONS") as most:
            sockets = [self.daemon.connect_http() for _ in range(most + 40)]
            for s in sockets:
                self.addCleanup(s.close)
                s.sendall(b"GET /v1/spectrum?format=netcdf HTTP/1.1\r\n" +
                          HOST + b"\r\n")
            for s in sockets:
                s.recv(16)

    @LONG
    def test_UNREAD_BYTES(self):
        """Pictures that nobody reads; shares_test.py has a small house."""
        with self.rises("UNREAD_BYTES"):
            for _ in range(8):
                s = self.daemon.connect_http()
                self.addCleanup(s.close)
                s.sendall(b"GET /v1/views/bridge/frame.exr?width=2048&height="
                          b"2048&layers=radiance,normal,sun,depth&float=1 "
                          b"HTTP/1.1\r\n" + HOST + b"\r\n")

    def test_SERIES(self):
        with self.rises("SERIES") as most:
            codes = self.ask_many(4 * most, series={
                "sweep": [{"over": "elevation", "first": 0, "last": 80}],
                "optics": {"sky": {}}})
            self.assertEqual(set(codes), {"BUSY"})

    def test_SERIES_QUESTIONS(self):
        pb = schema()
        with self.rises("SERIES_QUESTIONS") as most:
            for axes in ([most + 1], [most // 100, 101]):
                reply = self.session().ask(series={"spectrum": {}, "sweep": [
                    {"over": name, "first": 1, "last": count, "step": 1}
                    for name, count in zip(("wavelength", "sea.seed"), axes)]})
                self.assertEqual(reply.error.code, pb.OUT_OF_RANGE, reply)
                self.assertEqual(reply.error.path, "sweep", reply)

    def test_SERIES_VALUES(self):
        with self.rises("SERIES_VALUES") as most:
            reply = self.session().ask(series={
                "sweep": [{"over": "time", "first": 0,
                           "last": most // 2000}],
                "surface": {"points": [{"east": i, "north": 0}
                                       for i in range(1000)]}})
            self.assertEqual(reply.error.code, schema().OUT_OF_RANGE, reply)

    def open_live(self, sockets, query, view="bridge"):
        s = self.daemon.connect_http()
        self.addCleanup(s.close)
        s.sendall(f"GET /v1/views/{view}/{query} HTTP/1.1\r\n".encode() +
                  HOST + b"\r\n")
        sockets.append(s)
        return int(s.recv(64).split()[1])

    def close(self, sockets):
        for s in sockets:
            s.close()
        until("all are gone", lambda: self.daemon.metrics()[
            "pelagos_frames_subscriptions"] == 0)

    def test_LIVE_PIXELS(self):
        side = 4096
        count = VALUE["LIVE_PIXELS"] // side ** 2
        self.daemon.patch({"views": {f"large{i}": {
            "width": side, "height": side} for i in range(count + 1)}})
        sockets = []
        with self.rises("LIVE_PIXELS"):
            self.assertEqual([self.open_live(sockets, "mjpeg?fps=0.1",
                                             f"large{i}")
                              for i in range(count + 1)],
                             [200] * count + [503])
            self.close(sockets)
        self.daemon.patch({"views": {f"large{i}": None
                                     for i in range(count + 1)}})

    def test_LIVE_STREAMS(self):
        """Half of them in H.264."""
        sockets = []
        with self.rises("LIVE_STREAMS") as most:
            statuses = [self.open_live(sockets, f"ts?bitrate={100 + i}"
                                       if i % 2 else f"mjpeg?quality={1 + i}")
                        for i in range(most + 1)]
            self.assertEqual(statuses, [200] * most + [503])
            self.close(sockets)

    @LONG
    def test_SESSION_OUTPUT_BYTES(self):
        with self.rises("SESSION_OUTPUT_BYTES"):
            session = self.session()
            pb = schema()
            for i in range(6):
                session.send(pb.Request(id=i, frame={
                    "view": "bridge", "format": pb.EXR, "width": 2048,
                    "height": 2048, "float_samples": True,
                    "layers": ["radiance", "normal", "sun", "depth"]}))
            until("all are drawn", lambda: self.daemon.metrics()[
                "pelagos_frames_requests_waiting"] == 0)
            codes = [session.receive().error.code for _ in range(6)]
            self.assertIn(pb.BUSY, codes)


class Places(Case):
    """Connections."""

    def proxied(self):
        """A daemon that believes whom this test speaks for."""
        before, type(self).daemon = self.daemon, Daemon(
            "--trust-proxy", "127.0.0.1")

        def back():
            type(self).daemon.stop()
            type(self).daemon = before
        self.addCleanup(back)

    def viewer(self, address):
        s = self.daemon.connect_http()
        self.addCleanup(s.close)
        s.sendall(b"GET /v1/views/bridge/mjpeg?fps=0.1 HTTP/1.1\r\n" + HOST +
                  b"X-Forwarded-For: %s\r\n\r\n" % address)
        return s.recv(64).split()[1]

    def test_HTTP_PER_LOOPBACK(self):
        with self.rises("HTTP_PER_LOOPBACK") as most:
            free = most - most // 8
            self.assertEqual([self.viewer(b"127.0.0.1")
                              for _ in range(free + 1)],
                             [b"200"] * free + [b"429"])
            rest = []
            for _ in range(most):  # the others push each other out
                s = self.daemon.connect_http()
                self.addCleanup(s.close)
                s.sendall(b"GET / HTTP/1.1\r\n")
                rest.append(s)
            self.assertLessEqual(self.daemon.metrics()[
                "pelagos_http_connections"], 2 * most)

    def test_HTTP_NEWCOMERS(self):
        with self.rises("HTTP_NEWCOMERS") as most:
            for _ in range(most + 1):
                self.addCleanup(self.daemon.connect_http().close)
            self.assertEqual(self.daemon.get("/v1/state").status, 200)

    def test_HTTP_PER_SOURCE(self):
        self.proxied()
        with self.rises("HTTP_PER_SOURCE") as most:
            self.assertEqual([self.viewer(b"203.0.113.5")
                              for _ in range(most + 1)],
                             [b"200"] * most + [b"429"])
            self.assertEqual(self.viewer(b"203.0.113.6"), b"200")

    def test_HTTP_CONNECTIONS(self):
        """Views take seven eighths; the rest wait for pictures."""
        self.proxied()
        self.daemon.patch({"clock": {"mode": "STEPPED"}})
        with self.rises("HTTP_CONNECTIONS") as most:
            views = most - most // 8
            got = [self.viewer(b"203.0.113.%d" % (i // 16))
                   for i in range(views + 1)]
            self.assertEqual(got, [b"200"] * views + [b"429"])
            waiting = []
            for i in range(most // 8 + 32):
                s = self.daemon.connect_http()
                self.addCleanup(s.close)
                s.sendall(b"GET /v1/views/bridge/frame.png?width=4096&height="
                          b"4096 HTTP/1.1\r\n" + HOST +
                          b"X-Forwarded-For: 198.51.100.%d\r\n\r\n" % i)
                waiting.append(s)
            self.assertIn(b'"status"', self.daemon.raw(
                b"GET /healthz HTTP/1.1\r\n" + HOST +
                b"Connection: close\r\n\r\n"))
            for s in waiting:
                s.close()

    def test_SESSIONS(self):
        with self.rises("SESSIONS") as most:
            for _ in range(most):
                self.assertTrue(self.tcp().ask(get={}).HasField("state"))
            late = self.tcp()
            self.assertEqual(late.receive().error.code, schema().BUSY)
            self.assertTrue(self.session().ask(get={}).HasField("state"),
                            "the Unix socket has its own")


class Whep(Case):
    """Peers that never connect."""

    def ask(self):
        return self.daemon.request("POST", "/v1/views/bridge/whep", OFFER,
                                   {"Content-Type": "application/sdp"}).status

    def test_WHEP_SESSIONS(self):
        with self.rises("WHEP_SESSIONS") as most:
            with concurrent.futures.ThreadPoolExecutor(most + 8) as pool:
                answers = [a.result() for a in [
                    pool.submit(self.ask) for _ in range(most + 8)]]
            self.assertEqual(set(answers), {201, 503})
            self.assertGreaterEqual(answers.count(201), most)

    def test_WHEP_IDLE_S(self):
        with self.rises("WHEP_IDLE_S"):
            self.assertEqual(self.ask(), 201)
            until("it is over", lambda: self.daemon.metrics()[
                "pelagos_whep_sessions"] == 0)


@unittest.skipUnless(cluster_case.has_etcd(), "no etcd")
class Cluster(Case):
    """Nodes that only say that they are there."""

    @classmethod
    def setUpClass(cls):
        cls.store = cluster_case.Store()
        cls.daemon = cluster_case.Node("one", cls.store)
        until("it takes part", lambda: cls.daemon.cluster().get("nodes"))

    @classmethod
    def tearDownClass(cls):
        super().tearDownClass()
        cls.store.stop()

    def say(self, names, beat):
        for name in names:
            self.store.put(f"bridge/nodes/{name}", schema().ClusterNode(
                name=name, beat=beat).SerializeToString())

    def listed(self):
        return {n["name"] for n in self.daemon.cluster().get("nodes", ())}

    def test_CLUSTER_NODES(self):
        names = [f"n{i:03}" for i in range(VALUE["CLUSTER_NODES"])]
        with self.rises("CLUSTER_NODES") as most:
            for beat in range(1, 9):
                self.say(names, beat)  # with "one" that is one too many
            self.assertEqual(len(self.listed()), most)
            self.assertEqual(self.listed(), {"one", *names[:-1]})
        self.assertEqual(self.daemon.log().count("CLU-021"), 1)
        self.assertIn(names[-1], self.daemon.log())
        time.sleep(6.1)  # all are gone now
        self.say(["late"], 1)
        until("it has room", lambda: "late" in self.listed())
        self.assertIn("one", self.listed())
        self.assertEqual(len(self.listed()), most)


class Strangers(unittest.TestCase):
    """Clients without a token, where one is asked for."""
    counted, rises = Case.counted, Case.rises

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.port = free_port()
        tokens = os.path.join(cls.folder.name, "tokens")
        with open(tokens, "w", encoding="ascii") as f:
            f.write("instruct-token-0123 instruct\n")
        os.chmod(tokens, 0o600)
        cls.daemon = Daemon("--token-file", tokens, "--rtsp",
                            f"127.0.0.1:{cls.port}")
        cls.daemon.token = "instruct-token-0123"

    @classmethod
    def tearDownClass(cls):
        cls.daemon.stop()
        cls.folder.cleanup()

    def connect(self, port):
        s = socket.create_connection(("127.0.0.1", port), 60)
        self.addCleanup(s.close)
        return s

    def test_SESSION_STRANGERS(self):
        with self.rises("SESSION_STRANGERS") as most:
            for _ in range(most + 1):
                self.connect(self.daemon.tcp_port)
            with Session(self.daemon.connect_tcp()) as late:
                self.assertTrue(late.ask(login={
                    "token": self.daemon.token}).HasField("state"))

    def test_RTSP_STRANGERS(self):
        with self.connect(self.port) as s:  # GStreamer has come to life
            s.sendall(b"OPTIONS * RTSP/1.0\r\nCSeq: 1\r\n\r\n")
            s.recv(64)
        with self.rises("RTSP_STRANGERS") as most:
            for _ in range(most + 1):
                self.connect(self.port)
            time.sleep(0.2)  # so long each stays
            self.connect(self.port)


class Handshakes(unittest.TestCase):
    rises, counted = Case.rises, Case.counted

    def test_RTSP_HANDSHAKES(self):
        """As many as there may be stop in the middle; one more is served."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        cert, key = make_certificate(folder.name)
        port = free_port()
        self.daemon = Daemon("--token-file", write(
            os.path.join(folder.name, "tokens"), TOKEN),
            "--tls-cert", cert, "--tls-key", key,
            "--rtsp", f"127.0.0.1:{port}")
        self.addCleanup(self.daemon.stop)
        self.daemon.token = TOKEN
        begin = client_hello()[:100]
        with self.rises("RTSP_HANDSHAKES") as most:
            for _ in range(most + 1):
                s = socket.create_connection(("127.0.0.1", port), 60)
                self.addCleanup(s.close)
                s.sendall(begin)
        trust = ssl.create_default_context(cafile=cert)
        with trust.wrap_socket(
                socket.create_connection(("127.0.0.1", port), 60),
                server_hostname="localhost") as s:
            s.sendall(b"OPTIONS * RTSP/1.0\r\nCSeq: 1\r\n\r\n")
            self.assertIn(b"RTSP/1.0 200", s.recv(64))


class Rtsp(Case):
    port = None

    @classmethod
    def setUpClass(cls):
        cls.port = free_port()
        cls.options = ("--rtsp", f"127.0.0.1:{cls.port}")
        super().setUpClass()
        with socket.create_connection(("127.0.0.1", cls.port)) as s:
            s.sendall(b"OPTIONS * RTSP/1.0\r\nCSeq: 1\r\n\r\n")
            s.recv(64)

    def setUp(self):
        # Those of the test before are counted until the daemon sees them gone.
        until("no client is left",
              lambda: self.daemon.metrics()["pelagos_rtsp_clients"] == 0)

    def connect(self):
        s = socket.create_connection(("127.0.0.1", self.port), 60)
        self.addCleanup(s.close)
        return s

    def test_RTSP_CLIENTS(self):
        with self.rises("RTSP_CLIENTS") as most:
            for _ in range(most + 1):
                self.connect()

    def test_RTSP_HEAD_BYTES(self):
        with self.rises("RTSP_HEAD_BYTES") as most:
            s = self.connect()
            s.sendall(b"OPTIONS * RTSP/1.0\r\n")
            with contextlib.suppress(OSError):
                s.sendall(b"X: y\r\n" * most)
            receive_all(s)

    def test_RTSP_BODY_BYTES(self):
        with self.rises("RTSP_BODY_BYTES") as most:
            s = self.connect()
            s.sendall(b"OPTIONS * RTSP/1.0\r\nContent-Length: %d\r\n\r\n"
                      % (most + 1))
            receive_all(s)

    def test_RTSP_IDLE_S(self):
        with self.rises("RTSP_IDLE_S"):
            self.assertEqual(receive_all(self.connect()), b"")


class Times(Case):
    """Of clients that stop in the middle, all at once."""

    def test_all(self):
        began = time.monotonic()
        with tempfile.NamedTemporaryFile("w") as token:
            token.write("0123456789abcdef0123")
            token.flush()
            guarded = Daemon("--token-file", token.name)
        self.addCleanup(guarded.stop)
        stranger = guarded.connect_tcp()
        self.addCleanup(stranger.close)
        head = self.daemon.connect_http()
        head.sendall(b"GET / HTTP/1.1\r\n")
        body = self.daemon.connect_http()
        body.sendall(b"PATCH /v1/state HTTP/1.1\r\n" + HOST + b"Content-Type: "
                     b"application/json\r\nContent-Length: 99\r\n\r\n{")
        half = self.daemon.connect_tcp()
        half.sendall(b"\x20ab")
        ends = {"SESSION_LOGIN_S": stranger, "HTTP_HEADER_S": head,
                "HTTP_BODY_S": body, "SESSION_MESSAGE_S": half}
        if SOAK:
            stalled = Session(self.daemon.connect_tcp())
            request = schema().Request(id=1, models={}).SerializeToString()
            stalled.socket.settimeout(1)
            with contextlib.suppress(OSError):
                for _ in range(200000):
                    stalled.socket.sendall(varint(len(request)) + request)
            ends["SESSION_STALL_S"] = None
            self.addCleanup(stalled.close)
        over = threading.Event()

        def drip():  # silent ones are ended after 10 s
            with contextlib.suppress(OSError):
                while not over.wait(1):
                    body.sendall(b" ")
        threading.Thread(target=drip, daemon=True).start()
        self.addCleanup(over.set)
        for bound, s in ends.items():
            daemon = guarded if s is stranger else self.daemon
            if s:
                receive_all(s)
                s.close()
                print(f"{bound}: the end after "
                      f"{time.monotonic() - began:.1f} s of {VALUE[bound]} s")
                self.assertGreater(time.monotonic() - began,
                                   VALUE[bound] - 0.5)
            elif bound == "SESSION_STALL_S":
                time.sleep(VALUE[bound] + 2)
            if daemon is guarded:
                metrics = guarded.get("/metrics", headers={
                    "Authorization": "Bearer 0123456789abcdef0123"})
                self.assertRegex(metrics.body.decode(),
                                 r'timeouts_total\{input="tcp"\} [1-9]')
            else:
                until(f"{bound} is counted",
                      lambda b=bound: self.counted(b) > 0)

    test_SESSION_LOGIN_S = test_HTTP_HEADER_S = test_HTTP_BODY_S = None
    test_SESSION_MESSAGE_S = test_SESSION_STALL_S = None

    @LONG
    def test_HTTP_ANSWER_S(self):
        """A whole answer that its client does not take."""
        with self.rises("HTTP_ANSWER_S") as most:
            s = socket.socket()
            self.addCleanup(s.close)
            s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            s.connect(("127.0.0.1", self.daemon.http_port))
            s.sendall(b"GET /v1/views/bridge/frame.exr?width=2048&height=2048"
                      b" HTTP/1.1\r\n" + HOST + b"\r\n")
            time.sleep(most + 2)


class Bridges(Case):
    @classmethod
    def setUpClass(cls):
        cls.modbus, cls.lines = free_port(), free_port()
        cls.nmea, cls.cigi = (free_port(socket.SOCK_DGRAM) for _ in range(2))
        cls.options = ("--modbus", f"127.0.0.1:{cls.modbus}",
                       "--nmea", f"127.0.0.1:{cls.nmea}",
                       "--nmea-ais", "--nmea-tcp", f"127.0.0.1:{cls.lines}",
                       "--cigi", f"127.0.0.1:{cls.cigi}")
        super().setUpClass()

    def many(self, port, count):
        for _ in range(count):
            self.addCleanup(socket.create_connection(("127.0.0.1", port),
                                                     60).close)

    def send(self, data):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
            s.sendto(data, ("127.0.0.1", self.nmea))

    def test_MODBUS_CLIENTS(self):
        with self.rises("MODBUS_CLIENTS") as most:
            self.many(self.modbus, most + 1)

    def test_NMEA_CLIENTS(self):
        with self.rises("NMEA_CLIENTS") as most:
            self.many(self.lines, most + 1)

    def test_NMEA_SENTENCE_BYTES(self):
        with self.rises("NMEA_SENTENCE_BYTES") as most:
            self.send(b"$GPHDT," + b"1" * most + b",T*00\r\n")

    def test_NMEA_DATAGRAM_BYTES(self):
        with self.rises("NMEA_DATAGRAM_BYTES") as most:
            self.send(b"\r\n" * (most // 2 + 1))

    def test_NMEA_TARGETS(self):
        with self.rises("NMEA_TARGETS") as most:
            for i in range(most + 1):
                for line in sentences([
                        (1, 6), (0, 2), (244000000 + i, 30), (0, 4), (0, 8),
                        (50, 10), (1, 1), (round(4.1 * 600000) + 10 * i, 28),
                        (round(52.0 * 600000), 27), (900, 12), (90, 9),
                        (30, 6), (0, 2), (0, 3), (0, 1), (0, 19)]):
                    self.send(line.encode() + b"\r\n")

    def test_CIGI_QUESTIONS(self):
        with self.rises("CIGI_QUESTIONS") as most, \
                cigi.Host(("127.0.0.1", self.cigi)) as host:
            until("the host is heard", lambda: host.send() and
                  host.receive() is not None)
            host.send(*(cigi.hat_hot(i, 52, 4) for i in range(most + 1)))
            host.settle()

    def test_CIGI_WAITING(self):
        with self.rises("CIGI_WAITING") as most, \
                cigi.Host(("127.0.0.1", self.cigi)) as host:
            until("the host is heard", lambda: host.send() and
                  host.receive() is not None)
            asked = VALUE["CIGI_QUESTIONS"]
            heights = [cigi.hat_hot(i, 52, 4, kind=2) for i in range(asked)]
            before = self.counted("CIGI_WAITING")

            def flooded():  # faster than Start of Frame takes them along
                for _ in range(2 * most // asked):
                    host.send(*heights)
                return self.counted("CIGI_WAITING") > before

            until("the requests are too many", flooded)


class Table(unittest.TestCase):
    def test_every_row_has_a_test(self):
        tests = {name[5:] for case in (Requests, Work, Places, Whep, Rtsp, Times,
                                       Strangers, Handshakes,
                                       Cluster, Bridges) for name in dir(case)
                 if name.startswith("test_")}
        self.assertEqual(set(ROWS) - tests, set())
        with open(os.path.join(ROOT, "proto/manual.md"),
                  encoding="utf-8") as f:
            manual = f.read()
        for names in COUNTERS.values():
            for name in names:
                self.assertIn(f"`{name}`", manual)


if __name__ == "__main__":
    unittest.main(verbosity=2)
