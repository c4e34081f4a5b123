"""Ragged faces as plain arrays, before anything is known of their connectivity, and how their edges meet."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Polygons:
    """Faces that may be anything: degenerate, repeated, ill oriented. Corner ``h`` starts half-edge ``h``."""

    offsets: Indices
    corners: Indices

    @property
    def count(self) -> int:
        """Number of faces."""
        return len(self.offsets) - 1

    @cached_property
    def sizes(self) -> Indices:
        """Number of corners of each face, (m,)."""
        return np.diff(self.offsets)

    @cached_property
    def face(self) -> Indices:
        """Face of each corner, (h,)."""
        return np.repeat(np.arange(self.count), self.sizes)

    @cached_property
    def heads(self) -> Indices:
        """Vertex at which each half-edge ends, (h,)."""
        return self.corners[self.following]

    @cached_property
    def following(self) -> Indices:
        """Next corner round the face, (h,)."""
        following = np.arange(1, len(self.corners) + 1)
        filled = self.sizes > 0
        following[self.offsets[1:][filled] - 1] = self.offsets[:-1][filled]
        return following

    def select(self, kept: NDArray[np.bool_]) -> "Polygons":
        """Return the faces that `kept`, (m,), marks."""
        sizes = self.sizes[kept]
        return Polygons(np.concatenate(([0], np.cumsum(sizes))), self.corners[np.repeat(kept, self.sizes)])

    def extend(self, faces: list[list[int]]) -> "Polygons":
        """Return these faces and then `faces`."""
        offsets = np.cumsum([self.offsets[-1], *map(len, faces)])
        corners = np.array([corner for face in faces for corner in face], np.int64)
        return Polygons(np.concatenate((self.offsets, offsets[1:])), np.concatenate((self.corners, corners)))

    def turn(self, turned: NDArray[np.bool_]) -> "Polygons":
        """Return the faces with those that `turned`, (m,), marks run round the other way, from the same corner."""
        place = np.arange(len(self.corners)) - self.offsets[self.face]
        back = self.offsets[self.face] + (self.sizes[self.face] - place) % np.maximum(self.sizes[self.face], 1)
        source = np.where(turned[self.face], back, np.arange(len(self.corners)))
        return Polygons(self.offsets, self.corners[source])

    def by_size(self) -> list[tuple[Indices, Indices]]:
        """Return (rows, (rows, size) corners) for each number of corners, ascending."""
        if self.count and self.offsets[1] > 0 and (self.sizes == self.sizes[0]).all():
            return [(np.arange(self.count), self.corners.reshape(self.count, -1))]
        groups = []
        for size in np.unique(self.sizes):
            rows = np.flatnonzero(self.sizes == size)
            groups.append((rows, self.corners[self.offsets[rows, None] + np.arange(size)]))
        return groups


@dataclass(frozen=True)
class Edges:
    """How half-edges share edges, whatever their direction.

    Attributes
    ----------
    first, second : (p,) the two half-edges of each edge with two faces.
    boundary : (b,) half-edges of edges with one face.
    crowded : half-edges of each edge with more faces.
    """

    first: Indices
    second: Indices
    boundary: Indices
    crowded: list[Indices]


def edges_of(faces: Polygons) -> Edges:
    """Sort half-edges by their ends and see how many share each edge; edges from a vertex to itself do not count."""
    low, high = np.minimum(faces.corners, faces.heads), np.maximum(faces.corners, faces.heads)
    key = low * (int(high.max(initial=0)) + 1) + high
    order = np.argsort(key, kind="stable")
    if (low == high).any():
        order = order[(low != high)[order]]
    ordered = key[order]
    starts = np.flatnonzero(np.concatenate(([True], ordered[1:] != ordered[:-1])))[: len(ordered)]
    counts = np.diff(np.append(starts, len(ordered)))
    pairs, many = starts[counts == 2], np.flatnonzero(counts > 2)
    crowded = [order[start : start + count] for start, count in zip(starts[many], counts[many], strict=True)]
    return Edges(order[pairs], order[pairs + 1], order[starts[counts == 1]], crowded)
