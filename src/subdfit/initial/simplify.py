"""Fewer triangles for the same surface: to a number of vertices, or as few as a tolerance allows."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.initial.decimate import Decimated, decimate
from subdfit.target.bvh import TriangleTree

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

LEAST_VERTICES = 4

CLOSE_ENOUGH = 1.02
"""Ratio of the counts, one within the tolerance and one not, between which no further count is tried."""


@dataclass(frozen=True, eq=False)
class Simplified:
    """A triangle mesh with fewer vertices, of the same topology.

    Attributes
    ----------
    points : (k, 3) float64.
    triangles : (m, 3) int64, rows of `points`.
    point_rows : (k,) int64, rows of the original points; None where vertices were placed freely.
    error : largest distance of an original point from the triangles.
    message : why there are more vertices than were to be left, or None.
    """

    points: Floats
    triangles: Rows
    point_rows: Rows | None
    error: float
    message: str | None = None


def simplify(
    points: Floats,
    triangles: Rows,
    *,
    vertices: int | None = None,
    max_error: float | None = None,
    keep_points: bool = False,
) -> Simplified:
    """Decimate by quadric errors; components, genus and boundary loops stay.

    Parameters
    ----------
    points, triangles : (n, 3) and (m, 3)
        An oriented manifold in which every point is used.
    vertices : int, optional
        How many to leave, or the least where there is a tolerance too; more stay where the topology needs them.
    max_error : float, optional
        Largest distance of a point from the result, in the points' unit. The fewest vertices that hold it are found by
        bisection, to 2 %.
    keep_points : bool
        Whether vertices are original points; else they are where the error is least.
    """
    least = min(vertices or LEAST_VERTICES, len(points))
    if max_error is None:
        return _reduced(points, triangles, least, keep_points)
    found = _reduced(points, triangles, least, keep_points)
    within, below = len(points), len(found.points)
    best = Simplified(points, triangles, np.arange(len(points)) if keep_points else None, 0.0)
    if found.error <= max_error:
        return found
    while within > CLOSE_ENOUGH * below:
        count = int(np.sqrt(float(within) * below)) + 1
        found = _reduced(points, triangles, count, keep_points)
        if found.error <= max_error and len(found.points) < within:
            best, within = found, len(found.points)
        else:
            below = count
    return best


def _reduced(points: Floats, triangles: Rows, count: int, keep_points: bool) -> Simplified:
    found: Decimated = decimate(points, triangles, max(count, 3), subset=keep_points)
    error = TriangleTree(found.points, found.triangles).closest(points).distance.max()
    return Simplified(found.points, found.triangles, found.point_rows, float(error), found.message)
