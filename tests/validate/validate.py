#!/usr/bin/python3
"""All tables of docs/validation.md: `make validate`.

    validate.py [--quick] [--assert] [--doc] [PART…]

Runs the parts sea, sky, water, drawn, numbers, eye (all of them), each a
program of its own whose tables go to standard output, and ends with one table
of all checks, their bars and what was found. --quick takes few rows and rays:
a minute. --doc writes that table and the plots of a full run into docs/. The
status is 3 where a part fails by its own bounds, or with --assert where a bar
is missed.
"""
import argparse
import glob
import json
import os
import re
import shutil
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
sys.path.insert(0, HERE)
import svgplot  # noqa: E402

BIN = os.environ.get("PELAGOS_BIN", os.path.join(ROOT, "build/release/bin"))
# Tests of which the figures are shown; each fails by its own bounds.
NUMBERS = ("brdf_test", "facets_test", "directional_test", "ndbc_test",
           "welch_test", "cascade_test", "probe_test", "shimmer_test")
DOC = os.path.join(ROOT, "docs", "validation.md")


def folder_of(options):
    return os.path.join(ROOT, "build", "validate",
                        "quick" if options.quick else "")


def script(name, options):
    return ["/usr/bin/python3", "-B", os.path.join(HERE, name)] + (
        ["--quick"] if options.quick else [])


def parts(options):
    """{part: its commands}"""
    quick = ["--quick"] if options.quick else []
    return {
        "sea": [script("seatrace/seatrace.py", options)],
        "sky": [script("airtrace/airsky.py", options)],
        "water": [[os.path.join(BIN, "validate_water"), *quick],
                  ["cat", os.path.join(folder_of(options), "water.md")]],
        "drawn": [script("drawn.py", options),
                  [os.path.join(BIN, "drawn_test")]
                  + ([] if options.quick else ["--all"])],
        "numbers": [[os.path.join(BIN, test)] for test in NUMBERS],
        "eye": [script("eye.py", options)],
    }


def name_of(command):
    return os.path.basename(command[2 if "python" in command[0] else 0])


def run(command):
    """Shows what a program prints, without a test's frame; its status."""
    name = name_of(command)
    print(f"\n== {name}", flush=True)
    start = time.monotonic()
    child = subprocess.Popen(command, stdout=subprocess.PIPE,
                             stderr=subprocess.STDOUT, text=True, cwd=ROOT)
    for line in child.stdout:
        if not re.match(r"\[|info|warn|\s*$", line):
            print(line, end="", flush=True)
    status = child.wait()
    print(f"({name}: {time.monotonic() - start:.0f} s"
          + (f", status {status})" if status else ")"), flush=True)
    return status


def read(folder, name):
    try:
        with open(os.path.join(folder, name), encoding="utf-8") as f:
            return json.load(f)
    except OSError:
        return None


def spread(values):
    """Median and worst without sign, as words; both numbers."""
    order = sorted(abs(v) for v in values)
    return order[len(order) // 2], order[-1]


def sea_checks(folder):
    found = read(folder, "seatrace-pm.json")
    if not found:
        return
    worst = max(abs(row["difference"]) for row in found["flat"])
    yield ("Fresnel, flat sea, 0 to 89.9°", "≤ 0.5 %", f"{worst:.2%} worst",
           worst <= 0.005)
    for key, what, last, bars in (("sky550", "sky layer", 80, (0.05, 0.10)),
                                  ("sun550", "Sun layer", 75, (0.05, 0.10))):
        for far, bar in zip((False, True), bars):
            part = [row[key] for row in found["rows"]
                    if (row["zenith"] > last) == far
                    and row[key]["verdict"] != "dim"]
            if part:
                middle, most = spread(e["difference"] for e in part)
                failed = sum(e["verdict"] == "FAIL" for e in part)
                yield (f"{what}, zenith {'over' if far else 'to'} {last}°",
                       f"≤ {bar:.0%} each row",
                       f"median {middle:.1%}, worst {most:.1%}, {failed} of "
                       f"{len(part)} fail", failed == 0)


def sky_checks(folder):
    found = read(folder, "airsky-all.json")
    if not found:
        return
    for name, what in (("cpu", "C"), ("gpu", "shaders")):
        values = sorted(abs(row[name]) for row in found["rows"]
                        if name in row)
        if values:
            p95 = values[len(values) * 19 // 20]
            middle, worst = spread(values)
            yield (f"sky radiance, {what}", "median ≤ 1.5, p95 ≤ 5, worst "
                   "≤ 10 %", f"{middle:.2%}, {p95:.1%}, {worst:.1%}",
                   middle <= 0.015 and p95 <= 0.05 and worst <= 0.1)


def water_checks(folder):
    rows = read(folder, "water.json")
    if not rows:
        return
    errors = [row["all"] / row["montecarlo"] - 1 for row in rows
              if row.get("montecarlo")]
    rms = (sum(e * e for e in errors) / len(errors)) ** 0.5
    yield ("all orders in the water", "≤ 0.3 % rms, none above 2 %",
           f"{rms:.2%} rms, worst {spread(errors)[1]:.1%}",
           rms <= 0.003 and spread(errors)[1] <= 0.02)


def drawn_checks(folder):
    found = read(folder, "drawn.json")
    if found:
        rows = found["rows"]
        failed = sum(not row["pass"] for row in rows)
        yield ("drawn against queried", "median ≤ 1 mm + 0.05 pixel, p99 ≤ "
               "1 pixel", f"p99 {max(r['p99_px'] for r in rows):.2f} pixels "
               f"at worst, {failed} of {len(rows)} fail", failed == 0)


def eye_checks(folder):
    found = read(folder, "eye.json")
    if found:
        for check in found["checks"]:
            yield tuple(check)


def summary(folder):
    lines = ["| check | bar | found | |", "|---|---|---|---|"]
    missed = 0
    for checks in (sea_checks, sky_checks, water_checks, drawn_checks,
                   eye_checks):
        for what, bar, figure, good in checks(folder):
            lines.append(f"| {what} | {bar} | {figure} | "
                         f"{'met' if good else 'MISSED'} |")
            missed += not good
    return lines, missed


def sky_plots(folder):
    """Radiance over the zenith angle in the Sun's vertical, 550 nm."""
    found = read(folder, "airsky-all.json")
    if not found:
        return
    panels = []
    for visibility, sun in ((300, 40), (300, 80), (300, 93), (40, 50),
                            (40, 80), (40, 93), (5, 50), (5, 80), (5, 93)):
        part = [row for row in found["rows"] if row["channel"] == "550"
                and row["azimuth"] in (0, 180)
                and (row["visibility"], row["sun"]) == (visibility, sun)]
        part.sort(key=lambda r: r["zenith"] * (1 if r["azimuth"] else -1))

        def curve(name, part=part):
            return [(r["zenith"] * (1 if r["azimuth"] else -1), r["reference"]
                     * (1 + (r[name] if name else 0))) for r in part
                    if not name or name in r]

        panels.append((f"{visibility} km, Sun's zenith {sun}°",
                       {"reference": curve(None), "cpu": curve("cpu"),
                        "gpu": curve("gpu")}))
    svgplot.save(os.path.join(folder, "airsky.svg"), panels,
                 "zenith angle, ° (the Sun's side to the left)",
                 "W m⁻² sr⁻¹ nm⁻¹ at 550 nm", log=True)


def write_doc(folder, lines):
    """The table between its marks in docs/validation.md, and the plots."""
    with open(DOC, encoding="utf-8") as f:
        text = f.read()
    text = re.sub(r"(<!-- checks -->\n).*?(<!-- end -->)",
                  lambda m: m.group(1) + "\n".join(lines) + "\n" + m.group(2),
                  text, flags=re.S)
    with open(DOC, "w", encoding="utf-8") as f:
        f.write(text)
    for path in glob.glob(os.path.join(folder, "seatrace-pm-*.svg")) + \
            glob.glob(os.path.join(folder, "airsky.svg")):
        shutil.copy(path, os.path.join(ROOT, "docs", "validation-"
                                       + os.path.basename(path)))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--assert", dest="check", action="store_true")
    parser.add_argument("--doc", action="store_true")
    parser.add_argument("part", nargs="*", metavar="PART")
    options = parser.parse_args()
    known = parts(options)
    if unknown := [part for part in options.part if part not in known]:
        parser.error(f"no such part: {unknown[0]}; there are {', '.join(known)}")
    os.nice(max(0, 10 - os.nice(0)))
    failed = [name_of(command)
              for part in options.part or known for command in known[part]
              if run(command)]
    folder = folder_of(options)
    sky_plots(folder)
    lines, missed = summary(folder)
    print("\n" + "\n".join(lines))
    print(f"\n{missed} bars are missed"
          + (f"; failed: {', '.join(failed)}" if failed else ""))
    if options.doc and not options.quick:
        write_doc(folder, lines)
    return 3 if failed or (options.check and missed) else 0


if __name__ == "__main__":
    sys.exit(main())
