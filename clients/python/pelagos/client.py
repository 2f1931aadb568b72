"""The ocean: one running pelagosd."""
from __future__ import annotations

import contextlib
import os
import ssl
import stat
import urllib.parse
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from .frame import Frame, from_answer, parts_of
from .parts import Entities, Views
from .schema import FORMATS, State
from .surface import Surface, query
from .transport import Transport

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

DEFAULT_URL = "http://127.0.0.1:8080"
URL_VARIABLE = "PELAGOS_URL"
TOKEN_VARIABLE = "PELAGOS_TOKEN"
TOKEN_FILE_VARIABLE = "PELAGOS_TOKEN_FILE"
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
        return State.from_json(self.transport.request(
            "PATCH", "/v1/state", _plain(change), headers).json())

    def __getitem__(self, path: str) -> Any:
        """`ocean["sea.windSpeed"]`: a number, text, or JSON of a part; None
        for what is absent."""
        place = "/".join(urllib.parse.quote(part, safe="")
                         for part in _split(path))
        return self.transport.request("GET", "/v1/state/" + place
                                      ).json().get("value")

    def __setitem__(self, path: str, value: Any) -> None:
        """`ocean["views.bridge.yaw"] = 5`"""
        parts = _split(path)
        if parts[:2] == ["sea", "swell"] and len(parts) > 2:
            self._set_swell(parts, value)
        else:
            for part in reversed(parts):
                value = {part: value}
            self.patch(value)

    def __delitem__(self, path: str) -> None:
        """`del ocean["sky.sunElevation"]`: back to its default, or gone."""
        self[path] = None

    def _set_swell(self, parts: list[str], value: Any) -> None:
        """A list without keys goes whole: read, changed, and sent back if
        nobody else has changed the state meanwhile."""
        state = self.state()
        swell: list[Any] = [s.to_json() for s in state.sea.swell
                            ] if state.sea else []
        try:
            index = int(parts[2])
            if len(parts) == 4:
                swell[index] = {**swell[index], parts[3]: value}
            elif value is None:
                del swell[index]
            else:
                swell[index] = value
        except (ValueError, IndexError):
            raise LookupError(f"there is no {'.'.join(parts[:3])}") from None
        self.patch({"sea": {"swell": swell}}, revision=state.revision)

    @contextlib.contextmanager
    def kept(self) -> Iterator[State]:
        """`with ocean.kept():` puts the state back at the end as it was at
        the start, clock, views and entities included."""
        before = self.state()
        try:
            yield before
        finally:
            self.patch(before.to_json(nulls=True))

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

    # --- sea and pictures ---------------------------------------------------

    def surface(self, points: "ArrayLike", time: float | None = None, *,
                frame: int | None = None, acceleration: bool = False,
                foam: bool = False) -> Surface:
        """Height [m], normal, velocity [m/s] and, where they are asked for,
        acceleration [m/s2] and foam (share of the water) of the sea that is drawn, at points (..., 2): east
        and north of the origin [m]. time: simulated time [s], none: the
        clock's, or the frame's. frame: number of one of the last 64 frames,
        for the sea that it shows. Any number of points, in batches, all of
        one time."""
        return query(lambda content: self.transport.request(
            "POST", "/v1/surface", content).json(), points, time, frame,
            acceleration, foam)

    def frame(self, view: str, format: str = "jpg", *,
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
        name = urllib.parse.quote(view, safe="")
        answer = self.transport.request(
            "GET", f"/v1/views/{name}/frame.{format}{text}")
        return from_answer(view, format, answer.headers, answer.body)

    def frames(self, views: Iterable[str] | None = None, format: str = "jpg",
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
        names = None if views is None else ",".join(views)
        text = _query(views=names, width=width, height=height, quality=quality,
                      time=time, layers=layers, float_samples=float_samples)
        answer = self.transport.request("GET", f"/v1/frames.{format}{text}")
        return {headers["X-Pelagos-View"]:
                from_answer(headers["X-Pelagos-View"], format, headers, data)
                for headers, data in parts_of(answer)}

    def images(self, views: Iterable[str] | None = None, *,
               width: int | None = None, height: int | None = None,
               time: float | None = None) -> "dict[str, NDArray[np.uint8]]":
        """The same as arrays: RGB, uint8, (height, width, 3), without loss."""
        return {name: frame.image() for name, frame in self.frames(
            views, "png", width=width, height=height, time=time).items()}


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
