"""Closest points on the boundary or crease curves of a limit surface."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.limit.surface import LimitSurface
from subdfit.schemes.domain import CORNERS
from subdfit.target.bvh import SegmentTree

Floats = NDArray[np.float64]

SEGMENTS = 4
"""Chords a cell side in the tree."""
NEWTON_STEPS = 6
SETTLED = 1e-7
"""A parameter that moves by less is found: what is left is its square."""


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

    def closest(self, points: Floats) -> CurveProjection:
        """Footpoints of (k, 3) points: the nearest chord, then Newton's method along the curves."""
        start = self._start(points)
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

    def _start(self, points: Floats) -> tuple[NDArray[np.int64], Floats]:
        count = len(self)
        knots = np.tile(np.linspace(0, 1, SEGMENTS + 1), count)
        vertices = self._expand(np.repeat(np.arange(count), SEGMENTS + 1), knots)[0]
        first = (np.arange(count)[:, None] * (SEGMENTS + 1) + np.arange(SEGMENTS)).ravel()
        found = SegmentTree(vertices, np.column_stack([first, first + 1])).closest(points)
        segment = found.segment.astype(np.int64)
        return segment // SEGMENTS, (segment % SEGMENTS + found.parameter) / SEGMENTS

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
        before = self._expand(first_side, first_t)[0]
        after = self._expand(side, t)[0]
        worse = np.linalg.norm(after - points, axis=1) > np.linalg.norm(before - points, axis=1)
        side, t = np.where(worse, first_side, side), np.where(worse, first_t, t)
        position, tangent, _ = self._expand(side, t)
        length = np.linalg.norm(tangent, axis=1, keepdims=True)
        tangent = np.divide(tangent, length, out=np.zeros_like(tangent), where=length > 0)
        face, uv = self.locate(side, t)
        return CurveProjection(side, t, face, uv, position, tangent, np.linalg.norm(position - points, axis=1))
