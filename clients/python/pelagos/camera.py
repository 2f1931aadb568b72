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
by 8 cm, at 8 km by 5 m. From 20 km above the sea on the sphere is the WGS 84
ellipsoid, as pictures from there show it.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import need
from .errors import BadPicture
from .exr import Exr
from .geo import arrival
from .schema import Origin, View

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray


#: Radius of the sphere that the daemon lays the sea on [m].
EARTH_RADIUS = 6360000.0
#: Height above the sea from which pictures show the ellipsoid instead [m].
SPACE = 20000.0
_MAJOR, _MINOR = 6378137.0, 6356752.314245179  # WGS 84 [m]
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


class _Sphere:
    """The map as it is laid about an eye near the sea (server/scene/globe.c).
    Offsets are from the eye, (..., 3): east, north, up [m]."""

    def bent(self, off: "NDArray[np.float64]") -> "NDArray[np.float64]":
        """What the map has there, as it is seen."""
        np = need.numpy()
        arc = np.hypot(off[..., 0], off[..., 1])
        flat = arc
        # flat = arc cos(flat / 2R): each round is (arc / 2R)^2 nearer.
        for _ in range(12):
            flat = arc * np.cos(0.5 * flat / EARTH_RADIUS)
        share = np.divide(flat, arc, out=np.ones_like(arc), where=arc > 0)
        return np.stack([share * off[..., 0], share * off[..., 1],
                         off[..., 2] - self._drop(flat)], -1)

    def laid(self, off: "NDArray[np.float64]") -> "NDArray[np.float64]":
        """The inverse of bent."""
        np = need.numpy()
        flat = np.hypot(off[..., 0], off[..., 1])
        stretch = 1.0 / np.cos(0.5 * flat / EARTH_RADIUS)
        return np.stack([stretch * off[..., 0], stretch * off[..., 1],
                         off[..., 2] + self._drop(flat)], -1)

    def _drop(self, flat: "NDArray[np.float64]") -> "NDArray[np.float64]":
        """Depth of the sphere below the eye's level."""
        np = need.numpy()
        half = np.sin(0.5 * flat / EARTH_RADIUS)
        return 2.0 * EARTH_RADIUS * half * half


class _Ellipsoid:
    """The same of an eye high up: WGS 84, made a sphere by an affine map, in
    whose frame the eye stands on the z axis (server/render/spacegeometry.c).

    matrix  of directions and lengths into that frame, (3, 3)
    eye     distance of the eye from its middle [m]
    """

    def __init__(self, height: float, latitude: float, turn: float) -> None:
        """height above the ellipsoid [m], geodetic latitude [deg], the map's
        north clockwise of true north [rad]."""
        np = need.numpy()
        self.height = height
        f = math.radians(latitude)
        up = np.array([math.cos(f), 0.0, math.sin(f)])
        east, north = np.array([0.0, 1.0, 0.0]), np.array([-up[2], 0.0, up[0]])
        axes = np.stack([math.cos(turn) * east + math.sin(turn) * north,
                         math.cos(turn) * north - math.sin(turn) * east, up])
        half = np.array([_MAJOR, _MAJOR, _MINOR])
        eye = up * half ** 2 / np.linalg.norm(up * half) + up * height
        eye, axes = EARTH_RADIUS * eye / half, EARTH_RADIUS * axes / half
        self.eye = float(np.linalg.norm(eye))
        z = eye / self.eye
        x = axes[0] - z * (z @ axes[0])
        x /= np.linalg.norm(x)
        self.matrix = np.stack([x, np.cross(z, x), z]) @ axes.T

    def laid(self, off: "NDArray[np.float64]") -> "NDArray[np.float64]":
        np = need.numpy()
        at = off @ self.matrix.T + np.array([0.0, 0.0, self.eye])
        flat = np.hypot(at[..., 0], at[..., 1])
        angle = np.arctan2(flat, at[..., 2])
        far = np.linalg.norm(at, axis=-1)
        stretch = np.divide(angle * far, flat, out=np.ones_like(flat),
                            where=flat > 0)
        return np.stack([stretch * off[..., 0], stretch * off[..., 1],
                         far - EARTH_RADIUS - self.height], -1)

    def bent(self, off: "NDArray[np.float64]") -> "NDArray[np.float64]":
        """NaN beyond a quarter of the way round."""
        np = need.numpy()
        radius = EARTH_RADIUS + off[..., 2] + self.height
        share = np.ones_like(radius)
        a = float(self.matrix[:, 2] @ self.matrix[:, 2])
        for _ in range(8):  # the angle hardly depends on the share
            level = share[..., None] * off[..., :2] @ self.matrix[:, :2].T
            level = level + np.array([0.0, 0.0, self.eye])
            b = level @ self.matrix[:, 2]
            c = (level * level).sum(-1) - radius ** 2
            with np.errstate(invalid="ignore"):
                up = (np.sqrt(b * b - a * c) - b) / a
            at = level + up[..., None] * self.matrix[:, 2]
            angle = np.hypot(at[..., 0], at[..., 1]) / radius / share
            share = np.where(angle < 0.5 * math.pi, np.sinc(angle / math.pi),
                             np.nan)
        return np.stack([share * off[..., 0], share * off[..., 1], up], -1)


def _met(base: "NDArray[np.float64]", along: "NDArray[np.float64]",
         sine: float) -> "NDArray[np.float64]":
    """The two y, (2, n), at which base + y along, (n, 3), has this sine of
    elevation; NaN: there is none."""
    np = need.numpy()
    # (base + y along).z = sine |base + y along|, squared: a quadratic in y.
    two = along[2] ** 2 - sine ** 2 * (along @ along)
    one = 2 * (base[:, 2] * along[2] - sine ** 2 * (base @ along))
    none = base[:, 2] ** 2 - sine ** 2 * (base * base).sum(-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(one ** 2 - 4 * two * none)
        y = np.stack([-one + root, -one - root]) / (2 * two)
        at = base + y[..., None] * along
        off = np.abs(at[..., 2] - sine * np.linalg.norm(at, axis=-1))
        return np.where(off < 1e-9 * (1 + np.abs(y)), y, np.nan)


@dataclass(frozen=True)
class Camera:
    """Intrinsics and pose.

    rotation  world to camera, float64, (3, 3)
    position  of the eye: east, north, up [m], float64, (3,)
    origin    of the world's east and north
    level     of the sea there, altitude [m]
    """
    intrinsics: Intrinsics
    rotation: "NDArray[np.float64]"
    position: "NDArray[np.float64]"
    origin: Origin = Origin()
    level: float = 0.0

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
        origin = Origin(*(float(a.get(f"pelagos.origin{axis}", own))
                          for axis, own in (("Latitude", Origin.latitude),
                                            ("Longitude", Origin.longitude))))
        return Camera(
            Intrinsics(picture.width, picture.height, center_x - across / 2,
                       center_x + across / 2, center_y + high / 2,
                       center_y - high / 2),
            rotation, position, origin, float(a.get("pelagos.seaLevel", 0.0)))

    @property
    def _globe(self) -> "_Sphere | _Ellipsoid":
        height = float(self.position[2]) - self.level
        return _Sphere() if height < SPACE else self._below(height)

    def _below(self, height: float) -> _Ellipsoid:
        east, north = (float(v) for v in self.position[:2])
        there, turn = arrival(east, north, self.origin)
        return _Ellipsoid(height, there.latitude, turn)

    def project(self, points: "ArrayLike") -> "NDArray[np.float64]":
        """Pixels (u, v), (..., 2), of points of the world, (..., 3): east,
        north, up [m], on the curved sea. NaN for what lies behind the camera."""
        np = need.numpy()
        x = self._globe.bent(np.asarray(points, np.float64)
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
        return self.position + self._globe.laid(distance[..., None] * rays)

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
        i = self.intrinsics
        u = np.concatenate([(np.arange(i.width) + 0.5) / i.width, [0.0, 1.0]])
        x = i.left + u * (i.right - i.left)
        if high >= SPACE and refraction == 0:
            dip, distance, rows = self._limb(self._below(high), x)
        else:
            radius = EARTH_RADIUS / (1 - refraction)
            # acos(radius / (radius + high)), whose digits go where high is
            # small.
            dip = math.atan2(math.sqrt(high * (2 * radius + high)), radius)
            distance = radius * dip
            rows = self._rows(x, -math.sin(dip), np.eye(3))
        middle = i.width // 2
        pixel = i.width / (i.right - i.left) * (i.top - i.bottom) / i.height
        tilt = math.degrees(math.atan(
            (rows[middle] - rows[middle - 1]) * pixel))
        return Horizon(math.degrees(dip), distance, rows[:-2],
                       float(rows[-2]), float(rows[-1]), tilt)

    def _limb(self, globe: _Ellipsoid, x: "NDArray[np.float64]"
              ) -> "tuple[float, float, NDArray[np.float64]]":
        """Dip [rad] and distance of the ellipsoid's edge where the camera
        looks, and its rows."""
        np = need.numpy()
        tangent = math.sqrt(globe.eye ** 2 - EARTH_RADIUS ** 2)
        sine = -tangent / globe.eye
        ahead = math.atan2(*self.rotation[2, :2])
        level = np.array([[math.sin(ahead), math.cos(ahead), 0.0]])
        low = np.nanmin(_met(level @ globe.matrix.T, globe.matrix[:, 2], sine))
        way = level[0] + np.array([0.0, 0.0, low])
        way *= tangent / np.linalg.norm(globe.matrix @ way)
        return (-math.atan(low), float(np.hypot(*globe.laid(way)[:2])),
                self._rows(x, sine, globe.matrix))

    def _rows(self, x: "NDArray[np.float64]", sine: float,
              matrix: "NDArray[np.float64]") -> "NDArray[np.float64]":
        """Rows at which directions (x, y, 1) of the camera have this sine of
        elevation in the frame of matrix: of two, the one nearer the picture's
        middle."""
        np = need.numpy()
        i = self.intrinsics
        right, down, ahead = (matrix @ self.rotation.T).T
        y = _met(x[:, None] * right + ahead, down, sine)
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
