"""Facets of a Delaunay tetrahedralisation and their empty spheres.

``cells[c]`` are four points and ``beyond[c, i]`` is the cell across the facet opposite corner ``i``, -1 outside the
hull.
"""

import numpy as np

from subdfit.compiled import inner_kernel, kernel

FLAT = 1e-9
"""Height over a facet, as a share of the root of its area, below which a point counts as lying in its plane."""

THIN = 1e-24
"""Squared sine below which three points count as lying on a line."""


@kernel
def small_facets(points, cells, beyond, largest, begin, end, corners, radii):  # type: ignore[no-untyped-def]
    """Gather the facets through which small spheres pass that are empty of points, and the radii of the smallest.

    Left out are facets without area, on the hull, with a corner beyond the rows of `largest`, those whose radius
    exceeds `largest` at all three corners, and those whose first corner is not in begin..end - 1.

    Parameters
    ----------
    corners : (2 c, 3) int32, filled from the top, each row ascending.
    radii : (2 c,) float64.

    Returns
    -------
    int : number of facets.
    """
    count = 0
    for c in range(len(cells)):
        for i in range(4):
            if beyond[c, i] <= c:
                continue
            p, q, r = cells[c, (i + 1) % 4], cells[c, (i + 2) % 4], cells[c, (i + 3) % 4]
            low, high = min(p, q, r), max(p, q, r)
            if low < begin or low >= end or high >= len(largest):
                continue
            radius = _empty_radius(points, cells, beyond, c, i)
            if radius <= max(largest[p], largest[q], largest[r]):
                corners[count, 0], corners[count, 1], corners[count, 2] = low, p + q + r - low - high, high
                radii[count] = radius
                count += 1
    return count


@inner_kernel
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
        apex = cells[c, i] if side == 0 else _apex_beyond(cells, beyond, c, i)
        x0, x1, x2 = points[apex, 0] - points[a, 0], points[apex, 1] - points[a, 1], points[apex, 2] - points[a, 2]
        height = (x0 * n0 + x1 * n1 + x2 * n2) / length
        power = x0 * (x0 - 2.0 * o0) + x1 * (x1 - 2.0 * o1) + x2 * (x2 - 2.0 * o2)
        if height > FLAT * np.sqrt(length):
            most = power / (2.0 * height)
        elif height < -FLAT * np.sqrt(length):
            least = power / (2.0 * height)
    nearest = min(max(0.0, least), most)
    return np.sqrt(o0 * o0 + o1 * o1 + o2 * o2 + nearest * nearest)


@inner_kernel
def _apex_beyond(cells, beyond, c, i):  # type: ignore[no-untyped-def]
    """The fourth point of the cell across a facet, not on the hull."""
    cell, j = beyond[c, i], 0
    while (
        cells[cell, j] == cells[c, (i + 1) % 4]
        or cells[cell, j] == cells[c, (i + 2) % 4]
        or cells[cell, j] == cells[c, (i + 3) % 4]
    ):
        j += 1
    return cells[cell, j]


@kernel
def facets_at(corners, offsets, facets):  # type: ignore[no-untyped-def]
    """Fill in the facets at each point, ascending: those at point p begin at ``offsets[p]``."""
    place = offsets.copy()
    for f in range(len(corners)):
        for k in range(3):
            p = corners[f, k]
            facets[place[p]] = f
            place[p] += 1
