#!/usr/bin/python3
"""A ship's mirror image and shadow, and its hull seen through the water,
against rays over realised seas (shiptrace.c).

    shiptrace.py [--quick] [--assert] [--times N] [--wind W…]

A hull of 30 m lies 200 m away. Pictures of the program, of many seeds with the
ship and without it, and rays over realised seas with and without it are compared
line by line: the radiance of the sea, summed over the columns in which the
reference sees something of the ship in the sea, without its own pixels. Both
sides take the sea without the ship from the program, so that the ship alone is
judged. Taken from the program are also its sky, the Sun's irradiance and the
radiance of its water, which have references of their own. Bar: 5 % of a line's
energy. Prints a table, leaves it with its figures and pictures in
build/validate/ (quick: in its quick/).
"""
import argparse
import concurrent.futures
import json
import math
import os
import subprocess
import sys
import tempfile

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(HERE)))
sys.path[:0] = [os.path.join(ROOT, "tests"),
                os.path.join(ROOT, "clients", "python"),
                os.path.join(ROOT, "tests", "validate", "seatrace"), HERE]
import pelagos  # noqa: E402
import seatrace  # noqa: E402
import shipmodel  # noqa: E402
import shippicture  # noqa: E402
from pelagos_daemon import BIN, Daemon  # noqa: E402

EYE, AWAY, FIELD, WIDE, HIGH, PITCH = 12.0, 200.0, 16.0, 448, 252, -4.0
HEADING, WIND_FROM, ELEVATION = 60, 240, 25
SUNS = {"ahead": 0, "abeam": 90, "behind": 180}
WINDS = (3, 12)
ABSORPTION, SCATTERING = (0.4, 0.1, 0.12), 0.3
BACKSCATTERED = 0.017  # of the scattering: /v1/optics/water of this water
BAR = 0.05
# struct ship_sight: name, shape.
S, C = 3, 3
FIELDS = (("direct", ()), ("body", (S, C)), ("mirrors", ()), ("sky", (S, C)),
          ("with", (S, C)), ("sunny", (S,)), ("lit", (S, C)), ("open", (C,)),
          ("wet", ()), ("hull", (S, C)))
LAYERS = ["sky", "sun", "water", "id"]


def view(name, **more):
    return {"name": name, "forward": -AWAY, "up": EYE, "pitch": PITCH,
            "fieldOfView": FIELD, "width": WIDE, "height": HIGH,
            "antialiasing": False, **more}


def base_state():
    water = {f"{what}{nm}": value for what, values in
             (("absorption", ABSORPTION), ("scattering", [SCATTERING] * 3))
             for nm, value in zip(("680", "550", "440"), values)}
    return {"clock": {"mode": "STEPPED", "time": 0},
            "sea": {"spectrum": "PIERSON_MOSKOWITZ", "fetch": 2e6,
                    "synthesiser": "FFT", "whitecaps": 0,
                    "windDirection": WIND_FROM},
            "water": water,
            "sky": {"sunAzimuth": 0, "visibility": 300000,
                    "sunElevation": ELEVATION}}


def put_ship(daemon, here):
    seatrace.change(daemon, {"entities": [{
        "id": 1, "heading": HEADING, "latitude": 52.6 if here else 62.6,
        "longitude": 5.2, "altitude": 0, "model": {"name": "ship.gltf"}}]})


# --- the program ------------------------------------------------------------

def drawn(daemon, ocean, wind, count):
    """{(sun, with): {layer: sums over seeds of (lines, columns, 3)}}, and the
    change of each seed."""
    found = {}
    seatrace.change(daemon, {"views": None})
    seatrace.change(daemon, {"views": [view("v")]})
    for seed in range(count):
        seatrace.change(daemon, {"sea": {"windSpeed": wind,
                                         "seed": 500 + seed}})
        for sun, azimuth in SUNS.items():
            seatrace.change(daemon, {"sky": {"sunAzimuth": azimuth}})
            for here in (False, True):
                put_ship(daemon, here)
                picture = ocean.frame("v", "exr", layers=LAYERS,
                                      float_samples=True,
                                      time=7.0 * seed).exr()
                found.setdefault((sun, here), []).append(
                    {name: np.asarray(picture[name], dtype=np.float32)
                     for name in LAYERS})
    return {key: {name: np.stack([p[name] for p in pictures])
                  for name in LAYERS} for key, pictures in found.items()}


# --- the reference ----------------------------------------------------------

def placed_mesh():
    corners, albedo = shipmodel.triangles()
    h = math.radians(HEADING)
    c, s = math.cos(h), math.sin(h)
    turned = np.stack([c * corners[..., 0] + s * corners[..., 1],
                       -s * corners[..., 0] + c * corners[..., 1],
                       corners[..., 2]], -1)
    return np.concatenate([turned.reshape(-1, 9), albedo[:, None]], 1)


def traced(wind, setup, sky, irradiance, water, skip, columns, folder):
    mesh_path = os.path.join(folder, f"mesh{wind}")
    sky_path = os.path.join(folder, f"sky{wind}")
    placed_mesh().astype("<f8").tofile(mesh_path)
    sky.astype("<f8").tofile(sky_path)
    fade = [a + BACKSCATTERED * SCATTERING for a in ABSORPTION]
    text = " ".join(str(word) for word in (
        "wind", wind, "fetch", 2e6, "chop", 0, "to", -(WIND_FROM + 180),
        "realisations", setup["realisations"], "rays", setup["rays"],
        "seed", 7, "nodes", 512, "eye", -AWAY, 0, EYE, "pitch", PITCH,
        "field", FIELD, "width", WIDE, "height", HIGH, "skip", skip,
        "columns", *columns, "elevation", ELEVATION, "irradiance",
        *irradiance, "water", *water, "fade", *fade, "suns", len(SUNS),
        "azimuths", *(-a for a in SUNS.values()), "sky", sky_path, "mesh",
        mesh_path))
    done = subprocess.run([os.path.join(BIN, "shiptrace")],
                          input=text.encode(), stdout=subprocess.PIPE,
                          check=True)
    values = np.frombuffer(done.stdout, "<f4").reshape(
        setup["realisations"], HIGH - skip, columns[1] - columns[0], -1)
    found, at = {}, 0
    for name, shape in FIELDS:
        size = int(np.prod(shape))
        found[name] = values[..., at:at + size].reshape(
            *values.shape[:3], *shape)
        at += size
    return found


# --- comparison -------------------------------------------------------------

def sky_share(sky, irradiance):
    """Of the light that enters a flat sea, the Sun's share, by channel."""
    height = np.radians(90 * (np.arange(121) / 120) ** 2)
    ring = np.sin(height) * np.cos(height)
    diffuse = 2 * math.pi * np.trapz(
        sky.mean(1) * (ring * 0.96)[:, None], height, axis=0)
    s = math.sin(math.radians(ELEVATION))
    inside = math.sqrt(1 - (1 - s * s) / 1.34 ** 2)
    mirrored = 0.5 * (((s - 1.34 * inside) / (s + 1.34 * inside)) ** 2
                      + ((1.34 * s - inside) / (1.34 * s + inside)) ** 2)
    direct = np.array(irradiance) * s * (1 - mirrored)
    return direct / (direct + diffuse)


def smooth(mean):
    """The sea without the ship: the mean over 31 columns."""
    sums = np.cumsum(np.pad(mean, ((0, 0), (16, 15), (0, 0)), "edge"), 1)
    return (sums[:, 31:] - sums[:, :-31]) / 31


def reference_change(found, s, plain, share):
    """Change of the sea's radiance by the ship: (realisations, lines, columns,
    3) each of mirror, shadow in the glitter, shadow in the water with the hull
    seen through it. Rays that meet the ship count nowhere."""
    sea = (1 - found["direct"])[..., None]
    left = share * found["lit"][..., s, :] + (1 - share) * found["open"]
    return {"mirror": found["with"][..., s, :] - found["sky"][..., s, :],
            "glitter": (found["sunny"][..., s, None] - sea) * plain["sun"],
            "water": ((left - sea) * plain["water"]
                      + found["hull"][..., s, :])}


def our_change(pictures, sun, cut):
    """The same of the program, and where it shows the sea."""
    after = {k: v[cut] for k, v in pictures[sun, True].items()}
    before = {k: v[cut] for k, v in pictures[sun, False].items()}
    sea = (after["id"].reshape(after["sky"].shape[:3]) == 0)[..., None]
    return {name: (after[layer] - before[layer]) * sea
            for name, layer in (("mirror", "sky"), ("glitter", "sun"),
                                ("water", "water"))}, sea, after, before


def mean_noise(values):
    return values.mean(0), values.std(0, ddof=1) / math.sqrt(len(values))


def compare(wind, sun, s, pictures, found, skip, columns, share):
    """Rows of lines, and what the pictures show. A line is of the columns that
    the ship spans, and judged where the reference sees 5 % of it changed and
    15 % of it are sea. Differences are parts of the line's energy, at least of
    half of what it is without the ship."""
    cut = (slice(None), slice(skip, None), slice(*columns))
    ours, our_sea, after, before = our_change(pictures, sun, cut)
    plain = {k: smooth(before[k].mean(0)) for k in ("sky", "sun", "water")}
    base = sum(plain.values())
    theirs = reference_change(found, s, plain, share)
    sea = 1 - found["direct"]
    touched = (found["mirrors"] + found["wet"] + sea
               - found["sunny"][..., s]).mean(0)
    rows = []
    span = slice(18, -36)  # of the columns: the ship's
    for line in range(touched.shape[0]):
        if (touched[line, span].sum() < 0.05 * sea.mean(0)[line, span].sum()
                or sea.mean(0)[line, span].mean() < 0.15):
            continue
        row = {"wind": wind, "sun": sun, "line": line + skip}
        energies = [(part * base)[:, line, span].sum((1)).mean(0)
                    for part in (our_sea, sea[..., None])]
        for name in ours:
            row[name] = [(change[name][:, line, span].sum(1) / energy).mean(0)
                         for change, energy in zip((ours, theirs), energies)]
        both = [mean_noise(sum(change.values())[:, line, span].sum(1) / energy)
                for change, energy in zip((ours, theirs), energies)]
        row["ours"], row["reference"] = both[0][0], both[1][0]
        # Of a line in full shadow little is left to divide by.
        left = np.maximum(1 + both[1][0], 0.5)
        row["difference"] = (both[0][0] - both[1][0]) / left
        row["noise"] = np.hypot(both[0][1], both[1][1]) / left
        rows.append(row)
    layers = ("sky", "sun", "water")
    there = sea[..., None] * base + sum(theirs.values())
    there += found["body"][..., s, :]
    return rows, {"ours": sum(after[k].mean(0) for k in layers),
                  "reference": there.mean(0),
                  "one": sum(after[k][0] for k in layers)}


HEAD = ("| wind | Sun | lines | off: median | worst | noise | mirror: ours, "
        "reference | glitter | water | over 5 % | |\n|" + "---|" * 11)


def summary(rows, wind, sun, channel=1):
    part = [r for r in rows if (r["wind"], r["sun"]) == (wind, sun)]
    off = np.array([abs(r["difference"][channel]) for r in part])
    noise = np.array([r["noise"][channel] for r in part])

    def both(name):
        a, b = (np.mean([r[name][i][channel] for r in part]) for i in (0, 1))
        return f"{a:+.1%}, {b:+.1%}"

    over = int((off - 2 * noise > BAR).sum())
    return {"wind": wind, "sun": sun, "lines": len(part),
            "median": float(np.median(off)), "worst": float(off.max()),
            "noise": float(np.median(noise)), "over": over,
            "beyond": int((off > BAR).sum()),
            "mirror": both("mirror"), "glitter": both("glitter"),
            "water": both("water")}


def text_of(s):
    return (f"| {s['wind']} | {s['sun']} | {s['lines']} | {s['median']:.1%} | "
            f"{s['worst']:.1%} | {s['noise']:.1%} | {s['mirror']} | "
            f"{s['glitter']} | {s['water']} | {s['beyond']}, beyond noise "
            f"{s['over']} | {'FAIL' if s['over'] else 'pass'} |")


def run(options, setup, folder):
    os.makedirs(folder, exist_ok=True)
    lines, rows, sums, shown = [HEAD], [], [], {}
    print(HEAD, flush=True)
    with tempfile.TemporaryDirectory() as scratch:
        models = os.path.join(scratch, "models")
        os.mkdir(models)
        for name, text in (("ship.gltf", shipmodel.gltf()),
                           ("ship.json", shipmodel.DESCRIPTION)):
            with open(os.path.join(models, name), "w", encoding="utf-8") as f:
                f.write(text)
        with Daemon("--models", models) as daemon:
            ocean = pelagos.Ocean(daemon.url(), timeout=600)
            seatrace.change(daemon, base_state())
            sky = seatrace.take_sky(daemon, ocean, ELEVATION)[1]
            answer = daemon.get(
                f"/v1/optics/sky?height=2&elevation=90&azimuth=0"
                f"&sky.sunElevation={ELEVATION}").json()
            irradiance = answer["sky"]["sunIrradiance"]
            put_ship(daemon, False)
            skip, columns = 96, (90, 358)
            seatrace.change(daemon, {"views": None})
            seatrace.change(daemon, {"views": [view("v")],
                                     "sea": {"windSpeed": options.wind[0]}})
            water = np.asarray(ocean.frame("v", "exr", layers=["water"])
                               .exr()["water"])[skip:].mean((0, 1)).tolist()
            share = sky_share(sky, irradiance)
            with concurrent.futures.ThreadPoolExecutor(1) as pool:
                tracing = {wind: pool.submit(
                    traced, wind, setup, sky, irradiance, water, skip,
                    columns, scratch) for wind in options.wind}
                for wind in options.wind:
                    pictures = drawn(daemon, ocean, wind, setup["pictures"])
                    found = tracing[wind].result()
                    for s, sun in enumerate(SUNS):
                        new, shown[wind, sun] = compare(
                            wind, sun, s, pictures, found, skip, columns,
                            share)
                        rows += new
                        sums.append(summary(rows, wind, sun))
                        lines.append(text_of(sums[-1]))
                        print(lines[-1], flush=True)
    shippicture.save(os.path.join(folder, "shiptrace.png"), shown)
    with open(os.path.join(folder, "shiptrace.md"), "w",
              encoding="utf-8") as f:
        f.write("\n".join(lines) + "\n")
    with open(os.path.join(folder, "shiptrace.json"), "w",
              encoding="utf-8") as f:
        json.dump({"rows": rows, "sums": sums}, f,
                  default=lambda v: v.tolist() if hasattr(v, "tolist")
                  else float(v))
    return sum(s["over"] for s in sums)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--assert", dest="check", action="store_true")
    parser.add_argument("--times", type=int, default=1)
    parser.add_argument("--wind", type=int, nargs="+", default=list(WINDS))
    options = parser.parse_args()
    os.nice(max(0, 10 - os.nice(0)))
    setup = ({"pictures": 6, "realisations": 4, "rays": 8} if options.quick
             else {"pictures": 32 * options.times,
                   "realisations": 32 * options.times, "rays": 4})
    folder = os.path.join(ROOT, "build", "validate",
                          "quick" if options.quick else "")
    failed = run(options, setup, folder)
    print(f"\n{failed} lines fail")
    return 3 if options.check and failed else 0


if __name__ == "__main__":
    sys.exit(main())
