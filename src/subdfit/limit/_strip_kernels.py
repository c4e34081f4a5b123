"""From strips, beside lines along which a surface is no polynomial, to the polynomials under their parameters."""

import numpy as np

from subdfit.compiled import inlined_kernel, kernel
from subdfit.limit._gather_kernels import KEPT, coefficients
from subdfit.limit._locate_kernels import part

PATHS = 128
"""Paths of three steps into a strip, as numbers in base four after a leading one."""
SLOTS = KEPT + PATHS
"""Those kept, and those at the ends of paths into a strip; the first two of these serve all longer paths by turns."""


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
