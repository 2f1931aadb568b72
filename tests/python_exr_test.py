#!/usr/bin/python3
"""The Python client's own reader of EXR files: all types, damaged files."""
import contextlib
import os
import pathlib
import struct
import sys
import unittest
import zlib

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import ROOT

sys.path.insert(0, str(pathlib.Path(ROOT) / "clients/python"))
sys.dont_write_bytecode = True
import pelagos
from pelagos.exr import with_number


def exr_file(channels, lines, compression, width, pixels, attributes=b""):
    """channels: [(name, type)]; pixels: bytes of each chunk."""
    chlist = b"".join(n.encode() + b"\0" + struct.pack("<iIii", t, 0, 1, 1)
                      for n, t in channels) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, lines - 1)

    def attribute(name, kind, data):
        return (name + b"\0" + kind + b"\0" + struct.pack("<i", len(data))
                + data)
    head = (struct.pack("<ii", 20000630, 2)
            + attribute(b"channels", b"chlist", chlist)
            + attribute(b"compression", b"compression", bytes([compression]))
            + attribute(b"dataWindow", b"box2i", window) + attributes + b"\0")
    step = {0: 1, 2: 1, 3: 16}[compression]
    at = len(head) + 8 * len(pixels)
    table, body = b"", b""
    for i, chunk in enumerate(pixels):
        table += struct.pack("<Q", at + len(body))
        body += struct.pack("<ii", i * step, len(chunk)) + chunk
    return head + table + body


class ExrReader(unittest.TestCase):
    def test_uncompressed_and_all_types(self):
        rows = [b"".join(np.asarray(v, t).tobytes() for v, t in (
            ([y, 2 * y], "<f2"), ([y + .5, 1e30], "<f4"), ([y, 1 << 31],
                                                            "<u4")))
            for y in range(3)]
        exr = pelagos.read_exr(exr_file(
            [("A.x", 1), ("A.y", 2), ("id", 0)], 3, 0, 2, rows))
        np.testing.assert_array_equal(exr.channels["A.x"],
                                      [[0, 0], [1, 2], [2, 4]])
        self.assertEqual(exr.channels["A.y"][2, 1], np.float32(1e30))
        self.assertEqual(exr.channels["id"][0, 1], 1 << 31)
        self.assertEqual(exr.layers["A"].shape, (3, 2, 2))

    def test_names_of_depth(self):
        row = [np.asarray([1, 2], "<f4").tobytes()]
        for names in (["depth.Z"], ["Z"], ["Y", "depth.Z"]):
            exr = pelagos.read_exr(exr_file([(n, 2) for n in names], 1, 0, 2,
                                            [row[0] * len(names)]))
            self.assertEqual(list(exr.layers), ["depth"], names)
            np.testing.assert_array_equal(exr["depth"], [[1, 2]])
        exr = pelagos.read_exr(exr_file([("Y", 2)], 1, 0, 2, row))
        self.assertEqual(list(exr.layers), ["radiance"])

    def test_damage_is_refused(self):
        whole = exr_file([("R", 1)], 2, 0, 2, [b"\0" * 4] * 2)
        pelagos.read_exr(whole)
        packed = zlib.compress(b"\0" * 1000)
        cases = [
            b"", b"no picture", whole[:-1], whole[:20],
            whole.replace(b"dataWindow", b"dataWindos"),
            exr_file([("R", 1)], 2, 0, 2, [b"\0" * 3, b"\0" * 4]),
            exr_file([("R", 1)], 16, 3, 2, [b"not deflate"]),
            exr_file([("R", 1)], 16, 3, 2, [packed]),
            exr_file([("R", 1)], 1 << 20, 3, 1 << 8, []),
            exr_file([("R", 1)], 16, 3, 1 << 30, [b""]),
            exr_file([], 1, 0, 1, [b""]),
        ]
        for data in cases:
            with self.assertRaises(pelagos.BadPicture, msg=data[:40]):
                pelagos.read_exr(data)
        for at in range(0, len(whole)):  # no other exception, whatever comes
            for value in (0, 0x7f, 0xff):
                with contextlib.suppress(pelagos.BadPicture):
                    pelagos.read_exr(whole[:at] + bytes([value])
                                     + whole[at + 1:])

    def test_with_number(self):
        data = exr_file([("R", 1)], 1, 0, 1, [b"\0\0"],
                        b"n\0double\0" + struct.pack("<id", 8, 4.0))
        self.assertEqual(pelagos.read_exr(data).attributes["n"], 4.0)
        data = with_number(data, "n", 7)
        self.assertEqual(pelagos.read_exr(data).attributes["n"], 7.0)
        with self.assertRaises(pelagos.BadPicture):
            with_number(data, "m", 7)


if __name__ == "__main__":
    unittest.main(verbosity=2)
