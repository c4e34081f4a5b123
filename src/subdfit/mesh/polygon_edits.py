"""Collapses and turns of edges and merges of faces that keep a polygon mesh an oriented manifold with its creases."""

from collections.abc import Iterable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology

Floats = NDArray[np.float64]
Ring = list[int]
Side = tuple[int, int]

MOST_FACES = 10
"""Most faces that a collapse leaves round a vertex."""
FEWEST_FACES = 3
"""Fewest faces round a vertex inside."""


def sides(ring: Ring) -> list[Side]:
    """The sides of a ring of vertices, in its direction."""
    return list(pairwise([*ring, ring[0]]))


class PolygonEdits:
    """Faces as rings of vertices, edited by the numbers of vertices and faces of the mesh they come from.

    Parameters
    ----------
    mesh
        The control mesh; its creases count as sharp for ever.
    """

    def __init__(self, mesh: ControlMesh) -> None:
        t = mesh.topology
        corners = t.face_vertices.tolist()
        self.rings: dict[int, Ring] = {k: corners[a:b] for k, (a, b) in enumerate(pairwise(t.face_offsets.tolist()))}
        self._mesh = mesh
        self._sharp = {frozenset(ends) for ends in t.edge_vertices[t.sharpness > 0].tolist()}
        self._corners = set(np.flatnonzero(t.corner_sharpness > 0).tolist())
        self._rim = set(np.flatnonzero(t.boundary_vertices).tolist())
        self._faces: dict[int, set[int]] = {v: set() for v in range(t.vertex_count)}
        for face, ring in self.rings.items():
            for v in ring:
                self._faces[v].add(face)

    def faces_at(self, v: int) -> set[int]:
        """Faces round a vertex."""
        return self._faces[v]

    def around(self, v: int) -> set[int]:
        """Vertices that share a face with one, itself among them."""
        return {u for face in self._faces[v] for u in self.rings[face]}

    def neighbours(self, v: int) -> set[int]:
        """Vertices joined to one by an edge."""
        return {u for face in self._faces[v] for side in sides(self.rings[face]) if v in side for u in side} - {v}

    def sharp_neighbours(self, v: int) -> set[int]:
        """Vertices joined to one by a sharp edge or one of the boundary."""
        return {u for u in self.neighbours(v) if frozenset((u, v)) in self._sharp}

    def may_collapse(self, v: int, w: int) -> bool:
        """Whether the edge between two neighbours may shrink to the second, so that the first is gone.

        The mesh stays a manifold (the link condition), creases stay curves between the same ends, and no vertex is left
        with fewer than three faces inside the mesh.
        """
        creases = self.sharp_neighbours(v)
        if v in self._corners or len(creases) not in (0, 2) or (creases and w not in creases):
            return False
        both = self._faces[v] & self._faces[w]
        shrunk = {face for face in both if len(self.rings[face]) == FEWEST_FACES}
        tips = {u for face in shrunk for u in self.rings[face]} - {v, w}
        if self.neighbours(v) & self.neighbours(w) != tips or self.around(v) & self.around(w) != (
            {u for face in both for u in self.rings[face]}
        ):
            return False
        if any({frozenset((u, v)), frozenset((u, w))} <= self._sharp for u in tips):
            return False
        left = {u: len(self._faces[u]) - 1 for u in tips}
        left[w] = len(self._faces[v] | self._faces[w]) - len(shrunk)
        if left[w] > max(MOST_FACES, len(self._faces[w])):
            return False
        return all(count >= (1 if u in self._rim else FEWEST_FACES) for u, count in left.items())

    def collapse(self, v: int, w: int) -> None:
        """Shrink the edge from v to w to w."""
        faces, self._faces[v] = self._faces[v], set()
        for face in sorted(faces):
            ring = self.rings[face]
            if w in ring:
                ring.remove(v)
                if len(ring) < FEWEST_FACES:
                    for u in ring:
                        self._faces[u].discard(face)
                    del self.rings[face]
            else:
                ring[ring.index(v)] = w
                self._faces[w].add(face)
        moved = {side for side in self._sharp if v in side}
        self._sharp = (self._sharp - moved) | {frozenset({*side} - {v} | {w}) for side in moved if w not in side}

    def may_merge(self, a: int, b: int, most_corners: int) -> bool:
        """Whether the two faces at the edge between a and b may become one."""
        return self._may_go(a, b) and len(self._outline(a, b)[0]) <= most_corners

    def merge(self, a: int, b: int) -> int:
        """Remove the edge between a and b; the face that is left."""
        one, other = sorted(self._faces[a] & self._faces[b])
        self.rings[one], gone = self._outline(a, b)[0], self.rings.pop(other)
        for u in gone:
            self._faces[u].discard(other)
            self._faces[u].add(one)
        return one

    def may_turn(self, a: int, b: int, forward: bool) -> bool:
        """Whether the edge between a and b may go round, see `turned`.

        Vertices keep as many faces as other edits leave them, and no two come to share a face beyond their edge.
        """
        if not self._may_go(a, b):
            return False
        ring, _ = self.turned(a, b, forward)
        one, other = self._faces[ring[0]], self._faces[ring[-1]]
        return one & other <= self._faces[a] & self._faces[b] and max(len(one), len(other)) < MOST_FACES

    def turned(self, a: int, b: int, forward: bool) -> tuple[Ring, Ring]:
        """What two faces become when the edge between a and b goes round by one vertex, forward or back.

        Both keep their numbers of corners. The new edge joins the first and the last vertex of the first ring.
        """
        loop, end = self._outline(a, b)
        if forward:
            return loop[1 : end + 2], [*loop[end + 1 :], *loop[:2]]
        return [*loop[-1:], *loop[:end]], loop[end - 1 :]

    def turn(self, a: int, b: int, forward: bool) -> None:
        """Let the edge between a and b go round."""
        rings = dict(zip(sorted(self._faces[a] & self._faces[b]), self.turned(a, b, forward), strict=True))
        for face in rings:
            for u in self.rings[face]:
                self._faces[u].discard(face)
        for face, ring in rings.items():
            self.rings[face] = ring
            for u in ring:
                self._faces[u].add(face)

    def _may_go(self, a: int, b: int) -> bool:
        """Whether the edge between a and b is smooth, its two faces meet in it alone, and its ends can do without."""
        both = self._faces[a] & self._faces[b]
        if frozenset((a, b)) in self._sharp or len(both) != 2:
            return False
        one, other = (self.rings[face] for face in both)
        if set(one) & set(other) != {a, b}:
            return False
        return all(len(self._faces[v]) > (1 if v in self._rim else FEWEST_FACES) for v in (a, b))

    def _outline(self, a: int, b: int) -> tuple[Ring, int]:
        """The ring round the two faces at an edge, from one end of it on, and where in it the other end comes."""
        one, other = (self.rings[face] for face in sorted(self._faces[a] & self._faces[b]))
        if (a, b) not in sides(one):
            a, b = b, a
        at, back = one.index(a), other.index(b)
        first, second = [*one[at + 1 :], *one[: at + 1]], [*other[back + 1 :], *other[: back + 1]]
        return first + second[1:-1], len(first) - 1

    def frozen(self) -> tuple[ControlMesh, NDArray[np.int64]]:
        """The control mesh that is left, and the row of each of its vertices in the first one."""
        rings = list(self.rings.values())
        used, rows = np.unique(np.concatenate(rings), return_inverse=True)
        number = {int(v): k for k, v in enumerate(used)}
        creases = [tuple(number[v] for v in sorted(side)) for side in self._sharp]
        topology = Topology.from_faces(
            np.concatenate([[0], np.cumsum([len(ring) for ring in rings])]),
            rows,
            len(used),
            crease_edges=np.array(sorted(creases), np.int64).reshape(-1, 2),
            corner_vertices=_rows_of(sorted(self._corners), number),
        )
        return ControlMesh(topology, self._mesh.points[used], self._mesh.scheme), used


def _rows_of(vertices: Iterable[int], number: dict[int, int]) -> NDArray[np.int64]:
    return np.array([number[v] for v in vertices], np.int64)
