"""Closest points on the boundary or crease curves of a limit surface."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from subdfit.limit.surface import LimitSurface
from subdfit.schemes.domain import CORNERS
from subdfit.target.bvh import SegmentTree

Floats = NDArray[np.float64]

SEGMENTS = 4
"""Chords a cell side in the tree."""
NEWTON_STEPS = 6
SETTLED = 1e-7
"""A parameter that moves by less is found: what is left is its square."""
AGAINST, STRANDS = -0.3, 32
"""Cosine between the directions of a point's curve and of a chord from which that runs against it; and among how many
of the nearest chords one that does not is looked for."""


@dataclass(frozen=True, eq=False)
class CurveProjection:
    """Footpoints on curves of a surface.

    Attributes
    ----------
    side : (k,) int64, row of `SurfaceCurves`; t (k,) float64 in [0, 1] along it.
    face, uv : (k,) int32 and (k, 2), the same points on the surface.
    position, tangent : (k, 3), the points and unit tangents of the curve.
    distance : (k,) float64.
    """

    side: NDArray[np.int64]
    t: Floats
    face: NDArray[np.int32]
    uv: Floats
    position: Floats
    tangent: Floats
    distance: Floats

    def __getitem__(self, rows: NDArray[np.bool_]) -> "CurveProjection":
        """Those of some points."""
        return CurveProjection(
            self.side[rows],
            self.t[rows],
            self.face[rows],
            self.uv[rows],
            self.position[rows],
            self.tangent[rows],
            self.distance[rows],
        )


class SurfaceCurves:
    """The boundary curves of a surface, or its creases: cell sides, chained through their ends.

    Parameters
    ----------
    surface
        The surface.
    inner
        True for the creases inside the surface, False for its boundary.
    """

    def __init__(self, surface: LimitSurface, inner: bool) -> None:
        self.surface = surface
        domain = surface.domain
        neighbour = domain.neighbour
        cells = np.arange(domain.face_count)[:, None]
        wanted = domain.present & domain.sharp & ((neighbour > cells) if inner else (neighbour < 0))
        cell, side = np.nonzero(wanted)
        self.cell, self.side = cell.astype(np.int32), side
        self.ends = np.column_stack([domain.points[cell, side], domain.points[cell, domain.next_corner(cell, side)]])
        self._next = self._chain(self.ends, int(domain.points.max(initial=-1)) + 1)

    def __len__(self) -> int:
        """Number of sides."""
        return len(self.cell)

    @staticmethod
    def _chain(ends: NDArray[np.int64], vertices: int) -> NDArray[np.int64]:
        """For each end (2 side + 0 or 1) the end of another side that joins it smoothly alone; -1 if none."""
        at = ends.ravel()
        order = np.argsort(at, kind="stable")
        degree = np.bincount(at, minlength=vertices)
        pairs = order[degree[at[order]] == 2].reshape(-1, 2)
        joined = np.full(len(at), -1, np.int64)
        joined[pairs[:, 0]], joined[pairs[:, 1]] = pairs[:, 1], pairs[:, 0]
        return joined

    def locate(self, side: NDArray[np.int64], t: Floats) -> tuple[NDArray[np.int32], Floats]:
        """Return face (k,) and uv (k, 2) of points on the curves."""
        cell = self.cell[side]
        return cell, np.clip(self.surface.domain.along(cell, self.side[side], t), 0.0, 1.0)

    def closest(self, points: Floats, along: Floats | None = None, apart: float = 0.0) -> CurveProjection:
        """Footpoints of points: the nearest chord, then Newton's method along the curves.

        Parameters
        ----------
        points
            (k, 3).
        along
            (k, 3), optional: the unit directions of the curves they lie on, zero where unknown. A slit and the rim of a
            thin part have two strands side by side, which run against each other: of these a point keeps to its own.
        apart
            Strands nearer to a point than this are not told apart.
        """
        start = self._start(points, along, apart)
        side, t = start[0].copy(), start[1].copy()
        moving = np.arange(len(points))
        for _ in range(NEWTON_STEPS):
            position, first, second = self._expand(side[moving], t[moving])
            gap = position - points[moving]
            slope = np.einsum("kd,kd->k", first, gap)
            metric = np.einsum("kd,kd->k", first, first)
            bend = metric + np.einsum("kd,kd->k", second, gap)
            step = np.clip(slope / np.where(bend > 0.1 * metric, bend, np.maximum(metric, 1e-300)), -0.5, 0.5)
            moved = self._move(side[moving], t[moving] - step)
            still = (moved[0] == side[moving]) & (np.abs(moved[1] - t[moving]) < SETTLED)
            side[moving], t[moving] = moved
            moving = moving[~still]
            if len(moving) == 0:
                break
        return self._best(points, side, t, *start)

    def _start(self, points: Floats, along: Floats | None, apart: float) -> tuple[NDArray[np.int64], Floats]:
        ends = np.arange(2 * len(self._chords)).reshape(-1, 2)
        found = SegmentTree(self._chords.reshape(-1, 3), ends).closest(points)
        chord, parameter = found.segment.astype(np.int64), found.parameter
        if along is not None:
            against = np.flatnonzero(self._against(chord, along) & (found.distance > apart))
            own, known = self._own_strand(points[against], along[against])
            chord[against[known]], parameter[against[known]] = own[known], 0.5
        return chord // SEGMENTS, (chord % SEGMENTS + parameter) / SEGMENTS

    @cached_property
    def _chords(self) -> Floats:
        """The ends of the chords of all sides, (sides `SEGMENTS`, 2, 3)."""
        count, knots = len(self), np.linspace(0, 1, SEGMENTS + 1)
        side = np.repeat(np.arange(count), len(knots))
        at = self._expand(side, np.tile(knots, count))[0].reshape(count, len(knots), 3)
        return np.stack([at[:, :-1], at[:, 1:]], axis=2).reshape(-1, 2, 3)

    def _against(self, chord: NDArray[np.int64], along: Floats) -> NDArray[np.bool_]:
        """Whether chords, (k, ...), run against directions, (k, 3)."""
        run = self._chords[chord, 1] - self._chords[chord, 0]
        cosine = np.einsum("k...d,kd->k...", run, along)
        return np.asarray(cosine < AGAINST * np.linalg.norm(run, axis=-1))

    def _own_strand(self, points: Floats, along: Floats) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """For each point the nearest chord by its middle that does not run against it; whether there is one near."""
        if len(points) == 0:
            return np.empty(0, np.int64), np.empty(0, np.bool_)
        ranks = np.arange(1, min(STRANDS, len(self._chords)) + 1)
        near = np.asarray(cKDTree(self._chords.mean(axis=1)).query(points, k=ranks)[1], np.int64)
        alike = ~self._against(near, along)
        return near[np.arange(len(near)), alike.argmax(axis=1)], np.asarray(alike.any(axis=1))

    def _expand(self, side: NDArray[np.int64], t: Floats) -> tuple[Floats, Floats, Floats]:
        """Position, first and second derivative by t."""
        face, uv = self.locate(side, t)
        value = self.surface.evaluate(face, uv, 2)
        assert value.first is not None
        assert value.second is not None
        shape, begin = self.surface.domain.shape[face], self.side[side]
        a, b = (CORNERS[shape, (begin + 1) % shape] - CORNERS[shape, begin]).T[:, :, None]
        first = a * value.first[:, 0] + b * value.first[:, 1]
        second = a * a * value.second[:, 0] + 2 * a * b * value.second[:, 1] + b * b * value.second[:, 2]
        return value.position, first, second

    def _move(self, side: NDArray[np.int64], t: Floats) -> tuple[NDArray[np.int64], Floats]:
        """Carry parameters beyond a side's end over to the next side."""
        end = np.where(t > 1, 2 * side + 1, 2 * side)
        over = np.where(t > 1, t - 1, -t)
        joined = np.where((t > 1) | (t < 0), self._next[end], -1)
        crossing = joined >= 0
        new_side = np.where(crossing, joined // 2, side)
        new_t = np.where(crossing, np.where(joined % 2 == 0, over, 1 - over), t)
        return new_side, np.clip(new_t, 0.0, 1.0)

    def _best(
        self, points: Floats, side: NDArray[np.int64], t: Floats, first_side: NDArray[np.int64], first_t: Floats
    ) -> CurveProjection:
        """Keep the start where Newton's method ended farther away."""
        before, before_tangent, _ = self._expand(first_side, first_t)
        after, after_tangent, _ = self._expand(side, t)
        worse = np.linalg.norm(after - points, axis=1) > np.linalg.norm(before - points, axis=1)
        side, t = np.where(worse, first_side, side), np.where(worse, first_t, t)
        position = np.where(worse[:, None], before, after)
        tangent = np.where(worse[:, None], before_tangent, after_tangent)
        length = np.linalg.norm(tangent, axis=1, keepdims=True)
        tangent = np.divide(tangent, length, out=np.zeros_like(tangent), where=length > 0)
        face, uv = self.locate(side, t)
        return CurveProjection(side, t, face, uv, position, tangent, np.linalg.norm(position - points, axis=1))
