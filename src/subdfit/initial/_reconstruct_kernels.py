"""Greedy choice of Delaunay facets that make up a surface (Cohen-Steiner and Da 2004).

``space`` holds the points, the corners of facets, the facets at each point, and the facets' radii, as
`subdfit.initial.delaunay.Facets` says. The *front*, the boundary of the surface while it grows, is a set of loops
of points with the surface on their left. A point has one fan of triangles at all times, hence at most one front edge
that leaves it, and edges are called by that point. ``front[u]`` holds what is known of edge u:

``AFTER, BEFORE``  the next point of its loop, the point before
``HELD``           the facet of the surface along it
``FACET, APEX``    its candidate: the facet that would best continue the surface, and its third point; -1 for none
``WAITERS, NEXT``  the first of the edges that wait for point u, and the edge that waits after u for the same point

``state[u]`` tells where point u is, ``grade[u]`` how plausible the candidate is.
"""

import numpy as np

from subdfit.compiled import inner_kernel, kernel
from subdfit.initial._heap_kernels import put, take_out

AFTER, BEFORE, HELD, FACET, APEX, WAITERS, NEXT = 0, 1, 2, 3, 4, 5, 6
FREE, FRONT, INSIDE = 0, 1, 2

NONE = -np.inf
"""Grade of an edge without a candidate."""

NEW = np.inf
"""Grade of an edge whose candidate has not been looked for yet."""

SLIVER = np.cos(5.0 * np.pi / 6.0)
"""Cosine of the angle that bounds the fold between neighbours and the angles of a triangle at the front (section 3)."""

WEDGE = np.cos(np.pi / 6.0)
"""Cosine of the fold up to which only a candidate's radius decides (section 3.2)."""

JUMP = 5.0
"""Most that the radius may grow from a triangle to a candidate outside the wedge (section 4)."""

ALIKE = 1.0 + 1e-6
"""Ratio of radii up to which facets count as lying on one sphere."""


@inner_kernel
def _bend(points, u, v, w, b):  # type: ignore[no-untyped-def]
    """Cosine of the angle between the normals of triangles u v w and v u b."""
    e0, e1, e2 = points[v, 0] - points[u, 0], points[v, 1] - points[u, 1], points[v, 2] - points[u, 2]
    f0, f1, f2 = points[w, 0] - points[u, 0], points[w, 1] - points[u, 1], points[w, 2] - points[u, 2]
    g0, g1, g2 = points[b, 0] - points[u, 0], points[b, 1] - points[u, 1], points[b, 2] - points[u, 2]
    m0, m1, m2 = e1 * f2 - e2 * f1, e2 * f0 - e0 * f2, e0 * f1 - e1 * f0
    n0, n1, n2 = g1 * e2 - g2 * e1, g2 * e0 - g0 * e2, g0 * e1 - g1 * e0
    m, n = m0 * m0 + m1 * m1 + m2 * m2, n0 * n0 + n1 * n1 + n2 * n2
    return (m0 * n0 + m1 * n1 + m2 * n2) / np.sqrt(m * n)


@inner_kernel
def _wide(points, u, v, b):  # type: ignore[no-untyped-def]
    """Whether triangle u v b has an angle near 180 degrees at u or v."""
    e0, e1, e2 = points[v, 0] - points[u, 0], points[v, 1] - points[u, 1], points[v, 2] - points[u, 2]
    f0, f1, f2 = points[b, 0] - points[u, 0], points[b, 1] - points[u, 1], points[b, 2] - points[u, 2]
    g0, g1, g2 = points[b, 0] - points[v, 0], points[b, 1] - points[v, 1], points[b, 2] - points[v, 2]
    side = np.sqrt(e0 * e0 + e1 * e1 + e2 * e2)
    at_u = e0 * f0 + e1 * f1 + e2 * f2
    at_v = -(e0 * g0 + e1 * g1 + e2 * g2)
    return at_u <= SLIVER * side * np.sqrt(f0 * f0 + f1 * f1 + f2 * f2) or at_v <= SLIVER * side * np.sqrt(
        g0 * g0 + g1 * g1 + g2 * g2
    )


@inner_kernel
def _third(corners, facet, u, v):  # type: ignore[no-untyped-def]
    """The point of a facet besides `u` and `v`; -1 where one of them is no corner."""
    a, b, c = np.int64(corners[facet, 0]), np.int64(corners[facet, 1]), np.int64(corners[facet, 2])
    if (a == u or b == u or c == u) and (a == v or b == v or c == v):
        return a + b + c - u - v
    return np.int64(-1)


@inner_kernel
def _joined(u, v, space, surface):  # type: ignore[no-untyped-def]
    """Whether the surface has the edge u v."""
    _, corners, offsets, at, _ = space
    chosen, found = surface[0], False
    for k in range(offsets[u], offsets[u + 1]):
        found = found or (chosen[at[k]] and _third(corners, at[k], u, v) >= 0)
    return found


@inner_kernel
def _fits(u, v, b, space, surface):  # type: ignore[no-untyped-def]
    """Whether the facet across front edge u v with third point b can join and leave an oriented manifold.

    Where `b` is on the front but not next to the edge, it can only together with a twin.
    """
    points, corners = space[0], space[1]
    _, state, front = surface
    if state[b] != FRONT:
        return state[b] == FREE
    left, right = front[u, BEFORE] == b, front[v, AFTER] == b
    if left and _bend(points, b, u, _third(corners, front[b, HELD], b, u), v) <= SLIVER:
        return False
    if right and _bend(points, v, b, _third(corners, front[v, HELD], v, b), u) <= SLIVER:
        return False
    return (left or not _joined(u, b, space, surface)) and (right or not _joined(v, b, space, surface))


@inner_kernel
def _candidate(u, v, held, space, surface):  # type: ignore[no-untyped-def]
    """Find the facet of least radius across front edge u v of the surface's facet `held` (section 3).

    Of facets on one sphere, as grids of points have, the one that bends least.

    Returns
    -------
    facet, apex : the candidate and its point besides u and v; -1 where there is none.
    grade : 1 / radius within the wedge; below -1 outside, falling with the fold; `NONE` for none.
    """
    points, corners, offsets, at, radii = space
    state = surface[1]
    w = _third(corners, held, u, v)
    best, best_apex, straightest, least = np.int64(-1), np.int64(-1), -1.0, np.inf
    for k in range(offsets[u], offsets[u + 1]):
        facet = np.int64(at[k])
        b = _third(corners, facet, u, v)
        if b < 0 or facet == held or not radii[facet] <= ALIKE * least or state[b] == INSIDE or _wide(points, u, v, b):
            continue
        bend = _bend(points, u, v, w, b)
        plausible = bend > WEDGE or (bend > SLIVER and radii[facet] <= JUMP * radii[held])
        better = ALIKE * radii[facet] < least or bend > straightest
        if plausible and better and _fits(u, v, b, space, surface):
            best, best_apex, straightest, least = facet, b, bend, radii[facet]
    if best < 0:
        return best, best_apex, NONE
    return best, best_apex, 1.0 / least if straightest > WEDGE else straightest - 2.0


@inner_kernel
def _drop(u, surface, queue):  # type: ignore[no-untyped-def]
    """Forget the candidate of edge u, wherever it is queued or waits."""
    front = surface[2]
    take_out(u, *queue)
    b = front[u, APEX]
    if b >= 0 and front[b, WAITERS] == u:
        front[b, WAITERS] = front[u, NEXT]
    elif b >= 0:
        w = front[b, WAITERS]
        while w >= 0 and front[w, NEXT] != u:
            w = front[w, NEXT]
        if w >= 0:
            front[w, NEXT] = front[u, NEXT]
    front[u, NEXT], front[u, FACET], front[u, APEX] = -1, -1, -1


@inner_kernel
def _look_ahead(u, space, surface, queue):  # type: ignore[no-untyped-def]
    """Find the candidate of front edge u anew and queue it."""
    front, grade = surface[2], queue[0]
    _drop(u, surface, queue)
    front[u, FACET], front[u, APEX], grade[u] = _candidate(u, front[u, AFTER], front[u, HELD], space, surface)
    if grade[u] > NONE:
        put(u, *queue)


@inner_kernel
def _wait(u, surface, queue):  # type: ignore[no-untyped-def]
    """Set edge u aside until something changes at the apex of its candidate."""
    front = surface[2]
    take_out(u, *queue)
    b = front[u, APEX]
    front[u, NEXT] = front[b, WAITERS]
    front[b, WAITERS] = u


@inner_kernel
def _wake(b, surface, queue):  # type: ignore[no-untyped-def]
    """Queue the edges that waited for point b."""
    front = surface[2]
    u = front[b, WAITERS]
    front[b, WAITERS] = -1
    while u >= 0:
        put(u, *queue)
        ahead = front[u, NEXT]
        front[u, NEXT] = -1
        u = ahead


@inner_kernel
def _choose(a, b, c, facet, surface, triangles, count):  # type: ignore[no-untyped-def]
    """Make triangle a b c, which is `facet`, part of the surface."""
    surface[0][facet] = True
    triangles[count[0], 0], triangles[count[0], 1], triangles[count[0], 2] = a, b, c
    count[0] += 1


@inner_kernel
def _connect(u, v, held, surface, queue):  # type: ignore[no-untyped-def]
    """Make u v a front edge along facet `held`, to be looked at before anything else."""
    _, state, front = surface
    grade = queue[0]
    front[u, AFTER], front[v, BEFORE], front[u, HELD] = v, u, held
    state[u] = FRONT
    state[v] = FRONT
    grade[u] = NEW
    put(u, *queue)


@inner_kernel
def _start(seed, space, surface, queue, triangles, count):  # type: ignore[no-untyped-def]
    """Begin a surface at a facet of free points that continues within the wedge across all its sides."""
    corners, state = space[1], surface[1]
    a, b, d = np.int64(corners[seed, 0]), np.int64(corners[seed, 1]), np.int64(corners[seed, 2])
    for u, v in ((a, b), (b, d), (d, a)):
        if state[a] != FREE or state[b] != FREE or state[d] != FREE or _candidate(u, v, seed, space, surface)[2] < 0.0:
            return
    _choose(a, b, d, seed, surface, triangles, count)
    for u, v in ((a, b), (b, d), (d, a)):
        _connect(u, v, seed, surface, queue)


@inner_kernel
def _cover(u, space, surface, queue, triangles, count):  # type: ignore[no-untyped-def]
    """Add the candidate of edge u: to a free point, as an ear beside the edge, or into the last gap of a loop."""
    _, state, front = surface
    v, b, facet = front[u, AFTER], front[u, APEX], front[u, FACET]
    left = state[b] == FRONT and front[u, BEFORE] == b
    right = state[b] == FRONT and front[v, AFTER] == b
    _drop(u, surface, queue)
    _choose(v, u, b, facet, surface, triangles, count)
    if left:
        _drop(b, surface, queue)
    if right:
        _drop(v, surface, queue)
    if not left:
        _connect(u, b, facet, surface, queue)
    if not right:
        _connect(b, v, facet, surface, queue)
    state[u] = INSIDE if left else FRONT
    state[v] = INSIDE if right else FRONT
    state[b] = INSIDE if left and right else FRONT
    for p in (u, v, b):
        _wake(p, surface, queue)


@inner_kernel
def _twin(u, space, surface, queue):  # type: ignore[no-untyped-def]
    """The front edge at the apex of edge u's candidate whose own candidate shares a side with it; -1 for none.

    Added together they glue two stretches of the front and leave all points with one fan (section 3.1).
    """
    front, grade = surface[2], queue[0]
    v, b = front[u, AFTER], front[u, APEX]
    p, q = front[b, BEFORE], front[b, AFTER]
    ahead = front[b, APEX] == u and front[u, BEFORE] != q and _fits(b, q, u, space, surface)
    back = front[p, APEX] == v and front[v, AFTER] != p and _fits(p, b, v, space, surface)
    if ahead and (not back or grade[b] >= grade[p]):
        return b
    return p if back else np.int64(-1)


@inner_kernel
def _glue(u, twin, space, surface, queue, triangles, count):  # type: ignore[no-untyped-def]
    """Add the candidates of edges u and `twin`, which share a side."""
    front = surface[2]
    v, b, facet, other = front[u, AFTER], front[u, APEX], front[u, FACET], front[twin, FACET]
    end = front[twin, AFTER]
    _drop(u, surface, queue)
    _drop(twin, surface, queue)
    _choose(v, u, b, facet, surface, triangles, count)
    _choose(end, twin, u if twin == b else v, other, surface, triangles, count)
    if twin == b:
        _connect(b, v, facet, surface, queue)
        _connect(u, end, other, surface, queue)
    else:
        _connect(u, b, facet, surface, queue)
        _connect(twin, v, other, surface, queue)
    for p in (u, v, twin, end):
        _wake(p, surface, queue)


@kernel
def grow(seeds, points, corners, offsets, at, radii, state, triangles):  # type: ignore[no-untyped-def]
    """Grow a surface from each seed whose points are still free when its turn comes, until nothing plausible is left.

    Parameters
    ----------
    seeds : (s,) int64, facets in the order in which they are tried.
    points, corners, offsets, at, radii : the attributes of `Facets`.
    state : (n,) int8, all `FREE`; afterwards tells where each point ended.
    triangles : (k, 3) int64, filled from the top.

    Returns
    -------
    int : number of triangles.
    """
    n = len(state)
    space = (points, corners, offsets, at, radii)
    surface = (np.zeros(len(radii), np.bool_), state, np.full((n, 7), -1, np.int64))
    queue = (np.full(n, NONE), np.empty(n, np.int64), np.full(n, -1, np.int64), np.zeros(1, np.int64))
    front, heap, size = surface[2], queue[1], queue[3]
    count = np.zeros(1, np.int64)
    for seed in seeds:
        _start(seed, space, surface, queue, triangles, count)
        while size[0] > 0:
            u = heap[0]
            v, b = front[u, AFTER], front[u, APEX]
            if b < 0 or not _fits(u, v, b, space, surface):
                _look_ahead(u, space, surface, queue)
            elif state[b] == FREE or front[u, BEFORE] == b or front[v, AFTER] == b:
                _cover(u, space, surface, queue, triangles, count)
            else:
                twin = _twin(u, space, surface, queue)
                if twin >= 0:
                    _glue(u, twin, space, surface, queue, triangles, count)
                else:
                    _wait(u, surface, queue)
    return count[0]
