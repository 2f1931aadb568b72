"""What each pixel of a picture shows: entities, their classes, distances and
boxes, for detectors, trackers and their scores."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from . import need
from .camera import Camera
from .errors import Conflict
from .schema import FrameTruth, MODEL_CLASSES, PixelBox, SeenEntity

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .client import Ocean

_TRIES = 8


@dataclass(frozen=True)
class Box:
    """A box in a picture, in pixels from its upper left corner: of what is
    visible it is whole pixels, columns x to x + width - 1."""
    x: float
    y: float
    width: float
    height: float

    @property
    def area(self) -> float:
        """Pixels."""
        return self.width * self.height

    @property
    def corners(self) -> tuple[float, float, float, float]:
        """Left, top, right, bottom edge."""
        return (self.x, self.y, self.x + self.width, self.y + self.height)

    def overlap(self, other: Box) -> float:
        """Area of both over area of either (IoU), 0 to 1."""
        a, b = self.corners, other.corners
        wide = min(a[2], b[2]) - max(a[0], b[0])
        high = min(a[3], b[3]) - max(a[1], b[1])
        if wide <= 0 or high <= 0:
            return 0.0
        return wide * high / (self.area + other.area - wide * high)


@dataclass(frozen=True)
class LabelledEntity:
    """An entity that a picture shows, or would if nothing hid it.

    id        number of the entity
    kind      its model's class, one of `pelagos.MODEL_CLASSES`
    model     name of its model
    visible   box of the pixels that show it; None: none does
    whole     box of all of its shape above its waterline, whatever hides it;
              may reach beyond the picture
    pixels    that show it
    hidden    share of its shape in the picture that others, waves, land or
              the horizon hide, 0 to 1
    truncated its shape reaches beyond the picture
    distance  from the eye [m]
    bearing   from the eye, true [deg]
    seen      all that the daemon says of it
    """
    id: int
    kind: str
    model: str
    visible: Box | None
    whole: Box | None
    pixels: int
    hidden: float
    truncated: bool
    distance: float
    bearing: float
    seen: SeenEntity = field(repr=False)


@dataclass(frozen=True)
class Labels:
    """One moment of one view.

    view, time, revision  of the picture; time is simulated [s]
    image     RGB, uint8, (height, width, 3); None where it was not wanted
    depth     distance along the pixel's ray [m], float32, sky infinite
    ids       number of the entity that a pixel's middle shows, int32, -1 none
    classes   index into `pelagos.MODEL_CLASSES` of what that is, -1 none
    entities  those in the picture, those hidden wholly too
    camera    that took it
    truth     what the daemon says of the picture
    """
    view: str
    time: float
    revision: int
    image: "NDArray[np.uint8] | None"
    depth: "NDArray[np.float32]"
    ids: "NDArray[np.int32]"
    classes: "NDArray[np.int32]"
    entities: tuple[LabelledEntity, ...]
    camera: Camera
    truth: FrameTruth = field(repr=False)

    def mask(self, id: int) -> "NDArray[np.bool_]":
        """The pixels that show the entity, (height, width)."""
        return self.ids == id

    def box_of_ids(self, id: int) -> Box | None:
        """The box of these pixels, from the layer alone; None: there are
        none."""
        np = need.numpy()
        rows, columns = np.nonzero(self.mask(id))
        if len(rows) == 0:
            return None
        x, y = int(columns.min()), int(rows.min())
        return Box(x, y, int(columns.max()) - x + 1, int(rows.max()) - y + 1)

    def agreement(self) -> dict[int, float]:
        """Of each entity that is visible by the boxes or by the layer `id`,
        how well the two agree: overlap of the boxes, 0 to 1."""
        told = {e.id: e.visible for e in self.entities if e.visible}
        out = {}
        for id in sorted({*told, *self.visible_ids()}):
            one, other = told.get(id), self.box_of_ids(id)
            out[id] = one.overlap(other) if one and other else 0.0
        return out

    def visible_ids(self) -> list[int]:
        """Numbers of the entities that a pixel shows, ascending."""
        np = need.numpy()
        return [int(id) for id in np.unique(self.ids) if id >= 0]


def labels(ocean: Ocean, view: str, *, width: int | None = None,
           height: int | None = None, time: float | None = None,
           image: bool = True) -> Labels:
    """Picture, depth, numbers and boxes of a view, all of one moment and one
    state, also while the clock runs; Conflict where others change the state
    faster than pictures are drawn."""
    np = need.numpy()
    for _ in range(_TRIES):
        exr = ocean.frame(view, "exr", width=width, height=height, time=time,
                          layers=("depth", "id", "class"))
        told = ocean.frame(view, "json", width=width, height=height,
                           time=exr.time)
        shown = ocean.frame(view, "png", width=width, height=height,
                            time=exr.time) if image else exr
        if {exr.revision} == {told.revision, shown.revision}:
            break
    else:
        raise Conflict(409, {"code": "CONFLICT", "detail":
                             "the state changes between the pictures of one "
                             "moment: stop who changes it, or the clock"})
    picture = exr.exr()
    truth = FrameTruth.from_json(told.truth())
    return Labels(
        view, exr.time, exr.revision, shown.image() if image else None,
        picture["depth"].astype(np.float32, copy=False),
        picture["id"].astype(np.int64).astype(np.int32) - 1,
        picture["class"].astype(np.int32) - 1,
        tuple(map(_entity, truth.entities)), Camera.of_exr(picture), truth)


def _box(box: PixelBox | None) -> Box | None:
    if box is None:
        return None
    return Box(box.x or 0.0, box.y or 0.0, box.width or 0.0, box.height or 0.0)


def _entity(seen: SeenEntity) -> LabelledEntity:
    return LabelledEntity(
        seen.id or 0, seen.class_ or MODEL_CLASSES[0], seen.model or "",
        _box(seen.visible), _box(seen.whole), seen.pixels or 0,
        seen.hidden or 0.0, bool(seen.truncated), seen.distance or 0.0,
        seen.bearing or 0.0, seen)
