"""What the steps of segmentation know of a mesh: areas, lengths, neighbours, which edges are sharp."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from subdfit.limit.curvature import principal_curvature
from subdfit.target.curvature import ball_curvature
from subdfit.target.features import Edges

Floats = NDArray[np.float64]
Labels = NDArray[np.int64]
Flags = NDArray[np.bool_]

FLAT = 0.05
"""Degrees across edges within a plane, as much as coordinates in single precision bend it."""


@dataclass(frozen=True)
class Facets:
    """A triangle mesh to be segmented.

    Attributes
    ----------
    points : (n, 3) float64.
    triangles : (m, 3) int32.
    edges : its `mesh_edges`.
    sharp : (e,) bool, the edges that are sharp.
    radius : of the balls over which curvature is averaged.
    """

    points: Floats
    triangles: NDArray[np.int32]
    edges: Edges
    sharp: Flags
    radius: float

    @cached_property
    def areas(self) -> Floats:
        """Area of each triangle, (m,)."""
        a, b, c = np.moveaxis(self.points[self.triangles], 1, 0)
        return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)

    @cached_property
    def centres(self) -> Floats:
        """Centre of each triangle, (m, 3)."""
        return np.asarray(self.points[self.triangles].mean(axis=1))

    @cached_property
    def lengths(self) -> Floats:
        """Length of each edge, (e,)."""
        ends = self.points[self.edges.vertices]
        return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))

    @cached_property
    def diagonal(self) -> float:
        """Diagonal of the bounding box."""
        return float(np.linalg.norm(np.ptp(self.points[self.triangles.ravel()], axis=0)))

    @cached_property
    def inner(self) -> NDArray[np.int64]:
        """Edges between two triangles, row numbers."""
        return np.flatnonzero(self.edges.valence == 2)

    def curvature(self, borders: Flags | None = None) -> tuple[Floats, Floats]:
        """Principal curvatures (m, 2) at the centres, and directions (m, 2, 3).

        Balls stop at sharp edges, and at `borders` (e,) if given.
        """
        seeds = np.arange(len(self.triangles), dtype=np.int32)
        radii = np.full(len(seeds), self.radius)
        found = principal_curvature(
            *ball_curvature(self.points, self.triangles, self.edges, self.centres, seeds, radii, self.sharp, borders)
        )
        values = np.stack([found.minimum, found.maximum], axis=1)
        return values, np.stack([found.minimum_direction, found.maximum_direction], axis=1)

    def borders(self, labels: Labels) -> Flags:
        """Edges whose two triangles have different labels, (e,) bool."""
        between = np.zeros(len(self.lengths), np.bool_)
        sides = labels[self.edges.faces[self.inner]]
        between[self.inner] = sides[:, 0] != sides[:, 1]
        return between

    def width(self, member: Flags) -> float:
        """Width of the strip that has the area and the perimeter of the triangles marked, (m,) bool."""
        sides = np.bincount(self.edges.of_face[member].ravel(), minlength=len(self.lengths))
        return float(2 * self.areas[member].sum() / max(self.lengths[sides == 1].sum(), np.finfo(float).tiny))

    def connected(self, joined: Flags) -> Labels:
        """Number the parts that triangles form when they are joined across the edges marked, (e,) bool."""
        pairs = self.edges.faces[joined & (self.edges.valence == 2)]
        count = len(self.triangles)
        links = coo_array((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
        return np.asarray(connected_components(links, directed=False)[1], np.int64)
