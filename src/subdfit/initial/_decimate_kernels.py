"""Edge collapses on a triangle mesh held in flat half-edge arrays, cheapest quadric first.

Half-edge ``h`` starts at ``vertices[h]``; the triangle is ``h // 3``. A vertex has a *kind*: 0 smooth, 1 on
a curve (two edges of one mark), 2 corner. An edge has a *mark*: 0 smooth, 1 crease, 2 boundary.
"""

import numpy as np

from subdfit.compiled import inner_kernel, kernel
from subdfit.initial._quadric_kernels import quadric_error, quadric_minimum
from subdfit.mesh._ring_kernels import following, preceding

SMOOTH, CURVE, CORNER = 0, 1, 2
IDLE, QUEUED, STALE, REFUSED = 0, 1, 2, 3

VALENCE_WEIGHT = 0.02
"""Relative rise of the cost for each unit of (valence - regular)^2 that the merged vertex has too much."""

RETRY = 4.0
"""A refused edge waits until costs are this many times higher: its neighbourhood may admit it by then."""

LEAST_COST = 1e-24
"""Cost below which all are alike, for a mesh of diagonal 1."""

FACE_QUALITY = 2.0 * np.sqrt(3.0)
"""Makes |normal| / (sum of squared sides) equal 1 for an equilateral triangle."""


@inner_kernel
def _cost(h, state, points, quadrics, vertices, twin, mark, kind, valence, subset):  # type: ignore[no-untyped-def]
    """Cost of collapsing edge `h`, infinite where its ends must stay apart, and the point they merge in.

    A corner never moves and a curve's vertex takes smooth neighbours in without moving; two of a kind meet
    where their summed quadric is least, or at the best of ends and midpoint where that is ill-posed or was refused; in
    a `subset` of the points always at an end.
    """
    u, v = vertices[h], vertices[following(h)]
    a00, a01 = quadrics[u, 0] + quadrics[v, 0], quadrics[u, 1] + quadrics[v, 1]
    a02, a11 = quadrics[u, 2] + quadrics[v, 2], quadrics[u, 3] + quadrics[v, 3]
    a12, a22 = quadrics[u, 4] + quadrics[v, 4], quadrics[u, 5] + quadrics[v, 5]
    b0, b1 = quadrics[u, 6] + quadrics[v, 6], quadrics[u, 7] + quadrics[v, 7]
    b2, c = quadrics[u, 8] + quadrics[v, 8], quadrics[u, 9] + quadrics[v, 9]
    ux, uy, uz = points[u, 0], points[u, 1], points[u, 2]
    vx, vy, vz = points[v, 0], points[v, 1], points[v, 2]
    ku, kv, marked, inner = kind[u], kind[v], mark[h], twin[h] >= 0
    excess = valence[u] + valence[v] - (3 + inner) - (4 if marked == 2 else 6)
    if ku > SMOOTH and kv > SMOOTH and (marked == 0 or ku + kv == 2 * CORNER):
        return np.inf, ux, uy, uz
    solved, x, y, z = quadric_minimum(a00, a01, a02, a11, a12, a22, b0, b1, b2)
    best = np.inf
    if solved and state[h] != REFUSED and ku == kv and not subset:
        best = quadric_error(a00, a01, a02, a11, a12, a22, b0, b1, b2, c, x, y, z)
    else:
        for step in range(0, 3, 2 if subset else 1):
            share = 0.0 if ku > kv else 1.0 if ku < kv else 0.5 * step
            px, py, pz = ux + share * (vx - ux), uy + share * (vy - uy), uz + share * (vz - uz)
            error = quadric_error(a00, a01, a02, a11, a12, a22, b0, b1, b2, c, px, py, pz)
            if error < best:
                best, x, y, z = error, px, py, pz
    return best * (1.0 + VALENCE_WEIGHT * excess * excess), x, y, z


@inner_kernel
def _keeps_curves(h, twin, mark):  # type: ignore[no-untyped-def]
    """Whether no triangle beside edge `h` has both other sides marked: those two curves would merge."""
    other = np.int64(twin[h])
    kept = mark[following(h)] == 0 or mark[preceding(h)] == 0
    if other >= 0:
        kept = kept and (mark[following(other)] == 0 or mark[preceding(other)] == 0)
    return kept


@inner_kernel
def _shared_neighbours(h, vertices, twin, outgoing, seen, stamp):  # type: ignore[no-untyped-def]
    """Count the vertices next to both ends of edge `h`; `stamp` must not be in `seen` yet."""
    u, v = vertices[h], vertices[following(h)]
    g = np.int64(outgoing[u])
    while g >= 0:
        back = preceding(g)
        seen[vertices[following(g)]] = stamp
        seen[vertices[back]] = stamp
        g = np.int64(twin[back])
        if g == outgoing[u]:
            g = np.int64(-1)
    shared = 0
    g = np.int64(outgoing[v])
    while g >= 0:
        shared += seen[vertices[following(g)]] == stamp
        back = preceding(g)
        g = np.int64(twin[back])
        if g < 0:
            shared += seen[vertices[back]] == stamp
        if g == outgoing[v]:
            g = np.int64(-1)
    return shared


@inner_kernel
def _star_change(u, v, x, y, z, points, vertices, twin, outgoing):  # type: ignore[no-untyped-def]
    """How the triangles of `u` that avoid `v` fare when `u` moves to (x, y, z).

    Returns
    -------
    before, after : worst quality (1 equilateral, 0 degenerate) of all triangles of `u` now, of the survivors then.
    turn : least cosine between a survivor's normals now and then; 1 where it had no direction yet.
    """
    before, after, turn = 1.0, 1.0, 1.0
    p0, p1, p2 = points[u, 0], points[u, 1], points[u, 2]
    g = outgoing[u]
    while True:
        back = preceding(g)
        a, b = vertices[following(g)], vertices[back]
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
            s0, s1, s2 = x - a0, y - a1, z - a2
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


@inner_kernel
def _collapse(h, gone, kept, vertices, twin, mark, outgoing, valence, kind):  # type: ignore[no-untyped-def]
    """Merge the ends of edge `h` into `kept`, take its one or two triangles out and sew the gaps."""
    start = outgoing[gone]
    g = start
    while True:
        vertices[g] = kept
        g = twin[preceding(g)]
        if g < 0 or g == start:
            break
    valence[kept] += valence[gone] - 2
    around = -1
    for side in (h, np.int64(twin[h])):
        if side < 0:
            continue
        ahead, back = following(side), preceding(side)
        apex = vertices[back]
        left, right = twin[ahead], twin[back]
        joined = max(mark[ahead], mark[back])
        if left >= 0:
            twin[left] = right
            mark[left] = joined
            around = following(left)
        if right >= 0:
            twin[right] = left
            mark[right] = joined
            around = right
        if outgoing[apex] == back:
            outgoing[apex] = left
        valence[apex] -= 1
        valence[kept] -= 1
        first = 3 * (side // 3)
        for i in range(first, first + 3):
            vertices[i] = -1
    outgoing[kept] = around
    if kind[kept] > SMOOTH:
        while twin[outgoing[kept]] >= 0:
            outgoing[kept] = following(twin[outgoing[kept]])
            if outgoing[kept] == around:
                break


@inner_kernel
def _sift_down(keys, edges, size):  # type: ignore[no-untyped-def]
    """Let the top entry of the four-way heap in row 0 sink to its place."""
    key, edge = keys[0, 0], edges[0, 0]
    slot = 0
    while 4 * slot + 1 < size:
        least = 4 * slot + 1
        for other in range(least + 1, min(least + 4, size)):
            if keys[0, other] < keys[0, least]:
                least = other
        if keys[0, least] >= key:
            break
        keys[0, slot] = keys[0, least]
        edges[0, slot] = edges[0, least]
        slot = least
    keys[0, slot] = key
    edges[0, slot] = edge


@inner_kernel
def _enter(h, cost, ceiling, keys, edges, sizes):  # type: ignore[no-untyped-def]
    """Put an edge on the heap, row 0, if its cost is at most the ceiling, else in row 1, which has no order."""
    row = 1 if cost > ceiling else 0
    slot = sizes[row]
    sizes[row] += 1
    while row == 0 and slot > 0 and keys[0, (slot - 1) // 4] > cost:
        keys[0, slot] = keys[0, (slot - 1) // 4]
        edges[0, slot] = edges[0, (slot - 1) // 4]
        slot = (slot - 1) // 4
    keys[row, slot] = cost
    edges[row, slot] = h


@inner_kernel
def _raise_ceiling(vertices, keys, edges, sizes):  # type: ignore[no-untyped-def]
    """Move waiting edges of at most twice the least cost onto the empty heap; forget dead ones met on the way.

    A heap of few entries stays in the processor's cache, and most edges die before their turn comes.
    """
    least = np.inf
    for slot in range(sizes[1]):
        least = min(least, keys[1, slot])
    ceiling = 2.0 * least
    count = sizes[1]
    sizes[1] = 0
    for slot in range(count):
        h, key = np.int64(edges[1, slot]), keys[1, slot]
        if key > ceiling or vertices[h] >= 0:
            _enter(h, key, ceiling, keys, edges, sizes)
    return ceiling


@kernel
def queue_edges(  # type: ignore[no-untyped-def]
    points, quadrics, vertices, twin, mark, valence, kind, subset, keys, edges, sizes, state
):
    """Enter all edges that may be collapsed into an empty queue: none on the heap as yet, all waiting."""
    for first in range(len(vertices)):
        if vertices[first] >= 0 and twin[first] < first:
            cost, _x, _y, _z = _cost(first, state, points, quadrics, vertices, twin, mark, kind, valence, subset)
            if cost < np.inf:
                state[first] = QUEUED
                _enter(first, cost, -1.0, keys, edges, sizes)


@kernel
def collapse_edges(  # type: ignore[no-untyped-def]
    points,
    quadrics,
    vertices,
    twin,
    mark,
    outgoing,
    valence,
    kind,
    alive,
    target,
    most_valence,
    least_quality,
    least_turn,
    subset,
    keys,
    edges,
    sizes,
    state,
    seen,
    highest,
):
    """Collapse the cheapest admissible edges, in place, until `target` vertices are left or none is admissible.

    Quadrics only grow, so a stale entry's cost bounds the true one from below: entries are re-evaluated
    when they reach the top, not when they go stale. A half-edge has at most one entry, so the queue never
    outgrows the mesh. In a `subset` of the points the vertices left stay where they were.

    A collapse may leave valence above `most_valence` only where an end had as much, a triangle of less than
    `least_quality` only where the star had a worse one, and must keep each survivor's normal within the angle of cosine
    `least_turn`. What is refused waits for another try, at an end or midpoint, at higher costs.

    The queue is that of `queue_edges`, or as an earlier call left it: `keys`, `edges` (2, h) and `sizes` (2,), the heap
    and what waits; `state` (h,) of each half-edge's entry; `seen` (n,), stamps; `highest` (1,), the heap's ceiling.

    Returns
    -------
    alive : int, vertices left.
    """
    stamp = seen.max()
    ceiling = highest[0]
    while alive > target:
        if sizes[0] == 0:
            if sizes[1] == 0:
                break
            ceiling = _raise_ceiling(vertices, keys, edges, sizes)
            continue
        h = np.int64(edges[0, 0])
        dead = vertices[h] < 0
        cost = np.inf
        if not dead:
            cost, x, y, z = _cost(h, state, points, quadrics, vertices, twin, mark, kind, valence, subset)
            if state[h] >= STALE and keys[0, 0] < cost <= ceiling:
                state[h] = QUEUED if state[h] == STALE else REFUSED
                keys[0, 0] = cost
                _sift_down(keys, edges, sizes[0])
                continue
        sizes[0] -= 1
        keys[0, 0] = keys[0, sizes[0]]
        edges[0, 0] = edges[0, sizes[0]]
        _sift_down(keys, edges, sizes[0])
        if not dead and state[h] >= STALE and ceiling < cost < np.inf:
            state[h] = QUEUED if state[h] == STALE else REFUSED
            _enter(h, cost, ceiling, keys, edges, sizes)
            continue
        state[h] = IDLE
        if dead or cost == np.inf:
            continue

        gone, kept = vertices[h], vertices[following(h)]
        if kind[gone] > kind[kept]:
            gone, kept = kept, gone
        merged = valence[gone] + valence[kept] - (4 if twin[h] >= 0 else 3)
        opposite = 2 if twin[h] >= 0 else 1
        least_valence = 3 if twin[outgoing[kept]] >= 0 else 2
        stamp += 1
        allowed = least_valence <= merged <= max(most_valence, valence[gone], valence[kept])
        allowed = allowed and _keeps_curves(h, twin, mark)
        allowed = allowed and _shared_neighbours(h, vertices, twin, outgoing, seen, stamp) == opposite
        if allowed:
            before, after, turn = _star_change(gone, kept, x, y, z, points, vertices, twin, outgoing)
            other_before, other_after, other_turn = _star_change(kept, gone, x, y, z, points, vertices, twin, outgoing)
            after = min(after, other_after)
            fair = after >= least_quality or after >= min(before, other_before)
            allowed = fair and min(turn, other_turn) >= least_turn
        if not allowed:
            later = RETRY * max(cost, ceiling, LEAST_COST)
            if later < 1.0:
                state[h] = REFUSED
                _enter(h, later, ceiling, keys, edges, sizes)
            continue

        _collapse(h, gone, kept, vertices, twin, mark, outgoing, valence, kind)
        points[kept, 0], points[kept, 1], points[kept, 2] = x, y, z
        for i in range(10):
            quadrics[kept, i] += quadrics[gone, i]
        outgoing[gone] = -1
        alive -= 1
        spoke, ring_end = np.int64(outgoing[kept]), False
        while not ring_end:
            if not _grow_stale(spoke, twin, state):
                cost, x, y, z = _cost(spoke, state, points, quadrics, vertices, twin, mark, kind, valence, subset)
                if cost < np.inf:
                    state[spoke] = QUEUED
                    _enter(spoke, cost, ceiling, keys, edges, sizes)
            spoke, ring_end = _next_spoke(spoke, kept, vertices, twin, outgoing)
    highest[0] = ceiling
    return alive


@inner_kernel
def _grow_stale(h, twin, state):  # type: ignore[no-untyped-def]
    """Call the entries of edge `h` stale; False where it has none (it was refused before, or is new)."""
    queued = False
    for side in (h, np.int64(twin[h])):
        if side >= 0 and state[side] != IDLE:
            state[side] = STALE
            queued = True
    return queued


@inner_kernel
def _next_spoke(h, centre, vertices, twin, outgoing):  # type: ignore[no-untyped-def]
    """Return the next edge of `centre` counter-clockwise after `h`, and whether the round is over.

    On a boundary the last edge comes as the half-edge that runs towards the centre.
    """
    if vertices[h] != centre:
        return h, True
    back = preceding(h)
    if twin[back] < 0:
        return back, False
    ahead = np.int64(twin[back])
    return ahead, ahead == outgoing[centre]
