"""Local edits of an oriented triangle mesh in flat arrays, each carrying surface points along.

Half-edge ``h = 3 * face + slot`` runs from ``origin[h]`` to the origin of the next slot; ``twin[h]`` is the
half-edge running back, -1 on the boundary; ``sharp[h]`` is the sharpness of its edge, the same on both sides.
A surface point is ``(face, u, v)`` with the weights ``1 - u - v, u, v`` of slots 0, 1, 2.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

import math

import numpy as np

from subdfit.compiled import inner_kernel, kernel

BISECTED = 1
QUARTERED = 10
SLIVER = 1e-6
"""A flip leaves no triangle with less than this share of the area of its two triangles."""
ROUNDING = 1e-12
"""Cosines that differ by less are taken as equal."""


@kernel
def following(h):
    """Next half-edge of the same face."""
    return h - 2 if h % 3 == 2 else h + 1


@kernel
def preceding(h):
    """Previous half-edge of the same face."""
    return h + 2 if h % 3 == 0 else h - 1


@kernel
def rings(origin, twin, sides, out, degree):
    """Fill `degree` (edges of each vertex) and `out` (a half-edge leaving it, on the boundary if one is)."""
    out[:] = -1
    degree[:] = 0
    for h in range(sides):
        v = origin[h]
        degree[v] += 1
        if twin[h] < 0:
            degree[origin[following(h)]] += 1
            out[v] = h
        elif out[v] < 0:
            out[v] = h


@kernel
def torn_vertex(origin, twin, out, degree, vertices):
    """First vertex whose triangles are not one fan, or -1."""
    for v in range(vertices):
        if out[v] < 0:
            continue
        first = np.int64(out[v])
        h = first
        seen = 1 if twin[first] < 0 else 0
        while True:
            seen += 1
            h = np.int64(twin[preceding(h)])
            if h < 0 or h == first:
                break
        if seen != degree[v]:
            return v
    return -1


@inner_kernel
def side_between(origin, twin, out, v, w):
    """Half-edge v to w, or w to v where only that exists; -1 when the vertices share no edge."""
    first = np.int64(out[v])
    h = first
    while h >= 0:
        if origin[following(h)] == w:
            return h
        last = preceding(h)
        h = np.int64(twin[last])
        if h < 0 and origin[last] == w:
            return last
        if h == first:
            break
    return np.int64(-1)


@inner_kernel
def hard(twin, sharp, h):
    """Whether an edge is part of a curve that must stay: boundary or crease."""
    return twin[h] < 0 or sharp[h] > 0.0


# Splits: the marked sides are bisected, each face follows by the number of its marked sides.


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
