#!/usr/bin/python3
"""A daemon takes what earlier ones left: state, journal and command log of
every version in tests/golden/state. What a newer one left is refused and stays
as it is.

    tests/upgrade_test.py --write NAME   makes tests/golden/state/NAME by the
                                         daemon of now
"""
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import BIN, ROOT, Daemon, until

GOLDEN = os.path.join(ROOT, "tests/golden/state")
VERSIONS = sorted(os.listdir(GOLDEN))
STATE_VERSION = 2  # of server/scene/store.h
FIRST = {
    "clock": {"mode": "STEPPED", "time": 100},
    "sea": {"synthesiser": "TROCHOIDS", "windSpeed": 11.5,
            "windDirection": 200, "seed": 41,
            "swell": [{"height": 1.5, "period": 9, "direction": 300}]},
    "sky": {"sunElevation": 12, "visibility": 9000,
            "fog": [{"visibility": 800, "top": 40}]},
    "views": {"port": {"yaw": -90, "entity": 1},
              "ir": {"entity": 7, "sensor": {"kind": "THERMAL"}}},
    "entities": {"7": {"name": "Bø", "latitude": 52.61, "longitude": 5.21,
                       "speed": 6, "heading": 40, "model": {"name": "container-ship"},
                       "wake": True, "wash": True,
                       "navigationStatus": "UNDER_WAY", "lights": "ON"}},
}
# In the journal alone.
THEN = [{"sea": {"windSpeed": 13.25, "wave": [
            {"height": 0.5, "period": 6, "direction": 10}]}},
        {"entities": {"7": {"heading": 70, "turnRate": 3.5},
                      "9": {"name": "buoy", "latitude": 52.6,
                            "longitude": 5.2, "afloat": True}},
         "views": {"ir": None}},
        {"origin": {"latitude": 52.5}, "sky": {"fog": None}}]


def read(*path):
    with open(os.path.join(*path), "rb") as f:
        return f.read()


def write(data, *path):
    with open(os.path.join(*path), "wb") as f:
        f.write(data)


def crc32c(data):
    """As RFC 3720 has it, little-endian."""
    crc = 0xffffffff
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82f63b78 if crc & 1 else 0)
    return (crc ^ 0xffffffff).to_bytes(4, "little")


def with_checksum(text):
    """A state file as its checksum says that it is."""
    at = text.index(b'"stateChecksum": "') + 18
    zeroed = text[:at] + bytes(8 * b"0") + text[at + 8:]
    return (text[:at] + crc32c(zeroed)[::-1].hex().encode() + text[at + 8:])


def make(name):
    """A session that ends by kill -9 while its journal is ahead."""
    to = os.path.join(GOLDEN, name)
    with tempfile.TemporaryDirectory() as folder:
        state = os.path.join(folder, "scene")
        daemon = Daemon("--state", state, "--record",
                        os.path.join(folder, "session.pelog"))

        def change(patch):
            answer = daemon.patch(patch)
            assert answer.status == 200, answer

        change(FIRST)
        until("it is saved", lambda: b"11.5" in read(state))
        kept = read(state)
        daemon.request("POST", "/v1/clock/step", {"seconds": 1.25})
        for patch in THEN:
            change(patch)
        daemon.request("POST", "/v1/clock/step", {"seconds": 0.5})
        expected = daemon.state()
        daemon.stop(signal.SIGKILL)
        os.makedirs(to)
        # The journal has every edit since the start; the state file as it was
        # before the last ones.
        write(kept, to, "scene")
        for part in ("scene.journal", "session.pelog"):
            write(read(folder, part), to, part)
        write(json.dumps(expected, indent=1).encode() + b"\n", to,
              "expected.json")


def lacking(expected, found, path=""):
    """Where `found` has not what is expected; more may be there."""
    if isinstance(expected, dict) and isinstance(found, dict):
        return [place for key in expected for place in
                (lacking(expected[key], found[key], f"{path}.{key}")
                 if key in found else [f"{path}.{key} is gone"])]
    if isinstance(expected, list) and isinstance(found, list) \
            and len(expected) == len(found):
        return [place for i, pair in enumerate(zip(expected, found))
                for place in lacking(*pair, f"{path}.{i}")]
    return [] if expected == found else [f"{path}: {found}, not {expected}"]


class Upgrade(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="pelagos-upgrade-")
        self.addCleanup(shutil.rmtree, self.folder)
        self.state = os.path.join(self.folder, "scene")

    def bring(self, version):
        for part in ("scene", "scene.journal"):
            shutil.copy(os.path.join(GOLDEN, version, part), self.folder)
        return json.loads(read(GOLDEN, version, "expected.json"))

    def has(self, expected, found):
        self.assertEqual(lacking(expected, found), [])

    def test_what_was_there_is_there(self):
        for version in VERSIONS:
            with self.subTest(version):
                expected = self.bring(version)
                with Daemon("--state", self.state) as daemon:
                    self.has(expected, daemon.state())
                    log = daemon.log()
                for bad in ("SCN-002", "SCN-015"):
                    self.assertNotIn(bad, log)
                self.assertIn("SCN-016", log)  # the journal was needed
                rewritten = json.loads(read(self.state))
                self.assertEqual(rewritten.pop("stateVersion"), STATE_VERSION)
                self.has(expected, rewritten)
                self.assertEqual(sorted(os.listdir(self.folder)),
                                 ["scene", "scene.prev"])
                with Daemon("--state", self.state) as daemon:
                    self.has(expected, daemon.state())

    def test_a_log_leads_where_it_led(self):
        with Daemon() as daemon:
            for version in VERSIONS:
                with self.subTest(version):
                    expected = json.loads(
                        read(GOLDEN, version, "expected.json"))
                    subprocess.run(
                        [os.path.join(BIN, "pelagosctl"), "--server",
                         f"tcp:127.0.0.1:{daemon.tcp_port}", "replay",
                         "--quiet",
                         os.path.join(GOLDEN, version, "session.pelog")],
                        check=True, timeout=60)
                    del expected["revision"]
                    self.has(expected, daemon.state())

    def refused(self, words):
        before = {name: read(self.folder, name)
                  for name in os.listdir(self.folder)}
        with self.assertRaises(RuntimeError) as raised:
            Daemon("--state", self.state).stop()
        self.assertIn(words, str(raised.exception))
        self.assertEqual(before, {name: read(self.folder, name)
                                  for name in os.listdir(self.folder)})

    def test_a_newer_state_is_left_alone(self):
        self.bring(VERSIONS[-1])
        text = read(self.state)
        newer = text.replace(b'"stateVersion": %d' % STATE_VERSION,
                             b'"stateVersion": %d' % (STATE_VERSION + 1))
        self.assertNotEqual(newer, text)
        newer = with_checksum(newer)
        write(newer, self.state)
        self.refused(f"version {STATE_VERSION + 1}")

    def test_a_newer_journal_is_left_alone(self):
        self.bring(VERSIONS[-1])
        good = bytearray(read(self.state + ".journal"))
        form = bytearray(good)
        form[5] += 1
        form[12:16] = crc32c(form[:12])
        head = bytearray(good)
        at = head.index(b"\x08\x01", 48)  # LogHead.version
        end = 48 + int.from_bytes(head[40:44], "little")
        head[at + 1] = 3
        head[44:48] = crc32c(head[32:44] + head[48:end])
        for newer in (form, head):
            write(newer, self.state + ".journal")
            self.refused("version 3")

    def test_a_damaged_number_is_no_newer_version(self):
        """One flipped bit of what says the version keeps no daemon from
        starting, and loses nothing."""
        expected = self.bring(VERSIONS[-1])
        journal = self.state + ".journal"
        good = read(journal)
        write(good.replace(b"PELOG2", b"PELOG3", 1), journal)
        with Daemon("--state", self.state) as daemon:
            self.has(expected, daemon.state())
            self.assertIn("SCN-015", daemon.log())
        self.bring(VERSIONS[-1])
        text = read(self.state)
        write(text.replace(b'"stateVersion": 2', b'"stateVersion": 3'),
              self.state)
        with Daemon("--state", self.state) as daemon:
            self.has(expected, daemon.state())
            self.assertIn("SCN-002", daemon.log())

    def test_a_version_that_never_was(self):
        """Set aside, as every file that does not load."""
        for wrong in (b"0", b"1.5"):
            write(b'{"stateVersion": ' + wrong + b', "sea": {}}', self.state)
            with Daemon("--state", self.state) as daemon:
                self.assertIn("SCN-002", daemon.log())
        for wrong in (b"3", b"99999999999999999999"):
            write(b'{ "stateVersion" :' + wrong + b"}", self.state)
            self.refused("newer")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--write"]:
        make(sys.argv[2])
    else:
        unittest.main()
