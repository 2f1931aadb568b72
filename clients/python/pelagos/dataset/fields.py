"""Paths of the state in plans: whether they are there, and what values they
take, by the schema's own table."""
from __future__ import annotations

import dataclasses
import difflib
import hashlib
import math
import typing
from typing import Any

from ..record import Record, list_of, message_of
from ..schema import Entity, Preset, State, View


class BadPlan(ValueError):
    """What is wrong with a plan: where, which value, what is wanted."""


@dataclasses.dataclass(frozen=True)
class Field:
    """One field at the end of a path: its type, unit, range and words."""
    path: str
    kind: type
    unit: str | None
    minimum: float | None
    maximum: float | None
    words: tuple[str, ...]

    def check(self, value: Any, where: str) -> None:
        """BadPlan where the field cannot have the value."""
        if value is None:
            return
        wanted = self.wanted()
        if self.kind is bool:
            fit = isinstance(value, bool)
        elif self.kind is str:
            fit = isinstance(value, str) and (not self.words
                                              or value in self.words)
        else:
            fit = (isinstance(value, (int, float))
                   and not isinstance(value, bool) and math.isfinite(value)
                   and (self.kind is float or float(value).is_integer())
                   and (self.minimum is None or self.maximum is None
                        or self.minimum <= value <= self.maximum))
        if not fit:
            raise BadPlan(f"{where}: {self.path} is {value!r}, {wanted} is "
                          f"wanted{near(value, self.words)}")

    def wanted(self) -> str:
        """"a number from 0 to 40 m/s"."""
        if self.words:
            return "one of " + ", ".join(self.words)
        if self.kind is bool:
            return "true or false"
        if self.kind is str:
            return "a text"
        text = "a whole number" if self.kind is int else "a number"
        if self.minimum is not None:
            text += f" from {self.minimum:g} to {self.maximum:g}"
        return text + ("" if self.unit in (None, "1") else f" {self.unit}")


def near(value: Any, words: Any) -> str:
    """Asks whether the nearest word was meant, if any is near."""
    found = difflib.get_close_matches(str(value), list(words), 1)
    return f"; did you mean {found[0]}?" if found else ""


def _keyed(kind: type[Record] | None) -> bool:
    return kind in (Entity, View, Preset)


def field_at(path: str, where: str, root: type[Record] = State) -> Field:
    """The field at a path: sea.windSpeed, views.camera.up, entities.1.speed,
    sea.swell.0.height."""
    parts = path.split(".")
    kind: type[Record] = root
    at = 0
    while True:
        name = parts[at] if at < len(parts) else ""
        known = {f.name.rstrip("_"): f for f in dataclasses.fields(kind)}
        if name not in known:
            so_far = ".".join(parts[:at + 1])
            raise BadPlan(f"{where}: there is no field {so_far!r}"
                          f"{near(name, known)}" if name else
                          f"{where}: {path!r} is no single field")
        inner = known[name].name
        element, message = list_of(kind, inner), message_of(kind, inner)
        if element is not None:
            if at + 2 >= len(parts) or not (
                    _keyed(element) or parts[at + 1].isdigit()):
                raise BadPlan(f"{where}: {path!r} is no single field: a list "
                              "is followed by a key and a field, as in "
                              "views.camera.up or sea.swell.0.height")
            kind, at = element, at + 2
        elif message is not None:
            if at + 1 == len(parts):
                raise BadPlan(f"{where}: {path!r} is no single field, but has "
                              "several")
            kind, at = message, at + 1
        else:
            if at + 1 < len(parts):
                raise BadPlan(f"{where}: {path!r}: nothing is below "
                              f"{'.'.join(parts[:at + 1])}")
            return _field_of(path, kind, known[name])


def _field_of(path: str, kind: type[Record],
              f: "dataclasses.Field[Any]") -> Field:
    hint = typing.get_type_hints(kind)[f.name]
    inner = next((t for t in typing.get_args(hint) if t is not type(None)),
                 hint)
    data = f.metadata
    return Field(path, inner if isinstance(inner, type) else float,
                 data.get("unit"), data.get("minimum"), data.get("maximum"),
                 data.get("words", ()))


def check_patch(patch: Any, where: str, root: type[Record] = State,
                prefix: str = "") -> None:
    """BadPlan where a merge patch of the state names what is not there, or
    gives what is out of range."""
    if not isinstance(patch, dict):
        raise BadPlan(f"{where}: {prefix.rstrip('.') or 'the state'} is "
                      f"{_short(patch)}, an object is wanted")
    known = {f.name.rstrip("_"): f for f in dataclasses.fields(root)}
    for name, value in patch.items():
        path = prefix + name
        if name not in known:
            raise BadPlan(f"{where}: there is no field {path!r}"
                          f"{near(name, known)}")
        if value is None:
            continue
        f = known[name]
        element, message = list_of(root, f.name), message_of(root, f.name)
        if element is not None and _keyed(element):
            _check_keyed(value, where, element, path)
        elif element is not None:
            _check_list(value, where, element, path)
        elif message is not None:
            check_patch(value, where, message, path + ".")
        elif typing.get_origin(typing.get_type_hints(root)[f.name]) is tuple:
            if not isinstance(value, list):
                raise BadPlan(f"{where}: {path} is {_short(value)}, a list is "
                              "wanted")
        else:
            _field_of(path, root, f).check(value, where)


def _check_keyed(value: Any, where: str, kind: type[Record],
                 path: str) -> None:
    key = "id" if kind is Entity else "name"
    if not isinstance(value, list) or not all(
            isinstance(e, dict) and key in e for e in value):
        raise BadPlan(f"{where}: {path} is a list of objects with {key!r}")
    keys = [str(e[key]) for e in value]
    for i, element in enumerate(value):
        if keys[i] in keys[:i]:
            raise BadPlan(f"{where}: {path} has {key} {keys[i]} twice")
        check_patch(element, where, kind, f"{path}.{element[key]}.")


def _check_list(value: Any, where: str, kind: type[Record],
                path: str) -> None:
    if not isinstance(value, list):
        raise BadPlan(f"{where}: {path} is {_short(value)}, a list is wanted")
    for i, element in enumerate(value):
        if isinstance(element, list):  # short for the fields in their order
            names = [f.name.rstrip("_") for f in dataclasses.fields(kind)]
            element = dict(zip(names, element))
        check_patch(element, where, kind, f"{path}.{i}.")


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 40 else text[:37] + "…"


def digest_of(path: str) -> str:
    """SHA-256 of a file."""
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        while data := file.read(1 << 20):
            digest.update(data)
    return digest.hexdigest()
