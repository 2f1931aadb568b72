"""The part of gymnasium's interface that usv_env.py uses, for where gymnasium is
not installed: spaces Box and Dict, and what gymnasium.Env gives. NumPy only."""
from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]


def generator(seed: int | None) -> np.random.Generator:
    if seed is not None and (not isinstance(seed, int) or seed < 0):
        raise ValueError(f"a seed is a whole number from 0 on, not {seed}")
    return np.random.default_rng(seed)


class Space:
    """Of shape and dtype, with a generator of its own."""

    def __init__(self, shape: tuple[int, ...] | None = None,
                 dtype: Any = None) -> None:
        self.shape = shape
        self.dtype = None if dtype is None else np.dtype(dtype)
        self.random = np.random.default_rng()

    def seed(self, seed: int | None = None) -> None:
        self.random = np.random.default_rng(seed)


class Box(Space):
    """Arrays between low and high."""

    def __init__(self, low: Any, high: Any,
                 shape: tuple[int, ...] | None = None,
                 dtype: Any = np.float32) -> None:
        super().__init__(np.shape(low) if shape is None else shape, dtype)
        self.low = np.broadcast_to(low, self.shape or ()).astype(dtype)
        self.high = np.broadcast_to(high, self.shape or ()).astype(dtype)

    def sample(self) -> Array:
        if self.dtype is not None and self.dtype.kind in "iu":
            return self.random.integers(
                self.low, self.high, endpoint=True, dtype=self.dtype)
        wide = np.clip(self.high.astype(float), -1e6, 1e6)
        low = np.clip(self.low.astype(float), -1e6, 1e6)
        return self.random.uniform(low, wide).astype(self.dtype)

    def contains(self, x: Any) -> bool:
        return bool(isinstance(x, np.ndarray) and x.dtype == self.dtype
                    and x.shape == self.shape and (x >= self.low).all()
                    and (x <= self.high).all())

    def __contains__(self, x: Any) -> bool:
        return self.contains(x)


class Dict(Space):
    """Spaces by name."""

    def __init__(self, members: Mapping[str, Any]) -> None:
        super().__init__()
        self.spaces = dict(members)

    def seed(self, seed: int | None = None) -> None:
        for n, space in enumerate(self.spaces.values()):
            space.seed(None if seed is None else seed + n)

    def sample(self) -> dict[str, Any]:
        return {n: space.sample() for n, space in self.spaces.items()}

    def contains(self, x: Any) -> bool:
        return (isinstance(x, dict) and x.keys() == self.spaces.keys()
                and all(s.contains(x[n]) for n, s in self.spaces.items()))

    def __contains__(self, x: Any) -> bool:
        return self.contains(x)

    def __getitem__(self, name: str) -> Any:
        return self.spaces[name]


class Env:
    """What gymnasium.Env gives to those who inherit it."""
    metadata: dict[str, Any] = {"render_modes": []}
    render_mode: str | None = None
    spec: Any = None
    action_space: Any
    observation_space: Any

    def reset(self, *, seed: int | None = None,
              options: dict[str, Any] | None = None) -> Any:
        if seed is not None:
            self.np_random = generator(seed)

    @property
    def unwrapped(self) -> Any:
        return self

    @property
    def np_random(self) -> np.random.Generator:
        if getattr(self, "_random", None) is None:
            self._random = generator(None)
        return self._random

    @np_random.setter
    def np_random(self, value: np.random.Generator) -> None:
        self._random = value

    def close(self) -> None:
        pass

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
