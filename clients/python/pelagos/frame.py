"""One picture of a view, as it came and as arrays."""
from __future__ import annotations

import io
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from . import need
from .errors import BadPicture, MissingPackage, ProtocolError
from .exr import Exr, read_exr
from .schema import LINEAR_FORMATS
from .transport import Answer

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Frame:
    """An encoded picture with what the daemon says of it.

    view       name of the view
    number     counts frames since the daemon's start; the views of one frame
               share it
    time       simulated time [s] (nine digits)
    revision   of the state it shows
    format     one of `pelagos.FORMATS`
    data       the file's bytes
    render_ms, encode_ms   how long it took [ms]
    stale      an input of `sources` was silent when it was drawn
    host       frame number of the simulator host that it shows, 0: none
    """
    view: str
    number: int
    time: float
    revision: int
    format: str
    data: bytes = field(repr=False)
    render_ms: float = 0.0
    encode_ms: float = 0.0
    stale: bool = False
    host: int = 0

    @property
    def host_frame(self) -> int:
        """`host` by the schema's name."""
        return self.host

    def image(self) -> "NDArray[np.uint8]":
        """RGB, uint8, (height, width, 3), top row first. Of formats with 8
        bits; needs OpenCV or Pillow."""
        if self.format == "json":
            raise BadPicture("a frame of json has no pixels: use .truth()")
        if self.format in LINEAR_FORMATS:
            raise BadPicture(f"a frame of {self.format} has floats: use .exr()")
        return decode(self.data)

    def exr(self) -> Exr:
        """The layers of an EXR frame as float32 arrays."""
        if self.format != "exr":
            raise BadPicture(f"a {self.format} frame has no layers; ask for "
                             "format='exr'")
        return read_exr(self.data)

    def truth(self) -> "dict[str, Any]":
        """What a json frame says of entities: FrameTruth of the schema."""
        if self.format != "json":
            raise BadPicture(f"a {self.format} frame has no truth; ask for "
                             "format='json'")
        truth: dict[str, Any] = json.loads(self.data)
        return truth

    def save(self, path: "str | os.PathLike[str]") -> None:
        """Writes the file as it came."""
        with open(path, "wb") as file:
            file.write(self.data)


def from_answer(view: str, form: str, headers: Mapping[str, str],
                data: bytes) -> Frame:
    return Frame(view, int(headers.get("X-Pelagos-Frame", 0)),
                 float(headers.get("X-Pelagos-Time", 0)),
                 int(headers.get("X-Pelagos-Revision", 0)), form, data,
                 float(headers.get("X-Pelagos-Render-Ms", 0)),
                 float(headers.get("X-Pelagos-Encode-Ms", 0)),
                 headers.get("X-Pelagos-Stale", "none") != "none",
                 int(headers.get("X-Pelagos-Host-Frame", 0)))


def parts_of(answer: Answer) -> Iterator[tuple[dict[str, str], bytes]]:
    """Headers and bytes of the parts of multipart/mixed; each says its size."""
    kind, _, boundary = answer.headers.get("Content-Type", "").partition(
        "boundary=")
    if not kind.startswith("multipart/mixed") or not boundary:
        raise ProtocolError("the answer is not several pictures")
    mark, body, at = b"--" + boundary.encode(), answer.body, 0
    while not body.startswith(mark + b"--", at):
        end = body.find(b"\r\n\r\n", at)
        if end < 0 or not body.startswith(mark + b"\r\n", at):
            raise ProtocolError("a part of the answer is damaged")
        lines = body[at:end].decode("latin-1").split("\r\n")[1:]
        headers = {name: value for name, _, value in (
            line.partition(": ") for line in lines)}
        size = int(headers.get("Content-Length", -1))
        start = end + 4
        if size < 0 or body[start + size:start + size + 2] != b"\r\n":
            raise ProtocolError("a part of the answer has no end")
        yield headers, body[start:start + size]
        at = start + size + 2


def decode(data: bytes) -> "NDArray[np.uint8]":
    """The bytes of a JPEG or PNG file as RGB, uint8, (height, width, 3)."""
    np = need.numpy()
    try:
        import cv2
    except ImportError:
        return _decode_with_pillow(data)
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        raise BadPicture("the picture is damaged")
    return np.ascontiguousarray(image[:, :, ::-1])


def _decode_with_pillow(data: bytes) -> "NDArray[np.uint8]":
    np = need.numpy()
    try:
        from PIL import Image, UnidentifiedImageError
    except ImportError:
        raise MissingPackage(
            "8-bit pictures as arrays need Pillow or OpenCV: apt install "
            "python3-pil, or pip install Pillow (Frame.data is the file "
            "itself, without any)") from None
    try:
        with Image.open(io.BytesIO(data)) as picture:
            return np.asarray(picture.convert("RGB"))
    except (UnidentifiedImageError, OSError, SyntaxError) as error:
        raise BadPicture(f"the picture is damaged: {error}") from None
