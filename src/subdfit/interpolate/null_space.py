"""Control meshes that a scheme shrinks to nothing: where the limit operator is singular.

Catmull-Clark's operator is singular on closed connected meshes whose valences are all three and whose faces all have an
even number of corners, such as a cube or a hexagonal prism: there the vertices take two colours, and a mesh with one
point for each colour, opposite to one another, has its limit at 0. A scheme whose operator equals Catmull-Clark's on
such meshes inherits this. No scheme need be asked: the two-coloured vector either is in the null space or not.
"""

from dataclasses import dataclass

import numpy as np
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
    sign : (n,) int8, +1 and -1 by turns on the components with such a vector, 0 elsewhere.
    component : (n,) int32, a vertex that names the component.
    """

    sign: NDArray[np.int8]
    component: NDArray[np.int32]

    @classmethod
    def of(cls, B: LimitOperator, topology: Topology) -> "NullSpace":
        """Find the components whose two-coloured vector has the limit 0 everywhere."""
        if topology.triangles_only:
            return cls(np.zeros(B.size, np.int8), np.zeros(B.size, np.int32))
        sign, component = kernels.two_colours(topology.edge_vertices, B.size)
        astray = np.zeros(B.size, np.bool_)
        astray[component[np.abs(B.matrix @ sign.astype(np.float64)) > _ROUNDING]] = True
        return cls(np.where(astray[component], 0, sign).astype(np.int8), component)

    @property
    def count(self) -> int:
        """Number of components with a null vector."""
        return len(np.unique(self.component[self.sign != 0]))

    def without(self, points: Floats) -> Floats:
        """Points (n, 3) less their part along the null vectors: data that can be interpolated, or the least solution.

        The weights that make the operator symmetric are constant on such components, so one projection serves both.
        """
        if not self.sign.any():
            return points
        size = np.maximum(np.bincount(self.component, np.abs(self.sign), len(points)), 1)
        share = [np.bincount(self.component, self.sign * column, len(points)) / size for column in points.T]
        return np.asarray(points - self.sign[:, None] * np.stack(share, axis=1)[self.component])
