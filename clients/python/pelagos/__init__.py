"""Pelagos from Python: an ocean to steer, to look at and to measure.

    from pelagos import Ocean

    ocean = Ocean()                       # http://127.0.0.1:8080
    ocean["sea.windSpeed"] = 12           # m/s
    image = ocean.views["bridge"].image() # uint8, (height, width, 3), RGB
    surface = ocean.surface([[0, 0], [25, -10]])
    surface.height                        # m, float64, (2,)

Fields have the names of the schema everywhere (`sea.windSpeed`), angles are
degrees, lengths metres, times seconds. proto/pelagos.proto of the project names
every field with its unit and range; so does `ocean.fields()`.
"""
from .camera import (EARTH_RADIUS, STANDARD_REFRACTION, Camera, Horizon,
                     Intrinsics)
from .client import Ocean
from .coco import Coco, positions_csv, shot
from .errors import (BadPicture, Busy, Conflict, Forbidden, Internal, Invalid,
                     Malformed, MissingPackage, NotFound, Notice, OutOfRange,
                     PelagosError, ProtocolError, Refused, TimedOut, Unauthorized,
                     Unreachable)
from .exr import Exr, read_exr
from .frame import Frame
from .geo import Geographic, Local, convergence, to_geographic, to_local
from .labels import Box, LabelledEntity, Labels
from .live import LiveFrame, LiveStream, VideoStream
from .parts import Entities, EntityHandle, ViewHandle, Views
from .schema import (FORMATS, LAYERS, MODEL_CLASSES, VERSION, Area, Clock,
                     Entity, Fog, FrameTruth, Frustum, Light, LightSector,
                     Model, ModelInfo, Models, Optics, Origin, OwnShip, Radar,
                     Sea, Seabed, Searchlight, SeenEntity, Sensor, SignalLamp,
                     Sky, Sources, State, Swell, TrackPoint, View, Water, Wave)
from .schema import (ExerciseRun, LookAt, Orbit, Place, Preset, Satellite,
                     Waypoint)
from .series import Series
from .spectrum import Spectrum
from .surface import Surface, SurfaceSeries

__version__ = VERSION

__all__ = [
    "Area", "BadPicture", "Box", "Busy", "Camera", "Clock", "Coco", "Conflict",
    "convergence", "EARTH_RADIUS", "Entities", "Entity", "EntityHandle", "ExerciseRun", "Exr",
    "Fog", "Forbidden", "FORMATS", "Frame", "FrameTruth", "Frustum", "Geographic",
    "Horizon", "Internal", "Intrinsics", "Invalid", "LabelledEntity", "Labels",
    "LAYERS", "Light", "LightSector", "LiveFrame", "LiveStream", "Local",
    "LookAt", "Malformed", "MissingPackage", "Model", "MODEL_CLASSES", "ModelInfo",
    "Models", "NotFound", "Notice", "Ocean", "Optics", "Orbit", "Origin", "OutOfRange", "OwnShip",
    "PelagosError", "Place", "positions_csv", "Preset", "ProtocolError", "Radar", "read_exr",
    "Refused", "Satellite", "Sea", "Seabed", "Searchlight", "SeenEntity", "Sensor", "Series", "shot",
    "SignalLamp", "Sky", "Sources", "Spectrum", "STANDARD_REFRACTION", "State",
    "Surface", "SurfaceSeries", "Swell", "TimedOut", "to_geographic",
    "to_local", "TrackPoint", "Unauthorized", "Unreachable", "VERSION",
    "VideoStream", "View", "ViewHandle", "Views", "Water", "Wave",
    "Waypoint",
]
