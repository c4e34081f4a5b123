"""From strips, beside lines along which a surface is no polynomial, to the polynomials under their parameters."""

import math

import numpy as np

from subdfit.compiled import inlined_kernel, inner_kernel
from subdfit.limit._gather_kernels import KEPT, coefficients
from subdfit.limit._locate_kernels import QUAD, part

PATHS = 128
"""Paths of three steps into a strip, as numbers in base four after a leading one."""
SLOTS = KEPT + PATHS
"""Those kept, and those at the ends of paths into a strip; the first two of these serve all longer paths by turns."""

ROW = tuple(np.uint64(16 * k) for k in range(16))
"""Where the rows of a matrix begin."""


@inlined_kernel
def corner(shape, i):  # type: ignore[no-untyped-def]
    """Parameters of a cell's corner."""
    if shape == QUAD:
        return 1.0 * (i == 1 or i == 2), 1.0 * (i >= 2)
    return 1.0 * (i == 1), 1.0 * (i == 2)


@inlined_kernel
def along_seam(shape, side, x, y, levels, pieces):  # type: ignore[no-untyped-def]
    """Which piece of a cell's side (x, y) lies on, and its parameters there; -1 if steps of so many levels lead off."""
    x0, y0 = corner(shape, side)
    x1, y1 = corner(shape, (side + 1) % shape)
    across_x, across_y = x1 - x0, y1 - y0
    off = across_x * (y - y0) - across_y * (x - x0)
    if math.ldexp(off, levels) >= 1.0:
        return -1, x, y
    ahead = (across_x * (x - x0) + across_y * (y - y0)) / (across_x * across_x + across_y * across_y)
    n = min(max(int(pieces * ahead), 0), pieces - 1)
    left = pieces - 1 - n
    return n, pieces * x - left * x0 - n * x1, pieces * y - left * y0 - n * y1


@inlined_kernel
def next_step(patches, shape, strip, levels, x, y):  # type: ignore[no-untyped-def]
    """The next step towards the polynomial under (x, y) of a strip that may be refined by so many levels.

    Returns
    -------
    matrix : the number of the matrix that takes it.
    strip : where it leads, -1 for a polynomial; levels : those that are left there.
    x, y : the parameters there; scale : their derivatives by those before.
    """
    if levels == 0:
        return 5 * strip + 4, -1, 0, x, y, 1.0
    side, at_once = patches.strip_sides[strip], patches.strip_at_once
    if side >= 0 and levels >= at_once:
        pieces = 1 << at_once
        n, along_x, along_y = along_seam(shape, side, x, y, levels, pieces)
        if n >= 0:
            return patches.strip_products[strip] + n, strip, levels - at_once, along_x, along_y, 1.0 * pieces
    i, factor, shift_x, shift_y = part(shape, x, y)
    x, y = factor * x + shift_x, factor * y + shift_y
    return 5 * strip + i, patches.strip_parts[strip, i], levels - 1, x, y, factor


@inner_kernel
def take_step(matrices, matrix, cache, c, to):  # type: ignore[no-untyped-def]
    """Write what a matrix makes of the numbers at ``cache[c:]`` into ``cache[to:]``."""
    # Of unsigned numbers the compiler knows that they do not count from the end, and only then does it vectorise.
    begin, rows, m = np.uint64(256 * matrix), np.uint64(16), matrices
    for a in range(c, c + 48, 16):
        b = np.uint64(to + a - c)
        x0, x1, x2, x3 = cache[a], cache[a + 1], cache[a + 2], cache[a + 3]
        x4, x5, x6, x7 = cache[a + 4], cache[a + 5], cache[a + 6], cache[a + 7]
        x8, x9, x10, x11 = cache[a + 8], cache[a + 9], cache[a + 10], cache[a + 11]
        x12, x13, x14, x15 = cache[a + 12], cache[a + 13], cache[a + 14], cache[a + 15]
        for r in range(rows):
            k = begin + r
            total = m[k + ROW[0]] * x0 + m[k + ROW[1]] * x1 + m[k + ROW[2]] * x2 + m[k + ROW[3]] * x3
            total += m[k + ROW[4]] * x4 + m[k + ROW[5]] * x5 + m[k + ROW[6]] * x6 + m[k + ROW[7]] * x7
            total += m[k + ROW[8]] * x8 + m[k + ROW[9]] * x9 + m[k + ROW[10]] * x10 + m[k + ROW[11]] * x11
            total += m[k + ROW[12]] * x12 + m[k + ROW[13]] * x13 + m[k + ROW[14]] * x14 + m[k + ROW[15]] * x15
            cache[b + r] = total


@inner_kernel
def into_strip(patches, shape, strip, x, y, cache, tags, c, tag):  # type: ignore[no-untyped-def]
    """Go from a strip, whose numbers are at ``cache[c:]``, to the polynomial under its (x, y).

    Returns
    -------
    c : where the coefficients lie.
    x, y : the polynomial's own parameters; scale : their derivatives by the strip's.
    """
    matrices, levels = patches.strip_matrices, patches.strip_levels
    scale, path = 1.0, 1
    to, other = KEPT, KEPT + 1
    while strip >= 0:
        before, first = strip, levels
        matrix, strip, levels, x, y, factor = next_step(patches, shape, strip, levels, x, y)
        scale *= factor
        single = first - levels == 1
        path = min(4 * path + matrix - 5 * before, PATHS) if single else PATHS
        if path == PATHS:
            take_step(matrices, matrix, cache, c, 48 * to)
            c, to, other = 48 * to, other, to
        else:
            if tags[KEPT + path] != tag:
                take_step(matrices, matrix, cache, c, 48 * (KEPT + path))
                tags[KEPT + path] = tag
            c = 48 * (KEPT + path)
    return c, x, y, scale


@inlined_kernel
def polynomial(patches, shape, patch, block, strip, x, y, cache, tags):  # type: ignore[no-untyped-def]
    """The polynomial that `locate` found, at the end of the strip if there is one; returns as `into_strip` does."""
    c = coefficients(patches, patch, block, cache, tags)
    if strip < 0:
        return c, x, y, 1.0
    return into_strip(patches, shape, strip, x, y, cache, tags, c, np.int64(patch) << 16 | block)


@inner_kernel
def way_into_strip(patches, shape, strip, x, y, way):  # type: ignore[no-untyped-def]
    """Write the matrices of `into_strip` into `way`; returns their number, x, y and scale."""
    scale, steps, levels = 1.0, 0, patches.strip_levels
    while strip >= 0:
        way[steps], strip, levels, x, y, factor = next_step(patches, shape, strip, levels, x, y)
        scale *= factor
        steps += 1
    return steps, x, y, scale


@inner_kernel
def back_from_strip(matrices, way, steps, row):  # type: ignore[no-untyped-def]
    """Turn a row over the coefficients at the end of `way` into one over the numbers at its beginning."""
    before = np.empty(16)
    for step in range(steps - 1, -1, -1):
        for k in range(16):
            begin, total = 256 * way[step] + 16 * k, 0.0
            for r in range(16):
                total += matrices[begin + r] * row[r]
            before[k] = total
        for k in range(16):
            row[k] = before[k]
