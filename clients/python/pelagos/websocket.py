"""Live views over WebSocket, as proto/live.md has it: RFC 6455's client side
and the header of a picture. Standard library only; one thread."""
from __future__ import annotations

import base64
import contextlib
import hashlib
import http.client
import json
import os
import socket
import struct
import urllib.parse
from collections.abc import Mapping
from typing import Any, NamedTuple

from .errors import PelagosError, ProtocolError, TimedOut, Unreachable, refusal
from .transport import Transport

_GUID = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
_TEXT, _BINARY, _CLOSE, _PING, _PONG = 1, 2, 8, 9, 10
_MAX_MESSAGE = 64 << 20
_HEADER = struct.Struct("<BBBBHHQdQQIIIIQ")
_PRESENT = struct.Struct("<Q")  # later versions add to the end
_KEY, _GAP, _STALE = 1, 2, 4
# The server pings every 10 s: longer silence is a connection that is gone.
_SILENCE_S = 30.0
H264, JPEG = 1, 2


class Head(NamedTuple):
    """Header of a picture; times in microseconds."""
    version: int
    kind: int
    flags: int
    size: int
    width: int
    height: int
    number: int
    time: float
    host: int
    stamp: int
    drawn: int
    encoded: int
    queued: int
    missed: int
    revision: int
    present: int = 0

    @property
    def key(self) -> bool:
        return bool(self.flags & _KEY)

    @property
    def gap(self) -> bool:
        return bool(self.flags & _GAP)

    @property
    def stale(self) -> bool:
        return bool(self.flags & _STALE)


class LiveSocket:
    """One viewer. options: of the query, as codec, quality, credit."""

    def __init__(self, transport: Transport, view: str,
                 options: Mapping[str, Any], timeout: float) -> None:
        self.view = view
        self._connection = transport.connect(timeout)
        self._socket: socket.socket = self._connection.sock
        self._file = self._socket.makefile("rb")
        query = urllib.parse.urlencode(
            {k: v for k, v in options.items() if v is not None})
        path = (f"/v1/views/{urllib.parse.quote(view, safe='')}/live"
                + ("?" + query if query else ""))
        try:
            self._shake_hands(transport, path)
            self._socket.settimeout(_SILENCE_S)
        except TimeoutError:
            self.close()
            raise TimedOut(f"no stream from {transport.url} within "
                           f"{timeout:g} s") from None
        except (OSError, http.client.HTTPException) as error:
            self.close()
            if isinstance(error, PelagosError):
                raise
            raise Unreachable(f"no stream from {transport.url}: "
                              f"{error}") from None
        except PelagosError:
            self.close()
            raise

    def _shake_hands(self, transport: Transport, path: str) -> None:
        key = base64.b64encode(os.urandom(16))
        transport.send(self._connection, "GET", path, None, {
            "Upgrade": "websocket", "Connection": "Upgrade",
            "Sec-WebSocket-Key": key.decode(), "Sec-WebSocket-Version": "13"})
        line = self._file.readline(8192).split(None, 2)
        if (len(line) < 2 or not line[0].startswith(b"HTTP/1.")
                or not line[1].isdigit()):
            raise ProtocolError(f"{transport.url} does not speak HTTP")
        headers = http.client.parse_headers(self._file)
        status = int(line[1])
        if status >= 400:
            length = headers.get("Content-Length", "0")
            size = int(length) if length.isdigit() else 0
            raise refusal(status, self._file.read(min(size, 65536)))
        accept = base64.b64encode(hashlib.sha1(key + _GUID).digest()).decode()
        if status != 101 or headers.get("Sec-WebSocket-Accept") != accept:
            raise ProtocolError(f"{transport.url} has no WebSocket")

    # --- reading ------------------------------------------------------------

    def read(self) -> tuple[Head, bytes]:
        """The next picture; waits for it."""
        while True:
            opcode, data = self._frame()
            if opcode == _BINARY:
                return self._picture(data)
            if opcode == _PING:
                self._send(_PONG, data)
            elif opcode == _CLOSE:
                raise Unreachable(f"the stream of {self.view} has ended")
            elif opcode == _TEXT:
                self._text(data)

    def _picture(self, data: bytes) -> tuple[Head, bytes]:
        if len(data) < _HEADER.size:
            raise ProtocolError("a picture without a header")
        head = Head(*_HEADER.unpack_from(data))
        if (head.version != 1 or head.kind not in (H264, JPEG)
                or not _HEADER.size <= head.size <= len(data)):
            raise ProtocolError("a picture with a header of another kind")
        if head.size >= _HEADER.size + _PRESENT.size:
            present, = _PRESENT.unpack_from(data, _HEADER.size)
            head = head._replace(present=present)
        return head, data[head.size:]

    def _text(self, data: bytes) -> None:
        try:
            said = json.loads(data)
        except ValueError:
            raise ProtocolError("a message that is no JSON") from None
        if isinstance(said, dict) and said.get("type") == "end":
            raise Unreachable(f"the stream of {self.view} has ended: "
                              f"{said.get('message', '')}")

    def _frame(self) -> tuple[int, bytes]:
        """(opcode, payload); the server sends whole frames."""
        first, size = self._take(2)
        if size == 126:
            size, = struct.unpack(">H", self._take(2))
        elif size == 127:
            size, = struct.unpack(">Q", self._take(8))
        elif size > 127:
            raise ProtocolError("a masked frame from the server")
        if first & 0xF0 != 0x80 or size > _MAX_MESSAGE:
            raise ProtocolError("a frame of a form that is not read here")
        return first & 15, self._take(size)

    def _take(self, size: int) -> bytes:
        try:
            data = self._file.read(size)
        except TimeoutError:
            raise TimedOut(f"{self.view} has been silent for "
                           f"{_SILENCE_S:g} s") from None
        except (OSError, ValueError) as error:
            raise Unreachable(f"the stream of {self.view} broke: "
                              f"{error}") from None
        if len(data) < size:
            raise Unreachable(f"the stream of {self.view} has ended")
        return data

    # --- writing ------------------------------------------------------------

    def acknowledge(self, number: int) -> None:
        """That picture and all before it are decoded."""
        self._send(_BINARY, struct.pack("<B7xQ", 1, number))

    def _send(self, opcode: int, data: bytes) -> None:
        mask = os.urandom(4)
        masked = bytes(b ^ mask[i & 3] for i, b in enumerate(data[:125]))
        try:
            self._socket.sendall(bytes([0x80 | opcode, 0x80 | len(masked)])
                                 + mask + masked)
        except OSError as error:
            raise Unreachable(f"the stream of {self.view} broke: "
                              f"{error}") from None

    def stop(self) -> None:
        """From any thread: a read in progress ends."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        self._file.close()
        self._connection.close()
