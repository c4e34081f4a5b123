"""Values and derivatives of the cells' polynomials."""

from subdfit.compiled import inlined_kernel
from subdfit.limit._locate_kernels import QUAD


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
def biquadratic(c, o, x, y):  # type: ignore[no-untyped-def]
    """What `bicubic` returns, where the coefficients of the third powers are zero."""
    p0 = c[o] + y * (c[o + 1] + y * c[o + 2])
    p1 = c[o + 4] + y * (c[o + 5] + y * c[o + 6])
    p2 = c[o + 8] + y * (c[o + 9] + y * c[o + 10])
    q0 = c[o + 1] + y * (2 * c[o + 2])
    q1 = c[o + 5] + y * (2 * c[o + 6])
    q2 = c[o + 9] + y * (2 * c[o + 10])
    return p0 + x * (p1 + x * p2), p1 + x * (2 * p2), q0 + x * (q1 + x * q2)


@inlined_kernel
def first_order(shape, quad_degree, c, o, x, y):  # type: ignore[no-untyped-def]
    """Value and first derivatives of a cell's polynomial."""
    if shape == QUAD:
        if quad_degree == 2:
            return biquadratic(c, o, x, y)
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
