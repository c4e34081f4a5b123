"""Samples drawn to what faces like the surface: what bulges into a slit is drawn back to the slit's end.

What is nearest there are the slit's sides, to which the surface would be drawn apart, and go on crossing the slit.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.reverse import Samples
from subdfit.limit.curvature import unit
from subdfit.limit.surface import LimitSurface
from subdfit.target.normals import face_normals
from subdfit.target.target import Target

Floats = NDArray[np.float64]

ALIKE = 0.5
"""The surface faces like a part of the target where the cosine between both is as large as this."""
FARTHER = 5.0
"""Such a part is looked for up to so many times as far away as what is nearest."""


@dataclass(frozen=True, eq=False)
class AimedSamples(Samples):
    """Samples of a surface, each with its direction to the nearest part of the target that faces like the surface.

    That is what is nearest, but for samples where this faces elsewhere and another is not far. Made by `aim`; parts of
    them are samples as any.

    Attributes
    ----------
    farthest : how far away such a part may lie.
    """

    farthest: float = np.inf

    @classmethod
    def aim(cls, samples: Samples, surface: LimitSurface, target: Target, farthest: float) -> "AimedSamples":
        """Aim samples whose nearest points are known."""
        normals = surface.normals(samples.face, samples.uv)
        off = np.flatnonzero((_cosines(normals, target, samples.triangle) < ALIKE) & (samples.gap > 0))
        place = surface.evaluate(samples.face[off], samples.uv[off]).position
        distance = target.tree.closest(place, start=samples.triangle[off]).distance
        row, triangle = _nearest_alike(place, normals[off], target, np.minimum(FARTHER * distance, farthest))
        # The nearest point of the triangle that is named, not of all.
        found = target.tree.closest(place[row], start=triangle, enough=np.inf)
        normal, gap, near = samples.normal.copy(), samples.gap.copy(), samples.triangle.copy()
        normal[off[row]] = unit(target.on_triangles(triangle, found.uv) - place[row])
        # The faceting's allowance stays that of what is nearest: at the fold that ends a slit it is so large that what
        # is off in the slit would be let off.
        gap[off[row]] += found.distance - distance[row]
        near[off[row]] = triangle
        return cls(samples.face, samples.uv, normal, gap, near, farthest)

    def renewed(self, surface: LimitSurface, target: Target) -> "AimedSamples":
        """The same samples on a surface that has moved."""
        return AimedSamples.aim(super().renewed(surface, target), surface, target, self.farthest)


def _nearest_alike(
    places: Floats, normals: Floats, target: Target, radii: Floats
) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """The nearest triangle of the target that faces like each place within its radius: rows, (k,), and triangles."""
    begin, triangle, distance = target.tree.within(places, radii)
    row = np.repeat(np.arange(len(places)), np.diff(begin))
    alike = np.flatnonzero(_cosines(normals[row], target, triangle) >= ALIKE)
    alike = alike[np.lexsort((distance[alike], row[alike]))]
    alike = alike[np.diff(row[alike], prepend=-1) != 0]
    return row[alike], triangle[alike]


def _cosines(normals: Floats, target: Target, triangles: NDArray[np.int32]) -> Floats:
    """Cosines of the angles between unit vectors, (k, 3), and the normals of triangles of the target, (k,)."""
    return np.asarray(np.einsum("kd,kd->k", normals, face_normals(target.points, target.triangles[triangles])))
