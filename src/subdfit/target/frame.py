"""The normalised frame: coordinates of any size and offset become small numbers round 0, and back."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Frame:
    """Normalised coordinates: the centre of the bounding box at 0, its diagonal 1.

    Attributes
    ----------
    centre : (3,) float64, and diagonal, in the caller's unit.
    """

    centre: Floats
    diagonal: float

    @classmethod
    def of(cls, points: Floats) -> "Frame":
        """Frame of (n, 3) points, n >= 1."""
        low, high = points.min(axis=0), points.max(axis=0)
        return cls(low + (high - low) / 2, float(np.linalg.norm(high - low)))

    def inside(self, points: Floats) -> Floats:
        """From the caller's coordinates to normalised ones."""
        return np.ascontiguousarray((points - self.centre) / self.diagonal)

    def outside(self, points: Floats) -> Floats:
        """From normalised coordinates to the caller's."""
        return np.ascontiguousarray(points * self.diagonal + self.centre)
