"""Triangles over a contour that face against its surface: control edges are chosen so that least of these is left.

What an edge stands for is a path on the surface. Seen along the normals of such paths a triangle is run round in its
own direction or in the other, as in the plane. Over a contour that is simple there, all run in their own direction if
and only if no two edges cross, so that the faces cover the surface once.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ring = list[int]

_STEEP = 0.25
"""Cosine between a triangle and the surface below which it is too steep; across the end of a tube it is near 0."""
_MOST = 256
"""Places of a contour up to which its triangles are looked at; they grow as the cube."""
_WEIGHT = 20.0
"""How many times more an area costs by which triangles are too steep, or face away, than one that is not covered."""

_BARRED = 1e3
"""Areas of the surface that an edge costs which is not possible."""


@dataclass(frozen=True)
class Facing:
    """How the triangles over a contour face.

    Attributes
    ----------
    along : (k, k, k) float32, area of the triangle of three places in cyclic order as seen along the surface's normal,
        negative where it faces away.
    cost : (k, k, k) float32, minus this area, and more where the triangle faces away or is steep.
    possible : (k, k) bool, places that an edge may join.
    area : of the surface.
    """

    along: NDArray[np.float32]
    cost: NDArray[np.float32]
    possible: Flags
    area: float

    @classmethod
    def of(cls, points: Floats, normals: Floats, possible: Flags, area: float) -> "Facing | None":
        """That of a contour, None where it has too many places.

        Parameters
        ----------
        points : (k, 3) float64, the control points at its places.
        normals : (k, k, 3) float64, of the surface along the path between two places; symmetric.
        possible : (k, k) bool.
        area : of the surface.
        """
        k = len(points)
        if k > _MOST:
            return None
        along, cost = np.empty((k, k, k), np.float32), np.empty((k, k, k), np.float32)
        for a in range(k):
            ahead = points - points[a]
            vector = np.cross(ahead[:, None], ahead[None]) / 2
            mean = normals[a][:, None] + normals[a][None] + normals
            mean /= np.maximum(np.linalg.norm(mean, axis=2, keepdims=True), 1e-300)
            along[a] = np.sum(vector * mean, axis=2)
            steep = np.maximum(_STEEP * np.linalg.norm(vector, axis=2) - along[a], 0.0)
            cost[a] = _WEIGHT * steep - along[a]
        return cls(along, cost, possible, area)

    def costs(self, ring: Ring, chords: list[tuple[int, int]]) -> Floats:
        """By how much cutting a ring between two of its places costs more than the best cut, (c,), chords (c, 2).

        Each side counts as its best triangulation, found by dynamic programming (Klincsek 1980). A triangulation with
        an edge that is not possible counts as worse than any without.
        """
        n, rows = len(ring), np.array(ring)
        barred = _BARRED * self.area
        least, first = np.zeros((n, n)), np.arange(n)
        for span in range(2, n):
            last = (first + span) % n
            between = (first[:, None] + np.arange(1, span)) % n
            found = least[first[:, None], between] + least[between, last[:, None]]
            found += self.cost[rows[:, None], rows[between], rows[last][:, None]]
            chord = self.possible[rows, rows[last]] | (span == n - 1)
            least[first, last] = found.min(axis=1) + np.where(chord, 0.0, barred)
        i, j = np.array(chords).T
        both = least[i, j] + least[j, i]
        return np.asarray(both - both.min())

    def fits(self, ring: Ring) -> bool:
        """Whether no corner of a ring, as a triangle with its neighbours, faces away."""
        corners = zip(ring[-1:] + ring[:-1], ring, ring[1:] + ring[:1], strict=True)
        return all(self.along[corner] >= 0.0 for corner in corners)
