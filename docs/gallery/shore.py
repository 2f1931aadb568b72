#!/usr/bin/python3
"""Writes a made-up bay for the gallery: shore.py FILE.asc DEPTH

A beach in a wide arc, sand bars before it and dunes behind, down to DEPTH
metres 300 m off; Esri grid about 52.6 N, 5.2 E.
"""
import math
import sys

COLUMNS, ROWS = 800, 700
CELL = 2.4e-5  # degrees: 1.6 m east, 2.7 m north
EAST_M, NORTH_M = 67760, 111250  # a degree there


def smooth(x):
    x = min(max(x, 0.0), 1.0)
    return x * x * (3 - 2 * x)


def height(east, north, depth):
    """Metres above the sea; the bay opens to the west, its water's edge lies
    70 m east of the middle."""
    edge = (70 - 0.0006 * north * north + 12 * math.sin(north / 61)
            + 4 * math.sin(north / 17 + 1))
    off = (edge - east) * 0.9  # metres off the beach
    if off < 0:
        dune = smooth((-off - 25) / 40) * (
            2.2 + 1.3 * math.sin(north / 23 + east / 41)
            + 0.8 * math.sin(north / 9 - east / 13))
        return min(-off * 0.045, 2.2) + dune + 9 * smooth((-off - 60) / 160)
    bars = 0.35 * math.sin(off / 9 + math.sin(north / 37)) * smooth(off / 30)
    return -depth * smooth(off / 320) ** 0.8 - 0.02 * off * math.exp(-off / 60) \
        + bars * (1 - smooth(off / 140))


def main():
    path, depth = sys.argv[1], float(sys.argv[2])
    west, south = 5.2 - COLUMNS / 2 * CELL, 52.6 - ROWS / 2 * CELL
    with open(path, "w", encoding="ascii") as out:
        out.write(f"ncols {COLUMNS}\nnrows {ROWS}\nxllcorner {west:.9f}\n"
                  f"yllcorner {south:.9f}\ncellsize {CELL}\n")
        for row in range(ROWS):
            north = (ROWS / 2 - row - 0.5) * CELL * NORTH_M
            out.write(" ".join(
                f"{height((c + 0.5 - COLUMNS / 2) * CELL * EAST_M, north, depth):.3f}"
                for c in range(COLUMNS)) + "\n")


if __name__ == "__main__":
    main()
