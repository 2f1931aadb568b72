"""From views to the pinhole camera of computer vision.

Axes, as in OpenCV. Picture: u to the right, v down, in pixels; the outer
corner of the upper left pixel is (0, 0), its centre (0.5, 0.5) (functions that
count centres in whole numbers want K[:2, 2] - 0.5). Camera: x to the
right, y down, z along the line of sight. World: metres east, north and up of
the scene's origin. About each eye the daemon lays that map on a sphere, so that
the horizon dips and what is far sinks: of a point X of the world

    d = bent(X - position)            as it is seen: right up at the eye
    x = R @ d                         rotation R, (3, 3)
    (u, v, 1) = K @ x / x[2]          intrinsics K, (3, 3)

Camera.project and Camera.unproject do all of it. At 1 km what is far has sunk
by 8 cm, at 8 km by 5 m.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import need
from .errors import BadPicture
from .exr import Exr
from .schema import View

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray


#: Radius of the sphere that the daemon lays the sea on [m].
EARTH_RADIUS = 6360000.0
#: Of air as it mostly is: what light bends, over what the Earth does.
STANDARD_REFRACTION = 0.13


@dataclass(frozen=True)
class Horizon:
    """Where a camera sees the horizon of a calm sea.

    dip       below the level [deg]
    distance  along the sea [m]
    rows      for each column's centre the row v where it is [px], float64,
              (width,): sky is above it, sea below; outside 0..height it is not
              in the picture; NaN: the column does not meet it
    left, right  v at the picture's left and right edge [px]
    tilt      of it in the picture's middle [deg], its right side down positive
    """
    dip: float
    distance: float
    rows: "NDArray[np.float64]"
    left: float
    right: float
    tilt: float


@dataclass(frozen=True)
class Intrinsics:
    """Picture of width x height pixels; left, right, top, bottom: tangents of
    the angles from the camera's axis to the picture's edges, left and bottom
    negative where they lie left of or below the axis."""
    width: int
    height: int
    left: float
    right: float
    top: float
    bottom: float

    @staticmethod
    def of_view(view: View, width: int | None = None,
                height: int | None = None) -> Intrinsics:
        """Of a view's state; width, height: of the picture asked for, where
        not the view's own. The vertical field follows the ratio, as the
        daemon does it."""
        wide, high = width or view.width, height or view.height
        if view.frustum is not None:
            f = view.frustum
            left, right, top, bottom = (
                math.tan(math.radians(angle or 0.0))
                for angle in (f.left, f.right, f.top, f.bottom))
        else:
            right = math.tan(math.radians(view.fieldOfView) / 2)
            top = right * view.height / view.width
            left, bottom = -right, -top
        stretch = (high / wide) * (view.width / view.height)
        return Intrinsics(wide, high, left, right, top * stretch,
                          bottom * stretch)

    @property
    def K(self) -> "NDArray[np.float64]":
        """The matrix K, (3, 3), pixels."""
        np = need.numpy()
        fx = self.width / (self.right - self.left)
        fy = self.height / (self.top - self.bottom)
        return np.array([[fx, 0.0, -self.left * fx],
                         [0.0, fy, self.top * fy],
                         [0.0, 0.0, 1.0]])

    def rays(self) -> "NDArray[np.float64]":
        """Unit directions through the pixels' centres in the camera's axes,
        (height, width, 3)."""
        np = need.numpy()
        u = (np.arange(self.width) + 0.5) / self.width
        v = (np.arange(self.height) + 0.5) / self.height
        x = self.left + u * (self.right - self.left)
        y = -(self.top - v * (self.top - self.bottom))
        out = np.empty((self.height, self.width, 3))
        out[..., 0] = x[None, :]
        out[..., 1] = y[:, None]
        out[..., 2] = 1.0
        return out / np.linalg.norm(out, axis=-1, keepdims=True)


def _bent(off: "NDArray[np.float64]") -> "NDArray[np.float64]":
    """From the eye as it is seen, (..., 3), of what the map has that far to the
    east, north and up (server/scene/globe.c)."""
    np = need.numpy()
    arc = np.hypot(off[..., 0], off[..., 1])
    flat = arc
    # flat = arc cos(flat / 2R): each round is (arc / 2R)^2 nearer.
    for _ in range(12):
        flat = arc * np.cos(0.5 * flat / EARTH_RADIUS)
    share = np.divide(flat, arc, out=np.ones_like(arc), where=arc > 0)
    return np.stack([share * off[..., 0], share * off[..., 1],
                     off[..., 2] - _drop(flat)], -1)


def _laid(off: "NDArray[np.float64]") -> "NDArray[np.float64]":
    """The inverse of _bent."""
    np = need.numpy()
    flat = np.hypot(off[..., 0], off[..., 1])
    stretch = 1.0 / np.cos(0.5 * flat / EARTH_RADIUS)
    return np.stack([stretch * off[..., 0], stretch * off[..., 1],
                     off[..., 2] + _drop(flat)], -1)


def _drop(flat: "NDArray[np.float64]") -> "NDArray[np.float64]":
    """Depth of the sphere below the eye's level."""
    np = need.numpy()
    half = np.sin(0.5 * flat / EARTH_RADIUS)
    return 2.0 * EARTH_RADIUS * half * half


@dataclass(frozen=True)
class Camera:
    """Intrinsics and pose.

    rotation  world to camera, float64, (3, 3)
    position  of the eye: east, north, up [m], float64, (3,)
    """
    intrinsics: Intrinsics
    rotation: "NDArray[np.float64]"
    position: "NDArray[np.float64]"

    @staticmethod
    def of_exr(picture: Exr) -> Camera:
        """The camera that took an EXR of pelagosd, from its attributes. They
        are single floats: the pose is good to a millimetre within 10 km of
        the origin."""
        np = need.numpy()
        try:
            a = picture.attributes
            matrix = np.asarray(a["worldToCamera"], np.float64)
            (center_x, center_y), across = (a["screenWindowCenter"],
                                            a["screenWindowWidth"])
            aspect = a["pixelAspectRatio"]
        except KeyError as error:
            raise BadPicture(f"the EXR file has no {error.args[0]}: it is not "
                             "one of pelagosd") from None
        # Row vectors and y up in the file; columns and y down here.
        rotation = matrix[:3, :3].T * np.array([[1.0], [-1.0], [1.0]])
        position = -matrix[:3, :3] @ matrix[3, :3]
        high = across / aspect * picture.height / picture.width
        return Camera(
            Intrinsics(picture.width, picture.height, center_x - across / 2,
                       center_x + across / 2, center_y + high / 2,
                       center_y - high / 2),
            rotation, position)

    def project(self, points: "ArrayLike") -> "NDArray[np.float64]":
        """Pixels (u, v), (..., 2), of points of the world, (..., 3): east,
        north, up [m], on the curved sea. NaN for what lies behind the camera."""
        np = need.numpy()
        x = _bent(np.asarray(points, np.float64)
                  - self.position) @ self.rotation.T
        z = np.where(x[..., 2:] > 0, x[..., 2:], np.nan)
        return ((x / z) @ self.intrinsics.K.T)[..., :2]

    def unproject(self, depth: "ArrayLike") -> "NDArray[np.float64]":
        """Points of the world, (height, width, 3): east, north, and up from
        the sea's level there, from the depth layer (distance along the ray
        [m], (height, width)). NaN for the sky."""
        np = need.numpy()
        distance = np.asarray(depth, np.float64)
        shape = (self.intrinsics.height, self.intrinsics.width)
        if distance.shape != shape:
            raise ValueError(f"depth has the shape {distance.shape}, the "
                             f"camera {shape}")
        distance = np.where(np.isfinite(distance), distance, np.nan)
        rays = self.intrinsics.rays() @ self.rotation
        return self.position + _laid(distance[..., None] * rays)

    def horizon(self, height: float | None = None,
                refraction: float = 0.0) -> Horizon:
        """The horizon of a calm sea.

        height      of the eye above the sea [m]; none: above altitude 0
        refraction  what light bends along its way, over what the Earth does:
                    0, as pictures are drawn (their rays are straight), or
                    STANDARD_REFRACTION to know where a real camera would have
                    it; below 1
        """
        np = need.numpy()
        high = float(self.position[2]) if height is None else float(height)
        if not high > 0:
            raise ValueError(f"an eye {high:g} m above the sea has no horizon")
        if not refraction < 1:
            raise ValueError(f"refraction is below 1, not {refraction:g}")
        radius = EARTH_RADIUS / (1 - refraction)
        # acos(radius / (radius + high)), whose digits go where high is small.
        dip = math.atan2(math.sqrt(high * (2 * radius + high)), radius)
        i = self.intrinsics
        u = np.concatenate([(np.arange(i.width) + 0.5) / i.width, [0.0, 1.0]])
        rows = self._rows(i.left + u * (i.right - i.left), -math.sin(dip))
        middle = i.width // 2
        pixel = i.width / (i.right - i.left) * (i.top - i.bottom) / i.height
        tilt = math.degrees(math.atan(
            (rows[middle] - rows[middle - 1]) * pixel))
        return Horizon(math.degrees(dip), radius * dip, rows[:-2],
                       float(rows[-2]), float(rows[-1]), tilt)

    def _rows(self, x: "NDArray[np.float64]",
              sine: float) -> "NDArray[np.float64]":
        """Rows at which directions (x, y, 1) of the camera have this sine of
        elevation: of two, the one nearer the picture's middle."""
        np = need.numpy()
        i = self.intrinsics
        up = self.rotation[:, 2]
        # up . (x, y, 1) = sine |(x, y, 1)|, squared: a quadratic in y.
        a = up[0] * x + up[2]
        two, one = up[1] ** 2 - sine ** 2, 2 * a * up[1]
        none = a ** 2 - sine ** 2 * (x ** 2 + 1)
        with np.errstate(invalid="ignore", divide="ignore"):
            root = np.sqrt(one ** 2 - 4 * two * none)
            y = np.stack([(-one + root) / (2 * two), (-one - root) / (2 * two)])
            off = np.abs((a + up[1] * y) - sine * np.sqrt(x ** 2 + y ** 2 + 1))
            y = np.where(off < 1e-9 * (1 + np.abs(y)), y, np.nan)
        away = np.abs(y + 0.5 * (i.top + i.bottom))
        first = np.nan_to_num(away[0], nan=np.inf) <= np.nan_to_num(
            away[1], nan=np.inf)
        return ((np.where(first, y[0], y[1]) + i.top)
                / (i.top - i.bottom) * i.height)

    def to_json(self) -> dict[str, Any]:
        """K, rotation, position and size, as lists."""
        i = self.intrinsics
        return {"width": i.width, "height": i.height, "K": i.K.tolist(),
                "rotation": self.rotation.tolist(),
                "position": self.position.tolist()}
