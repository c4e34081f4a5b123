"""Curves along edges: creases and boundaries as chains of vertices between corners."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

_CORNER, _CONTRAST, _STRAIGHT, _STRAYS = 45.0, 4.0, 3, 0.5
"""A boundary has a corner where it turns by so many degrees, and by so many times less at so many points to each side;
but none of a loop of whose turns of so many degrees more than the last share are no corners: it is ragged."""
TURNING = 0.5
"""Where the directions of the edges before and after a point add up to less, it is one where a curve turns back."""


@dataclass(frozen=True)
class Curve:
    """A chain of vertices along edges.

    Attributes
    ----------
    vertices : (k,) int64, rows of the points; a closed curve does not repeat its first vertex. An open
        curve may begin and end at the same vertex, where others meet it.
    closed : whether the last vertex is joined to the first.
    """

    vertices: NDArray[np.int64]
    closed: bool

    @property
    def edges(self) -> NDArray[np.int64]:
        """The edges (k, 2) int64, or one fewer if open, in the curve's direction."""
        pairs: NDArray[np.int64] = np.stack([self.vertices, np.roll(self.vertices, -1)], axis=1)
        return pairs if self.closed else pairs[:-1]


@dataclass(frozen=True)
class _Turns:
    """How a boundary turns at its points, (n,), and in a last row, (n + 1,), to which -1 leads, that stands for none.

    Attributes
    ----------
    after, before : the next point and the last along its direction, -1 for none.
    alone : (k,) int64, points through which it runs once; elsewhere there is no axis, and 180 degrees.
    axis : (n + 1, 3), the direction about which it turns.
    degrees : by which it turns.
    """

    after: NDArray[np.int64]
    before: NDArray[np.int64]
    alone: NDArray[np.int64]
    axis: NDArray[np.float64]
    degrees: NDArray[np.float64]

    @classmethod
    def along(cls, points: NDArray[np.float64], edges: NDArray[np.integer]) -> "_Turns":
        """Those of directed edges (b, 2) between points (n, 3)."""
        count = len(points)
        after, before = np.full(count + 1, -1, np.int64), np.full(count + 1, -1, np.int64)
        after[edges[:, 0]], before[edges[:, 1]] = edges[:, 1], edges[:, 0]
        ends = np.bincount(edges.ravel(), minlength=count + 1)
        alone = np.flatnonzero((ends == 2) & (after >= 0) & (before >= 0))
        coming, going = points[alone] - points[before[alone]], points[after[alone]] - points[alone]
        axis, degrees = np.zeros((count + 1, 3)), np.full(count + 1, 180.0)
        axis[alone] = np.cross(coming, going)
        across = np.linalg.norm(axis[alone], axis=1)
        degrees[alone] = np.degrees(np.arctan2(across, np.einsum("kd,kd->k", coming, going)))
        return cls(after, before, alone, axis, degrees)


def boundary_edges(triangles: NDArray[np.integer]) -> NDArray[np.int64]:
    """Edges that belong to one triangle, (b, 2) int64, each in its triangle's direction."""
    sides = np.asarray(triangles, np.int64)[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    ends = np.sort(sides, axis=1)
    key = ends[:, 0] * (int(sides.max(initial=0)) + 1) + ends[:, 1]
    _, first, valence = np.unique(key, return_index=True, return_counts=True)
    single: NDArray[np.int64] = sides[np.sort(first[valence == 1])]
    return single


def boundary_corners(points: NDArray[np.float64], edges: NDArray[np.integer]) -> NDArray[np.int64]:
    """Points, (c,) int64 ascending, at which a boundary that is straight or smooth on both sides turns sharply.

    Parameters
    ----------
    points : (n, 3) float64.
    edges : (b, 2) int, rows of `points`: the boundary, directed.
    """
    count = len(points)
    rim = _Turns.along(points, edges)
    turn = rim.degrees
    sharp = rim.alone[turn[rim.alone] >= _CORNER]
    corners = sharp
    for neighbour in (rim.after, rim.before):
        at = corners
        for _ in range(_STRAIGHT):
            at = neighbour[at]
            kept = _CONTRAST * turn[at] <= turn[corners]
            corners, at = corners[kept], at[kept]
    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
    loop = connected_components(graph, directed=False)[1]
    turns, found = (np.bincount(loop[at], minlength=count) for at in (sharp, corners))
    return corners[found[loop[corners]] >= (1 - _STRAYS) * turns[loop[corners]]]


def zigzag(points: NDArray[np.float64], edges: NDArray[np.integer]) -> NDArray[np.int64]:
    """Points, (z,) int64 ascending, of a boundary in a zigzag, as a cut along the edges of a mesh leaves it.

    They and three to each side are sharp turns, each to the other side than the one before: round the prongs of a comb
    two go the same way. Arguments as in `boundary_corners`.
    """
    rim = _Turns.along(points, edges)
    sharp, after = rim.degrees >= _CORNER, rim.after
    opposed = sharp & sharp[after] & (np.einsum("kd,kd->k", rim.axis, rim.axis[after]) < 0)
    between = opposed & opposed[rim.before]
    found = between
    for neighbour in (after, rim.before):
        at = neighbour
        for _ in range(_STRAIGHT - 1):
            found = found & between[at]
            at = neighbour[at]
    return np.flatnonzero(found)


def directions(points: NDArray[np.float64], edges: NDArray[np.integer]) -> NDArray[np.float64]:
    """Unit directions, (n, 3), in which directed edges (e, 2) run at points (n, 3).

    Zero where a curve turns back, and at points of none.
    """
    found = np.zeros_like(points)
    np.add.at(found, edges, _units(points[edges[:, 1]] - points[edges[:, 0]], 0.0)[:, None])
    return _units(found, TURNING)


def _units(vectors: NDArray[np.float64], shortest: float) -> NDArray[np.float64]:
    """Unit vectors, (k, 3); zero for those that are no longer than the shortest."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > shortest))


def boundary_loops(triangles: NDArray[np.integer]) -> list[Curve]:
    """Boundary of a triangle mesh as curves, its triangles on the left; closed wherever it is manifold."""
    return curves(boundary_edges(triangles))


def curves(edges: NDArray[np.integer]) -> list[Curve]:
    """Chain edges to curves, split where other than two edges meet.

    A curve takes the direction of its first edge.

    Parameters
    ----------
    edges : (e, 2) int, each edge once.

    Returns
    -------
    The open curves in order of their first vertex, then the closed ones.
    """
    edges = np.asarray(edges, np.int64).reshape(-1, 2)
    if len(edges) == 0:
        return []
    vertex, side = edges.ravel(), np.arange(edges.size)
    side = side[np.argsort(vertex, kind="stable")]
    _, first, degree = np.unique(vertex[side], return_index=True, return_counts=True)
    smooth = degree == 2
    pairs = side[first[smooth, None] + [0, 1]]
    joined = np.full(edges.size, -1)
    joined[pairs[:, 0]], joined[pairs[:, 1]] = pairs[:, 1], pairs[:, 0]
    return _walk(edges, joined)


def _walk(edges: NDArray[np.int64], joined: NDArray[np.int64]) -> list[Curve]:
    """Follow edge ends: end ``s`` is ``edges.ravel()[s]``, ``s ^ 1`` the other end, `joined` the next edge's."""
    vertex, link = edges.ravel().tolist(), joined.tolist()
    visited = [False] * len(edges)
    starts = np.flatnonzero(joined < 0)
    # An edge leaves its even end: a curve begins there if it can, and so keeps the edges' direction.
    open_starts = starts[np.lexsort((starts, starts % 2))]
    every = np.arange(0, edges.size, 2)
    closed_starts = every[np.argsort(edges[:, 0], kind="stable")]
    chains: dict[bool, list[Curve]] = {False: [], True: []}
    for start in [*open_starts.tolist(), *closed_starts.tolist()]:
        if visited[start // 2]:
            continue
        chain, end = [vertex[start]], start
        while end >= 0 and not visited[end // 2]:
            visited[end // 2] = True
            chain.append(vertex[end ^ 1])
            end = link[end ^ 1]
        closed = end >= 0
        chains[closed].append(Curve(np.array(chain[:-1] if closed else chain), closed))
    chains[False].sort(key=lambda curve: tuple(curve.vertices[:2].tolist()))
    return chains[False] + chains[True]
