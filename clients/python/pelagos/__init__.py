"""Pelagos from Python: an ocean to steer, to look at and to measure.

    from pelagos import Ocean

    ocean = Ocean()                       # http://127.0.0.1:8080
    ocean["sea.windSpeed"] = 12           # m/s
    image = ocean.views["bridge"].image() # uint8, (height, width, 3), RGB
    surface = ocean.surface([[0, 0], [25, -10]])
    surface.height                        # m, float64, (2,)

Fields have the names of the schema everywhere (`sea.windSpeed`), angles are
degrees, lengths metres, times seconds. proto/manual.md of the project names
every field with its unit and range; so does `ocean.fields()`.
"""
from .camera import Camera, Intrinsics
from .client import Ocean
from .errors import (BadPicture, Busy, Conflict, Internal, Invalid, Malformed,
                     MissingPackage, NotFound, OutOfRange, PelagosError,
                     ProtocolError, Refused, TimedOut, Unauthorized,
                     Unreachable)
from .exr import Exr, read_exr
from .frame import Frame
from .live import LiveFrame, LiveStream, VideoStream
from .parts import EntityHandle, ViewHandle
from .coco import Coco, positions_csv, shot
from .schema import (FORMATS, LAYERS, VERSION, Clock, Entity, Frustum, Origin,
                     Sea, Sky, State, Swell, View, Water)
from .surface import Surface

__version__ = VERSION

__all__ = [
    "BadPicture", "Busy", "Camera", "Clock", "Coco", "Conflict", "Entity",
    "EntityHandle", "Exr", "FORMATS", "Frame", "Frustum", "Internal", "Intrinsics",
    "Invalid", "LAYERS", "LiveFrame", "LiveStream", "Malformed",
    "MissingPackage", "NotFound", "Ocean", "Origin", "OutOfRange", "PelagosError",
    "ProtocolError", "Refused", "Sea", "Sky", "State", "Surface", "Swell",
    "TimedOut", "Unauthorized", "Unreachable", "VideoStream", "View", "ViewHandle",
    "Water", "positions_csv", "read_exr", "shot",
]
