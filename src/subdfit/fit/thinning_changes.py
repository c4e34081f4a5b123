"""Changes that leave less of a control mesh: edges that collapse, faces that merge; and what each seems to cost."""

from abc import ABC, abstractmethod
from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.mesh.polygon_edits import PolygonEdits, sides

Floats = NDArray[np.float64]
Pairs = set[tuple[int, int]]

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

    @abstractmethod
    def near(self, edits: PolygonEdits) -> set[int]:
        """Vertices of the faces that change."""

    @abstractmethod
    def make(self, edits: PolygonEdits) -> None:
        """Make the change."""

    def named(self, names: NDArray[np.int64]) -> tuple[int, int]:
        """The edge's ends by other names."""
        return int(names[self.first]), int(names[self.second])


class Collapse(Change):
    """The first vertex goes to the second."""

    def near(self, edits: PolygonEdits) -> set[int]:
        """Vertices of the faces round the first."""
        return edits.around(self.first)

    def make(self, edits: PolygonEdits) -> None:
        """Shrink the edge."""
        edits.collapse(self.first, self.second)


class Merge(Change):
    """The faces on both sides of the edge become one."""

    def near(self, edits: PolygonEdits) -> set[int]:
        """Vertices of the two faces."""
        return {v for face in edits.faces_at(self.first) & edits.faces_at(self.second) for v in edits.rings[face]}

    def make(self, edits: PolygonEdits) -> None:
        """Remove the edge."""
        edits.merge(self.first, self.second)


def collapses(edits: PolygonEdits, limits: Floats, tried: Pairs) -> list[Change]:
    """For each vertex the cheapest collapse that is possible and was not tried, few for each."""
    count = Counter(v for v, _ in tried)
    normals = {face: _normal(limits[ring]) for face, ring in edits.rings.items()}
    found: list[Change] = []
    for v in range(len(limits)):
        if count[v] < TRIES:
            possible = [w for w in sorted(edits.neighbours(v)) if (v, w) not in tried and edits.may_collapse(v, w)]
            costs = _collapse_costs(edits, limits, normals, v, possible)
            found += [Collapse(v, possible[k], float(costs[k])) for k in np.argsort(costs, kind="stable")[:1]]
    return found


def merges(edits: PolygonEdits, limits: Floats, tried: Pairs) -> list[Change]:
    """Pairs of faces that become a convex quad, flat ones first."""
    found: list[Change] = []
    for v in range(len(limits)):
        for w in sorted(edits.neighbours(v)):
            if v < w and (v, w) not in tried and edits.may_merge(v, w, MOST_CORNERS):
                cost = _merge_cost(edits, limits, v, w)
                found += [Merge(v, w, cost)] if np.isfinite(cost) else []
    return found


def _collapse_costs(
    edits: PolygonEdits, limits: Floats, normals: dict[int, Floats], v: int, others: list[int]
) -> Floats:
    """Squared distances of others from the planes of the faces round v and the lines of its creases, by area, (k,).

    Garland and Heckbert 1997, on limit points.
    """
    steps = limits[others] - limits[v]
    normal = np.array([normals[face] for face in sorted(edits.faces_at(v))])
    area = np.maximum(np.linalg.norm(normal, axis=1), 1e-300)
    total = np.sum((steps @ normal.T) ** 2 / area, axis=1)
    for u in sorted(edits.sharp_neighbours(v)):
        total += np.sum(np.cross(limits[u] - limits[v], steps) ** 2, axis=1)
    return np.asarray(total)


def _merge_cost(edits: PolygonEdits, limits: Floats, v: int, w: int) -> float:
    """Squared sine of the angle between the two faces; infinite where the merged face is not convex."""
    one, other = (edits.rings[face] for face in sorted(edits.faces_at(v) & edits.faces_at(w)))
    a, b = (_normal(limits[ring]) for ring in (one, other))
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


def _normal(ring: Floats) -> Floats:
    return np.asarray(np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0))
