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
def group_maximum(group, value, out):  # type: ignore[no-untyped-def]
    """Raise ``out[g]`` to the largest `value` of group g."""
    for k in range(len(group)):
        if value[k] > out[group[k]]:
            out[group[k]] = value[k]


@kernel
def squared_distance_metric(first, second, distance, floor, out):  # type: ignore[no-untyped-def]
    """Write the quadratic form of the squared distance to a surface, seen from each point, into `out` (k, 6).

    Along the normal the weight is 1; along a principal direction with radius of curvature rho it is d / (d + rho)
    (Pottmann and Hofer 2003, with signs dropped as Lavoue et al. do), and `floor` at least. `first` (k, 2, 3) and
    `second` (k, 3, 3) are the surface's derivatives at the footpoint, `distance` (k,) is d.
    """
    for k in range(len(first)):
        ux, uy, uz = first[k, 0, 0], first[k, 0, 1], first[k, 0, 2]
        vx, vy, vz = first[k, 1, 0], first[k, 1, 1], first[k, 1, 2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        area = np.sqrt(nx * nx + ny * ny + nz * nz)
        length = np.sqrt(ux * ux + uy * uy + uz * uz)
        if not (area > 0 and length > 0):
            out[k, 0] = out[k, 3] = out[k, 5] = 1.0
            out[k, 1] = out[k, 2] = out[k, 4] = 0.0
            continue
        nx, ny, nz = nx / area, ny / area, nz / area
        # An orthonormal frame (e, f) of the tangent plane; the parameters are x / a - b y / (a c), y / c in it.
        ex, ey, ez = ux / length, uy / length, uz / length
        fx, fy, fz = ny * ez - nz * ey, nz * ex - nx * ez, nx * ey - ny * ex
        a, b, c = length, vx * ex + vy * ey + vz * ez, vx * fx + vy * fy + vz * fz
        p = second[k, 0, 0] * nx + second[k, 0, 1] * ny + second[k, 0, 2] * nz
        q = second[k, 1, 0] * nx + second[k, 1, 1] * ny + second[k, 1, 2] * nz
        r = second[k, 2, 0] * nx + second[k, 2, 1] * ny + second[k, 2, 2] * nz
        xx = p / (a * a)
        xy = (q - b / a * p) / (a * c)
        yy = (r - 2 * b / a * q + b * b / (a * a) * p) / (c * c)
        mean, half = (xx + yy) / 2, np.sqrt(((xx - yy) / 2) ** 2 + xy * xy)
        angle = 0.5 * np.arctan2(2 * xy, xx - yy)
        cosine, sine = np.cos(angle), np.sin(angle)
        bend1, bend2 = abs(mean + half) * distance[k], abs(mean - half) * distance[k]
        w1, w2 = max(floor, bend1 / (1 + bend1)), max(floor, bend2 / (1 + bend2))
        gx, gy, gz = cosine * ex + sine * fx, cosine * ey + sine * fy, cosine * ez + sine * fz
        hx, hy, hz = cosine * fx - sine * ex, cosine * fy - sine * ey, cosine * fz - sine * ez
        out[k, 0] = nx * nx + w1 * gx * gx + w2 * hx * hx
        out[k, 1] = nx * ny + w1 * gx * gy + w2 * hx * hy
        out[k, 2] = nx * nz + w1 * gx * gz + w2 * hx * hz
        out[k, 3] = ny * ny + w1 * gy * gy + w2 * hy * hy
        out[k, 4] = ny * nz + w1 * gy * gz + w2 * hy * hz
        out[k, 5] = nz * nz + w1 * gz * gz + w2 * hz * hz
