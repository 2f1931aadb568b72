"""The ocean: one running pelagosd."""
from __future__ import annotations

import contextlib
import os
import ssl
import stat
import sys
import urllib.parse
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, overload

from .errors import Notice
from .frame import Frame, from_answer, parts_of
from .parts import Entities, ViewHandle, Views
from .record import Record, list_of, message_of
from .schema import (FORMATS, Clock, Entity, Models, Optics, Origin, OwnShip,
                     Preset, Sea, Seabed, Sky, Sources, State, View, Water)
from .series import Axis, Series, axes_of
from .spectrum import Spectrum
from .surface import Surface, SurfaceSeries, query, series
from .transport import Transport

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

DEFAULT_URL = "http://127.0.0.1:8080"
URL_VARIABLE = "PELAGOS_URL"
TOKEN_VARIABLE = "PELAGOS_TOKEN"
TOKEN_FILE_VARIABLE = "PELAGOS_TOKEN_FILE"
_HERE = os.path.dirname(__file__)
_ALIASES = {"view": "views", "entity": "entities"}


class Ocean:
    """Talks to one daemon over HTTP. Any number of threads may use it.

    url      http://HOST:PORT, or https: through a proxy; none: $PELAGOS_URL,
             else http://127.0.0.1:8080
    timeout  of each wait for the daemon [s]
    token    what pelagosd --token-file asks for; none: $PELAGOS_TOKEN, else
             the line in the file $PELAGOS_TOKEN_FILE, else nothing is given
    cafile   certificates (PEM) to trust for https instead of the system's
    headers  sent with every request

    A refusal raises a Refused (OutOfRange, NotFound, ...) that names the
    field, its unit and range, and leaves the state as it was.
    """

    def __init__(self, url: str | None = None, *, timeout: float = 30.0,
                 token: str | None = None,
                 cafile: "str | os.PathLike[str] | None" = None,
                 headers: Mapping[str, str] | None = None) -> None:
        given = dict(headers or {})
        if token := token or _token():
            given["Authorization"] = f"Bearer {token}"
        context = (ssl.create_default_context(cafile=os.fspath(cafile))
                   if cafile else None)
        self.transport = Transport(
            url or os.environ.get(URL_VARIABLE) or DEFAULT_URL, timeout,
            given, context)
        self.views = Views(self)
        self.entities = Entities(self)

    def close(self) -> None:
        self.transport.close()

    def __enter__(self) -> Ocean:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Ocean {self.transport.url}>"

    # --- state --------------------------------------------------------------

    def state(self) -> State:
        """All of the state, with clock.time of this moment."""
        return State.from_json(
            self.transport.request("GET", "/v1/state").json())

    def set(self, *, revision: int | None = None, **parts: Any) -> State:
        """Sets fields, all or none; the state after it:

            ocean.set(sea={"windSpeed": 12, "swell": [[2, 9, 270, 10]]},
                      sky={"sunElevation": None})

        None resets a field to its default. revision: only if the state is
        still at that one (Conflict otherwise)."""
        return self.patch(parts, revision=revision)

    def patch(self, change: Mapping[str, Any], *,
              revision: int | None = None) -> State:
        """The same by a merge patch (RFC 7396), as proto/manual.md has it."""
        headers = {"Content-Type": "application/merge-patch+json"}
        if revision is not None:
            headers["If-Match"] = f'"{revision}"'
        answer = self.transport.request("PATCH", "/v1/state", _plain(change),
                                        headers)
        if notice := answer.headers.get("X-Pelagos-Notice"):
            warnings.warn(notice, Notice,
                          stacklevel=_depth())
        return State.from_json(answer.json())

    def __getitem__(self, path: str) -> Any:
        """`ocean["sea.windSpeed"]`: a number, text, or JSON of a part; None
        for what is absent."""
        place = "/".join(urllib.parse.quote(part, safe="")
                         for part in _split(path))
        return self.transport.request("GET", "/v1/state/" + place
                                      ).json().get("value")

    def __setitem__(self, path: str, value: Any) -> None:
        """`ocean["views.bridge.yaw"] = 5`, `ocean["sea.swell.0.height"] = 2`"""
        parts = _split(path)
        if at := _list_without_key(parts):
            self._set_element(parts, at, value)
        else:
            self.patch(_nested(parts, value))

    def __delitem__(self, path: str) -> None:
        """`del ocean["sky.sunElevation"]`: back to its default, or gone."""
        self[path] = None

    def _set_element(self, parts: list[str], at: int, value: Any) -> None:
        """A list without keys (parts[:at]) goes whole: read, changed, and sent
        back if nobody else has changed the state meanwhile."""
        content = self.transport.request("GET", "/v1/state").json()
        elements: Any = content
        for name in parts[:at]:
            elements = (_keyed(elements, name) if isinstance(elements, list)
                        else elements.get(name, []))
        try:
            inner, key = elements, int(parts[at])
            if len(parts) == at + 1:
                if value is None:
                    del elements[key]
                else:
                    elements[key] = value
            else:
                inner = elements[key]
                for name in parts[at + 1:-1]:
                    inner = inner[int(name) if isinstance(inner, list)
                                  else name]
                inner[int(parts[-1]) if isinstance(inner, list)
                      else parts[-1]] = value
        except (ValueError, IndexError, KeyError, TypeError):
            raise LookupError(
                f"there is no {'.'.join(parts[:at + 1])}") from None
        self.patch(_nested(parts[:at], elements),
                   revision=int(content["revision"]))

    @contextlib.contextmanager
    def kept(self) -> Iterator[State]:
        """`with ocean.kept():` puts the state back at the end as it was at
        the start, clock, views and entities included."""
        before = self.state()
        try:
            yield before
        finally:
            self.patch(before.to_json(nulls=True))

    def reset(self, seed: int = 1,
              scene: State | Mapping[str, Any] | None = None) -> State:
        """Makes the whole state a known one: simulated time 0, the clock
        STEPPED, waves and clouds of `seed` (0 to 4294967295). The pictures and
        answers that follow the same steps are then the same to the bit, on the
        same device, whatever the daemon did before.

        scene: what is in it, as a State or a patch; every field that it does
        not give is at its default. Without entities there is one, 1,
        "ownship", and without views one on it, "bridge", as pelagosd starts.
        Its clock may give utc, rate and reckoning; its poses hold at time 0,
        and wakes and washes begin then. The state after it."""
        given = scene.to_json() if isinstance(scene, State) else _plain(
            scene or {})
        known = {"clock": Clock, "origin": Origin, "sea": Sea, "water": Water,
                 "sky": Sky, "ownShip": OwnShip, "sources": Sources,
                 "seabed": Seabed}
        change: dict[str, Any] = {
            name: {**kind().to_json(nulls=True), **(given.pop(name, {}) or {})}
            for name, kind in known.items()}
        change["clock"].update(mode="STEPPED", time=0.0)
        change["sea"]["seed"] = int(seed)
        change["sky"]["cloudSeed"] = int(seed) % 65536
        for name, key, first in (
                ("entities", "id", {"id": 1, "name": "ownship"}),
                ("views", "name", {"name": "bridge"})):
            elements = given.pop(name, None)
            if isinstance(elements, Mapping):
                elements = [{key: k, **e} for k, e in elements.items()]
            change[name] = [first] if elements is None else elements
        if change["views"] == [{"name": "bridge"}] and change["entities"]:
            change["views"][0]["entity"] = int(change["entities"][0]["id"])
        for entity in change["entities"]:
            entity["id"] = int(entity["id"])
            entity.pop("track", None)
            entity["poseTime"] = 0.0
        # No part of what is seen; who patches takes an exercise over.
        for name in ("revision", "exercise") + (
                ("presets",) if isinstance(scene, State) else ()):
            given.pop(name, None)
        return self.patch({**given, **change})

    def step(self, seconds: float = 1 / 30, *, until: float | None = None
             ) -> State:
        """Advances simulated time by seconds [s; 0 to 3600], or until that
        very moment [s]; the clock's mode must be STEPPED
        (`ocean.set(clock={"mode": "STEPPED", "time": 0})`). The state after
        it."""
        content = ({"seconds": float(seconds)} if until is None
                   else {"until": float(until)})
        return State.from_json(self.transport.request(
            "POST", "/v1/clock/step", content, repeatable=False).json())

    def fields(self) -> dict[str, dict[str, Any]]:
        """Every path of the state with its `unit`, `minimum`, `maximum` (where
        it has them) and `doc`."""
        found = self.transport.request("GET", "/v1/fields").json()["fields"]
        return {field.pop("path"): field for field in found}

    def health(self) -> dict[str, Any]:
        """Version, device and revision of the daemon."""
        answer: dict[str, Any] = self.transport.request("GET",
                                                        "/healthz").json()
        return answer

    def models(self) -> Models:
        """The models that entities may have: built in, and files of pelagosd
        --models, with size, class and, of a file that cannot be used, why."""
        return Models.from_json(
            self.transport.request("GET", "/v1/models").json())

    # --- sea and pictures ---------------------------------------------------

    @overload
    def surface(self, points: "ArrayLike", time: float | None = None, *,
                frame: int | None = None, acceleration: bool = False,
                foam: bool = False) -> Surface: ...

    @overload
    def surface(self, points: "ArrayLike",
                time: "Sequence[float] | NDArray[np.float64]", *,
                frame: int | None = None, acceleration: bool = False,
                foam: bool = False, moving: bool = False
                ) -> SurfaceSeries: ...

    def surface(self, points: "ArrayLike", time: Any = None, *,
                frame: int | None = None, acceleration: bool = False,
                foam: bool = False, moving: bool = False
                ) -> Surface | SurfaceSeries:
        """Height [m], normal, velocity [m/s] and, where they are asked for,
        acceleration [m/s2] and foam (share of the water) of the sea that is
        drawn, at points (..., 2): east and north of the origin [m]. Any number
        of points, in batches, all of one time.

        time    simulated time [s], past or to come; none: the clock's, or the
                frame's; a list of times: a SurfaceSeries, arrays (times, ...)
        frame   number of one of the last 64 frames, for the sea that it shows
        moving  with a list of times: points are (times, ..., 2), each time's
                own, as of a hull under way
        """
        def ask(content: dict[str, Any]) -> Any:
            return self.transport.request("POST", "/v1/surface",
                                          content).json()

        if time is None or isinstance(time, (int, float)) or not getattr(
                time, "ndim", 1):
            if moving:
                raise ValueError("moving points need a list of times")
            return query(ask, points, time, frame, acceleration, foam)
        return series(ask, points, time, frame, acceleration, foam, moving)

    def soundings(self, latitude: float | None = None,
                  longitude: float | None = None, *, spacing: float = 10,
                  columns: int = 256, rows: int = 256, turn: float = 0
                  ) -> "NDArray[np.float32]":
        """Depths of the bottom below mean sea level [m], (rows, columns), the
        first row the upper one: negative on land, NaN where the file
        has no data. Of cells larger than the file's the least depth counts.

        latitude, longitude  of the raster's middle [deg]; none: the origin's
        spacing              of its cells, both ways [m; 0.01 to 100000]
        columns, rows        1 to 512
        turn                 where its upper side looks, clockwise from north
                             [deg]

        Conflict where the state names no seabed.file."""
        import numpy as np
        given = {"latitude": latitude, "longitude": longitude,
                 "spacing": spacing, "columns": columns, "rows": rows,
                 "turn": turn}
        answer = self.transport.request(
            "GET", "/v1/soundings?" + urllib.parse.urlencode(
                {k: v for k, v in given.items() if v is not None}))
        return np.frombuffer(answer.body, "<f4").reshape(
            rows, columns).astype(np.float32)

    def spectrum(self, *, frequencies: int = 0, directions: int = 0,
                 lowest: float | None = None, highest: float | None = None,
                 wavelength: float | None = None,
                 patch: Mapping[str, Any] | None = None) -> Spectrum:
        """The numbers of the sea in force, or of any other.

        frequencies      to list, 0 to 200, evenly in their logarithm
        lowest, highest  of them [rad/s; 0.05 to 100] (0.2, 10)
        directions       to list at each, 0 to 72, from 0 deg on
        wavelength       [m]: also sums up the waves shorter than this
        patch            changes for this answer only:
                         patch={"sea": {"windSpeed": 12}}
        """
        asked = {"frequencies": int(frequencies),
                 "directions": int(directions), "lowest": lowest,
                 "highest": highest, "wavelength": wavelength}
        content: dict[str, Any] = {name: value for name, value in asked.items()
                                   if value is not None}
        if patch is not None:
            content["patch"] = {"state": _plain(patch)}
        return Spectrum.from_json(self.transport.request(
            "POST", "/v1/spectrum", _plain(content)).json())

    def optics(self, question: str, *, source: str = "REFERENCE",
               patch: Mapping[str, Any] | None = None, **query: Any) -> Optics:
        """Numbers of light, by the Sun, air, water and wind of the state:

            ocean.optics("sky", elevation=20, azimuth=90).sky.radiance
            ocean.optics("brdf", viewZenith=75).brdf.brdf
            ocean.optics("water", wavelength=400, wavelengthLast=700,
                         patch={"water": {"chlorophyll": 3}}).water.total

        question  "sky", "brdf" or "water"
        source    whose answer: REFERENCE, GPU, and of the water MONTECARLO
        patch     changes for this answer only
        query     fields of the schema's SkyQuery, BrdfQuery or WaterQuery
        """
        if question not in ("sky", "brdf", "water"):
            raise ValueError("a question of optics is sky, brdf or water, not "
                             f"{question!r}")
        content: dict[str, Any] = {"from": source, question: _plain(query)}
        if patch is not None:
            content["patch"] = {"state": _plain(patch)}
        return Optics.from_json(self.transport.request(
            "POST", "/v1/optics", content).json())

    def series(self, question: str, sweep: Mapping[str, Axis] | None = None, *,
               source: str | None = None,
               patch: Mapping[str, Any] | None = None, **query: Any) -> Series:
        """One question at each combination of the values of some axes:

            s = ocean.series("water", {"wavelength": slice(400, 700, 10),
                                       "chlorophyll": [0.1, 1]}, sunZenith=40)
            s["remoteSensingReflectance"]        # float64, (31, 2)
            ocean.series("surface", {"time": slice(0, 600, 0.5)},
                         points=[[0, 0]])["height"]
            ocean.series("spectrum", {"windSpeed": [5, 10]}).dataset()

        question  "sky", "brdf", "water", "spectrum" or "surface"
        sweep     at most four axes: a number of the question or of the state by
                  its name, its values or a slice, whose stop belongs to it
        source    of light, as of optics
        patch     changes for this answer only; not of surface
        query     fields of the schema's SkyQuery, BrdfQuery, WaterQuery,
                  SpectrumQuery or SurfaceQuery; `time` of light too
        """
        if question not in ("sky", "brdf", "water", "spectrum", "surface"):
            raise ValueError("a series is of sky, brdf, water, spectrum or "
                             f"surface, not of {question!r}")
        asked: dict[str, Any] = _plain(query)
        above: dict[str, Any] = {}
        if question in ("sky", "brdf", "water"):
            if "time" in asked:
                above["time"] = asked.pop("time")
            if source is not None:
                above["from"] = source
            asked = {**above, question: asked}
            question = "optics"
        elif source is not None:
            raise ValueError(f"{question} has no source")
        if patch is not None:
            asked["patch"] = {"state": _plain(patch)}
        return Series.from_json(self.transport.request(
            "POST", "/v1/series", {"sweep": axes_of(sweep or {}),
                                   question: asked}).json())

    def frame(self, view: str | ViewHandle, format: str = "jpg", *,
              width: int | None = None, height: int | None = None,
              time: float | None = None, quality: int | None = None,
              layers: Sequence[str] = (), float_samples: bool = False
              ) -> Frame:
        """One picture of a view; see ViewHandle.frame."""
        if format not in FORMATS:
            raise ValueError(f"format is one of {', '.join(FORMATS)}, not "
                             f"{format!r}")
        text = _query(width=width, height=height, quality=quality, time=time,
                      layers=layers, float_samples=float_samples)
        key = _name(view)
        answer = self.transport.request(
            "GET", f"/v1/views/{urllib.parse.quote(key, safe='')}"
            f"/frame.{format}{text}")
        return from_answer(key, format, answer.headers, answer.body)

    def frames(self, views: Iterable[str | ViewHandle] | None = None, format: str = "jpg",
               *, width: int | None = None, height: int | None = None,
               time: float | None = None, quality: int | None = None,
               layers: Sequence[str] = (), float_samples: bool = False
               ) -> dict[str, Frame]:
        """Pictures of several views (none: of all) by one request, of one
        frame: of one state, simulated time and number, clock running or not.
        All of them, or a Refused; in the order of the views."""
        if format not in FORMATS:
            raise ValueError(f"format is one of {', '.join(FORMATS)}, not "
                             f"{format!r}")
        names = None if views is None else ",".join(map(_name, views))
        text = _query(views=names, width=width, height=height, quality=quality,
                      time=time, layers=layers, float_samples=float_samples)
        answer = self.transport.request("GET", f"/v1/frames.{format}{text}")
        return {headers["X-Pelagos-View"]:
                from_answer(headers["X-Pelagos-View"], format, headers, data)
                for headers, data in parts_of(answer)}

    def image(self, view: str | ViewHandle, *, width: int | None = None,
              height: int | None = None, time: float | None = None
              ) -> "NDArray[np.uint8]":
        """One picture of a view without loss: RGB, uint8, (height, width, 3)."""
        return self.frame(view, "png", width=width, height=height,
                          time=time).image()

    def images(self, views: Iterable[str | ViewHandle] | None = None, *,
               width: int | None = None, height: int | None = None,
               time: float | None = None) -> "dict[str, NDArray[np.uint8]]":
        """The same as arrays: RGB, uint8, (height, width, 3), without loss."""
        return {name: frame.image() for name, frame in self.frames(
            views, "png", width=width, height=height, time=time).items()}


def _depth() -> int:
    """Of the frame that called this package, seen from the caller."""
    frame, depth = sys._getframe(1), 1
    while frame.f_back and os.path.dirname(frame.f_code.co_filename) == _HERE:
        frame, depth = frame.f_back, depth + 1
    return depth


def _name(view: str | ViewHandle) -> str:
    return view.name if isinstance(view, ViewHandle) else view


def _nested(parts: Sequence[str], value: Any) -> Any:
    """The patch that sets one path."""
    for part in reversed(parts):
        value = {part: value}
    return value


def _list_without_key(parts: Sequence[str]) -> int:
    """How many of the parts name a list without keys that the others go into;
    0: there is none, as where the schema does not know them."""
    kind: type[Record] = State
    at = 0
    while at < len(parts) - 1:
        element = list_of(kind, parts[at])
        if element is Entity or element is View or element is Preset:
            kind, at = element, at + 2
            continue
        if element is not None:
            return at + 1
        inner = message_of(kind, parts[at])
        if inner is None:
            return 0
        kind, at = inner, at + 1
    return 0


def _keyed(elements: list[Any], key: str) -> Any:
    """Of entities or views the one with this id or name."""
    for element in elements:
        if key in (str(element.get("id")), element.get("name")):
            return element
    return {}


def _query(*, time: float | None, layers: Sequence[str], float_samples: bool,
           **more: Any) -> str:
    """Of a picture, with its question mark; empty where nothing is asked."""
    asked = {**more,
             "time": None if time is None else repr(float(time)),
             "layers": ",".join(layers) or None,
             "float": 1 if float_samples else None}
    text = urllib.parse.urlencode(
        {name: value for name, value in asked.items() if value is not None},
        safe=",")
    return "?" + text if text else ""


def _token() -> str | None:
    """Of the environment."""
    if token := os.environ.get(TOKEN_VARIABLE):
        return token
    if path := os.environ.get(TOKEN_FILE_VARIABLE):
        # A FIFO or a device in its place must not hold the caller up.
        fd = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        with open(fd, encoding="ascii") as file:
            if not stat.S_ISREG(os.fstat(fd).st_mode):
                raise OSError(f"{path} is no regular file")
            return file.readline().strip()
    return None


def _split(path: str) -> list[str]:
    parts = path.split(".")
    if not all(parts):
        raise ValueError(f"{path!r} is no path")
    parts[0] = _ALIASES.get(parts[0], parts[0])
    return parts


def _plain(value: Any) -> Any:
    """JSON of what callers have: numbers and arrays of NumPy, records of
    schema.py, tuples."""
    if isinstance(value, Mapping):
        return {str(name): _plain(v) for name, v in value.items()}
    if hasattr(value, "to_json"):
        return _plain(value.to_json())
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    return value
