"""Polylines as targets of curve fitting: arc length, curvature, closest points, sharp points."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

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
    points : (n, 3) float64; a closed chain does not repeat its first point.
    closed : whether the last point is joined to the first.
    """

    points: Floats
    closed: bool = False

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
        begin, end = self._ends
        direction = end - begin
        square = np.maximum(np.sum(direction**2, axis=1), 1e-300)
        arcs, distances = np.empty(len(queries)), np.empty(len(queries))
        for first in range(0, len(queries), 256):
            chunk = queries[first : first + 256]
            t = np.clip(np.einsum("qsk,sk->qs", chunk[:, None] - begin, direction) / square, 0, 1)
            foot = begin + t[..., None] * direction
            squares = np.sum((chunk[:, None] - foot) ** 2, axis=2)
            best = np.argmin(squares, axis=1)
            rows = np.arange(len(chunk))
            arcs[first : first + 256] = self.arc[best] + t[rows, best] * self.lengths[best]
            distances[first : first + 256] = np.sqrt(squares[rows, best])
        return arcs, distances

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
