"""The same surface meshed badly, in three ways."""

import numpy as np
from numpy.typing import NDArray

from subdfit.initial.decimate import decimate
from subdfit.target.features import automatic_creases

Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]


def with_slivers(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> Mesh:
    """A vertex more in every other triangle, so near its first side that what is left is a needle."""
    cut = triangles[::2]
    middle = len(points) + np.arange(len(cut))
    fresh = np.einsum("k,tkd->td", [0.47, 0.5, 0.03], points[cut])
    parts = [np.column_stack([cut[:, k], cut[:, (k + 1) % 3], middle]) for k in range(3)]
    return np.concatenate([points, fresh]), np.concatenate([triangles[1::2], *parts])


def decimated(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> Mesh:
    """A third of the vertices, which leaves long triangles where the surface is flat or ruled."""
    creases = automatic_creases(points, triangles)
    found = decimate(points, triangles, len(points) // 3, crease_edges=creases)
    return found.points, found.triangles


def noisy(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> Mesh:
    """Normal noise of .1 % of the diagonal."""
    return shaken(points, 1e-3 / np.sqrt(3))[0], triangles


def shaken(points: NDArray[np.float64], share: float) -> tuple[NDArray[np.float64], float]:
    """Points with normal noise in all directions, and its standard deviation, given as a share of the diagonal."""
    sigma = share * float(np.linalg.norm(np.ptp(points, axis=0)))
    return points + sigma * np.random.default_rng(0).normal(size=points.shape), sigma
