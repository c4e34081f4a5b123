"""Facets of a Delaunay tetrahedralisation: their empty spheres, and turning round an edge from facet to facet.

``cells[c]`` are four points and ``beyond[c, i]`` is the cell across the facet opposite corner ``i``, -1 outside the
hull. That facet is called ``4 c + i``, so each facet inside the hull has two names.
"""

import numpy as np

from subdfit.compiled import inlined_kernel, kernel

FLAT = 1e-9
"""Height over a facet, as a share of the root of its area, below which a point counts as lying in its plane."""

THIN = 1e-24
"""Squared sine below which three points count as lying on a line."""


@kernel
def facet_radii(points, cells, beyond, largest, start, stop, radii):  # type: ignore[no-untyped-def]
    """Fill in, for the facets of some cells, the radius of the smallest sphere through each that is empty of points.

    Infinite for facets without area, on the hull, with a corner beyond the rows of `largest`, and where the radius
    exceeds `largest` at all three corners. A facet inside is written once under each name, by the lower cell.
    """
    for c in range(start, stop):
        for i in range(4):
            other = beyond[c, i]
            if other > c:
                bound, inner = 0.0, True
                for k in range(1, 4):
                    p = cells[c, (i + k) % 4]
                    inner = inner and p < len(largest)
                    bound = max(bound, largest[p % len(largest)])
                radius = _empty_radius(points, cells, beyond, c, i) if inner else np.inf
                radius = radius if radius <= bound else np.inf
                radii[4 * c + i] = radius
                radii[other_name(cells, beyond, 4 * c + i)] = radius


@kernel
def _empty_radius(points, cells, beyond, c, i):  # type: ignore[no-untyped-def]
    """Radius of the smallest empty sphere through a facet (Cohen-Steiner and Da 2004, section 2.1).

    The centres of spheres through the facet lie on its axis, at heights t over its circumcentre; a point at height h
    with power p to the facet's circumsphere is outside as long as 2 h t <= p. The apexes of the cells on both sides
    bound t from both sides; one in the facet's own plane bounds nothing.
    """
    a, b, d = cells[c, (i + 1) % 4], cells[c, (i + 2) % 4], cells[c, (i + 3) % 4]
    u0, u1, u2 = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    v0, v1, v2 = points[d, 0] - points[a, 0], points[d, 1] - points[a, 1], points[d, 2] - points[a, 2]
    n0, n1, n2 = u1 * v2 - u2 * v1, u2 * v0 - u0 * v2, u0 * v1 - u1 * v0
    squared = n0 * n0 + n1 * n1 + n2 * n2
    uu, vv = u0 * u0 + u1 * u1 + u2 * u2, v0 * v0 + v1 * v1 + v2 * v2
    if not squared > THIN * uu * vv:
        return np.inf
    w0, w1, w2 = uu * v0 - vv * u0, uu * v1 - vv * u1, uu * v2 - vv * u2
    scale = 0.5 / squared
    o0, o1, o2 = (w1 * n2 - w2 * n1) * scale, (w2 * n0 - w0 * n2) * scale, (w0 * n1 - w1 * n0) * scale
    length = np.sqrt(squared)
    least, most = -np.inf, np.inf
    for side in range(2):
        facet = 4 * c + i if side == 0 else other_name(cells, beyond, 4 * c + i)
        apex = cells[facet // 4, facet % 4]
        x0, x1, x2 = points[apex, 0] - points[a, 0], points[apex, 1] - points[a, 1], points[apex, 2] - points[a, 2]
        height = (x0 * n0 + x1 * n1 + x2 * n2) / length
        power = x0 * (x0 - 2.0 * o0) + x1 * (x1 - 2.0 * o1) + x2 * (x2 - 2.0 * o2)
        if height > FLAT * np.sqrt(length):
            most = power / (2.0 * height)
        elif height < -FLAT * np.sqrt(length):
            least = power / (2.0 * height)
    nearest = min(max(0.0, least), most)
    return np.sqrt(o0 * o0 + o1 * o1 + o2 * o2 + nearest * nearest)


@kernel
def other_name(cells, beyond, facet):  # type: ignore[no-untyped-def]
    """The name of a facet, not on the hull, from the cell on its other side."""
    c, i = facet // 4, facet % 4
    cell = np.int64(beyond[c, i])
    j = 0
    while (
        cells[cell, j] == cells[c, (i + 1) % 4]
        or cells[cell, j] == cells[c, (i + 2) % 4]
        or cells[cell, j] == cells[c, (i + 3) % 4]
    ):
        j += 1
    return 4 * cell + j


@kernel
def third(cells, facet, u, v):  # type: ignore[no-untyped-def]
    """The point of a facet besides `u` and `v`."""
    c, i = facet // 4, facet % 4
    k = 0
    while k == i or cells[c, k] == u or cells[c, k] == v:
        k += 1
    return np.int64(cells[c, k])


@inlined_kernel
def next_round(cells, beyond, facet, u, v):  # type: ignore[no-untyped-def]
    """Turn round edge `u v`, inside the hull, through the cell that names `facet`.

    Returns
    -------
    facet : the next facet, as the next cell names it.
    apex : its point besides `u` and `v`.
    """
    c, i = facet // 4, facet % 4
    k = 0
    while k == i or cells[c, k] == u or cells[c, k] == v:
        k += 1
    apex = np.int64(cells[c, i])
    cell = np.int64(beyond[c, k])
    j = 0
    while cells[cell, j] == u or cells[cell, j] == v or cells[cell, j] == apex:
        j += 1
    return 4 * cell + j, apex
