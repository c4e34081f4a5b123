"""What one step of subdivision makes of patches over triangles and quads.

The step is read off the scheme itself: examples of the kinds are refined, and the patches of their children are listed
as any others are.
"""

from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.schemes._level import Level
from subdfit.schemes._loop_types import box_spline
from subdfit.schemes._quad_patches import bicubic_basis
from subdfit.schemes._quad_triangle_kinds import Kind, Regular, groups
from subdfit.schemes._quad_triangle_patches import Points, examples, list_points
from subdfit.schemes._quad_triangle_rules import refine

Rows = NDArray[np.int64]
Matrix = NDArray[np.float64]


class Part(NamedTuple):
    """A quarter of a patch after one step.

    `turn` is the corner of the quarter at which its own patch begins; `matrix` takes the patch's points to its points.
    """

    kind: Kind
    turn: int
    matrix: Matrix


def parts(kinds: Sequence[Kind], turns: Sequence[int] | None = None) -> list[list[Part]]:
    """The quarters of a patch of each kind, in the order of the parts of its cell, at whose corner `turn` it begins."""
    level, half_edges = examples(kinds)
    step, t, count = refine(level.topology), level.topology, len(kinds)
    fine = Level.of(step.child)
    face = t.face[half_edges].astype(np.int64)
    size = np.array([kind.size for kind in kinds])[:, None]
    turn = np.zeros((count, 1), np.int64) if turns is None else np.array(turns)[:, None]
    corner = ((half_edges - t.face_offsets[face])[:, None] - turn) % size
    place = np.arange(4)
    children = 4 * face[:, None] + np.where((size == 3) & (place == 3), 3, (corner + place) % size)
    # Where a quarter's own parameters begin: a triangle's children keep its order.
    begin = fine.topology.face_offsets[children] + np.where(size == 3, corner, -place % size)
    found, which, first = _listed(fine, children.ravel(), begin.ravel())
    turned = (first - begin.ravel()) % np.repeat(size, 4)
    whole = list_points(level, kinds, np.arange(count), half_edges)
    matrices = _matrices(whole, list_points(fine, found, which, first), step.matrix)
    out = [Part(found[which[i]], int(turned[i]), matrices[i]) for i in range(4 * count)]
    return [out[i : i + 4] for i in range(0, 4 * count, 4)]


def _listed(level: Level, faces: Rows, begin: Rows) -> tuple[list[Kind], Rows, Rows]:
    """Kinds, which of them each face is, and the half-edges that leave first corners; `begin`, if any may be first."""
    found = groups(level, faces)
    which, first = np.full(len(faces), -1), begin.copy()
    for number, group in enumerate(found):
        which[group.rows] = number
        if not isinstance(group.kind, Regular):
            first[group.rows] = group.half_edges
    assert (which >= 0).all()
    return [group.kind for group in found], which, first


def _matrices(whole: Points, fine: Points, step: sp.csr_array) -> list[Matrix]:
    """For each four parts of refined patches the matrices from the patch's points to theirs."""
    a, b, c = fine.corners.T
    mirrored = sp.diags_array((b >= 0).astype(np.float64))
    rows = sp.coo_array(step[a] + mirrored @ (step[np.maximum(b, 0)] - step[np.maximum(c, 0)]))
    columns = np.diff(whole.start)
    column = np.full(step.shape[1], -1)
    column[whole.corners[:, 0]] = np.arange(len(whole.corners)) - np.repeat(whole.start[:-1], columns)
    part = np.repeat(np.arange(len(fine.start) - 1), np.diff(fine.start))
    width = columns[part // 4]
    begin = np.cumsum(width) - width
    own = column[rows.col] >= 0
    assert np.all(np.abs(rows.data[~own]) < 1e-12), "a patch depends on its own points only"
    flat = np.zeros(int(width.sum()))
    flat[begin[rows.row[own]] + column[rows.col[own]]] = rows.data[own]
    ends = np.append(begin, len(flat))[fine.start]
    return [flat[i:j].reshape(-1, columns[k // 4]) for k, (i, j) in enumerate(pairwise(ends))]


@cache
def polynomials(size: int) -> Matrix:
    """Polynomials of a regular patch over a face of so many corners, (STRIDE, points)."""
    return bicubic_basis() if size == 4 else box_spline()[:, [*range(7), 9, 8, 7, 10, 11]]
