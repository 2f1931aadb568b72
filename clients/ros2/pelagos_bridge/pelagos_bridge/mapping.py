"""Messages of ROS 2 and values of Pelagos, each from the other. Pure functions:
message classes come in as `types` (an object with Image, CameraInfo, ... as
attributes), so nothing of ROS is imported here.

Frames, after REP 103 and REP 105:

    earth      ECEF of WGS 84
    map        east, north, up of Pelagos' origin [m]. It is the azimuthal
               equidistant map of the scene, which leaves the plane that touches
               the ellipsoid there by 2 cm up at 500 m (7.8 cm at 1 km), and by
               4 mm sideways at 10 km
    base_link  of the entity: x forward, y to port, z up
    NAME_optical_frame  of a view: x right, y down, z ahead

Latitudes, longitudes and heights are WGS 84's, as REP 147 has them for
geographic interfaces; `altitude` of Pelagos is taken for the height above the
ellipsoid, since the scene knows no geoid. Angles of Pelagos are compass
degrees; those of ROS radians, anticlockwise from east.
"""
from __future__ import annotations

import math
from typing import Any

import numpy as np

from pelagos import (Camera, Intrinsics, Origin, Surface, convergence,
                     to_geographic, to_local)

Quaternion = tuple[float, float, float, float]  # x, y, z, w

# --- angles ----------------------------------------------------------------


def quaternion_of(rotation: Any) -> Quaternion:
    """Of a rotation matrix, (3, 3): columns are the child's axes."""
    m = np.asarray(rotation, float)
    # The largest of the four squares is never small (Shepperd 1978).
    squares = np.array([1 + m[0, 0] - m[1, 1] - m[2, 2],
                        1 - m[0, 0] + m[1, 1] - m[2, 2],
                        1 - m[0, 0] - m[1, 1] + m[2, 2],
                        1 + m[0, 0] + m[1, 1] + m[2, 2]])
    k = int(squares.argmax())
    a, b, c = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]
    d, e, f = m[1, 0] + m[0, 1], m[0, 2] + m[2, 0], m[2, 1] + m[1, 2]
    s = squares[k]
    q = np.array(((s, d, e, a), (d, s, f, b), (e, f, s, c), (a, b, c, s))[k])
    q /= np.linalg.norm(q)
    x, y, z, w = (float(v) for v in (q if q[3] >= 0 else -q))
    return x, y, z, w


def matrix_of(q: Quaternion) -> Any:
    """Of a quaternion of any length but 0."""
    x, y, z, w = np.array(q, float) / np.linalg.norm(q)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def body_rotation(heading: float, pitch: float, roll: float) -> Any:
    """base_link to map of an entity: heading clockwise from north, pitch bow
    up, roll starboard down [deg]."""
    yaw, tip, heel = np.radians((90.0 - heading, -pitch, roll))
    cy, sy, cp, sp, cr, sr = (np.cos(yaw), np.sin(yaw), np.cos(tip),
                              np.sin(tip), np.cos(heel), np.sin(heel))
    return np.array([
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr]])


def attitude_of(rotation: Any) -> tuple[float, float, float]:
    """Heading (0..360), pitch, roll [deg]: the inverse."""
    m = np.asarray(rotation, float)
    yaw = math.degrees(math.atan2(m[1, 0], m[0, 0]))
    tip = math.degrees(math.asin(max(-1.0, min(1.0, -m[2, 0]))))
    heel = math.degrees(math.atan2(m[2, 1], m[2, 2]))
    return (90.0 - yaw) % 360.0, -tip, heel


# --- headers, clock, transforms ----------------------------------------------


def stamp(types: Any, seconds: float) -> Any:
    """Simulated time as a stamp; nanoseconds are rounded."""
    whole = round(seconds * 1e9)
    return types.Time(sec=whole // 10**9, nanosec=whole % 10**9)


def seconds_of(time: Any) -> float:
    return float(time.sec) + 1e-9 * float(time.nanosec)


def header(types: Any, seconds: float, frame: str) -> Any:
    return types.Header(stamp=stamp(types, seconds), frame_id=frame)


def clock(types: Any, seconds: float) -> Any:
    """rosgraph_msgs/Clock."""
    return types.Clock(clock=stamp(types, seconds))


def transform(types: Any, seconds: float, parent: str, child: str,
              place: Any, rotation: Any) -> Any:
    """geometry_msgs/TransformStamped: rotation's columns are the child's axes
    in the parent's."""
    x, y, z, w = quaternion_of(rotation)
    px, py, pz = (float(v) for v in place)
    return types.TransformStamped(
        header=header(types, seconds, parent), child_frame_id=child,
        transform=types.Transform(
            translation=types.Vector3(x=px, y=py, z=pz),
            rotation=types.Quaternion(x=x, y=y, z=z, w=w)))


def entity_transform(types: Any, seconds: float, parent: str, child: str,
                     entity: Any, origin: Origin) -> Any:
    """map to base_link, of an entity whose pose is of this moment."""
    at = to_local(entity.latitude, entity.longitude, origin)
    turn = convergence(entity.latitude, entity.longitude, origin)
    return transform(types, seconds, parent, child,
                     (at.east, at.north, entity.altitude),
                     body_rotation(entity.heading + turn, entity.pitch,
                                   entity.roll))


def camera_transform(types: Any, seconds: float, parent: str, child: str,
                     camera: Camera) -> Any:
    """map to the optical frame."""
    return transform(types, seconds, parent, child, camera.position,
                     camera.rotation.T)


def earth_transform(types: Any, seconds: float, parent: str, child: str,
                    origin: Origin) -> Any:
    """earth (ECEF) to map (east, north, up of the origin)."""
    lat, lon = math.radians(origin.latitude), math.radians(origin.longitude)
    axis, flat = 6378137.0, 1 / 298.257223563
    ratio = flat * (2 - flat)
    radius = axis / math.sqrt(1 - ratio * math.sin(lat) ** 2)
    place = (radius * math.cos(lat) * math.cos(lon),
             radius * math.cos(lat) * math.sin(lon),
             radius * (1 - ratio) * math.sin(lat))
    east = (-math.sin(lon), math.cos(lon), 0.0)
    north = (-math.sin(lat) * math.cos(lon), -math.sin(lat) * math.sin(lon),
             math.cos(lat))
    up = (math.cos(lat) * math.cos(lon), math.cos(lat) * math.sin(lon),
          math.sin(lat))
    return transform(types, seconds, parent, child, place,
                     np.array([east, north, up]).T)


# --- pictures ------------------------------------------------------------------


def image(types: Any, seconds: float, frame: str, picture: Any) -> Any:
    """sensor_msgs/Image of RGB, uint8, (height, width, 3)."""
    high, wide, _ = picture.shape
    return types.Image(
        header=header(types, seconds, frame), height=high, width=wide,
        encoding="rgb8", is_bigendian=0, step=3 * wide,
        data=np.ascontiguousarray(picture, np.uint8).tobytes())


def compressed(types: Any, seconds: float, frame: str, data: bytes) -> Any:
    """sensor_msgs/CompressedImage of a JPEG's bytes."""
    return types.CompressedImage(header=header(types, seconds, frame),
                                 format="jpeg", data=data)


def depth_image(types: Any, seconds: float, frame: str, depth: Any,
                intrinsics: Intrinsics) -> Any:
    """sensor_msgs/Image, 32FC1 in metres along the optical axis (REP 118, not
    along the ray as Pelagos' layer is); the sky is +Inf: beyond all range."""
    along = np.asarray(depth, float) * intrinsics.rays()[..., 2]
    high, wide = along.shape
    return types.Image(
        header=header(types, seconds, frame), height=high, width=wide,
        encoding="32FC1", is_bigendian=0, step=4 * wide,
        data=along.astype("<f4").tobytes())


def camera_info(types: Any, seconds: float, frame: str,
                intrinsics: Intrinsics) -> Any:
    """sensor_msgs/CameraInfo of a pinhole without distortion. ROS counts
    pixels from the middle of the upper left one, Pelagos from its corner."""
    K = intrinsics.K.copy()
    K[:2, 2] -= 0.5
    projection = np.concatenate([K, np.zeros((3, 1))], 1)
    return types.CameraInfo(
        header=header(types, seconds, frame), height=intrinsics.height,
        width=intrinsics.width, distortion_model="plumb_bob", d=[0.0] * 5,
        k=K.ravel().tolist(), r=np.eye(3).ravel().tolist(),
        p=projection.ravel().tolist(), binning_x=0, binning_y=0)


# --- vessels --------------------------------------------------------------------


def odometry_entity(odometry: Any, origin: Origin) -> dict[str, float]:
    """Fields of an entity of a nav_msgs/Odometry whose pose is in map and whose
    twist is in base_link. ValueError where a number is not finite or the
    orientation is not a rotation."""
    pose, twist = odometry.pose.pose, odometry.twist.twist
    o, p = pose.orientation, pose.position
    numbers = np.array([p.x, p.y, p.z, o.x, o.y, o.z, o.w, twist.linear.x,
                        twist.linear.y, twist.linear.z, twist.angular.x,
                        twist.angular.y, twist.angular.z], float)
    if not np.isfinite(numbers).all():
        raise ValueError("the odometry has a number that is not finite")
    if np.linalg.norm(numbers[3:7]) < 1e-6:
        raise ValueError("the odometry's orientation is no rotation: all of it "
                         "is 0")
    rotation = matrix_of((o.x, o.y, o.z, o.w))
    place = to_geographic(p.x, p.y, origin)
    turn = convergence(place.latitude, place.longitude, origin)
    heading, pitch, roll = attitude_of(rotation)
    east, north, climb = rotation @ numbers[7:10]
    speed = math.hypot(east, north)
    course = (math.degrees(math.atan2(east, north)) if speed > 1e-3
              else heading)
    # Rates of the angles from those about the body's axes.
    wx, wy, wz = numbers[10:13]
    tip, heel = math.radians(-pitch), math.radians(roll)
    turning = ((wy * math.sin(heel) + wz * math.cos(heel))
               / max(math.cos(tip), 1e-6))
    rates = np.degrees([-turning,
                        -(wy * math.cos(heel) - wz * math.sin(heel)),
                        wx + turning * math.sin(tip)])
    turn_rate, pitch_rate, roll_rate = (float(r) for r in rates)
    return {"latitude": place.latitude, "longitude": place.longitude,
            "altitude": float(p.z), "heading": (heading - turn) % 360.0,
            "pitch": pitch, "roll": roll, "speed": float(speed),
            "course": (course - turn) % 360.0, "turnRate": turn_rate,
            "climbRate": float(climb), "pitchRate": pitch_rate,
            "rollRate": roll_rate}


def entity_odometry(types: Any, seconds: float, frame: str, child: str,
                    entity: Any, origin: Origin) -> Any:
    """nav_msgs/Odometry of an entity: where it is, and how it goes."""
    at = to_local(entity.latitude, entity.longitude, origin)
    turn = convergence(entity.latitude, entity.longitude, origin)
    rotation = body_rotation(entity.heading + turn, entity.pitch, entity.roll)
    course = math.radians(entity.course + turn)
    u, v, w = (float(n) for n in rotation.T @ (
        entity.speed * math.sin(course), entity.speed * math.cos(course),
        entity.climbRate))
    tip, heel = math.radians(-entity.pitch), math.radians(entity.roll)
    turning = -math.radians(entity.turnRate)
    tipping = -math.radians(entity.pitchRate)
    heeling = math.radians(entity.rollRate)
    wx = heeling - turning * math.sin(tip)
    wy = tipping * math.cos(heel) + turning * math.cos(tip) * math.sin(heel)
    wz = turning * math.cos(tip) * math.cos(heel) - tipping * math.sin(heel)
    x, y, z, q = quaternion_of(rotation)
    return types.Odometry(
        header=header(types, seconds, frame), child_frame_id=child,
        pose=types.PoseWithCovariance(pose=types.Pose(
            position=types.Point(x=at.east, y=at.north,
                                 z=float(entity.altitude)),
            orientation=types.Quaternion(x=x, y=y, z=z, w=q))),
        twist=types.TwistWithCovariance(twist=types.Twist(
            linear=types.Vector3(x=u, y=v, z=w),
            angular=types.Vector3(x=wx, y=wy, z=wz))))


def fix(types: Any, seconds: float, frame: str, entity: Any) -> Any:
    """sensor_msgs/NavSatFix of where an entity is."""
    return types.NavSatFix(
        header=header(types, seconds, frame),
        status=types.NavSatStatus(status=0, service=1),
        latitude=float(entity.latitude), longitude=float(entity.longitude),
        altitude=float(entity.altitude), position_covariance_type=0)


# --- waves ------------------------------------------------------------------------


def wave_points(request: Any) -> Any:
    """(n, 2), east and north of map, of pelagos_msgs/srv/WaveHeights."""
    points = np.array([(p.x, p.y) for p in request.points], float)
    if len(points) == 0:
        raise ValueError("no points are asked for")
    if not np.isfinite(points).all():
        raise ValueError("a point is not finite")
    return points


def wave_answer(types: Any, answer: Any, surface: Surface) -> Any:
    """Fills the answer of pelagos_msgs/srv/WaveHeights."""
    answer.success, answer.message = True, ""
    answer.stamp = stamp(types, surface.time)
    answer.heights = [float(h) for h in surface.height]
    answer.normals = [types.Vector3(x=float(x), y=float(y), z=float(z))
                      for x, y, z in surface.normal]
    answer.velocities = [types.Vector3(x=float(x), y=float(y), z=float(z))
                         for x, y, z in surface.velocity]
    return answer


def wave_failure(answer: Any, reason: str) -> Any:
    answer.success, answer.message = False, reason
    return answer
