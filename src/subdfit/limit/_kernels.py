"""Surface points and their derivatives, and the order in which they are evaluated."""

import numpy as np

from subdfit.compiled import inlined_kernel, kernel
from subdfit.limit._locate_kernels import QUAD, locate
from subdfit.limit._polynomial_kernels import first_order, second_order
from subdfit.limit._strip_kernels import SLOTS, polynomial

NEAR_LEVEL = 30
"""Level of refinement at which a point counts as very near an irregular corner."""


@kernel
def evaluate(patches, cell, uv, order, start, stop, derivatives, position, first, second):  # type: ignore[no-untyped-def]
    """Evaluate points ``order[start:stop]``; results go to their own rows.

    `position` (k, 3), `first` (k, 2, 3), `second` (k, 3, 3) by uu, uv, vv; those beyond `derivatives` are not touched.
    """
    cache = np.empty(48 * SLOTS)
    tags = np.full(SLOTS, -1, np.int64)
    degree = patches.quad_degree
    for n in range(start, stop):
        k = order[n]
        shape = patches.cell_shape[cell[k]]
        patch, block, strip, x, y, xu, xv, yu, yv = locate(patches, cell[k], uv[k, 0], uv[k, 1])
        c, x, y, scale = polynomial(patches, shape, patch, block, strip, x, y, cache, tags)
        xu, xv, yu, yv = scale * xu, scale * xv, scale * yu, scale * yv
        if derivatives == 0:
            for d in range(3):
                position[k, d] = first_order(shape, degree, cache, c + 16 * d, x, y)[0]
            continue
        for d in range(3):
            value, by_x, by_y = first_order(shape, degree, cache, c + 16 * d, x, y)
            position[k, d] = value
            first[k, 0, d] = xu * by_x + yu * by_y
            first[k, 1, d] = xv * by_x + yv * by_y
        if derivatives == 2:
            for d in range(3):
                by_xx, by_xy, by_yy = second_order(shape, cache, c + 16 * d, x, y)
                second[k, 0, d] = xu * xu * by_xx + 2 * xu * yu * by_xy + yu * yu * by_yy
                second[k, 1, d] = xu * xv * by_xx + (xu * yv + xv * yu) * by_xy + yu * yv * by_yy
                second[k, 2, d] = xv * xv * by_xx + 2 * xv * yv * by_xy + yv * yv * by_yy


@inlined_kernel
def derivatives(patches, shape, patch, block, strip, x, y, xu, xv, yu, yv, out, cache, tags):  # type: ignore[no-untyped-def]
    """Write S, Su, Sv, Suu, Suv, Svv of what `locate` found into `out` (18,), three coordinates each."""
    c, x, y, scale = polynomial(patches, shape, patch, block, strip, x, y, cache, tags)
    xu, xv, yu, yv = scale * xu, scale * xv, scale * yu, scale * yv
    degree = patches.quad_degree
    for d in range(3):
        value, by_x, by_y = first_order(shape, degree, cache, c + 16 * d, x, y)
        by_xx, by_xy, by_yy = second_order(shape, cache, c + 16 * d, x, y)
        out[d] = value
        out[3 + d] = xu * by_x + yu * by_y
        out[6 + d] = xv * by_x + yv * by_y
        out[9 + d] = xu * xu * by_xx + 2 * xu * yu * by_xy + yu * yu * by_yy
        out[12 + d] = xu * xv * by_xx + (xu * yv + xv * yu) * by_xy + yu * yv * by_yy
        out[15 + d] = xv * xv * by_xx + 2 * xv * yv * by_xy + yv * yv * by_yy


@inlined_kernel
def expand(patches, cell, u, v, out, cache, tags):  # type: ignore[no-untyped-def]
    """Write S and its first and second derivatives at (u, v) into `out` (18,), three coordinates each.

    At an irregular corner the first derivatives are those of a point very near, whose directions are true, scaled to
    the length of the limit tangents, and the second are zero.
    """
    shape = patches.cell_shape[cell]
    patch, block, strip, x, y, xu, xv, yu, yv = locate(patches, cell, u, v)
    kind = patches.patch_type[patch]
    levels = patches.type_levels[kind]
    px = py = pz = wanted = found = 0.0
    for near in range(2):
        derivatives(patches, shape, patch, block, strip, x, y, xu, xv, yu, yv, out, cache, tags)
        if levels == 0 or (block < 3 * levels and not near):
            return
        wanted, found = found, 0.0
        for i in range(3, 9):
            found += out[i] * out[i]
        if near:
            break
        px, py, pz = out[0], out[1], out[2]
        # The sub-patch between of a deep level, at its middle; a triangle's is turned by half.
        block, strip, x, y = 3 * NEAR_LEVEL - 1, np.int64(patches.type_strips[kind, 2]), 0.5, 0.5
        if shape != QUAD:
            xu, xv, yu, yv = -xu, -xv, -yu, -yv
    scale = np.sqrt(wanted / found) if found > 0 else 0.0
    out[0], out[1], out[2] = px, py, pz
    for i in range(3, 9):
        out[i] *= scale
    for i in range(9, 18):
        out[i] = 0.0


@kernel
def first_outside(cell, uv, shape, slack):  # type: ignore[no-untyped-def]
    """First point whose cell does not exist or whose (u, v) lies outside it by more than `slack`; else -1."""
    for k in range(len(cell)):
        if not 0 <= cell[k] < len(shape):
            return k
        u, v = uv[k, 0], uv[k, 1]
        reach = max(u, v) if shape[cell[k]] == QUAD else u + v
        if not (u >= -slack and v >= -slack and reach <= 1 + slack):
            return k
    return -1


@kernel
def order_by_cell(cell, cells):  # type: ignore[no-untyped-def]
    """Stable order of points by cell, by counting."""
    start = np.zeros(cells + 1, np.int64)
    for k in range(len(cell)):
        start[cell[k] + 1] += 1
    for c in range(cells):
        start[c + 1] += start[c]
    order = np.empty(len(cell), np.int64)
    for k in range(len(cell)):
        order[start[cell[k]]] = k
        start[cell[k]] += 1
    return order
