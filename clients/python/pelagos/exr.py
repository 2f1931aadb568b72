"""Reads OpenEXR: single-part scan-line files, uncompressed, ZIPS or ZIP, of
half, float and uint samples. That is what pelagosd writes, and a good part of
what others do. zlib and NumPy only. After "OpenEXR File Layout" (openexr.com).
"""
from __future__ import annotations

import os
import struct
import zlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from . import need
from .errors import BadPicture

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_MAGIC = 20000630
_LINES = {0: 1, 2: 1, 3: 16}  # of a chunk: NONE, ZIPS, ZIP
_TYPES = {0: ("<u4", 4), 1: ("<f2", 2), 2: ("<f4", 4)}
_MAX_PIXELS = 1 << 28
_MAX_CHANNELS = 256


@dataclass(frozen=True)
class Exr:
    """One EXR file.

    channels    name as in the file ("R", "depth.Z") to float32, (height,
                width); uint samples stay uint32
    attributes  name to int, float, str, tuple, or float32 (4, 4) for a
                matrix; what else the file has, as bytes
    """
    width: int
    height: int
    channels: "dict[str, NDArray[Any]]" = field(repr=False)
    attributes: dict[str, Any] = field(repr=False)

    @property
    def layers(self) -> "dict[str, NDArray[Any]]":
        """Layers as arrays: (height, width, n), or (height, width) for a
        layer of one channel. Channels are in the order R G B A, X Y Z,
        else by name. Without a layer's name "Z" is "depth", "Y" is left out
        beside "depth.Z" (it is the same once more, where depth is alone in a
        file), and all others are "radiance".

        Of pelagosd: radiance (680, 550, 440 nm) [W m-2 sr-1 nm-1]; depth:
        distance along the ray [m], sky infinite; normal: east, north, up,
        sky 0; position (float64): east, north, up of the origin [m], sky 0."""
        np = need.numpy()
        groups: dict[str, list[str]] = {}
        for name in self.channels:
            layer, _, last = name.rpartition(".")
            bare = "depth" if last == "Z" else "radiance"
            if name == "Y" and "depth.Z" in self.channels:
                continue  # depth once more, for readers who look for pictures
            groups.setdefault(layer or bare, []).append(name)
        order = "RGBAXYZ"
        out = {}
        for layer, names in groups.items():
            def rank(name: str) -> tuple[int, str]:
                last = name.rpartition(".")[2]
                return (order.find(last) if last in order else 99, last)
            names.sort(key=rank)
            planes = [self.channels[name] for name in names]
            out[layer] = planes[0] if len(planes) == 1 else np.stack(planes, -1)
        if "pelagos.positionEast" in self.attributes and "position" in out:
            place = out["position"].astype(np.float64)
            sea = place.any(axis=-1)
            place[sea, 0] += self.attributes["pelagos.positionEast"]
            place[sea, 1] += self.attributes["pelagos.positionNorth"]
            out["position"] = place
        return out

    def __getitem__(self, layer: str) -> "NDArray[Any]":
        """One layer; see `layers`."""
        layers = self.layers
        if layer not in layers:
            raise KeyError(f"no layer {layer!r} here, only "
                           + ", ".join(sorted(layers)))
        return layers[layer]


def read_exr(source: "bytes | str | os.PathLike[str]") -> Exr:
    """Reads the bytes of a file, or the file at a path. Raises BadPicture."""
    if isinstance(source, (bytes, bytearray, memoryview)):
        data = bytes(source)
    else:
        with open(source, "rb") as file:
            data = file.read()
    try:
        return _read(data)
    except (struct.error, IndexError, UnicodeDecodeError, zlib.error) as error:
        raise BadPicture(f"the EXR file is damaged: {error}") from None


def with_number(data: bytes, name: str, value: float) -> bytes:
    """The file with another value of a double attribute: for files that are
    to be equal to the bit although a counter ("pelagos.revision") is not."""
    head = name.encode() + b"\0double\0" + struct.pack("<i", 8)
    at = data.find(head)
    if at < 0:
        raise BadPicture(f"the EXR file has no double called {name}")
    at += len(head)
    return data[:at] + struct.pack("<d", value) + data[at + 8:]


class _Cursor:
    def __init__(self, data: bytes) -> None:
        self.data, self.at = data, 0

    def take(self, size: int) -> bytes:
        if size < 0 or self.at + size > len(self.data):
            raise BadPicture("the EXR file ends too early")
        self.at += size
        return self.data[self.at - size:self.at]

    def unpack(self, form: str) -> tuple[Any, ...]:
        return struct.unpack("<" + form,
                             self.take(struct.calcsize("<" + form)))

    def text(self) -> str:
        end = self.data.find(b"\0", self.at, self.at + 256)
        if end < 0:
            raise BadPicture("a name in the EXR file has no end")
        out = self.data[self.at:end].decode()
        self.at = end + 1
        return out


def _attribute(kind: str, raw: bytes) -> Any:
    forms = {"int": "i", "float": "f", "double": "d", "compression": "B",
             "lineOrder": "B", "v2i": "2i", "v2f": "2f", "v3f": "3f",
             "box2i": "4i", "box2f": "4f"}
    if kind == "string":
        return raw.decode(errors="replace")
    if kind in ("m33f", "m44f"):
        np = need.numpy()
        side = 3 if kind == "m33f" else 4
        return np.frombuffer(raw, "<f4", side * side).reshape(side, side)
    if kind in forms:
        values = struct.unpack("<" + forms[kind], raw)
        return values[0] if len(values) == 1 else values
    return raw


def _channel_list(raw: bytes) -> list[tuple[str, str, int]]:
    cursor = _Cursor(raw)
    out: list[tuple[str, str, int]] = []
    while name := cursor.text():
        kind, _, x, y = cursor.unpack("iIii")
        if kind not in _TYPES or (x, y) != (1, 1) or len(out) == _MAX_CHANNELS:
            raise BadPicture(f"channel {name} of this EXR file is of a form "
                             "that is not read here")
        out.append((name, *_TYPES[kind]))
    return out


def _header(cursor: _Cursor) -> tuple[list[tuple[str, str, int]],
                                      dict[str, Any]]:
    magic, version = cursor.unpack("ii")
    if magic != _MAGIC:
        raise BadPicture("this is no EXR file")
    if version & 0xFF != 2 or version & ~(0xFF | 0x400):
        raise BadPicture("only single-part scan-line EXR files are read here")
    channels, attributes = [], {}
    while name := cursor.text():
        kind = cursor.text()
        raw = cursor.take(cursor.unpack("i")[0])
        if kind == "chlist":
            channels = _channel_list(raw)
        else:
            attributes[name] = _attribute(kind, raw)
    window = attributes.get("dataWindow")
    if not channels or not isinstance(window, tuple) or len(window) != 4:
        raise BadPicture("the EXR file has no channels or no window")
    return channels, attributes


def _unzip(packed: bytes, size: int) -> bytes:
    """Undoes EXR's ZIP: deflate, differences, halves interleaved."""
    np = need.numpy()
    stream = zlib.decompressobj()
    plain = stream.decompress(packed, size + 1)
    if len(plain) != size:
        raise BadPicture("a chunk of the EXR file has the wrong length")
    values = np.frombuffer(plain, np.uint8).copy()
    values[1:] -= np.uint8(128)
    values = np.cumsum(values, dtype=np.uint8)
    out = np.empty(size, np.uint8)
    half = (size + 1) // 2
    out[0::2] = values[:half]
    out[1::2] = values[half:]
    return out.tobytes()


def _read(data: bytes) -> Exr:
    np = need.numpy()
    cursor = _Cursor(data)
    channels, attributes = _header(cursor)
    compression = attributes.get("compression", 0)
    if compression not in _LINES:
        raise BadPicture(f"EXR compression {compression} is not read here, "
                         "only NONE, ZIPS and ZIP")
    lines = _LINES[compression]
    left, top, right, bottom = attributes["dataWindow"]
    width, height = right - left + 1, bottom - top + 1
    if width < 1 or height < 1 or width * height > _MAX_PIXELS:
        raise BadPicture(f"an EXR picture of {width} x {height}")
    line_size = width * sum(size for _, _, size in channels)
    chunks = -(-height // lines)
    # Deflate packs at most 1032 to 1: no memory for what cannot be there.
    if height * line_size > 1100 * len(data):
        raise BadPicture("the EXR file ends too early")
    planes = {name: np.empty((height, width),
                             np.uint32 if form == "<u4" else np.float32)
              for name, form, _ in channels}
    seen = np.zeros(height, bool)
    for offset in cursor.unpack(f"{chunks}Q"):
        if offset > len(data):
            raise BadPicture("the EXR file ends too early")
        cursor.at = offset
        y, packed_size = cursor.unpack("ii")
        row = y - top
        if row < 0 or row >= height or row % lines:
            raise BadPicture("a chunk of the EXR file is out of place")
        count = min(lines, height - row)
        packed = cursor.take(packed_size)
        size = count * line_size
        # A chunk that would grow is stored as it is.
        plain = (packed if compression == 0 or packed_size >= size
                 else _unzip(packed, size))
        if len(plain) != size:
            raise BadPicture("a chunk of the EXR file has the wrong length")
        block = np.frombuffer(plain, np.uint8).reshape(count, line_size)
        at = 0
        for name, form, sample in channels:
            part = np.ascontiguousarray(block[:, at:at + width * sample])
            planes[name][row:row + count] = part.view(form)
            at += width * sample
        seen[row:row + count] = True
    if not seen.all():
        raise BadPicture("lines of the EXR file are missing")
    return Exr(width, height, planes, attributes)
