"""Coefficients of polynomials from the points of patches, kept while the next points lie in the same ones."""

import numpy as np

from subdfit.compiled import inlined_kernel, kernel

KEPT = 10
"""Coefficient sets kept while the cell does not change: the sub-patches of three levels, and one for all deeper."""


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
def coefficients(patches, patch, block, cache, tags):  # type: ignore[no-untyped-def]
    """Return where in `cache` (48 SLOTS,) the polynomial's coefficients lie, gathered only if not there yet."""
    slot = min(block, KEPT - 1)
    tag = np.int64(patch) << 16 | block
    if tags[slot] != tag:
        gather(patches, patch, block, cache, 48 * slot)
        tags[slot] = tag
    return 48 * slot
