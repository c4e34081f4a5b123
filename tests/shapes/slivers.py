"""Surfaces of known curvature, triangulated badly: random vertices, joined as if the surface were stretched."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay

Floats = NDArray[np.float64]


class Analytic(NamedTuple):
    """A mesh and what is true of the surface at its vertices."""

    points: Floats
    triangles: NDArray[np.int64]
    minimum: Floats
    maximum: Floats
    minimum_direction: Floats
    normal: Floats


def cylinder(count: int, stretch: float, seed: int = 0) -> Analytic:
    """Radius one, height three, open at both ends."""
    q, triangles = scattered(count, (2 * np.pi, 3.0), stretch, seed, both=False)
    normal = np.stack([np.cos(q[:, 0]), np.sin(q[:, 0]), 0 * q[:, 0]], 1)
    axis = np.tile([0.0, 0.0, 1.0], (len(q), 1))
    points = normal + q[:, 1:] * axis
    return Analytic(points, triangles, np.zeros(len(q)), np.ones(len(q)), axis, normal)


def torus(count: int, stretch: float, seed: int = 0) -> Analytic:
    """Radii 1 and 0.4."""
    small = 0.4
    q, triangles = scattered(count, (2 * np.pi, 2 * np.pi * small), stretch, seed, both=True)
    a, b = q[:, 0], q[:, 1] / small
    ring = 1.0 + small * np.cos(b)
    points = np.stack([ring * np.cos(a), ring * np.sin(a), small * np.sin(b)], 1)
    normal = np.stack([np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b)], 1)
    along = np.stack([-np.sin(a), np.cos(a), 0 * a], 1)
    return Analytic(points, triangles, np.cos(b) / ring, np.full(len(q), 1 / small), along, normal)


def scattered(
    count: int, size: tuple[float, float], stretch: float, seed: int, *, both: bool
) -> tuple[Floats, NDArray[np.int64]]:
    """Random points of a strip that closes round its width (and its height), and triangles Delaunay once stretched."""
    width, height = size
    q = np.random.default_rng(seed).uniform(size=(count, 2)) * size
    if not both:
        rim = np.linspace(0, width, int(np.sqrt(count * width / height)), endpoint=False)
        q = np.concatenate([q, *(np.stack([rim, np.full(len(rim), end)], 1) for end in (0.0, height))])
    shifts = [(i * width, j * height) for i in (0, -1, 1) for j in ((0, -1, 1) if both else (0,))]
    tiled = np.concatenate([q + shift for shift in shifts])
    triangles = Delaunay(tiled * [stretch, 1.0]).simplices.astype(np.int64)
    centre = tiled[triangles].mean(axis=1)
    own = (centre[:, 0] >= 0) & (centre[:, 0] < width)
    if both:
        own &= (centre[:, 1] >= 0) & (centre[:, 1] < height)
    a, b, c = np.moveaxis(tiled[triangles], 1, 0)
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    return q, triangles[own & (area > 1e-12)] % len(q)
