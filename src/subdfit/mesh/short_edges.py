"""Edges of a triangle mesh shorter than a length, shrunk to points, the shortest first."""

import heapq
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Coarsened:
    """A triangle mesh with fewer vertices.

    Attributes
    ----------
    points : (k, 3) float64, each a mean of the vertices that it took in.
    triangles : (j, 3) int32, rows of `points`.
    rows : (j,) int64, which triangle of the first mesh each was.
    merged : (n,) int64, the row of `points` for each vertex of the first mesh; -1 for those of no triangle.
    """

    points: Floats
    triangles: NDArray[np.int32]
    rows: Indices
    merged: Indices

    def edges(self, ends: Indices) -> Indices:
        """What is left of edges of the first mesh, (e, 2): those whose ends have not become one."""
        found = np.sort(self.merged[ends], axis=1)
        return np.unique(found[found[:, 0] < found[:, 1]], axis=0)


def without_short_edges(points: Floats, triangles: NDArray[np.integer], least: float, weights: Floats) -> Coarsened:
    """Shrink edges to the weighted mean of what their ends took in, while one is shorter than `least` that may go.

    The result is a manifold with the same boundaries, holes and handles (the link condition: Dey, Edelsbrunner, Guha,
    Nekhayev, "Topology preserving edge contraction", 1999).

    Parameters
    ----------
    points : (n, 3) float64.
    triangles : (m, 3) int, rows of `points`, oriented alike, at most two an edge.
    least : in the unit of the points.
    weights : (n,) float64, with which vertices count in means.
    """
    mesh = _Shrinking(points, triangles, weights)
    ends = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    length = np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1)
    short = length < least
    queue = [(far, a, b) for far, (a, b) in zip(length[short].tolist(), ends[short].tolist(), strict=True)]
    heapq.heapify(queue)
    while queue:
        far, a, b = heapq.heappop(queue)
        # Ends that have moved were queued anew.
        if mesh.faces[a] and mesh.faces[b] and far == mesh.distance(a, b) and mesh.may_shrink(a, b):
            mesh.shrink(a, b)
            for v in sorted(mesh.around(a) - {a}):
                if mesh.distance(a, v) < least:
                    heapq.heappush(queue, (mesh.distance(a, v), min(a, v), max(a, v)))
    return mesh.frozen()


class _Shrinking:
    """A triangle mesh whose edges shrink one by one; vertices and triangles keep their rows."""

    def __init__(self, points: Floats, triangles: NDArray[np.integer], weights: Floats) -> None:
        self.points = points.copy()
        self.weight = weights.copy()
        self.into = np.arange(len(points))
        self.corners: dict[int, list[int]] = dict(enumerate(triangles.tolist()))
        self.faces: list[set[int]] = [set() for _ in points]
        for face, corners in self.corners.items():
            for v in corners:
                self.faces[v].add(face)

    def distance(self, a: int, b: int) -> float:
        return float(np.linalg.norm(self.points[a] - self.points[b]))

    def around(self, v: int) -> set[int]:
        """A vertex and its neighbours."""
        return {u for face in self.faces[v] for u in self.corners[face]}

    def may_shrink(self, a: int, b: int) -> bool:
        """Whether two vertices are neighbours, and what is left without their edge is a manifold of the same kind."""
        both = self.faces[a] & self.faces[b]
        one, other = self.around(a), self.around(b)
        if len(one & other) != len(both) + 2 or one == other:
            return False
        # On the boundary a vertex has one face fewer than neighbours.
        inside = [len(near) - 1 == len(self.faces[v]) for v, near in ((a, one), (b, other))]
        return len(both) == 1 or (len(both) == 2 and any(inside))

    def shrink(self, kept: int, gone: int) -> None:
        total = self.weight[kept] + self.weight[gone]
        share = self.weight[gone] / total
        self.points[kept] += share * (self.points[gone] - self.points[kept])
        self.weight[kept], self.into[gone] = total, kept
        for face in self.faces[kept] & self.faces[gone]:
            for v in self.corners.pop(face):
                self.faces[v].discard(face)
        for face in self.faces[gone]:
            corners = self.corners[face]
            corners[corners.index(gone)] = kept
        self.faces[kept] |= self.faces[gone]
        self.faces[gone] = set()

    def frozen(self) -> Coarsened:
        while not np.array_equal(self.into, self.into[self.into]):
            self.into = self.into[self.into]
        corners = np.array(list(self.corners.values()), np.int64)
        used, triangles = np.unique(corners, return_inverse=True)
        number = np.full(len(self.points), -1)
        number[used] = np.arange(len(used))
        rows = np.fromiter(self.corners, np.int64, len(self.corners))
        return Coarsened(self.points[used], triangles.reshape(-1, 3).astype(np.int32), rows, number[self.into])
