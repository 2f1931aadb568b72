"""Motion-JPEG over HTTP. One thread."""
from __future__ import annotations

import contextlib
import http.client
import socket
import urllib.parse
from collections.abc import Mapping
from typing import Any

from .errors import PelagosError, ProtocolError, TimedOut, Unreachable, refusal
from .frame import Frame, from_answer
from .transport import Transport

_MAX_LINE = 8192
_MAX_LINES = 64
_MAX_PICTURE = 64 << 20


class MjpegSocket:
    """One viewer. options: of the query, fps and quality."""

    def __init__(self, transport: Transport, view: str,
                 options: Mapping[str, Any], timeout: float) -> None:
        self.view = view
        query = urllib.parse.urlencode(
            {k: v for k, v in options.items() if v is not None})
        path = (f"/v1/views/{urllib.parse.quote(view, safe='')}/mjpeg"
                + ("?" + query if query else ""))
        self._connection = transport.connect(timeout)
        self._socket: socket.socket = self._connection.sock
        try:
            transport.send(self._connection, "GET", path)
            self._response = self._connection.getresponse()
            if self._response.status >= 400:
                raise refusal(self._response.status,
                              self._response.read(65536))
            # A clock that stands sends nothing: silence is no failure.
            self._socket.settimeout(None)
        except TimeoutError:
            self._connection.close()
            raise TimedOut(f"no stream from {transport.url} within "
                           f"{timeout:g} s") from None
        except (OSError, http.client.HTTPException) as error:
            self._connection.close()
            raise Unreachable(f"no stream from {transport.url}: "
                              f"{error}") from None
        except PelagosError:
            self._connection.close()
            raise

    def read(self) -> Frame:
        """The next picture; waits for it."""
        try:
            return self._part()
        except (OSError, ValueError, http.client.HTTPException) as error:
            if isinstance(error, PelagosError):
                raise
            raise Unreachable(f"the stream of {self.view} broke: "
                              f"{error}") from None

    def _part(self) -> Frame:
        stream = self._response
        headers: dict[str, str] = {}
        for _ in range(_MAX_LINES):
            line = stream.readline(_MAX_LINE)
            if not line:
                raise Unreachable(f"the stream of {self.view} has ended")
            if line == b"\r\n" and "Content-Length" in headers:
                break
            name, colon, value = line.decode("latin-1").partition(":")
            if colon:
                headers[name.strip()] = value.strip()
        else:
            raise ProtocolError("no Motion-JPEG comes")
        size = int(headers["Content-Length"])
        if not 0 < size <= _MAX_PICTURE:
            raise ProtocolError(f"a picture of {size} bytes")
        data = bytearray()
        while len(data) < size:
            chunk = stream.read(size - len(data))
            if not chunk:
                raise Unreachable(f"the stream of {self.view} has ended")
            data += chunk
        return from_answer(self.view, "jpg", headers, bytes(data))

    def stop(self) -> None:
        """From any thread: a read in progress ends."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        self._response.close()
        self._connection.close()
