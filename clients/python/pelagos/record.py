"""Dataclasses that read and write JSON; see schema.py."""
from __future__ import annotations

import dataclasses
import functools
import typing
from typing import Any, TypeVar

Self = TypeVar("Self", bound="Record")


def _field(default: Any, unit: str | None = None,
           minimum: float | None = None, maximum: float | None = None,
           words: str = "") -> Any:
    return dataclasses.field(default=default, metadata={
        "unit": unit, "minimum": minimum, "maximum": maximum,
        "words": tuple(words.split())})


@functools.cache
def _readers(kind: type) -> dict[str, Any]:
    """Of each field, by its name on the wire, its name here and what makes a
    value from JSON."""
    out = {}
    for name, hint in typing.get_type_hints(kind).items():
        many = typing.get_origin(hint) is tuple
        inner = next((t for t in typing.get_args(hint)
                      if t not in (type(None), Ellipsis)), hint)
        read = (inner.from_json if isinstance(inner, type)
                and issubclass(inner, Record) else inner)
        out[name.rstrip("_")] = (name, (lambda v, r=read: tuple(map(r, v)))
                                 if many else read)
    return out


def list_of(kind: type[Record], name: str) -> type[Record] | None:
    """Where the field `name` is a list of messages: their class."""
    hint = typing.get_type_hints(kind).get(name)
    if typing.get_origin(hint) is not tuple:
        return None
    inner = typing.get_args(hint)[0]
    return inner if issubclass(inner, Record) else None


def message_of(kind: type[Record], name: str) -> type[Record] | None:
    """Where the field `name` is a message: its class."""
    hint = typing.get_type_hints(kind).get(name)
    return next((t for t in typing.get_args(hint) if isinstance(t, type)
                 and issubclass(t, Record)), None)


@dataclasses.dataclass(frozen=True)
class Record:
    """Base of the schema's messages."""

    @classmethod
    def from_json(cls: type[Self], content: dict[str, Any]) -> Self:
        """Fields that this class does not know are passed over."""
        # A class is hashable, whatever its objects are.
        readers = _readers(cls)  # type: ignore[arg-type]
        return cls(**{readers[name][0]: readers[name][1](value)
                      for name, value in content.items()
                      if name in readers and value is not None})

    def to_json(self, nulls: bool = False) -> dict[str, Any]:
        """May be sent back in a patch. Without what is absent; or, with
        nulls, as None, so that the patch makes it absent."""
        out: dict[str, Any] = {}
        for f in dataclasses.fields(self):
            value, name = getattr(self, f.name), f.name.rstrip("_")
            if isinstance(value, Record):
                out[name] = value.to_json(nulls)
            elif isinstance(value, tuple):
                out[name] = [v.to_json() if isinstance(v, Record) else v
                             for v in value]
            elif value is not None or nulls:
                out[name] = value
        return out
