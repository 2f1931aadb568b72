"""Views and entities of an ocean as objects, and the maps that hold them."""
from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from .camera import Camera, Horizon, Intrinsics
from .errors import NotFound
from .frame import Frame
from .labels import Labels, labels
from .live import LiveStream, VideoStream
from .schema import Entity, View

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .client import Ocean


class _Handle:
    _list = ""

    def __init__(self, ocean: Ocean, key: str) -> None:
        self._ocean, self.key = ocean, key

    def set(self, **fields: Any) -> None:
        """Sets fields, all or none; None resets one to its default."""
        self._ocean.patch({self._list: {self.key: fields}})

    def __getitem__(self, field: str) -> Any:
        """A field's value now; None: absent."""
        return self._ocean[f"{self._list}.{self.key}.{field}"]

    def __setitem__(self, field: str, value: Any) -> None:
        self._ocean[f"{self._list}.{self.key}.{field}"] = value

    def __delitem__(self, field: str) -> None:
        del self._ocean[f"{self._list}.{self.key}.{field}"]

    def remove(self) -> None:
        """Takes it out of the world."""
        self._ocean.patch({self._list: {self.key: None}})

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self._list}.{self.key}>"


class EntityHandle(_Handle):
    """A body that moves: `ocean.entities[1]`."""
    _list = "entities"

    @property
    def id(self) -> int:
        """The key of `ocean.entities`."""
        return int(self.key)

    @property
    def name(self) -> str:
        """Its name now; empty: it has none."""
        return self.state.name or ""

    @property
    def state(self) -> Entity:
        """Its fields now, as it was last set: pose at poseTime."""
        return Entity.from_json(self._ocean[f"entities.{self.key}"])


class ViewHandle(_Handle):
    """A camera: `ocean.views["bridge"]`."""
    _list = "views"

    @property
    def name(self) -> str:
        """The key of `ocean.views`."""
        return self.key

    @property
    def state(self) -> View:
        """Its fields now."""
        return View.from_json(self._ocean[f"views.{self.key}"])

    def frame(self, format: str = "jpg", *, width: int | None = None,
              height: int | None = None, time: float | None = None,
              quality: int | None = None, layers: Sequence[str] = (),
              float_samples: bool = False) -> Frame:
        """One picture.

        format        one of `pelagos.FORMATS`
        width, height [px] instead of the view's
        time          simulated time [s] instead of the clock's
        quality       of JPEG, 1 to 100
        layers        of EXR, names of `pelagos.LAYERS`; none: radiance
        float_samples EXR with 32-bit floats instead of halves (depth always)
        """
        return self._ocean.frame(self.key, format, width=width, height=height,
                                 time=time, quality=quality, layers=layers,
                                 float_samples=float_samples)

    def labels(self, *, width: int | None = None, height: int | None = None,
               time: float | None = None, image: bool = True) -> Labels:
        """Picture, depth, numbers of entities, classes and boxes, all of one
        moment."""
        return labels(self._ocean, self.key, width=width, height=height,
                      time=time, image=image)

    def horizon(self, *, width: int | None = None, height: int | None = None,
                time: float | None = None, refraction: float = 0.0
                ) -> Horizon:
        """Where its pictures have the horizon of a calm sea, by the pose and
        the eye's height above sea.level; refraction: see Camera.horizon."""
        level = self._ocean["sea.level"] or 0.0
        camera = self.camera(width, height, time)
        return camera.horizon(float(camera.position[2]) - level, refraction)

    def truth(self, *, width: int | None = None, height: int | None = None,
              time: float | None = None) -> "dict[str, Any]":
        """What a picture shows of entities: FrameTruth of the schema."""
        return self.frame("json", width=width, height=height,
                          time=time).truth()

    def image(self, *, width: int | None = None, height: int | None = None,
              time: float | None = None) -> "NDArray[np.uint8]":
        """One picture without loss: RGB, uint8, (height, width, 3)."""
        return self.frame("png", width=width, height=height, time=time).image()

    def layers(self, *names: str, width: int | None = None,
               height: int | None = None, time: float | None = None,
               float_samples: bool = False) -> "dict[str, NDArray[np.float32]]":
        """Layers of one picture, float32 (these three where none is named;
        see `frame` for the others):

        radiance  (height, width, 3), 680, 550, 440 nm [W m-2 sr-1 nm-1]
        depth     (height, width), distance along the ray [m], sky infinite
        normal    (height, width, 3), unit, east, north, up; sky 0

        and of the others

        position  (height, width, 3), float64: east, north, up of the origin
                  [m], as `Ocean.surface` takes and gives; sky 0
        """
        wanted = names or ("radiance", "depth", "normal")
        return self.frame("exr", width=width, height=height, time=time,
                          layers=wanted,
                          float_samples=float_samples).exr().layers

    def intrinsics(self, width: int | None = None,
                   height: int | None = None) -> Intrinsics:
        """K and rays of the view's pictures; asks for the state only."""
        return Intrinsics.of_view(self.state, width, height)

    def stand(self, entity: int, eye: "int | str" = 0) -> None:
        """Puts the camera at an eye point of an entity's model, as its bridge:
        by its number or name, as Ocean.models() has it."""
        state = self._ocean.state()
        model = next((e.model for e in state.entities if e.id == entity), None)
        known = None
        for _ in range(100):  # a shape is read within seconds of its first use
            known = next((m for m in self._ocean.models().models
                          if model and m.name == model.name), None)
            if known is None or known.bytes or known.error:
                break
            time.sleep(0.1)
        if model is None or known is None:
            raise LookupError(f"entity {entity} has no model")
        found = [p for i, p in enumerate(known.eyes) if eye in (i, p.name)]
        if not found:
            raise LookupError(
                f"{known.name} has no eye point {eye!r}; it has "
                f"{[p.name for p in known.eyes]}")
        scale = (model.length or known.length or 1) / (known.length or 1)
        self.set(entity=entity, level=False, **{
            name: round((getattr(found[0], name) or 0) * scale, 3)
            for name in ("forward", "right", "up")})

    def camera(self, width: int | None = None, height: int | None = None,
               time: float | None = None) -> Camera:
        """Intrinsics and pose at `time` (the clock's now). The daemon says
        where the camera is, by a picture of 16 x 16 pixels; where there is an
        EXR frame already, Camera.of_exr(frame.exr()) is free and exact."""
        small = self.frame("exr", width=16, height=16, time=time)
        pose = Camera.of_exr(small.exr())
        return replace(pose, intrinsics=self.intrinsics(width, height))

    def live(self, *, fps: float | None = None, quality: int | None = None,
             width: int | None = None, height: int | None = None,
             timeout: float = 10.0) -> LiveStream:
        """A live iterator over its pictures, always the newest. fps: at most
        so many, 0.1 to 240, over Motion-JPEG; quality: of JPEG, 1 to 100 (80);
        width, height [px]: instead of the view's, without fps; timeout: the
        longest wait for a picture [s]."""
        return LiveStream(self._ocean.transport, self.key, fps, quality,
                          width, height, timeout)

    def video(self, *, bitrate: int | None = None, width: int | None = None,
              height: int | None = None, timeout: float = 10.0) -> VideoStream:
        """Its H.264 access units as they are drawn, to save or to decode.
        bitrate: 100 to 100000 [kbit/s]; width, height [px]: instead of the
        view's; timeout: of the connection [s]."""
        return VideoStream(self._ocean.transport, self.key, bitrate, width,
                           height, timeout)


class Views:
    """`ocean.views`: by name, in the state's order."""

    def __init__(self, ocean: Ocean) -> None:
        self._ocean = ocean

    def __getitem__(self, name: str) -> ViewHandle:
        if name not in self:
            raise NotFound(404, {"code": "NOT_FOUND", "path": f"views.{name}",
                                 "detail": f"there is no view called {name}"})
        return ViewHandle(self._ocean, name)

    def add(self, name: str, **fields: Any) -> ViewHandle:
        """Adds a view, or sets fields of one that is there:

            ocean.views.add("wing", entity=1, right=12, up=15, yaw=90)
        """
        self._ocean.patch({"views": {name: fields}})
        return ViewHandle(self._ocean, name)

    def __delitem__(self, name: str) -> None:
        self[name].remove()

    def __contains__(self, name: object) -> bool:
        return name in self.names()

    def names(self) -> list[str]:
        """In the state's order."""
        return [view.name or "" for view in self._ocean.state().views]

    def __iter__(self) -> Iterator[ViewHandle]:
        return (ViewHandle(self._ocean, name) for name in self.names())

    def __len__(self) -> int:
        return len(self.names())


class Entities:
    """`ocean.entities`: by id, or by a name that one entity has."""

    def __init__(self, ocean: Ocean) -> None:
        self._ocean = ocean

    def __getitem__(self, key: int | str) -> EntityHandle:
        """The handle keeps the entity's id."""
        for entity in self._ocean.state().entities:
            if key == entity.id or key == entity.name or key == str(entity.id):
                return EntityHandle(self._ocean, str(entity.id))
        raise NotFound(404, {"code": "NOT_FOUND", "path": f"entities.{key}",
                             "detail": f"there is no entity {key}"})

    def add(self, id: int, **fields: Any) -> EntityHandle:
        """Adds an entity, or sets fields of one that is there:

            ocean.entities.add(7, name="buoy", latitude=52.601, longitude=5.2)
        """
        self._ocean.patch({"entities": {str(int(id)): fields}})
        return EntityHandle(self._ocean, str(int(id)))

    def __delitem__(self, key: int | str) -> None:
        self[key].remove()

    def __contains__(self, key: object) -> bool:
        return any(key in (entity.id, entity.name, str(entity.id))
                   for entity in self._ocean.state().entities)

    def ids(self) -> list[int]:
        """In the state's order."""
        return [entity.id or 0 for entity in self._ocean.state().entities]

    def names(self) -> list[str]:
        """As `ids`; empty where one has no name."""
        return [entity.name or "" for entity in self._ocean.state().entities]

    def __iter__(self) -> Iterator[EntityHandle]:
        return (EntityHandle(self._ocean, str(id)) for id in self.ids())

    def __len__(self) -> int:
        return len(self.ids())
