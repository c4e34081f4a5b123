"""Weights of patch points in a surface point, as sparse rows."""

import numpy as np

from subdfit.compiled import kernel
from subdfit.limit._locate_kernels import QUAD, locate
from subdfit.limit._strip_kernels import back_from_strip, way_into_strip


@kernel
def row_sizes(patches, cell, uv):  # type: ignore[no-untyped-def]
    """Row offsets of the sparse weights: how many patch points each point depends on, summed."""
    offsets = np.zeros(len(cell) + 1, np.int64)
    for k in range(len(cell)):
        patch = locate(patches, cell[k], uv[k, 0], uv[k, 1])[0]
        offsets[k + 1] = offsets[k] + patches.type_size[patches.patch_type[patch]]
    return offsets


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
