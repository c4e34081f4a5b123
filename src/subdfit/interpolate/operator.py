"""The limit operator B, which takes the vertices of a control mesh to their limit points."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.interpolate import _kernels as kernels
from subdfit.parallel import map_chunks

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

CHUNK = 65536
"""Rows that one thread takes at a time."""

ROUNDING = 1e-9
"""Relative asymmetry that long chains of quotients of masks may leave in a symmetric matrix."""


@dataclass(frozen=True, eq=False)
class LimitOperator:
    """The matrix B of limit masks, (n, n), in the form that kernels take.

    Attributes
    ----------
    matrix : B, with ascending columns in each row.
    """

    matrix: sp.csr_array

    @classmethod
    def of(cls, rows: sp.csr_array) -> "LimitOperator":
        """Take what a scheme's `limit_rows` gives, and sort it where it stands."""
        rows.sort_indices()
        return cls(rows)

    def breadth_first(self) -> tuple["LimitOperator", NDArray[np.int32]]:
        """The same operator with vertices in an order in which neighbours are near one another in memory, too.

        Our number of its vertex i is the i-th of the second result.
        """
        offsets, columns, values = self.arrays
        order, number = kernels.breadth_first(offsets, columns)
        starts = np.concatenate([[0], np.cumsum(np.diff(offsets)[order])])
        moved, copied = np.empty_like(columns), np.empty_like(values)
        numbers = (*self.arrays, order, number, starts)
        map_chunks(lambda a, b: kernels.renumber(*numbers, a, b, moved, copied), self.size, CHUNK)
        return LimitOperator(sp.csr_array((copied, moved, starts), self.matrix.shape)), order

    @cached_property
    def arrays(self) -> tuple[NDArray[np.int64], NDArray[np.int32], Floats]:
        """Offsets, columns and values of the rows."""
        m = self.matrix
        return m.indptr.astype(np.int64), m.indices.astype(np.int32, copy=False), m.data

    @property
    def size(self) -> int:
        """Number of vertices."""
        return int(self.matrix.shape[0])

    def times(self, x: Floats) -> Floats:
        """B x, for x (n, 3)."""
        out = np.empty_like(x)
        self.energy(np.zeros(self.size), x, out)
        return out

    def energy(self, weight: Floats, x: Floats, out: Floats) -> float:
        """x^T D B x with D = diag(weight); B x is written into `out`."""
        parts = map_chunks(lambda a, b: kernels.product(*self.arrays, weight, x, a, b, out), self.size, CHUNK)
        return float(sum(parts))

    def distances(self, x: Floats, data: Floats) -> Floats:
        """Distance of each limit point from its datum, (n,)."""
        out = np.empty(self.size)
        map_chunks(lambda a, b: kernels.gaps(*self.arrays, data, x, a, b, out), self.size, CHUNK)
        return out

    @cached_property
    def on_curves(self) -> Flags:
        """Rows with at most three entries that refer to such rows only, (n,).

        These are corners and vertices of creases and boundaries: the limit of a subdivision curve at a vertex depends
        on it and its two neighbours along the curve. They make B block triangular.
        """
        offsets, columns, _ = self.arrays
        inside = np.diff(offsets) <= 3
        while True:
            rows = np.flatnonzero(inside)
            length = np.diff(offsets)[rows]
            entry = np.repeat(offsets[rows] - np.cumsum(length) + length, length) + np.arange(length.sum())
            astray = np.repeat(rows, length)[~inside[columns[entry]]]
            if not len(astray):
                return inside
            inside[astray] = False

    @cached_property
    def weights(self) -> Floats | None:
        """The d > 0 that make diag(d) B symmetric among the vertices off curves, 0 on curves, (n,); None if none do.

        They exist for Loop, N / (1 - beta), for Catmull-Clark, n (n + 5), and for Doo-Sabin, n, but not round darts.
        Here they are found from the entries of B alone.
        """
        free = ~self.on_curves
        weight = kernels.spread_weights(*self.arrays, free)
        if np.any(free & (weight <= 0)):
            return None
        parts = map_chunks(lambda a, b: kernels.asymmetry(*self.arrays, free, weight, a, b), self.size, CHUNK)
        return weight if max(parts) <= ROUNDING else None
