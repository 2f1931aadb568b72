"""Plans of data sets: one JSON file says everything; what is wrong with it is
said before anything is drawn (docs/datasets.md)."""
from __future__ import annotations

import copy
import dataclasses
import hashlib
import json
import math
import os
import re
from typing import Any

from ..schema import FORMATS, LAYERS, LINEAR_FORMATS
from . import jsontext
from .fields import BadPlan, check_patch, digest_of, field_at, near
from .sample import Distribution, rounded, uniform
from .traffic import Group

#: Key: the type that is wanted, and the default.
KEYS: dict[str, tuple[Any, Any]] = {
    "name": (str, None), "about": (str, ""), "license": (str, ""),
    "seed": (int, 1), "frames": (int, None), "scenes": (list, None),
    "shard": (int, None), "sequence": (dict, None), "view": (str, None),
    "width": (int, None), "height": (int, None), "picture": (str, "jpg"),
    "quality": (int, 90), "layers": (list, ["depth", "id", "class"]),
    "labels": (bool, True), "ids": (bool, False), "state": (dict, {}),
    "ranges": (dict, {}), "traffic": (list, []), "time": (object, 0.0),
    "directories": (dict, {}),
}
_WANTED = {str: "a text", int: "a whole number", list: "a list",
           dict: "an object", bool: "true or false"}
#: Formats of pictures of eight bits.
PICTURES = tuple(f for f in FORMATS if f not in (*LINEAR_FORMATS, "json"))
#: Directories of files that scenes name: options of pelagosd.
DIRECTORIES = ("models", "panoramas", "bathymetry", "spectra")
_NOT_RANGES = ("clock.mode", "clock.time", "revision", "exercise", "presets")
_MOST_FRAMES = 100_000_000
_LONGEST_S = 1e6


@dataclasses.dataclass(frozen=True)
class Scene:
    """What one scene is made of.

    seed        of waves and clouds
    patch       of the state at simulated time 0
    time        of its first frame [s]
    parameters  that were drawn: path to value; None: left as it is
    """
    seed: int
    patch: dict[str, Any]
    time: float
    parameters: dict[str, Any]


class Plan:
    """A checked plan. `content` is it with every default said."""

    def __init__(self, content: Any, folder: str = ".") -> None:
        if not isinstance(content, dict):
            raise BadPlan("the plan is no JSON object")
        for key in content:
            if key not in KEYS:
                raise BadPlan(f"the plan: there is no {key!r}"
                              f"{near(key, KEYS)}; it has "
                              + ", ".join(KEYS))
        self.content: dict[str, Any] = {
            key: self._value(content, key) for key in KEYS}
        c = self.content
        self.folder = folder
        self.name, self.seed = str(c["name"]), c["seed"]
        if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}", self.name):
            raise BadPlan(f"name is {c['name']!r}, 1 to 64 of A-Z a-z 0-9 . _ "
                          "- are wanted")
        _within(c, "seed", 0, 2**53)
        _within(c, "quality", 1, 100)
        self._read_sequence()
        self._read_count()
        self._read_outputs()
        self._read_scene()
        self._read_directories()

    # --- reading ------------------------------------------------------------

    @staticmethod
    def _value(content: dict[str, Any], key: str) -> Any:
        kind, default = KEYS[key]
        value = content.get(key)
        if value is None:
            return copy.deepcopy(default)
        if kind is not object and (not isinstance(value, kind) or (
                kind is int and isinstance(value, bool))):
            raise BadPlan(f"{key} is {value!r}, {_WANTED[kind]} is wanted")
        return copy.deepcopy(value)

    def _read_sequence(self) -> None:
        given = self.content["sequence"] or {}
        for key in given:
            if key not in ("frames", "step"):
                raise BadPlan(f"sequence: there is no {key!r}; it has frames, "
                              "step")
        given = {"frames": 1, "step": 0.1, **given}
        _within(given, "frames", 1, 100_000, "sequence.")
        _within(given, "step", 0.001, 3600, "sequence.", whole=False)
        self.content["sequence"] = given
        self.length, self.step = int(given["frames"]), float(given["step"])

    def _read_count(self) -> None:
        c, n = self.content, self.length
        if c["scenes"] is not None:
            if not c["scenes"]:
                raise BadPlan("scenes is an empty list")
            count = len(c["scenes"]) * n
            if c["frames"] not in (None, count):
                raise BadPlan(f"frames is {c['frames']}, but scenes are "
                              f"{count} frames: leave frames out")
            c["frames"] = count
        if not isinstance(c["frames"], int):
            raise BadPlan("frames (a number) or scenes (a list of changes of "
                          "the state) is wanted")
        _within(c, "frames", 1, _MOST_FRAMES)
        self.frames = int(c["frames"])
        if c["shard"] is None:
            # At least twenty, for workers to share.
            c["shard"] = n * max(1, min(1000, -(-self.frames // 20)) // n)
        _within(c, "shard", 1, 100_000)
        self.shard = int(c["shard"] or 1)
        for key in ("frames", "shard"):
            if c[key] % n:
                raise BadPlan(f"{key} is {c[key]}, a multiple of "
                              f"sequence.frames ({n}) is wanted")
        self.shards = -(-self.frames // self.shard)

    def _read_outputs(self) -> None:
        c = self.content
        if c["picture"] not in (*PICTURES, "none"):
            raise BadPlan(f"picture is {c['picture']!r}, one of "
                          f"{', '.join(PICTURES)}, none is wanted")
        for layer in c["layers"]:
            if layer not in LAYERS:
                raise BadPlan(f"layers: there is no {layer!r}; there are "
                              + ", ".join(LAYERS))
        # In the order of the table, each once.
        c["layers"] = [x for x in LAYERS if x in c["layers"]]
        if c["picture"] == "none" and not (c["layers"] or c["ids"]):
            raise BadPlan("picture is none, layers are none, ids are none: "
                          "nothing is left to draw")

    def _read_scene(self) -> None:
        c = self.content
        check_patch(c["state"], "state")
        _long_lists(c["state"])
        view = c["view"]
        views = c["state"].setdefault("views", [
            {"name": view or "camera", "entity": 1}])
        c["state"].setdefault("entities", [{"id": 1, "name": "ownship"}])
        self.view = c["view"] = view or (views[0]["name"] if views else "")
        mine = [v for v in views if v["name"] == self.view]
        if not mine:
            raise BadPlan(f"view is {self.view!r}, one of state.views is "
                          "wanted: " + ", ".join(v["name"] for v in views))
        for key in ("width", "height"):
            if c[key] is not None:
                mine[0][key] = c[key]
                field_at(f"views.{self.view}.{key}", key).check(c[key], key)
        for i, patch in enumerate(c["scenes"] or []):
            check_patch(patch, f"scenes[{i}]")
            _long_lists(patch)
        self.ranges: dict[str, Distribution] = {}
        for path, spec in sorted(c["ranges"].items()):
            where = f"ranges.{path}"
            if path.startswith(_NOT_RANGES):
                raise BadPlan(f"{where}: that is the plan's own: `time` says "
                              "the moment of a scene")
            self.ranges[path] = Distribution(spec, where,
                                             field_at(path, where))
            for i in range(len(c["scenes"] or [0])):
                _place(self._base(i), path, where)
        self.grids = [p for p, d in self.ranges.items() if d.kind == "grid"]
        time = c["time"]
        spec = time if isinstance(time, dict) else {"choice": [time]}
        self.time = Distribution(spec, "time", grid=False)
        for value in self.time.extremes():
            if (isinstance(value, bool) or not isinstance(value, (int, float))
                    or not 0 <= value <= _LONGEST_S):
                raise BadPlan(f"time is {value!r}, a number from 0 to "
                              f"{_LONGEST_S:g} s is wanted")
        self.traffic = [Group(g, f"traffic[{i}]")
                        for i, g in enumerate(c["traffic"])]

    def _read_directories(self) -> None:
        self.directories: dict[str, str] = {}
        for key, value in self.content["directories"].items():
            if key not in DIRECTORIES:
                raise BadPlan(f"directories: there is no {key!r}; there are "
                              + ", ".join(DIRECTORIES))
            path = os.path.abspath(os.path.join(self.folder, str(value)))
            if not os.path.isdir(path):
                raise BadPlan(f"directories.{key} is {value!r}: {path} is no "
                              "directory")
            self.directories[key] = path

    # --- what follows from it -----------------------------------------------

    def frames_of(self, shard: int) -> range:
        return range(shard * self.shard,
                     min((shard + 1) * self.shard, self.frames))

    def _base(self, number: int) -> dict[str, Any]:
        state = copy.deepcopy(self.content["state"])
        if self.content["scenes"] is not None:
            _merge(state, copy.deepcopy(self.content["scenes"][number]))
        return state

    def scene(self, number: int) -> Scene:
        """A function of the plan and the number alone."""
        patch = self._base(number)
        drawn: dict[str, Any] = {}
        turn = number
        for path in reversed(self.grids):
            values = self.ranges[path].values
            drawn[path] = values[turn % len(values)]
            turn //= len(values)
        for path, distribution in self.ranges.items():
            if distribution.kind != "grid":
                drawn[path] = distribution.draw(self.seed, number, path)
            if drawn[path] is not None:
                element, key = _place(patch, path, f"ranges.{path}")
                element[key] = drawn[path]
        time = rounded(self.time.draw(self.seed, number, "time") or 0.0)
        clock = patch.setdefault("clock", {})
        last = time + self.length * self.step
        clock["reckoning"] = max(clock.get("reckoning", 60.0), math.ceil(last))
        for i, group in enumerate(self.traffic):
            group.add(patch, self.view, self.seed, number, i, time)
        seed = patch.get("sea", {}).get("seed")
        if seed is None:
            seed = int(uniform(self.seed, number, "sea.seed") * 2**32)
        return Scene(seed, patch, time, {p: drawn[p] for p in self.ranges})

    def moment(self, scene: Scene, frame: int) -> float:
        """Simulated time of a frame [s]."""
        return rounded(scene.time + frame % self.length * self.step)

    def files_digest(self) -> str:
        """SHA-256 of the files that scenes may name, "" without any."""
        if not self.directories:
            return ""
        total = hashlib.sha256()
        for key, folder in sorted(self.directories.items()):
            for root, folders, names in os.walk(folder):
                folders.sort()
                for name in sorted(names):
                    path = os.path.join(root, name)
                    total.update(f"{key}/{os.path.relpath(path, folder)}\0"
                                 f"{digest_of(path)}\n".encode())
        return total.hexdigest()

    def digest(self) -> str:
        """SHA-256 of everything that the plan says, but where its files
        lie."""
        content = {**self.content, "directories": sorted(self.directories),
                   "files": self.files_digest()}
        return hashlib.sha256(canonical(content)).hexdigest()


def canonical(content: Any) -> bytes:
    """JSON with one spelling."""
    return json.dumps(content, sort_keys=True, ensure_ascii=False,
                      allow_nan=False, separators=(",", ":")).encode()


def read_plan(path: str) -> Plan:
    """Of a file; BadPlan says what is wrong with it."""
    try:
        with open(path, encoding="utf-8") as file:
            content = jsontext.parse(file.read())
    except OSError as error:
        raise BadPlan(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise BadPlan(f"{path}: no JSON: {error}") from None
    try:
        return Plan(content, os.path.dirname(path) or ".")
    except BadPlan as error:
        raise BadPlan(f"{path}: {error}") from None


def _within(content: dict[str, Any], key: str, low: float, high: float,
            prefix: str = "", whole: bool = True) -> None:
    value = content[key]
    fit = (isinstance(value, int if whole else (int, float))
           and not isinstance(value, bool) and low <= value <= high)
    if not fit:
        raise BadPlan(f"{prefix}{key} is {value!r}, a "
                      f"{'whole ' if whole else ''}number from {low:g} to "
                      f"{high:g} is wanted")


def _long_lists(patch: dict[str, Any]) -> None:
    """Trains of swell as objects, so that paths lead into them."""
    sea = patch.get("sea") or {}
    names = ("height", "period", "direction", "spread")
    if isinstance(sea.get("swell"), list):
        sea["swell"] = [dict(zip(names, s)) if isinstance(s, list) else s
                        for s in sea["swell"]]


def _merge(into: dict[str, Any], patch: dict[str, Any]) -> None:
    """RFC 7396; elements of keyed lists by their keys."""
    for name, value in patch.items():
        if name in ("entities", "views") and into.get(name):
            key = "id" if name == "entities" else "name"
            for element in value or []:
                mine = [e for e in into[name] if e[key] == element[key]]
                if mine:
                    _merge(mine[0], element)
                else:
                    into[name].append(element)
        elif isinstance(value, dict) and isinstance(into.get(name), dict):
            _merge(into[name], value)
        else:
            into[name] = value


def _place(patch: dict[str, Any], path: str, where: str
           ) -> tuple[dict[str, Any], str]:
    """The object that has the last part of a path, made where it can be."""
    parts = path.split(".")
    at: Any = patch
    for i, part in enumerate(parts[:-1]):
        if isinstance(at, list):
            found = [e for k, e in enumerate(at) if part in (
                str(e.get("id", "")), e.get("name"))
                or ("id" not in e and "name" not in e and part == str(k))]
            if not found:
                raise BadPlan(f"{where}: there is no "
                              f"{'.'.join(parts[:i + 1])} in the plan's state")
            at = found[0]
        else:
            if at.get(part) is None:
                at[part] = ([] if part in ("swell", "fog", "entities",
                                           "views") else {})
            at = at[part]
    return at, parts[-1]
