"""Triangles cut in two, three or four at the middles of marked edges; arrays as in ``_ring_kernels.py``."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np

from subdfit.compiled import inner_kernel, kernel
from subdfit.mesh._ring_kernels import following

BISECTED = 1
QUARTERED = 10


@kernel
def complete_marks(twin, marked, faces):
    """Mark all sides of every face with two marked sides, until every face has none, one or three."""
    waiting = np.empty(3 * faces + 1, np.int64)
    for start in range(faces):
        waiting[0] = start
        size = 1
        while size > 0:
            size -= 1
            f = waiting[size]
            count = 0
            for h in range(3 * f, 3 * f + 3):
                count += marked[h]
            if count != 2:
                continue
            for h in range(3 * f, 3 * f + 3):
                if not marked[h]:
                    marked[h] = True
                    if twin[h] >= 0:
                        marked[twin[h]] = True
                        waiting[size] = twin[h] // 3
                        size += 1


@kernel
def place_middles(origin, twin, marked, points, vertices, middle, parents):
    """Append the midpoint of every marked edge as a vertex, in the order of its first half-edge."""
    v = vertices
    for h in range(len(marked)):
        if not marked[h]:
            continue
        t = twin[h]
        if 0 <= t < h:
            middle[h] = middle[t]
            continue
        a, b = origin[h], origin[following(h)]
        middle[h] = v
        parents[v, 0], parents[v, 1] = a, b
        for k in range(3):
            points[v, k] = 0.5 * (points[a, k] + points[b, k])
        v += 1


@inner_kernel
def bisect(origin, twin, sharp, f, g, slot, vertex):
    """Cut face `f` from `vertex`, on its side `slot`, to the opposite corner; `g` gets the half after it.

    Corners keep their slots, and so does every side of the old face: in `f`, in `g`, or half in each.
    """
    nxt, last = (slot + 1) % 3, (slot + 2) % 3
    for k in range(3):
        origin[3 * g + k] = origin[3 * f + k]
    origin[3 * f + nxt] = vertex
    origin[3 * g + slot] = vertex
    twin[3 * f + nxt], twin[3 * g + last] = 3 * g + last, 3 * f + nxt
    sharp[3 * f + nxt] = sharp[3 * g + last] = 0.0


@inner_kernel
def distance_squared(points, a, b):
    """Squared distance of two vertices."""
    x, y, z = points[a, 0] - points[b, 0], points[a, 1] - points[b, 1], points[a, 2] - points[b, 2]
    return x * x + y * y + z * z


@kernel
def divide_faces(origin, twin, sharp, points, marked, middle, pattern, child, first, second):
    """Cut the faces with marked sides; record how (`pattern`) and the first new face (`child`) of each.

    ``pattern``: 0 whole; ``1 + slot`` bisected; ``4 + slot`` the later half bisected again on the slot after;
    ``7 + slot`` the earlier half bisected again on the slot before; 10 quartered, the middle keeping the row.
    `first`, `second`: for each old half-edge the half-edges on its two halves (or itself, when not marked).
    """
    new = len(pattern)
    for f in range(len(pattern)):
        count = 0
        for h in range(3 * f, 3 * f + 3):
            count += marked[h]
            first[h] = h
        child[f] = new
        if count == 1:
            slot = 0 if marked[3 * f] else (1 if marked[3 * f + 1] else 2)
            pattern[f] = BISECTED + slot
            bisect(origin, twin, sharp, f, new, slot, middle[3 * f + slot])
            second[3 * f + slot] = 3 * new + slot
            first[3 * f + (slot + 1) % 3] = 3 * new + (slot + 1) % 3
        elif count == 2:
            bare = 0 if not marked[3 * f] else (1 if not marked[3 * f + 1] else 2)
            i, j = (bare + 1) % 3, (bare + 2) % 3
            m, n = middle[3 * f + i], middle[3 * f + j]
            a, b = origin[3 * f + bare], origin[3 * f + i]
            if distance_squared(points, a, m) <= distance_squared(points, b, n):
                pattern[f] = BISECTED + 3 + i
                bisect(origin, twin, sharp, f, new, i, m)
                bisect(origin, twin, sharp, new, new + 1, j, n)
                twin[3 * f + j], twin[3 * (new + 1) + bare] = 3 * (new + 1) + bare, 3 * f + j
                sharp[3 * (new + 1) + bare] = 0.0
                second[3 * f + i] = 3 * new + i
                first[3 * f + j], second[3 * f + j] = 3 * new + j, 3 * (new + 1) + j
            else:
                pattern[f] = BISECTED + 6 + j
                bisect(origin, twin, sharp, f, new, j, n)
                bisect(origin, twin, sharp, f, new + 1, i, m)
                first[3 * f + bare], second[3 * f + j] = 3 * new + bare, 3 * new + j
                second[3 * f + i] = 3 * (new + 1) + i
                first[3 * f + j] = 3 * (new + 1) + j
        elif count == 3:
            pattern[f] = QUARTERED
            quarter(origin, twin, sharp, f, new, middle[3 * f], middle[3 * f + 1], middle[3 * f + 2])
            for k in range(3):
                first[3 * f + k] = 3 * (new + k) + k
                second[3 * f + k] = 3 * (new + (k + 1) % 3) + k
        new += count


@inner_kernel
def quarter(origin, twin, sharp, f, new, ab, bc, ca):
    """Cut face `f` in four: corner triangles ``new + slot``, and the middle, turned round, in row `f`."""
    h, n = 3 * f, 3 * new
    a, b, c = origin[h], origin[h + 1], origin[h + 2]
    origin[n], origin[n + 1], origin[n + 2] = a, ab, ca
    origin[n + 3], origin[n + 4], origin[n + 5] = ab, b, bc
    origin[n + 6], origin[n + 7], origin[n + 8] = ca, bc, c
    origin[h], origin[h + 1], origin[h + 2] = bc, ca, ab
    for k in range(3):
        inner = (k + 1) % 3
        twin[h + inner], twin[n + 3 * k + inner] = n + 3 * k + inner, h + inner
        sharp[h + inner] = sharp[n + 3 * k + inner] = 0.0


@kernel
def join_sides(twin, sharp, old_twin, old_sharp, marked, first, second):
    """Give the pieces of every old half-edge their twins and the sharpness of their edge."""
    for h in range(len(marked)):
        t = old_twin[h]
        sharp[first[h]] = old_sharp[h]
        if marked[h]:
            twin[first[h]] = second[t] if t >= 0 else -1
            twin[second[h]] = first[t] if t >= 0 else -1
            sharp[second[h]] = old_sharp[h]
        else:
            twin[first[h]] = first[t] if t >= 0 else -1


# Carried points.
