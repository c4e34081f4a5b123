"""Polynomial patches: find the one under a parameter, gather its coefficients, evaluate them."""

import math
from typing import NamedTuple

import numpy as np

from subdfit.compiled import inlined_kernel, kernel

TRIANGLE, QUAD = 3, 4
"""Shapes of cells, as in `subdfit.schemes.domain`."""

KEPT = 10
"""Coefficient sets kept while the cell does not change: the sub-patches of three levels, and one for all deeper."""
PATHS = 128
"""Paths of three steps into a strip, as numbers in base four after a leading one."""
SLOTS = KEPT + PATHS
"""Those kept, and those at the ends of paths into a strip; the first two of these serve all longer paths by turns."""

NEAR_LEVEL = 30
"""Level of refinement at which a point counts as very near an irregular corner."""


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
    strip_matrices: np.ndarray
    strip_levels: int
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
    level = levels + 1
    if reach > 0.0:
        level = max(1, 1 - math.frexp(reach)[1])
    if level > levels:
        return patch, 3 * levels, -1, 0.0, 0.0, xu, xv, yu, yv
    finer = math.ldexp(1.0, level)
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


@kernel
def gather(patches, patch, block, out, to):  # type: ignore[no-untyped-def]
    """Write a polynomial's coefficients, 16 for each coordinate, into ``out[to:to + 48]``."""
    kind = patches.patch_type[patch]
    size = patches.type_size[kind]
    begin = patches.type_offset[kind] + 16 * block * size
    first = patches.patch_offset[patch]
    # Taken out of the tuple once: numba counts a reference each time a field is read.
    points, positions, matrices = patches.patch_points, patches.positions, patches.matrices
    # Four rows at a time: twelve sums stay in registers.
    for row in range(to, to + 16, 4):
        x0 = x1 = x2 = x3 = 0.0
        y0 = y1 = y2 = y3 = 0.0
        z0 = z1 = z2 = z3 = 0.0
        at = begin + row - to
        for k in range(size):
            q = points[first + k]
            x, y, z = positions[q, 0], positions[q, 1], positions[q, 2]
            m0, m1, m2, m3 = matrices[at], matrices[at + 1], matrices[at + 2], matrices[at + 3]
            x0, x1, x2, x3 = x0 + m0 * x, x1 + m1 * x, x2 + m2 * x, x3 + m3 * x
            y0, y1, y2, y3 = y0 + m0 * y, y1 + m1 * y, y2 + m2 * y, y3 + m3 * y
            z0, z1, z2, z3 = z0 + m0 * z, z1 + m1 * z, z2 + m2 * z, z3 + m3 * z
            at += 16
        out[row], out[row + 1], out[row + 2], out[row + 3] = x0, x1, x2, x3
        out[row + 16], out[row + 17], out[row + 18], out[row + 19] = y0, y1, y2, y3
        out[row + 32], out[row + 33], out[row + 34], out[row + 35] = z0, z1, z2, z3


@inlined_kernel
def quartic(c, o, x, y):  # type: ignore[no-untyped-def]
    """Value and first derivatives of a quartic with coefficients ``c[o:o + 15]`` of x^i y^j, i then j."""
    p0 = c[o] + y * (c[o + 1] + y * (c[o + 2] + y * (c[o + 3] + y * c[o + 4])))
    p1 = c[o + 5] + y * (c[o + 6] + y * (c[o + 7] + y * c[o + 8]))
    p2 = c[o + 9] + y * (c[o + 10] + y * c[o + 11])
    p3 = c[o + 12] + y * c[o + 13]
    q0 = c[o + 1] + y * (2 * c[o + 2] + y * (3 * c[o + 3] + y * (4 * c[o + 4])))
    q1 = c[o + 6] + y * (2 * c[o + 7] + y * (3 * c[o + 8]))
    q2 = c[o + 10] + y * (2 * c[o + 11])
    value = p0 + x * (p1 + x * (p2 + x * (p3 + x * c[o + 14])))
    by_x = p1 + x * (2 * p2 + x * (3 * p3 + x * (4 * c[o + 14])))
    by_y = q0 + x * (q1 + x * (q2 + x * c[o + 13]))
    return value, by_x, by_y


@inlined_kernel
def bicubic(c, o, x, y):  # type: ignore[no-untyped-def]
    """Value and first derivatives of a bicubic with coefficients ``c[o:o + 16]`` of x^i y^j, i then j."""
    p0 = c[o] + y * (c[o + 1] + y * (c[o + 2] + y * c[o + 3]))
    p1 = c[o + 4] + y * (c[o + 5] + y * (c[o + 6] + y * c[o + 7]))
    p2 = c[o + 8] + y * (c[o + 9] + y * (c[o + 10] + y * c[o + 11]))
    p3 = c[o + 12] + y * (c[o + 13] + y * (c[o + 14] + y * c[o + 15]))
    q0 = c[o + 1] + y * (2 * c[o + 2] + y * (3 * c[o + 3]))
    q1 = c[o + 5] + y * (2 * c[o + 6] + y * (3 * c[o + 7]))
    q2 = c[o + 9] + y * (2 * c[o + 10] + y * (3 * c[o + 11]))
    q3 = c[o + 13] + y * (2 * c[o + 14] + y * (3 * c[o + 15]))
    value = p0 + x * (p1 + x * (p2 + x * p3))
    by_x = p1 + x * (2 * p2 + x * (3 * p3))
    by_y = q0 + x * (q1 + x * (q2 + x * q3))
    return value, by_x, by_y


@inlined_kernel
def first_order(shape, c, o, x, y):  # type: ignore[no-untyped-def]
    """Value and first derivatives of a cell's polynomial."""
    if shape == QUAD:
        return bicubic(c, o, x, y)
    return quartic(c, o, x, y)


@inlined_kernel
def second_order(shape, c, o, x, y):  # type: ignore[no-untyped-def]
    """Second derivatives by xx, xy, yy of the polynomial of `first_order`."""
    if shape == QUAD:
        p2 = c[o + 8] + y * (c[o + 9] + y * (c[o + 10] + y * c[o + 11]))
        p3 = c[o + 12] + y * (c[o + 13] + y * (c[o + 14] + y * c[o + 15]))
        q1 = c[o + 5] + y * (2 * c[o + 6] + y * (3 * c[o + 7]))
        q2 = c[o + 9] + y * (2 * c[o + 10] + y * (3 * c[o + 11]))
        q3 = c[o + 13] + y * (2 * c[o + 14] + y * (3 * c[o + 15]))
        r0 = 2 * c[o + 2] + y * (6 * c[o + 3])
        r1 = 2 * c[o + 6] + y * (6 * c[o + 7])
        r2 = 2 * c[o + 10] + y * (6 * c[o + 11])
        r3 = 2 * c[o + 14] + y * (6 * c[o + 15])
        return 2 * p2 + x * (6 * p3), q1 + x * (2 * q2 + x * (3 * q3)), r0 + x * (r1 + x * (r2 + x * r3))
    p2 = c[o + 9] + y * (c[o + 10] + y * c[o + 11])
    p3 = c[o + 12] + y * c[o + 13]
    q1 = c[o + 6] + y * (2 * c[o + 7] + y * (3 * c[o + 8]))
    q2 = c[o + 10] + y * (2 * c[o + 11])
    r0 = 2 * c[o + 2] + y * (6 * c[o + 3] + y * (12 * c[o + 4]))
    r1 = 2 * c[o + 7] + y * (6 * c[o + 8])
    by_xx = 2 * p2 + x * (6 * p3 + x * (12 * c[o + 14]))
    by_xy = q1 + x * (2 * q2 + x * (3 * c[o + 13]))
    by_yy = r0 + x * (r1 + x * (2 * c[o + 11]))
    return by_xx, by_xy, by_yy


@inlined_kernel
def coefficients(patches, patch, block, cache, tags):  # type: ignore[no-untyped-def]
    """Return where in `cache` (48 SLOTS,) the polynomial's coefficients lie, gathered only if not there yet."""
    slot = min(block, KEPT - 1)
    tag = np.int64(patch) << 16 | block
    if tags[slot] != tag:
        gather(patches, patch, block, cache, 48 * slot)
        tags[slot] = tag
    return 48 * slot


@kernel
def strip_step(matrices, strip, i, cache, c, to):  # type: ignore[no-untyped-def]
    """Write the numbers of part `i` of a strip, or of the polynomial that stands for it (4), into ``cache[to:]``."""
    for row in range(0, 16, 4):
        x0 = x1 = x2 = x3 = 0.0
        y0 = y1 = y2 = y3 = 0.0
        z0 = z1 = z2 = z3 = 0.0
        for k in range(16):
            x, y, z = cache[c + k], cache[c + 16 + k], cache[c + 32 + k]
            m0, m1 = matrices[strip, i, k, row], matrices[strip, i, k, row + 1]
            m2, m3 = matrices[strip, i, k, row + 2], matrices[strip, i, k, row + 3]
            x0, x1, x2, x3 = x0 + m0 * x, x1 + m1 * x, x2 + m2 * x, x3 + m3 * x
            y0, y1, y2, y3 = y0 + m0 * y, y1 + m1 * y, y2 + m2 * y, y3 + m3 * y
            z0, z1, z2, z3 = z0 + m0 * z, z1 + m1 * z, z2 + m2 * z, z3 + m3 * z
        at = to + row
        cache[at], cache[at + 1], cache[at + 2], cache[at + 3] = x0, x1, x2, x3
        cache[at + 16], cache[at + 17], cache[at + 18], cache[at + 19] = y0, y1, y2, y3
        cache[at + 32], cache[at + 33], cache[at + 34], cache[at + 35] = z0, z1, z2, z3


@kernel
def into_strip(patches, shape, strip, x, y, cache, tags, c, tag):  # type: ignore[no-untyped-def]
    """Go from a strip, whose numbers are at ``cache[c:]``, to the polynomial under its (x, y).

    Returns
    -------
    c : where the coefficients lie.
    x, y : the polynomial's own parameters; scale : their derivatives by the strip's.
    """
    parts, matrices = patches.strip_parts, patches.strip_matrices
    scale, path = 1.0, 1
    to, other = KEPT, KEPT + 1
    for _ in range(patches.strip_levels):
        i, factor, shift_x, shift_y = part(shape, x, y)
        x, y, scale = factor * x + shift_x, factor * y + shift_y, factor * scale
        path = min(4 * path + i, PATHS)
        if path == PATHS:
            strip_step(matrices, strip, i, cache, c, 48 * to)
            c, to, other = 48 * to, other, to
        else:
            if tags[KEPT + path] != tag:
                strip_step(matrices, strip, i, cache, c, 48 * (KEPT + path))
                tags[KEPT + path] = tag
            c = 48 * (KEPT + path)
        strip = parts[strip, i]
        if strip < 0:
            return c, x, y, scale
    strip_step(matrices, strip, 4, cache, c, 48 * to)
    return 48 * to, x, y, scale


@inlined_kernel
def polynomial(patches, shape, patch, block, strip, x, y, cache, tags):  # type: ignore[no-untyped-def]
    """The polynomial that `locate` found, at the end of the strip if there is one; returns as `into_strip` does."""
    c = coefficients(patches, patch, block, cache, tags)
    if strip < 0:
        return c, x, y, 1.0
    return into_strip(patches, shape, strip, x, y, cache, tags, c, np.int64(patch) << 16 | block)


@kernel
def evaluate(patches, cell, uv, order, start, stop, derivatives, position, first, second):  # type: ignore[no-untyped-def]
    """Evaluate points ``order[start:stop]``; results go to their own rows.

    `position` (k, 3), `first` (k, 2, 3), `second` (k, 3, 3) by uu, uv, vv; those beyond `derivatives` are not touched.
    """
    cache = np.empty(48 * SLOTS)
    tags = np.full(SLOTS, -1, np.int64)
    for n in range(start, stop):
        k = order[n]
        shape = patches.cell_shape[cell[k]]
        patch, block, strip, x, y, xu, xv, yu, yv = locate(patches, cell[k], uv[k, 0], uv[k, 1])
        c, x, y, scale = polynomial(patches, shape, patch, block, strip, x, y, cache, tags)
        xu, xv, yu, yv = scale * xu, scale * xv, scale * yu, scale * yv
        if derivatives == 0:
            for d in range(3):
                position[k, d] = first_order(shape, cache, c + 16 * d, x, y)[0]
            continue
        for d in range(3):
            value, by_x, by_y = first_order(shape, cache, c + 16 * d, x, y)
            position[k, d] = value
            first[k, 0, d] = xu * by_x + yu * by_y
            first[k, 1, d] = xv * by_x + yv * by_y
        if derivatives == 2:
            for d in range(3):
                by_xx, by_xy, by_yy = second_order(shape, cache, c + 16 * d, x, y)
                second[k, 0, d] = xu * xu * by_xx + 2 * xu * yu * by_xy + yu * yu * by_yy
                second[k, 1, d] = xu * xv * by_xx + (xu * yv + xv * yu) * by_xy + yu * yv * by_yy
                second[k, 2, d] = xv * xv * by_xx + 2 * xv * yv * by_xy + yv * yv * by_yy


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


@kernel
def row_sizes(patches, cell, uv):  # type: ignore[no-untyped-def]
    """Row offsets of the sparse weights: how many patch points each point depends on, summed."""
    offsets = np.zeros(len(cell) + 1, np.int64)
    for k in range(len(cell)):
        patch = locate(patches, cell[k], uv[k, 0], uv[k, 1])[0]
        offsets[k + 1] = offsets[k] + patches.type_size[patches.patch_type[patch]]
    return offsets


@kernel
def way_into_strip(patches, shape, strip, x, y, way):  # type: ignore[no-untyped-def]
    """Write the steps of `into_strip` into `way`, each as 5 strip + part; returns their number, x, y and scale."""
    scale = 1.0
    steps = 0
    while strip >= 0:
        if steps == patches.strip_levels:
            way[steps] = 5 * strip + 4
            return steps + 1, x, y, scale
        i, factor, shift_x, shift_y = part(shape, x, y)
        x, y, scale = factor * x + shift_x, factor * y + shift_y, factor * scale
        way[steps] = 5 * strip + i
        steps += 1
        strip = patches.strip_parts[strip, i]
    return steps, x, y, scale


@kernel
def back_from_strip(matrices, way, steps, row):  # type: ignore[no-untyped-def]
    """Turn a row over the coefficients at the end of `way` into one over the numbers at its beginning."""
    before = np.empty(16)
    for step in range(steps - 1, -1, -1):
        strip, i = way[step] // 5, way[step] % 5
        for k in range(16):
            total = 0.0
            for r in range(16):
                total += matrices[strip, i, k, r] * row[r]
            before[k] = total
        row[:] = before


@kernel
def weights(patches, cell, uv, offsets, start, stop, derivative, columns, values):  # type: ignore[no-untyped-def]
    """Write the sparse rows of points ``start`` to ``stop``: weights of patch points.

    `derivative` is 0 for the position, 1 and 2 for the derivative by u and v, 3 to 5 for those by uu, uv and vv.
    """
    powers_x = np.ones(5)
    powers_y = np.ones(5)
    monomial = np.zeros(16)
    way = np.empty(patches.strip_levels + 1, np.int64)
    matrices, points = patches.matrices, patches.patch_points
    for k in range(start, stop):
        shape = patches.cell_shape[cell[k]]
        quad = shape == QUAD
        patch, block, strip, x, y, xu, xv, yu, yv = locate(patches, cell[k], uv[k, 0], uv[k, 1])
        steps, x, y, scale = way_into_strip(patches, shape, strip, x, y, way)
        xu, xv, yu, yv = scale * xu, scale * xv, scale * yu, scale * yv
        for i in range(1, 5):
            powers_x[i] = powers_x[i - 1] * x
            powers_y[i] = powers_y[i - 1] * y
        at = 0
        for i in range(4 if quad else 5):
            for j in range(4 if quad else 5 - i):
                by_x = i * powers_x[max(i - 1, 0)] * powers_y[j]
                by_y = j * powers_x[i] * powers_y[max(j - 1, 0)]
                if derivative == 0:
                    monomial[at] = powers_x[i] * powers_y[j]
                elif derivative == 1:
                    monomial[at] = xu * by_x + yu * by_y
                elif derivative == 2:
                    monomial[at] = xv * by_x + yv * by_y
                else:
                    by_xx = i * (i - 1) * powers_x[max(i - 2, 0)] * powers_y[j]
                    by_xy = i * j * powers_x[max(i - 1, 0)] * powers_y[max(j - 1, 0)]
                    by_yy = j * (j - 1) * powers_x[i] * powers_y[max(j - 2, 0)]
                    xa, ya = (xv, yv) if derivative == 5 else (xu, yu)
                    xb, yb = (xu, yu) if derivative == 3 else (xv, yv)
                    monomial[at] = xa * xb * by_xx + (xa * yb + ya * xb) * by_xy + ya * yb * by_yy
                at += 1
        if at == 15:
            monomial[15] = 0.0
        back_from_strip(patches.strip_matrices, way, steps, monomial)
        kind = patches.patch_type[patch]
        size = patches.type_size[kind]
        begin = patches.type_offset[kind] + 16 * block * size
        for p in range(size):
            total = 0.0
            for r in range(16):
                total += matrices[begin + 16 * p + r] * monomial[r]
            columns[offsets[k] + p] = points[patches.patch_offset[patch] + p]
            values[offsets[k] + p] = total


@inlined_kernel
def derivatives(patches, shape, patch, block, strip, x, y, xu, xv, yu, yv, out, cache, tags):  # type: ignore[no-untyped-def]
    """Write S, Su, Sv, Suu, Suv, Svv of what `locate` found into `out` (18,), three coordinates each."""
    c, x, y, scale = polynomial(patches, shape, patch, block, strip, x, y, cache, tags)
    xu, xv, yu, yv = scale * xu, scale * xv, scale * yu, scale * yv
    for d in range(3):
        value, by_x, by_y = first_order(shape, cache, c + 16 * d, x, y)
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
    derivatives(patches, shape, patch, block, strip, x, y, xu, xv, yu, yv, out, cache, tags)
    levels = patches.type_levels[patches.patch_type[patch]]
    if levels == 0 or block != 3 * levels:
        return
    px, py, pz = out[0], out[1], out[2]
    wanted = found = 0.0
    for i in range(3, 9):
        wanted += out[i] * out[i]
    # The sub-patch between of a deep level, at its middle; a triangle's is turned by half.
    turn = 1.0 if shape == QUAD else -1.0
    derivatives(
        patches,
        shape,
        patch,
        3 * NEAR_LEVEL - 1,
        patches.type_strips[patches.patch_type[patch], 2],
        0.5,
        0.5,
        turn * xu,
        turn * xv,
        turn * yu,
        turn * yv,
        out,
        cache,
        tags,
    )
    for i in range(3, 9):
        found += out[i] * out[i]
    scale = np.sqrt(wanted / found) if found > 0 else 0.0
    out[0], out[1], out[2] = px, py, pz
    for i in range(3, 9):
        out[i] *= scale
    for i in range(9, 18):
        out[i] = 0.0
