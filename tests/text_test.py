#!/usr/bin/python3
"""Texts of hostile clients and files where they are shown again: in answers,
in the log, in a terminal. No control characters, and valid UTF-8."""
import os
import random
import re
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import BIN, SLOW_S, Daemon, Session, schema, varint

HOSTILE = (b"\x1b[31mred\x1b]0;title\a", b"\xff\xfe\x80", b"\xe2\x82",
           b"\xc2\x9b31m", b"two\nerror NET-999 forged\r\n", b"\x7f\x08\x08",
           b"a" * 63 + "\u20ac".encode(), b"a" * 200, b"\xed\xa0\x80", b"")
CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f]")


def field(number, data):
    return varint(number << 3 | 2) + varint(len(data)) + data


class Texts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon("--log-level", "debug")

    @classmethod
    def tearDownClass(cls):
        status = cls.daemon.stop()
        assert status == 0, f"the daemon ended with {status}"

    def raw_reply(self, message):
        """The bytes of the Reply to the bytes of a Request."""
        with Session(self.daemon.connect_tcp()) as session:
            session.socket.sendall(varint(len(message)) + message)
            data = session.socket.recv(65536)
        return data

    def clean(self, data):
        text = data.decode()  # or UnicodeDecodeError
        self.assertIsNone(CONTROL.search(text), repr(text))

    def texts_of(self, data):
        """Every text of the Error in a Reply, as bytes."""
        def strings(data):
            at = 0
            while at < len(data):
                tag, kind = data[at] >> 3, data[at] & 7
                at += 1
                if kind == 2:
                    size = shift = 0
                    while True:
                        byte = data[at]
                        at += 1
                        size |= (byte & 127) << shift
                        shift += 7
                        if byte < 128:
                            break
                    yield tag, data[at:at + size]
                    at += size
                elif kind == 0:
                    while data[at] >= 128:
                        at += 1
                    at += 1
                else:
                    at += 8
        body = data[1 if data[0] < 128 else 2:]
        for _, error in strings(body):
            for _, text in strings(error):
                yield text

    def test_errors_over_protobuf(self):
        pb = schema()
        number = {(m, f.name): f.number
                  for m in ("Request", "Patch", "State", "View", "Entity",
                            "FrameRequest", "ModelsQuery", "Login")
                  if hasattr(pb, m)
                  for f in getattr(pb, m).DESCRIPTOR.fields}
        seen = 0
        for bad in HOSTILE:
            def patch(part):
                return field(number["Request", "patch"], part)

            def state(part):
                return patch(field(number["Patch", "state"], part))
            for message in (
                    state(field(number["State", "views"],
                                field(number["View", "name"], bad))),
                    state(field(number["State", "entities"],
                                field(number["Entity", "name"], bad))),
                    patch(field(number["Patch", "remove"], bad)),
                    patch(field(number["Patch", "remove"], b"views." + bad)),
                    field(number["Request", "frame"],
                          field(number["FrameRequest", "view"], bad))):
                reply = self.raw_reply(message)
                for text in self.texts_of(reply):
                    self.clean(text)
                    seen += 1
        self.assertGreater(seen, 50)

    def test_problems_over_http(self):
        for bad in HOSTILE:
            quoted = "".join(f"%{b:02x}" for b in bad)
            for path in (f"/v1/views/{quoted}/frame.jpg",
                         f"/v1/state/{quoted}", f"/v1/state?{quoted}=1"):
                answer = self.daemon.get(path)
                self.assertGreaterEqual(answer.status, 400)
                self.assertIsNone(CONTROL.search(
                    answer.body.decode().rstrip("\n")))

    def test_log(self):
        """A record is one line."""
        self.test_errors_over_protobuf()
        with Session(self.daemon.connect_tcp()) as session:
            session.socket.sendall(b"\x05\xff\xff\xff\x1b\n")
            session.receive()
        with open(self.daemon.log_path, "rb") as f:
            for line in f.read().split(b"\n"):
                self.clean(line)
                self.assertRegex(line, rb"^$|^(error|warning|info|debug) [A-Z]"
                                       rb"|^[^ ]*:")

    def ctl(self, *arguments):
        done = subprocess.run(
            [os.path.join(BIN, "pelagosctl"), "--server",
             f"tcp:127.0.0.1:{self.daemon.tcp_port}", *arguments],
            capture_output=True, timeout=SLOW_S)
        return done.stdout + done.stderr

    def test_replay_of_a_hostile_log(self):
        pb = schema()
        chance = random.Random(1)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "log.pelog")
            for bad in HOSTILE + (chance.randbytes(60),):
                state = pb.State()
                state.clock.mode = pb.STEPPED
                head = pb.LogHead(version=1, state=state, waves=20)
                made = head.SerializeToString()
                names = {f.name: f.number
                         for f in pb.LogHead.DESCRIPTOR.fields}
                for name in ("program", "device", "began"):
                    made += field(names[name], bad)
                entries = [
                    field(pb.LogEntry.DESCRIPTOR.fields_by_name["head"].number,
                          made),
                    field(pb.LogEntry.DESCRIPTOR.fields_by_name["patch"].number,
                          field(pb.Patch.DESCRIPTOR.fields_by_name[
                              "remove"].number, b"views." + bad))]
                time = pb.LogEntry(time=0).SerializeToString()
                with open(path, "wb") as f:
                    f.write(MAGIC)
                    for entry in entries:
                        entry = time + entry
                        f.write(varint(len(entry)) + entry)
                said = self.ctl("replay", path)
                self.clean(said)
            self.assertIn(b"recorded", said)


MAGIC = b"PELOG1\r\n"

if __name__ == "__main__":
    unittest.main(verbosity=2)
