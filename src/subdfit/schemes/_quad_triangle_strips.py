"""Strips beside regular seams, where the surface is no polynomial: one step into each part, and what stands for it."""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from subdfit.schemes._loop_types import monomials
from subdfit.schemes._quad_triangle_kinds import Regular, Strip
from subdfit.schemes._quad_triangle_parts import Part, parts, polynomials
from subdfit.schemes.domain import CORNERS
from subdfit.schemes.patch_table import AT_ONCE, STRIDE, Strips

Matrix = NDArray[np.float64]

STRIPS = [(Strip(3, touching), turn) for touching in range(4) for turn in range(3)]
STRIPS += [(Strip(4, 0), turn) for turn in range(4)]
"""Strips by their number: kind, and the corner of the parametric face at which the strip begins."""
LEVELS = 18
"""Steps into a strip: what then stands for it errs in its derivatives by the square of 2^-18."""
NEAR = 60
"""Steps towards a corner after which nothing but its limit and its tangents is left, to the last digit."""


def part_numbers(part: Part) -> tuple[int, Matrix]:
    """The strip that a part is (-1: a polynomial), and the matrix (STRIDE, n) from the whole's points."""
    if isinstance(part.kind, Regular):
        return -1, polynomials(part.kind.size) @ part.matrix
    assert isinstance(part.kind, Strip)
    return STRIPS.index((part.kind, part.turn)), relative(part.matrix)


def relative(points: Matrix) -> Matrix:
    """The numbers that stand for a strip's points (k, n): the first, and the others relative to it; (STRIDE, n)."""
    numbers = np.zeros((STRIDE, points.shape[1]))
    numbers[0] = points[0]
    numbers[1 : len(points)] = points[1:] - points[0]
    return numbers


@cache
def strips() -> Strips:
    """All strips."""
    kinds, turns = zip(*STRIPS, strict=True)
    found = [[part_numbers(part) for part in quarters] for quarters in parts(kinds, turns)]
    child = np.array([[number for number, _ in row] for row in found], np.int8)
    steps = np.array([[_from_relative(matrix) for _, matrix in row] for row in found])
    ends = np.array([_touching_polynomial(child, steps, strip) for strip in range(len(STRIPS))])
    single = np.concatenate([steps, ends[:, None]], axis=1).reshape(-1, STRIDE, STRIDE)
    sides = np.array([-1 if kind.touching else turn for kind, turn in STRIPS], np.int8)
    seams = np.flatnonzero(sides >= 0)
    along = [_along_side(steps[strip, [sides[strip], (sides[strip] + 1) % STRIPS[strip][0].size]]) for strip in seams]
    products = np.full(len(STRIPS), -1, np.int32)
    products[seams] = len(single) + 2**AT_ONCE * np.arange(len(seams))
    matrices = np.concatenate([single, *along])
    return Strips(child, sides, products, matrices.swapaxes(1, 2).ravel(), LEVELS)


def _along_side(halves: Matrix) -> Matrix:
    """Matrices to the pieces of a side that is halved `AT_ONCE` times, by those to its halves, (2, STRIDE, STRIDE)."""
    pieces = np.eye(STRIDE)[None]
    for _ in range(AT_ONCE):
        pieces = (halves @ pieces[:, None]).reshape(-1, STRIDE, STRIDE)
    return pieces


def _from_relative(rows: Matrix) -> Matrix:
    """The same for a strip's numbers instead of its points, (STRIDE, STRIDE); sums of rows are 1 or exactly 0."""
    matrix = np.zeros((STRIDE, STRIDE))
    matrix[:, 1 : rows.shape[1]] = rows[:, 1:]
    matrix[0, 0] = 1.0
    return matrix


def _touching_polynomial(child: NDArray[np.int8], steps: Matrix, strip: int) -> Matrix:
    """The polynomial with the strip's limit points and derivatives in its corners, (STRIDE, STRIDE)."""
    size = STRIPS[strip][0].size
    corners = np.array([_corner_limit(child, steps, strip, corner) for corner in range(size)])
    return _from_relative(_cubic(corners) if size == 3 else _bicubic(corners))


def _corner_limit(child: NDArray[np.int8], steps: Matrix, strip: int, corner: int) -> Matrix:
    """Limit point and derivatives by u and v in a corner, (3, STRIDE)."""
    size = STRIPS[strip][0].size
    numbers, scale, at = np.eye(STRIDE), 1.0, strip
    while at >= 0 and scale < 2.0**NEAR:
        numbers, at, scale = steps[at, corner] @ numbers, int(child[at, corner]), 2 * scale
    if at < 0:
        return np.array([[1.0], [scale], [scale]]) * (_at_corner(size, corner) @ numbers)
    numbers[0], base = 0.0, numbers[0].copy()
    place = np.roll(numbers[:size], STRIPS[at][1], axis=0)
    # Seen so near, the strip is flat: either side of a quad along u will do.
    return np.array([base, scale * (place[1] - place[0]), scale * (place[-1] - place[0])])


def exponents(size: int) -> list[tuple[int, int]]:
    """Exponents (i, j) of the monomials u^i v^j over a cell of so many corners."""
    return monomials() if size == 3 else [(i, j) for i in range(4) for j in range(4)]


def _at_corner(size: int, corner: int, orders: tuple[tuple[int, int], ...] = ((0, 0), (1, 0), (0, 1))) -> Matrix:
    """Rows that differentiate a polynomial, so often by u and by v, in a corner of its cell, (orders, STRIDE)."""
    u, v = CORNERS[size, corner]
    rows = np.zeros((len(orders), STRIDE))
    for row, (a, b) in zip(rows, orders, strict=True):
        for k, (i, j) in enumerate(exponents(size)):
            if i >= a and j >= b:
                row[k] = (i if a else 1) * (j if b else 1) * u ** (i - a) * v ** (j - b)
    return rows


def _cubic(corners: Matrix) -> Matrix:
    """The cubic with given points and derivatives in the corners (3, 3, n) of a triangle that keeps quadratics.

    Of the one degree of freedom left, 2 a30 - a21 - a12 + 2 a03 = 0 disposes, which holds for quadratics and does not
    prefer a corner (Farin 1986, the nine-parameter interpolant).
    """
    order = [sum(pair) for pair in exponents(3)]
    keep = np.array([k for k, total in enumerate(order) if total <= 3])
    conditions = np.vstack([_at_corner(3, corner) for corner in range(3)])[:, keep]
    last = [{(3, 0): 2.0, (2, 1): -1.0, (1, 2): -1.0, (0, 3): 2.0}.get(exponents(3)[k], 0.0) for k in keep]
    values = np.vstack([corners.reshape(9, -1), np.zeros(corners.shape[2])])
    out = np.zeros((STRIDE, corners.shape[2]))
    out[keep] = np.linalg.solve(np.vstack([conditions, last]), values)
    return out


def _bicubic(corners: Matrix) -> Matrix:
    """The bicubic with given points and derivatives in the corners (4, 3, n) of a quad, its twists from the sides."""
    by_u, by_v = corners[:, 1], corners[:, 2]
    along = {0: by_v[1] - by_v[0], 1: by_v[1] - by_v[0], 2: by_v[2] - by_v[3], 3: by_v[2] - by_v[3]}
    across = {0: by_u[3] - by_u[0], 3: by_u[3] - by_u[0], 1: by_u[2] - by_u[1], 2: by_u[2] - by_u[1]}
    twists = np.array([(along[i] + across[i]) / 2 for i in range(4)])
    values = np.concatenate([corners, twists[:, None]], axis=1).reshape(16, -1)
    orders = ((0, 0), (1, 0), (0, 1), (1, 1))
    return np.linalg.solve(np.vstack([_at_corner(4, corner, orders) for corner in range(4)]), values)
