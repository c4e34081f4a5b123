"""A block with a round hole through it, whose faces and edges are known exactly."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay

Floats = NDArray[np.float64]


def drilled_block(
    step: float = 0.1, size: tuple[float, float, float] = (3.0, 2.0, 1.0), radius: float = 0.6
) -> tuple[Floats, NDArray[np.int64]]:
    """A block from the origin on, with a hole along z in the middle: points (n, 3) and triangles (m, 3)."""
    centre = np.array(size[:2]) / 2
    x, y = (np.linspace(0, s, round(s / step) + 1) for s in size[:2])
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), -1).reshape(-1, 2)
    grid = grid[np.hypot(*(grid - centre).T) > radius + 0.6 * step]
    count = max(12, round(2 * np.pi * radius / step))
    angle = 2 * np.pi * np.arange(count) / count
    hole = centre + radius * np.stack([np.cos(angle), np.sin(angle)], 1)
    flat = np.concatenate([grid, hole])
    lid = Delaunay(flat, qhull_options="QJ Pp").simplices.astype(np.int64)
    a, b, c = np.moveaxis(flat[lid], 1, 0)
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    lid = np.where((area > 0)[:, None], lid, lid[:, ::-1])[np.abs(area) > 1e-6]
    lid = lid[np.hypot(*(flat[lid].mean(axis=1) - centre).T) > radius * np.cos(np.pi / count)]
    layers = round(size[2] / step)
    z = np.linspace(0, size[2], layers + 1)
    n = len(flat)
    points = np.concatenate([np.column_stack([flat, np.full(n, height)]) for height in z])
    sides = lid[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    known = {(a, b) for a, b in sides.tolist()}
    rim = np.array([(a, b) for a, b in sides.tolist() if (b, a) not in known])
    walls = []
    for k in range(layers):
        low, high = rim + k * n, rim + (k + 1) * n
        walls += [np.column_stack([low, high[:, 1]]), np.column_stack([low[:, 0], high[:, ::-1]])]
    triangles = np.concatenate([lid[:, ::-1], lid + layers * n, *walls])
    used, rows = np.unique(triangles, return_inverse=True)
    return points[used], rows.reshape(-1, 3)


def distance_from_edges(
    points: Floats, size: tuple[float, float, float] = (3.0, 2.0, 1.0), radius: float = 0.6
) -> Floats:
    """Distances (k,) of points from the nearest sharp edge of the block."""
    x, y, z = points.T
    off = [np.minimum(np.abs(v), np.abs(v - s)) for v, s in zip((x, y, z), size, strict=True)]
    beyond = [np.maximum(np.maximum(-v, v - s), 0) for v, s in zip((x, y, z), size, strict=True)]
    straight = [np.sqrt(off[i] ** 2 + off[j] ** 2 + beyond[k] ** 2) for i, j, k in ((0, 1, 2), (0, 2, 1), (1, 2, 0))]
    ring = np.hypot(x - size[0] / 2, y - size[1] / 2) - radius
    return np.asarray(np.min([*straight, np.hypot(ring, off[2])], axis=0))
