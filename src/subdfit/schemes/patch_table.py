"""A control mesh's topology, compiled for evaluation: which matrix takes which points to which polynomial.

Kernels read these arrays and know polynomial patches, never schemes. A *cell* (parametric face) is one patch, or is cut
in four, and again, until each part is one: to keep irregular corners apart, and to get past semi-sharp creases. A patch
lists points and has a *type*. A regular type holds one matrix from those points to the coefficients of a polynomial in
the patch's (u, v). An irregular type has its irregular corner at (0, 0) and holds such matrices for the three regular
sub-patches of every level of refinement towards that corner, and one, the last, for the corner itself.

Along some lines a surface is no polynomial at all, however near one looks. A *strip* is what lies beside such a line.
Where a matrix leads to a strip, its `STRIDE` numbers are no coefficients but stand for the strip: the first of its
points, and the others relative to that. Further matrices take them to the numbers of its four parts, polynomials or
strips again. After so many steps a polynomial that touches the surface in the corners stands for the strip.

The points of patches are the control points followed by *local points*, fixed combinations of control points:
refined vertices where a cell is cut, and mirror points beyond boundaries and creases.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

LEVELS = 52
"""Levels of refinement kept towards an irregular corner: below 2^-52 a parameter is the corner's."""
STRIDE = 16
"""Coefficients stored a point, see `PatchTable.matrices`."""


class PatchType(NamedTuple):
    """A type of patches.

    Attributes
    ----------
    size : points of a patch.
    levels : 0 if regular, else `LEVELS`.
    strips : the strip of each sub-patch (of a regular type's patch itself: the first), -1 for polynomials.
    matrices : as in `PatchTable.matrices`.
    """

    size: int
    levels: int
    strips: tuple[int, int, int]
    matrices: NDArray[np.float64]


class Strips(NamedTuple):
    """The strips of a scheme.

    Attributes
    ----------
    parts : (s, 4) int8, the strip that each part of a strip is, -1 for a polynomial.
    sides : (s,) int8, the side of its cell along which a strip begins again on each finer level, -1 for none.
    products : (s,) int32, the first of the matrices that lead along this side by `AT_ONCE` levels, in sequence.
    matrices : flat float64, `STRIDE` by `STRIDE` each and stored number by number like `PatchTable.matrices`: five a
        strip, to the numbers of its parts and to the polynomial that stands for the strip in the end; then `products`.
    levels : levels of refinement before that.
    """

    parts: NDArray[np.int8]
    sides: NDArray[np.int8]
    products: NDArray[np.int32]
    matrices: NDArray[np.float64]
    levels: int


NO_STRIPS = Strips(np.empty((0, 4), np.int8), np.empty(0, np.int8), np.empty(0, np.int32), np.empty(0), 0)
AT_ONCE = 6
"""Levels that one matrix leads along the line beside which a strip lies."""


@dataclass(frozen=True, eq=False)
class PatchTable:
    """Patches of all cells.

    Attributes
    ----------
    point_matrix : (points, n) sparse, patch points from control points; its first n rows are the identity.
    cell_node : (f,) int32, the patch of each cell, or ``~row`` of `node_children` where it is cut.
    node_children : (s, 4) int32, the parts of what is cut, patches or cut again: one at each corner, and for a
        triangle the middle one last, whose parameters are turned by half.
    patch_type : (p,) int32.
    patch_corner : (p,) int8, the corner of the patch's cell (or part of one) that is its (0, 0).
    patch_offset : (p + 1,) int64 into `patch_points`.
    patch_points : int32, rows of the patch points.
    type_size : (t,) int32, points of a patch of that type.
    type_levels : (t,) int32, 0 for a regular type, else `LEVELS`.
    type_offset : (t,) int64, where its first matrix begins in `matrices`.
    type_strips : (t, 3) int8, see `PatchType.strips`.
    matrices : float64; a matrix is stored point by point, `STRIDE` coefficients each: on triangles the 15 monomials
        u^i v^j, i + j <= 4, ordered by i then j, and a zero; on quads those with i, j <= 3. The sub-patch ``j`` =
        0, 1, 2 (beside the second corner, beside the last, between) of level ``l`` >= 1 is matrix ``3 (l - 1) + j``,
        the corner itself matrix ``3 levels``.
    strips : what the strips are.
    quad_degree : highest power of u and of v on quads, 3 or 2.
    """

    point_matrix: sp.csr_array
    cell_node: NDArray[np.int32]
    node_children: NDArray[np.int32]
    patch_type: NDArray[np.int32]
    patch_corner: NDArray[np.int8]
    patch_offset: NDArray[np.int64]
    patch_points: NDArray[np.int32]
    type_size: NDArray[np.int32]
    type_levels: NDArray[np.int32]
    type_offset: NDArray[np.int64]
    type_strips: NDArray[np.int8]
    matrices: NDArray[np.float64]
    strips: Strips
    quad_degree: int = 3

    @property
    def local_matrix(self) -> sp.csr_array:
        """The rows of `point_matrix` that are not control points."""
        return self.point_matrix[self.point_matrix.shape[1] :]
