#!/usr/bin/env python3
"""A ship's bridge with five windows, 225 degrees across: five views of one
eye with off-axis frusta, as five screens would show them, drawn of one moment;
stitches them to one panorama and checks that neighbours meet.

    bridge.py --out panorama.png [--url http://127.0.0.1:8080]

(`make bridge` starts a daemon for it as well.) With --live it also watches the
five windows, and checks that the pictures of one frame have the same number,
simulated time and time of presentation in each.

A screen's frustum is off-axis where the eye does not stand before its middle:
the axis goes through the foot of the perpendicular, the window spans from
`left` to `right` of that. Neighbours meet where yaw + right of the one is
yaw + left of the next.
"""
from __future__ import annotations

import argparse
import contextlib
import math
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pelagos import Camera, Exr, Frame, LiveFrame, Ocean, PelagosError

Array = NDArray[Any]
ACROSS = 45.0
TOP, BOTTOM = 12.0, -25.0
# Window: its middle and the foot of its perpendicular, from the bow [deg].
WINDOWS = {"port-wing": (-90, -84), "port": (-45, -48), "ahead": (0, 0),
           "starboard": (45, 48), "starboard-wing": (90, 84)}
# Tangents travel as single floats, poses too: a few of their 6e-8.
RAY_TOLERANCE_RAD = 2e-6
EYE_TOLERANCE_M = 1e-4
# The server's two clocks are read once for each picture that it sends.
PRESENT_TOLERANCE_S = 1e-3
# Waves shorter than a pixel differ from one column to the next: over moments
# of a sea at 12 m/s the fit's standard deviation is 0.07 px.
FIT_TOLERANCE_PX = 0.25
DARK = 1e-12


def add_windows(ocean: Ocean, entity: int, width: int, height: int) -> None:
    """All in one patch: they come together."""
    ocean.patch({"views": {
        name: {"entity": entity, "forward": 10, "right": 0, "up": 18,
               "yaw": foot, "pitch": 0, "roll": 0,
               "width": width, "height": height, "meter": "bridge",
               "frustum": {"left": middle - foot - ACROSS / 2,
                           "right": middle - foot + ACROSS / 2,
                           "top": TOP, "bottom": BOTTOM}}
        for name, (middle, foot) in WINDOWS.items()}})


def edge_normal(camera: Camera, right: bool) -> Array:
    """Of the plane through the eye and the right or left edge, in the world:
    unit, (3,)."""
    i = camera.intrinsics
    x = i.right if right else i.left
    rays = np.array([[x, -i.top, 1.0], [x, -i.bottom, 1.0]]) @ camera.rotation
    normal = np.cross(rays[0], rays[1])
    return normal / np.linalg.norm(normal)


def sample(picture: Array, camera: Camera, rays: Array
           ) -> Array:
    """The picture along rays of the world, (..., 3), bilinear; NaN outside."""
    u, v = np.moveaxis(camera.project(camera.position + rays), -1, 0)
    height, width = picture.shape[:2]
    # Edges belong to the picture: half a pixel beyond the last centre.
    inside = (u >= 0) & (u <= width) & (v >= 0) & (v <= height)
    x = np.clip(np.where(inside, u, 0) - 0.5, 0, width - 1)
    y = np.clip(np.where(inside, v, 0) - 0.5, 0, height - 1)
    x0, y0 = (np.minimum(a.astype(int), n - 2)
              for a, n in ((x, width), (y, height)))
    fx, fy = (x - x0)[..., None], (y - y0)[..., None]
    out = ((picture[y0, x0] * (1 - fx) + picture[y0, x0 + 1] * fx) * (1 - fy)
           + (picture[y0 + 1, x0] * (1 - fx)
              + picture[y0 + 1, x0 + 1] * fx) * fy)
    return np.where(inside[..., None], out, np.nan)


def panorama_rays(ahead: Camera, width: int) -> Array:
    """Rays of a cylinder round the ship's upright, (height, width, 3)."""
    azimuth = np.radians(225) * ((np.arange(width) + 0.5) / width - 0.5)
    # The windows are lowest where they are farthest from their foot: what all
    # of them show, at every azimuth.
    widest = math.cos(math.radians(ACROSS / 2 + 6))
    top = math.tan(math.radians(TOP)) * widest
    bottom = math.tan(math.radians(BOTTOM)) * widest
    pitch = np.radians(225) / width
    rows = np.arange(top, bottom, -pitch)
    rays = np.empty((len(rows), width, 3))
    rays[..., 0] = np.sin(azimuth)[None, :]
    rays[..., 1] = -rows[:, None]
    rays[..., 2] = np.cos(azimuth)[None, :]
    return rays @ ahead.rotation


def stitch(images: dict[str, Array], cameras: dict[str, Camera],
           width: int) -> Array:
    rays = panorama_rays(cameras["ahead"], width)
    out = np.full(rays.shape, np.nan)
    for name in WINDOWS:
        part = sample(images[name].astype(float), cameras[name], rays)
        out = np.where(np.isnan(out), part, out)
    return np.nan_to_num(out).round().astype(np.uint8)


def light_at_edge(picture: Array, camera: Camera, rays: Array,
                  inward: Array) -> Array:
    """Extrapolated from the two columns next to the edge; inward: from a
    pixel's middle to its neighbour's, away from the edge."""
    near = sample(picture, camera, (rays + inward / 2)[:, None])[:, 0]
    far = sample(picture, camera, (rays + inward * 1.5)[:, None])[:, 0]
    return 1.5 * near - 0.5 * far


def check_seam(left: str, right: str, pictures: dict[str, Exr],
               cameras: dict[str, Camera]) -> bool:
    """Geometry: both edges are one plane through one eye. Pictures: slid along
    the seam past each other, they fit best where they are, by the vertex of a
    parabola through their misfit; in logarithms, so that each row counts."""
    a, b = cameras[left], cameras[right]
    sine = float(np.linalg.norm(np.cross(edge_normal(a, True),
                                         edge_normal(b, False))))
    eye = float(np.abs(a.position - b.position).max())
    i, K = a.intrinsics, a.intrinsics.K
    v = np.linspace(-i.top, -i.bottom, i.height)[4:-4]
    edge = np.stack([np.full_like(v, i.right), v, np.ones_like(v)], -1)
    across = a.rotation[0] / K[0, 0]
    down = a.rotation[1] / K[1, 1]
    one, other = (np.log(np.maximum(pictures[n]["radiance"].astype(float),
                                    DARK)) for n in (left, right))
    offsets = np.arange(-8, 9) / 8
    misfit = [np.nanmean(np.abs(
        light_at_edge(one, a, edge @ a.rotation - offset / 2 * down, -across)
        - light_at_edge(other, b, edge @ a.rotation + offset / 2 * down,
                        across))) for offset in offsets]
    curve, slope, _ = np.polyfit(offsets, misfit, 2)
    best = float(-slope / (2 * curve)) if curve > 0 else math.inf
    good = (sine <= RAY_TOLERANCE_RAD and eye <= EYE_TOLERANCE_M
            and abs(best) <= FIT_TOLERANCE_PX)
    print(f"{left} | {right}: edges {sine:.1e} rad apart, pictures fit best "
          f"{best:+.3f} px from where they are: "
          + ("meets" if good else "DOES NOT MEET"))
    return good


def check_one_frame(frames: list[Frame]) -> bool:
    """Pictures that were asked for together are of one frame."""
    numbers = {frame.number for frame in frames}
    good = len(numbers) == 1 and len({frame.time for frame in frames}) == 1
    print(f"{len(frames)} pictures of frame "
          f"{', '.join(str(n) for n in sorted(numbers))}: "
          + ("one frame" if good else "NOT ONE FRAME"))
    return good


def check_live(ocean: Ocean, sets: int) -> bool:
    """Watches all windows until so many frames came in each of them. A window
    that is slow leaves frames out; those that come agree."""
    seen: dict[int, dict[str, LiveFrame]] = {}
    whole: list[int] = []
    with contextlib.ExitStack() as stack:
        streams = {name: stack.enter_context(
            ocean.views[name].live(width=160, height=120))
            for name in WINDOWS}
        for _ in range(50 * sets):
            for name, stream in streams.items():
                frame = next(stream)
                seen.setdefault(frame.number, {})[name] = frame
            whole = [n for n, views in seen.items()
                     if len(views) == len(WINDOWS)]
            if len(whole) >= sets:
                break
    times = all(len({f.time for f in seen[n].values()}) == 1 for n in whole)
    present = [[f.present for f in seen[n].values()] for n in whole]
    apart = max((max(p) - min(p) for p in present), default=0.0)
    good = times and apart <= PRESENT_TOLERANCE_S and len(whole) >= sets
    print(f"live: {len(whole)} of {len(seen)} frames came in all five windows, "
          f"times of presentation {1e6 * apart:.0f} us apart: "
          + ("each is one frame" if good else "THEY DO NOT AGREE"))
    return good


def save(image: Array, path: str) -> None:
    try:
        import cv2
    except ImportError:
        from PIL import Image
        Image.fromarray(image).save(path)
    else:
        cv2.imwrite(path, image[:, :, ::-1])


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--url", help="of the daemon")
    parser.add_argument("--out", default="panorama.png")
    parser.add_argument("--size", default="640x480", help="of a window")
    parser.add_argument("--entity", default=1, type=int)
    parser.add_argument("--live", default=0, type=int, metavar="FRAMES",
                        help="also watch so many frames in all windows")
    parser.add_argument("--keep", action="store_true",
                        help="leave the five views in the scene")
    options = parser.parse_args()
    width, height = (int(n) for n in options.size.split("x"))
    with Ocean(options.url) as ocean:
        add_windows(ocean, options.entity, width, height)
        try:
            # One moment for all, though the clock may run.
            time = float(ocean["clock.time"])
            frames = ocean.frames(WINDOWS, "exr", time=time,
                                  float_samples=True)
            shown = ocean.frames(WINDOWS, "png", time=time)
            good = check_one_frame([*frames.values(), *shown.values()])
            if options.live:
                good = check_live(ocean, options.live) and good
        finally:
            if not options.keep:
                ocean.patch({"views": dict.fromkeys(WINDOWS)})
    images = {name: frame.image() for name, frame in shown.items()}
    pictures = {name: frame.exr() for name, frame in frames.items()}
    cameras = {name: Camera.of_exr(p) for name, p in pictures.items()}
    names = list(WINDOWS)
    meets = [check_seam(a, b, pictures, cameras)
             for a, b in zip(names, names[1:])]
    save(stitch(images, cameras, width * 4), options.out)
    print(f"{options.out}: 225 degrees at {time:.3f} s")
    if not (good and all(meets)):
        sys.exit(1)


if __name__ == "__main__":
    try:
        main()
    except PelagosError as error:
        sys.exit(f"bridge.py: {error}")
