"""Coefficients of polynomials from the points of patches, kept while the next points lie in the same ones."""

import numpy as np

from subdfit.compiled import inlined_kernel, inner_kernel

OF_PATCH, PATCHES = 10, 4
"""Coefficient sets kept of one patch, the sub-patches of three levels and one for all deeper; and of how many patches:
those of a cell that is cut, which are numbered in sequence."""
KEPT = OF_PATCH * PATCHES


@inlined_kernel
def listed(points, positions, at, end):  # type: ignore[no-untyped-def]
    """A point in the list of patches' points, or zero for entries from `end` on."""
    if at >= end:
        return 0.0, 0.0, 0.0
    q = points[at]
    return positions[q, 0], positions[q, 1], positions[q, 2]


@inner_kernel
def gather(patches, patch, block, out, to):  # type: ignore[no-untyped-def]
    """Write a polynomial's coefficients, 16 for each coordinate, into ``out[to:to + 48]``."""
    kind = patches.patch_type[patch]
    size = patches.type_size[kind]
    begin = patches.type_offset[kind] + 16 * block * size
    first, end = patches.patch_offset[patch], patches.patch_offset[patch] + size
    last = begin + 16 * (size - 1)
    # Taken out of the tuple once: numba counts a reference each time a field is read.
    points, positions, m = patches.patch_points, patches.positions, patches.matrices
    # Of unsigned numbers the compiler knows that they do not count from the end, and only then does it vectorise.
    x, y, z, rows = np.uint64(to), np.uint64(to + 16), np.uint64(to + 32), np.uint64(16)
    for r in range(np.uint64(48)):
        out[x + r] = 0.0
    for k in range(0, size, 4):
        x0, y0, z0 = listed(points, positions, first + k, end)
        x1, y1, z1 = listed(points, positions, first + k + 1, end)
        x2, y2, z2 = listed(points, positions, first + k + 2, end)
        x3, y3, z3 = listed(points, positions, first + k + 3, end)
        at = begin + 16 * k
        a, b = np.uint64(at), np.uint64(min(at + 16, last))
        c, d = np.uint64(min(at + 32, last)), np.uint64(min(at + 48, last))
        for r in range(rows):
            m0, m1, m2, m3 = m[a + r], m[b + r], m[c + r], m[d + r]
            out[x + r] += m0 * x0 + m1 * x1 + m2 * x2 + m3 * x3
            out[y + r] += m0 * y0 + m1 * y1 + m2 * y2 + m3 * y3
            out[z + r] += m0 * z0 + m1 * z1 + m2 * z2 + m3 * z3


@inlined_kernel
def coefficients(patches, patch, block, cache, tags):  # type: ignore[no-untyped-def]
    """Return where in `cache` (48 SLOTS,) the polynomial's coefficients lie, gathered only if not there yet."""
    slot = OF_PATCH * (patch % PATCHES) + min(block, OF_PATCH - 1)
    tag = np.int64(patch) << 16 | block
    if tags[slot] != tag:
        gather(patches, patch, block, cache, 48 * slot)
        tags[slot] = tag
    return 48 * slot
