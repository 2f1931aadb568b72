"""What can go wrong. Every exception of this package is a PelagosError."""
from __future__ import annotations

import json
from typing import Any


class PelagosError(Exception):
    """Base of all."""


class Notice(UserWarning):
    """No error: an edit switched something off without having been asked to,
    like the model of a ship that it gave a speed; the text says what, and how
    to keep it on."""


class Unreachable(PelagosError, ConnectionError):
    """Nothing answers at the address, or the connection broke."""


class TimedOut(PelagosError, TimeoutError):
    """The daemon did not answer in time."""


class ProtocolError(PelagosError):
    """What answers does not speak Pelagos' protocol."""


class BadPicture(PelagosError, ValueError):
    """A picture cannot be read; the message says why."""


class MissingPackage(PelagosError, ImportError):
    """A package that this call needs is not installed; the message names it
    and how to get it."""


class Refused(PelagosError):
    """The daemon refused the request; the state is as it was.

    code     name of the schema's ErrorCode, "OUT_OF_RANGE"
    status   of HTTP, 400
    path     field at fault, "sea.windSpeed", or None
    value    the refused value as text, or None
    unit     unit of the field, "m/s", or None
    minimum, maximum  its legal range in that unit, or None
    """

    def __init__(self, status: int, problem: dict[str, Any]) -> None:
        self.status = status
        self.code: str = str(problem.get("code", "INTERNAL"))
        self.path: str | None = problem.get("path")
        self.value: str | None = problem.get("value")
        self.unit: str | None = problem.get("unit")
        self.minimum: float | None = problem.get("minimum")
        self.maximum: float | None = problem.get("maximum")
        super().__init__(problem.get("detail") or problem.get("title")
                         or f"refused with status {status}")


class Malformed(Refused, ValueError):
    """The request could not be read."""


class NotFound(Refused, LookupError):
    """No such field, view or entity."""


class OutOfRange(Refused, ValueError):
    """A value is outside its legal range."""


class Invalid(Refused, ValueError):
    """A value has the wrong type or form."""


class Conflict(Refused):
    """The request contradicts the state: a step while the clock runs freely,
    or the revision asked for is over (status 412)."""


class Busy(Refused):
    """A limit is reached; try again later."""


class Unauthorized(Refused, PermissionError):
    """The token is missing or wrong: Ocean(token=…) or $PELAGOS_TOKEN."""


class Forbidden(Refused, PermissionError):
    """The token's role does not reach so far."""


class Internal(Refused):
    """The daemon failed; its log says more."""


_KINDS: dict[str, type[Refused]] = {
    "MALFORMED": Malformed, "NOT_FOUND": NotFound,
    "OUT_OF_RANGE": OutOfRange, "INVALID": Invalid, "CONFLICT": Conflict,
    "BUSY": Busy, "INTERNAL": Internal, "UNAUTHORIZED": Unauthorized,
    "FORBIDDEN": Forbidden,
}
_BY_STATUS: dict[int, type[Refused]] = {401: Unauthorized, 404: NotFound, 409: Conflict, 412: Conflict, 429: Busy,
              503: Busy}


def refusal(status: int, body: bytes) -> Refused:
    """The exception for an answer of 400 and above."""
    try:
        problem = json.loads(body)
    except (ValueError, RecursionError):
        problem = {}
    if not isinstance(problem, dict):
        problem = {}
    other: type[Refused] = Internal if status >= 500 else Invalid
    kind = _BY_STATUS.get(status, _KINDS.get(str(problem.get("code")), other))
    return kind(status, problem)
