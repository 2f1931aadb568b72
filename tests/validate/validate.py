#!/usr/bin/python3
"""All tables of docs/validation.md: `make validate`.

    validate.py [--quick] [--assert] [--doc] [PART…]

Runs the parts sea, sky, water, drawn, numbers, eye, foam, night, ship (all of them), each of
programs of its own, two programs at a time; shows their tables in turn, and
ends with one table of all checks, their bars and what was found. --quick takes
few rows and rays: a minute. --doc writes the rows of the parts that ran into
the table of docs/validation.md, and their plots beside it; not from --quick.
The status is 3 where a part fails by its own bounds, or with --assert where a
bar is missed.
"""
import argparse
import concurrent.futures
import contextlib
import glob
import json
import math
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
SLOW = ("probe_test", "shimmer_test", "welch_test")  # not in --quick
DOC = os.path.join(ROOT, "docs", "validation.md")


def folder_of(options):
    return os.path.join(ROOT, "build", "validate",
                        "quick" if options.quick else "")


def script(name, options):
    return ["/usr/bin/python3", "-B", os.path.join(HERE, name)] + (
        ["--quick"] if options.quick else [])


def parts(options):
    """{part: its commands}, the longest first."""
    quick = ["--quick"] if options.quick else []
    return {
        "sea": [script("seatrace/seatrace.py", options) + ["--jobs", "1"]],
        "ship": [script("shiptrace/shiptrace.py", options)],
        "drawn": [script("drawn.py", options),
                  [os.path.join(BIN, "drawn_test")]
                  + ([] if options.quick else ["--all"])],
        "sky": [script("airtrace/airsky.py", options)],
        "water": [[os.path.join(BIN, "validate_water"), *quick]],
        "numbers": [[os.path.join(BIN, test)] for test in NUMBERS
                    if not (options.quick and test in SLOW)],
        "eye": [script("eye.py", options)],
        "foam": [script("foam.py", options)],
        "night": [script("night.py", options)],
        "space": [script("space.py", options),
                  script("spacewinds.py", options),
                  [os.path.join(BIN, "space_mixed_test")],
                  [os.path.join(BIN, "space_rows_test")]
                  + ([] if options.quick else ["--long"])],
    }


def name_of(command):
    return os.path.basename(command[2 if "python" in command[0] else 0])


def run(command, folder):
    """Status, and seconds of wall and of processor, with all that it started;
    what it prints, without a test's frame, goes into the folder as NAME.txt."""
    start = time.monotonic()
    try:
        process = subprocess.Popen(command, stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, cwd=ROOT)
    except OSError as error:
        return 127, (0.0, 0.0), [str(error)]
    with process.stdout:
        text = process.stdout.read().decode(errors="replace")
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if name_of(command) == "validate_water" and process.returncode == 0:
        with open(os.path.join(folder, "water.md"), encoding="utf-8") as f:
            text += f.read()
    lines = [line for line in text.splitlines()
             if line.strip() and not re.match(r"\[|info|warn", line)]
    with open(os.path.join(folder, name_of(command) + ".txt"), "w",
              encoding="utf-8") as f:
        f.write("\n".join(lines) + "\n")
    return process.returncode, (time.monotonic() - start,
                                used.ru_utime + used.ru_stime), lines


def forget(chosen, folder):
    """Results of earlier runs of these parts: what fails shows no old ones."""
    for path in [RESULTS[part] for part in chosen if part in RESULTS]:
        with contextlib.suppress(FileNotFoundError):
            os.remove(os.path.join(folder, path))


def run_all(chosen, folder):
    """Names of those that failed. Two at a time, shown as they end."""
    failed, start, all_used = [], time.monotonic(), 0.0
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        ours = {pool.submit(run, command, folder): name_of(command)
                for command in chosen}
        for future in concurrent.futures.as_completed(ours):
            status, (seconds, used), lines = future.result()
            all_used += used
            print(f"\n== {ours[future]}", *lines, sep="\n")
            print(f"({ours[future]}: {seconds:.0f} s, {used:.0f} s of processor"
                  + (f", status {status})" if status else ")"), flush=True)
            if status:
                failed.append(ours[future])
    print(f"\nAll: {time.monotonic() - start:.0f} s, {all_used:.0f} s of "
          "processor", flush=True)
    return failed


def read(folder, name):
    try:
        with open(os.path.join(folder, name), encoding="utf-8") as f:
            return json.load(f)
    except OSError:
        return None


def said(folder, name, pattern):
    """All matches of a pattern in what a program printed."""
    try:
        with open(os.path.join(folder, name + ".txt"), encoding="utf-8") as f:
            return re.findall(pattern, f.read())
    except OSError:
        return []


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
                unsure = sum(e["verdict"] == "open" for e in part)
                yield (f"{what}, zenith {'over' if far else 'to'} {last}°",
                       f"≤ {bar:.0%} each row",
                       f"median {middle:.1%}, worst {most:.1%}, of {len(part)} "
                       f"rows {failed} fail, {unsure} open",
                       None if unsure and not failed else not failed)


def sky_checks(folder):
    found = read(folder, "airsky-all.json")
    if not found:
        return
    for name, what in (("cpu", "C"), ("gpu", "shaders")):
        rows = [row for row in found["rows"] if name in row]
        if rows:
            values = sorted(abs(row[name]) for row in rows)
            p95 = values[len(values) * 19 // 20]
            middle, _ = spread(values)
            # As airsky.py: what the reference knows worse is open.
            known = [abs(row[name]) for row in rows if row["noise"] <= 0.05]
            worst = max(known, default=0)
            yield (f"sky radiance, {what}", "median ≤ 1.5, p95 ≤ 5, worst "
                   "≤ 10 %", f"{middle:.2%}, {p95:.1%}, {worst:.1%}, "
                   f"{len(rows) - len(known)} of {len(rows)} rows open",
                   middle <= 0.015 and p95 <= 0.05 and worst <= 0.1)


def beyond(rms, noise):
    """What is left of a root mean square without its reference's noise."""
    return max(rms * rms - noise * noise, 0.0) ** 0.5


def known_within(rms, noise, bar, others=True):
    """Whether a comparison keeps a bar for its rms, noise and all, and others;
    None where noise that exceeds the bar explains it."""
    if noise < bar:
        return rms <= bar and others
    return None if rms <= math.hypot(bar, 1.5 * noise) and others else False


def published_checks(folder):
    """Of the water that each table is of, and in words of the default's."""
    names = {"canonical problems": "problems 1, 2, 6 of Mobley et al. 1993, "
                                    "optical depths of 1 to 10",
             "K_d": "K_d of Morel and Maritorena 2001, average Case 1 water "
                    "with CDOM after Morel and Gentili 2009",
             "R": "R of Morel and Maritorena 2001, the same water",
             "f/Q": "f/Q of Morel, Antoine and Gentili 2002"}
    tell = r"([^,]+?) ([\d.]+) %"
    usual = {what.strip(): number for line
             in said(folder, "validate_water", r"In the default water: (.*)")
             for what, number in re.findall(tell, line)}
    for line in said(folder, "validate_water", r"Median off: (.*)"):
        for what, number in re.findall(tell, line):
            what = what.strip()
            more = (f" (the default water {usual[what]} %)" if what in usual
                    else "")
            yield (names.get(what, what), "median ≤ 10 %",
                   f"{number} %{more}", float(number) <= 10)


def column_checks(folder):
    """Problems of which no published number is at hand, against photons."""
    for own, layers, sky, noise, waves, through in said(
            folder, "validate_water",
            r"Columns, median off: photons against published ([\d.]+) %, "
            r"problem 3 ([\d.]+) %, problem 4 ([\d.]+) % \(noise ([\d.]+) %\), "
            r"problem 5 ([\d.]+) %, light through waves ([\d.]+) %"):
        for what, figure, more in (
                ("photons of columns themselves, problems 2 and 6 with "
                 "Petzold's function", own, ""),
                ("problem 3's kind, layers, by a homogeneous water: light just "
                 "below the surface, photons (not the paper's figure)", layers,
                 ""),
                ("problem 4's kind, below a sky, photons (not the paper's "
                 "figure)", sky, f" (noise {noise} %)"),
                ("problem 5's kind, below waves, Sun at 80°, photons (not the "
                 "paper's figure)", waves, ""),
                ("part of a Sun's light that enters through waves, photons",
                 through, "")):
            yield (what, "median ≤ 10 %", f"{figure} %{more}",
                   float(figure) <= 10)


def water_checks(folder):
    yield from published_checks(folder)
    yield from column_checks(folder)
    for rays in said(folder, "validate_water",
                     r"All (\d+): rms ([\d.]+) %, of which the photons' noise "
                     r"([\d.]+) %; worst ([\d.]+) %"):
        rms, noise, worst = (float(value) / 100 for value in rays[1:])
        yield ("all orders by chlorophyll, photons of another program",
               "≤ 0.3 % rms, none above 2 %",
               f"{rms:.2%} rms (of it noise {noise:.2%}), worst {worst:.1%} "
               f"of {rays[0]}",
               known_within(rms, noise, 0.003,
                            worst <= max(0.02, 5 * noise)))
    for rays in said(folder, "validate_water",
                     r"Raman, all (\d+): rms ([\d.]+) %, of which the photons' "
                     r"noise ([\d.]+) %; worst ([\d.]+) %"):
        rms, noise, worst = (float(value) / 100 for value in rays[1:])
        yield ("problem 7's kind, Raman's light by itself, photons of another "
               "program",
               "≤ 1 % rms, none above 10 %",
               f"{rms:.2%} rms (of it noise {noise:.2%}), worst {worst:.1%} "
               f"of {rays[0]}",
               known_within(rms, noise, 0.01,
                            worst <= max(0.1, 5 * noise)))
    rows = [row for row in read(folder, "water.json") or ()
            if row.get("montecarlo")]
    if not rows:
        return
    errors = [row["all"] / row["montecarlo"] - 1 for row in rows]
    noises = [row["montecarloError"] / row["montecarlo"] for row in rows]
    rms, noise = (math.sqrt(sum(v * v for v in values) / len(rows))
                  for values in (errors, noises))
    worst = spread(errors)[1]
    yield ("all orders, bottoms and views to 88°, own Monte Carlo",
           "≤ 0.3 % rms less noise, none above 2 %",
           f"{rms:.2%} rms (noise {noise:.2%}, less it "
           f"{beyond(rms, noise):.2%}), worst {worst:.1%} of {len(rows)}",
           beyond(rms, noise) <= 0.003 and worst <= max(0.02, 5 * noise))


def drawn_checks(folder):
    found = read(folder, "drawn.json")
    if found:
        rows = found["rows"]
        failed = sum(not row["pass"] for row in rows)
        yield ("drawn against queried", "median ≤ 1 mm + 0.05 pixel, p99 ≤ "
               "1 pixel", f"p99 {max(r['p99_px'] for r in rows):.2f} pixels "
               f"at worst, {failed} of {len(rows)} fail", failed == 0)
    # drawn_test prints a row for each sea, eye, heading and length of wave.
    rows = said(folder, "drawn_test", r"\| ([\d.]+) \| [\d.]+ \| \d+ \| \d+ \| "
                r"([\d.]+) % \| (pass|fail) \|")
    if rows:
        failed = [row for row in rows if row[2] == "fail"]
        yield ("drawn against queried, from 2 to 100 m, both ways, and what "
               "nearer waves should hide", "the same, 1 % hidden",
               f"p99 {max(float(row[0]) for row in rows):.2f} pixels, hidden "
               f"{max(float(row[1]) for row in rows):.1f} % at worst, "
               f"{len(failed)} of {len(rows)} fail", not failed)


def numbers_checks(folder):
    normals = said(folder, "cascade_test",
                   r"gradient by ([\d.]+) deg rms, worst ([\d.]+)")
    if normals:
        rms = max(float(n[0]) for n in normals)
        yield ("queried normals, FFT, against the gradient", "≤ 0.2° rms",
               f"{rms:.2f}° rms in the worst of {len(normals)} seas",
               rms <= 0.2)
    for name, what in (("sixty", "trochoids"), ("FFT", "FFT")):
        seas = said(folder, "welch_test",
                    name + r", spectrum.*: ([\d.]+) rms of ln.*noise ([\d.]+)")
        if seas:
            rms = [float(sea[0]) for sea in seas]
            noise = max(float(sea[1]) for sea in seas)
            yield (f"Welch's spectrum of queries, 0.7 to 4 ω_p, {what}",
                   "≤ 0.15 rms ln each", f"median {spread(rms)[0]:.3f}, worst "
                   f"{max(rms):.3f} of {len(rms)} seas, noise {noise:.3f}",
                   max(rms) <= 0.15)


def eye_checks(folder):
    found = read(folder, "eye.json")
    if found:
        for check in found["checks"]:
            yield tuple(check)


def foam_checks(folder):
    found = read(folder, "foam.json")
    if found:
        for check in found["checks"]:
            yield tuple(check)


def night_checks(folder):
    found = read(folder, "night.json")
    if found:
        for check in found["checks"]:
            yield tuple(check)


def ship_checks(folder):
    found = read(folder, "shiptrace.json")
    for s in found["sums"] if found else ():
        yield (f"{s['look']}, {s['wind']} m/s, Sun {s['sun']}",
               "≤ 5 % a line", f"median {s['median']:.1%}, worst "
               f"{s['worst']:.1%} (noise {s['noise']:.1%}), {s['over']} of "
               f"{s['lines']} fail", s["over"] == 0)


def space_checks(folder):
    found = read(folder, "space.json")
    for r in found["rows"] if found else ():
        parts = [f"{where}{100 * m:.1f}" for m, where in
                 ((r["beside"], ""), (r["in"], "glint "))
                 if m is not None]
        yield (f"{r['height'] / 1e3:g} km, Sun {r['sun']}°, "
               f"{r['azimuth']}° aside", "2 %, glint 5",
               ", ".join(parts), r["pass"])
    for r in found.get("rise", ()) if found else ():
        moves = [abs(b / a - 1) for a, b in zip(r["share"], r["share"][1:])]
        yield (f"rows at {r['pitch']}°, {r['heights'][0] / 1e3:g} to "
               f"{r['heights'][-1] / 1e3:g} km, against the trace",
               "1 % an octave + 2 noise", f"{100 * max(moves):.2f}, noise "
               f"{100 * max(r['noise']):.2f}", r["pass"])
    found = read(folder, "spacewinds.json")
    for r in found["rows"] if found else ():
        parts = [f"{where}{100 * r[name]:.1f} (other wind "
                 f"{100 * r[name + 'Other']:.1f})" for name, where in
                 (("beside", ""), ("in", "glint "))
                 if r[name] is not None]
        yield (f"two winds, {r['height'] / 1e3:g} km, Sun {r['sun']}°, "
               f"{r['azimuth']}° aside", "2 %, glint 5",
               ", ".join(parts), r["pass"])
    rows = said(folder, "space_rows_test",
                r"(\d+)° below: ([\d.]+) % an octave.* ([\d.]+) %")
    for below, most, noise in rows:
        yield (f"rows at -{below}°, 2 m to 400 km, no air",
               "1 % an octave + 2 noise", f"{most}, noise {noise}",
               float(most) <= 1 + 2 * float(noise))
    for what, most in said(folder, "space_mixed_test",
                           r"(.*), each hundredth.* by ([\d.]+) of 255"):
        yield (f"{what}, 20 to 30 km, bands of 8 rows",
               "3 of 255 each 1 % of height", most,
               float(most) <= 3)


CHECKS = {"sea": sea_checks, "sky": sky_checks, "water": water_checks,
          "drawn": drawn_checks, "numbers": numbers_checks, "eye": eye_checks,
          "foam": foam_checks, "night": night_checks, "ship": ship_checks,
          "space": space_checks}
RESULTS = {"sea": "seatrace-pm.json", "sky": "airsky-all.json",
           "water": "water.json", "drawn": "drawn.json", "eye": "eye.json",
           "foam": "foam.json", "night": "night.json", "ship": "shiptrace.json",
           "space": "space.json"}
HEAD = ["| part | check | bar | found | |", "|---|---|---|---|---|"]


def summary(folder, chosen):
    """Rows of the table by part; how many miss their bar. A check is good, not
    good, or None: noise leaves it open."""
    words = {True: "met", False: "MISSED", None: "open"}
    rows, missed = {}, 0
    for part in CHECKS:
        if part not in chosen:
            continue
        checks = list(CHECKS[part](folder)) or [
            ("its programs", "end with figures", "none", False)]
        for what, bar, figure, good in checks:
            rows.setdefault(part, []).append(
                f"| {part} | {what} | {bar} | {figure} | "
                f"{words[good]} |")
            missed += good is not None and not good
    return rows, missed


def table(rows):
    return HEAD + [line for part in CHECKS for line in rows.get(part, ())]


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


def write_doc(folder, rows):
    """The rows of these parts between the table's marks in
    docs/validation.md, the others as they are; and the plots."""
    with open(DOC, encoding="utf-8") as f:
        text = f.read()
    marks = re.search(r"(<!-- checks -->\n)(.*?)(<!-- end -->)", text, re.S)
    kept = {}
    for line in marks[2].splitlines():
        part = line.strip("| ").split(" |")[0]
        if part in CHECKS:
            kept.setdefault(part, []).append(line)
    lines = table({**kept, **rows})
    text = (text[:marks.end(1)] + "\n".join(lines) + "\n"
            + text[marks.start(3):])
    with open(DOC, "w", encoding="utf-8") as f:
        f.write(text)
    for part, plots in (("sea", "seatrace-pm-*.svg"), ("sky", "airsky.svg"),
                        ("ship", "shiptrace*.jpg")):
        for path in glob.glob(os.path.join(folder, plots)):
            if part in rows:
                shutil.copy(path, os.path.join(
                    ROOT, "docs", "validation-" + os.path.basename(path)))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--assert", dest="check", action="store_true")
    parser.add_argument("--doc", action="store_true")
    parser.add_argument("--tables", action="store_true",
                        help="run nothing: of what the last run left")
    parser.add_argument("part", nargs="*", metavar="PART")
    options = parser.parse_args()
    known = parts(options)
    if unknown := [part for part in options.part if part not in known]:
        parser.error(f"no such part: {unknown[0]}; there are {', '.join(known)}")
    os.nice(max(0, 10 - os.nice(0)))
    chosen = options.part or list(known)
    folder = folder_of(options)
    os.makedirs(folder, exist_ok=True)
    if not options.tables:
        forget(chosen, folder)
    failed = [] if options.tables else run_all(
        [c for part in known if part in chosen for c in known[part]], folder)
    sky_plots(folder)
    rows, missed = summary(folder, chosen)
    print("\n" + "\n".join(table(rows)))
    print(f"\n{missed} bars are missed"
          + (f"; failed: {', '.join(failed)}" if failed else ""))
    if options.doc and not options.quick:
        write_doc(folder, rows)
    return 3 if failed or (options.check and missed) else 0


if __name__ == "__main__":
    sys.exit(main())
