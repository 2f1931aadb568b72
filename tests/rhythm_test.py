#!/usr/bin/python3
"""Rhythms of lights against timetables written by hand from the notation of
charts and the durations of docs/lights.md: at each of 30 frames a second over
120 s, every flash and eclipse of every character begins and ends in the frame
in which it shall, or beside it."""
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
BIN = pathlib.Path(os.environ.get("PELAGOS_BIN", ROOT / "build/release/bin"))
RATE, SECONDS = 30, 120

# What is seen, for how many seconds; "." nothing. The last until the period's
# end, which is their sum.
TIMETABLES = {
    "F": "W1",
    "F Y": "Y1",
    "Fl 5s": "W0.5 .4.5",
    "Fl R 4s": "R0.4 .3.6",
    "Fl Y 2.5s": "Y0.3 .2.2",
    "Fl 30s": "W1 .29",
    "Fl.G.3s": "G0.3 .2.7",
    "LFl 10s": "W2 .8",
    "LFl R 6s": "R2 .4",
    "Iso W 4s": "W2 .2",
    "Iso G 5s": "G2.5 .2.5",
    "Oc 6s": ".2 W4",
    "Oc G 6s": ".2 G4",
    "Oc(2) 8s": ".0.66667 W1.33333 .0.66667 W5.33333",
    "Fl(2) 5s": "W0.41667 .0.83333 W0.41667 .3.33333",
    "Fl(2) R 10s": "R0.66667 .1.33333 R0.66667 .7.33333",
    "Fl(3) 10s": "W0.66667 .1.33333 W0.66667 .1.33333 W0.66667 .5.33333",
    "Fl(4) Y 15s": "Y0.66667 .1.33333 Y0.66667 .1.33333 Y0.66667 .1.33333 "
                   "Y0.66667 .8.33333",
    "Fl(2+1) R 14s": "R0.66667 .1.33333 R0.66667 .3.33333 R0.66667 .7.33333",
    "Fl(2+1) G 10.5s": "G0.5 .1 G0.5 .2.5 G0.5 .5.5",
    "Q": "W0.4 .0.6",
    "Q G": "G0.4 .0.6",
    "VQ": "W0.2 .0.3",
    "UQ": "W0.1 .0.15",
    "Q(3) 10s": "W0.4 .0.6 W0.4 .0.6 W0.4 .7.6",
    "VQ(3) 5s": "W0.2 .0.3 W0.2 .0.3 W0.2 .3.8",
    "Q(6)+LFl 15s": "W0.4 .0.6 " * 6 + "W2 .7",
    "VQ(6)+LFl 10s": "W0.2 .0.3 " * 6 + "W2 .5",
    "Q(9) 15s": "W0.4 .0.6 " * 8 + "W0.4 .6.6",
    "VQ(9) 10s": "W0.2 .0.3 " * 8 + "W0.2 .5.8",
    "IQ 10s": "W0.4 .0.6 " * 6 + "W0.4 .3.6",
    "IVQ 7s": "W0.2 .0.3 " * 7 + "W0.2 .3.3",
    "Mo(A) 8s": "W0.5 .0.5 W1.5 .5.5",
    "Mo(U) W 15s": "W0.5 .0.5 W0.5 .0.5 W1.5 .11.5",
    "Mo(D) R 4s": "R1 .0.33333 R0.33333 .0.33333 R0.33333 .1.66667",
    "Al.WR 6s": "W3 R3",
    "Al WRG 9s": "W3 R3 G3",
    "Al.Fl WR 10s": "W0.5 .4.5 R0.5 .4.5",
    "Al.LFl WG 20s": "W2 .8 G2 .8",
    "Al.Fl(2) WR 10s": "W0.66667 .1.33333 R0.66667 .7.33333",
    "Al.Oc BuY 3s": ".0.5 B1 .0.5 Y1",
    "Al.Iso RG 8s": "R2 .2 G2 .2",
    "Al.Q RW": "R0.4 .0.6 W0.4 .0.6",
}


def spans(timetable):
    return [(s[0], float(s[1:])) for s in timetable.split()]


def at(table, seconds):
    period = sum(length for _, length in table)
    # 1e-5: the tables are rounded there.
    left = (seconds + 1e-4) % period
    for what, length in table:
        if left < length:
            return what
        left -= length
    return table[-1][0]


def check(name, seen):
    table = spans(TIMETABLES[name])
    changes = 0
    for k in range(RATE * SECONDS):
        near = {at(table, (k + d) / RATE) for d in (-1, 0, 1)}
        if seen[k] not in near:
            return f"{name}: {seen[k]} at {k / RATE:.3f} s, not {near}"
        changes += k > 0 and seen[k] != seen[k - 1]
    period = sum(length for _, length in table)
    kinds = [what for what, _ in table]
    each = sum(a != b for a, b in zip(kinds, kinds[1:] + kinds[:1]))
    expected = each * SECONDS / period
    if abs(changes - expected) > each:
        return f"{name}: {changes} changes, not {expected:.1f}"
    return None


def main():
    names = list(TIMETABLES)
    lines = subprocess.run(
        [BIN / "rhythm", str(RATE * SECONDS), str(RATE), *names], check=True,
        stdout=subprocess.PIPE, text=True).stdout.splitlines()
    wrong = [w for w in map(check, names, lines) if w]
    print("\n".join(wrong) or f"{len(names)} characters, {SECONDS} s each")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
