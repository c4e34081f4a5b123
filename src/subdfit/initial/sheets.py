"""Where a coarse mesh mixes up sheets of the target: at strands, tongues and cracks a few tolerances wide.

From such a start the surface grows fins from one sheet to the other, as the other's points are the nearest ones, and no
later step mends them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.target.bvh import Closest
from subdfit.target.normals import face_normals
from subdfit.target.target import Target

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

SEGMENTS = 6
"""Samples of a triangle are the nodes inside it when its sides are cut in so many."""


@dataclass(frozen=True, eq=False)
class Sheets:
    """The sheets of a target that has a mesh.

    Attributes
    ----------
    target : the data.
    bound : the tolerance; sheets nearer than that need not be told apart.
    """

    target: Target
    bound: float

    def mixed(self, points: Floats, triangles: Rows, found: Closest) -> tuple[Floats, Rows]:
        """Places, (k, 3), where a coarse mesh faces against what is nearest, and its triangles there, (k,).

        Looked at from both sides: from the target's used points, `found` on the coarse mesh, and from samples of that.
        """
        normals = face_normals(points, triangles)
        used = self.target.used
        data = self._against(self.target.normals[used], normals[found.triangle], found.distance)
        samples, sampled = self._samples(points, triangles, normals)
        places = np.concatenate([self.target.points[used[data]], samples])
        return places, np.concatenate([found.triangle[data].astype(np.int64), sampled])

    def _samples(self, points: Floats, triangles: Rows, normals: Floats) -> tuple[Floats, Rows]:
        uv = np.array([(i, j) for i in range(1, SEGMENTS) for j in range(1, SEGMENTS - i)]) / SEGMENTS
        weights = np.column_stack([1 - uv.sum(axis=1), uv])
        samples = np.einsum("sc,tcd->tsd", weights, points[triangles]).reshape(-1, 3)
        triangle = np.repeat(np.arange(len(triangles)), len(uv))
        found = self.target.tree.closest(samples)
        nearest = face_normals(self.target.points, self.target.triangles[found.triangle])
        rows = self._against(normals[triangle], nearest, found.distance)
        return samples[rows], triangle[rows]

    def _against(self, normals: Floats, others: Floats, distance: Floats) -> Rows:
        """Rows of normals that face against others, farther than the tolerance away."""
        return np.flatnonzero((np.einsum("kd,kd->k", normals, others) < 0) & (distance > self.bound))
