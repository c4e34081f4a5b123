"""Sums over data points: normal equations without their matrix, lumped weights, maxima a face."""

import numpy as np

from subdfit.compiled import kernel


@kernel
def normal_product(offsets, columns, values, metric, x, start, stop, out):  # type: ignore[no-untyped-def]
    """Add W^T D W x to `out` for the rows ``start`` to ``stop`` of W.

    `metric` (k, 6) holds each row's symmetric D: xx, xy, xz, yy, yz, zz. `x` and `out` are (points, 3).
    """
    for k in range(start, stop):
        a = b = c = 0.0
        for p in range(offsets[k], offsets[k + 1]):
            w, q = values[p], columns[p]
            a += w * x[q, 0]
            b += w * x[q, 1]
            c += w * x[q, 2]
        d = metric[k, 0] * a + metric[k, 1] * b + metric[k, 2] * c
        e = metric[k, 1] * a + metric[k, 3] * b + metric[k, 4] * c
        f = metric[k, 2] * a + metric[k, 4] * b + metric[k, 5] * c
        for p in range(offsets[k], offsets[k + 1]):
            w, q = values[p], columns[p]
            out[q, 0] += w * d
            out[q, 1] += w * e
            out[q, 2] += w * f


@kernel
def transposed_product(offsets, columns, values, vectors, start, stop, out):  # type: ignore[no-untyped-def]
    """Add W^T `vectors` to `out` for the rows ``start`` to ``stop``; both have the same number of columns."""
    for k in range(start, stop):
        for p in range(offsets[k], offsets[k + 1]):
            w, q = values[p], columns[p]
            for d in range(vectors.shape[1]):
                out[q, d] += w * vectors[k, d]


@kernel
def barycentric_sums(face, uv, error, corner, start, stop, moved, weight):  # type: ignore[no-untyped-def]
    """Sum error vectors over the one-ring of each control vertex, weighted by barycentric coordinates.

    Nishiyama et al. 2008, equations 3 and 4: `moved` (n, 3) gathers u e, `weight` (n,) gathers u. `corner` (f, 3) holds
    the control vertices of each face.
    """
    for k in range(start, stop):
        f = face[k]
        u, v = uv[k, 0], uv[k, 1]
        for c in range(3):
            share = 1 - u - v if c == 0 else (u if c == 1 else v)
            i = corner[f, c]
            weight[i] += share
            for d in range(3):
                moved[i, d] += share * error[k, d]


@kernel
def group_maximum(group, value, out):  # type: ignore[no-untyped-def]
    """Raise ``out[g]`` to the largest `value` of group g."""
    for k in range(len(group)):
        if value[k] > out[group[k]]:
            out[group[k]] = value[k]


@kernel
def plane_metric(first, tangential, weight, out):  # type: ignore[no-untyped-def]
    """Write n n^T + tangential (I - n n^T), times the weight, for the planes of ``first`` (k, 2, 3); I where degenerate."""
    for k in range(len(first)):
        x = first[k, 0, 1] * first[k, 1, 2] - first[k, 0, 2] * first[k, 1, 1]
        y = first[k, 0, 2] * first[k, 1, 0] - first[k, 0, 0] * first[k, 1, 2]
        z = first[k, 0, 0] * first[k, 1, 1] - first[k, 0, 1] * first[k, 1, 0]
        squared = x * x + y * y + z * z
        w = weight[k]
        if squared > 0:
            a, b = w * (1 - tangential) / squared, w * tangential
        else:
            a, b = 0.0, w
        out[k, 0], out[k, 1], out[k, 2] = a * x * x + b, a * x * y, a * x * z
        out[k, 3], out[k, 4], out[k, 5] = a * y * y + b, a * y * z, a * z * z + b
