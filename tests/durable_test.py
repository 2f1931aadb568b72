#!/usr/bin/python3
"""What was answered is there after kill -9, and a full disk loses nothing that
the reserved room of the journal holds."""
import contextlib
import http.client
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import BIN, ROOT, SANITIZED, SLOW_S, Daemon, until

KILLS = int(os.environ.get("DURABLE_KILLS", "4"))


def field(daemon, path):
    return daemon.get("/v1/state/" + path).json()["value"]


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
        daemon = self.daemon()
        for i in range(4):
            daemon.patch({"sky": {"visibility": 7000 + i}})
        daemon.stop(signal.SIGKILL)
        with open(self.state + ".journal", "r+b") as f:
            size = os.fstat(f.fileno()).st_size
            f.truncate(size - 3)   # torn: its last edit is left out
        os.utime(self.state)
        with self.daemon() as daemon:
            self.assertEqual(field(daemon, "sky.visibility"), 7002)
        # The daemon ended well: what lies there now belongs to nobody.
        with open(self.state + ".journal", "wb") as f:
            f.write(b"no journal")
        with self.daemon() as daemon:
            self.assertEqual(field(daemon, "sky.visibility"), 7002)
            self.assertIn("SCN-015", daemon.log())

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
        """Read-only, failing, taking half of what is written: pictures and
        edits go on; each part says it once, and once that it is over; then
        nothing that was answered is lost."""
        record = os.path.join(self.folder.name, "r.pelog")
        with disk_that_fills(self.folder.name) as path:
            for at, fault in enumerate(("EROFS", "EIO", "SHORT")):
                base = 8000 + 100 * at
                with self.subTest(fault), self.daemon(
                        "--record", record) as daemon:
                    with open(path + "-", "w") as f:
                        f.write(fault)
                    os.rename(path + "-", path)
                    self._edits_and_pictures(daemon, base)
                    until("said", lambda: "SCN-003" in daemon.log())
                    # Tried again, and not said again.
                    until("tried again", lambda: daemon.metrics()[
                        "pelagos_scene_save_errors_total"] >= 2)
                    os.unlink(path)
                    until("saved again", lambda: "SCN-014" in daemon.log())

                    def well():
                        self._edits_and_pictures(daemon, base + 50)
                        log = daemon.log()
                        return ("REC-002" in log) == ("REC-008" in log) and (
                            "SCN-012" in log) == ("SCN-013" in log)
                    until("all is over", well)
                    log = daemon.log()
                    for what in ("SCN-003", "SCN-014", "SCN-012", "REC-002"):
                        self.assertLessEqual(log.count(what), 1, log)
                    daemon.stop(signal.SIGKILL)
                with self.daemon() as daemon:
                    self.assertEqual(field(daemon, "sky.visibility"), base + 52)

    @unittest.skipIf(SANITIZED, "a sanitizer must be loaded first")
    def test_an_end_that_loses_edits_says_so(self):
        """Where neither the state nor its journal can be written SIGTERM does
        not end with 0."""
        with disk_that_fills(self.folder.name) as path:
            daemon = self.daemon()
            with open(path, "w", encoding="ascii") as f:
                f.write("EIO")
            self._edits_and_pictures(daemon, 8100)
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

    def _edits_and_pictures(self, daemon, base):
        for i in range(3):
            self.assertEqual(daemon.patch({"sky": {
                "visibility": base + i}}).status, 200)
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
