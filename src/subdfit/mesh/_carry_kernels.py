"""Surface points carried along by divisions and flips.

A surface point is ``(face, u, v)`` with the weights ``1 - u - v, u, v`` of slots 0, 1, 2.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np

from subdfit.compiled import inner_kernel, kernel
from subdfit.mesh._division_kernels import BISECTED, QUARTERED


@inner_kernel
def put(uv, p, slot, w0, w1, w2):
    """Store weights that begin at `slot`, kept inside the triangle against rounding."""
    u, v = w1, w2
    if slot == 1:
        u, v = w0, w1
    elif slot == 2:
        u, v = w2, w0
    u = min(max(u, 0.0), 1.0)
    v = max(v, 0.0)
    uv[p, 0] = u
    uv[p, 1] = v if u + v <= 1.0 else 1.0 - u


@inner_kernel
def taken(uv, p, slot):
    """Weights of a point, beginning at `slot`."""
    u, v = uv[p, 0], uv[p, 1]
    w = 1.0 - u - v
    if slot == 0:
        return w, u, v
    if slot == 1:
        return u, v, w
    return v, w, u


@inner_kernel
def follow_bisection(face, uv, p, g, slot):
    """Move a point with a bisection of its face on side `slot`; True when it goes to the new face `g`."""
    x, y, z = taken(uv, p, slot)
    if x >= y:
        put(uv, p, slot, x - y, 2.0 * y, z)
        return False
    put(uv, p, slot, 2.0 * x, y - x, z)
    face[p] = g
    return True


@kernel
def follow_division(face, uv, pattern, child, start, stop):
    """Move the points ``start:stop`` from the old faces to the new: the place on the flat triangles stays."""
    for p in range(start, stop):
        how = np.int64(pattern[face[p]])
        if how == 0:
            continue
        new = np.int64(child[face[p]])
        if how < QUARTERED:
            slot, again = (how - BISECTED) % 3, (how - BISECTED) // 3
            moved = follow_bisection(face, uv, p, new, slot)
            if again == 1 and moved:
                follow_bisection(face, uv, p, new + 1, (slot + 1) % 3)
            elif again == 2 and not moved:
                follow_bisection(face, uv, p, new + 1, (slot + 2) % 3)
            continue
        u, v = uv[p, 0], uv[p, 1]
        w = 1.0 - u - v
        if w >= 0.5:
            face[p] = new
            put(uv, p, 0, 2.0 * w - 1.0, 2.0 * u, 2.0 * v)
        elif u >= 0.5:
            face[p] = new + 1
            put(uv, p, 0, 2.0 * w, 2.0 * u - 1.0, 2.0 * v)
        elif v >= 0.5:
            face[p] = new + 2
            put(uv, p, 0, 2.0 * w, 2.0 * u, 2.0 * v - 1.0)
        else:
            put(uv, p, 0, 1.0 - 2.0 * w, 1.0 - 2.0 * u, 1.0 - 2.0 * v)


@kernel
def list_points(face, head, link):
    """Chain the points of each face: ``head[face]``, then ``link[point]``, -1 at the end."""
    head[:] = -1
    for p in range(len(face)):
        link[p] = head[face[p]]
        head[face[p]] = p


@kernel
def follow_flips(face, uv, changed, log, head, link):
    """Move points with a series of flips, each given by its two half-edges (-1: none).

    The quad of the two faces is flattened to the unit square, corner a at (0, 0), d at (1, 0), b at (1, 1)
    and c at (0, 1), and points keep their place in it. Edge ab of the faces abc, bad (from the slots of the
    two half-edges on) becomes cd of adc, bcd.
    """
    for n in range(len(log)):
        if log[n, 0] < 0:
            continue
        f, g, i, j = log[n, 0] // 3, log[n, 1] // 3, log[n, 0] % 3, log[n, 1] % 3
        waiting = (head[f], head[g])
        head[f] = head[g] = -1
        for k in range(2):
            p = np.int64(waiting[k])
            while p >= 0:
                later = np.int64(link[p])
                if k == 0:
                    _, b, c = taken(uv, p, i)
                    x, y = b, b + c
                else:
                    b, _, d = taken(uv, p, j)
                    x, y = b + d, b
                if x + y <= 1.0:
                    put(uv, p, i, 1.0 - x - y, x, y)
                    home = f
                else:
                    put(uv, p, j, x + y - 1.0, 1.0 - x, 1.0 - y)
                    home = g
                face[p] = home
                changed[p] = True
                link[p] = head[home]
                head[home] = p
                p = later


# Flips.
