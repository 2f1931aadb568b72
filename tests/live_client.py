"""A WebSocket client for tests: its own framing, standard library only.

    with Live(daemon, "bridge") as live:
        head, data = live.picture()
        live.ack(head)
"""
import base64
import json
import os
import re
import socket
import struct
import time

from pelagos_daemon import SLOW_S

HEADER = struct.Struct("<BBBBHHQdQQIIIIQQHH4x")
FIELDS = ("version kind flags size width height number time host stamp drawn "
          "encoded queued missed revision present drawn_width "
          "drawn_height").split()
KEY, GAP = 1, 2


class Closed(Exception):
    def __init__(self, code=None, reason=""):
        super().__init__(f"closed with {code} {reason}")
        self.code, self.reason = code, reason


class Refused(Exception):
    def __init__(self, status, head, body):
        super().__init__(f"{status}: {body[:200]}")
        self.status, self.head, self.body = status, head, body


class Head:
    """The header of a picture, by its fields."""

    def __init__(self, data):
        self.__dict__.update(zip(FIELDS, HEADER.unpack_from(data)))

    @property
    def key(self):
        return bool(self.flags & KEY)

    @property
    def gap(self):
        return bool(self.flags & GAP)


class Live:
    def __init__(self, daemon, view, query="", headers=(), timeout=SLOW_S,
                 buffer=None):
        self.opened = time.monotonic()
        self.socket = socket.socket()
        if buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
        self.socket.settimeout(timeout)
        self.socket.connect(("127.0.0.1", daemon.http_port))
        self.buffer = b""
        self.texts = []
        key = base64.b64encode(os.urandom(16)).decode()
        given = {"Host": f"127.0.0.1:{daemon.http_port}",
                 "Upgrade": "websocket", "Connection": "Upgrade",
                 "Sec-WebSocket-Key": key, "Sec-WebSocket-Version": "13"}
        given.update(headers)
        lines = "".join(f"{k}: {v}\r\n" for k, v in given.items()
                        if v is not None)
        self.socket.sendall(f"GET /v1/views/{view}/live{query} HTTP/1.1\r\n"
                            f"{lines}\r\n".encode())
        while b"\r\n\r\n" not in self.buffer:
            self.more()
        head, self.buffer = self.buffer.split(b"\r\n\r\n", 1)
        status = int(head.split()[1])
        if status != 101:
            told = re.search(rb"(?mi)^Content-Length: (\d+)", head)
            body = self.take(int(told[1]) if told else 0)
            self.socket.close()
            raise Refused(status, head.decode(), body.decode())
        self.head = head.decode()

    def more(self):
        data = self.socket.recv(1 << 18)
        if not data:
            raise Closed()
        self.buffer += data

    def take(self, count):
        while len(self.buffer) < count:
            self.more()
        data, self.buffer = self.buffer[:count], self.buffer[count:]
        return data

    def frame(self):
        """(opcode, payload) of the next frame; the server sends whole ones."""
        first, length = self.take(2)
        assert first & 0x80, "the server fragments"
        assert not length & 0x80, "the server masks"
        if length == 126:
            length, = struct.unpack(">H", self.take(2))
        elif length == 127:
            length, = struct.unpack(">Q", self.take(8))
        return first & 15, self.take(length)

    def message(self):
        """The next message: a dict for text, bytes for a picture."""
        while True:
            opcode, data = self.frame()
            if opcode == 9:
                self.send_frame(10, data)
            elif opcode == 8:
                raise Closed(struct.unpack(">H", data[:2])[0] if data else None,
                             data[2:].decode())
            elif opcode == 1:
                self.texts.append(json.loads(data))
                return self.texts[-1]
            elif opcode == 2:
                return data

    def picture(self):
        """(head, bytes) of the next picture; texts on the way are kept."""
        while True:
            message = self.message()
            if isinstance(message, bytes):
                head = Head(message)
                return head, message[head.size:]

    def text(self, kind):
        """The next text message of that type; pictures are acknowledged."""
        while True:
            message = self.message()
            if isinstance(message, bytes):
                self.ack(Head(message))
            elif message["type"] == kind:
                return message

    def send_frame(self, opcode, data, final=True, masked=True):
        mask = os.urandom(4)
        size = len(data)
        bit = 0x80 if masked else 0
        head = bytes([(0x80 if final else 0) | opcode])
        if size < 126:
            head += bytes([bit | size])
        elif size < 65536:
            head += bytes([bit | 126]) + struct.pack(">H", size)
        else:
            head += bytes([bit | 127]) + struct.pack(">Q", size)
        if masked:
            head += mask
            data = bytes(b ^ mask[i & 3] for i, b in enumerate(data))
        self.socket.sendall(head + data)

    def send(self, data):
        self.send_frame(2, data)

    def ack(self, head):
        self.send(struct.pack("<B7xQ", 1, head.number))

    def want_key(self):
        self.send(struct.pack("<B15x", 2))

    def profile(self, width=0, height=0, bitrate=0, quality=0):
        self.send(struct.pack("<BBHIHHI", 3, quality, 0, bitrate, width,
                              height, 0))

    def ask_time(self, echo):
        self.send(struct.pack("<B7xQ", 4, echo))

    def close(self):
        self.socket.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
