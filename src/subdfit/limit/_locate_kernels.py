"""The polynomial or strip under a parameter of a cell."""

from typing import NamedTuple

import numpy as np

from subdfit.compiled import inlined_kernel

TRIANGLE, QUAD = 3, 4
"""Shapes of cells, as in `subdfit.schemes.domain`."""


class Patches(NamedTuple):
    """The arrays of a patch table (see `subdfit.schemes.patch_table`), the shapes of its cells, its points (n, 3)."""

    cell_shape: np.ndarray
    cell_node: np.ndarray
    node_children: np.ndarray
    patch_type: np.ndarray
    patch_corner: np.ndarray
    patch_offset: np.ndarray
    patch_points: np.ndarray
    type_size: np.ndarray
    type_levels: np.ndarray
    type_offset: np.ndarray
    type_strips: np.ndarray
    matrices: np.ndarray
    strip_parts: np.ndarray
    strip_sides: np.ndarray
    strip_products: np.ndarray
    strip_at_once: int
    strip_matrices: np.ndarray
    strip_levels: int
    quad_degree: int
    positions: np.ndarray


@inlined_kernel
def turned(shape, corner, x, y, xu, xv, yu, yv):  # type: ignore[no-untyped-def]
    """Parameters x, y of a cell, and their derivatives, seen with `corner` as the first."""
    if corner == 0:
        return x, y, xu, xv, yu, yv
    if shape == QUAD:
        if corner == 1:
            return y, 1 - x, yu, yv, -xu, -xv
        if corner == 2:
            return 1 - x, 1 - y, -xu, -xv, -yu, -yv
        return 1 - y, x, -yu, -yv, xu, xv
    if corner == 1:
        return y, 1 - x - y, yu, yv, -xu - yu, -xv - yv
    return 1 - x - y, x, -xu - yu, -xv - yv, xu, xv


@inlined_kernel
def part(shape, x, y):  # type: ignore[no-untyped-def]
    """Which of the four parts of a cell that is cut holds (x, y), and its parameters there, as factor x + shift.

    Returns
    -------
    index : the corner at which the part lies, or 3 for a triangle's middle.
    factor, shift_x, shift_y.
    """
    if shape == QUAD:
        if y < 0.5:
            return (0, 2.0, 0.0, 0.0) if x < 0.5 else (1, 2.0, -1.0, 0.0)
        return (3, 2.0, 0.0, -1.0) if x < 0.5 else (2, 2.0, -1.0, -1.0)
    if x + y <= 0.5:
        return 0, 2.0, 0.0, 0.0
    if x >= 0.5:
        return 1, 2.0, -1.0, 0.0
    if y >= 0.5:
        return 2, 2.0, 0.0, -1.0
    return 3, -2.0, 1.0, 1.0


@inlined_kernel
def locate(patches, cell, u, v):  # type: ignore[no-untyped-def]
    """Find the polynomial or the strip under (u, v) of a cell.

    Returns
    -------
    patch : row of the patch.
    block : which matrix of its type.
    strip : the strip that this leads to, -1 for a polynomial.
    x, y : the polynomial's (or strip's) own parameters.
    xu, xv, yu, yv : derivatives of x, y by u, v. At an irregular corner itself, where the scheme's own derivatives
        vanish or diverge, the polynomial holds limit tangents instead, scaled as at a regular corner.
    """
    shape = patches.cell_shape[cell]
    patch = patches.cell_node[cell]
    x, y, scale = u, v, 1.0
    while patch < 0:
        i, factor, shift_x, shift_y = part(shape, x, y)
        x, y, scale = factor * x + shift_x, factor * y + shift_y, factor * scale
        patch = patches.node_children[~patch, i]
    x, y, xu, xv, yu, yv = turned(shape, patches.patch_corner[patch], x, y, scale, 0.0, 0.0, scale)
    kind = patches.patch_type[patch]
    levels = patches.type_levels[kind]
    if levels == 0:
        return patch, 0, patches.type_strips[kind, 0], x, y, xu, xv, yu, yv
    reach = max(x, y) if shape == QUAD else x + y
    # Most points are a level or two from the corner's far side: doubling is faster than to take the exponent.
    level, finer = 1, 2.0
    while reach < 0.5 and level <= levels:
        reach, level, finer = 2 * reach, level + 1, 2 * finer
    if level > levels:
        return patch, 3 * levels, -1, 0.0, 0.0, xu, xv, yu, yv
    x, y = x * finer, y * finer
    sub = 0
    if shape == QUAD:
        if x >= 1.0 and y >= 1.0:
            sub, x, y = 2, x - 1, y - 1
        elif x >= 1.0:
            x -= 1
        else:
            sub, y = 1, y - 1
    elif x >= 1.0:
        x -= 1
    elif y >= 1.0:
        sub, y = 1, y - 1
    else:
        sub, x, y, finer = 2, 1 - x, 1 - y, -finer
    block, strip = 3 * (level - 1) + sub, patches.type_strips[kind, sub]
    return patch, block, strip, x, y, xu * finer, xv * finer, yu * finer, yv * finer
