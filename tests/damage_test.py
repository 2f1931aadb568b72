#!/usr/bin/python3
"""A daemon's journal and state file, damaged between its lives: each damage is
told, in the log and in /healthz, costs the damaged entry at most, and the file
is kept. DAMAGE_PLACES: so many places by chance for each file."""
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import ROOT, SANITIZED, Daemon

PLACES = int(os.environ.get("DAMAGE_PLACES", "3"))
EDITS = 24
FIRST = 30  # number of the first ship
GOLDEN = os.path.join(ROOT, "tests/golden/state")


def read(path):
    with open(path, "rb") as f:
        return f.read()


def write(path, data):
    with open(path, "wb") as f:
        f.write(data)


def edit(daemon, first=FIRST, count=EDITS):
    for i in range(first, first + count):
        answer = daemon.patch({"entities": {str(i): {
            "name": f"ship {i}", "latitude": 52.6, "longitude": 5.2}}})
        assert answer.status == 200, answer


def ships(daemon):
    return {e["id"] for e in daemon.state()["entities"] if e["id"] >= FIRST}


class Damage(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.state = os.path.join(folder.name, "state.json")
        self.journal = self.state + ".journal"
        self.chance = random.Random(1)

    def life(self, how=signal.SIGTERM, edits=True):
        """The files that it leaves, by the ends of their names."""
        daemon = Daemon("--state", self.state)
        old = read(self.state)
        try:
            if edits:
                edit(daemon)
        finally:
            daemon.stop(how)
        files = self.files()
        if how == signal.SIGKILL:
            files[""] = old  # that of before the edits
            files.pop(".prev", None)
        return files

    def files(self):
        folder = os.path.dirname(self.state)
        return {name[len("state.json"):]: read(os.path.join(folder, name))
                for name in os.listdir(folder)
                if name.startswith("state.json")}

    def put(self, files):
        for name in self.files():
            os.unlink(self.state + name)
        for name, data in files.items():
            if not name.endswith(".lock"):
                write(self.state + name, data)

    def start(self, *more):
        """What a start makes of the files: ships, log, reasons of /healthz."""
        with Daemon("--state", self.state, *more) as daemon:
            health = daemon.get("/healthz").json()
            reasons = [d["reason"] for d in health.get("degraded", [])]
            return ships(daemon), daemon.log(), reasons

    def told(self, files, which, bad, lost):
        """`which` of the files is replaced by `bad`."""
        self.put({**files, which: bad})
        there, log, reasons = self.start()
        self.assertTrue(reasons, log)
        self.assertRegex(log, "SCN-015" if which else "SCN-002")
        self.assertEqual(read(self.state + which + ".bad"), bad)
        gone = EDITS - len(there)
        self.assertLessEqual(gone, lost, log)
        if which:
            said = re.search(r"(\d+) are lost", reasons[0])
            said = int(said.group(1)) if said else 0
            # The head counts as well, whose state the file has.
            self.assertIn(said - gone, (0, 1), reasons)
        return gone

    def places(self, size):
        quarters = [size * i // 4 for i in range(4)] + [size - 1]
        return quarters + [self.chance.randrange(size) for _ in range(PLACES)]

    def flipped(self, data):
        for at in self.places(len(data)):
            bad = bytearray(data)
            bad[at] ^= 1 << self.chance.randrange(8)
            yield at, bytes(bad)

    def test_flipped_bits_of_the_journal(self):
        files = self.life(signal.SIGKILL)
        tried = [self.told(files, ".journal", bad, 1)
                 for _, bad in self.flipped(files[".journal"])]
        print(f"{len(tried)} of {len(tried)} told, {sum(tried)} edits lost")

    def test_tails_of_the_journal_that_are_cut(self):
        files = self.life(signal.SIGKILL)
        whole = files[".journal"]
        # Of the last half; a head that is cut as well has no edits.
        cuts = sorted(self.chance.sample(range(1, len(whole) // 2), PLACES))
        lost = [self.told(files, ".journal", whole[:-cut], EDITS)
                for cut in [1] + cuts]
        self.assertEqual(lost, sorted(lost))
        self.assertEqual(lost[0], 1)
        print(f"{len(lost)} of {len(lost)} told; lost: {lost}")

    def test_flipped_bits_of_the_state_after_a_clean_end(self):
        """Nothing is lost: the generation before it has the same."""
        files = self.life()
        self.assertNotIn(".journal", files)
        count = 0
        for at, bad in self.flipped(files[""]):
            self.assertEqual(self.told(files, "", bad, 0), 0, at)
            count += 1
        for size in (0, 1, len(files[""]) // 2):
            self.assertEqual(self.told(files, "", files[""][:size], 0), 0)
            count += 1
        print(f"{count} of {count} told, no edit lost")

    def test_both_generations_damaged(self):
        files = self.life()
        bad = files[""][:100]
        self.put({"": bad, ".prev": bad[:90]})
        there, log, reasons = self.start()
        self.assertEqual(there, set())
        self.assertIn("the generation before it does not load either",
                      reasons[0])
        self.assertIn("SCN-002", log)
        self.assertEqual(read(self.state + ".bad"), bad)
        self.assertEqual(read(self.state + ".prev.bad"), bad[:90])

    def test_state_and_journal_damaged_after_a_kill(self):
        """The generation before and the rest of the journal."""
        files = self.life()
        self.put(files)
        daemon = Daemon("--state", self.state)
        edit(daemon, FIRST + EDITS, 6)
        daemon.stop(signal.SIGKILL)
        files = self.files()
        journal = bytearray(files[".journal"])
        journal[journal.index(f"ship {FIRST + EDITS + 2}".encode())] ^= 1
        self.put({**files, "": files[""][:50], ".journal": bytes(journal)})
        there, log, reasons = self.start()
        self.assertGreaterEqual(len(there), EDITS + 5, log)
        self.assertEqual(len(reasons), 2, reasons)

    def test_second_lives_keep_what_the_first_kept(self):
        """In one folder, again and again: no older file is overwritten."""
        kept = []
        for life in range(4):
            daemon = Daemon("--state", self.state)
            edit(daemon, FIRST + life, 2)
            # The folder has one daemon.
            with self.assertRaisesRegex(RuntimeError, "another daemon"):
                Daemon("--state", self.state).stop()
            daemon.stop(signal.SIGKILL)
            bad = bytearray(read(self.journal))
            bad[-2] ^= 4
            write(self.journal, bad)
            kept.append(bytes(bad))
        self.start()
        for life, bad in enumerate(kept):
            end = ".bad" if life == 0 else f".bad.{life + 1}"
            self.assertEqual(read(self.journal + end), bad)

    def test_journals_of_the_first_form(self):
        """Without checksums: what cannot be read is told, no start fails."""
        for version in ("0", "1"):
            files = {"": read(f"{GOLDEN}/{version}/scene"),
                     ".journal": read(f"{GOLDEN}/{version}/scene.journal")}
            whole = files[".journal"]
            self.assertEqual(whole[:6], b"PELOG1")
            for cut in (1, 3, len(whole) // 8):
                self.put({**files, ".journal": whole[:-cut]})
                _, log, reasons = self.start()
                self.assertTrue(reasons, (version, cut, log))
                self.assertEqual(read(self.journal + ".bad"), whole[:-cut])
            self.put({**files, ".journal": b"PELOG1\r\n" + b"\xff" * 64})
            _, log, reasons = self.start()
            self.assertTrue(reasons, (version, log))

    @unittest.skipIf(SANITIZED, "a sanitizer must be loaded first")
    def test_a_clock_that_is_set_back(self):
        """Between the lives, by a day: all edits are there, and of two
        generations the newest is used, whatever their files' times."""
        folder = os.path.dirname(self.state)
        shim = os.path.join(folder, "jump.so")
        subprocess.run([os.environ.get("CC", "cc"), "-shared", "-fPIC", "-o",
                        shim, os.path.join(ROOT, "tests/lib/clockjump.c"),
                        "-ldl"], check=True)
        jump = os.path.join(folder, "jump")
        os.environ.update(LD_PRELOAD=shim, CLOCK_JUMP=jump)
        try:
            for life, seconds in enumerate((0, -86400, -172800, 86400)):
                write(jump, str(seconds).encode())
                daemon = Daemon("--state", self.state)
                self.assertEqual(len(ships(daemon)), 3 * life)
                edit(daemon, FIRST + 3 * life, 3)
                daemon.stop((signal.SIGKILL, signal.SIGTERM)[life % 2])
        finally:
            del os.environ["LD_PRELOAD"], os.environ["CLOCK_JUMP"]
        os.utime(self.state, (0, 0))
        there, _, reasons = self.start()
        self.assertEqual((len(there), reasons), (12, []))


if __name__ == "__main__":
    unittest.main(verbosity=2)
