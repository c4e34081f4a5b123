"""Small machined parts, well meshed."""

import numpy as np
from numpy.typing import NDArray

from shapes import grids


def can(
    sections: int = 40, rows: int = 20, radius: float = 1.0, height: float = 3.0
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """A closed cylinder round z, centred: a wall of a grid of triangles, and lids of rings."""
    rings = max(2, round(sections / (2 * np.pi)))
    z = np.concatenate([np.full(rings, -0.5), np.linspace(-0.5, 0.5, rows + 1)[1:-1], np.full(rings, 0.5)]) * height
    r = np.concatenate([np.arange(1, rings + 1) / rings, np.ones(rows - 1), np.arange(rings, 0, -1) / rings]) * radius
    angle = 2 * np.pi * np.arange(sections) / sections
    wall = np.stack([np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle)), np.outer(z, np.ones(sections))], -1)
    i = grids.vertices(*wall.shape[:2])
    low, high = i.size, i.size + 1
    fans = [np.stack([np.roll(i[0], -1), i[0], np.full(sections, low)], 1)]
    fans.append(np.stack([i[-1], np.roll(i[-1], -1), np.full(sections, high)], 1))
    points = np.concatenate([wall.reshape(-1, 3), [[0, 0, -height / 2], [0, 0, height / 2]]])
    return points, np.concatenate([grids.triangles_of(grids.wrapped(i).T), *fans])


def shaft(sections: int = 48, step: float = 0.12) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """A closed stepped shaft round z: two cylinders of radii 1 and .5, two lids, and a ring between."""
    stops = np.array([[0, -1], [1, -1], [1, 0.2], [0.5, 0.2], [0.5, 1.4], [0, 1.4]])
    count = np.ceil(np.linalg.norm(np.diff(stops, axis=0), axis=1) / step).astype(int)
    along = np.repeat(np.arange(len(count)), count) + np.concatenate([np.arange(k) / k for k in count])
    r, z = (np.interp(along, np.arange(len(stops)), column) for column in stops.T)
    r, z = np.append(r, 0.0)[1:-1], np.append(z, 1.4)[1:-1]
    angle = 2 * np.pi * np.arange(sections) / sections
    rings = np.stack([np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle)), np.outer(z, np.ones(sections))], -1)
    i = grids.vertices(*rings.shape[:2])
    fans = [np.stack([np.roll(i[0], -1), i[0], np.full(sections, i.size)], 1)]
    fans.append(np.stack([i[-1], np.roll(i[-1], -1), np.full(sections, i.size + 1)], 1))
    points = np.concatenate([rings.reshape(-1, 3), [[0, 0, -1], [0, 0, 1.4]]])
    return points, np.concatenate([grids.triangles_of(grids.wrapped(i).T), *fans])
