"""The sea surface at points, as arrays."""
from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import need
from .errors import ProtocolError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

# A query has at most 10,000 points and 512 KiB; 60 bytes a point is the most.
_AT_ONCE = 8000


@dataclass(frozen=True)
class Surface:
    """The surface at points of any shape (...,).

    time      simulated time of all of them [s]
    height    above mean sea level [m], float64, (...,)
    normal    unit normal, east, north, up, float64, (..., 3)
    velocity  of the water particle [m/s], east, north, up, float64, (..., 3)
    depth     of the bottom below mean sea level [m], negative on land, NaN
              where seabed.file has no data, float64, (...,)
    sounding  depth below the surface at this time [m], 0 where it is dry
    acceleration  of the water particle [m/s2], east, north, up, float64,
              (..., 3); None unless it was asked for
    foam      share of the water that dense foam hides, 0..1, before its fine
              structure, float64, (...,); None unless it was asked for
    """
    time: float
    height: "NDArray[np.float64]"
    normal: "NDArray[np.float64]"
    velocity: "NDArray[np.float64]"
    depth: "NDArray[np.float64]"
    sounding: "NDArray[np.float64]"
    acceleration: "NDArray[np.float64] | None" = None
    foam: "NDArray[np.float64] | None" = None


@dataclass(frozen=True)
class SurfaceSeries:
    """The surface at points (...,) at several times: as Surface, each array
    with the times as its first axis, (times, ...). `series[3]` and iteration
    give the Surface of one time."""
    time: "NDArray[np.float64]"
    height: "NDArray[np.float64]"
    normal: "NDArray[np.float64]"
    velocity: "NDArray[np.float64]"
    depth: "NDArray[np.float64]"
    sounding: "NDArray[np.float64]"
    acceleration: "NDArray[np.float64] | None" = None
    foam: "NDArray[np.float64] | None" = None

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, index: int) -> Surface:
        return Surface(
            float(self.time[index]), self.height[index], self.normal[index],
            self.velocity[index], self.depth[index], self.sounding[index],
            None if self.acceleration is None else self.acceleration[index],
            None if self.foam is None else self.foam[index])

    def __iter__(self) -> Iterator[Surface]:
        return (self[index] for index in range(len(self)))


def series(ask: Callable[[dict[str, Any]], Any], points: "ArrayLike",
           times: "ArrayLike", frame: int | None = None,
           acceleration: bool = False, foam: bool = False,
           moving: bool = False) -> SurfaceSeries:
    """moving: points are (times, ..., 2), those of each time."""
    np = need.numpy()
    when = np.asarray(times, np.float64)
    if when.ndim != 1 or len(when) == 0:
        raise ValueError("times are a list of at least one, not of the shape "
                         f"{when.shape}")
    at = np.asarray(points, np.float64)
    if moving and (at.ndim < 2 or len(at) != len(when)):
        raise ValueError(f"moving points have the shape ({len(when)}, ..., 2), "
                         f"as many as times, not {at.shape}")
    each = [query(ask, at[i] if moving else at, float(time), frame,
                  acceleration, foam) for i, time in enumerate(when)]

    def stack(name: str) -> Any:
        return np.stack([getattr(one, name) for one in each])

    return SurfaceSeries(
        when, stack("height"), stack("normal"), stack("velocity"),
        stack("depth"), stack("sounding"),
        stack("acceleration") if acceleration else None,
        stack("foam") if foam else None)


def query(ask: Callable[[dict[str, Any]], Any], points: "ArrayLike",
          time: float | None = None, frame: int | None = None,
          acceleration: bool = False, foam: bool = False) -> Surface:
    """points: (..., 2), east and north. ask: sends one query."""
    np = need.numpy()
    at = np.asarray(points, dtype=np.float64)
    if at.ndim < 1 or at.shape[-1] != 2:
        raise ValueError(f"points have the shape (..., 2), not {at.shape}")
    if not np.isfinite(at).all():
        raise ValueError("a point is not finite")
    flat = at.reshape(-1, 2)
    if len(flat) == 0:
        raise ValueError("a query has at least one point")
    values = np.empty((len(flat), 13))
    fixed: dict[str, Any] = {"acceleration": True} if acceleration else {}
    if foam:
        fixed["foam"] = True
    if frame is not None:
        fixed["frame"] = str(int(frame))
    for start in range(0, len(flat), _AT_ONCE):
        part = flat[start:start + _AT_ONCE]
        content: dict[str, Any] = {"points": part.tolist(), **fixed}
        if time is not None:
            content["time"] = float(time)
        answer = ask(content)
        try:
            # The first answer's time holds for all.
            time = float(answer["time"])
            rows = [(p["height"], *_vector(p["normal"]),
                     *_vector(p["velocity"]), p.get("depth", math.nan),
                     p.get("sounding", math.nan),
                     *_vector(p["acceleration"] if acceleration else {}),
                     p["foam"] if foam else 0.0)
                    for p in answer["points"]]
            values[start:start + len(part)] = rows
        except (KeyError, TypeError, ValueError) as error:
            raise ProtocolError(f"not a Surface: {error!r}") from None
    shape = at.shape[:-1]
    assert time is not None
    return Surface(time, values[:, 0].reshape(shape),
                   values[:, 1:4].reshape(*shape, 3),
                   values[:, 4:7].reshape(*shape, 3),
                   values[:, 7].reshape(shape), values[:, 8].reshape(shape),
                   values[:, 9:12].reshape(*shape, 3) if acceleration
                   else None, values[:, 12].reshape(shape) if foam else None)


def _vector(value: dict[str, float]) -> tuple[float, float, float]:
    return (value.get("east", 0.0), value.get("north", 0.0),
            value.get("up", 0.0))
