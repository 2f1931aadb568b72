#!/usr/bin/env python3
"""Writes a labelled data set: for each frame

    0000.png        what a camera sees
    0000.exr        depth [m] and normal of each pixel
    0000.json       time, sea state, Sun, pose of ship and camera, intrinsics,
                    and the water's height under the hull

Five scenes of ten frames each, every scene with a wind, Sun and course of its
own. The same --seed gives the same files, to the bit, on the same device:
whatever the daemon did before, and in whatever state it was. That state is put
back at the end.

    dataset.py --out dataset [--url http://127.0.0.1:8080] [--frames 50]
"""
from __future__ import annotations

import argparse
import json
import pathlib
import sys
from typing import Any

import numpy as np

from pelagos import (Camera, Clock, Ocean, Origin, PelagosError, Sea, Sky,
                     Swell, Water)
from pelagos.exr import with_number

SCENE_FRAMES = 10
STEP_S = 0.5
# Points of a hull of 40 m by 8 m: forward and right of its middle [m].
HULL = {"bow": (20, 0), "stern": (-20, 0), "port": (0, -4),
        "starboard": (0, 4), "middle": (0, 0)}


def scene(seed: int, number: int, width: int, height: int) -> dict[str, Any]:
    """A whole state, from the two numbers alone."""
    random = np.random.default_rng([seed, number])

    def pick(low: float, high: float) -> float:
        return round(float(random.uniform(low, high)), 3)

    wind_from = pick(0, 360)
    course = pick(0, 360)
    # Every field is said, the defaults too: nothing is left of what was.
    return {
        "clock": Clock(mode="STEPPED", time=100.0 * number
                       ).to_json(nulls=True),
        "origin": Origin().to_json(nulls=True),
        "water": Water().to_json(nulls=True),
        "sea": Sea(windSpeed=pick(2, 16), windDirection=wind_from,
                   seed=int(random.integers(1, 1 << 31)),
                   swell=(Swell(height=pick(0, 2), period=pick(7, 13),
                                direction=pick(0, 360)),)
                   ).to_json(nulls=True),
        "sky": Sky(sunAzimuth=pick(0, 360), sunElevation=pick(3, 60),
                   visibility=pick(5000, 40000)).to_json(nulls=True),
        "entities": [{"id": 1, "name": "ship", "heading": course,
                      "course": course, "speed": pick(2, 9),
                      "pitch": pick(-2, 2), "roll": pick(-6, 6)}],
        "views": [
            {"name": "camera", "entity": 1, "up": 12, "forward": 5,
             "yaw": pick(-60, 60), "pitch": pick(-12, 0),
             "fieldOfView": 60, "width": width, "height": height},
            # A camera in the ship's reference point: its pose is the ship's.
            {"name": "reference", "entity": 1, "up": 0, "width": 16,
             "height": 16}],
    }


def label(ocean: Ocean, time: float, camera: Camera, exposure: float) -> dict[str, Any]:
    state = ocean.state()
    ship = ocean.views["reference"].camera(time=time)
    # Rows of a camera's rotation: right, down, ahead.
    right, _, ahead = ship.rotation
    points = [ship.position + f * ahead + r * right for f, r in HULL.values()]
    water = ocean.surface(np.array(points)[:, :2], time=time)
    hull = {name: {"point": point.tolist(), "water": float(height)}
            for name, point, height in zip(HULL, points, water.height)}
    sea, sky, entity = state.sea, state.sky, state.entities[0]
    assert sea and sky
    return {
        "time": time,
        "sea": sea.to_json(),
        "sun": {"azimuth": sky.sunAzimuth, "elevation": sky.sunElevation},
        "visibility": sky.visibility,
        "exposure": exposure,
        "camera": camera.to_json(),
        "ship": {"position": ship.position.tolist(),
                 "heading": entity.heading, "pitch": entity.pitch,
                 "roll": entity.roll, "speed": entity.speed},
        "hull": hull,
    }


def write_frame(ocean: Ocean, number: int, folder: pathlib.Path) -> None:
    time = float(ocean["clock.time"])
    camera = ocean.views["camera"]
    exr = camera.frame("exr", layers=("depth", "normal"))
    picture = exr.exr()
    content = label(ocean, time, Camera.of_exr(picture),
                    picture.attributes["pelagos.exposure"])
    name = folder / f"{number:04}"
    camera.frame("png").save(name.with_suffix(".png"))
    # The revision counts edits since the daemon's start: not for the files.
    name.with_suffix(".exr").write_bytes(
        with_number(exr.data, "pelagos.revision", 0))
    name.with_suffix(".json").write_text(
        json.dumps(content, indent=1, sort_keys=True) + "\n")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--url", help="of the daemon")
    parser.add_argument("--out", default="dataset", type=pathlib.Path)
    parser.add_argument("--frames", default=50, type=int)
    parser.add_argument("--seed", default=1, type=int)
    parser.add_argument("--size", default="640x360", help="WIDTHxHEIGHT")
    options = parser.parse_args()
    width, height = (int(n) for n in options.size.split("x"))
    options.out.mkdir(parents=True, exist_ok=True)
    with Ocean(options.url) as ocean, ocean.kept():
        for number in range(options.frames):
            if number % SCENE_FRAMES == 0:
                ocean.patch(scene(options.seed, number // SCENE_FRAMES,
                                  width, height))
            else:
                ocean.step(STEP_S)
            write_frame(ocean, number, options.out)
            print(f"\r{number + 1} of {options.frames} frames in "
                  f"{options.out}", end="", flush=True)
    print()


if __name__ == "__main__":
    try:
        main()
    except PelagosError as error:
        sys.exit(f"dataset.py: {error}")
