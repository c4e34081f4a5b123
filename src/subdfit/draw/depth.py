"""The depth of a picture on a grid of cells: which points are hidden, and which lie in a hollow."""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

_REACH = (0.010, 0.045)
"""Widths of the soft shadows, as shares of the picture's larger side."""

_STRENGTH = (0.30, 0.28)
"""How much light the deepest hollow loses, for each reach."""

_BEHIND = 3.0
"""A point is hidden when it lies this many cells behind all that is nearest around it."""


class DepthPicture:
    """Heights of the points nearest to the viewer, in square cells of a camera's window.

    Parameters
    ----------
    seen : (n, 3) float32, from `Camera.project`: right, up, and the height towards the viewer.
    window : left, right, bottom and top of the picture.
    cells : number of cells along its larger side.
    """

    def __init__(self, seen: NDArray[np.float32], window: tuple[float, float, float, float], cells: int) -> None:
        left, right, bottom, top = window
        self._side = max(right - left, top - bottom)
        self._cell = self._side / cells
        self._corner = np.array([left, bottom], np.float32)
        self._shape = (int((right - left) / self._cell) + 1, int((top - bottom) / self._cell) + 1)
        self._height = np.full(self._shape, -np.inf, np.float32)
        np.maximum.at(self._height, self._cells(seen), seen[:, 2])

    def hides(self, seen: NDArray[np.float32]) -> NDArray[np.bool_]:
        """Return (m,) whether points lie behind a gapless front of the points that made the picture."""
        front = ndimage.minimum_filter(self._height, size=3, mode="nearest")
        return np.asarray(seen[:, 2] < front[self._cells(seen)] - _BEHIND * self._cell)

    def openness(self, seen: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return (m,) how freely points see the sky, from the depth alone; 1 is free.

        The depth is compared with its own blurred copy: what lies below its surroundings darkens (Luft, Colditz
        and Deussen 2006, "Image enhancement by unsharp masking the depth buffer").
        """
        known = np.isfinite(self._height)
        weight, height = known.astype(np.float32), np.where(known, self._height, np.float32(0.0))
        cells = self._cells(seen)
        free = np.ones(len(seen), np.float32)
        for reach, strength in zip(_REACH, _STRENGTH, strict=True):
            width = reach * self._side / self._cell
            near = ndimage.gaussian_filter(weight, width)
            around = ndimage.gaussian_filter(height, width) / np.maximum(near, 1e-6)
            below = np.clip((around[cells] - seen[:, 2]) / (reach * self._side), 0.0, 1.0)
            free *= 1.0 - strength * below
        return free

    def _cells(self, seen: NDArray[np.float32]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        at = ((seen[:, :2] - self._corner) / self._cell).astype(np.int64)
        return np.clip(at[:, 0], 0, self._shape[0] - 1), np.clip(at[:, 1], 0, self._shape[1] - 1)
