#!/usr/bin/python3
"""Makes the table of sky radiances that the sky is compared with (airtrace.c).

    airtable.py [--paths N] [--most N] [--error SHARE] [--jobs N] [--out FILE]
                [--visibility KM…] [--mend SHARE]

200 directions (20 zenith angles, 10 azimuths from the Sun's) at 680, 550 and
440 nm, 15 Suns, five visibilities; the sea below. The table that is committed,
table.json, is of `make airtable` (about an hour of two cores): radiances in
W m-2 sr-1 nm-1 with four digits, and their standard errors in 1/10,000 of
them. A visibility that is done is written at once. --mend takes the table as
it is and traces again, Sun by Sun, the sights of which a row is known worse
than SHARE; a row whose new error is smaller replaces the old one.
"""
import argparse
import json
import os
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(HERE)))
PROGRAM = os.path.join(os.environ.get(
    "PELAGOS_BIN", os.path.join(ROOT, "build", "release", "bin")), "airtrace")
ZENITHS = (5, 15, 25, 30, 40, 50, 55, 60, 65, 70,
           75, 78, 80, 82, 84, 86, 87.5, 88.5, 89.2, 89.7)
AZIMUTHS = (0, 10, 25, 45, 70, 90, 110, 135, 160, 180)
SUNS = (0, 20, 40, 50, 60, 70, 75, 80, 85, 88, 90, 91.5, 93, 94, 95)
VISIBILITIES = (40, 300, 5, 100, 15)  # km
CHANNELS = ("680", "550", "440")
HEIGHT_M = 2


def directions(zeniths=ZENITHS, azimuths=AZIMUTHS):
    return [(zenith, azimuth) for zenith in zeniths for azimuth in azimuths]


def trace(visibility, suns, sights, *options):
    """{(sight's number, Sun): [(radiance, error, of the first order) x 3]}"""
    command = [PROGRAM, "--visibility", visibility, "--height", HEIGHT_M,
               "--suns", ",".join(f"{sun:g}" for sun in suns), *options]
    text = "".join(f"{zenith} {azimuth}\n" for zenith, azimuth in sights)
    done = subprocess.run([str(word) for word in command], input=text,
                          stdout=subprocess.PIPE, text=True, check=True)
    found = {}
    for line in done.stdout.splitlines():
        sight, sun, _, *values = line.split()
        found.setdefault((int(sight), suns[int(sun)]), []).append(
            tuple(float(value) for value in values))
    return found


def table_of(visibility, found, sights):
    """{Sun: {channel: {"radiance": [...], "error": [...]}}}"""
    table = {}
    for sun in SUNS:
        part = table[f"{sun:g}"] = {}
        for c, channel in enumerate(CHANNELS):
            values = [found[i, sun][c] for i in range(len(sights))]
            part[channel] = {
                "radiance": [float(f"{value[0]:.4g}") for value in values],
                "error": [round(1e4 * value[1] / value[0])
                          for value in values]}
    return table


def write(table, path):
    with open(path, "w", encoding="utf-8") as f:
        f.write(json.dumps(table, separators=(",", ":")).replace(
            '"4', '\n"4').replace('"5', '\n"5').replace('"6', '\n"6')
            + "\n")


def mend(options):
    """Rows known worse than options.mend, anew, the worst Suns first."""
    with open(options.out, encoding="utf-8") as f:
        table = json.load(f)
    sights = directions()
    noisy = {}
    for visibility in options.visibility:
        for sun in SUNS:
            part = table["visibility"][f"{visibility:g}"][f"{sun:g}"]
            some = [i for i in range(len(sights)) if max(
                part[c]["error"][i] for c in CHANNELS) > 1e4 * options.mend]
            if some:
                noisy[visibility, sun] = part, some
    for (visibility, sun), (part, some) in sorted(
            noisy.items(), key=lambda item: -len(item[1][1])):
        found = trace(visibility, [sun], [sights[i] for i in some],
                      "--paths", options.paths, "--most", options.most,
                      "--error", options.error, "--threads", options.jobs)
        better = 0
        for place, i in enumerate(some):
            for c, channel in enumerate(CHANNELS):
                light, error, _ = found[place, sun][c]
                row = part[channel]
                if 1e4 * error / light < row["error"][i]:
                    row["radiance"][i] = float(f"{light:.4g}")
                    row["error"][i] = round(1e4 * error / light)
                    better += 1
        write(table, options.out)
        print(f"visibility {visibility:g} km, Sun {sun:g}: {better} of "
              f"{3 * len(some)} rows are better known", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--paths", type=int, default=500)
    parser.add_argument("--most", type=int, default=4000)
    parser.add_argument("--error", type=float, default=0.004)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--visibility", type=float, nargs="+",
                        default=VISIBILITIES)
    parser.add_argument("--out", default=os.path.join(HERE, "table.json"))
    parser.add_argument("--mend", type=float)
    options = parser.parse_args()
    os.nice(max(0, 10 - os.nice(0)))
    if options.mend:
        mend(options)
        return 0
    sights = directions()
    table = {"zeniths": ZENITHS, "azimuths": AZIMUTHS, "suns": SUNS,
             "height": HEIGHT_M, "visibility": {}}
    for visibility in options.visibility:
        found = trace(visibility, SUNS, sights, "--paths", options.paths,
                      "--most", options.most, "--error", options.error,
                      "--threads", options.jobs)
        table["visibility"][f"{visibility:g}"] = table_of(visibility, found,
                                                          sights)
        write(table, options.out)
        errors = sorted(e for sun in table["visibility"][
            f"{visibility:g}"].values() for channel in sun.values()
            for e in channel["error"])
        print(f"visibility {visibility:g} km: {len(errors)} rows, standard "
              f"error {errors[len(errors) // 2] / 100:.2f} % (median), "
              f"{errors[len(errors) * 19 // 20] / 100:.2f} % (of 95 in 100), "
              f"{errors[-1] / 100:.2f} % (worst)", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
