"""Sheets of faces: matching at crowded edges, orientation, cutting vertices apart into fans."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from subdfit.mesh._polygons import Edges, Indices, Polygons
from subdfit.mesh._repair_kernels import merge_labels

Flags = NDArray[np.bool_]
Pairs = tuple[Indices, Indices]


def split_fans(faces: Polygons, pairs: Pairs, vertex_count: int) -> tuple[Polygons, Indices]:
    """Give every fan of faces a vertex of its own; faces hang together where `pairs` of half-edges say so.

    Returns
    -------
    faces : the fan with the lowest corner keeps the vertex, others get rows from `vertex_count` on.
    copied : the vertex that each new row is a copy of.
    """
    first, second = pairs
    opposite = faces.corners[first] != faces.corners[second]
    next_first, next_second = faces.following[first], faces.following[second]
    labels = merge_labels(
        np.concatenate((first, next_first)),
        np.concatenate((np.where(opposite, next_second, second), np.where(opposite, second, next_second))),
        len(faces.corners),
    )
    fans = np.flatnonzero(labels == np.arange(len(labels)))
    fan_vertex = faces.corners[fans]
    _, keepers = np.unique(fan_vertex, return_index=True)
    extra = np.ones(len(fans), np.bool_)
    extra[keepers] = False
    vertex_of = np.empty(len(labels), np.int64)
    vertex_of[fans] = fan_vertex
    vertex_of[fans[extra]] = vertex_count + np.arange(np.count_nonzero(extra))
    return Polygons(faces.offsets, vertex_of[labels]), fan_vertex[extra]


def orientation(faces: Polygons, edges: Edges) -> tuple[Flags, Flags]:
    """Decide which faces to turn so that neighbours agree; the fewer faces of a component are turned.

    Every face is taken twice, as it is and turned; copies that agree across an edge hang together
    (the oriented double cover). A component that can be oriented falls into two sheets.

    Returns
    -------
    turned : (m,) faces to turn.
    twisted : (m,) faces of components that cannot be oriented.
    """
    count = faces.count
    f, g = faces.face[edges.first], faces.face[edges.second]
    clash = (faces.corners[edges.first] == faces.corners[edges.second]) * count
    ends = np.concatenate((f, f + count)), np.concatenate((g + clash, g + count - clash))
    cover = coo_array((np.ones(2 * len(f), np.int8), ends), (2 * count, 2 * count))
    labels = connected_components(cover, directed=False)[1]
    plain, other = labels[:count], labels[count:]
    votes = np.bincount(plain, minlength=2 * count)
    turned = (votes[other] > votes[plain]) | ((votes[other] == votes[plain]) & (other < plain))
    return turned, plain == other


def twist_cut(faces: Polygons, edges: Edges, twisted: Flags) -> tuple[Flags, Flags]:
    """Orient the `twisted` faces along a breadth-first tree; what then disagrees is to be cut.

    Round every inner vertex an even number of edges disagrees, so that the cut runs on to the boundary or closes.

    Returns
    -------
    turned : (m,) faces to turn.
    cut : (p,) pairs of `edges` that still disagree.
    """
    f, g = faces.face[edges.first], faces.face[edges.second]
    clash = faces.corners[edges.first] == faces.corners[edges.second]
    links = np.concatenate((f, g)), np.concatenate((g, f))
    dual = coo_array((np.ones(2 * len(f)), links), (faces.count, faces.count)).tocsr()
    clashing = set(zip(f[clash].tolist(), g[clash].tolist(), strict=True))
    turned = np.zeros(faces.count, np.bool_)
    reached = ~twisted
    for seed in np.flatnonzero(twisted).tolist():
        if reached[seed]:
            continue
        order, before = breadth_first_order(dual, seed, directed=False)
        reached[order] = True
        for face in order[1:].tolist():
            parent = int(before[face])
            turned[face] = turned[parent] ^ ((face, parent) in clashing or (parent, face) in clashing)
    return turned, clash ^ turned[f] ^ turned[g]


def match_crowded(faces: Polygons, edges: Edges, points: NDArray[np.float64]) -> Pairs:
    """Pair faces at edges with more than two: of opposite direction, the flattest continuation first.

    `points` gives the position of each vertex of `faces`. Faces left over stay unpaired.
    """
    matched: list[tuple[int, int]] = []
    for group in edges.crowded:
        tails = faces.corners[group]
        a, b = points[tails.min()], points[max(tails.max(), faces.heads[group].max())]
        inward = [_inward(faces, h, points, a, b) for h in group]
        candidates = sorted(
            (float(inward[i] @ inward[j]), int(group[i]), int(group[j]))
            for i in range(len(group))
            for j in range(i + 1, len(group))
            if tails[i] != tails[j]
        )
        free = set(group.tolist())
        for _, first, second in candidates:
            if first in free and second in free:
                free -= {first, second}
                matched.append((first, second))
    rows = np.array(matched, np.int64).reshape(-1, 2)
    return np.ascontiguousarray(rows[:, 0]), np.ascontiguousarray(rows[:, 1])


def _inward(
    faces: Polygons, half_edge: int, points: NDArray[np.float64], a: NDArray[np.float64], b: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Unit vector from edge a b into the face, square to the edge; zero where there is none."""
    face = faces.face[half_edge]
    centre = points[faces.corners[faces.offsets[face] : faces.offsets[face + 1]]].mean(axis=0) - a
    along = b - a
    inward: NDArray[np.float64] = centre - along * (centre @ along) / max(along @ along, np.finfo(float).tiny)
    return inward / max(float(np.linalg.norm(inward)), np.finfo(float).tiny)
