#!/usr/bin/python3
"""Requests of clients of others: parameters that defeat caches, targets in
absolute form, tags of what they have, preflights of pages of other origins."""
import contextlib
import http.client
import os
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from http_case import HttpCase
from pelagos_daemon import Daemon
from whep_offer import OFFER

DESK, ELSEWHERE = "http://desk.example:8000", "http://elsewhere.example"
VIEW = "/v1/views/bridge"
SMALL = "width=32&height=16"


def head_of(daemon, target, method="GET", headers=None, host=None):
    """Status and headers of an answer that may be endless."""
    c = http.client.HTTPConnection("127.0.0.1", daemon.http_port, timeout=60)
    with contextlib.closing(c):
        c.putrequest(method, target, skip_host=True)
        c.putheader("Host", host or f"127.0.0.1:{daemon.http_port}")
        for name, value in (headers or {}).items():
            c.putheader(name, value)
        c.endheaders()
        answer = c.getresponse()
        body = b"" if answer.status == 200 else answer.read()
        return answer.status, answer.headers, body.decode()


class Parameters(HttpCase):
    def test_unknown_ones_are_ignored_and_named(self):
        for path in (VIEW + "/frame.jpg?" + SMALL, VIEW + "/mjpeg?fps=5",
                     VIEW + "/ts?width=64", VIEW + "/hls.m3u8?width=64",
                     "/v1/frames.jpg?" + SMALL, "/healthz?", "/metrics?"):
            for more, named in (
                    ("cacheBust=1", "cacheBust"), ("_=1", "_"), ("ts=1", "ts"),
                    ("&_=17", "_"), ("1700000000", "1700000000"),
                    ("a=1&a=2&b", "a, a, b"), ("a%20b=1%2C", "a%20b"),
                    ("%C3%A4%22=1", "%C3%A4%22")):
                url = path + ("" if path[-1] == "?" else "&") + more
                for method in ("GET", "HEAD"):
                    if method == "HEAD" and "hls" in path:
                        continue
                    status, headers, _ = head_of(self.daemon, url, method)
                    self.assertEqual(status, 200, url)
                    self.assertEqual(headers["X-Pelagos-Ignored"], named, url)
            status, headers, _ = head_of(self.daemon, path)
            self.assertEqual((status, headers["X-Pelagos-Ignored"]),
                             (200, None), path)
        answer = self.daemon.get(VIEW + "/frame.jpg?" + "&".join(
            f"{'x' * 20}{i}=1" for i in range(40)))
        self.assertEqual(answer.status, 200)
        self.assertLess(len(answer.headers["X-Pelagos-Ignored"]), 200)

    def test_what_a_playlist_names(self):
        text = self.daemon.get(VIEW + "/hls.m3u8?_HLS_skip=YES").body.decode()
        part = next(line for line in text.splitlines() if "/hls/" in line and
                    not line.startswith("#")).split("/")[-1]
        answer = self.daemon.get(f"/v1/hls/{part}?t=1")
        self.assertEqual((answer.status, answer.headers["X-Pelagos-Ignored"]),
                         (200, "t"))

    def test_near_misses_name_the_right_one(self):
        for path, wrong, right in (
                ("mjpeg", "fsp", "fps"), ("mjpeg", "FPS", "fps"),
                ("mjpeg", "fp", "fps"), ("mjpeg", "ffps", "fps"),
                ("mjpeg", "Qualiti", "quality"),
                ("frame.jpg", "widht", "width"), ("frame.jpg", "Time", "time"),
                ("frame.exr", "layer", "layers"), ("ts", "bitrat", "bitrate"),
                ("hls.m3u8", "_hls_MSN", "_HLS_msn"),
                ("live", "codek", "codec")):
            answer = self.daemon.get(f"{VIEW}/{path}?_=1&{wrong}=5")
            said = self.refused(answer, 400, code="NOT_FOUND", path=wrong)
            self.assertIn(f"`{right}`", said["detail"])
        self.refused(self.daemon.get("/v1/frames.jpg?view=bridge"), 400,
                     path="view")

    def test_others_refuse_them(self):
        for path in ("/v1/state", "/v1/views", "/v1/almanac", "/v1/spectrum"):
            self.refused(self.daemon.get(path + "?_=1"), 400, path="_")
        self.refused(self.daemon.request(
            "PATCH", "/v1/state?_=1", {"sea": {"windSpeed": 9}}), 400, path="_")
        self.refused(self.daemon.request(
            "POST", VIEW + "/whep?_=1", OFFER,
            {"Content-Type": "application/sdp"}), 400, path="_")
        # A value that is said twice holds neither way.
        for path in (VIEW + "/frame.jpg?width=32&width=64",
                     "/v1/spectrum?frequencies=4&frequencies=5"):
            self.refused(self.daemon.get(path), 400, code="MALFORMED")


class Targets(HttpCase):
    def test_absolute_form(self):
        port = self.daemon.http_port
        for target in (f"http://127.0.0.1:{port}/healthz", "HTTP://localhost/",
                       f"http://127.0.0.1:{port}/v1/state?", "https://[::1]",
                       f"http://localhost{VIEW}/frame.jpg?{SMALL}&_=1"):
            status, _, body = head_of(self.daemon, target)
            self.assertEqual(status, 200, (target, body))
        status, _, body = head_of(self.daemon, "http://localhost?x=1")
        self.assertEqual(status, 200, body)

    def test_hosts_are_checked_all_the_same(self):
        for target, host in (("http://evil.example/healthz", None),
                             ("http://localhost/healthz", "evil.example"),
                             ("http://a@localhost/healthz", None),
                             ("http:///healthz", None)):
            status, _, body = head_of(self.daemon, target, host=host)
            self.assertEqual(status, 403, (target, host, body))
        status, _, body = head_of(self.daemon, "ftp://localhost/healthz")
        self.assertEqual(status, 400, body)
        # A page is of the host that the target names.
        status, _, _ = head_of(
            self.daemon, f"http://localhost{VIEW}/frame.jpg?{SMALL}",
            headers={"Origin": "http://localhost"})
        self.assertEqual(status, 200)


class Tags(HttpCase):
    def test_what_is_there_already_is_not_sent(self):
        for path in ("/v1/state", "/v1/state/sea.windSpeed", "/v1/schema",
                     "/v1/openapi.json", "/app.js"):
            tag = self.daemon.get(path).headers["ETag"]
            for given in (tag, "W/" + tag.removeprefix("W/"), f'"no", {tag}',
                          "*"):
                again = self.daemon.get(path, headers={"If-None-Match": given})
                self.assertEqual((again.status, again.body), (304, b""), path)
                self.assertEqual(again.headers["ETag"], tag)
            self.assertEqual(self.daemon.get(
                path, headers={"If-None-Match": '"other"'}).status, 200)
        tag = self.daemon.get("/v1/state").headers["ETag"]
        self.daemon.patch({"sea": {"windSpeed": 13}})
        self.assertEqual(self.daemon.get(
            "/v1/state", headers={"If-None-Match": tag}).status, 200)

    def test_strong_tags_are_of_the_same_bytes(self):
        """The clock's time moves without a revision: the state's tag is weak,
        and what is the clock's has none."""
        one, two = (self.daemon.get("/v1/state") for _ in range(2))
        self.assertEqual(one.headers["ETag"], two.headers["ETag"])
        self.assertTrue(one.headers["ETag"].startswith('W/"'))
        for path in ("/v1/state/clock.time", "/v1/state/clock"):
            answer = self.daemon.get(path, headers={"If-None-Match": "*"})
            self.assertEqual((answer.status, answer.headers["ETag"]),
                             (200, None), path)


class Origins(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        file = tempfile.NamedTemporaryFile("w", suffix=".tokens")
        cls.addClassCleanup(file.close)
        file.write("watch-token-0123456789 watch desk\n"
                   "instruct-token-0123456789 instruct desk\n")
        file.flush()
        cls.daemon = Daemon("--token-file", file.name, "--allow-origin", DESK)
        cls.addClassCleanup(cls.daemon.stop)
        cls.token = {"Authorization": "Bearer instruct-token-0123456789"}
        assert cls.daemon.request(
            "PUT", VIEW, {"entity": 1, "width": 64, "height": 64},
            cls.token).status in (200, 201)

    def preflight(self, path, method, origin=DESK, headers="content-type"):
        return self.daemon.request("OPTIONS", path, None, {
            "Origin": origin, "Access-Control-Request-Method": method,
            "Access-Control-Request-Headers": headers})

    def test_preflights(self):
        for method, path in (("POST", VIEW + "/whep"),
                             ("DELETE", "/v1/whep/0123"),
                             ("GET", "/v1/state"), ("GET", "/healthz"),
                             ("GET", VIEW + "/frame.jpg"),
                             ("GET", VIEW + "/hls.m3u8"),
                             ("GET", VIEW + "/mjpeg"),
                             ("HEAD", VIEW + "/frame.png"),
                             ("POST", "/v1/surface")):
            answer = self.preflight(path, method)
            self.assertEqual(answer.status, 204, (path, answer))
            said = {name.lower(): value.lower()
                    for name, value in answer.headers.items()}
            self.assertEqual(said["access-control-allow-origin"], DESK)
            self.assertIn(method.lower(), said["access-control-allow-methods"])
            for name in ("content-type", "authorization", "if-match"):
                self.assertIn(name, said["access-control-allow-headers"])
            self.assertGreater(int(said["access-control-max-age"]), 0)
            self.assertIn("origin", said["vary"])

    def test_refused_preflights(self):
        for method, path, origin, status in (
                ("PATCH", "/v1/state", DESK, 403),
                ("PUT", VIEW, DESK, 403), ("DELETE", VIEW, DESK, 403),
                ("POST", VIEW + "/whep", ELSEWHERE, 403),
                ("POST", VIEW + "/whep", "null", 403),
                ("POST", VIEW + "/whep", DESK + ".evil.example", 403),
                ("POST", "/v1/nothing/there", DESK, 404),
                ("PUT", "/healthz", DESK, 405)):
            answer = self.preflight(path, method, origin)
            self.assertEqual(answer.status, status, (method, path, origin))
            if origin != DESK:
                self.assertIsNone(
                    answer.headers["Access-Control-Allow-Origin"])

    def test_options_without_a_page(self):
        answer = self.daemon.request("OPTIONS", VIEW + "/whep")
        self.assertEqual((answer.status, answer.headers["Allow"]),
                         (204, "POST"))

    def test_session(self):
        offer = dict(self.token, Origin=DESK,
                     **{"Content-Type": "application/sdp"})
        answer = self.daemon.request("POST", VIEW + "/whep", OFFER, offer)
        self.assertEqual(answer.status, 201, answer)
        self.assertEqual(answer.headers["Access-Control-Allow-Origin"], DESK)
        exposed = answer.headers["Access-Control-Expose-Headers"].lower()
        for name in ("location", "etag", "link", "x-pelagos-ignored"):
            self.assertIn(name, exposed)
        place = answer.headers["Location"]
        self.assertEqual(self.daemon.request(
            "DELETE", place, None, dict(self.token, Origin=ELSEWHERE)).status,
            403)
        gone = self.daemon.request("DELETE", place, None,
                                   dict(self.token, Origin=DESK))
        self.assertEqual(gone.status, 204)
        self.assertEqual(gone.headers["Access-Control-Allow-Origin"], DESK)

    def test_a_page_can_read_why_it_is_refused(self):
        for method, path, headers, status in (
                ("POST", VIEW + "/whep", {}, 401),
                ("POST", VIEW + "/whep", dict(self.token, **{
                    "Content-Type": "text/plain"}), 415),
                ("PATCH", "/v1/state", dict(self.token, **{
                    "Content-Type": "application/json"}), 403),
                ("GET", "/v1/nothing/there", self.token, 404)):
            answer = self.daemon.request(method, path, "{}" if method != "GET"
                                         else None, dict(headers, Origin=DESK))
            self.assertEqual(answer.status, status, (method, path, answer))
            self.assertEqual(answer.headers["Access-Control-Allow-Origin"],
                             DESK)
        # A token that instructs does not let a page edit.
        self.assertIn("watch", self.daemon.request(
            "PATCH", "/v1/state", {"sea": {"windSpeed": 3}},
            dict(self.token, Origin=DESK)).json()["detail"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
