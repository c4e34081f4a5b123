"""Subdivision curves: what boundaries and creases of every scheme but Doo-Sabin's are.

New vertices at the middles, old ones by the mask 1/8, 6/8, 1/8 (Lavoué et al. 2007, equation 2); the ends of an open
curve stay (equation 3). The limit is a uniform cubic B-spline. A point that mirrors the second control point in the
end makes equation 3 the same as equation 2, so that the end segments are no exception.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError

Floats = NDArray[np.float64]

_BASIS = np.array([[1, 4, 1, 0], [-3, 0, 3, 0], [3, -6, 3, 0], [-1, 3, -3, 1]]) / 6.0
"""Uniform cubic B-spline: powers of the parameter by control points."""


@dataclass(frozen=True)
class SubdivisionCurve:
    """A smooth subdivision curve; its ends, if it has any, are corners.

    The parameter runs from 0, one unit a control segment: to ``n - 1`` on an open curve, round to ``n`` on a closed
    one.

    Attributes
    ----------
    points : (n, d) float64, the control points; n >= 2 open, n >= 3 closed.
    closed : whether the last control point is joined to the first.
    """

    points: Floats
    closed: bool = False

    def __post_init__(self) -> None:
        if len(self.points) < 2 + self.closed:
            kind = "closed" if self.closed else "open"
            raise InputError(f"a {kind} curve of {len(self.points)} control points; give {2 + self.closed} or more")

    @property
    def length(self) -> int:
        """Number of control segments, the largest parameter."""
        return len(self.points) if self.closed else len(self.points) - 1

    def weights(self, parameters: Floats, derivative: int = 0) -> Floats:
        """Rows (k, n) with ``weights @ points`` the curve at the parameters (k,), or its derivative up to the third."""
        return curve_weights(parameters, len(self.points), self.closed, derivative)

    def evaluate(self, parameters: Floats, derivative: int = 0) -> Floats:
        """Points (k, d) of the limit curve, or derivatives by the parameter."""
        return np.asarray(self.weights(parameters, derivative) @ self.points)

    def limit_points(self) -> Floats:
        """Where the control points go in the limit, (n, d)."""
        return self.evaluate(np.arange(len(self.points), dtype=np.float64))

    def refined(self) -> "SubdivisionCurve":
        """One step of subdivision; the curve stays the same."""
        n = len(self.points)
        after, before = np.roll(self.points, -1, axis=0), np.roll(self.points, 1, axis=0)
        moved = (before + 6 * self.points + after) / 8
        middle = (self.points + after) / 2
        if not self.closed:
            moved[[0, -1]] = self.points[[0, -1]]
        result = np.empty((2 * n, self.points.shape[1]))
        result[0::2], result[1::2] = moved, middle
        return SubdivisionCurve(result if self.closed else result[:-1], self.closed)

    def polyline(self, per_segment: int = 8) -> Floats:
        """Points of the limit curve at equal steps of the parameter; a closed curve does not repeat its first."""
        steps = np.arange(self.length * per_segment + (not self.closed)) / per_segment
        return self.evaluate(steps)


def curve_weights(parameters: Floats, count: int, closed: bool, derivative: int = 0) -> Floats:
    """Rows (k, count) of the basis functions at parameters (k,), or of their derivatives."""
    t = np.asarray(parameters, np.float64)
    last = count if closed else count - 1
    t = np.mod(t, last) if closed else np.clip(t, 0, last)
    segment = np.minimum(t.astype(np.int64), last - 1)
    u = t - segment
    powers = np.zeros((len(t), 4))
    for power in range(derivative, 4):
        factor = np.prod(np.arange(power, power - derivative, -1))
        powers[:, power] = factor * u ** (power - derivative)
    values = powers @ _BASIS
    rows = np.zeros((len(t), count + 2))
    columns = segment[:, None] + np.arange(4)
    if closed:
        rows = np.zeros((len(t), count))
        np.add.at(rows, (np.arange(len(t))[:, None], (columns - 1) % count), values)
        return rows
    # Column 0 and the last stand for the mirror points 2 P_0 - P_1 and its like at the other end.
    np.add.at(rows, (np.arange(len(t))[:, None], columns), values)
    inner = rows[:, 1:-1].copy()
    inner[:, 0] += 2 * rows[:, 0]
    inner[:, 1] -= rows[:, 0]
    inner[:, -1] += 2 * rows[:, -1]
    inner[:, -2] -= rows[:, -1]
    return inner
