"""Regular samples inside large faces, where the vertices alone would leave a fit unconstrained."""

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError


def face_samples(
    points: NDArray[np.float64], triangles: NDArray[np.integer], spacing: float
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Samples inside the faces that have an edge longer than a spacing; none in the others.

    A face is cut in rows along its shortest edge, and each row in equal steps, both no longer than the
    spacing; a sample sits in the middle of each step. Slivers thus get one row of samples, not a full grid.

    Parameters
    ----------
    points : (n, 3) float64.
    triangles : (m, 3) int, rows of `points`.
    spacing : largest distance between neighbouring samples along and across rows, > 0, in the points' unit.

    Returns
    -------
    triangle : (s,) int64, in increasing order.
    uv : (s, 2) float64, strictly inside; the sample is ``(1 - u - v) a + u b + v c``.

    Raises
    ------
    InputError
        The spacing is not a positive length.
    """
    if not spacing > 0.0:
        raise InputError(f"the spacing of face samples is {spacing}; give a positive length")
    corners = points[triangles]
    lengths = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    large = np.flatnonzero(lengths.max(axis=1, initial=0.0) > spacing)
    base = np.argmin(lengths[large], axis=1)
    rows = np.ceil(lengths[large].max(axis=1) / spacing).astype(np.int64)
    face, height = _spread(rows)
    width = (1.0 - height) * lengths[large, base][face]
    row, along = _spread(np.maximum(np.ceil(width / spacing), 1).astype(np.int64))
    face, height = face[row], height[row]
    weights = np.empty((len(face), 3))
    sample = np.arange(len(face))
    weights[sample, base[face]] = (1.0 - height) * (1.0 - along)
    weights[sample, (base[face] + 1) % 3] = (1.0 - height) * along
    weights[sample, (base[face] + 2) % 3] = height
    return large[face], weights[:, 1:]


def _spread(counts: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Middles of ``counts[i]`` equal parts of [0, 1] for every i: the owners i and the positions."""
    owner = np.repeat(np.arange(len(counts)), counts)
    part = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    return owner, (part + 0.5) / counts[owner]
