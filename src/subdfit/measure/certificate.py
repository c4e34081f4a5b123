"""Two-sided errors of a limit surface against a target, and the certificate.

Every number is found afresh: footpoints of all data points by a global search that no earlier parameter can mislead,
the reverse side from samples of the surface, curves apart.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subdfit.closest.curves import SurfaceCurves
from subdfit.closest.projection import Projection, Projector
from subdfit.limit.surface import LimitSurface
from subdfit.measure.facing import MOST_AWAY, share_facing_away
from subdfit.measure.outliers import NO_OUTLIERS, Outliers, outliers
from subdfit.measure.peaks import Peaks, peaks
from subdfit.measure.samples import SurfaceSamples, surface_samples
from subdfit.target.bvh import Closest
from subdfit.target.sampling import face_samples
from subdfit.target.target import Target

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]


@dataclass(frozen=True)
class CurveErrors:
    """Distances of the target's curve points from the surface's curves, as shares of the diagonal."""

    max: float
    mean: float


@dataclass(frozen=True)
class Tolerance:
    """What is asked, as shares of the diagonal; None is not asked."""

    max: float | None = None
    rms: float | None = None
    mean: float | None = None

    def met(self, max_error: float, rms: float, mean: float) -> bool:
        """Whether errors hold all that is asked."""
        asked = ((self.max, max_error), (self.rms, rms), (self.mean, mean))
        return all(bound is None or value <= bound for bound, value in asked)


@dataclass(frozen=True, eq=False)
class Measurement:
    """Errors as shares of the target's diagonal.

    Attributes
    ----------
    max, rms, mean : data points (the target's used vertices) to the limit surface.
    reverse_max, reverse_rms, reverse_mean : samples of the surface to the target's faces (points alone: to these).
    boundary, crease : the target's curve points to the surface's curves; None where either has none.
    faceting : the largest sagitta of the target.
    samples_excess : how far samples inside large faces lie off beyond the sagitta there, at most.
    reverse_excess : how far the surface lies off beyond the allowance where it meets the target, at most.
    reverse_held : rms and mean that the tolerance applies to where no largest error is asked: of a mesh those of the
        reverse side, of a cloud, whose faces are our own making, those beyond their allowance.
    footpoints : of the data points, in the normalised frame.
    diagonal : in the caller's unit.
    facing_away : share of the surface's area that faces against the target there: sheets of a thin part that have
        fallen together, though they lie within the tolerance.
    excluded : rows of `footpoints` that max, rms and mean leave out as outliers.
    """

    max: float
    rms: float
    mean: float
    reverse_max: float
    reverse_rms: float
    reverse_mean: float
    boundary: CurveErrors | None
    crease: CurveErrors | None
    faceting: float
    samples_excess: float
    reverse_excess: float
    reverse_held: tuple[float, float]
    footpoints: Projection
    diagonal: float
    facing_away: float = 0.0
    excluded: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))

    def meets(self, tolerance: Tolerance) -> bool:
        """Whether the data's side, samples inside large faces included, is within the tolerance."""
        inside = tolerance.max is None or self.samples_excess <= tolerance.max
        return inside and tolerance.met(self.max, self.rms, self.mean)

    @property
    def sheets_fell_together(self) -> bool:
        """Whether so much faces away that the surface is no longer the target's."""
        return self.facing_away > MOST_AWAY

    def certifies(self, tolerance: Tolerance) -> bool:
        """Whether the surface lies within the tolerance on both sides, and faces where the target does.

        Where no largest error is asked, the reverse side is held to the mean and rms (see `reverse_held`).
        """
        if not self.meets(tolerance) or self.sheets_fell_together:
            return False
        bound = tolerance.max
        if bound is None:
            return tolerance.met(self.reverse_max, *self.reverse_held)
        return self.reverse_excess <= bound


def measure(
    surface: LimitSurface, target: Target, spacing: float, diagonal: float = 1.0, allowed: Outliers = NO_OUTLIERS
) -> Measurement:
    """Measure a surface against a target, both in the normalised frame.

    Parameters
    ----------
    surface
        The limit surface.
    target
        The data.
    spacing
        Target faces with longer sides than this are sampled inside as well.
    diagonal
        The frame's diagonal, for the record.
    allowed
        What may be left out of max, rms and mean.
    """
    data, excluded, inside = _forward(surface, target, spacing, allowed)
    distance = np.delete(data.distance, excluded)
    reverse = _reverse(surface, target)
    rms, mean = _rms_and_mean(distance)
    reverse_rms, reverse_mean = _rms_and_mean(reverse.distance)
    held = np.maximum(reverse.distance - reverse.allowance, 0.0) if target.cloud else reverse.distance
    return Measurement(
        max=float(distance.max()),
        rms=rms,
        mean=mean,
        reverse_max=reverse.farthest,
        reverse_rms=reverse_rms,
        reverse_mean=reverse_mean,
        boundary=None if target.cloud else _curve_errors(surface, target, inner=False),
        crease=_curve_errors(surface, target, inner=True),
        faceting=target.faceting,
        samples_excess=inside,
        reverse_excess=reverse.excess,
        reverse_held=_rms_and_mean(held),
        footpoints=data,
        diagonal=diagonal,
        facing_away=reverse.facing_away,
        excluded=excluded,
    )


def _forward(
    surface: LimitSurface, target: Target, spacing: float, allowed: Outliers
) -> tuple[Projection, NDArray[np.int64], float]:
    """Footpoints of the data, outliers among them, and the excess of samples inside large faces.

    What was searched in is then forgotten.
    """
    projector = Projector(surface)
    data = projector.certain(target.points[target.used])
    excluded = outliers(data.distance, allowed.share, allowed.bound)
    return data, excluded, _samples_excess(projector, target, spacing, excluded)


def _rms_and_mean(distance: Floats) -> tuple[float, float]:
    return float(np.sqrt(np.mean(distance**2))), float(distance.mean())


class _Reverse(NamedTuple):
    """The reverse side.

    Attributes
    ----------
    distance, allowance : of samples of the surface, (n,).
    farthest, excess : the largest distance, and the largest beyond the allowance, peaks between samples included.
    facing_away : share of the surface that does.
    """

    distance: Floats
    allowance: Floats
    farthest: float
    excess: float
    facing_away: float


def _reverse(surface: LimitSurface, target: Target) -> _Reverse:
    """Measure samples of the surface against the target's triangles, a cloud's included; points alone against these."""
    samples = surface_samples(surface)
    if not target.is_mesh:
        distance = target.nearest_point(samples.position)
        return _Reverse(distance, np.zeros(len(distance)), float(distance.max()), float(distance.max()), 0.0)
    found = target.tree.closest(samples.position)
    allowance = target.allowance(samples.position, found)
    near = found.triangle

    def gap_at(places: Floats, rows: Rows) -> Floats:
        return target.gaps(places, near[rows])

    farthest = float(_farthest(surface, samples, target, found).gap.max(initial=found.distance.max()))
    over = found.distance - allowance
    most = float(over.max())
    excess = float(peaks(surface, samples, over, gap_at, most).gap.max(initial=most))
    away = share_facing_away(samples.position, samples.triangles, target, found.triangle)
    return _Reverse(found.distance, allowance, max(farthest, excess), excess, away)


def reverse_peaks(surface: LimitSurface, target: Target) -> Peaks:
    """Where a surface lies farther from a target's triangles than round about, both in the normalised frame."""
    samples = surface_samples(surface)
    return _farthest(surface, samples, target, target.tree.closest(samples.position))


def _farthest(surface: LimitSurface, samples: SurfaceSamples, target: Target, found: Closest) -> Peaks:
    """The peaks of the distance from the target's triangles, of which `found` are those nearest to the samples."""

    def distance_at(places: Floats, rows: Rows) -> Floats:
        return target.tree.closest(places, start=found.triangle[rows]).distance

    return peaks(surface, samples, found.distance, distance_at, float(found.distance.max()))


def _samples_excess(projector: Projector, target: Target, spacing: float, excluded: NDArray[np.int64]) -> float:
    """How far samples of large faces lie off beyond the sagitta at most; faces at outliers stand for nothing."""
    if not target.is_mesh or target.cloud:
        return 0.0
    triangle, uv = face_samples(target.points, target.triangles, spacing)
    kept = ~np.isin(target.triangles[triangle], target.used[excluded]).any(axis=1)
    triangle, uv = triangle[kept], uv[kept]
    if len(triangle) == 0:
        return 0.0
    distance = projector.certain(target.on_triangles(triangle, uv)).distance
    return float((distance - target.sagitta(triangle, uv)).max())


def _curve_errors(surface: LimitSurface, target: Target, inner: bool) -> CurveErrors | None:
    edges = target.crease_edges if inner else target.boundary_edges
    curves = SurfaceCurves(surface, inner)
    if len(edges) == 0 or len(curves) == 0:
        return None
    found = curves.closest(target.points[np.unique(edges)])
    return CurveErrors(float(found.distance.max()), float(found.distance.mean()))
