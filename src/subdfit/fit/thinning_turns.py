"""Control edges that turn to follow the lines of curvature (Lavoué et al. 2007, equation 4, on a control mesh)."""

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.thinning_changes import FOLDED, BetweenFaces, Change, Polygons
from subdfit.limit.curvature import PrincipalCurvature, principal_curvature, unit
from subdfit.mesh.polygon_edits import PolygonEdits
from subdfit.target.curvature import ball_curvature, default_radius
from subdfit.target.features import edges_among, mesh_edges
from subdfit.target.target import Target

Floats = NDArray[np.float64]

GAIN = 10.0
"""Degrees by which an edge must follow the lines better when it has turned."""
SAMPLES = 8
"""Places at which an edge is compared with them."""
NO_DIRECTION = 45.0
"""Degrees that count where there are none."""
THIN = 0.05
"""Least sine of a corner of a face that a turn makes."""


@dataclass(frozen=True)
class Turn(BetweenFaces):
    """The edge goes round by one vertex of the two faces beside it, forward or back."""

    forward: bool
    must_gain: ClassVar[bool] = True

    def make(self, edits: PolygonEdits) -> None:
        """Turn the edge."""
        edits.turn(self.first, self.second, self.forward)


@dataclass(frozen=True, eq=False)
class Alignment:
    """A target's lines of curvature, and how well edges follow them.

    Attributes
    ----------
    target : a mesh.
    curvature : at the middles of its triangles, from what lies on the same side of its creases.
    """

    target: Target
    curvature: PrincipalCurvature

    @classmethod
    def of(cls, target: Target) -> "Alignment":
        """The lines of curvature of a target."""
        points, triangles = target.points, np.ascontiguousarray(target.triangles, np.int32)
        edges = mesh_edges(points, triangles)
        walls = edges_among(edges.vertices, target.crease_edges)
        every, radius = np.arange(len(triangles), dtype=np.int32), default_radius(points, edges)
        middles = points[triangles].mean(axis=1)
        radii = np.full(len(triangles), radius)
        return cls(target, principal_curvature(*ball_curvature(points, triangles, edges, middles, every, radii, walls)))

    @cached_property
    def _plain(self) -> NDArray[np.bool_]:
        """Triangles where the target has no lines of curvature."""
        return self.curvature.isotropic(self.target.diagonal)

    def degrees(self, begin: Floats, end: Floats) -> Floats:
        """Mean angles between chords, from (k, 3) to (k, 3), and the line of curvature that each follows better, (k,).

        45 counts where the target is flat or round.
        """
        share = ((np.arange(SAMPLES) + 0.5) / SAMPLES)[:, None]
        places = begin[:, None] * (1 - share) + end[:, None] * share
        rows = self.target.tree.closest(places.reshape(-1, 3)).triangle
        chord = np.repeat(unit(end - begin), SAMPLES, axis=0)
        plain = self._plain[rows]
        angles = []
        for direction in (self.curvature.minimum_direction, self.curvature.maximum_direction):
            cosine = np.abs(np.einsum("kx,kx->k", direction[rows], chord))
            angle = np.where(plain, NO_DIRECTION, np.degrees(np.arccos(np.minimum(cosine, 1.0))))
            angles.append(angle.reshape(-1, SAMPLES).mean(axis=1))
        return np.asarray(np.minimum(*angles))

    def turns(self, polygons: Polygons, v: int, tried: set[int]) -> list[Change]:
        """The best turn of an edge from a vertex to a later one, where that was not tried."""
        edits, limits = polygons.edits, polygons.limits
        others = [w for w in sorted(edits.neighbours(v) - tried) if v < w]
        found = []
        for w, forward in product(others, (True, False)):
            if edits.may_turn(v, w, forward):
                one, other = edits.turned(v, w, forward)
                if _fair(limits[one], limits[other]):
                    before, after = self.degrees(limits[[v, one[0]]], limits[[w, one[-1]]])
                    found += [Turn(v, w, float(after - before), forward)] if after < before - GAIN else []
        return list[Change](sorted(found, key=lambda turn: turn.cost)[:1])


def _fair(one: Floats, other: Floats) -> bool:
    """Whether two faces, rings of points, are convex and face much the same way."""
    normals = [np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0) for ring in (one - one[0], other - other[0])]
    first, second = unit(np.array(normals))
    return bool(first @ second >= FOLDED) and _convex(one, first) and _convex(other, second)


def _convex(ring: Floats, normal: Floats) -> bool:
    sides = unit(np.roll(ring, -1, axis=0) - ring)
    return bool(np.all(np.cross(np.roll(sides, 1, axis=0), sides) @ normal > THIN))
