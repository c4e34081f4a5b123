"""Matrices of biquadratic patches, regular and towards the middle of a face that is no quad.

The points of a patch, whose face at (0, 0) has M corners, are that face's, counter-clockwise from the patch's own
vertex q, then the other five round it:

        d3 --- n2 --- d2          q       in the middle; the patch is the square between the middles of its four faces
        |      |      |           p1      next of the face at (0, 0), beyond the side u = 0
        p1 --- q  --- n1          p(M-1)  its last, beyond the side v = 0
        |      |      |           d, n    corners of the other three faces, all quads
        p2 -- p(M-1)- d1
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from subdfit.schemes._doo_sabin_masks import averaging_mask, half_mask, original_mask
from subdfit.schemes._irregular import towards_corner
from subdfit.schemes.patch_table import STRIDE

Matrix = NDArray[np.float64]

REGULAR, ORIGINAL, AVERAGING, CONE = range(4)
"""What the face at (0, 0) is: a quad; another, with one of the masks; a corner of curves with the vertices V, q, p1 and
p(M-1)."""

BEFORE, AFTER = 1, 2
"""Where a crease ends in a corner of the face at (0, 0) beside q: in p(M-1), or in p1."""
TIP = 4
"""What the face is takes one of these values, plus TIP times one of those if a crease ends there."""

OUTER = 5
U, V = 4, 1
"""Which coefficients are those of u and of v."""


def patch_matrices(code: int, m: int) -> Matrix:
    """Matrices of a type, in the order that `PatchTable.matrices` documents."""
    if code == REGULAR:
        return _biquadratic(np.array([[2, 1, 8], [3, 0, 7], [4, 5, 6]]), np.eye(9)).T.ravel()
    if code == CONE:
        return _cone()
    mask = averaging_mask(m) if code % TIP == AVERAGING else original_mask(m)
    size = m + OUTER
    limit, tangents = np.zeros(size), np.zeros((2, size))
    limit[:m] = 1 / m
    # The two subdominant eigenvectors of both masks are cos and sin(2 pi j / m).
    eigen = 2 / m * np.cos(2 * np.pi * (np.arange(m) - np.arange(m)[:, None]) / m)
    tangents[:, :m] = eigen[0] + eigen[-1], eigen[0] + eigen[1]
    return _towards(mask, (0, 1, m - 1), limit, tangents, code // TIP)


def _cone() -> Matrix:
    """Towards a corner V of curves where every direction keeps its own tangent; face points V, q, p1, p(M-1)."""
    mask = np.eye(4) / 2
    mask[:, 0] += 1 / 2
    limit, tangents = np.zeros(4 + OUTER), np.zeros((2, 4 + OUTER))
    limit[0] = 1
    tangents[:, :4] = [-2, 1, 0, 1], [-2, 1, 1, 0]
    return _towards(mask, (1, 2, 3), limit, tangents)


def _towards(mask: Matrix, near: tuple[int, int, int], limit: Matrix, tangents: Matrix, tip: int = 0) -> Matrix:
    """All matrices of an irregular type, from its face's mask and which of the face's points are q, p1 and p(M-1).

    A crease that ends at p(M-1) comes from d1, and one that ends at p1 from d3: the quad there is half a face, and seen
    from the children beyond it, images of their points in the crease take the place of those across it.
    """
    m = len(mask)
    q, p1, last = near
    unit = np.eye(m + OUTER)
    d1, n1, d2, n2, d3 = unit[m:]
    quad = original_mask(4)
    # Corners of the three quads, each in the order of its points.
    half = half_mask(4)
    right = quad @ [unit[q], unit[last], d1, n1]
    opposite = quad @ [unit[q], n1, d2, n2]
    upper = quad @ [unit[q], n2, d3, unit[p1]]
    if tip == BEFORE:
        right = np.roll(half @ [unit[last], d1, n1, unit[q]], 1, axis=0)
    elif tip == AFTER:
        upper = np.roll(half @ [d3, unit[p1], unit[q], n2], -2, axis=0)
    face = mask @ unit[:m]
    smaller = np.vstack([face, right[1], right[0], opposite[0], upper[0], upper[3]])
    # The refined points by column and row, (0, 0) at the left below; the child of q and those of its quads in them.
    fine = [
        [None, face[p1], upper[3], upper[2]],
        [face[last], face[q], upper[0], upper[1]],
        [right[1], right[0], opposite[0], opposite[3]],
        [right[2], right[3], opposite[1], opposite[2]],
    ]
    if tip == BEFORE:
        for column, image in zip(fine[1:], (face[q], right[0], right[3]), strict=True):
            column[0] = 2 * column[0] - image
    elif tip == AFTER:
        fine[0][1:] = [2 * point - image for point, image in zip(fine[0][1:], (face[q], *upper[:2]), strict=True)]
    children = [(1, 0), (0, 1), (1, 1)]
    grids = [np.array([[fine[i + a][j + b] for b in range(3)] for a in range(3)]) for i, j in children]
    polynomials = [_biquadratic(np.arange(9).reshape(3, 3), grid.reshape(9, -1)) for grid in grids]
    return towards_corner(smaller, polynomials, limit, tangents, (U, V))


def _biquadratic(grid: NDArray[np.int64], points: Matrix) -> Matrix:
    """Coefficients (STRIDE, n) of the patch over a grid of rows of `points` (k, n), indexed by column and row."""
    spline = _spline()
    patch = np.zeros((4, 4, points.shape[1]))
    patch[:3, :3] = np.einsum("ai,bj,ijn->abn", spline, spline, points[grid])
    return patch.reshape(STRIDE, -1)


@cache
def _spline() -> Matrix:
    """Powers 1, t, t^2 of the uniform quadratic B-spline's three pieces in one span, (3, 3)."""
    return np.array([[1, 1, 0], [-2, 2, 0], [1, -2, 1]]) / 2
