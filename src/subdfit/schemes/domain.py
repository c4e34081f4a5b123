"""Parametric faces: what a surface is walked on, the same for every scheme."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

TRIANGLE = 3
QUAD = 4


@dataclass(frozen=True, eq=False)
class Domain:
    """Cells of two shapes, each with its own parameters, and how they join.

    A triangle has u, v >= 0, u + v <= 1 and its corners at (0, 0), (1, 0), (0, 1); a quad is the unit square,
    corners (0, 0), (1, 0), (1, 1), (0, 1). Side ``i`` runs from corner ``i`` to the next.

    Attributes
    ----------
    shape : (f,) int8, `TRIANGLE` or `QUAD`.
    neighbour : (f, 4) int32, the cell beyond each side; -1 at the boundary (and at a triangle's fourth side).
    neighbour_side : (f, 4) int8, which side of the neighbour it is.
    sharp : (f, 4) bool, whether the surface has a crease or ends at that side.
    vertex : (f, 4) int32, the control vertex at each corner, -1 where a corner stands for none.
    """

    shape: NDArray[np.int8]
    neighbour: NDArray[np.int32]
    neighbour_side: NDArray[np.int8]
    sharp: NDArray[np.bool_]
    vertex: NDArray[np.int32]

    @property
    def face_count(self) -> int:
        """Number of cells."""
        return len(self.shape)
