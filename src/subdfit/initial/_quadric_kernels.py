"""Error quadrics of a triangle mesh: squared distances to planes and points, summed.

A quadric is a row ``a00 a01 a02 a11 a12 a22 b0 b1 b2 c`` and means x'Ax + 2b'x + c (Garland and Heckbert,
Surface simplification using quadric error metrics, 1997, section 5). Half-edge ``h`` starts at
``vertices[h]`` and belongs to triangle ``h // 3``.
"""

import numpy as np

from subdfit.compiled import inner_kernel, kernel
from subdfit.mesh._ring_kernels import following, preceding

CURVE_WEIGHT = 10.0
"""Weight of the planes that stand on creases and boundaries, against the faces' own planes."""

POINT_WEIGHT = 1e-6
"""Weight of the distance to the points themselves: makes every quadric invertible, spreads points in flats."""


@kernel
def vertex_quadrics(points, vertices, mark):  # type: ignore[no-untyped-def]
    """Sum each vertex's area-weighted planes, its curves' upright planes and its own point.

    Returns
    -------
    quadrics : (n, 10) float64
    """
    quadrics = np.zeros((len(points), 10))
    for h in range(len(vertices)):
        o, p, r = vertices[h], vertices[following(h)], vertices[preceding(h)]
        x, y, z = points[o, 0], points[o, 1], points[o, 2]
        e0, e1, e2 = points[p, 0] - x, points[p, 1] - y, points[p, 2] - z
        g0, g1, g2 = points[r, 0] - x, points[r, 1] - y, points[r, 2] - z
        n0, n1, n2 = e1 * g2 - e2 * g1, e2 * g0 - e0 * g2, e0 * g1 - e1 * g0
        length = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2) + 1e-300
        _add_plane(quadrics, o, n0 / length, n1 / length, n2 / length, x, y, z, length / 6.0)
        _add_point(quadrics, o, x, y, z, POINT_WEIGHT * length / 6.0)
        if mark[h] > 0:
            m0, m1, m2 = n1 * e2 - n2 * e1, n2 * e0 - n0 * e2, n0 * e1 - n1 * e0
            squared = e0 * e0 + e1 * e1 + e2 * e2
            scale = 1.0 / (np.sqrt(squared) * length + 1e-300)
            weight = 0.5 * CURVE_WEIGHT * squared
            _add_plane(quadrics, o, m0 * scale, m1 * scale, m2 * scale, x, y, z, weight)
            _add_plane(quadrics, p, m0 * scale, m1 * scale, m2 * scale, x, y, z, weight)
    return quadrics


@inner_kernel
def _add_plane(quadrics, v, a, b, c, x, y, z, weight):  # type: ignore[no-untyped-def]
    """Add `weight` times the squared distance to the plane through (x, y, z) with unit normal (a, b, c)."""
    d = -(a * x + b * y + c * z)
    quadrics[v, 0] += weight * a * a
    quadrics[v, 1] += weight * a * b
    quadrics[v, 2] += weight * a * c
    quadrics[v, 3] += weight * b * b
    quadrics[v, 4] += weight * b * c
    quadrics[v, 5] += weight * c * c
    quadrics[v, 6] += weight * a * d
    quadrics[v, 7] += weight * b * d
    quadrics[v, 8] += weight * c * d
    quadrics[v, 9] += weight * d * d


@inner_kernel
def _add_point(quadrics, v, x, y, z, weight):  # type: ignore[no-untyped-def]
    """Add `weight` times the squared distance to (x, y, z)."""
    quadrics[v, 0] += weight
    quadrics[v, 3] += weight
    quadrics[v, 5] += weight
    quadrics[v, 6] -= weight * x
    quadrics[v, 7] -= weight * y
    quadrics[v, 8] -= weight * z
    quadrics[v, 9] += weight * (x * x + y * y + z * z)


@inner_kernel
def quadric_error(a00, a01, a02, a11, a12, a22, b0, b1, b2, c, x, y, z):  # type: ignore[no-untyped-def]
    """Value of a quadric at (x, y, z), not below 0."""
    value = x * (a00 * x + 2.0 * (a01 * y + a02 * z + b0))
    value += y * (a11 * y + 2.0 * (a12 * z + b1)) + z * (a22 * z + 2.0 * b2) + c
    return max(value, 0.0)


@inner_kernel
def quadric_minimum(a00, a01, a02, a11, a12, a22, b0, b1, b2):  # type: ignore[no-untyped-def]
    """Solve A x = -b by LDL'; the first result is False where A is not safely positive definite."""
    l1, l2 = a01 / a00, a02 / a00
    d1 = a11 - l1 * a01
    e = a12 - l1 * a02
    l3 = e / d1
    d2 = a22 - l2 * a02 - l3 * e
    y1 = -b1 + l1 * b0
    z = (-b2 + l2 * b0 - l3 * y1) / d2
    y = y1 / d1 - l3 * z
    return a00 > 0.0 and d1 > 1e-12 * a11 and d2 > 1e-12 * a22, -b0 / a00 - l1 * y - l2 * z, y, z
