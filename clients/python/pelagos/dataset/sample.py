"""Draws of a plan: a value is a function of seed, scene and name alone, so
that any worker has the same for any scene, in any order.

A uniform number is the first 53 bits of the SHA-256 of "seed/scene/name/k",
over 2^53. Numbers are rounded to nine digits: what logarithms of different
libraries differ by is then gone."""
from __future__ import annotations

import hashlib
import math
import statistics
from typing import Any

from .fields import BadPlan, Field

#: Kinds of distributions, and what each takes.
KINDS = {
    "uniform": "[lowest, highest]",
    "logUniform": "[lowest, highest], both above 0",
    "integer": "[lowest, highest], whole numbers, both belong to it",
    "normal": "[mean, deviation], with \"within\": [lowest, highest]",
    "choice": "[value, …], with \"weights\": [number, …] or without",
    "grid": "[value, …]",
}
_ALSO = {"within": "normal", "weights": "choice", "chance": None}


def uniform(seed: int, scene: int, name: str, k: int = 0) -> float:
    """In [0, 1), a multiple of 2^-53."""
    text = f"{seed}/{scene}/{name}/{k}".encode()
    digest = hashlib.sha256(text).digest()
    return (int.from_bytes(digest[:8], "big") >> 11) / 9007199254740992.0


def rounded(value: float) -> float:
    """To nine significant digits."""
    return float(f"{value:.9g}")


class Distribution:
    """One entry of a plan's ranges, checked."""

    def __init__(self, spec: Any, where: str, field: Field | None = None,
                 grid: bool = True) -> None:
        self.where = where
        if not isinstance(spec, dict):
            raise BadPlan(f"{where}: {spec!r}, an object is wanted, such as "
                          '{"uniform": [2, 16]}')
        kinds = [name for name in spec if name in KINDS]
        wrong = [name for name in spec if name not in KINDS
                 and name not in _ALSO]
        if wrong or len(kinds) != 1:
            raise BadPlan(f"{where}: {wrong[0]!r} is no distribution"
                          if wrong else f"{where}: one distribution is wanted")
        self.kind: str = kinds[0]
        for name in spec:
            if _ALSO.get(name) not in (None, self.kind):
                raise BadPlan(f"{where}: {name!r} goes with {_ALSO[name]}, not "
                              f"with {self.kind}")
        if self.kind == "grid" and not grid:
            raise BadPlan(f"{where}: a grid is for fields of the state")
        self.values: list[Any] = spec[self.kind]
        if not isinstance(self.values, list) or not self.values:
            self._refuse()
        self.chance = float(_numbers([spec.get("chance", 1)], where)[0])
        if not 0 <= self.chance <= 1:
            raise BadPlan(f"{where}: chance is {self.chance:g}, a number from "
                          "0 to 1 is wanted")
        if self.kind == "grid" and self.chance < 1:
            raise BadPlan(f"{where}: a grid has no chance")
        self.whole = self.kind == "integer" or (
            field is not None and field.kind is int)
        self._read(spec)
        if field is not None:
            for value in self.extremes():
                field.check(value, where)

    def _refuse(self) -> None:
        raise BadPlan(f"{self.where}: {self.kind} takes {KINDS[self.kind]}, "
                      f"not {self.values!r}")

    def _read(self, spec: dict[str, Any]) -> None:
        if self.kind in ("choice", "grid"):
            weights = spec.get("weights", [1] * len(self.values))
            weights = _numbers(weights, self.where)
            if (len(weights) != len(self.values) or min(weights) < 0
                    or sum(weights) <= 0):
                raise BadPlan(f"{self.where}: weights are as many as the "
                              "values, none below 0, not all 0")
            self.weights = weights
            return
        numbers = _numbers(self.values, self.where)
        if len(numbers) != 2:
            self._refuse()
        self.low, self.high = numbers
        if self.kind == "normal":
            self.mean, self.deviation = numbers
            within = _numbers(spec.get("within"), self.where)
            if self.deviation <= 0 or len(within) != 2:
                self._refuse()
            self.low, self.high = within
            normal = statistics.NormalDist(self.mean, self.deviation)
            self.tails = normal.cdf(self.low), normal.cdf(self.high)
            if self.tails[1] - self.tails[0] < 1e-9:
                raise BadPlan(f"{self.where}: nothing of this normal "
                              "distribution is within [" + ", ".join(
                                  f"{n:g}" for n in within) + "]")
        if (self.low > self.high
                or (self.kind == "logUniform" and self.low <= 0)
                or (self.whole and not (self.low.is_integer()
                                        and self.high.is_integer()))):
            self._refuse()

    def extremes(self) -> list[Any]:
        """All values of a list, or both ends."""
        if self.kind in ("choice", "grid"):
            return self.values
        return [self.low, self.high]

    def draw(self, seed: int, scene: int, name: str, k: int = 0,
             turn: int = 0) -> Any:
        """The value of a scene; None: left as it is. turn: of a grid."""
        if self.kind == "grid":
            return self.values[turn % len(self.values)]
        if (self.chance < 1
                and uniform(seed, scene, name + "?", k) >= self.chance):
            return None
        u = uniform(seed, scene, name, k)
        if self.kind == "choice":
            return self._chosen(u)
        if self.whole:
            value = self._spread(u) if self.kind != "integer" else 0.0
            return (int(self.low + math.floor(u * (self.high - self.low + 1)))
                    if self.kind in ("integer", "uniform")
                    else int(math.floor(value + 0.5)))
        return min(max(rounded(self._spread(u)), self.low), self.high)

    def _spread(self, u: float) -> float:
        if self.kind == "logUniform":
            return self.low * math.exp(u * math.log(self.high / self.low))
        if self.kind == "normal":
            low, high = self.tails
            p = min(max(low + u * (high - low), 1e-300), 1 - 2.0 ** -53)
            value = statistics.NormalDist(self.mean, self.deviation).inv_cdf(p)
            return min(max(value, self.low), self.high)
        return self.low + u * (self.high - self.low)

    def _chosen(self, u: float) -> Any:
        rest = u * sum(self.weights)
        for value, weight in zip(self.values, self.weights):
            if rest < weight:
                return value
            rest -= weight
        return next(v for v, w in reversed(list(
            zip(self.values, self.weights))) if w > 0)

    def __str__(self) -> str:
        if self.kind in ("choice", "grid"):
            text = f"{self.kind} of " + ", ".join(map(str, self.values))
        elif self.kind == "normal":
            text = (f"normal, {self.mean:g} ± {self.deviation:g}, within "
                    f"{self.low:g} to {self.high:g}")
        else:
            text = f"{self.kind}, {self.low:g} to {self.high:g}"
        return text + (f"; in {100 * self.chance:g} % of the scenes"
                       if self.chance < 1 else "")


def _numbers(values: Any, where: str) -> list[float]:
    if not isinstance(values, list) or not all(
            isinstance(v, (int, float)) and not isinstance(v, bool)
            and math.isfinite(v) for v in values):
        raise BadPlan(f"{where}: {values!r}, numbers are wanted")
    return [float(v) for v in values]
