"""Writes Apache Parquet: columns of whole numbers, floats and text, which may
be absent; plain encoding, not compressed. Debian 12 has no library that does;
every reader of Parquet knows this form. After "Apache Parquet Format" 2.10
(parquet.thrift) and the compact protocol of Apache Thrift."""
from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from typing import Any, BinaryIO

_MAGIC = b"PAR1"
# Type, and the converted type of text.
_KINDS = {"int": (2, None), "float": (5, None), "str": (6, 0)}
_OPTIONAL = 1
_PLAIN, _RLE = 0, 3
_ROWS = 100_000
# Thrift's types in the compact protocol.
_I32, _I64, _BINARY, _LIST, _STRUCT = 5, 6, 8, 9, 12


def _varint(n: int) -> bytes:
    out = bytearray()
    while n > 0x7F:
        out.append(n & 0x7F | 0x80)
        n >>= 7
    out.append(n)
    return bytes(out)


def _zigzag(n: int) -> bytes:
    return _varint((n << 1) ^ (n >> 63))


def _struct(*fields: tuple[int, int, Any]) -> bytes:
    """(number, type, value); None: left out. A list is (type, [values])."""
    out, last = b"", 0
    for number, kind, value in fields:
        if value is None:
            continue
        out += bytes([(number - last) << 4 | kind]) + _value(kind, value)
        last = number
    return out + b"\0"


def _value(kind: int, value: Any) -> bytes:
    if kind in (_I32, _I64):
        return _zigzag(value)
    if kind == _BINARY:
        return _varint(len(value)) + bytes(value)
    if kind == _LIST:
        inner, values = value
        head = (bytes([len(values) << 4 | inner]) if len(values) < 15 else
                bytes([0xF0 | inner]) + _varint(len(values)))
        return head + b"".join(_value(inner, v) for v in values)
    return bytes(value)  # a structure, as _struct made it


def _levels(values: Sequence[Any]) -> bytes:
    """Which values are there: runs of definition levels of one bit."""
    out, i = b"", 0
    while i < len(values):
        there, begin = values[i] is not None, i
        while i < len(values) and (values[i] is not None) == there:
            i += 1
        out += _varint((i - begin) << 1) + bytes([there])
    return struct.pack("<I", len(out)) + out


def _plain(kind: str, values: Iterable[Any]) -> bytes:
    there = [v for v in values if v is not None]
    if kind == "int":
        return struct.pack(f"<{len(there)}q", *there)
    if kind == "float":
        return struct.pack(f"<{len(there)}d", *there)
    texts = [str(v).encode() for v in there]
    return b"".join(struct.pack("<I", len(t)) + t for t in texts)


class Table:
    """columns: name to "int" (64 bits), "float" (64 bits) or "str"."""

    def __init__(self, file: BinaryIO, columns: dict[str, str],
                 made_by: str, about: dict[str, str]) -> None:
        self.file, self.columns = file, columns
        self.made_by, self.about = made_by, about
        self.rows: list[dict[str, Any]] = []
        self.groups: list[bytes] = []
        self.count = 0
        self.at = len(_MAGIC)
        file.write(_MAGIC)

    def add(self, row: dict[str, Any]) -> None:
        """Of each column its value; None or missing: absent."""
        self.rows.append(row)
        if len(self.rows) == _ROWS:
            self._flush()

    def _flush(self) -> None:
        if not self.rows:
            return
        chunks, total = [], 0
        for name, kind in self.columns.items():
            values = [row.get(name) for row in self.rows]
            body = _levels(values) + _plain(kind, values)
            header = _struct(
                (1, _I32, 0), (2, _I32, len(body)), (3, _I32, len(body)),
                (5, _STRUCT, _struct((1, _I32, len(values)), (2, _I32, _PLAIN),
                                     (3, _I32, _RLE), (4, _I32, _RLE))))
            size = len(header) + len(body)
            self.file.write(header + body)
            chunks.append(_struct(
                (2, _I64, self.at),
                (3, _STRUCT, _struct(
                    (1, _I32, _KINDS[kind][0]),
                    (2, _LIST, (_I32, [_PLAIN, _RLE])),
                    (3, _LIST, (_BINARY, [name.encode()])), (4, _I32, 0),
                    (5, _I64, len(values)), (6, _I64, size), (7, _I64, size),
                    (9, _I64, self.at)))))
            self.at += size
            total += size
        self.groups.append(_struct((1, _LIST, (_STRUCT, chunks)),
                                   (2, _I64, total),
                                   (3, _I64, len(self.rows))))
        self.count += len(self.rows)
        self.rows = []

    def close(self) -> None:
        """Writes what is left and the footer; the file stays open."""
        self._flush()
        schema = [_struct((4, _BINARY, b"schema"),
                          (5, _I32, len(self.columns)))]
        for name, kind in self.columns.items():
            number, converted = _KINDS[kind]
            schema.append(_struct((1, _I32, number), (3, _I32, _OPTIONAL),
                                  (4, _BINARY, name.encode()),
                                  (6, _I32, converted)))
        about = [_struct((1, _BINARY, k.encode()), (2, _BINARY, v.encode()))
                 for k, v in self.about.items()]
        footer = _struct(
            (1, _I32, 1), (2, _LIST, (_STRUCT, schema)), (3, _I64, self.count),
            (4, _LIST, (_STRUCT, self.groups)), (5, _LIST, (_STRUCT, about)),
            (6, _BINARY, self.made_by.encode()))
        self.file.write(footer + struct.pack("<I", len(footer)) + _MAGIC)
