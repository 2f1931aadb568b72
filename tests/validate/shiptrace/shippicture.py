"""Pictures side by side as PNG."""
import struct
import zlib

import numpy as np

# Linear Rec. 709 of radiances at 680, 550 and 440 nm, for looking only.
LIGHT = np.array([1.0, 1.0, 0.85])
GAP = 4


def shown(image, scale):
    value = np.clip(image * LIGHT * scale, 0, 1)
    return (255 * value ** (1 / 2.2) + 0.5).astype(np.uint8)


def chunk(kind, data):
    return (struct.pack(">I", len(data)) + kind + data
            + struct.pack(">I", zlib.crc32(kind + data)))


def write(path, pixels):
    high, wide, _ = pixels.shape
    rows = b"".join(b"\0" + line.tobytes() for line in pixels)
    with open(path, "wb") as f:
        f.write(b"\x89PNG\r\n\x1a\n"
                + chunk(b"IHDR", struct.pack(">IIBBBBB", wide, high, 8, 2, 0,
                                             0, 0))
                + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def save(path, found):
    """A line for each wind and Sun: a sea of ours, the mean of ours, the
    reference's."""
    lines = []
    for pictures in found.values():
        scale = 0.6 / np.percentile(pictures["reference"].mean(-1), 97)
        columns = []
        for name in ("one", "ours", "reference"):
            image = shown(pictures[name], scale)
            gap = np.full((image.shape[0], GAP, 3), 255, np.uint8)
            columns += [image, gap]
        line = np.concatenate(columns[:-1], 1)
        lines += [line, np.full((GAP, line.shape[1], 3), 255, np.uint8)]
    write(path, np.concatenate(lines[:-1], 0))
