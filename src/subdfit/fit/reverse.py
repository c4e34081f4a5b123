"""The reverse side: samples of the surface and of its curves, and what of the target lies nearest."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.closest.curves import SurfaceCurves
from subdfit.fit.places import Places
from subdfit.fit.state import FitState
from subdfit.limit.surface import LimitSurface
from subdfit.limit.tessellate import lattice
from subdfit.measure import PEAK, Tolerance, peaks, reverse_segments, surface_samples
from subdfit.schemes.domain import CORNERS, Domain
from subdfit.target.bvh import SegmentTree
from subdfit.target.target import Target

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

SPARSE = 3
"""Faces and sides of curves with fewer points than this are sampled."""
TOUCHING = 1e-9
"""A sample this near its foot has no direction in which it is off."""

DRAWN = 0.5
"""Samples farther off than this share of the bound are held: drawing others back would push them beyond it."""
CURVE_PLACES = np.array([0.25, 0.5, 0.75])
"""Where along a side its curve is sampled."""


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of a surface, each with its direction to the nearest point of the target.

    Attributes
    ----------
    face, uv : (k,) int32 and (k, 2), where they lie.
    normal : (k, 3), unit vectors towards the nearest point of the target.
    gap : (k,), how far each lies off the target beyond what its faceting allows.
    triangle : (k,) int32, the triangle of the target that holds that point.
    """

    face: NDArray[np.int32]
    uv: Floats
    normal: Floats
    gap: Floats
    triangle: NDArray[np.int32]

    @classmethod
    def of(
        cls,
        surface: LimitSurface,
        target: Target,
        face: NDArray[np.int32],
        uv: Floats,
        bound: float | None = None,
        near: NDArray[np.int32] | None = None,
    ) -> "Samples":
        """Find the feet of samples, only of those farther off than `bound` where that is given; a cloud has none.

        `near` (k,) names a triangle likely to be near each.
        """
        if not target.is_mesh or len(face) == 0:
            return cls.none()
        position = surface.evaluate(face, uv).position
        # Samples within the bound are dropped: they need not know what lies nearest.
        found = target.tree.closest(position, start=near, enough=bound or 0.0)
        gap = found.distance - target.allowance(position, found)
        far = slice(None) if bound is None else np.flatnonzero(gap > bound)
        foot = target.on_triangles(found.triangle[far], found.uv[far])
        length = found.distance[far][:, None]
        normal = np.divide(foot - position[far], length, out=np.zeros_like(foot), where=length > TOUCHING)
        return cls(face[far], np.ascontiguousarray(uv[far]), normal, np.maximum(gap[far], 0.0), found.triangle[far])

    @classmethod
    def none(cls) -> "Samples":
        """No samples."""
        return cls(np.empty(0, np.int32), np.empty((0, 2)), np.empty((0, 3)), np.empty(0), np.empty(0, np.int32))

    def renewed(self, surface: LimitSurface, target: Target) -> "Samples":
        """The same samples on a surface that has moved."""
        return Samples.of(surface, target, self.face, self.uv, near=self.triangle)

    def __len__(self) -> int:
        """Number of samples."""
        return len(self.face)

    def __getitem__(self, rows: Flags | NDArray[np.int64]) -> "Samples":
        """Some of these."""
        return Samples(self.face[rows], self.uv[rows], self.normal[rows], self.gap[rows], self.triangle[rows])

    def joined(self, other: "Samples") -> "Samples":
        """These and others."""
        return Samples(
            np.concatenate([self.face, other.face]),
            np.concatenate([self.uv, other.uv]),
            np.concatenate([self.normal, other.normal]),
            np.concatenate([self.gap, other.gap]),
            np.concatenate([self.triangle, other.triangle]),
        )


def strays(
    surface: LimitSurface,
    target: Target,
    bound: float,
    cells: Flags | None = None,
    segments: int = 0,
    share: float = 1.0,
) -> Samples:
    """Those of the certificate's samples, and of the peaks between them, that stray.

    They lie off, beyond what the faceting allows, by more than `share` times `bound`. Peaks are searched to the end
    only where they may exceed `bound`; lower ones are wherever their search was given up. Where `cells` (c,) are
    flagged, those of these alone; `segments` a small cell's side, where given. Of a large cell's many samples the
    farthest stands for those near it, so that they do not outvote the data.
    """
    if not target.is_mesh:
        return Samples.none()
    segments = segments or reverse_segments(surface.domain)
    sampled = surface_samples(surface, cells, segments)
    found = target.tree.closest(sampled.position, enough=PEAK * bound)
    near, gap = found.triangle, found.distance - target.allowance(sampled.position, found)

    def gap_at(places: Floats, rows: NDArray[np.int64]) -> Floats:
        return target.gaps(places, near[rows])

    tops = peaks(surface, sampled, gap, gap_at, bound)
    far = np.flatnonzero(gap > share * bound)
    face, uv = np.concatenate([sampled.face[far], tops.face]), np.concatenate([sampled.uv[far], tops.uv])
    samples = Samples.of(surface, target, face, uv, share * bound, near[np.concatenate([far, tops.row])])
    return samples[_farthest(samples, segments)]


def _farthest(samples: Samples, segments: int) -> NDArray[np.int64]:
    """Rows of the farthest of the samples in each square of a cell cut into so many segments, ascending."""
    i, j = np.floor(samples.uv * segments + TOUCHING).astype(np.int64).T
    square = (samples.face.astype(np.int64) * (segments + 1) + i) * (segments + 1) + j
    order = np.lexsort([-samples.gap, square])
    first = np.diff(square[order], prepend=-1) != 0
    return np.sort(order[first])


def even_samples(
    surface: LimitSurface, target: Target, segments: int, cells: Flags | None = None, bound: float | None = None
) -> Samples:
    """As many samples in each cell, or each of the flagged ones, (c,), with so many segments a side.

    Where `bound` is given, those farther off alone.
    """
    grid = lattice(surface.domain, segments, cells)
    return Samples.of(surface, target, grid.face, grid.uv, bound)


def even_strays(state: FitState, bound: float) -> Samples:
    """Those of a state's even samples, as dense as the certificate's, that stray by more than a bound.

    Peaks between them are left out: they would pull the hardest.
    """
    surface = state.surface
    return even_samples(surface, state.data.target, reverse_segments(surface.domain), bound=bound)


def reverse_badness(state: FitState, tolerance: Tolerance) -> float:
    """Largest ratio of rms and mean of the reverse side to what is asked; 0 where neither is.

    By a quarter of the certificate's samples: a sum over all of the surface needs no more.
    """
    segments = max(reverse_segments(state.surface.domain) // 2, 1)
    places = surface_samples(state.surface, segments=segments).position
    distance = state.data.target.tree.closest(places).distance
    asked = ((tolerance.rms, float(np.sqrt(np.mean(distance**2)))), (tolerance.mean, float(distance.mean())))
    return max((value / bound for bound, value in asked if bound), default=0.0)


def inner_places(domain: Domain, cells: NDArray[np.int64]) -> tuple[NDArray[np.int32], Floats]:
    """Places inside some cells, faces (k,) and parameters (k, 2): their middles, and half-way to each corner."""
    shape, present = domain.shape[cells], domain.present[cells]
    middle = (CORNERS[shape] * present[:, :, None]).sum(axis=1) / shape[:, None]
    places = np.concatenate([middle[:, None], (middle[:, None] + CORNERS[shape]) / 2], axis=1)
    row, column = np.nonzero(np.column_stack([np.ones(len(cells), np.bool_), present]))
    return cells[row].astype(np.int32), np.ascontiguousarray(places[row, column])


def inner_samples(surface: LimitSurface, target: Target, cells: NDArray[np.int64]) -> Samples:
    """Samples inside some cells."""
    return Samples.of(surface, target, *inner_places(surface.domain, cells))


@dataclass(frozen=True, eq=False)
class CurveSamples:
    """Samples of a surface's curves, each with the nearest segment of the target's.

    Attributes
    ----------
    face, uv : (k,) int32 and (k, 2), where they lie.
    foot, along : (k, 3), the nearest point of the target's curves, and the segment's unit direction there.
    """

    face: NDArray[np.int32]
    uv: Floats
    foot: Floats
    along: Floats

    @classmethod
    def of(cls, curves: SurfaceCurves, sides: NDArray[np.int64], tree: SegmentTree) -> "CurveSamples":
        """Samples at the places `CURVE_PLACES` of some sides."""
        side, t = np.repeat(sides, len(CURVE_PLACES)), np.tile(CURVE_PLACES, len(sides))
        face, uv = curves.locate(side, t)
        position = curves.surface.evaluate(face, uv).position
        foot, along = tree.on_segments(tree.closest(position))
        return cls(face, uv, foot, along)

    def gaps(self, surface: LimitSurface) -> Floats:
        """From each sample across the curve to the target's, (k, 3)."""
        apart = self.foot - surface.evaluate(self.face, self.uv).position
        return np.asarray(apart - np.einsum("kd,kd->k", apart, self.along)[:, None] * self.along)


def sparse_samples(state: FitState) -> Samples:
    """Samples of faces with few data points: nothing else keeps them near the target."""
    face = Places(state.surface).face
    count = np.bincount(face[state.face], minlength=state.surface.topology.face_count)
    return inner_samples(state.surface, state.data.target, np.flatnonzero(count[face] < SPARSE))


def sparse_curve_samples(state: FitState, cells: Flags) -> list[CurveSamples]:
    """Samples of those sides of the flagged cells, (c,), that lie on curves and have few data points."""
    trees = (state.data.target.boundary_tree, state.data.target.crease_tree)
    samples = []
    for found, curves, tree in zip(state.held, state.curves, trees, strict=True):
        if found is not None and curves is not None and tree is not None:
            few = np.bincount(found.side, minlength=len(curves)) < SPARSE
            samples.append(CurveSamples.of(curves, np.flatnonzero(few & cells[curves.cell]), tree))
    return samples
