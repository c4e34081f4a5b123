"""Polylines as targets of curve fitting: arc length, curvature, closest points, sharp points."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.mesh.checks import finite_points
from subdfit.target.bvh import SegmentTree

Floats = NDArray[np.float64]

FEW = 64
"""Segments that are faster looked at one by one than through a tree."""
_TURN = 40.0
"""Degrees by which a polyline turns at a sharp point."""
_SHARE = 0.75
"""Share of the turn over twice the distance that a sharp point makes itself."""
_REACH = 1.5
"""Distance over which the turn at a point is judged, in median segments."""


@dataclass(frozen=True)
class Polyline:
    """A chain of points.

    Attributes
    ----------
    points : (n, 3) float64, n >= 2; a closed chain does not repeat its first point.
    closed : whether the last point is joined to the first.

    Raises
    ------
    InputError
        Fewer than two points, or one that has not three finite coordinates.
    """

    points: Floats
    closed: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", finite_points(self.points, "chain"))
        if len(self.points) < 2:
            raise InputError("a chain of 1 point is no curve; give 2 or more")

    @cached_property
    def _ends(self) -> tuple[Floats, Floats]:
        after = np.roll(self.points, -1, axis=0)
        return (self.points, after) if self.closed else (self.points[:-1], after[:-1])

    @cached_property
    def lengths(self) -> Floats:
        """Length of each segment."""
        begin, end = self._ends
        return np.asarray(np.linalg.norm(end - begin, axis=1))

    @cached_property
    def arc(self) -> Floats:
        """Arc length at each point, and at the end of the chain."""
        return np.concatenate([[0.0], np.cumsum(self.lengths)])

    @property
    def total(self) -> float:
        """Length of the chain."""
        return float(self.arc[-1])

    def at(self, arc: Floats) -> Floats:
        """Points (k, 3) at arc lengths (k,)."""
        s = np.mod(arc, self.total) if self.closed else np.clip(arc, 0, self.total)
        segment = np.clip(np.searchsorted(self.arc, s, side="right") - 1, 0, len(self.lengths) - 1)
        t = (s - self.arc[segment]) / np.maximum(self.lengths[segment], 1e-300)
        begin, end = self._ends
        return np.asarray(begin[segment] + t[:, None] * (end[segment] - begin[segment]))

    def closest(self, queries: Floats) -> tuple[Floats, Floats]:
        """Arc lengths (q,) and distances (q,) of the closest points of the chain."""
        segment = self._nearest(queries)
        begin, end = (ends[segment] for ends in self._ends)
        along = end - begin
        square = np.maximum(np.einsum("qd,qd->q", along, along), 1e-300)
        t = np.clip(np.einsum("qd,qd->q", queries - begin, along) / square, 0, 1)
        foot = begin + t[:, None] * along
        return self.arc[segment] + t * self.lengths[segment], np.linalg.norm(queries - foot, axis=1)

    def _nearest(self, queries: Floats) -> NDArray[np.int64]:
        if len(self.lengths) > FEW:
            return self._tree.closest(np.ascontiguousarray(queries, np.float64)).segment.astype(np.int64)
        begin, end = self._ends
        along = end - begin
        square = np.maximum(np.sum(along**2, axis=1), 1e-300)
        t = np.clip(np.einsum("qsk,sk->qs", queries[:, None] - begin, along) / square, 0, 1)
        gap = queries[:, None] - (begin + t[..., None] * along)
        return np.asarray(np.argmin(np.sum(gap**2, axis=2), axis=1), np.int64)

    @cached_property
    def _tree(self) -> SegmentTree:
        rows = np.arange(len(self.points))
        ends = np.stack([rows, np.roll(rows, -1)], axis=1)
        return SegmentTree(self.points, ends if self.closed else ends[:-1])

    def curvature(self, arc: Floats, window: float) -> tuple[Floats, Floats]:
        """Curvature vectors and unit tangents (k, 3) at arc lengths, from the chords to half a window either way.

        The window is cut at the ends of an open chain, where the curvature is that of the nearest full window.
        """
        half = np.full(len(arc), window / 2)
        centre = arc if self.closed else np.clip(arc, window / 2, max(self.total - window / 2, window / 2))
        before, here, after = self.at(centre - half), self.at(centre), self.at(centre + half)
        a, b = here - before, after - here
        la, lb = (np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-300) for v in (a, b))
        bend = 2 * (b / lb - a / la) / (la + lb)
        near = self.at(arc + half) - self.at(arc - half)
        return bend, near / np.maximum(np.linalg.norm(near, axis=1, keepdims=True), 1e-300)

    def sharp_points(self) -> NDArray[np.int64]:
        """Points at which the chain turns sharply, row numbers, ascending; never an end of an open chain.

        The turn is that between the chords to a short distance either way, so that a corner cut by a bevel of an edge
        or two is one, too. A point is sharp when the chain turns there by 40 degrees and more and hardly farther over
        twice the distance: round a small circle it turns twice as far. Of neighbours the sharpest counts.
        """
        inner = np.arange(len(self.points)) if self.closed else np.arange(1, len(self.points) - 1)
        at, reach = self.arc[inner], _REACH * float(np.median(self.lengths))
        near, far = self._turn(at, reach), self._turn(at, 2 * reach)
        found: list[int] = []
        for k in np.argsort(-near, kind="stable"):
            if near[k] < _TURN:
                break
            if near[k] >= _SHARE * far[k] and not self._within(at[found], at[k], reach).any():
                found.append(int(k))
        return np.sort(inner[found]).astype(np.int64)

    def sharpest(self, share: float) -> NDArray[np.int64]:
        """Points at which the chain itself turns by a share of the most it does, row numbers; never an open end."""
        inner = np.arange(len(self.points)) if self.closed else np.arange(1, len(self.points) - 1)
        turn = self._turn(self.arc[inner], 1e-3 * float(self.lengths.min()))
        return np.asarray(inner[turn >= share * turn.max(initial=0.0)], np.int64)

    def _turn(self, arc: Floats, reach: float) -> Floats:
        """Degrees between the chords to `reach` before and behind."""
        here = self.at(arc)
        a, b = here - self.at(arc - reach), self.at(arc + reach) - here
        turn = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.sum(a * b, axis=1))
        return np.asarray(np.degrees(turn))

    def _within(self, at: Floats, centre: float, reach: float) -> NDArray[np.bool_]:
        gap = np.abs(at - centre)
        return np.asarray((np.minimum(gap, self.total - gap) if self.closed else gap) <= reach)

    def parts(self, cuts: NDArray[np.int64]) -> list["Polyline"]:
        """The open chains between the points named, in order; the chain itself where there are none."""
        if len(cuts) == 0:
            return [self]
        n = len(self.points)
        stops = [*cuts.tolist(), int(cuts[0]) + n] if self.closed else [0, *cuts.tolist(), n - 1]
        return [Polyline(self.points[np.arange(a, b + 1) % n]) for a, b in pairwise(stops)]
