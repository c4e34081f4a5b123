"""Small components with inner vertices of two faces, such as two triangles back to back, that no scheme can bend.

Catmull-Clark's limit points of two triangles back to back all lie in their centroid. Old models hold such specks by the
dozen. They are small enough for their pseudo-inverse.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from subdfit.interpolate.operator import LimitOperator
from subdfit.mesh.topology import Topology

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

MOST = 60
"""Vertices of a speck."""
_ZERO = 1e-8
"""Singular values below are 0."""


@dataclass(frozen=True, eq=False)
class Specks:
    """Components of a mesh whose part of the limit operator is singular, each with the pseudo-inverse of its part.

    Attributes
    ----------
    rows : the vertices of each.
    inverse : (k, k) for each with k vertices.
    null_vectors : number of independent control meshes of specks that have the limit 0.
    """

    rows: list[Rows]
    inverse: list[Floats]
    null_vectors: int

    @classmethod
    def of(cls, B: LimitOperator, topology: Topology) -> "Specks":
        """Find them: elsewhere the operator has no other null vectors than `NullSpace` finds."""
        found = cls([], [], 0)
        for rows in _candidates(topology):
            part = B.matrix[rows][:, rows].toarray()
            null = int(np.count_nonzero(np.linalg.svd(part, compute_uv=False) < _ZERO))
            if null:
                inverse = np.linalg.pinv(part, rtol=_ZERO)
                found = cls([*found.rows, rows], [*found.inverse, inverse], found.null_vectors + null)
        return found

    def settled(self, B: LimitOperator) -> LimitOperator:
        """The operator with the specks' rows as if their limit points were their control points."""
        if not self.rows:
            return B
        others = np.ones(B.size)
        others[np.concatenate(self.rows)] = 0.0
        return LimitOperator.of(sp.csr_array(sp.diags_array(others) @ B.matrix + sp.diags_array(1.0 - others)))

    def solved(self, data: Floats) -> Floats:
        """The data (n, 3) with the least control points of specks that come nearest, in their place."""
        if not self.rows:
            return data
        points = data.copy()
        for rows, inverse in zip(self.rows, self.inverse, strict=True):
            points[rows] = inverse @ data[rows]
        return points


def _candidates(topology: Topology) -> list[Rows]:
    """Vertices of each small component that has an inner vertex of two faces."""
    count, ends = topology.vertex_count, topology.edge_vertices
    doubtful = np.bincount(topology.face_vertices, minlength=count) == 2
    doubtful[topology.boundary_vertices] = False
    if not doubtful.any():
        return []
    links = sp.coo_array((np.ones(len(ends), np.int8), (ends[:, 0], ends[:, 1])), shape=(count, count))
    _, label = connected_components(links, directed=False)
    size = np.bincount(label)
    small = np.unique(label[doubtful & (size[label] <= MOST)])
    return [np.flatnonzero(label == component) for component in small]
