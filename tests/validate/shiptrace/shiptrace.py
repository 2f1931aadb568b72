#!/usr/bin/python3
"""A ship's mirror image and shadow, and its hull seen through the water,
against rays over realised seas (shiptrace.c).

    shiptrace.py [--quick] [--assert] [--times N] [--wind W…]
                 [--look mirror|keel…]

A hull of 30 m lies 200 m away, where the sea mirrors it, and 45 m below and
before the eye, where its keel is seen through the water. Pictures of the
program, of many seeds with the ship and without it, and rays over realised seas
with and without it are compared line by line: the radiance of the sea, summed
over the columns that the ship spans, without the pixels that show the ship in
any picture of either side, and without those next to them. Both sides take the
sea without the ship from the program, so that the ship alone is judged; what the
reference mirrors counts by the sky that it mirrors in the same seas. Taken from
the program are also its sky, the Sun's irradiance and the radiance of its water,
which have references of their own. Bar: 5 % of a line's energy. Prints a table,
leaves it with its figures and pictures in build/validate/ (quick: in its
quick/).
"""
import argparse
import collections
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

Look = collections.namedtuple(
    "Look", "eye away field wide high pitch skip columns span rays")
LOOKS = {
    "mirror": Look(12.0, 200.0, 16.0, 448, 252, -4.0, 96, (90, 358), (18, 232),
                   1),
    "keel": Look(45.0, 45.0, 16.0, 448, 252, -48.0, 40, (100, 348), (0, 248),
                 0.5)}
HEADING, WIND_FROM, ELEVATION = 60, 240, 25
SUNS = {"ahead": 0, "abeam": 90, "behind": 180}
CALM = 0.3  # m/s: waves of a millimetre
# At 12 m/s waves leave no line in which most rays go to the hull under water.
WINDS = {"mirror": (3, 12), "keel": (CALM, 3)}
ABSORPTION, SCATTERING = (0.4, 0.1, 0.12), 0.3
BACKSCATTERED = 0.017  # of the scattering: /v1/optics/water of this water
BAR = 0.05
# struct ship_sight: name, shape.
S, C = 3, 3
FIELDS = (("direct", ()), ("body", (S, C)), ("mirrors", ()), ("sky", (S, C)),
          ("with", (S, C)), ("sunny", (S,)), ("lit", (S, C)), ("open", (C,)),
          ("wet", ()), ("hull", (S, C)))
LAYERS = ["sky", "sun", "water", "id"]


def view(look):
    return {"name": "v", "forward": -look.away, "up": look.eye,
            "pitch": look.pitch, "fieldOfView": look.field,
            "width": look.wide, "height": look.high, "antialiasing": False}


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

def drawn(daemon, ocean, look, wind, count):
    """{(sun, with): {layer: sums over seeds of (lines, columns, 3)}}, and the
    change of each seed."""
    found = {}
    seatrace.change(daemon, {"views": None})
    seatrace.change(daemon, {"views": [view(look)]})
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


def traced(look, wind, setup, sky, irradiance, water, folder):
    mesh_path = os.path.join(folder, f"mesh{wind}{look.eye}")
    sky_path = os.path.join(folder, f"sky{wind}{look.eye}")
    placed_mesh().astype("<f8").tofile(mesh_path)
    sky.astype("<f8").tofile(sky_path)
    columns, rays = look.columns, max(1, int(setup["rays"] * look.rays))
    fade = [a + BACKSCATTERED * SCATTERING for a in ABSORPTION]
    text = " ".join(str(word) for word in (
        "wind", wind, "fetch", 2e6, "chop", 0, "to", -(WIND_FROM + 180),
        "realisations", setup["realisations"], "rays", rays,
        "seed", 7, "nodes", 512, "eye", -look.away, 0, look.eye,
        "pitch", look.pitch, "field", look.field, "width", look.wide,
        "height", look.high, "skip", look.skip,
        "columns", *columns, "elevation", ELEVATION, "irradiance",
        *irradiance, "water", *water, "fade", *fade, "suns", len(SUNS),
        "azimuths", *(-a for a in SUNS.values()), "sky", sky_path, "mesh",
        mesh_path))
    done = subprocess.run([os.path.join(BIN, "shiptrace")],
                          input=text.encode(), stdout=subprocess.PIPE,
                          check=True)
    values = np.frombuffer(done.stdout, "<f4").reshape(
        setup["realisations"], look.high - look.skip, columns[1] - columns[0], -1)
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


def our_change(after, before):
    """The same of the program."""
    return {name: after[layer] - before[layer]
            for name, layer in (("mirror", "sky"), ("glitter", "sun"),
                                ("water", "water"))}


def mean_noise(values):
    return values.mean(0), values.std(0, ddof=1) / math.sqrt(len(values))


def beside_ship(ids, direct):
    """Pixels that show the ship nowhere, nor does one next to them: an edge is
    mixed there by samples that the reference does not have."""
    ship = (ids != 0).any(0) | (direct.max(0) > 0)
    for axis in (0, 1):
        ship = ship | np.roll(ship, 1, axis) | np.roll(ship, -1, axis)
    return ~ship


def shares(change, sky, whole):
    """A line's changes of pictures or seas as parts of its energy, (n, 3); of
    what is mirrored the sky in the same seas is the measure."""
    mirror = change["mirror"].sum(1)
    sky = sky.sum(1)
    ratio = mirror.mean(0) / sky.mean(0)
    rest = (change["glitter"] + change["water"]).sum(1) / whole[0]
    return (rest + whole[1] * (ratio + (mirror - ratio * sky) / sky.mean(0)))


def compare(look, wind, sun, s, pictures, found, share):
    """Rows of lines, and what the pictures show. A line is judged where the
    reference sees 5 % of it changed and 15 % of its columns are left; of the
    keel the pixels that see it.
    Differences are parts of the line's energy, at least of half of what it is
    without the ship."""
    cut = (slice(None), slice(look.skip, None), slice(*look.columns))
    after, before = ({k: v[cut] for k, v in pictures[sun, here].items()}
                     for here in (True, False))
    ids = after["id"].reshape(after["sky"].shape[:3])
    plain = {k: smooth(before[k].mean(0)) for k in ("sky", "sun", "water")}
    base = sum(plain.values())
    theirs = reference_change(found, s, plain, share)
    ours = our_change(after, before)
    left_sea = beside_ship(ids, found["direct"])
    keel = look is LOOKS["keel"]
    touched = (found["wet"] if keel else
               found["mirrors"] + found["wet"] + 1 - found["direct"]
               - found["sunny"][..., s]).mean(0)
    if keel:  # where it is seen, a few dozen pixels of a line
        left_sea &= touched > 0.3
    rows = []
    for line in range(touched.shape[0]):
        here = np.zeros(touched.shape[1], bool)
        here[look.span[0]:look.span[1]] = True
        here &= left_sea[line]
        least = 0.02 if keel else 0.15
        if (here.sum() < least * (look.span[1] - look.span[0])
                or touched[line, here].mean() < 0.05):
            continue
        row = {"look": "keel" if keel else "mirror", "wind": wind, "sun": sun,
               "line": line + look.skip}

        def of(values):
            return values[..., line, :, :][..., here, :]

        whole = of(base).sum(0)
        sky_part = of(plain["sky"]).sum(0) / whole
        both = []
        for change, sky in ((ours, before["sky"]),
                            (theirs, found["sky"][..., s, :])):
            parts = {k: of(v) for k, v in change.items()}
            both.append(mean_noise(shares(parts, of(sky), (whole, sky_part))))
            for k, v in parts.items():
                by = of(sky).sum(1).mean(0) / sky_part if k == "mirror" \
                    else whole
                row.setdefault(k, []).append(v.sum(1).mean(0) / by)
        row["ours"], row["reference"] = both[0][0], both[1][0]
        # Of a line in full shadow little is left to divide by.
        left = np.maximum(1 + both[1][0], 0.5)
        row["difference"] = (both[0][0] - both[1][0]) / left
        row["noise"] = np.hypot(both[0][1], both[1][1]) / left
        rows.append(row)
    layers = ("sky", "sun", "water")
    sea = 1 - found["direct"]
    there = sea[..., None] * base + sum(theirs.values())
    there += found["body"][..., s, :]
    return rows, {"ours": sum(after[k].mean(0) for k in layers),
                  "reference": there.mean(0),
                  "one": sum(after[k][0] for k in layers)}


HEAD = ("| look | wind | Sun | lines | off: median | worst | noise | mirror: ours, "
        "reference | glitter | water | over 5 % | |\n|" + "---|" * 12)


def summary(rows, look, wind, sun, channel=1):
    part = [r for r in rows
            if (r["look"], r["wind"], r["sun"]) == (look, wind, sun)]
    off = np.array([abs(r["difference"][channel]) for r in part])
    noise = np.array([r["noise"][channel] for r in part])

    def both(name):
        a, b = (np.mean([r[name][i][channel] for r in part]) for i in (0, 1))
        return f"{a:+.1%}, {b:+.1%}"

    over = int((off - 2 * noise > BAR).sum())
    return {"look": look, "wind": wind, "sun": sun, "lines": len(part),
            "median": float(np.median(off)), "worst": float(off.max()),
            "noise": float(np.median(noise)), "over": over,
            "beyond": int((off > BAR).sum()),
            "mirror": both("mirror"), "glitter": both("glitter"),
            "water": both("water")}


def text_of(s):
    return (f"| {s['look']} | {s['wind']:g} | {s['sun']} | {s['lines']} | {s['median']:.1%} | "
            f"{s['worst']:.1%} | {s['noise']:.1%} | {s['mirror']} | "
            f"{s['glitter']} | {s['water']} | {s['beyond']}, beyond noise "
            f"{s['over']} | {'FAIL' if s['over'] else 'pass'} |")


def plain_water(daemon, ocean, look, wind):
    """Mean radiance that leaves the water."""
    seatrace.change(daemon, {"views": None})
    seatrace.change(daemon, {"views": [view(look)], "sea": {"windSpeed": wind}})
    layer = ocean.frame("v", "exr", layers=["water"]).exr()["water"]
    return np.asarray(layer)[look.skip:].mean((0, 1)).tolist()


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
            share = sky_share(sky, irradiance)
            with concurrent.futures.ThreadPoolExecutor(1) as pool:
                tracing = {}
                for kind in options.look:
                    look = LOOKS[kind]
                    winds = options.wind or WINDS[kind][:1 if options.quick else None]
                    water = plain_water(daemon, ocean, look, winds[0])
                    for wind in winds:
                        tracing[kind, wind] = pool.submit(
                            traced, look, wind, setup, sky, irradiance, water,
                            scratch)
                for (kind, wind), job in tracing.items():
                    look = LOOKS[kind]
                    pictures = drawn(daemon, ocean, look, wind,
                                     setup["pictures"])
                    found = job.result()
                    for s, sun in enumerate(SUNS):
                        new, shown[kind, wind, sun] = compare(
                            look, wind, sun, s, pictures, found, share)
                        rows += new
                        sums.append(summary(rows, kind, wind, sun))
                        lines.append(text_of(sums[-1]))
                        print(lines[-1], flush=True)
    for kind in options.look:
        name = "shiptrace.jpg" if kind == "mirror" else f"shiptrace-{kind}.jpg"
        shippicture.save(os.path.join(folder, name),
                         {k: v for k, v in shown.items() if k[0] == kind})
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
    parser.add_argument("--wind", type=float, nargs="+")
    parser.add_argument("--look", nargs="+", choices=list(LOOKS))
    options = parser.parse_args()
    options.look = options.look or (["mirror"] if options.quick
                                    else list(LOOKS))
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
