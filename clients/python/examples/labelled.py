#!/usr/bin/env python3
"""Writes a labelled data set for detectors: scenes of ships and buoys.

    images/0000.png    RGB
    depth/0000.tif     metres along the ray, 32-bit floats, the sky infinite
    ids/0000.png       16 bits: the entity that a pixel shows plus one, 0 none
    annotations.json   COCO: boxes, run-length masks, categories

Each scene has a wind, swell, Sun, camera and traffic of its own; the same
--seed gives the same files, to the bit, on the same device. At the end it
prints pictures a second and how well the boxes that the daemon tells agree with
those of the layer of ids. The state is put back.

    labelled.py --out labelled [--url http://127.0.0.1:8080] [--scenes 20]
"""
from __future__ import annotations

import argparse
import json
import pathlib
import sys
import time
from typing import Any

import numpy as np
from PIL import Image

from pelagos import Coco, Labels, Ocean, PelagosError, to_geographic

SHIPS = ("tug", "fishing-boat", "sailing-yacht", "pilot-launch", "patrol-boat",
         "rib", "usv", "ferry", "container-ship", "tanker")
BUOYS = ("lateral-port-a", "lateral-starboard-a", "cardinal-north",
         "cardinal-east", "cardinal-south", "cardinal-west", "safe-water",
         "special-mark", "isolated-danger")
# Metres from the camera at which they are placed, the large ones farther.
NEAR_M, FAR_M = 40.0, 900.0
LARGE = ("ferry", "container-ship", "tanker")


def scene(seed: int, number: int, width: int, height: int
          ) -> tuple[int, dict[str, Any]]:
    """A seed of the sea and a scene, from the two numbers alone."""
    random = np.random.default_rng([seed, number])

    def pick(low: float, high: float) -> float:
        return round(float(random.uniform(low, high)), 3)

    heading = pick(0, 360)
    entities: list[dict[str, Any]] = [
        {"id": 1, "name": "own", "heading": heading}]
    for id in range(2, 2 + int(random.integers(4, 11))):
        kinds = SHIPS if random.random() < 0.5 else BUOYS
        kind = str(random.choice(kinds))
        # As many to each distance's tenfold, within the picture's width.
        away = NEAR_M * (FAR_M / NEAR_M) ** float(random.random())
        if kind in LARGE:
            away = max(3 * away, 400.0)
        bearing = np.radians(heading + pick(-28, 28))
        place = to_geographic(away * float(np.sin(bearing)),
                              away * float(np.cos(bearing)))
        course = pick(0, 360)
        entities.append({
            "id": id, "model": {"name": kind}, "afloat": True,
            "latitude": place.latitude, "longitude": place.longitude,
            "heading": course, "course": course,
            "speed": pick(0, 6) if kinds is SHIPS else 0.0})
    return int(random.integers(1, 1 << 31)), {
        "sea": {"windSpeed": pick(1, 14), "windDirection": pick(0, 360),
                "swell": [[pick(0, 1.5), pick(7, 13), pick(0, 360), 10]]},
        "sky": {"sunAzimuth": pick(0, 360), "sunElevation": pick(6, 60),
                "visibility": pick(4000, 40000)},
        "entities": entities,
        "views": [{"name": "camera", "entity": 1, "up": pick(3, 15),
                   "pitch": pick(-6, 1), "roll": pick(-4, 4),
                   "fieldOfView": 60, "width": width, "height": height}]}


def write(labels: Labels, coco: Coco, name: str, out: pathlib.Path) -> None:
    Image.fromarray(labels.image).save(out / f"images/{name}.png")
    Image.fromarray(labels.depth).save(out / f"depth/{name}.tif")
    Image.fromarray((labels.ids + 1).astype(np.uint16)
                    ).save(out / f"ids/{name}.png")
    coco.add_labels(labels, f"images/{name}.png")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--url", help="of the daemon")
    parser.add_argument("--out", default="labelled", type=pathlib.Path)
    parser.add_argument("--scenes", default=20, type=int)
    parser.add_argument("--seed", default=1, type=int)
    parser.add_argument("--size", default="640x360", help="WIDTHxHEIGHT")
    parser.add_argument("--timeout", default=60, type=float,
                        help="seconds that a picture may take")
    options = parser.parse_args()
    width, height = (int(n) for n in options.size.split("x"))
    for folder in ("images", "depth", "ids"):
        (options.out / folder).mkdir(parents=True, exist_ok=True)
    coco, agreement, began = Coco(), [], time.monotonic()
    with Ocean(options.url, timeout=options.timeout) as ocean, ocean.kept():
        for number in range(options.scenes):
            ocean.reset(*scene(options.seed, number, width, height))
            labels = ocean.views["camera"].labels()
            agreement += list(labels.agreement().values())
            write(labels, coco, f"{number:04}", options.out)
            print(f"\r{number + 1} of {options.scenes} scenes in "
                  f"{options.out}", end="", flush=True)
    taken = time.monotonic() - began
    with open(options.out / "annotations.json", "w", encoding="utf-8") as file:
        json.dump(coco.to_json(), file, indent=1)
    print(f"\n{len(coco.images)} pictures, {len(coco.annotations)} boxes; "
          f"{len(coco.images) / taken:.2f} pictures a second")
    if agreement:
        print(f"boxes and ids agree: mean overlap {np.mean(agreement):.4f}, "
              f"least {min(agreement):.4f}, of {len(agreement)}")
    if any(overlap < 1 for overlap in agreement):
        sys.exit("labelled.py: a box is not that of its pixels")


if __name__ == "__main__":
    try:
        main()
    except PelagosError as error:
        sys.exit(f"labelled.py: {error}")
