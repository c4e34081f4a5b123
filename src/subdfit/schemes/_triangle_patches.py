"""Box-spline patches over triangles: their points, and the matrices of their types."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.mesh.topology import Topology
from subdfit.schemes import _loop_kernels as kernels
from subdfit.schemes._corner_type import CornerType
from subdfit.schemes._level import Level
from subdfit.schemes._loop_types import OUTER, irregular_matrices, regular_matrix
from subdfit.schemes._one_shape import REGULAR, OneShapePatches
from subdfit.schemes.scheme import Refinement

Indices = NDArray[np.int32]
Rows = NDArray[np.int64]


@dataclass(frozen=True)
class TrianglePatches(OneShapePatches):
    """Patches of a scheme that is Loop's around these triangles; `refine` is the scheme's own."""

    refine: Callable[[Topology], Refinement]
    corners: int = 3
    regular_size: int = 12

    def sizes(self, faces: Rows, edges: Rows) -> Rows:
        """The corner's ring, the corner, and five points round the other two."""
        return edges + OUTER

    def points(self, level: Level, chosen: Rows, corner: Rows, start: Rows, offsets: Rows) -> tuple[Indices, Indices]:
        """List the points of patches and the mirror points they use."""
        t = level.topology
        mirror_of = np.full(len(t.face_vertices), -1, np.int32)
        mirror_corners = np.empty((np.count_nonzero(level.sharp), 3), np.int32)
        used = np.zeros(1, np.int64)
        points = kernels.patch_points(
            chosen,
            corner,
            start,
            offsets,
            t.face_vertices,
            t.twin,
            level.sharp_count,
            level.first,
            level.faces,
            level.position,
            mirror_of,
            mirror_corners,
            used,
        )
        return points, mirror_corners[: used[0]]

    def matrices(self, kind: CornerType) -> NDArray[np.float64]:
        """The matrices of a type."""
        return regular_matrix() if kind == REGULAR else irregular_matrices(kind)
