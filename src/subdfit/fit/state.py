"""Where a fit stands: the surface, every data point's footpoint, the errors."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from subdfit.closest.curves import CurveProjection, SurfaceCurves
from subdfit.closest.projection import Projection, Projector
from subdfit.fit.changes import changed_cells
from subdfit.fit.data import FitData
from subdfit.fit.places import Places
from subdfit.limit._kernels import order_by_cell
from subdfit.limit.surface import LimitSurface
from subdfit.measure import far_points, outliers
from subdfit.measure.facing import AWAY

Floats = NDArray[np.float64]

FOOTPOINT_TOLERANCE = 1e-6
"""Footpoints are settled to this share of the diagonal while fitting."""


@dataclass(frozen=True)
class Errors:
    """One-sided errors of the vertices that are not left out, as shares of the diagonal.

    `excess` is the largest that the tolerance applies to: it counts samples inside faces too, each less its allowance.
    """

    max: float
    rms: float
    mean: float
    excess: float


@dataclass(frozen=True, eq=False)
class FitState:
    """A surface with the footpoints of all data.

    Attributes
    ----------
    surface : the limit surface, in the normalised frame.
    face, uv, distance : (k,), (k, 2), (k,), footpoints of all points on the surface.
    boundary, crease : footpoints of the points on curves, None where there are none.
    """

    data: FitData
    surface: LimitSurface
    face: NDArray[np.int32]
    uv: Floats
    distance: Floats
    boundary: CurveProjection | None
    crease: CurveProjection | None
    curves: tuple[SurfaceCurves | None, SurfaceCurves | None] = field(repr=False, default=(None, None))

    @classmethod
    def start(cls, data: FitData, surface: LimitSurface) -> "FitState":
        """Find all footpoints from nothing."""
        found = Projector(surface, FOOTPOINT_TOLERANCE).nearest(data.points)
        return cls._complete(data, surface, found)

    @classmethod
    def follow(cls, data: FitData, surface: LimitSurface, face: NDArray[np.int32], uv: Floats) -> "FitState":
        """Find footpoints from given places on the surface."""
        return cls._complete(data, surface, Projector(surface, FOOTPOINT_TOLERANCE).refine(data.points, face, uv))

    @classmethod
    def _complete(cls, data: FitData, surface: LimitSurface, found: Projection) -> "FitState":
        return cls(data, surface, found.face, found.uv, found.distance, None, None).with_curves_of(surface)

    def _with_curves(self, curves: tuple[SurfaceCurves | None, SurfaceCurves | None]) -> "FitState":
        data = self.data
        found = [
            curve.closest(data.points[rows], along, data.bound) if curve is not None and len(curve) else None
            for curve, rows, along in zip(curves, (data.boundary, data.crease), (data.along, None), strict=True)
        ]
        return replace(self, boundary=found[0], crease=found[1], curves=curves)

    def with_curves_of(self, surface: LimitSurface) -> "FitState":
        """The same footpoints on the surface, those on curves found anew on `surface`."""
        return self._with_curves(
            (
                SurfaceCurves(surface, inner=False) if len(self.data.boundary) else None,
                SurfaceCurves(surface, inner=True) if len(self.data.crease) else None,
            )
        )

    def moved(self, control_points: Floats) -> "FitState":
        """The same connectivity with other control points; footpoints follow from where they were."""
        return FitState.follow(self.data, self.surface.with_points(control_points), self.face, self.uv)

    def onto(self, surface: LimitSurface, face: NDArray[np.int32], uv: Floats) -> "FitState":
        """All points on a surface that differs in parts, from given places; these are exact where it does not."""
        projector = Projector(surface, FOOTPOINT_TOLERANCE)
        order = projector.order(face)
        rows = order[changed_cells(self.surface, surface)[face[order]]]
        found = projector.refine(self.data.points, face, uv, rows)
        distance = self.distance.copy()
        distance[rows] = found.distance[rows]
        return replace(self, surface=surface, face=found.face, uv=found.uv, distance=distance).with_curves_of(surface)

    def rows_in(self, cells: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Rows of the points with a footpoint, on the surface or a curve, in the flagged cells."""
        keep = cells[self.face]
        for found, rows in ((self.boundary, self.data.boundary), (self.crease, self.data.crease)):
            if found is not None:
                keep[rows[cells[found.face]]] = True
        return np.flatnonzero(keep)

    def _part(self, rows: NDArray[np.int64]) -> tuple["FitState", NDArray[np.int64]]:
        """The state of some points, rows ascending."""
        if len(rows) == len(self.face):
            return self, rows
        boundary, crease = (
            None if found is None else found[np.isin(at, rows)]
            for found, at in ((self.boundary, self.data.boundary), (self.crease, self.data.crease))
        )
        some = replace(self, data=self.data.subset(rows), boundary=boundary, crease=crease)
        return replace(some, face=self.face[rows], uv=self.uv[rows], distance=self.distance[rows]), rows

    def thinned(self, most: int) -> tuple["FitState", NDArray[np.int64]]:
        """The state of fewer points, evenly chosen, and of all points on curves; and their rows.

        A face keeps at most `most` points for each triangle that it could be cut into.
        """
        topology = self.surface.topology
        order = order_by_cell(self.face, self.surface.domain.face_count)
        face = Places(self.surface).face[self.face[order]]
        count = np.bincount(face, minlength=topology.face_count)
        rank = np.arange(len(face)) - (np.cumsum(count) - count)[face]
        share = np.minimum(most * (np.diff(topology.face_offsets) - 2), count)[face]
        keep = self.data.on_curves
        keep[order[(rank + 1) * share // count[face] > rank * share // count[face]]] = True
        return self._part(np.flatnonzero(keep))

    def followed(self, some: "FitState", rows: NDArray[np.int64]) -> "FitState":
        """All points on the surface of `some`, whose `rows` know their footpoints already."""
        face, uv, distance = self.face.copy(), self.uv.copy(), self.distance.copy()
        face[rows], uv[rows], distance[rows] = some.face, some.uv, some.distance
        return replace(self, distance=distance).onto(some.surface, face, uv)

    def refreshed(self, threshold: float) -> "FitState":
        """Look globally for nearer footpoints of the points farther than `threshold`.

        Of two sheets of a thin part or crack the other may be nearer; a point goes over to it only where that lies
        within the threshold. Else it would draw the other sheet across; but points on curves are held by these.
        """
        rows = np.flatnonzero(self.distance > threshold)
        if len(rows) == 0:
            return self
        found = Projector(self.surface, FOOTPOINT_TOLERANCE).nearest(self.data.points[rows])
        better = found.distance < self.distance[rows]
        astray = self._facing(rows, self.face[rows], self.uv[rows]) < AWAY
        free = ~self.data.surface_rows[rows] | (found.distance <= threshold)
        better &= free | astray | (self._facing(rows, found.face, found.uv) >= AWAY)
        face, uv, distance = self.face.copy(), self.uv.copy(), self.distance.copy()
        face[rows[better]] = found.face[better]
        uv[rows[better]] = found.uv[better]
        distance[rows[better]] = found.distance[better]
        return replace(self, face=face, uv=uv, distance=distance)

    def assured(self, threshold: float) -> "FitState":
        """Footpoints of points farther than `threshold` found for certain: descent may end where none is nearest."""
        rows = np.flatnonzero(self.distance > threshold)
        if len(rows) == 0:
            return self
        found = Projector(self.surface, FOOTPOINT_TOLERANCE).certain(self.data.points[rows])
        nearer = found.distance < self.distance[rows]
        face, uv, distance = self.face.copy(), self.uv.copy(), self.distance.copy()
        face[rows[nearer]], uv[rows[nearer]] = found.face[nearer], found.uv[nearer]
        distance[rows[nearer]] = found.distance[nearer]
        return replace(self, face=face, uv=uv, distance=distance)

    def _facing(self, rows: NDArray[np.int64], face: NDArray[np.int32], uv: Floats) -> Floats:
        """Cosine between the normals of some data and of the surface at given places, (k,)."""
        return np.asarray(np.einsum("kd,kd->k", self.surface.normals(face, uv), self.data.normals[rows]))

    def verified(self) -> "FitState":
        """All footpoints found globally, from no earlier parameter."""
        return FitState._complete(
            self.data, self.surface, Projector(self.surface, FOOTPOINT_TOLERANCE).certain(self.data.points)
        )

    @property
    def excess(self) -> Floats:
        """What the tolerance applies to, (k,): distances less their allowance."""
        return self.distance - self.data.allowance

    @property
    def errors(self) -> Errors:
        """Errors of the vertices."""
        d = self.distance[: self.data.vertices]
        d = d[np.isfinite(self.data.allowance[: self.data.vertices])]
        return Errors(
            float(d.max()), float(np.sqrt(np.mean(d**2))), float(d.mean()), float(self.excess.max(initial=0.0))
        )

    @property
    def held(self) -> tuple[CurveProjection | None, CurveProjection | None]:
        """The footpoints on boundary and creases that the tolerance applies to; a cloud's boundary is too ragged."""
        return (None if self.data.target.cloud else self.boundary), self.crease

    @property
    def curve_distances(self) -> Floats:
        """Distances of boundary and crease points from their curves, where the tolerance applies to them."""
        parts = [c.distance for c in self.held if c is not None]
        return np.concatenate([np.empty(0), *parts])

    def excusing(self, share: float, bound: float | None) -> "FitState":
        """Leave outliers out of the errors and of what pulls: at most `share` of the points, those beyond `bound`.

        As long as there are more such points they are the surface's fault, all but those that fit no mesh either.
        """
        most = int(share * self.data.vertices)
        if most == 0:
            return self
        distance = self.distance[: self.data.vertices]
        far = far_points(distance, bound)
        if len(far) > most:
            far = np.intersect1d(outliers(distance, share, bound), self.data.suspects)
        return replace(self, data=self.data.without(far))
