"""Live pictures: Motion-JPEG, of which only the newest is kept."""
from __future__ import annotations

import contextlib
import http.client
import socket
import threading
import time
import urllib.parse
from collections.abc import Iterator
from dataclasses import dataclass
from typing import IO

from .errors import PelagosError, ProtocolError, TimedOut, Unreachable, refusal
from .frame import Frame, from_answer
from .transport import Transport

_MAX_LINE = 8192
_MAX_LINES = 64
_MAX_PICTURE = 64 << 20


@dataclass(frozen=True)
class LiveFrame(Frame):
    """A frame of a stream. received: time.monotonic() when it was there [s];
    dropped: pictures passed over since the one before, because nobody took
    them in time."""
    received: float = 0.0
    dropped: int = 0


class LiveStream:
    """Iterates over the frames of one view, always the newest:

        with ocean.views["bridge"].live() as stream:
            for frame in stream:
                show(frame.image())

    A thread reads; it holds one picture, and a newer one takes its place, so
    a slow loop sees fewer pictures, never old ones. Ends (StopIteration) after
    close(); raises TimedOut when no picture comes within `timeout` seconds and
    Unreachable when the daemon goes away or the view is deleted."""

    def __init__(self, transport: Transport, view: str,
                 fps: float | None = None, quality: int | None = None,
                 timeout: float = 10.0) -> None:
        self.view = view
        self.timeout = timeout
        self.received = 0  # pictures that came
        self.dropped = 0   # of them never taken
        self._newest: LiveFrame | None = None
        self._over = False
        self._failure: PelagosError | None = None
        self._passed = 0
        self._changed = threading.Condition()
        asked = {name: value for name, value in
                 (("fps", fps), ("quality", quality)) if value is not None}
        path = (f"/v1/views/{urllib.parse.quote(view, safe='')}/mjpeg"
                + ("?" + urllib.parse.urlencode(asked) if asked else ""))
        self._connection = transport.connect(timeout)
        self._socket: socket.socket = self._connection.sock
        try:
            transport.send(self._connection, "GET", path)
            self._response = self._connection.getresponse()
            if self._response.status >= 400:
                raise refusal(self._response.status, self._response.read(65536))
        except (OSError, http.client.HTTPException) as error:
            self._connection.close()
            if isinstance(error, PelagosError):
                raise
            raise Unreachable(f"no stream from {transport.url}: "
                              f"{error}") from None
        except PelagosError:
            self._connection.close()
            raise
        self._thread = threading.Thread(target=self._read, daemon=True,
                                        name=f"pelagos-live-{view}")
        self._thread.start()

    def __iter__(self) -> Iterator[LiveFrame]:
        return self

    def __next__(self) -> LiveFrame:
        """The newest picture that was not taken yet; waits for one."""
        end = time.monotonic() + self.timeout
        with self._changed:
            while self._newest is None:
                if self._over:
                    raise StopIteration
                if self._failure is not None:
                    raise self._failure
                left = end - time.monotonic()
                if left <= 0:
                    raise TimedOut(f"no picture of {self.view} within "
                                   f"{self.timeout:g} s")
                self._changed.wait(left)
            frame, self._newest = self._newest, None
            return frame

    def close(self) -> None:
        """Ends the stream; also a loop that waits for it in another thread."""
        with self._changed:
            self._over = True
            self._newest = None
            self._changed.notify_all()
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._response.close()
        self._connection.close()

    def __enter__(self) -> LiveStream:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # --- the reading thread -------------------------------------------------

    def _read(self) -> None:
        failure: PelagosError
        try:
            while True:
                self._keep(self._part(self._response))
        except PelagosError as error:
            failure = error
        except TimeoutError:
            failure = TimedOut(f"no picture of {self.view} within "
                               f"{self.timeout:g} s")
        except (OSError, ValueError, http.client.HTTPException) as error:
            failure = Unreachable(f"the stream of {self.view} broke: {error}")
        with self._changed:
            self._failure = failure
            self._changed.notify_all()

    def _keep(self, frame: Frame) -> None:
        with self._changed:
            self.received += 1
            if self._newest is not None:
                self.dropped += 1
                self._passed += 1
            else:
                self._passed = 0
            self._newest = LiveFrame(**{**vars(frame),
                                        "received": time.monotonic(),
                                        "dropped": self._passed})
            self._changed.notify_all()

    def _part(self, stream: IO[bytes]) -> Frame:
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
