#!/usr/bin/python3
"""Placed views and a spare (docs/cluster.md): one etcd, three nodes on this
machine, one of them a spare; nodes are killed and come back, and HAProxy routes
a view's viewers by packaging/haproxy/placed.cfg."""
import contextlib
import http.client
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import cluster_case as case
from pelagos_daemon import BIN, ROOT, SLOW_S, Daemon, Session, free_port, until

SMALL = "?width=64&height=36"
CONFIG = os.path.join(ROOT, "packaging/haproxy/placed.cfg")


def ctl(node, *words):
    return subprocess.run(
        [os.path.join(BIN, "pelagosctl"), "--server",
         f"tcp:127.0.0.1:{node.tcp_port}", "cluster", *words],
        capture_output=True, text=True, check=False)


def place(node, view, at):
    return node.request("PUT", f"/v1/cluster/place/{view}", {"node": at})


def places(node):
    return {p["view"]: p for p in node.cluster().get("places", [])}


def draws(node, view):
    """Whether a load balancer may ask the node for it."""
    with contextlib.suppress(OSError, http.client.HTTPException):
        return node.get(f"/v1/views/{view}/placed", timeout=2).status == 200
    return False


def await_taken(view, nodes):
    """Until one of them draws it, asked often, on one connection each."""
    with contextlib.ExitStack() as stack:
        asked = [stack.enter_context(contextlib.closing(
            http.client.HTTPConnection("127.0.0.1", n.http_port,
                                       timeout=SLOW_S))) for n in nodes]

        def taken():
            for connection in asked:
                connection.request("GET", f"/v1/views/{view}/placed")
                answer = connection.getresponse()
                answer.read()
                if answer.status == 200:
                    return True
            return False
        until("another draws it", taken, pause_s=0.01)


class Placement(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.store = case.Store()
        cls.addClassCleanup(cls.store.stop)
        cls.nodes = {}
        # The master is neither a spare nor killed first: by its rank.
        for name, options in (("a", ("--exercise-rank", "1")),
                              ("m", ("--exercise-rank", "0")),
                              ("s", ("--exercise-spare", "--exercise-rank",
                                     "2"))):
            cls.begin(name, *options)
            if name == "a":  # it begins the exercise, and m is to be the master
                for view in ("left", "right"):
                    answer = cls.nodes["a"].request(
                        "PUT", f"/v1/views/{view}", case.VIEW)
                    assert answer.status == 201, answer

    @classmethod
    def begin(cls, name, *options):
        node = case.Node(name, cls.store, "--waves", "20",
                         "--exercise-address", f"{name}.example:80", *options)
        cls.nodes[name] = node
        cls.addClassCleanup(node.stop)
        until(f"{name} takes part", lambda: node.is_master() or node.follows())
        return node

    @classmethod
    def there(cls):
        return [n for n in cls.nodes.values() if n.alive()]

    def await_drawn(self, view, name):
        """Until all that are there agree; the seconds that took."""
        begun = time.monotonic()
        until(f"{name} draws {view}", lambda: all(
            places(n).get(view, {}).get("drawnBy") == name and
            draws(n, view) == (n.name == name) for n in self.there()))
        return time.monotonic() - begun

    def setUp(self):
        self.clear()

    def clear(self):
        def cleared():
            for view in places(self.there()[0]):
                self.there()[0].request("DELETE", f"/v1/cluster/place/{view}")
            return not any(places(n) for n in self.there())
        until("nothing is placed", cleared, pause_s=0.3)

    def await_all_there(self):
        def said():
            nodes = self.nodes["m"].cluster()["nodes"]
            return {n["name"] for n in nodes if not n["silent"]} >= {
                n.name for n in self.there()}
        until("all say something", said)

    # --- without -----------------------------------------------------------

    def test_0_without_an_exercise(self):
        with Daemon() as alone:
            answer = alone.get("/v1/views/bridge/placed")
            self.assertEqual(answer.status, 200)
            self.assertEqual(answer.json(), {"view": "bridge"})
            self.assertEqual(alone.get("/v1/views/none/placed").status, 404)
            answer = place(alone, "bridge", "a")
            self.assertEqual(answer.status, 409)
            self.assertIn("pelagosd --exercise", answer.json()["detail"])
            done = ctl(alone, "place", "bridge", "a")
            self.assertEqual(done.returncode, 4)
            self.assertIn("pelagosd --exercise", done.stderr)

    # --- edits -------------------------------------------------------------

    def test_1_bad_input(self):
        node = self.nodes["s"]
        before = self.store.get("bridge/place")
        for view, body, status, says in (
                ("none", {"node": "a"}, 404, "bridge, left, right"),
                ("left", {"node": "a b"}, 400, "1 to 64 of a-z"),
                ("left", {"node": ""}, 400, "1 to 64 of a-z"),
                ("left", {"node": "x" * 65}, 400, "1 to 64 of a-z"),
                ("left", {}, 400, "node"),
                ("left", {"node": 3}, 400, "node"),
                ("left", {"node": "a", "view": "right"}, 400, "view"),
                ("left", {"nodes": "a"}, 400, "nodes")):
            answer = node.request("PUT", f"/v1/cluster/place/{view}", body)
            self.assertEqual(answer.status, status, (body, answer))
            self.assertIn(says, str(answer.json()), body)
        answer = node.request("DELETE", "/v1/cluster/place/left")
        self.assertEqual(answer.status, 404, answer)
        self.assertIn("those that are: none", answer.json()["detail"])
        self.assertEqual(self.store.get("bridge/place"), before)
        for words, code, says in ((("place", "left"), 2, "place VIEW NODE"),
                                  (("unplace",), 2, "unplace VIEW"),
                                  (("nonsense",), 2, "place VIEW NODE"),
                                  (("place", "none", "a"), 4, "left, right"),
                                  (("unplace", "left"), 4, "not placed")):
            done = ctl(node, *words)
            self.assertEqual(done.returncode, code, (words, done))
            self.assertIn(says, done.stderr)

    def test_1_edits_at_any_node(self):
        self.await_all_there()
        for node in self.nodes.values():
            answer = place(node, "left", "a")
            self.assertEqual(answer.status, 200, answer)
            self.assertEqual(answer.json()["places"][0]["node"], "a")
        self.await_drawn("left", "a")
        # A node that never was: the spare has it meanwhile.
        done = ctl(self.nodes["a"], "place", "right", "later")
        self.assertEqual(done.stdout, "view right is placed at node later, "
                         "which is not there now\n")
        self.await_drawn("right", "s")
        self.assertFalse(places(self.nodes["m"])["right"]["there"])
        said = ctl(self.nodes["m"]).stdout
        self.assertRegex(said, r"(?m)^left +a +a +a\.example:80$")
        self.assertRegex(said, r"(?m)^right +later +s +s\.example:80  as ")
        self.assertRegex(said, r"(?m)^s .*  spare")
        answer = self.nodes["m"].get("/v1/views/right/placed")
        self.assertEqual(answer.status, 503)
        self.assertEqual(answer.json(), {
            "view": "right", "node": "later", "drawnBy": "s", "there": False,
            "address": "s.example:80"})
        # By protobuf.
        with Session(self.nodes["s"].connect_tcp()) as session:
            reply = session.ask(place={"view": "right"})
            self.assertEqual([p.view for p in reply.cluster.places], ["left"])
            reply = session.ask(place={"view": "none", "node": "a"})
            self.assertEqual(reply.error.code, session.pb.NOT_FOUND)
        self.assertEqual(ctl(self.nodes["a"], "unplace", "left").returncode, 0)
        until("it is known to all", lambda: not any(
            places(n) for n in self.there()))
        for node in self.nodes.values():
            self.assertTrue(draws(node, "left"))  # unplaced: whoever

    def test_1_writers_at_once_lose_nothing(self):
        """Three nodes are given a view's place and another's end at once, many
        times over: nobody's edit is lost."""
        views = [f"v{i}" for i in range(9)]
        for view in views:
            def put(v=view):
                return next((a for a in (n.request(
                    "PUT", f"/v1/views/{v}", case.VIEW)
                    for n in self.there()) if a.status in (200, 201)), None)
            until("the view is there", put)
        until("everywhere", lambda: all(
            {v["name"] for v in n.state()["views"]} >= set(views)
            for n in self.there()))
        failed = []

        def edit(node, mine):
            for turn in range(10):
                for view in mine:
                    a = place(node, view, f"n{turn}")
                    if a.status != 200:
                        failed.append(a)
            a = node.request("DELETE", f"/v1/cluster/place/{mine[0]}")
            if a.status != 200:
                failed.append(a)
        threads = [threading.Thread(target=edit, args=(
            node, views[3 * i:3 * i + 3]))
            for i, node in enumerate(self.there())]
        for t in threads:
            t.start()
        for t in threads:
            t.join()
        self.assertEqual(failed, [])
        want = {v: "n9" for i, v in enumerate(views) if i % 3}
        until("all agree", lambda: all(
            {v: p["node"] for v, p in places(n).items()} == want
            for n in self.there()))

    def test_1_what_may_come_is_warm(self):
        """The node of a view and the spare draw it once before anybody asks;
        nobody else does."""
        def drawn():
            return {n.name: n.metrics()["pelagos_frames_views_total"]
                    for n in self.there()}
        until("the view is there", lambda: any(n.request(
            "PUT", "/v1/views/fresh", case.VIEW).status < 300
            for n in self.there()))
        until("everywhere", lambda: all("fresh" in [
            v["name"] for v in n.state()["views"]] for n in self.there()))
        before = None
        while before != (before := drawn()):
            time.sleep(2.5)  # what was begun is drawn
        self.assertEqual(place(self.nodes["m"], "fresh", "a").status, 200)
        before["a"] += 1
        before["s"] += 1
        until("it is drawn", lambda: drawn() == before)
        time.sleep(1.5)  # and no more
        self.assertEqual(drawn(), before)

    # --- nodes that go and come ---------------------------------------------

    def test_2_a_spare_takes_and_gives_back(self):
        self.await_all_there()
        a = self.nodes["a"]
        master = next(n for n in self.there() if n.is_master())
        if master is a:  # killed later, as one that leads
            self.await_another_master(a)
        self.assertEqual(place(self.nodes["m"], "left", "a").status, 200)
        self.assertEqual(place(self.nodes["m"], "right", "m").status, 200)
        self.await_drawn("left", "a")
        self.await_drawn("right", "m")
        for _ in range(2):
            begun = time.monotonic()
            self.nodes["a"].process.kill()  # its end may take seconds
            await_taken("left", [self.nodes["s"]])
            took = time.monotonic() - begun
            self.nodes["a"].kill()
            print(f"a spare has the view {took:.2f} s after kill -9 of its node")
            self.await_drawn("left", "s")
            self.await_drawn("right", "m")  # nothing else moves
            picture = self.nodes["s"].get(f"/v1/views/left/frame.png{SMALL}")
            self.assertEqual(picture.status, 200)
            self.assertTrue(next(n for n in self.nodes["m"].cluster()["nodes"]
                                 if n["name"] == "a")["silent"])
            self.begin("a", "--exercise-rank", "1")
            begun = time.monotonic()
            self.await_drawn("left", "a")
            back = time.monotonic() - begun
            print(f"it has it again {back:.2f} s after it follows")
            self.assertGreater(back, 2)  # not before it is steady

    def await_another_master(self, old):
        """It hangs for as long as another takes over."""
        old.process.send_signal(signal.SIGSTOP)
        until("another master", lambda: any(
            n.is_master() for n in self.there() if n is not old))
        old.process.send_signal(signal.SIGCONT)
        until("it follows", old.follows)

    def test_3_the_master_is_killed(self):
        master = next(n for n in self.there() if n.is_master())
        name = master.name
        self.await_all_there()
        self.assertEqual(place(master, "left", name).status, 200)
        self.await_drawn("left", name)
        others = [n for n in self.there() if n is not master]
        begun = time.monotonic()
        master.process.kill()
        await_taken("left", others)
        print(f"a spare has the view {time.monotonic() - begun:.2f} s after "
              "kill -9 of its node, the master")
        master.kill()
        self.await_drawn("left", "s" if name != "s" else "a")
        self.begin(name, *(["--exercise-spare"] if name == "s" else []))
        self.await_drawn("left", name)

    def test_4_a_hanging_node(self):
        """One that hangs is gone, and does not say that it draws it when it
        wakes up."""
        node = next(n for n in self.there()
                    if n.name in "am" and not n.is_master())
        self.await_all_there()
        self.assertEqual(place(node, "left", node.name).status, 200)
        self.await_drawn("left", node.name)
        node.process.send_signal(signal.SIGSTOP)
        try:
            until("the spare draws it", lambda: draws(self.nodes["s"], "left"))
        finally:
            node.process.send_signal(signal.SIGCONT)
        self.await_drawn("left", node.name)

    def test_5_the_store_stands(self):
        """Where etcd does not answer nobody is taken for gone, no edit is
        said to be done, and a node says that it is not up to date."""
        self.await_all_there()
        a = self.nodes["a"]
        self.assertEqual(place(a, "left", "a").status, 200)
        self.await_drawn("left", "a")
        moves = {n.name: n.metrics()["pelagos_cluster_place_moves_total"]
                 for n in self.there()}
        member = self.store.members[0].process
        member.send_signal(signal.SIGSTOP)
        try:
            until("it is not up to date", lambda: not draws(a, "left"))
            answer = place(a, "right", "a")
            self.assertIn(answer.status, (503, 409), answer)
            self.assertRegex(answer.json()["detail"],
                             r"store \(etcd\) does not answer|is joining")
        finally:
            member.send_signal(signal.SIGCONT)
        self.await_drawn("left", "a")
        for node in self.there():
            self.assertEqual(
                node.metrics()["pelagos_cluster_place_moves_total"],
                moves[node.name])

    # --- HAProxy -------------------------------------------------------------

    def test_6_haproxy_routes_by_it(self):
        if not shutil.which("haproxy"):
            self.skipTest("haproxy is not installed")
        self.await_all_there()
        with open(CONFIG, encoding="ascii") as f:
            text = f.read()
        port = free_port()
        text = text.replace("bind :8080", f"bind 127.0.0.1:{port}")
        for number, name in enumerate("ams", 1):
            text = text.replace(
                f"127.0.0.1:808{number}",
                f"127.0.0.1:{self.nodes[name].http_port}")
        folder = tempfile.mkdtemp(prefix="pelagos-placed-")
        self.addCleanup(shutil.rmtree, folder, ignore_errors=True)
        path = os.path.join(folder, "placed.cfg")
        with open(path, "w", encoding="ascii") as f:
            f.write(text)
        self.assertEqual(place(self.nodes["m"], "left", "a").status, 200)
        self.await_drawn("left", "a")
        subprocess.run(["haproxy", "-c", "-q", "-f", path], check=True)
        balancer = subprocess.Popen(["haproxy", "-q", "-f", path],
                                    stderr=subprocess.DEVNULL)

        def stop():
            balancer.kill()
            balancer.wait()
        self.addCleanup(stop)

        def ask():
            with contextlib.suppress(OSError, http.client.HTTPException):
                c = http.client.HTTPConnection("127.0.0.1", port, timeout=5)
                with contextlib.closing(c):
                    c.request("GET", f"/v1/views/left/frame.png{SMALL}")
                    answer = c.getresponse()
                    answer.read()
                    return answer.status
            return 0

        def goes_to(name):
            return self.watched_at(port) == [name]
        until("HAProxy listens", lambda: ask() > 0)
        until("HAProxy sends viewers to a", lambda: goes_to("a"))
        self.assertEqual(ask(), 200)
        live = Live(port)
        until("it is answered", live.answered)
        begun = time.monotonic()
        self.nodes["a"].process.kill()
        until("the viewer is let go", lambda: live.closed())
        until("it is served again", lambda: ask() == 200, pause_s=0.02)
        print("viewers behind HAProxy have pictures again "
              f"{time.monotonic() - begun:.2f} s after kill -9")
        self.nodes["a"].kill()
        self.assertEqual(self.watched_at(port), ["s"])
        self.begin("a", "--exercise-rank", "1")

    def watched_at(self, port):
        """The nodes that say that somebody watches it, while one does that
        comes through HAProxy."""
        def watched():
            return [n.name for n in self.there() for m in n.cluster()["nodes"]
                    if m["name"] == n.name and "left" in m.get("views", [])]
        viewer = Live(port)
        try:
            until("it is answered", viewer.answered)
            if not viewer.answer or viewer.answer.status != 200:
                return []
            return until("a node says so", lambda: watched() or (
                viewer.closed() and ["nobody"]))
        finally:
            viewer.close()
            until("it has left", lambda: not watched())


class Live:
    """Reads Motion-JPEG of the view for as long as it comes."""

    def __init__(self, port):
        self.connection = http.client.HTTPConnection("127.0.0.1", port,
                                                     timeout=SLOW_S)
        self.connection.connect()
        self.sock = self.connection.sock  # the library lets go of it
        self.answer = None
        self.ended = threading.Event()
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        with contextlib.suppress(OSError, ValueError, AttributeError,
                                 http.client.HTTPException):
            self.connection.request("GET", "/v1/views/left/mjpeg")
            self.answer = self.connection.getresponse()
            while self.answer.read(4096):
                pass
        self.ended.set()

    def answered(self):
        return self.answer or self.ended.is_set()

    def closed(self):
        return self.ended.is_set()

    def close(self):
        with contextlib.suppress(OSError):
            self.sock.shutdown(socket.SHUT_RDWR)
        self.ended.wait(SLOW_S)
        self.connection.close()
        self.sock.close()


if __name__ == "__main__":
    if not case.has_etcd():
        print("SKIP: no etcd")
        sys.exit(77)
    unittest.main(verbosity=2)
