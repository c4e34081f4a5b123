"""The points of a cloud, of size 1, and those that are points of their own."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from subdfit.errors import InputError
from subdfit.target.frame import Frame

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

SINGLE = float(np.finfo(np.float32).eps)
"""Distance, as a share of the cloud's size, up to which two points are one: the last digit of single precision, in
which the same scan may have been written."""


def normalised(points: Floats, name: str) -> Floats:
    """The points in a frame of size 1; at 0 where they coincide."""
    frame = Frame.of(points)
    if frame.diagonal > 0:
        return frame.inside(points)
    if (points != points[0]).any():
        raise InputError(f"{name}: the points are too near one another to compute with; give them in a smaller unit")
    return np.zeros_like(points)


def distinct(points: Floats) -> Rows:
    """The first row of each position, sorted by coordinates: the same order however the cloud is.

    Of points nearer than single precision tells apart, the first in this order stands for the others.
    """
    places = points + 0.0  # -0 and 0 are one place
    order = np.lexsort(places.T[::-1])
    ordered = places[order]
    new = np.concatenate([[True], (ordered[1:] != ordered[:-1]).any(axis=1)])
    first: Rows = order[new]
    near = cKDTree(places[first]).query_pairs(SINGLE * _size(places), output_type="ndarray")
    return np.delete(first, near.max(axis=1))


def _size(points: Floats) -> float:
    """Twice the median distance from the median point, which a few outliers do not change."""
    return 2.0 * float(np.median(np.linalg.norm(points - np.median(points, axis=0), axis=1)))
