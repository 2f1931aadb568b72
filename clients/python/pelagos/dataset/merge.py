"""What makes one data set of the shards: index, annotations, card. All of it
is read from the shards themselves."""
from __future__ import annotations

import contextlib
import json
import os
import tarfile
from collections.abc import Iterator
from typing import IO, Any

from ..coco import Coco
from . import jsontext
from .card import Card
from .fields import digest_of, field_at
from .folder import Folder
from .parquet import Table
from .plan import Plan

#: Columns of the index before those of the parameters.
COLUMNS = {"id": "str", "shard": "str", "frame": "int", "scene": "int",
           "time": "float", "seed": "int", "width": "int", "height": "int",
           "boxes": "int", "bytes": "int"}


class Incomplete(RuntimeError):
    """Shards are missing, or one is not what the plan says."""


def samples(path: str) -> Iterator[tuple[dict[str, Any], dict[str, int]]]:
    """Of each sample of a shard its JSON, and the sizes of its files."""
    with tarfile.open(path, "r:") as tar:
        key, about = "", None
        sizes: dict[str, int] = {}
        for member in tar:
            name, _, ending = member.name.partition(".")
            if name != key:
                if key:
                    yield _whole(path, key, about), sizes
                key, about, sizes = name, None, {}
            sizes[ending] = member.size
            if ending == "json":
                file = tar.extractfile(member)
                assert file
                try:
                    about = jsontext.parse(file.read().decode())
                except ValueError as error:
                    raise Incomplete(f"{path}: {member.name}: no JSON: "
                                     f"{error}") from None
        if key:
            yield _whole(path, key, about), sizes


def _whole(path: str, key: str, about: dict[str, Any] | None
           ) -> dict[str, Any]:
    if about is None:
        raise Incomplete(f"{path}: {key} has no .json")
    return about


class Annotations:
    """COCO, written as it is read: a million pictures need no memory."""

    def __init__(self, path: str, plan: Plan) -> None:
        self.plan, self.path = plan, path
        self.images: IO[str] = open(  # pylint: disable=consider-using-with
            path, "w+", encoding="utf-8")
        self.rest: IO[str] = open(  # pylint: disable=consider-using-with
            path + ".boxes", "w+", encoding="utf-8")
        self.count = 0
        c = plan.content
        info = {"description": c["about"] or plan.name, "contributor":
                "pelagosd", "version": plan.digest()}
        head = {**Coco().to_json(), "info": info, "licenses": [
            {"id": 1, "name": c["license"], "url": ""}] if c["license"]
            else []}
        self.head = {k: head[k] for k in ("info", "licenses", "categories")}
        self.images.write(json.dumps(self.head, sort_keys=True)[:-1]
                          + ',\n"images": [')

    def add(self, about: dict[str, Any], shard: str, first: bool) -> None:
        c, image = self.plan.content, about["frame"] + 1
        shown = c["picture"] if c["picture"] != "none" else "exr"
        self.images.write(("\n" if first else ",\n") + json.dumps({
            "id": image, "file_name": f"{about['frame']:09}.{shown}",
            "shard": shard, "width": about["width"], "height":
            about["height"], "time": about["time"], **(
                {"license": 1} if c["license"] else {})}))
        for annotation in about["annotations"]:
            self.count += 1
            self.rest.write(("\n" if self.count == 1 else ",\n") + json.dumps(
                {**annotation, "id": self.count, "image_id": image}))

    def close(self) -> None:
        self.images.write('],\n"annotations": [')
        self.rest.seek(0)
        while more := self.rest.read(1 << 20):
            self.images.write(more)
        self.images.write("]}\n")
        self.images.close()
        self.rest.close()
        os.unlink(self.path + ".boxes")


def merge(folder: Folder, partial: bool = False) -> dict[str, Any]:
    """Writes index.parquet, annotations.json (with labels), SHA256SUMS and
    README.md; what there is of it. partial: of the shards that are there."""
    plan, there = folder.plan(), folder.set()
    missing = folder.missing(plan)
    if missing and not partial:
        raise Incomplete(
            f"{len(missing)} of {plan.shards} shards are missing (the first "
            f"is {missing[0]:05}): `pelagosctl dataset run` with the plan "
            "draws them; --partial goes without them")
    alarms = folder.at("alarms")
    if os.path.isdir(alarms) and os.listdir(alarms):
        raise Incomplete(f"{alarms} has shards that came out with other bits "
                         "the second time: draw the set anew on machines that "
                         "are alike")
    parameters = {path: _column(path) for path in plan.ranges}
    card = Card(plan, there)
    with contextlib.ExitStack() as stack:
        index = stack.enter_context(open(folder.at("index.parquet.part"),
                                         "wb"))
        table = Table(index, {**COLUMNS, **parameters}, there["program"],
                      {"pelagos.plan": there["digest"],
                       "pelagos.device": there["device"]})
        boxes = (Annotations(folder.at("annotations.json.part"), plan)
                 if plan.content["labels"] else None)
        sums = stack.enter_context(open(folder.at("SHA256SUMS.part"), "w",
                                        encoding="ascii"))
        first = True
        for number in folder.done(plan):
            path = folder.shard(number)
            name = os.path.basename(path)
            sums.write(f"{digest_of(path)}  shards/{name}\n")
            expected = iter(plan.frames_of(number))
            for about, sizes in samples(path):
                if about["frame"] != next(expected, None):
                    raise Incomplete(f"{path}: frame {about['frame']} is out "
                                     "of place")
                table.add(_row(about, sizes, name, parameters))
                card.add(about, sizes)
                if boxes:
                    boxes.add(about, name, first)
                first = False
            if next(expected, None) is not None:
                raise Incomplete(f"{path} has too few frames")
        table.close()
        if boxes:
            boxes.close()
    card.bytes_of_shards = sum(os.path.getsize(folder.shard(n))
                               for n in folder.done(plan))
    with open(folder.at("README.md.part"), "w", encoding="utf-8") as file:
        file.write(card.text(folder, missing))
    for name in ("index.parquet", "annotations.json", "SHA256SUMS",
                 "README.md"):
        if name != "annotations.json" or boxes:
            os.replace(folder.at(name + ".part"), folder.at(name))
    return {"frames": card.frames, "boxes": boxes.count if boxes else 0,
            "shards": plan.shards - len(missing), "missing": len(missing),
            "bytes": card.bytes_of_shards}


def _column(path: str) -> str:
    kind = field_at(path, path).kind
    return {int: "int", float: "float"}.get(kind, "str")


def _row(about: dict[str, Any], sizes: dict[str, int], shard: str,
         parameters: dict[str, str]) -> dict[str, Any]:
    row = {name: about.get(name) for name in COLUMNS}
    row.update(shard=shard, bytes=sum(sizes.values()),
               boxes=len(about.get("annotations", [])))
    for path, kind in parameters.items():
        value = about["parameters"].get(path)
        if value is not None:
            value = (json.dumps(value) if kind == "str"
                     and not isinstance(value, str)
                     else float(value) if kind == "float" else value)
        row[path] = value
    return row
