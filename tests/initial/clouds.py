"""Clouds sampled at random or in grids from surfaces that are known."""

import numpy as np


def sphere(count, seed=0):
    """Return points spread evenly at random over the unit sphere."""
    points = np.random.default_rng(seed).standard_normal((count, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def torus(count, seed=0):
    """Return points on a torus of radii 2 and 0.7, spread evenly by rejection."""
    rng = np.random.default_rng(seed)
    u, v = 2 * np.pi * rng.random((2, 2 * count))
    kept = np.flatnonzero(2.7 * rng.random(2 * count) < 2 + 0.7 * np.cos(v))[:count]
    u, v = u[kept], v[kept]
    around = 2 + 0.7 * np.cos(v)
    return np.stack([around * np.cos(u), around * np.sin(u), 0.7 * np.sin(v)], axis=1)


def square(count, hole=0.0, seed=0):
    """Return points of the flat unit square outside a circle round its middle."""
    points = np.random.default_rng(seed).random((count, 3)) * [1, 1, 0]
    return points[np.linalg.norm(points[:, :2] - 0.5, axis=1) >= hole]


def grid(*axes):
    """Return all points whose coordinates are on the axes."""
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def box(steps):
    """Return the grid points on the faces of the unit cube: all cells at the surface are cospherical."""
    points = grid(*[np.linspace(0, 1, steps + 1)] * 3)
    return points[((points == 0) | (points == 1)).any(axis=1)]


def globe(parallels, meridians):
    """Return the poles, and points on circles of latitude, coplanar and cocircular."""
    polar = np.linspace(0, np.pi, parallels + 2)[1:-1, None]
    around = np.linspace(0, 2 * np.pi, meridians, endpoint=False)
    rings = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar) + 0 * around], -1)
    return np.concatenate([rings.reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
