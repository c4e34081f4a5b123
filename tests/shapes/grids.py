"""Grids of vertices: the quads between their rows and columns, and triangles."""

import numpy as np
from numpy.typing import NDArray

Rows = NDArray[np.int64]


def vertices(rows: int, columns: int) -> Rows:
    """Numbers of the vertices of a grid, (rows, columns), row by row."""
    return np.arange(rows * columns).reshape(rows, columns)


def quads_of(grid: Rows) -> Rows:
    """Quads (q, 4) of a grid (r, c), each from its first vertex down to the next row; of ``grid.T`` the other way."""
    return np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], -1).reshape(-1, 4)


def triangles_of(grid: Rows) -> Rows:
    """The same quads cut in two, (2 q, 3)."""
    return cut(quads_of(grid))


def cut(quads: Rows) -> Rows:
    """Triangles (2 q, 3): quads (q, 4) cut from their first corner to their third."""
    return np.ascontiguousarray(np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


def wrapped(grid: Rows) -> Rows:
    """A grid whose last column is the first once more, (r, c + 1)."""
    return np.column_stack([grid, grid[:, 0]])
