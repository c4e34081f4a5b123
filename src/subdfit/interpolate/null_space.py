"""Control meshes that a scheme shrinks to nothing: where the limit operator is singular.

Catmull-Clark's operator is singular on closed connected meshes whose valences are all three and whose faces all have an
even number of corners, such as a cube or a hexagonal prism: there the vertices take two colours, and a mesh with one
point for each colour, opposite to one another, has its limit at 0. The cube stays singular with a crease along one
edge. A scheme whose operator equals Catmull-Clark's on such meshes inherits this. No scheme need be asked: the
two-coloured vector either is in the null space or not.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse.linalg as spl
from numpy.typing import NDArray

from subdfit.interpolate import _kernels as kernels
from subdfit.interpolate.operator import LimitOperator
from subdfit.mesh.topology import Topology

Floats = NDArray[np.float64]

_ROUNDING = 1e-12


@dataclass(frozen=True, eq=False)
class NullSpace:
    """Alternating vectors that the operator takes to zero, one for each of some components of the mesh.

    Attributes
    ----------
    right : (n,), +1 and -1 by turns on the components with such a vector, 0 elsewhere: B right = 0.
    left : (n,), as many vectors, orthogonal to all limit points that there can be: left B = 0.
    component : (n,) int32, a vertex that names the component.
    """

    right: Floats
    left: Floats
    component: NDArray[np.int32]

    @classmethod
    def of(cls, B: LimitOperator, topology: Topology) -> "NullSpace":
        """Find the components whose two-coloured vector has the limit 0 everywhere."""
        none = np.zeros(B.size)
        if topology.triangles_only:
            return cls(none, none, np.zeros(B.size, np.int32))
        sign, component = kernels.two_colours(topology.edge_vertices, B.size)
        astray = np.zeros(B.size, np.bool_)
        astray[component[np.abs(B.matrix @ sign.astype(np.float64)) > _ROUNDING]] = True
        right = np.where(astray[component], 0.0, sign)
        found = cls(right, none, component)
        return cls(right, found._left(B), component) if right.any() else found

    @property
    def count(self) -> int:
        """Number of components with a null vector."""
        return len(np.unique(self.component[self.right != 0]))

    def reachable(self, data: Floats) -> Floats:
        """The nearest to the data (n, 3) that limit points can be."""
        return self._without(self.left, data)

    def least(self, points: Floats) -> Floats:
        """The least control points (n, 3) with the same limit points."""
        return self._without(self.right, points)

    def _without(self, vectors: Floats, points: Floats) -> Floats:
        """Points less their part along one vector in each component."""
        if not vectors.any():
            return points
        return np.stack([column - vectors * self._along(vectors, column) for column in points.T], axis=1)

    def _along(self, vectors: Floats, column: Floats) -> Floats:
        """By component, the share of its vector in a column: a number for each vertex."""
        square = np.bincount(self.component, vectors**2, len(column))
        share = np.bincount(self.component, vectors * column, len(column)) / np.where(square > 0, square, 1.0)
        return np.asarray(share[self.component])

    def _left(self, B: LimitOperator) -> Floats:
        """The left null vectors: those of B + R R^T, which is regular, with the right ones R as right side."""
        transposed = B.matrix.T.tocsr()
        shape = (B.size, B.size)
        filled = spl.LinearOperator(
            shape, matvec=lambda x: transposed @ x + self.right * self._along(self.right, x), dtype=np.float64
        )
        return np.asarray(spl.bicgstab(filled, self.right, rtol=1e-14)[0])
