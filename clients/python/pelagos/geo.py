"""Places between degrees and the scene's metres, as the daemon has them.

The scene's frame is the azimuthal equidistant map about `origin`: metres along
the WGS 84 geodesic, split by its azimuth there into east and north. Standard
library only. Source: T. Vincenty, Survey Review 23(176), 1975."""
from __future__ import annotations

import math
from typing import NamedTuple

from .schema import Origin

_A = 6378137.0
_F = 1 / 298.257223563
_B = _A * (1 - _F)


class Local(NamedTuple):
    """East and north of the origin [m]."""
    east: float
    north: float


class Geographic(NamedTuple):
    """Geodetic latitude and longitude (-180..180) [deg]."""
    latitude: float
    longitude: float


def to_local(latitude: float, longitude: float,
             origin: Origin = Origin()) -> Local:
    """East and north of `origin` [m] of a place [deg]; within 1 mm to
    10,000 km. ValueError near the antipode, where there is no one way."""
    u1 = _reduced(origin.latitude)
    u2 = _reduced(latitude)
    away = math.radians(math.remainder(longitude - origin.longitude, 360.0))
    turn = away
    for _ in range(50):
        x = math.cos(u2) * math.sin(turn)
        y = (math.cos(u1) * math.sin(u2)
             - math.sin(u1) * math.cos(u2) * math.cos(turn))
        sine = math.hypot(x, y)
        cosine = (math.sin(u1) * math.sin(u2)
                  + math.cos(u1) * math.cos(u2) * math.cos(turn))
        if sine == 0.0:
            return Local(0.0, 0.0)
        arc = math.atan2(sine, cosine)
        alpha = math.cos(u1) * math.cos(u2) * math.sin(turn) / sine
        cos2 = 1 - alpha * alpha
        middle = (cosine - 2 * math.sin(u1) * math.sin(u2) / cos2
                  if cos2 > 1e-15 else 0.0)
        new = away + _lag(alpha, cos2, arc, sine, cosine, middle)
        change, turn = abs(new - turn), new
        if change < 1e-14:
            break
    else:
        raise ValueError(f"{latitude}, {longitude} is too near the antipode of "
                         "the origin")
    b = _series_b(cos2)
    distance = _B * _series_a(cos2) * (arc - _excess(b, sine, cosine, middle))
    azimuth = math.atan2(math.cos(u2) * math.sin(turn),
                         math.cos(u1) * math.sin(u2)
                         - math.sin(u1) * math.cos(u2) * math.cos(turn))
    return Local(distance * math.sin(azimuth), distance * math.cos(azimuth))


def to_geographic(east: float, north: float,
                  origin: Origin = Origin()) -> Geographic:
    """Latitude and longitude [deg] of a place [m]: the inverse."""
    return arrival(east, north, origin)[0]


def arrival(east: float, north: float,
            origin: Origin = Origin()) -> "tuple[Geographic, float]":
    """The same, and what the map's north has turned from true north on the way
    there by the geodesic from `origin` [rad, clockwise]."""
    distance = math.hypot(east, north)
    azimuth = math.atan2(east, north) if distance > 0 else 0.0
    u1 = _reduced(origin.latitude)
    begin = math.atan2(math.tan(u1), math.cos(azimuth))
    alpha = math.cos(u1) * math.sin(azimuth)
    cos2 = 1 - alpha * alpha
    b = _series_b(cos2)
    first = distance / (_B * _series_a(cos2))
    arc = first
    for _ in range(50):
        middle = math.cos(2 * begin + arc)
        new = first + _excess(b, math.sin(arc), math.cos(arc), middle)
        change, arc = abs(new - arc), new
        if change < 1e-15:
            break
    middle = math.cos(2 * begin + arc)
    sine, cosine = math.sin(arc), math.cos(arc)
    x = math.sin(u1) * sine - math.cos(u1) * cosine * math.cos(azimuth)
    latitude = math.atan2(
        math.sin(u1) * cosine + math.cos(u1) * sine * math.cos(azimuth),
        (1 - _F) * math.hypot(alpha, x))
    turn = math.atan2(
        sine * math.sin(azimuth),
        math.cos(u1) * cosine - math.sin(u1) * sine * math.cos(azimuth))
    away = turn - _lag(alpha, cos2, arc, sine, cosine, middle)
    there = Geographic(math.degrees(latitude), math.remainder(
        origin.longitude + math.degrees(away), 360.0))
    return there, (math.remainder(azimuth - math.atan2(alpha, -x), math.tau)
                   if distance > 0 else 0.0)


def convergence(latitude: float, longitude: float,
                origin: Origin = Origin()) -> float:
    """What a true heading at a place is to be turned by to be one on the map
    [deg]: bearing from the map's north = true heading + this."""
    step = -1e-3 if latitude > 0 else 1e-3
    here = to_local(latitude, longitude, origin)
    there = to_local(latitude + step, longitude, origin)
    return math.degrees(math.atan2((there.east - here.east) / step,
                                   (there.north - here.north) / step))


def _reduced(latitude: float) -> float:
    angle = math.radians(latitude)
    return math.atan2((1 - _F) * math.sin(angle), math.cos(angle))


def _u2(cos2: float) -> float:
    return cos2 * (_A * _A - _B * _B) / (_B * _B)


def _series_a(cos2: float) -> float:
    u = _u2(cos2)
    return 1 + u / 16384 * (4096 + u * (-768 + u * (320 - 175 * u)))


def _series_b(cos2: float) -> float:
    u = _u2(cos2)
    return u / 1024 * (256 + u * (-128 + u * (74 - 47 * u)))


def _excess(b: float, sine: float, cosine: float, middle: float) -> float:
    """Vincenty's equation 6."""
    m = middle * middle
    return b * sine * (middle + b / 4 * (
        cosine * (2 * m - 1)
        - b / 6 * middle * (4 * sine * sine - 3) * (4 * m - 3)))


def _lag(alpha: float, cos2: float, arc: float, sine: float, cosine: float,
         middle: float) -> float:
    """Equation 11: of longitude on the sphere over that on the ellipsoid."""
    c = _F / 16 * cos2 * (4 + _F * (4 - 3 * cos2))
    return (1 - c) * _F * alpha * (arc + c * sine * (
        middle + c * cosine * (2 * middle * middle - 1)))
