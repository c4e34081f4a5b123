"""Edges flipped for regular valences or for better angles; arrays as in ``_ring_kernels.py``."""

# mypy: allow-untyped-defs, allow-untyped-calls

import math

import numpy as np

from subdfit.compiled import inner_kernel, kernel
from subdfit.mesh._division_kernels import distance_squared
from subdfit.mesh._ring_kernels import following, hard, preceding, side_between

SLIVER = 1e-6
"""A flip leaves no triangle with less than this share of the area of its two triangles."""
ROUNDING = 1e-12
"""Cosines that differ by less are taken as equal."""


@inner_kernel
def area_vector(points, a, b, c):
    """Normal of a triangle, twice its area long."""
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


@inner_kernel
def faces_on(points, a, d, c, b, cos_turn):
    """Whether the triangles adc and bcd keep within an angle of the quad's area vector and are no slivers.

    The area vector of a quad is the same for both diagonals, so it stands for the surface before the flip.
    """
    x0, y0, z0 = area_vector(points, a, d, c)
    x1, y1, z1 = area_vector(points, b, c, d)
    x, y, z = x0 + x1, y0 + y1, z0 + z1
    whole = math.sqrt(x * x + y * y + z * z)
    area0 = math.sqrt(x0 * x0 + y0 * y0 + z0 * z0)
    area1 = math.sqrt(x1 * x1 + y1 * y1 + z1 * z1)
    if not min(area0, area1) > SLIVER * whole:
        return False
    turned0 = x0 * x + y0 * y + z0 * z < cos_turn * area0 * whole
    turned1 = x1 * x + y1 * y + z1 * z < cos_turn * area1 * whole
    return not (turned0 or turned1)


@inner_kernel
def may_flip(origin, twin, sharp, out, points, h, cos_turn):
    """Whether the edge of `h` may turn: it is smooth and inner, the new edge is new, and the faces are sound.

    No valence falls below 3: the neighbours of a vertex with three edges are joined already.
    """
    t = np.int64(twin[h])
    if t < 0 or sharp[h] > 0.0:
        return False
    bc, ca, ad, db = following(h), preceding(h), following(t), preceding(t)
    a, b, c, d = origin[h], origin[t], origin[ca], origin[db]
    # A sector between two curves keeps at least two triangles, or the limit surface has a spike there.
    if hard(twin, sharp, ca) and hard(twin, sharp, ad):
        return False
    if hard(twin, sharp, bc) and hard(twin, sharp, db):
        return False
    if not faces_on(points, a, d, c, b, cos_turn):
        return False
    return side_between(origin, twin, out, np.int64(c), np.int64(d)) < 0


@inner_kernel
def flip(origin, twin, sharp, out, degree, touched, h, t):
    """Turn the common edge ab of abc (side `h`) and bad (side `t`) to cd: adc and bcd keep their rows."""
    bc, ad = following(h), following(t)
    a, b, c, d = origin[h], origin[t], origin[preceding(h)], origin[preceding(t)]
    if out[a] == ad:
        out[a] = h
    if out[b] == bc:
        out[b] = t
    origin[bc], origin[ad] = d, c
    beyond_ad, beyond_bc = twin[ad], twin[bc]
    twin[h], twin[t] = beyond_ad, beyond_bc
    sharp[h], sharp[t] = sharp[ad], sharp[bc]
    if beyond_ad >= 0:
        twin[beyond_ad] = h
    if beyond_bc >= 0:
        twin[beyond_bc] = t
    twin[bc], twin[ad] = ad, bc
    sharp[bc] = sharp[ad] = 0.0
    degree[a] -= 1
    degree[b] -= 1
    degree[c] += 1
    degree[d] += 1
    for v in (a, b, c, d):
        touched[v] = True


@inner_kernel
def largest_cosine(points, a, b, c):
    """Cosine of the smallest angle of a triangle; 1 when two corners coincide."""
    bc, ca = distance_squared(points, b, c), distance_squared(points, c, a)
    ab = distance_squared(points, a, b)
    if min(bc, ca, ab) == 0.0:
        return 1.0
    at_a = (ca + ab - bc) / math.sqrt(ca * ab)
    at_b = (ab + bc - ca) / math.sqrt(ab * bc)
    at_c = (bc + ca - ab) / math.sqrt(bc * ca)
    return 0.5 * max(at_a, at_b, at_c)


@kernel
def flip_pairs(pairs, cos_turn, origin, twin, sharp, out, degree, points, touched):
    """Flip the edges named by their end vertices, in order, where they may.

    Return the two half-edges of each flip, (k, 2), -1 where it was refused.
    """
    log = np.full((len(pairs), 2), -1, np.int64)
    for k in range(len(pairs)):
        h = side_between(origin, twin, out, pairs[k, 0], pairs[k, 1])
        if h < 0 or not may_flip(origin, twin, sharp, out, points, h, cos_turn):
            continue
        t = np.int64(twin[h])
        flip(origin, twin, sharp, out, degree, touched, h, t)
        log[k, 0], log[k, 1] = h, t
    return log


@kernel
def flip_sweeps(
    sides, optimal, region, angles, max_rise, cos_turn, max_sweeps,
    origin, twin, sharp, out, degree, points, touched,
):  # fmt: skip
    """Sweep over all edges with a vertex of their two faces in `region`, flipping where it pays.

    It pays when the sum of squared differences of the valences to `optimal` rises by at most `max_rise` and,
    if `angles`, the smallest angle grows. After the first sweep only edges near the last flips are looked at.
    Return the two half-edges of each flip, (k, 2).
    """
    last_touch = np.zeros(len(region), np.int64)
    log = np.empty((64, 2), np.int64)
    flips = 0
    for sweep in range(1, max_sweeps + 1):
        before = flips
        for h in range(sides):
            t = np.int64(twin[h])
            if t < h:
                continue
            a, b, c, d = origin[h], origin[t], origin[preceding(h)], origin[preceding(t)]
            if not (region[a] or region[b] or region[c] or region[d]):
                continue
            if max(last_touch[a], last_touch[b], last_touch[c], last_touch[d]) < sweep - 1:
                continue
            rise = 4 - 2 * (degree[a] - optimal[a] + degree[b] - optimal[b])
            rise += 2 * (degree[c] - optimal[c] + degree[d] - optimal[d])
            if rise > max_rise:
                continue
            if angles:
                now = max(largest_cosine(points, a, b, c), largest_cosine(points, b, a, d))
                then = max(largest_cosine(points, a, d, c), largest_cosine(points, b, c, d))
                if not then < now - ROUNDING:
                    continue
            if not may_flip(origin, twin, sharp, out, points, h, cos_turn):
                continue
            flip(origin, twin, sharp, out, degree, touched, h, t)
            for v in (a, b, c, d):
                last_touch[v] = sweep
            if flips == len(log):
                log = np.concatenate((log, log))
            log[flips, 0], log[flips, 1] = h, t
            flips += 1
        if flips == before:
            break
    return log[:flips].copy()
