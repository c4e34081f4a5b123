"""Edge collapses on a triangle mesh held in flat half-edge arrays, cheapest quadric first.

Half-edge ``h`` starts at ``vertices[h]``; the triangle is ``h // 3``. A vertex has a *kind*: 0 smooth, 1 on
a curve (two edges of one mark), 2 corner. An edge has a *mark*: 0 smooth, 1 crease, 2 boundary. Quadrics
are rows ``a00 a01 a02 a11 a12 a22 b0 b1 b2 c`` of x'Ax + 2b'x + c (Garland and Heckbert 1997, section 5).
"""

import numpy as np

from subdfit.compiled import kernel

SMOOTH, CURVE, CORNER = 0, 1, 2
IDLE, QUEUED, STALE = 0, 1, 2

CURVE_WEIGHT = 10.0
"""Weight of the planes that stand on creases and boundaries, against the faces' own planes."""

POINT_WEIGHT = 1e-4
"""Weight of the distance to the points themselves: makes every quadric invertible, spreads points in flats."""

VALENCE_WEIGHT = 0.05
"""Relative rise of the cost for each unit of (valence - regular)^2 that the merged vertex has too much."""

FACE_QUALITY = 2.0 * np.sqrt(3.0)
"""Makes |normal| / (sum of squared sides) equal 1 for an equilateral triangle."""


@kernel
def _following(h):  # type: ignore[no-untyped-def]
    return h - 2 if h % 3 == 2 else h + 1


@kernel
def _preceding(h):  # type: ignore[no-untyped-def]
    return h + 2 if h % 3 == 0 else h - 1


@kernel
def vertex_quadrics(points, vertices, mark):  # type: ignore[no-untyped-def]
    """Sum each vertex's area-weighted planes, its curves' upright planes and its own point.

    Returns
    -------
    quadrics : (n, 10) float64
    """
    quadrics = np.zeros((len(points), 10))
    plane = np.empty(4)
    for f in range(len(vertices) // 3):
        corner = points[vertices[3 * f : 3 * f + 3]]
        normal = np.cross(corner[1] - corner[0], corner[2] - corner[0])
        length = np.sqrt(np.sum(normal * normal))
        area = 0.5 * length
        if length > 0.0:
            normal /= length
        plane[:3] = normal
        plane[3] = -np.sum(normal * corner[0])
        for i in range(3):
            v = vertices[3 * f + i]
            _add_plane(quadrics[v], plane, area / 3.0)
            _add_point(quadrics[v], corner[i], POINT_WEIGHT * area / 3.0)
        for i in range(3):
            if mark[3 * f + i] == 0:
                continue
            side = corner[(i + 1) % 3] - corner[i]
            squared = np.sum(side * side)
            upright = np.cross(normal, side)
            if squared > 0.0:
                upright /= np.sqrt(squared)
            plane[:3] = upright
            plane[3] = -np.sum(upright * corner[i])
            for v in (vertices[3 * f + i], vertices[3 * f + (i + 1) % 3]):
                _add_plane(quadrics[v], plane, 0.5 * CURVE_WEIGHT * squared)
    return quadrics


@kernel
def _add_plane(quadric, plane, weight):  # type: ignore[no-untyped-def]
    a, b, c, d = plane[0], plane[1], plane[2], plane[3]
    quadric[0] += weight * a * a
    quadric[1] += weight * a * b
    quadric[2] += weight * a * c
    quadric[3] += weight * b * b
    quadric[4] += weight * b * c
    quadric[5] += weight * c * c
    quadric[6] += weight * a * d
    quadric[7] += weight * b * d
    quadric[8] += weight * c * d
    quadric[9] += weight * d * d


@kernel
def _add_point(quadric, point, weight):  # type: ignore[no-untyped-def]
    x, y, z = point[0], point[1], point[2]
    quadric[0] += weight
    quadric[3] += weight
    quadric[5] += weight
    quadric[6] -= weight * x
    quadric[7] -= weight * y
    quadric[8] -= weight * z
    quadric[9] += weight * (x * x + y * y + z * z)


@kernel
def _error(q, x, y, z):  # type: ignore[no-untyped-def]
    value = x * (q[0] * x + 2.0 * (q[1] * y + q[2] * z + q[6]))
    value += y * (q[3] * y + 2.0 * (q[4] * z + q[7])) + z * (q[5] * z + 2.0 * q[8]) + q[9]
    return max(value, 0.0)


@kernel
def _minimise(q, place):  # type: ignore[no-untyped-def]
    """Solve A x = -b by LDL' into `place`; False where A is not safely positive definite."""
    d0 = q[0]
    if d0 <= 0.0:
        return False
    l1, l2 = q[1] / d0, q[2] / d0
    d1 = q[3] - l1 * q[1]
    if d1 <= 1e-12 * q[3]:
        return False
    e = q[4] - l1 * q[2]
    l3 = e / d1
    d2 = q[5] - l2 * q[2] - l3 * e
    if d2 <= 1e-12 * q[5]:
        return False
    y0 = -q[6]
    y1 = -q[7] - l1 * y0
    y2 = -q[8] - l2 * y0 - l3 * y1
    z = y2 / d2
    y = y1 / d1 - l3 * z
    place[0] = y0 / d0 - l1 * y - l2 * z
    place[1] = y
    place[2] = z
    return True


@kernel
def _cost(h, points, quadrics, vertices, twin, mark, kind, valence, place):  # type: ignore[no-untyped-def]
    """Cost of collapsing edge `h`, infinite where its ends must stay apart; the merged point goes to `place`.

    A corner never moves and a curve's vertex takes smooth neighbours in without moving; two of a kind meet
    where their summed quadric is least, or at the best of ends and midpoint where that is ill-posed.
    """
    u, v = vertices[h], vertices[_following(h)]
    if kind[u] > SMOOTH and kind[v] > SMOOTH and (mark[h] == 0 or kind[u] + kind[v] == 2 * CORNER):
        return np.inf
    q = quadrics[u] + quadrics[v]
    if kind[u] != kind[v]:
        place[:] = points[u] if kind[u] > kind[v] else points[v]
    elif not _minimise(q, place):
        best = np.inf
        for t in (0.5, 0.0, 1.0):
            x = points[u] + t * (points[v] - points[u])
            error = _error(q, x[0], x[1], x[2])
            if error < best:
                best = error
                place[:] = x
    merged = valence[u] + valence[v] - (4 if twin[h] >= 0 else 3)
    excess = merged - (4 if mark[h] == 2 else 6)
    return _error(q, place[0], place[1], place[2]) * (1.0 + VALENCE_WEIGHT * excess * excess)


@kernel
def _links_meet_twice(h, vertices, twin, mark, outgoing, valence, seen, stamp):  # type: ignore[no-untyped-def]
    """Whether collapsing `h` keeps the surface and its curves what they are, topologically.

    The link condition (Dey et al. 1999): the ends share only the corners opposite the edge. Of a vanishing
    triangle's other two sides at most one may be marked, else two curves (or a curve with itself) would
    merge; and the last four vertices of a closed piece stay.
    """
    u, v = vertices[h], vertices[_following(h)]
    opposite = 0
    for side in (h, twin[h]):
        if side >= 0:
            opposite += 1
            if mark[_following(side)] > 0 and mark[_preceding(side)] > 0:
                return False
    if opposite == 2 and valence[u] == 3 and valence[v] == 3:
        return False
    g = outgoing[u]
    while True:
        seen[vertices[_following(g)]] = stamp
        back = _preceding(g)
        seen[vertices[back]] = stamp
        g = twin[back]
        if g < 0 or g == outgoing[u]:
            break
    shared = 0
    g = outgoing[v]
    while True:
        shared += seen[vertices[_following(g)]] == stamp
        back = _preceding(g)
        g = twin[back]
        if g < 0:
            shared += seen[vertices[back]] == stamp
            break
        if g == outgoing[v]:
            break
    return shared == opposite


@kernel
def _star_change(u, v, place, points, vertices, twin, outgoing):  # type: ignore[no-untyped-def]
    """How the triangles of `u` that avoid `v` fare when `u` moves to `place`.

    Returns
    -------
    before, after : worst quality (1 equilateral, 0 degenerate) of all triangles of `u` now, of the survivors then.
    turn : least cosine between a survivor's normals now and then; 1 where it had no direction yet.
    """
    before, after, turn = 1.0, 1.0, 1.0
    p0, p1, p2 = points[u, 0], points[u, 1], points[u, 2]
    g = outgoing[u]
    while True:
        back = _preceding(g)
        a, b = vertices[_following(g)], vertices[back]
        a0, a1, a2 = points[a, 0], points[a, 1], points[a, 2]
        e0, e1, e2 = points[b, 0] - a0, points[b, 1] - a1, points[b, 2] - a2
        side = e0 * e0 + e1 * e1 + e2 * e2
        s0, s1, s2 = p0 - a0, p1 - a1, p2 - a2
        m0, m1, m2 = e1 * s2 - e2 * s1, e2 * s0 - e0 * s2, e0 * s1 - e1 * s0
        old = np.sqrt(m0 * m0 + m1 * m1 + m2 * m2)
        dot = s0 * e0 + s1 * e1 + s2 * e2
        squared = s0 * s0 + s1 * s1 + s2 * s2
        quality = FACE_QUALITY * old / (2.0 * (side + squared - dot) + 1e-300)
        before = min(before, quality)
        if a != v and b != v:
            s0, s1, s2 = place[0] - a0, place[1] - a1, place[2] - a2
            n0, n1, n2 = e1 * s2 - e2 * s1, e2 * s0 - e0 * s2, e0 * s1 - e1 * s0
            new = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
            dot = s0 * e0 + s1 * e1 + s2 * e2
            squared = s0 * s0 + s1 * s1 + s2 * s2
            after = min(after, FACE_QUALITY * new / (2.0 * (side + squared - dot) + 1e-300))
            if quality > 1e-6:
                turn = min(turn, (m0 * n0 + m1 * n1 + m2 * n2) / (old * new + 1e-300))
        g = twin[back]
        if g < 0 or g == outgoing[u]:
            return before, after, turn


@kernel
def _collapse(h, gone, kept, vertices, twin, mark, outgoing, valence, kind):  # type: ignore[no-untyped-def]
    """Merge the ends of edge `h` into `kept`, take its one or two triangles out and sew the gaps."""
    start = outgoing[gone]
    g = start
    while True:
        vertices[g] = kept
        g = twin[_preceding(g)]
        if g < 0 or g == start:
            break
    valence[kept] += valence[gone] - 2
    around = -1
    for side in (h, twin[h]):
        if side < 0:
            continue
        ahead, back = _following(side), _preceding(side)
        apex = vertices[back]
        left, right = twin[ahead], twin[back]
        joined = max(mark[ahead], mark[back])
        if left >= 0:
            twin[left] = right
            mark[left] = joined
            around = _following(left)
        if right >= 0:
            twin[right] = left
            mark[right] = joined
            around = right
        if outgoing[apex] == back:
            outgoing[apex] = left
        valence[apex] -= 1
        valence[kept] -= 1
        first = 3 * (side // 3)
        vertices[first : first + 3] = -1
    outgoing[kept] = around
    if kind[kept] > SMOOTH:
        while twin[outgoing[kept]] >= 0:
            outgoing[kept] = _following(twin[outgoing[kept]])
            if outgoing[kept] == around:
                break


@kernel
def _sift_down(keys, edges, size, slot):  # type: ignore[no-untyped-def]
    """Let the entry at `slot` sink to its place in the four-way heap."""
    key, edge = keys[slot], edges[slot]
    while True:
        child = 4 * slot + 1
        if child >= size:
            break
        least = child
        for other in range(child + 1, min(child + 4, size)):
            if keys[other] < keys[least]:
                least = other
        if keys[least] >= key:
            break
        keys[slot] = keys[least]
        edges[slot] = edges[least]
        slot = least
    keys[slot] = key
    edges[slot] = edge


@kernel
def _push(keys, edges, size, key, edge):  # type: ignore[no-untyped-def]
    """Add an entry to the heap and return its new size."""
    slot = size
    while slot > 0:
        parent = (slot - 1) // 4
        if keys[parent] <= key:
            break
        keys[slot] = keys[parent]
        edges[slot] = edges[parent]
        slot = parent
    keys[slot] = key
    edges[slot] = edge
    return size + 1


@kernel
def collapse_edges(  # type: ignore[no-untyped-def]
    points, quadrics, vertices, twin, mark, outgoing, valence, kind, alive, target, most_valence, least_quality, least_turn
):
    """Collapse the cheapest admissible edges, in place, until `target` vertices are left or none is admissible.

    Quadrics only grow, so a stale entry's cost bounds the true one from below: entries are re-evaluated
    when they reach the top, not when they go stale. A half-edge has at most one entry, so the heap never
    outgrows the mesh. A merged vertex (or a collapse's survivor) must have valence at most `most_valence`
    unless an end had more already, survivors quality at least `least_quality` unless the star was worse
    before, and a survivor's normal must keep a cosine of at least `least_turn` with what it was.

    Returns
    -------
    alive : int, vertices left.
    """
    keys = np.empty(len(vertices))
    edges = np.empty(len(vertices), np.int32)
    state = np.zeros(len(vertices), np.int8)
    seen = np.zeros(len(points), np.int32)
    place = np.empty(3)
    stamp = 0
    size = 0
    for h in range(len(vertices)):
        if vertices[h] >= 0 and twin[h] < h:
            cost = _cost(h, points, quadrics, vertices, twin, mark, kind, valence, place)
            if cost < np.inf:
                keys[size] = cost
                edges[size] = h
                state[h] = QUEUED
                size += 1
    for slot in range(size // 4, -1, -1):
        if slot < size:
            _sift_down(keys, edges, size, slot)

    while size > 0 and alive > target:
        h = edges[0]
        dead = vertices[h] < 0
        cost = np.inf
        if not dead:
            cost = _cost(h, points, quadrics, vertices, twin, mark, kind, valence, place)
            if state[h] == STALE and keys[0] < cost < np.inf:
                state[h] = QUEUED
                keys[0] = cost
                _sift_down(keys, edges, size, 0)
                continue
        state[h] = IDLE
        size -= 1
        keys[0] = keys[size]
        edges[0] = edges[size]
        _sift_down(keys, edges, size, 0)
        if dead or cost == np.inf:
            continue

        gone, kept = vertices[h], vertices[_following(h)]
        if kind[gone] > kind[kept]:
            gone, kept = kept, gone
        merged = valence[gone] + valence[kept] - (4 if twin[h] >= 0 else 3)
        if merged > most_valence and merged > max(valence[gone], valence[kept]):
            continue
        stamp += 1
        if not _links_meet_twice(h, vertices, twin, mark, outgoing, valence, seen, stamp):
            continue
        before, after, turn = _star_change(gone, kept, place, points, vertices, twin, outgoing)
        other_before, other_after, other_turn = _star_change(kept, gone, place, points, vertices, twin, outgoing)
        after = min(after, other_after)
        if min(turn, other_turn) < least_turn:
            continue
        if after < least_quality and after < min(before, other_before):
            continue

        _collapse(h, gone, kept, vertices, twin, mark, outgoing, valence, kind)
        points[kept] = place
        quadrics[kept] += quadrics[gone]
        outgoing[gone] = -1
        alive -= 1
        g = outgoing[kept]
        while True:
            size = _refresh(g, keys, edges, size, state, points, quadrics, vertices, twin, mark, kind, valence, place)
            back = _preceding(g)
            g = twin[back]
            if g < 0:
                size = _refresh(
                    back, keys, edges, size, state, points, quadrics, vertices, twin, mark, kind, valence, place
                )
                break
            if g == outgoing[kept]:
                break
    return alive


@kernel
def _refresh(  # type: ignore[no-untyped-def]
    h, keys, edges, size, state, points, quadrics, vertices, twin, mark, kind, valence, place
):
    """Call the entries of edge `h` stale, or queue it where it has none (refused before, or new)."""
    other = twin[h]
    waiting = False
    if state[h] != IDLE:
        state[h] = STALE
        waiting = True
    if other >= 0 and state[other] != IDLE:
        state[other] = STALE
        waiting = True
    if waiting:
        return size
    cost = _cost(h, points, quadrics, vertices, twin, mark, kind, valence, place)
    if cost == np.inf:
        return size
    state[h] = QUEUED
    return _push(keys, edges, size, cost, h)
