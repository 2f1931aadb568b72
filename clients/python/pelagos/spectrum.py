"""The numbers of a sea."""
from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from . import need, schema

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Spectrum(schema.Spectrum):
    """Moments (`spectrum`, `drawn`), `peakPeriod`, `meanDirection`, `whitecaps`
    and, where frequencies were asked for, the spectrum itself, by rows or as
    arrays over them:"""

    @property
    def omega(self) -> "NDArray[np.float64]":
        """Angular frequencies [rad/s], (n,)."""
        return self._column("omega")

    @property
    def density(self) -> "NDArray[np.float64]":
        """S(omega) over all directions [m2 s/rad], (n,)."""
        return self._column("density")

    @property
    def direction(self) -> "NDArray[np.float64]":
        """Mean direction that the waves come from [deg], (n,)."""
        return self._column("direction")

    @property
    def spread(self) -> "NDArray[np.float64]":
        """Circular standard deviation of direction [deg], (n,)."""
        return self._column("spread")

    @property
    def directional(self) -> "NDArray[np.float64]":
        """S(omega, theta) [m2 s/rad2], (n, directions): of waves that come
        from 0, 360/directions, ... deg; (n, 0) where none were asked for."""
        np = need.numpy()
        if not self.rows:
            return np.empty((0, 0))
        return np.array([row.directional for row in self.rows],
                        np.float64).reshape(len(self.rows), -1)

    @property
    def significantHeight(self) -> float:
        """Of the spectrum itself [m]."""
        moments = self.spectrum
        return (moments.significantHeight or 0.0) if moments else 0.0

    def _column(self, name: str) -> "NDArray[np.float64]":
        np = need.numpy()
        return np.array([getattr(row, name) or 0.0 for row in self.rows],
                        np.float64)
