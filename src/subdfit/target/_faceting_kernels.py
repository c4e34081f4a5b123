"""How far a smooth surface lies off the facets of a mesh, point by point."""

import numpy as np
from numpy.typing import NDArray

from subdfit.compiled import kernel

Reals = NDArray[np.float64]


@kernel
def heights(rises: Reals, triangle: NDArray[np.int32], uv: Reals, start: int, stop: int, out: Reals) -> None:
    """Write ``4 |sum of b_i b_j rise_ij|`` at barycentric b into ``out[start:stop]``."""
    for k in range(start, stop):
        u, v, t = uv[k, 0], uv[k, 1], triangle[k]
        w = 1.0 - u - v
        squared = 0.0
        for d in range(3):
            off = w * u * rises[t, 0, d] + u * v * rises[t, 1, d] + v * w * rises[t, 2, d]
            squared += off * off
        out[k] = 4.0 * np.sqrt(squared)
