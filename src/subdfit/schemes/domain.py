"""Parametric faces: what a surface is walked on, the same for every scheme."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

TRIANGLE = 3
QUAD = 4

CORNERS = np.zeros((5, 4, 2))
"""Parameters of the corners of a cell, by its shape: a triangle's fourth row means nothing."""
CORNERS[TRIANGLE, :3] = [[0, 0], [1, 0], [0, 1]]
CORNERS[QUAD] = [[0, 0], [1, 0], [1, 1], [0, 1]]


@dataclass(frozen=True, eq=False)
class Domain:
    """Cells of two shapes, each with its own parameters, and how they join.

    A triangle has u, v >= 0, u + v <= 1 and its corners at (0, 0), (1, 0), (0, 1); a quad is the unit square,
    corners (0, 0), (1, 0), (1, 1), (0, 1). Side ``i`` runs from corner ``i`` to the next. See `CORNERS`.

    Attributes
    ----------
    shape : (f,) int8, `TRIANGLE` or `QUAD`.
    neighbour : (f, 4) int32, the cell beyond each side; -1 at the boundary (and at a triangle's fourth side).
    neighbour_side : (f, 4) int8, which side of the neighbour it is.
    sharp : (f, 4) bool, whether the surface has a crease or ends at that side.
    vertex : (f, 4) int32, the control vertex at each corner, -1 where a corner stands for none.
    half_edge : (f,) int32, the control mesh's half-edge at each cell's first corner.
    parts : whether cells are parts of the control mesh's faces, each at one face corner, rather than whole faces with
        corners in the face's order. A part's first corner is its vertex's, the second lies in the middle of the side
        that begins there, the third in the face's middle, the last in the middle of the side before. Along curves a
        dual scheme's parts may reach further, and face corners on them have none.
    """

    shape: NDArray[np.int8]
    neighbour: NDArray[np.int32]
    neighbour_side: NDArray[np.int8]
    sharp: NDArray[np.bool_]
    vertex: NDArray[np.int32]
    half_edge: NDArray[np.int32]
    parts: bool = False

    @property
    def face_count(self) -> int:
        """Number of cells."""
        return len(self.shape)

    @cached_property
    def present(self) -> NDArray[np.bool_]:
        """Which corners and sides there are, (f, 4): a triangle has no fourth."""
        return np.asarray(np.arange(4) < self.shape[:, None])

    def next_corner(self, cell: NDArray[np.int64], corner: NDArray[np.int64]) -> NDArray[np.int64]:
        """The corner at which the side begins that follows the one begun at `corner`, (k,)."""
        return np.asarray((corner + 1) % self.shape[cell])

    def along(
        self, cell: NDArray[np.integer], side: NDArray[np.integer], t: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Parameters at share `t` of sides of cells, all (k,), as (k, 2)."""
        shape = self.shape[cell]
        begin, end = CORNERS[shape, side], CORNERS[shape, (side + 1) % shape]
        return np.asarray((1 - t)[:, None] * begin + t[:, None] * end)

    @cached_property
    def points(self) -> NDArray[np.int64]:
        """Number of the surface's point at each corner, (f, 4), -1 where there is no corner.

        Cells that share a point share the number; a control vertex's is its own row, other points' follow.
        """
        number = np.where(self.present, self.vertex, -1).astype(np.int64)
        unnamed = self.present & (number < 0)
        if not unnamed.any():
            return number
        cell, side = np.nonzero(self.present & (self.neighbour >= 0))
        beyond, other = self.neighbour[cell, side].astype(np.int64), self.neighbour_side[cell, side].astype(np.int64)
        here, there = 4 * cell + side, 4 * beyond + self.next_corner(beyond, other)
        graph = sp.coo_array((np.ones(len(here)), (here, there)), shape=(4 * len(self.shape),) * 2)
        _, group = connected_components(graph, directed=False)
        _, rank = np.unique(group[unnamed.ravel()], return_inverse=True)
        number[unnamed] = int(self.vertex.max(initial=-1)) + 1 + rank
        return number
