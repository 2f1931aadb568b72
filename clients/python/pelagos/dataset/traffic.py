"""Traffic of a plan: ships and marks at random places before the camera."""
from __future__ import annotations

import math
from typing import Any

from ..geo import to_geographic, to_local
from ..schema import MODEL_SIZES, Entity, Origin, View
from .fields import BadPlan, field_at, near
from .sample import Distribution

#: Of a group, what it is when it is not said.
_DEFAULTS: dict[str, Any] = {
    "count": {"integer": [0, 8]}, "distance": {"logUniform": [40, 900]},
    "bearing": {"uniform": [-28, 28]}, "course": {"uniform": [0, 360]},
    "speed": {"uniform": [0, 6]}, "apart": 10.0}
_TRIES = 20
_MOST = 200


class Group:
    """Entities of a kind: how many, of which models, where they are at the
    moment of the scene. Other keys are fields of Entity."""

    def __init__(self, spec: Any, where: str) -> None:
        if not isinstance(spec, dict):
            raise BadPlan(f"{where}: {spec!r}, an object is wanted")
        models = spec.get("models")
        if (not isinstance(models, list) or not models
                or not all(isinstance(m, str) for m in models)):
            raise BadPlan(f"{where}: models is {models!r}, a list of names is "
                          "wanted (`pelagosctl models` lists them)")
        for name in models:
            # Files of the directory of models have an ending.
            if name not in MODEL_SIZES and "." not in name:
                raise BadPlan(f"{where}: there is no model {name!r}"
                              f"{near(name, MODEL_SIZES)}")
        self.models = Distribution({"choice": models}, f"{where}.models")
        given = {**_DEFAULTS, **{k: v for k, v in spec.items()
                                 if k != "models"}}
        self.apart = given.pop("apart")
        if not isinstance(self.apart, (int, float)) or self.apart < 0:
            raise BadPlan(f"{where}.apart is {self.apart!r}, metres are "
                          "wanted")
        self.draws: dict[str, Distribution] = {}
        for key, value in given.items():
            own = key in _DEFAULTS and key not in ("course", "speed")
            field = None if own else field_at(key, where, Entity)
            self.draws[key] = Distribution(
                value if isinstance(value, dict) else {"choice": [value]},
                f"{where}.{key}", field, grid=False)
        for key, low, high in (("count", 0, _MOST), ("distance", 0, 1e5),
                               ("bearing", -360, 360)):
            for value in self.draws[key].extremes():
                if not isinstance(value, (int, float)) or not (
                        low <= value <= high):
                    raise BadPlan(f"{where}.{key} is {value!r}, a number from "
                                  f"{low:g} to {high:g} is wanted")

    def add(self, patch: dict[str, Any], view: str, seed: int, scene: int,
            group: int, time: float) -> None:
        """Adds the entities, placed so that they are there at `time`."""
        origin = Origin(**{k: v for k, v in (patch.get("origin") or {}).items()
                           if v is not None})
        entities: list[dict[str, Any]] = patch["entities"]
        east, north, ahead = _eye(patch, view, origin, time)
        name = f"traffic/{group}/"
        count = int(self.draws["count"].draw(seed, scene, name + "count") or 0)
        # Centres and half lengths of what is there, the eye's place too.
        taken = [(east, north, 0.0)] + [
            (*_at(e, origin, time), _half((e.get("model") or {}).get("name")))
            for e in entities]
        next_id = 1 + max((int(e["id"]) for e in entities), default=0)
        for i in range(count):
            model = self.models.draw(seed, scene, name + "model", i)
            half = _half(model)
            for attempt in range(_TRIES):
                k = i * _TRIES + attempt
                away = self.draws["distance"].draw(seed, scene,
                                                   name + "distance", k)
                bearing = self.draws["bearing"].draw(seed, scene,
                                                     name + "bearing", k)
                angle = math.radians(ahead + (bearing or 0.0))
                x = east + (away or 0.0) * math.sin(angle)
                y = north + (away or 0.0) * math.cos(angle)
                if all(math.hypot(x - a, y - b) >= self.apart + half + other
                       for a, b, other in taken):
                    break
            else:
                continue
            taken.append((x, y, half))
            entities.append(self._entity(
                {"id": next_id, "model": {"name": model}, "afloat": True}, x,
                y, seed, scene, name, i, time, origin))
            next_id += 1

    def _entity(self, out: dict[str, Any], x: float, y: float, seed: int,
                scene: int, name: str, i: int, time: float, origin: Origin
                ) -> dict[str, Any]:
        for key, distribution in self.draws.items():
            if key in ("count", "distance", "bearing"):
                continue
            value = distribution.draw(seed, scene, name + key, i)
            if value is None:
                continue
            at = out
            *folders, last = key.split(".")
            for folder in folders:
                at = at.setdefault(folder, {})
            at[last] = value
        out.setdefault("course", 0.0)
        out.setdefault("speed", 0.0)
        out.setdefault("heading", out["course"])
        way = out["speed"] * time
        turn = math.radians(out["course"])
        place = to_geographic(x - way * math.sin(turn),
                              y - way * math.cos(turn), origin)
        out["latitude"] = round(place.latitude, 9)
        out["longitude"] = round(place.longitude, 9)
        return out


def _half(model: str | None) -> float:
    """Half the length of a built-in model [m]; of others it is not known."""
    return float(MODEL_SIZES.get(model or "", (0, 0))[0]) / 2


def _default(entity: dict[str, Any], name: str, kind: type) -> float:
    value = entity.get(name)
    if value is None:
        value = getattr(kind, name, 0.0)
    return float(value or 0.0)


def _at(entity: dict[str, Any], origin: Origin, time: float
        ) -> tuple[float, float]:
    """East and north of the origin at `time`, by its speed and course [m]."""
    place = to_local(_default(entity, "latitude", Entity),
                     _default(entity, "longitude", Entity), origin)
    way = _default(entity, "speed", Entity) * time
    turn = math.radians(_default(entity, "course", Entity))
    return place.east + way * math.sin(turn), place.north + way * math.cos(turn)


def _eye(patch: dict[str, Any], view: str, origin: Origin, time: float
         ) -> tuple[float, float, float]:
    """East, north [m] and direction of sight [deg] of a view that is fixed to
    an entity, to the origin or to a place."""
    camera = next(v for v in patch["views"] if v["name"] == view)
    for other in ("orbit", "satellite", "waypoints", "lookAt"):
        if camera.get(other):
            raise BadPlan(f"traffic is placed before a camera on an entity, "
                          f"at a place or at the origin: views.{view} has "
                          f"{other}")
    ahead = _default(camera, "yaw", View)
    if camera.get("at"):
        place = to_local(float(camera["at"]["latitude"]),
                         float(camera["at"]["longitude"]), origin)
        return place.east, place.north, ahead
    if camera.get("entity") is None:
        return 0.0, 0.0, ahead
    carrier = [e for e in patch["entities"]
               if int(e["id"]) == int(camera["entity"])]
    if not carrier:
        raise BadPlan(f"views.{view}.entity is {camera['entity']}, which is "
                      "not in state.entities")
    east, north = _at(carrier[0], origin, time)
    return east, north, ahead + _default(carrier[0], "heading", Entity)
