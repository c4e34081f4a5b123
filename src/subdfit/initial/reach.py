"""Which points lie near some places, each with a reach of its own."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Floats = NDArray[np.float64]


def within_reach(points: Floats, places: Floats, reach: Floats) -> NDArray[np.bool_]:
    """Which points, (n, 3), lie within the reach, (k,), of the nearest of some places, (k, 3)."""
    distance, place = cKDTree(places).query(points)
    return np.asarray(distance <= reach[place])
