"""Live pictures: the newest one, or all of a video."""
from __future__ import annotations

import dataclasses
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass

from .errors import NotFound, PelagosError, TimedOut
from .frame import Frame
from .mjpeg import MjpegSocket
from .transport import Transport
from .websocket import JPEG, Head, LiveSocket


@dataclass(frozen=True)
class LiveFrame(Frame):
    """A frame of a stream.

    received  time.monotonic() when it was there [s]
    dropped   pictures passed over since the one before, because nobody took
              them in time
    stamp     when its state was taken, by the server's clock [s since 1970];
              0 over Motion-JPEG
    present   when all views of this frame are to be shown, by the same clock;
              0: not said
    key, gap  of video: it can be shown without those before it; pictures were
              left out just before it
    """
    received: float = 0.0
    dropped: int = 0
    stamp: float = 0.0
    present: float = 0.0
    key: bool = True
    gap: bool = False


def _frame(view: str, head: Head, data: bytes) -> LiveFrame:
    return LiveFrame(view, head.number, head.time, head.revision,
                     "jpg" if head.kind == JPEG else "h264", data,
                     head.drawn / 1e3, (head.encoded - head.drawn) / 1e3,
                     head.stale, head.host, time.monotonic(), 0,
                     head.stamp / 1e6, head.present / 1e6, head.key, head.gap)


class LiveStream:
    """Iterates over the frames of one view, always the newest:

        with ocean.views["bridge"].live() as stream:
            for frame in stream:
                show(frame.image())

    A thread reads; it holds one picture, and a newer one takes its place, so
    a slow loop sees fewer pictures, never old ones. Ends (StopIteration) after
    close(); raises TimedOut when no picture comes within `timeout` seconds and
    Unreachable when the daemon goes away or the view is deleted.

    protocol: "websocket", or "mjpeg" where a rate (fps) is asked for or the
    daemon has no WebSocket."""

    def __init__(self, transport: Transport, view: str,
                 fps: float | None = None, quality: int | None = None,
                 width: int | None = None, height: int | None = None,
                 timeout: float = 10.0) -> None:
        if fps is not None and (width or height):
            raise ValueError("a stream has fps, or width and height")
        self.view = view
        self.timeout = timeout
        self.received = 0  # pictures that came
        self.dropped = 0   # of them never taken
        self._newest: LiveFrame | None = None
        self._over = False
        self._failure: PelagosError | None = None
        self._passed = 0
        self._changed = threading.Condition()
        self._source: LiveSocket | MjpegSocket
        self.protocol = "websocket"
        try:
            if fps is not None:
                raise NotFound(404, {})
            self._source = LiveSocket(
                transport, view, {"codec": "jpeg", "quality": quality,
                                  "width": width, "height": height}, timeout)
        except NotFound as error:
            if error.path is not None or width or height:
                raise  # there is no such view, or no such stream of it
            self.protocol = "mjpeg"
            self._source = MjpegSocket(
                transport, view, {"fps": fps, "quality": quality}, timeout)
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
        self._source.stop()
        self._thread.join()
        self._source.close()

    def __enter__(self) -> LiveStream:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # --- the reading thread -------------------------------------------------

    def _next(self) -> LiveFrame:
        if isinstance(self._source, MjpegSocket):
            return LiveFrame(**vars(self._source.read()),
                             received=time.monotonic())
        head, data = self._source.read()
        # At once, not when it is taken: only so the newest is at hand.
        self._source.acknowledge(head.number)
        return _frame(self.view, head, data)

    def _read(self) -> None:
        try:
            while True:
                self._keep(self._next())
        except PelagosError as error:
            with self._changed:
                self._failure = error
                self._changed.notify_all()

    def _keep(self, frame: LiveFrame) -> None:
        with self._changed:
            self.received += 1
            if self._newest is not None:
                self.dropped += 1
                self._passed += 1
            else:
                self._passed = 0
            self._newest = dataclasses.replace(frame, dropped=self._passed)
            self._changed.notify_all()


class VideoStream:
    """Iterates over H.264 access units (Annex B), in order, the first a key:

        with ocean.views["bridge"].video() as video:
            for packet in video:
                file.write(packet.data)

    Each is acknowledged when the next is asked for. A loop that falls behind
    loses pictures at the daemon and goes on with a key, its `gap` set: what
    comes can always be decoded."""

    def __init__(self, transport: Transport, view: str,
                 bitrate: int | None = None, width: int | None = None,
                 height: int | None = None, timeout: float = 10.0) -> None:
        self.view = view
        self._last: int | None = None
        self._over = False
        self._source = LiveSocket(
            transport, view, {"codec": "h264", "bitrate": bitrate,
                              "width": width, "height": height}, timeout)

    def __iter__(self) -> Iterator[LiveFrame]:
        return self

    def __next__(self) -> LiveFrame:
        """The next access unit; waits for it."""
        if self._over:
            raise StopIteration
        try:
            if self._last is not None:
                self._source.acknowledge(self._last)
            head, data = self._source.read()
        except PelagosError:
            if self._over:
                raise StopIteration from None
            raise
        self._last = head.number
        return _frame(self.view, head, data)

    def close(self) -> None:
        """Ends it; also a loop that waits in another thread."""
        self._over = True
        self._source.stop()
        self._source.close()

    def __enter__(self) -> VideoStream:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
