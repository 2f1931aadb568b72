#!/usr/bin/python3
"""What was answered is there after kill -9, and a full disk loses nothing that
the reserved room of the journal holds."""
import contextlib
import functools
import http.client
import json
import operator
import os
import random
import resource
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import cigi_host
from pelagos_daemon import (BIN, ROOT, SANITIZED, SLOW_S, Daemon, Session,
                            free_port, until)

KILLS = int(os.environ.get("DURABLE_KILLS", "4"))


def field(daemon, path):
    return daemon.get("/v1/state/" + path).json()["value"]


def read(path):
    with open(path, "rb") as f:
        return f.read()


def health(daemon):
    answer = daemon.get("/healthz")
    assert answer.status == 200, answer
    return answer.json()


@contextlib.contextmanager
def small_file_limit(size):
    """Daemons that start within may have files of so many bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@contextlib.contextmanager
def disk_that_fills(folder):
    """Daemons that start within have a disk that is full while the file that
    this gives exists."""
    shim = os.path.join(folder, "fulldisk.so")
    full = os.path.join(folder, "full")
    subprocess.run([os.environ.get("CC", "cc"), "-shared", "-fPIC", "-o", shim,
                    os.path.join(ROOT, "tests/lib/fulldisk.c"), "-ldl"],
                   check=True)
    os.environ.update(LD_PRELOAD=shim, FULL_DISK=full)
    try:
        yield full
    finally:
        del os.environ["LD_PRELOAD"], os.environ["FULL_DISK"]


class Durable(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.state = os.path.join(self.folder.name, "state.json")

    def tearDown(self):
        self.folder.cleanup()

    def daemon(self, *more, **options):
        return Daemon("--state", self.state, *more, **options)

    def test_kill_loses_no_answered_edit(self):
        """Each life ends in the middle of edits, at no steady moment of the
        state file's second."""
        count, wanted = 0, {}
        for life in range(KILLS):
            daemon = self.daemon()
            try:
                for path, value in wanted.items():
                    self.assertEqual(field(daemon, path), value, life)
                for i in range(3 + 7 * (life % 3)):
                    count += 1
                    wind, ship = 3 + count % 20 / 2, 52 + count / 1000
                    answer = daemon.patch({
                        "sky": {"visibility": 5000 + count},
                        "entities": {"1": {"latitude": ship, "speed": 0},
                                     "7": {"name": f"target {count}"}}})
                    self.assertEqual(answer.status, 200, answer)
                    if count % 5 == 0:
                        daemon.patch({"sea": {"windSpeed": wind}})
                        wanted["sea.windSpeed"] = wind
                    wanted.update({"sky.visibility": 5000 + count,
                                   "entities.1.latitude": ship,
                                   "entities.7.name": f"target {count}"})
            finally:
                daemon.stop(signal.SIGKILL)
        with self.daemon() as daemon:
            for path, value in wanted.items():
                self.assertEqual(field(daemon, path), value)
            self.assertIn("SCN-016", daemon.log())
        # One that ends as it should leaves all in the file, no journal.
        self.assertFalse(os.path.exists(self.state + ".journal"))
        with open(self.state, encoding="utf-8") as f:
            self.assertEqual(json.load(f)["sky"]["visibility"], 5000 + count)

    def test_kill_while_edits_are_written(self):
        """Three clients edit as fast as they are answered when the end comes:
        what was answered is there, and at most the one that was under way."""
        chance = random.Random(KILLS)
        answered, starts, edits = [0] * 3, [], []

        def edit(daemon, client, killed):
            while not killed.is_set():
                value = answered[client] + 1
                begun = time.monotonic()
                try:
                    answer = daemon.patch({"entities": {str(20 + client): {
                        "name": f"n{value}", "latitude": 52.6,
                        "longitude": 5.2}}})
                except (OSError, http.client.HTTPException):
                    return
                if answer.status != 200:
                    return
                edits.append(time.monotonic() - begun)
                answered[client] = value

        for life in range(KILLS):
            begun = time.monotonic()
            daemon = self.daemon()
            try:
                there = {e["id"]: e["name"] for e in daemon.state()["entities"]
                         if "name" in e}
                for client in range(3):
                    name = there.get(20 + client, "n0")
                    got = int(name[1:])
                    self.assertIn(got - answered[client], (0, 1), life)
                    answered[client] = got
                picture = daemon.get(
                    "/v1/views/bridge/frame.jpg?width=64&height=36")
                self.assertEqual(picture.status, 200, life)
                starts.append(time.monotonic() - begun)
                killed = threading.Event()
                threads = [threading.Thread(target=edit,
                                            args=(daemon, client, killed))
                           for client in range(3)]
                for thread in threads:
                    thread.start()
                time.sleep(chance.uniform(0.02, 0.3))
                daemon.process.kill()
                killed.set()
                for thread in threads:
                    thread.join()
            finally:
                daemon.stop(signal.SIGKILL)
        starts.sort()
        edits.sort()
        self.assertGreater(len(edits), KILLS)
        print(f"{KILLS} kills, {len(edits)} edits answered: "
              f"p99 {1e3 * edits[int(.99 * (len(edits) - 1))]:.1f} ms of three "
              "clients at once; first picture after a start: median "
              f"{starts[len(starts) // 2]:.2f} s, "
              f"p99 {starts[int(.99 * (len(starts) - 1))]:.2f} s, "
              f"worst {starts[-1]:.2f} s")

    def test_steps_are_kept(self):
        daemon = self.daemon()
        daemon.patch({"clock": {"mode": "STEPPED", "time": 10}})
        for _ in range(5):
            self.assertEqual(daemon.request("POST", "/v1/clock/step", {
                "seconds": 0.25}).status, 200)
        at = field(daemon, "clock.time")
        daemon.stop(signal.SIGKILL)
        with self.daemon() as daemon:
            self.assertEqual(field(daemon, "clock.time"), at)

    def test_a_damaged_journal(self):
        """Whole entries are used, the file is kept, the loss is told in numbers
        until somebody has looked."""
        journal = self.state + ".journal"
        daemon = self.daemon()
        for i in range(20):
            self.assertEqual(daemon.patch({"entities": {str(30 + i): {
                "name": f"ship {i}", "latitude": 52.6, "longitude": 5.2}}}
                ).status, 200)
        daemon.stop(signal.SIGKILL)
        with open(journal, "rb") as f:
            whole = bytearray(f.read())
        at = whole.index(b"ship 7")
        whole[at] ^= 1
        with open(journal, "wb") as f:
            f.write(whole)
        # The state of before the edits.
        with open(self.state, encoding="utf-8") as f:
            old = json.load(f)
        old.pop("stateChecksum")
        old["revision"] = "0"
        old["entities"] = [e for e in old["entities"] if e["id"] < 30]
        with open(self.state, "w", encoding="utf-8") as f:
            json.dump(old, f)
        with self.daemon() as daemon:
            names = [e["name"] for e in daemon.state()["entities"]
                     if e["id"] >= 30]
            self.assertEqual(names, [f"ship {i}" for i in range(20) if i != 7])
            log = daemon.log()
            self.assertIn("SCN-015", log)
            self.assertIn("19 edits of it are used, 1 are lost", log)
            self.assertIn(f"first at byte {whole.rindex(whole[8:12], 0, at)}",
                          log)
            with open(journal + ".bad", "rb") as f:
                self.assertEqual(f.read(), whole)
            said = health(daemon)
            self.assertEqual(said["status"], "degraded")
            self.assertIn("1 are lost", said["degraded"][0]["reason"])
            os.unlink(journal + ".bad")  # somebody has looked
            self.assertEqual(health(daemon)["status"], "ok")

    def test_a_torn_journal(self):
        daemon = self.daemon()
        for i in range(4):
            daemon.patch({"sky": {"visibility": 7000 + i}})
        daemon.stop(signal.SIGKILL)
        with open(self.state + ".journal", "r+b") as f:
            size = os.fstat(f.fileno()).st_size
            f.truncate(size - 3)   # torn: its last edit is left out
        with self.daemon() as daemon:
            self.assertEqual(field(daemon, "sky.visibility"), 7002)
            self.assertIn("1 are lost", daemon.log())
        # The daemon ended well: what lies there now belongs to nobody.
        with open(self.state + ".journal", "wb") as f:
            f.write(b"no journal")
        with self.daemon() as daemon:
            self.assertEqual(field(daemon, "sky.visibility"), 7002)
            self.assertIn("SCN-015", daemon.log())
        with open(self.state + ".journal.bad.2", "rb") as f:
            self.assertEqual(f.read(), b"no journal")

    def test_the_journal_of_another_state_file(self):
        """As a state file that was copied over that of a daemon that was
        killed."""
        daemon = self.daemon()
        daemon.patch({"sky": {"visibility": 7000}})
        daemon.stop(signal.SIGKILL)
        other = os.path.join(self.folder.name, "other.json")
        with Daemon("--state", other) as daemon:
            daemon.patch({"sky": {"visibility": 8000}})
        os.rename(other, self.state)
        with self.daemon() as daemon:
            self.assertEqual(field(daemon, "sky.visibility"), 8000)
            self.assertIn("of another state file", daemon.log())
        self.assertTrue(os.path.exists(self.state + ".journal.bad"))

    def test_a_flipped_bit_of_the_state_file(self):
        """All of them are told; the journal has the state, where there is
        one."""
        daemon = self.daemon()
        daemon.patch({"sky": {"visibility": 7000}})
        until("it is saved", lambda: b"7000" in read(self.state))
        daemon.stop(signal.SIGKILL)
        whole = bytearray(read(self.state))
        journal = read(self.state + ".journal")
        for at in (whole.index(b"7000") + 1, 20, whole.index(b"Lineage") + 14):
            for name in os.listdir(self.folder.name):
                os.unlink(os.path.join(self.folder.name, name))
            bad = bytearray(whole)
            bad[at] ^= 1
            with open(self.state, "wb") as f:
                f.write(bad)
            with open(self.state + ".journal", "wb") as f:
                f.write(journal)
            with self.daemon() as daemon:
                self.assertEqual(field(daemon, "sky.visibility"), 7000)
                self.assertIn("SCN-002", daemon.log())
                self.assertEqual(health(daemon)["status"], "degraded")
            with open(self.state + ".bad", "rb") as f:
                self.assertEqual(f.read(), bad)

    def test_a_limit_of_file_sizes(self):
        """ulimit -f: as a disk that is full, and no signal ends the daemon."""
        record = os.path.join(self.folder.name, "r.pelog")
        with small_file_limit(48 << 10):
            daemon = self.daemon("--record", record)
        answers = [daemon.patch({"entities": {"5": {
            "name": "n" * 60, "latitude": 52.6, "heading": i % 360}}}).status
            for i in range(900)]
        self.assertLessEqual(set(answers), {200, 507})
        self.assertGreater(answers.count(200), 300)
        self.assertIn("REC-002", daemon.log())
        until("the journal restarts", lambda: daemon.patch({
            "sky": {"visibility": 7001}}).status == 200)
        daemon.stop(signal.SIGKILL)
        with self.daemon() as daemon:
            self.assertEqual(field(daemon, "sky.visibility"), 7001)

    @unittest.skipIf(SANITIZED, "a sanitizer must be loaded first")
    def test_beyond_what_is_reserved(self):
        """Edits are kept within what was reserved before the disk was full,
        then refused with 507, and taken again when there is room."""
        with disk_that_fills(self.folder.name) as full:
            daemon = self.daemon()
            open(full, "w").close()
            kept, status = 0, 200
            while status == 200:
                answer = daemon.patch({"views": {f"v{kept % 50}": {"entity": 1}},
                                       "sky": {"visibility": 5000 + kept},
                                       "entities": {str(100 + i): {
                                           "name": "x" * 60, "latitude": 52.6,
                                           "longitude": 5 + i / 1000}
                                           for i in range(100)}})
                status = answer.status
                kept += status == 200
            self.assertEqual(status, 507, answer)
            self.assertEqual(answer.json()["code"], "IO")
            self.assertGreater(kept, 50)
            print(f"{kept} edits of 10 kB within what is reserved")
            self.assertEqual(field(daemon, "sky.visibility"), 4999 + kept)
            said = health(daemon)
            self.assertEqual(said["status"], "degraded")
            self.assertIn("edits are refused", str(said["degraded"]))
            self.assertEqual(daemon.get(
                "/v1/views/bridge/frame.jpg?width=64&height=36").status, 200)
            daemon.stop(signal.SIGKILL)
            with self.daemon() as daemon:  # full still
                self.assertEqual(field(daemon, "sky.visibility"), 4999 + kept)
                os.unlink(full)
                until("it is well", lambda: health(daemon)["status"] == "ok")
                self.assertEqual(daemon.patch({"sky": {
                    "visibility": 7000}}).status, 200)

    def test_a_state_that_was_removed_stays_so(self):
        daemon = self.daemon()
        daemon.patch({"sky": {"visibility": 7000}})
        daemon.stop(signal.SIGKILL)
        os.unlink(self.state)
        with self.daemon() as daemon:
            self.assertNotEqual(field(daemon, "sky.visibility"), 7000)

    def test_a_broken_state_file_has_its_journal(self):
        daemon = self.daemon()
        daemon.patch({"sky": {"visibility": 7000}})
        daemon.stop(signal.SIGKILL)
        with open(self.state, "w") as f:
            f.write("{")
        with self.daemon() as daemon:
            self.assertEqual(field(daemon, "sky.visibility"), 7000)
            self.assertIn("begins with its journal", daemon.log())

    @unittest.skipIf(SANITIZED, "a sanitizer must be loaded first")
    def test_full_disk(self):
        """Pictures, edits and restarts go on; what is wrong is said once, and
        once that it is over; SIGTERM loses nothing."""
        record = os.path.join(self.folder.name, "r.pelog")

        def picture(daemon):
            answer = daemon.get("/v1/views/bridge/frame.jpg?width=64&height=36")
            self.assertEqual(answer.status, 200)

        def edit(daemon, value):
            self.assertEqual(daemon.patch({"sky": {
                "visibility": value}}).status, 200)
            picture(daemon)
        with disk_that_fills(self.folder.name) as full:
            daemon = self.daemon("--record", record)
            edit(daemon, 7000)
            open(full, "w").close()
            edit(daemon, 7001)
            until("the state is not saved", lambda: "SCN-003" in daemon.log())
            # More than fits into the last blocks of the recording.
            for i in range(400):
                daemon.patch({"entities": {"5": {"name": f"{i}" * 10}}})
            edit(daemon, 7002)
            until("nor the recording", lambda: "REC-002" in daemon.log())
            until("tried again", lambda: daemon.metrics()[
                "pelagos_scene_save_errors_total"] >= 2)
            self.assertEqual(daemon.log().count("SCN-003"), 1)
            self.assertEqual(daemon.metrics()[
                "pelagos_scene_journal_lost_total"], 0)
            log = daemon.log_path
            daemon.process.terminate()
            self.assertEqual(daemon.process.wait(60), 0)
            with open(log, encoding="utf-8") as f:
                self.assertIn("its journal has them", f.read())
            daemon.stop()
            # Full still.
            with self.daemon("--record", record) as daemon:
                self.assertEqual(field(daemon, "sky.visibility"), 7002)
                self.assertIn("REC-009", daemon.log())
                picture(daemon)
                os.unlink(full)
                until("saved again", lambda: "SCN-014" in daemon.log())

                def recording():
                    edit(daemon, 7003)
                    return "REC-008" in daemon.log()
                until("recording again", recording)
            with self.daemon() as daemon:
                self.assertEqual(field(daemon, "sky.visibility"), 7003)

    @unittest.skipIf(SANITIZED, "a sanitizer must be loaded first")
    def test_other_faults_of_the_disk(self):
        """Read-only, failing, taking half of what is written: pictures go on,
        and edits that cannot be kept are refused and change nothing; each part
        says it once, and once that it is over; then nothing that was answered
        is lost."""
        record = os.path.join(self.folder.name, "r.pelog")
        with disk_that_fills(self.folder.name) as path:
            for at, fault in enumerate(("EROFS", "EIO", "SHORT")):
                base = 8000 + 100 * at
                with self.subTest(fault), self.daemon(
                        "--record", record) as daemon:
                    with open(path + "-", "w") as f:
                        f.write(fault)
                    os.rename(path + "-", path)
                    before = field(daemon, "sky.visibility")
                    self._edits_and_pictures(daemon, base, 507)
                    self.assertEqual(field(daemon, "sky.visibility"), before)
                    self.assertEqual(health(daemon)["status"], "degraded")
                    until("said", lambda: "SCN-012" in daemon.log())
                    os.unlink(path)
                    # Without an edit, too.
                    until("it takes edits again", lambda: health(daemon)[
                        "status"] == "ok")
                    self._edits_and_pictures(daemon, base + 50)

                    def well():
                        self._edits_and_pictures(daemon, base + 50)
                        log = daemon.log()
                        return ("REC-002" in log) == ("REC-008" in log) and (
                            "SCN-012" in log) == ("SCN-013" in log)
                    until("all is over", well)
                    log = daemon.log()
                    for what in ("SCN-003", "SCN-014", "SCN-012", "SCN-034",
                                 "REC-002"):
                        self.assertLessEqual(log.count(what), 1, log)
                    daemon.stop(signal.SIGKILL)
                with self.daemon() as daemon:
                    self.assertEqual(field(daemon, "sky.visibility"), base + 52)

    @unittest.skipIf(SANITIZED, "a sanitizer must be loaded first")
    def test_every_way_to_edit(self):
        """By HTTP, protobuf, Modbus, CIGI, NMEA and a step each edit that
        cannot be kept is refused in the way's own words and changes nothing;
        each is taken again when there is room."""
        modbus, cigi_port, nmea = free_port(), free_port(socket.SOCK_DGRAM), \
            free_port(socket.SOCK_DGRAM)
        with disk_that_fills(self.folder.name) as path, self.daemon(
                "--modbus", f"127.0.0.1:{modbus}", "--cigi",
                f"127.0.0.1:{cigi_port}", "--cigi-silence", f"{SLOW_S:g}",
                "--nmea", f"127.0.0.1:{nmea}", unix=True) as daemon:
            def http(value):
                return daemon.patch({"sky": {"visibility": 7000 + value}}).status

            def protobuf(value):
                with Session(daemon.connect_unix()) as session:
                    reply = session.ask(patch={"state": {"sky": {
                        "visibility": 8000 + value}}})
                    return session.pb.ErrorCode.Name(reply.error.code) \
                        if reply.HasField("error") else 200

            def coils(value):
                """Wind speed, staged, and commit: the exception's number."""
                with socket.create_connection(("127.0.0.1", modbus), 60) as s:
                    for at, words in ((10, struct.pack(">f", 5 + value)),
                                      (5, b"\0\1")):
                        count = len(words) // 2
                        s.sendall(struct.pack(">HHHBBHHB", 1, 0, 7 + len(words),
                                              1, 16, at, count, len(words))
                                  + words)
                        answer = s.recv(300)
                    return answer[8] if answer[7] & 0x80 else 200

            def step(value):
                return daemon.request("POST", "/v1/clock/step", {
                    "seconds": 0.25 + value}).status

            host = cigi_host.Host(("127.0.0.1", cigi_port))
            self.addCleanup(host.close)
            talker = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            self.addCleanup(talker.close)

            def kept(log, count):
                return until(f"the log has {log}", lambda:
                             daemon.log().count(log) >= count)

            def settled():
                state = daemon.state()
                del state["clock"], state["sources"]
                return state

            daemon.patch({"clock": {"mode": "STEPPED"}})
            ways = {"HTTP": (http, 507), "protobuf": (protobuf, "IO"),
                    "Modbus": (coils, 4), "step": (step, 507)}
            for value, (way, _) in enumerate(ways.values()):
                self.assertEqual(way(value), 200, way)
            before, time_s = settled(), field(daemon, "clock.time")
            with open(path + "-", "w", encoding="ascii") as f:
                f.write("EIO")
            os.rename(path + "-", path)
            for name, (way, refused) in ways.items():
                self.assertEqual(way(9), refused, name)
                self.assertEqual(settled(), before, name)
            self.assertEqual(field(daemon, "clock.time"), time_s)
            # These have no answers: the log and the counters say it.
            host.send(cigi_host.entity(1, 52.7, 5.3, yaw=77))
            kept("CIG-002", 1)
            body = b"HEHDT,99.5,T"
            sentence = b"$%s*%02X\r\n" % (body, functools.reduce(
                operator.xor, body))
            talker.sendto(sentence, ("127.0.0.1", nmea))
            kept("NME-002", 1)
            self.assertEqual(settled(), before)
            self.assertEqual(health(daemon)["status"], "degraded")
            os.unlink(path)
            until("it is well", lambda: health(daemon)["status"] == "ok")
            for value, (name, (way, _)) in enumerate(ways.items()):
                if name != "step":  # the host leads the clock
                    self.assertEqual(way(value + 10), 200, name)

            def heading(wanted, send):
                send()
                return daemon.state()["entities"][0]["heading"] == wanted
            until("CIGI leads again", lambda: heading(77, lambda: host.send(
                cigi_host.entity(1, 52.7, 5.3, yaw=77))))
            until("NMEA does again", lambda: heading(99.5, lambda: talker.sendto(
                sentence, ("127.0.0.1", nmea))))

    @unittest.skipIf(SANITIZED, "a sanitizer must be loaded first")
    def test_events_of_an_exercise(self):
        """One that comes due while the disk is full stays due, and the log is
        not filled; it takes effect when there is room."""
        folder = os.path.join(self.folder.name, "exercises")
        os.mkdir(folder)
        with open(os.path.join(folder, "one.json"), "w") as f:
            json.dump({"ownShip": 1, "state": {"entities": [
                {"id": 1, "latitude": 52.6, "longitude": 5.2}]}, "events": [
                    {"name": "fog", "when": [{"at": 2}], "patch": {"state": {
                        "sky": {"visibility": 777}}}}]}, f)
        with disk_that_fills(self.folder.name) as path, self.daemon(
                "--exercises", folder) as daemon:
            daemon.patch({"clock": {"mode": "FREE"}})
            daemon.request("POST", "/v1/exercise", {"action": "LOAD",
                                                    "name": "one"})
            with open(path + "-", "w", encoding="ascii") as f:
                f.write("EIO")
            daemon.request("POST", "/v1/exercise", {"action": "START"})
            begun = field(daemon, "clock.time")
            os.rename(path + "-", path)
            until("it is due", lambda: field(daemon, "clock.time") > begun + 4)
            self.assertNotEqual(field(daemon, "sky.visibility"), 777)
            for said in ("EXR-001", "EXR-006"):
                self.assertNotIn(said, daemon.log())
            os.unlink(path)
            until("it has come", lambda:
                  field(daemon, "sky.visibility") == 777)
            self.assertEqual(daemon.log().count("EXR-007"), 1)

    @unittest.skipIf(SANITIZED, "a sanitizer must be loaded first")
    def test_an_end_that_loses_edits_says_so(self):
        """Where neither the state nor its journal can be written SIGTERM does
        not end with 0."""
        with disk_that_fills(self.folder.name) as path:
            daemon = self.daemon("--journal-full", "continue")
            with open(path, "w", encoding="ascii") as f:
                f.write("EIO")
            self._edits_and_pictures(daemon, 8100)
            answer = daemon.patch({"sky": {"visibility": 8100}})
            self.assertIn("X-Pelagos-Volatile", answer.headers)
            self.assertIn("not kept", str(health(daemon)["degraded"]))
            until("not in the journal", lambda: "SCN-012" in daemon.log())
            log = daemon.log_path
            daemon.process.terminate()
            self.assertNotEqual(daemon.process.wait(SLOW_S), 0)
            with open(log, encoding="utf-8") as f:
                self.assertIn("SCN-003", f.read())
            daemon.stop()

    def test_an_edit_waits_little_for_its_journal(self):
        """Prints how long (make soak: on a quiet machine, p99 below 2 ms)."""
        edits = []
        with self.daemon() as daemon:
            connection = http.client.HTTPConnection(
                "127.0.0.1", daemon.http_port, timeout=SLOW_S)
            for i in range(2000):
                body = json.dumps({"entities": {"1": {"heading": i % 360}}})
                begun = time.perf_counter()
                connection.request("PATCH", "/v1/state", body, {
                    "Content-Type": "application/merge-patch+json"})
                answer = connection.getresponse()
                answer.read()
                edits.append(time.perf_counter() - begun)
                self.assertEqual(answer.status, 200)
            connection.close()
            self.assertEqual(daemon.metrics()[
                "pelagos_scene_journal_lost_total"], 0)
        edits.sort()
        print(f"an edit: median {1e3 * edits[1000]:.2f} ms, "
              f"p99 {1e3 * edits[1980]:.2f} ms, worst {1e3 * edits[-1]:.1f} ms")

    def _edits_and_pictures(self, daemon, base, status=200):
        for i in range(3):
            self.assertEqual(daemon.patch({"sky": {
                "visibility": base + i}}).status, status)
            self.assertEqual(daemon.get(
                "/v1/views/bridge/frame.jpg?width=64&height=36").status, 200)

    @unittest.skipIf(SANITIZED, "a sanitizer must be loaded first")
    def test_recording_pictures_to_a_full_disk(self):
        clip = os.path.join(self.folder.name, "clip.mkv")
        command = [os.path.join(BIN, "pelagosctl"), "record", "bridge", clip,
                   "--seconds", "60", "--width", "320", "--height", "180"]

        @contextlib.contextmanager
        def recorder():
            """Runs until it has written something."""
            ctl = subprocess.Popen(command, stderr=subprocess.PIPE)
            try:
                until("it writes or ends", lambda: ctl.poll() is not None or (
                    os.path.exists(clip) and os.path.getsize(clip) > 0))
                self.assertIsNone(ctl.poll(), ctl.poll() is not None and
                                  ctl.stderr.read())
                yield ctl
            finally:
                ctl.kill()
                ctl.communicate()

        with Daemon(unix=True) as daemon:
            command[1:1] = ["--server", "unix:" + daemon.unix_path]
            with disk_that_fills(self.folder.name) as full:
                with recorder() as ctl:
                    open(full, "w").close()
                    said = ctl.communicate(timeout=SLOW_S)[1].decode()
                    self.assertEqual(ctl.returncode, 1, said)
                    self.assertIn("clip.mkv", said)
                os.unlink(full)
                os.unlink(clip)
                # And a signal ends it whatever it does.
                with recorder() as ctl:
                    ctl.terminate()
                    self.assertEqual(ctl.wait(SLOW_S), 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
