"""The card of a data set: what it shows, how it was made, how it is read."""
from __future__ import annotations

import collections
import json
from typing import TYPE_CHECKING, Any

from ..schema import MODEL_CLASSES
from .fields import field_at
from .plan import Plan

if TYPE_CHECKING:
    from .folder import Folder

_BINS = 10
_BARS = "▁▂▃▄▅▆▇█"


class Counts:
    """Of one parameter: how often which value, numbers in ten bins."""

    def __init__(self, low: float | None = None,
                 high: float | None = None) -> None:
        self.low, self.high = low, high
        self.bins = [0] * _BINS
        self.words: collections.Counter[str] = collections.Counter()
        self.absent = 0
        self.least, self.most = float("inf"), float("-inf")

    def add(self, value: Any) -> None:
        if value is None:
            self.absent += 1
        elif self.low is None or self.high is None:
            self.words[str(value)] += 1
        else:
            span = self.high - self.low
            at = int((value - self.low) / span * _BINS) if span > 0 else 0
            self.bins[min(max(at, 0), _BINS - 1)] += 1
            self.least = min(self.least, value)
            self.most = max(self.most, value)

    def text(self) -> str:
        absent = f"; absent {self.absent}" if self.absent else ""
        if self.low is None:
            return ", ".join(f"{word} {n}" for word, n in sorted(
                self.words.items(), key=lambda x: (-x[1], x[0]))) + absent
        if not any(self.bins):
            return "none" + absent
        top = max(self.bins)
        bars = "".join(_BARS[(7 * n + top - 1) // top] for n in self.bins)
        return f"{bars} {self.least:g} to {self.most:g}{absent}"


class Card:
    def __init__(self, plan: Plan, there: dict[str, Any]) -> None:
        self.plan, self.there = plan, there
        self.frames = self.bytes_of_shards = 0
        self.sizes: collections.Counter[str] = collections.Counter()
        self.boxes: collections.Counter[str] = collections.Counter()
        self.hidden = Counts(0, 1)
        self.per_frame = Counts(0, 20)
        self.counts: dict[str, Counts] = {}
        for path, d in plan.ranges.items():
            numeric = d.kind not in ("choice", "grid")
            self.counts[path] = Counts(d.low if numeric else None,
                                       d.high if numeric else None)

    def add(self, about: dict[str, Any], sizes: dict[str, int]) -> None:
        self.frames += 1
        self.sizes.update(sizes)
        for path, counts in self.counts.items():
            counts.add(about["parameters"].get(path))
        found = about.get("annotations", [])
        self.per_frame.add(len(found))
        for annotation in found:
            self.boxes[MODEL_CLASSES[annotation["category_id"] - 1]] += 1
            self.hidden.add(annotation["hidden"])

    def text(self, folder: "Folder", missing: list[int]) -> str:
        plan, c = self.plan, self.plan.content
        out = [f"# {plan.name}", ""]
        out += [c["about"], ""] if c["about"] else []
        out += ["Pictures of the sea, computed: no camera and no place is in "
                "them. Each is a function of its parameters, which lie beside "
                "it.", ""]
        if missing:
            out += [f"**{len(missing)} of {plan.shards} shards are missing.**",
                    ""]
        out += _table(["", ""], [
            ["frames", f"{self.frames}"],
            ["shards", f"{plan.shards - len(missing)} of {plan.shard} frames "
             f"(tar, WebDataset), {_size(self.bytes_of_shards)}"],
            ["sequences", f"of {plan.length} frames, {plan.step:g} s apart"
             if plan.length > 1 else "none: every frame is a scene"],
            ["program", self.there["program"]],
            ["device", self.there["device"]],
            ["plan, SHA-256", f"`{self.there['digest']}`"],
            ["files, SHA-256", f"`{self.there['files']}`"
             if self.there["files"] else "none are used"],
            ["license", c["license"] or "not said"]])
        out += ["", "## What is in a sample", ""]
        out += _table(["file", "what", "bytes, mean"], [
            [f"`.{e}`", _about(e, plan), f"{n // max(1, self.frames)}"]
            for e, n in sorted(self.sizes.items())])
        out += ["", "`index.parquet` has a row for each frame: its SHA-256 "
                "(`id`: of scene, program, device and files), shard, time and "
                "every parameter that was drawn."
                + (" `annotations.json` is COCO: boxes and run-length masks "
                   "of all shards." if c["labels"] else "")
                + " `SHA256SUMS` is of the shards."]
        out += ["", "## Parameters", ""]
        if self.counts:
            out += _table(
                ["field", "unit", "drawn from", "as it came"],
                [[f"`{path}`", _unit(path), str(plan.ranges[path]),
                  counts.text()] for path, counts in self.counts.items()])
        else:
            out += ["None was drawn."]
        if c["labels"]:
            out += ["", "## Boxes", "",
                    f"{sum(self.boxes.values())} in all; per frame "
                    f"{self.per_frame.text()}; hidden share "
                    f"{self.hidden.text()}.", ""]
            out += _table(["class", "boxes"], [
                [name.lower().replace("_", "-"), f"{n}"]
                for name, n in sorted(self.boxes.items(),
                                      key=lambda x: (-x[1], x[0]))])
        out += ["", "## How it is made again", "", "With this plan as "
                "`plan.json`, the same program and an equal device, to the "
                "bit:", "", "```sh", "pelagosctl dataset run plan.json",
                "```", "", "```json", _json(c), "```", "",
                "## How it is read", "", "```python",
                "import webdataset", f'set = webdataset.WebDataset("shards/'
                f'{{00000..{plan.shards - 1:05}}}.tar").decode("rgb")',
                "```"]
        return "\n".join(out) + "\n"


def _json(content: dict[str, Any]) -> str:
    """What the plan says, an entry a line where it is a list or an object."""
    said = {k: v for k, v in content.items() if v not in (None, "", {}, [])
            and not (k == "frames" and content["scenes"] is not None)}
    lines = []
    for key, value in said.items():
        text = json.dumps(value, ensure_ascii=False)
        if key in ("state", "ranges"):
            text = "{\n  " + ",\n  ".join(
                f"{json.dumps(k)}: {json.dumps(v, ensure_ascii=False)}"
                for k, v in value.items()) + "}"
        elif key in ("traffic", "scenes"):
            text = "[\n  " + ",\n  ".join(
                json.dumps(v, ensure_ascii=False) for v in value) + "]"
        lines.append(f' "{key}": {text}')
    return "{\n" + ",\n".join(lines) + "\n}"


def _table(head: list[str], rows: list[list[str]]) -> list[str]:
    return ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head),
            *("| " + " | ".join(cell.replace("|", "\\|") for cell in row)
              + " |" for row in rows)]


def _unit(path: str) -> str:
    unit = field_at(path, path).unit
    return "" if unit in (None, "1") else str(unit)


def _size(count: int) -> str:
    for unit, scale in (("GB", 1e9), ("MB", 1e6)):
        if count >= scale:
            return f"{count / scale:.1f} {unit}"
    return f"{count / 1e3:.0f} kB"


def _about(ending: str, plan: Plan) -> str:
    c = plan.content
    if ending == "json":
        return "time, seed, parameters, state, camera" + (
            ", truth, annotations" if c["labels"] else "")
    if ending == "exr":
        return "linear OpenEXR: " + ", ".join(c["layers"])
    if ending == "ids.png":
        return "16 bits: number of the entity plus one, 0 none"
    return "the picture, 8 bits, exposed"
