#!/usr/bin/python3
"""Small pictures of pelagosd against rays over a realised sea (seatrace.c).

    seatrace.py [--quick] [--assert [flat]] [--spectrum pm|elfouhaily]
                [--linear] [--times N] [--jobs N] [--slant M] [--no-paper]

Views of 128 x 16 pixels look at the sea from a slant distance of 2 km, so that
pixels are wider than the shortest waves and narrower than the longest; over
several seeds, places and moments the mean of their EXR layers `sky`, `sun` and
`fresnel` is compared with the mean radiance of realised seas in the same
directions. Taken from the program, so that only the surface is judged: the
radiance of its sky (its own pictures of it) and the Sun's irradiance. The water
is black in both. Everything is at 550 nm; the path's transmittance (Rayleigh's
scattering alone, visibility 300 km) is divided out.

Prints every row; the status is 0 unless --assert is given and a row fails.
Writes seatrace-SPECTRUM.md and .json into build/validate/ (quick: into its
quick/).
"""
import argparse
import concurrent.futures
import contextlib
import json
import math
import os
import subprocess
import sys
import tempfile

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(
    os.path.abspath(__file__)))))
sys.path[:0] = [os.path.join(ROOT, "tests"),
                os.path.join(ROOT, "clients", "python"),
                os.path.join(ROOT, "tests", "validate")]
import pelagos  # noqa: E402
import svgplot  # noqa: E402
from pelagos_daemon import BIN, Daemon  # noqa: E402

SPECTRA = {"pm": "PIERSON_MOSKOWITZ", "elfouhaily": "ELFOUHAILY"}
FETCH_M = 2e6
WIND_FROM = 30  # degrees from the Sun's azimuth, clockwise, which is north
AZIMUTHS = {"ahead": 0, "abeam": 90, "behind": 180}
WIDE, HIGH, COLUMNS, LINES = 4.0, 0.5, 128, 16
CHANNELS = ("680", "550", "440")
# Rayleigh's extinction at sea level, 1/m: 1.24062e-6 / lambda^4 (um).
EXTINCTION = 1.24062e-6 / np.array([0.68, 0.55, 0.44]) ** 4
# Sea layer's bars: to this zenith, beyond.
BARS = {"sky": (80, 0.05, 0.10), "sun": (75, 0.05, 0.10)}
FLAT_BAR = 0.005
FLAT_ZENITHS = (0, 20, 40, 50, 53.3, 60, 70, 75, 80, 83, 85, 87, 88, 89, 89.5,
                89.8, 89.9)
EARTH_M = 6.36e6


def base_state(spectrum):
    """Sea of a spectrum, black water, clear air."""
    absorbing = {f"{what}{nm}": value for nm in CHANNELS
                 for what, value in (("absorption", 100), ("scattering", 0))}
    return {"clock": {"mode": "STEPPED", "time": 0},
            "sea": {"spectrum": SPECTRA[spectrum], "fetch": FETCH_M,
                    "synthesiser": "FFT"},
            "water": absorbing,
            "sky": {"sunAzimuth": 0, "visibility": 300000}}


def change(daemon, patch):
    answer = daemon.patch(patch)
    if answer.status != 200:
        sys.exit(f"seatrace: {answer.status} {answer.body[:300]!r}")


def pictures(ocean, names, layers, at=None):
    frames = ocean.frames(names, "exr", layers=layers, float_samples=True,
                          time=at)
    return {name: frame.exr() for name, frame in frames.items()}


# --- what is taken from the program -----------------------------------------

SKY_VIEWS = {"sky0": (0, 0), "sky90": (90, 0), "sky180": (180, 0),
             "zenith": (0, 90)}
SKY_FIELD, SKY_SIZE = 100, 384


def axes(yaw, pitch):
    """Forward, right and up of a view, as east, north, up."""
    a, p = math.radians(yaw), math.radians(pitch)
    forward = (math.sin(a) * math.cos(p), math.cos(a) * math.cos(p),
               math.sin(p))
    right = (math.cos(a), -math.sin(a), 0)
    return np.array(forward), np.array(right), np.cross(right, forward)


def sample(image, axis, directions):
    """Bilinear samples of a square picture; None where it does not reach."""
    forward, right, up = axis
    depth = directions @ forward
    scale = SKY_SIZE / (2 * math.tan(math.radians(SKY_FIELD / 2)))
    with np.errstate(divide="ignore", invalid="ignore"):
        u = SKY_SIZE / 2 + scale * (directions @ right) / depth - 0.5
        v = SKY_SIZE / 2 - scale * (directions @ up) / depth - 0.5
        inside = ((depth > 0.1) & (u >= 0) & (u < SKY_SIZE - 1) & (v >= 0)
                  & (v < SKY_SIZE - 1))
    u, v = np.where(inside, u, 0), np.where(inside, v, 0)
    i, j = u.astype(int), v.astype(int)
    u, v = (u - i)[:, None], (v - j)[:, None]
    value = ((1 - v) * ((1 - u) * image[j, i] + u * image[j, i + 1])
             + v * ((1 - u) * image[j + 1, i] + u * image[j + 1, i + 1]))
    return value, inside


def take_sky(daemon, ocean, elevation):
    """The Sun's irradiance at 550 nm, and the sky's radiance over 121
    elevations 90 (i/120)^2 and 181 azimuths from the Sun's, from pictures. The
    lowest third of a degree, which pixels share with the sea, is the
    next."""
    change(daemon, {"sky": {"sunElevation": elevation},
                    "sea": {"windSpeed": 0},
                    "views": [{"name": name, "yaw": yaw, "pitch": pitch,
                               "fieldOfView": SKY_FIELD, "width": SKY_SIZE,
                               "height": SKY_SIZE, "up": 2}
                              for name, (yaw, pitch) in SKY_VIEWS.items()]})
    seen = pictures(ocean, list(SKY_VIEWS), ["sky"])
    height = np.maximum(90 * (np.arange(121) / 120) ** 2, 0.6)
    e, a = np.meshgrid(np.radians(height), np.radians(np.arange(181)),
                       indexing="ij")
    directions = np.stack([np.sin(a) * np.cos(e), np.cos(a) * np.cos(e),
                           np.sin(e)], -1).reshape(-1, 3)
    table = np.full((len(directions), 3), np.nan)
    for name, (yaw, pitch) in SKY_VIEWS.items():
        image = np.asarray(seen[name]["sky"], dtype=float)
        value, inside = sample(image, axes(yaw, pitch), directions)
        new = inside & np.isnan(table[:, 0])
        table[new] = value[new]
    assert not np.isnan(table).any()
    answer = daemon.get(f"/v1/optics/sky?height=2&elevation=90&azimuth=0"
                        f"&sky.sunElevation={elevation}").json()
    irradiance = answer["sky"]["sunIrradiance"][1]
    return irradiance, table.reshape(121, 181, 3)


def write_skies(path, skies):
    parts = [np.array([len(skies)], dtype="<f8")]
    for elevation, (irradiance, table) in skies.items():
        parts.append(np.array([elevation, irradiance], dtype="<f8"))
        parts.append(table.astype("<f8").ravel())
    with open(path, "wb") as f:
        f.write(b"".join(part.tobytes() for part in parts))


# --- the two sides ----------------------------------------------------------

def row_views(zeniths, slant_m, random):
    """A view for each zenith and azimuth, at places of chance within 2 km."""
    views = []
    for zenith in zeniths:
        for name, azimuth in AZIMUTHS.items():
            east, north = random.uniform(-2000, 2000, 2)
            views.append({"name": f"z{zenith}-{name}", "yaw": azimuth,
                          "pitch": zenith - 90, "fieldOfView": WIDE,
                          "width": COLUMNS, "height": LINES,
                          "forward": north, "right": east,
                          "up": slant_m * math.cos(math.radians(zenith))})
    return views


def row_means(picture, up, slant):
    # The air thins upwards by a scale height of 8 km; mean over the path.
    thin = -math.expm1(-up / 8000) / (up / 8000)
    clear = np.exp(-EXTINCTION * thin
                   * np.asarray(picture["depth"])[..., None])
    sky = (picture["sky"] / clear).mean((0, 1))
    sun = (picture["sun"] / clear).mean((0, 1))
    return [*sky, sun[1], picture["fresnel"].mean(), *tilts(picture, up, slant)]


def tilts(picture, up, slant):
    """How the long waves tilt what the picture shows: heights that are seen,
    of its upper half less its lower, of its right less its left, m."""
    depth = np.asarray(picture["depth"], dtype=float)
    scale = 2 * math.tan(math.radians(WIDE / 2)) / COLUMNS
    x = scale * (np.arange(COLUMNS) + 0.5 - COLUMNS / 2)
    y = scale * (LINES / 2 - 0.5 - np.arange(LINES))[:, None]
    # The middle of the picture is at the slant distance on level water.
    cosine = up / slant
    sine = math.sqrt(1 - cosine * cosine)
    down = (cosine - y * sine) / np.sqrt(1 + x * x + y * y)
    height = up - depth * down + depth ** 2 * (1 - down ** 2) / (2 * EARTH_M)
    half = LINES // 2, COLUMNS // 2
    return (height[:half[0]].mean() - height[half[0]:].mean(),
            height[:, half[1]:].mean() - height[:, :half[1]].mean())


def mean_of(samples):
    """Means of sky x 3, sun and fresnel over pictures, and their errors, as
    for pictures without tilt: heights that are seen are alike everywhere in
    the mean, so both tilts are 0 in it, and what goes with them is chance."""
    values = np.array(samples)
    values, tilt = values[:, :5], values[:, 5:]
    count = len(values)
    if count < 16:
        return values.mean(0), values.std(0, ddof=1) / math.sqrt(count)
    by = np.column_stack([np.ones(count), tilt])
    found = np.linalg.lstsq(by, values, rcond=None)[0]
    rest = values - by @ found
    unit = np.linalg.inv(by.T @ by)[0, 0]
    return found[0], np.sqrt((rest * rest).sum(0) / (count - 3) * unit)


def drawn(daemon, ocean, wind, setup, rows=None, first=0, values=None):
    """{(sun, row): samples of sky x 3, sun, fresnel, tilts}, of all rows or
    some, pictures from the first on, added to the values of an earlier call."""
    random = np.random.default_rng([int(wind * 10) + 1, first])
    values = {} if values is None else values
    change(daemon, {"views": None})
    for i in range(first, first + setup["pictures"]):
        views = row_views(setup["zeniths"], setup["slant"], random)
        rows = rows or range(len(views))
        views = [views[row] for row in rows]
        names = [view["name"] for view in views]
        change(daemon, {"views": views,
                        "sea": {"windSpeed": wind, "seed": 100 + i, "whitecaps": 0,
                                "windDirection": WIND_FROM}})
        for sun in setup["suns"]:
            change(daemon, {"sky": {"sunElevation": sun}})
            seen = pictures(ocean, names,
                            ["sky", "sun", "depth", "fresnel"], at=10.0 * i)
            for row, view in zip(rows, views):
                values.setdefault((sun, row), []).append(
                    row_means(seen[view["name"]], view["up"],
                              setup["slant"]))
    return values


def traced(wind, spectrum, sky_path, setup, chosen=None, seed=1):
    """{row or "sea": {name: (mean, error)}}; of all rows or some."""
    # Compass degrees run the other way round; waves run from where the wind
    # comes from to the other side.
    command = [os.path.join(BIN, "seatrace"), "--wind", wind, "--spectrum",
               spectrum, "--fetch", FETCH_M, "--wind-to", -(WIND_FROM + 180),
               "--skies", sky_path, "--threads", setup["jobs"],
               "--realisations", setup["realisations"], "--rays",
               setup["rays"], "--facets", setup["facets"], "--chop",
               setup["chop"], "--seed", seed]
    rows = [f"{zenith} {-azimuth} {WIDE} {HIGH}\n"
            for zenith in setup["zeniths"] for azimuth in AZIMUTHS.values()]
    chosen = list(range(len(rows)) if chosen is None else chosen)
    done = subprocess.run([str(word) for word in command],
                          input="".join(rows[row] for row in chosen),
                          stdout=subprocess.PIPE, text=True, check=True)
    found = {}
    for line in done.stdout.splitlines():
        row, name, mean, error = line.split()
        row = row if row == "sea" else str(chosen[int(row)])
        found.setdefault(row, {})[name] = (float(mean), float(error))
    return found


def join(found, more, share):
    """Both traces, the second with a share of all rays."""
    for row, figures in more.items():
        if row != "sea":
            for name, (mean, error) in figures.items():
                before, spread = found[row][name]
                found[row][name] = (
                    before + share * (mean - before),
                    math.hypot((1 - share) * spread, share * error))


def open_rows(table):
    """Places in `zeniths` by `AZIMUTHS` that have rows not yet decided, and
    those of them for which the rays are the greater part of the noise."""
    ours, rays = set(), set()
    for i, row in enumerate(table):
        for entry in (row["sky550"], row["sun550"]):
            if entry["verdict"] == "open":
                place = i // len(set(r["sun"] for r in table))
                ours.add(place)
                if entry["noise"] > 0.5 * entry["error"]:
                    rays.add(place)
    return sorted(ours), sorted(rays)


# --- tables -----------------------------------------------------------------

def verdict(difference, error, bar):
    """Fails beyond the bar by two standard errors; passes within it where
    two of them are no more than the bar; else it is open."""
    if abs(difference) <= bar and 2 * error <= bar:
        return "pass"
    return "FAIL" if abs(difference) - 2 * error > bar else "open"


def compare(ours, our_error, reference, error):
    """Relative difference and its standard error."""
    if reference == 0:
        return math.nan, math.nan
    return ours / reference - 1, math.hypot(
        our_error / reference, ours / reference * error / reference)


def table_of(wind, setup, skies, ours, found, paper):
    rows = []
    index = 0
    for zenith in setup["zeniths"]:
        for name in AZIMUTHS:
            theirs = found[str(index)]
            for s, sun in enumerate(skies):
                mean, error = mean_of(ours[sun, index])
                row = one_row(wind, zenith, name, s, sun, mean, error, theirs)
                if paper:
                    theirs_too = mean_of(paper[sun, index])[0]
                    row["sky550"]["paper"] = theirs_too[1]
                    row["sun550"]["paper"] = theirs_too[3]
                rows.append(row)
            index += 1
    return rows


def one_row(wind, zenith, name, s, sun, mean, error, theirs):
    row = {"wind": wind, "zenith": zenith, "azimuth": name, "sun": sun}
    sky = [theirs[f"sky.{s}.{c}"] for c in range(3)]
    for c, channel in enumerate(CHANNELS):
        d, e = compare(mean[c], error[c], *sky[c])
        row[f"sky{channel}"] = {"ours": mean[c], "reference": sky[c][0],
                                "noise": sky[c][1] / sky[c][0],
                                "difference": d, "error": e}
    row["sky550"]["once"] = theirs[f"skyOnce.{s}"][0]
    once, more = theirs[f"sun.{s}"], theirs[f"sunMore.{s}"]
    total = once[0] + more[0]
    noise = math.hypot(once[1], more[1])
    d, e = compare(mean[3], error[3], total, noise)
    row["sun550"] = {"ours": mean[3], "reference": total,
                     "noise": noise / total if total else math.nan,
                     "difference": d, "error": e,
                     "more": more[0] / total if total else math.nan}
    d, e = compare(mean[4], error[4], *theirs["fresnel"])
    row["fresnel"] = {"ours": mean[4], "reference": theirs["fresnel"][0],
                      "difference": d, "error": e,
                      "white": theirs["white"][0],
                      "blocked": theirs["blocked"][0],
                      "once": theirs["once"][0],
                      "closed": theirs["closed"][0],
                      "lost": theirs["lost"][0]}
    for what, key in (("sky", "sky550"), ("sun", "sun550")):
        last, low, high = BARS[what]
        bar = low if zenith <= last else high
        entry = row[key]
        entry["bar"] = bar
        # Far from the glitter there is nothing to compare: less than half a
        # percent of the sky's light, or not known to 5 %.
        if what == "sun" and (total < 0.005 * sky[1][0]
                              or not entry["noise"] < 0.05):
            entry["verdict"] = "dim"
        else:
            entry["verdict"] = verdict(entry["difference"], entry["error"],
                                       bar)
    return row


HEAD = ("| wind | zenith | look | Sun | sky: ours | reference | ± | differs | ±"
        " | bar | | Sun: ours | reference | ± | differs | ± | bar | |"
        " F: reference | differs | blocked |\n|" + "---|" * 21)


def text_of(row):
    sky, sun, f = row["sky550"], row["sun550"], row["fresnel"]
    text = (f"| {row['wind']:g} | {row['zenith']:g} | {row['azimuth']} "
            f"| {row['sun']:g} | {sky['ours']:.5f} | {sky['reference']:.5f} "
            f"| {sky['noise']:.1%} | {sky['difference']:+.1%} "
            f"| {sky['error']:.1%} | {sky['bar']:.0%} | {sky['verdict']} ")
    if sun["verdict"] == "dim":
        text += f"| {sun['ours']:.2e} | {sun['reference']:.2e} | | | | | dim "
    else:
        text += (f"| {sun['ours']:.2e} | {sun['reference']:.2e} "
                 f"| {sun['noise']:.1%} | {sun['difference']:+.1%} "
                 f"| {sun['error']:.1%} | {sun['bar']:.0%} | {sun['verdict']} ")
    return text + (f"| {f['reference']:.4f} | {f['difference']:+.1%} "
                   f"| {f['blocked']:.1%} |")


def flat_table(daemon, ocean, index):
    """Reflectance of a flat sea against Fresnel's equations, pixel by pixel;
    the Earth's curvature under the line of sight counts."""
    change(daemon, {"views": None})
    change(daemon, {"sea": {"windSpeed": 0}, "sky": {"sunElevation": 35}})
    size, field = 16, 1.0
    views = [{"name": f"flat{i}", "pitch": zenith - 90, "fieldOfView": field,
              "width": size, "height": size,
              "up": max(100 * math.cos(math.radians(zenith)), 1)}
             for i, zenith in enumerate(FLAT_ZENITHS)]
    change(daemon, {"views": views})
    seen = pictures(ocean, [v["name"] for v in views], ["fresnel", "depth"])
    rows = []
    for view, zenith in zip(views, FLAT_ZENITHS):
        # Of the lines beside the middle, two pixels.
        at = (size // 2 - 1, size // 2)
        forward, right, up = axes(0, view["pitch"])
        scale = 2 * math.tan(math.radians(field / 2)) / size
        ours, exact = [], []
        for j in at:
            for i in at:
                d = (forward + right * scale * (i + 0.5 - size / 2)
                     - up * scale * (j + 0.5 - size / 2))
                d /= np.linalg.norm(d)
                depth = float(seen[view["name"]]["depth"][j, i])
                level = math.hypot(d[0], d[1])
                angle = math.atan2(level, -d[2]) - depth * level / EARTH_M
                ours.append(float(seen[view["name"]]["fresnel"][j, i]))
                exact.append(fresnel(math.cos(angle), index))
        d = np.mean(ours) / np.mean(exact) - 1
        rows.append({"zenith": zenith, "ours": float(np.mean(ours)),
                     "exact": float(np.mean(exact)), "difference": d,
                     "verdict": verdict(d, 0, FLAT_BAR)})
    return rows


def fresnel(cosine, index):
    sine2 = (1 - cosine * cosine) / index ** 2
    inside = math.sqrt(1 - sine2)
    s = (cosine - index * inside) / (cosine + index * inside)
    p = (index * cosine - inside) / (index * cosine + inside)
    return (s * s + p * p) / 2


def sea_lines(wind, found):
    """The surface's own moments against its spectrum's."""
    sea = found["sea"]
    parts = [f"wind {wind:g} m/s:"]
    for name, what in (("along", "mean-square slope along the wind"),
                       ("cross", "across")):
        whole = sea[f"{name}.spectrum"][0]
        parts.append(f"{what} {sea[name][0]:.5f} ± {sea[name][1]:.5f} "
                     f"(spectrum {whole:.5f}, {sea[name][0]/whole-1:+.1%}),")
    parts.append(f"Hs {4 * math.sqrt(sea['m0'][0]):.3f} m (spectrum "
                 f"{4 * math.sqrt(sea['m0.spectrum'][0]):.3f} m)")
    return " ".join(parts)


def summary(rows):
    lines = ["| wind | layer | zenith | rows judged | pass | open | FAIL |"
             " median differs | worst |", "|" + "---|" * 9]
    for wind in sorted({row["wind"] for row in rows}):
        for key, what in (("sky550", "sky"), ("sun550", "Sun")):
            last = BARS[what.lower()][0]
            for far in (False, True):
                part = [row[key] for row in rows if row["wind"] == wind
                        and (row["zenith"] > last) == far
                        and row[key]["verdict"] != "dim"]
                if not part:
                    continue
                d = sorted((entry["difference"] for entry in part), key=abs)
                count = [sum(entry["verdict"] == v for entry in part)
                         for v in ("pass", "open", "FAIL")]
                lines.append(
                    f"| {wind:g} | {what} | {'over' if far else 'to'} {last} "
                    f"| {len(part)} | {count[0]} | {count[1]} | {count[2]} "
                    f"| {abs(d[len(d) // 2]):.1%} | {d[-1]:+.1%} |")
    return lines


def paper_rows(paper):
    """The same pictures by a daemon that draws as the paper has it."""
    if not paper:
        return lambda *_: None
    ocean = pelagos.Ocean(paper.url(), timeout=600)
    return lambda wind, setup: drawn(
        paper, ocean, wind, setup | {"pictures": setup["papers"]})


def paper_lines(rows):
    """Against the reference: ours and the paper's form, of rows not dim."""
    lines = ["| wind | layer | zenith | rows | ours: median | worst "
             "| the paper's form: median | worst |", "|" + "---|" * 8]
    for wind in sorted({row["wind"] for row in rows}):
        for key, what in (("sky550", "sky"), ("sun550", "Sun")):
            for low, high in ((0, 60), (60, 80), (80, 90)):
                part = [row[key] for row in rows if row["wind"] == wind
                        and low < row["zenith"] <= high
                        and row[key]["verdict"] != "dim"]
                if not part:
                    continue
                text = f"| {wind:g} | {what} | {low} to {high} | {len(part)} |"
                for name in ("ours", "paper"):
                    d = sorted((e[name] / e["reference"] - 1 for e in part),
                               key=abs)
                    text += f" {abs(d[len(d) // 2]):.1%} | {d[-1]:+.1%} |"
                lines.append(text)
    return lines


def save_plots(rows, name):
    """Radiance over the zenith angle of the eye's ray: for each wind and Sun,
    ahead, the sky's layer and the Sun's."""
    for key, what in (("sky550", "sky"), ("sun550", "sun")):
        panels = []
        for wind in sorted({row["wind"] for row in rows}):
            for sun in sorted({row["sun"] for row in rows}):
                part = [row for row in rows if row["azimuth"] == "ahead"
                        and (row["wind"], row["sun"]) == (wind, sun)]
                curves = {which: [(row["zenith"], row[key][which])
                                  for row in part if which in row[key]]
                          for which in ("reference", "ours", "paper")}
                panels.append((f"{wind:g} m/s, Sun {sun:g}°", curves))
        svgplot.save(f"{name}-{what}.svg", panels, xlabel="zenith angle, °",
                     ylabel="W m⁻² sr⁻¹ nm⁻¹", columns=3, log=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--assert", dest="check", nargs="?",
                        choices=("all", "flat"), const="all",
                        help="flat: only for the flat sea's table")
    parser.add_argument("--spectrum", choices=SPECTRA, default="pm")
    parser.add_argument("--linear", action="store_true",
                        help="the reference's crests are not sharpened")
    parser.add_argument("--times", type=int, default=1,
                        help="so many times the rays and facets")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--slant", type=float, default=2000)
    parser.add_argument("--rounds", type=int, default=6,
                        help="rays and pictures of rows that are still open, "
                        "so many times at most")
    for name in ("winds", "suns", "zeniths"):
        parser.add_argument(f"--{name}", help="these alone, whole, with commas")
    parser.add_argument("--no-paper", action="store_true",
                        help="without the paper's form (so is --quick)")
    options = parser.parse_args()
    setup = {"winds": (2, 7, 12), "suns": (10, 35, 60),
             "zeniths": (30, 45, 60, 70, 75, 80, 85, 88), "pictures": 32,
             "papers": 8, "realisations": 16, "rays": 1000,
             "facets": 500000, "rounds": options.rounds,
             "slant": options.slant, "jobs": options.jobs,
             "chop": int(not options.linear)}
    if options.quick:
        setup |= {"winds": (2, 12), "suns": (10, 35),
                  "zeniths": (45, 70, 80, 88), "pictures": 4,
                  "realisations": 4, "rays": 500, "facets": 100000,
                  "rounds": 1, "jobs": 1}
    if options.linear:  # a ray costs a twentieth
        setup["rays"] *= 8
        setup["facets"] *= 8
    setup["rays"] *= options.times
    setup["facets"] *= options.times
    for name in ("winds", "suns", "zeniths"):
        if text := getattr(options, name):
            setup[name] = [int(word) for word in text.split(",")]
    os.nice(max(0, 10 - os.nice(0)))
    run(options, setup)


def run(options, setup):
    lines, rows = [], []

    def show(line=""):
        lines.append(line)
        print(line, flush=True)

    with contextlib.ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        daemon = stack.enter_context(Daemon())
        paper = None
        if not (options.quick or options.no_paper):
            os.environ["PELAGOS_REFLECTION"] = "paper"
            paper = stack.enter_context(Daemon())
            del os.environ["PELAGOS_REFLECTION"]
            change(paper, base_state(options.spectrum))
        as_paper = paper_rows(paper)
        ocean = pelagos.Ocean(daemon.url(), timeout=600)
        change(daemon, base_state(options.spectrum))
        skies = {sun: take_sky(daemon, ocean, sun) for sun in setup["suns"]}
        path = os.path.join(folder, "skies")
        write_skies(path, skies)
        seas = []
        # Rays of every wind while the pictures are drawn.
        rays = stack.enter_context(
            concurrent.futures.ThreadPoolExecutor(max_workers=1))
        tracing = [rays.submit(traced, wind, options.spectrum, path, setup)
                   for wind in setup["winds"]]
        for wind, trace in zip(setup["winds"], tracing):
            ours = drawn(daemon, ocean, wind, setup)
            paper_form = as_paper(wind, setup)
            found = trace.result()
            new = table_of(wind, setup, skies, ours, found, paper_form)
            for again in range(1, setup["rounds"]):
                places, noisy = open_rows(new)
                if not places:
                    break
                more = rays.submit(traced, wind, options.spectrum, path, setup,
                                   noisy, again + 1) if noisy else None
                drawn(daemon, ocean, wind, setup, places,
                      again * setup["pictures"], ours)
                if more:
                    join(found, more.result(), 1 / (again + 1))
                new = table_of(wind, setup, skies, ours, found, paper_form)
            if not rows:
                show(HEAD)
            for row in new:
                show(text_of(row))
            rows += new
            seas.append(sea_lines(wind, found))
        show()
        for line in seas:
            show(line)
        show()
        for line in summary(rows):
            show(line)
        if paper:
            show()
            for line in paper_lines(rows):
                show(line)
        index = found["sea"]["index"][0]
        flat = flat_table(daemon, ocean, index)
    show()
    show(f"A flat sea, n = {index:.4f} (Quan and Fry 1995):\n\n| zenith | ours |"
         " exact | differs | bar | |\n" + "|" + "---|" * 6)
    for row in flat:
        show(f"| {row['zenith']:g} | {row['ours']:.5f} | {row['exact']:.5f} "
             f"| {row['difference']:+.2%} | {FLAT_BAR:.1%} "
             f"| {row['verdict']} |")
    lost = max(row["fresnel"]["lost"] for row in rows)
    closed = max(abs(row["fresnel"]["closed"] - 1) for row in rows)
    show(f"\nRays given up: {lost:.0e} at most. White sky and white water: "
         f"1 within {closed:.0e}.")
    folder = os.path.join(ROOT, "build", "validate",
                          "quick" if options.quick else "")
    os.makedirs(folder, exist_ok=True)
    name = os.path.join(folder, f"seatrace-{options.spectrum}"
                        + ("-linear" if options.linear else ""))
    with open(name + ".md", "w", encoding="utf-8") as f:
        f.write("\n".join(lines) + "\n")
    with open(name + ".json", "w", encoding="utf-8") as f:
        json.dump({"rows": rows, "flat": flat}, f, default=float)
    save_plots(rows, name)
    failed = sum(entry["verdict"] == "FAIL" for row in rows
                 for entry in (row["sky550"], row["sun550"]))
    flat_failed = sum(row["verdict"] == "FAIL" for row in flat)
    print(f"\n{failed + flat_failed} rows fail; {name}.md has the table")
    sys.exit(3 if flat_failed and options.check
             or failed and options.check == "all" else 0)


if __name__ == "__main__":
    main()
