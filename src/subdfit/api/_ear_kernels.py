"""Polygons lose one ear after the other until they are triangles."""

import numpy as np

from subdfit.compiled import inner_kernel, kernel

EDGE_ALREADY, NO_EAR, GONE = 2, 1, 4
"""What a corner's rank is made of: its diagonal is an edge already; it is no ear; it has been cut off."""


@kernel
def cut_ears(points, flat, offsets, corners, edges, triangles):  # type: ignore[no-untyped-def]
    """Cut polygons, and write their triangles in their order.

    An ear that is cut leaves all corners but its two neighbours as they were, so that a polygon of k corners takes
    k^2 steps (Meisters 1975; Eberly, Triangulation by ear clipping).

    Parameters
    ----------
    points : (n, 3) float64.
    flat : (c, 2) float64, each corner as seen along its polygon's normal, counter-clockwise.
    offsets, corners : the polygons, as in `MeshData`.
    edges : (e, 2) int64, the ends of all edges that are there already.
    triangles : (t, 3) int64, all that come out.
    """
    room = len(edges) + len(triangles)
    first, following, other = np.full(len(points), -1), np.empty(room, np.int64), np.empty(room, np.int64)
    for edge in range(len(edges)):
        _join(edge, edges[edge, 0], edges[edge, 1], first, following, other)
    edge, done = len(edges), 0
    for polygon in range(len(offsets) - 1):
        ring, outline = corners[offsets[polygon] : offsets[polygon + 1]], flat[offsets[polygon] : offsets[polygon + 1]]
        size = len(ring)
        before, after = np.arange(size) - 1, np.arange(size) + 1
        before[0], after[size - 1] = size - 1, 0
        reflex, rank, length = np.empty(size, np.bool_), np.empty(size, np.int64), np.empty(size)
        for at in range(size):
            reflex[at] = not _is_left(outline, before[at], at, after[at])
        for at in range(size):
            _judge(at, points, ring, outline, before, after, reflex, first, following, other, rank, length)
        for left in range(size, 2, -1):
            ear = 0
            for at in range(1, size):
                if rank[at] < rank[ear] or (rank[at] == rank[ear] and length[at] < length[ear]):
                    ear = at
            a, b = before[ear], after[ear]
            triangles[done, 0], triangles[done, 1], triangles[done, 2] = ring[a], ring[ear], ring[b]
            done += 1
            if left == 3:
                break
            _join(edge, ring[a], ring[b], first, following, other)
            edge += 1
            after[a], before[b], reflex[ear], rank[ear] = b, a, False, GONE
            reflex[a] = not _is_left(outline, before[a], a, b)
            reflex[b] = not _is_left(outline, a, b, after[b])
            _judge(a, points, ring, outline, before, after, reflex, first, following, other, rank, length)
            _judge(b, points, ring, outline, before, after, reflex, first, following, other, rank, length)


@inner_kernel
def _judge(at, points, ring, outline, before, after, reflex, first, following, other, rank, length):  # type: ignore[no-untyped-def]
    """Write the rank of a corner as an ear, the lowest is the best, and the square of its diagonal."""
    a, b = before[at], after[at]
    rank[at] = EDGE_ALREADY * _are_joined(ring[a], ring[b], first, following, other)
    rank[at] += NO_EAR * (reflex[at] or _covers_reflex(outline, a, at, b, reflex))
    length[at] = 0.0
    for axis in range(3):
        length[at] += (points[ring[b], axis] - points[ring[a], axis]) ** 2


@inner_kernel
def _covers_reflex(outline, a, at, b, reflex):  # type: ignore[no-untyped-def]
    """Whether a reflex corner lies inside the triangle at a corner; where any corner does, a reflex one does."""
    for k in range(len(outline)):
        if not reflex[k] or k in (a, at, b):
            continue
        if _is_left(outline, a, at, k) and _is_left(outline, at, b, k) and _is_left(outline, b, a, k):
            return True
    return False


@inner_kernel
def _is_left(outline, a, b, c):  # type: ignore[no-untyped-def]
    """Whether the corner c lies to the left of the line from a to b, and not on it."""
    # Two products are compared: their difference, contracted, would not be 0 on the line.
    along, across = outline[b, 0] - outline[a, 0], outline[b, 1] - outline[a, 1]
    return along * (outline[c, 1] - outline[a, 1]) > across * (outline[c, 0] - outline[a, 0])


@inner_kernel
def _join(edge, a, b, first, following, other):  # type: ignore[no-untyped-def]
    """Add an edge to those of its lower end."""
    low = min(a, b)
    other[edge], following[edge], first[low] = max(a, b), first[low], edge


@inner_kernel
def _are_joined(a, b, first, following, other):  # type: ignore[no-untyped-def]
    """Whether two vertices have an edge."""
    edge = first[min(a, b)]
    while edge >= 0 and other[edge] != max(a, b):
        edge = following[edge]
    return edge >= 0
