"""Data sets of ground truth: COCO for detection and instance masks, and a table
of positions as AIS would have them.

    coco = Coco()
    with ocean.kept():
        ocean.patch({"clock": {"mode": "STEPPED"}})
        for number in range(100):
            ocean.step(1)
            coco.add(*shot(ocean, "bridge"), f"{number:04}.jpg")
    coco.save("annotations.json")

Format: cocodataset.org, "Data format", object detection."""
from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from . import need
from .schema import MODEL_CLASSES

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .client import Ocean
    from .labels import Labels
    from .parts import ViewHandle

#: Columns of positions_csv, units as in the schema's SeenEntity.
POSITION_COLUMNS = ("time", "id", "class", "latitude", "longitude", "heading",
                    "course", "speed", "length", "beam", "draught")


def shot(ocean: "Ocean", view: "str | ViewHandle", *, time: float | None = None
         ) -> "tuple[dict[str, Any], NDArray[np.int64]]":
    """Truth of a view, and for each pixel the number of the entity plus one, 0
    for none. Of one moment where `time` is given or the clock stands."""
    np = need.numpy()
    truth = ocean.frame(view, "json", time=time).truth()
    exr = ocean.frame(view, "exr", layers=("id",), time=time).exr()
    return truth, exr.layers["id"].astype(np.int64)


def run_lengths(mask: "NDArray[np.bool_]") -> list[int]:
    """A mask as COCO has it: lengths of runs down the columns, zeros first."""
    np = need.numpy()
    flat = np.concatenate([[False], mask.flatten(order="F"), [False]])
    edges = np.flatnonzero(flat[1:] != flat[:-1])
    counts = np.diff(edges, prepend=0).tolist()
    if not counts or edges[-1] < mask.size:
        counts.append(mask.size - (int(edges[-1]) if counts else 0))
    return counts


class Coco:
    """A COCO data set that grows. The number of a category is that of the layer
    `class`, so data sets go together; `hidden`, `distance`, `entity` of an
    annotation are ours, readers pass over them."""

    def __init__(self) -> None:
        self.images: list[dict[str, Any]] = []
        self.annotations: list[dict[str, Any]] = []

    def add(self, truth: dict[str, Any], ids: "NDArray[np.int64]",
            file_name: str) -> int:
        """One picture with what it shows; returns its number."""
        height, width = ids.shape
        if (width, height) != (truth["width"], truth["height"]):
            raise ValueError("the truth and the numbers are of pictures of "
                             "different sizes")
        image = len(self.images) + 1
        self.images.append({"id": image, "file_name": file_name,
                            "width": width, "height": height,
                            "time": truth["time"]})
        for entity in truth.get("entities", []):
            if "visible" in entity:
                self._annotate(image, entity, ids == entity["id"] + 1)
        return image

    def add_labels(self, labels: "Labels", file_name: str) -> int:
        """The same of what `view.labels()` gave."""
        np = need.numpy()
        return self.add(labels.truth.to_json(),
                        labels.ids.astype(np.int64) + 1, file_name)

    def _annotate(self, image: int, entity: dict[str, Any],
                  mask: "NDArray[np.bool_]") -> None:
        if int(mask.sum()) != entity["pixels"]:
            raise ValueError("the truth and the numbers are of different "
                             "moments: stop the clock, or say the time")
        box = entity["visible"]
        self.annotations.append({
            "id": len(self.annotations) + 1, "image_id": image,
            "category_id": MODEL_CLASSES.index(entity["class"]) + 1,
            "bbox": [box["x"], box["y"], box["width"], box["height"]],
            "area": entity["pixels"], "iscrowd": 0,
            "segmentation": {"size": list(mask.shape),
                             "counts": run_lengths(mask)},
            "entity": entity["id"], "hidden": entity.get("hidden", 0.0),
            "distance": entity["distance"]})

    def to_json(self) -> dict[str, Any]:
        return {"info": {"description": "pelagosd"}, "licenses": [],
                "images": self.images, "annotations": self.annotations,
                "categories": [
                    {"id": i + 1, "name": name.lower().replace("_", "-"),
                     "supercategory": "thing on the sea"}
                    for i, name in enumerate(MODEL_CLASSES)]}

    def save(self, path: "str | os.PathLike[str]") -> None:
        with open(path, "w", encoding="utf-8") as file:
            json.dump(self.to_json(), file)


def positions_csv(truths: Iterable[dict[str, Any]],
                  path: "str | os.PathLike[str]") -> None:
    """Where every entity of these truths was: one row a moment and entity,
    pixels or none."""
    with open(path, "w", encoding="utf-8", newline="") as file:
        out = csv.writer(file)
        out.writerow(POSITION_COLUMNS)
        for truth in truths:
            for entity in truth.get("entities", []):
                row = {**entity, "time": truth["time"]}
                out.writerow([row.get(name, "") for name in POSITION_COLUMNS])
