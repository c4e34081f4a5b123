"""Changes that leave less of a control mesh: edges that collapse, faces that merge; and what each seems to cost."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from subdfit.limit.surface import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.polygon_edits import PolygonEdits, sides
from subdfit.mesh.topology import Topology

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]
Flags = NDArray[np.bool_]
Vertices = set[int]

TRIES = 2
"""Collapses of one vertex that are tried."""
MOST_CORNERS = 4
"""Corners of a face that two become."""
FOLDED = 0.5
"""Cosine of the angle by which the outline of a merged face may bend between its two halves."""


@dataclass(frozen=True)
class Change(ABC):
    """A change at the edge between two vertices, and what it seems to cost."""

    first: int
    second: int
    cost: float
    must_gain: ClassVar[bool] = False
    """Whether it is kept only where it brings the data nearer: a change that leaves no less of the mesh."""

    @abstractmethod
    def near(self, edits: PolygonEdits) -> set[int]:
        """Vertices of the faces that change."""

    @abstractmethod
    def make(self, edits: PolygonEdits) -> None:
        """Make the change."""

    def named(self, names: NDArray[np.int64]) -> "Change":
        """The same with other names of vertices, (n,)."""
        return replace(self, first=int(names[self.first]), second=int(names[self.second]))


class Collapse(Change):
    """The first vertex goes to the second."""

    def near(self, edits: PolygonEdits) -> set[int]:
        """Vertices of the faces round the first."""
        return edits.around(self.first)

    def make(self, edits: PolygonEdits) -> None:
        """Shrink the edge."""
        edits.collapse(self.first, self.second)


class BetweenFaces(Change, ABC):
    """A change of the two faces at the edge, and of no others."""

    def near(self, edits: PolygonEdits) -> set[int]:
        """Vertices of the two faces."""
        return {v for face in edits.faces_at(self.first) & edits.faces_at(self.second) for v in edits.rings[face]}


class Merge(BetweenFaces):
    """The faces on both sides of the edge become one."""

    def make(self, edits: PolygonEdits) -> None:
        """Remove the edge."""
        edits.merge(self.first, self.second)


@dataclass(frozen=True, eq=False)
class Polygons:
    """A control mesh with the limit points at its vertices, (n, 3), and the area normals of these polygons, (f, 3)."""

    edits: PolygonEdits
    limits: Floats
    normals: Floats

    @classmethod
    def of(cls, topology: Topology, edits: PolygonEdits, limits: Floats) -> "Polygons":
        """The polygons of a mesh open to edits."""
        ends = topology.face_vertices[topology.following]
        doubled = np.cross(limits[topology.face_vertices], limits[ends])
        return cls(edits, limits, np.add.reduceat(doubled, topology.face_offsets[:-1]))


def disjoint(edits: PolygonEdits, changes: list[Change]) -> list[Change]:
    """Those of the changes, first ones first, that have no vertex of their faces in common."""
    taken: set[int] = set()
    found = []
    for change in changes:
        near = change.near(edits)
        if not near & taken:
            taken |= near
            found.append(change)
    return found


def made(surface: LimitSurface, changes: list[Change]) -> tuple[ControlMesh, Rows, Flags]:
    """The control mesh with some changes, rows of its vertices before, (n,), and which are near each, (changes, n)."""
    edits = PolygonEdits(surface.control_mesh)
    near = np.zeros((len(changes), surface.topology.vertex_count), np.bool_)
    for flags, change in zip(near, changes, strict=True):
        flags[sorted(change.near(edits))] = True
    for change in changes:
        change.make(edits)
    mesh, rows = edits.frozen()
    return mesh, rows, near[:, rows]


def faces_made(topology: Topology, near: Flags) -> Flags:
    """The faces that changes make, (changes, f): those with two corners and more near each, (changes, n)."""
    corners = near[:, topology.face_vertices].astype(np.int64)
    return np.asarray(np.add.reduceat(corners, topology.face_offsets[:-1], axis=1) >= 2)


def collapses(polygons: Polygons, v: int, tried: Vertices) -> list[Change]:
    """The cheapest collapse of a vertex to one to which that was not tried, few in all."""
    if len(tried) >= TRIES:
        return []
    edits = polygons.edits
    possible = [w for w in sorted(edits.neighbours(v) - tried) if edits.may_collapse(v, w)]
    if not possible:
        return []
    costs = _collapse_costs(polygons, v, possible)
    return [Collapse(v, possible[k], float(costs[k])) for k in np.argsort(costs, kind="stable")[:1]]


def merges(polygons: Polygons, v: int, tried: Vertices) -> list[Change]:
    """Pairs of faces at edges from a vertex to later ones that become a convex quad, where that was not tried."""
    found, edits = [], polygons.edits
    for w in sorted(edits.neighbours(v) - tried):
        if v < w and edits.may_merge(v, w, MOST_CORNERS):
            cost = _merge_cost(polygons, v, w)
            found += [Merge(v, w, cost)] if np.isfinite(cost) else []
    return list[Change](found)


def _collapse_costs(polygons: Polygons, v: int, others: list[int]) -> Floats:
    """Squared distances of others from the planes of the faces round v and the lines of its creases, by area, (k,).

    Garland and Heckbert 1997, on limit points.
    """
    edits, limits = polygons.edits, polygons.limits
    steps = limits[others] - limits[v]
    normal = polygons.normals[sorted(edits.faces_at(v))]
    area = np.maximum(np.linalg.norm(normal, axis=1), 1e-300)
    total = np.sum((steps @ normal.T) ** 2 / area, axis=1)
    for u in sorted(edits.sharp_neighbours(v)):
        total += np.sum(np.cross(limits[u] - limits[v], steps) ** 2, axis=1)
    return np.asarray(total)


def _merge_cost(polygons: Polygons, v: int, w: int) -> float:
    """Squared sine of the angle between the two faces; infinite where the merged face is not convex."""
    edits, limits = polygons.edits, polygons.limits
    faces = sorted(edits.faces_at(v) & edits.faces_at(w))
    (one, other), (a, b) = (edits.rings[face] for face in faces), polygons.normals[faces]
    cosine = float(a @ b) / max(float(np.linalg.norm(a) * np.linalg.norm(b)), 1e-300)
    if cosine < FOLDED:
        return np.inf
    ring = limits[_outline(one, other)]
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    convex = np.all(np.cross(before, after) @ (a + b) > 0)
    return 1 - cosine**2 if convex else np.inf


def _outline(one: list[int], other: list[int]) -> list[int]:
    inner = set(sides(one)) & {side[::-1] for side in sides(other)}
    after = dict(side for side in [*sides(one), *sides(other)] if side not in inner and side[::-1] not in inner)
    ring = [min(after)]
    while after[ring[-1]] != ring[0]:
        ring.append(after[ring[-1]])
    return ring
