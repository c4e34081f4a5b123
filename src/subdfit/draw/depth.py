"""What is seen first in a picture, on a grid of samples."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.draw._kernels import mean_colors, paint_nearest
from subdfit.draw.camera import Camera

SAMPLES = 4
"""A pixel is the mean of so many samples each way."""

_BEHIND = 3.0
"""A point is hidden when it lies so many cells behind all samples around it."""

_AROUND = range(-1, 3)
"""Columns and rows of the samples around a point, from the sample to its lower left: half a pixel each way."""


@dataclass(frozen=True)
class Grid:
    """Square cells over a picture, a sample in the middle of each.

    Attributes
    ----------
    left, bottom : corner of the picture, as `Camera.project` gives points.
    cell : side of a cell, in the same unit.
    rows, columns : numbers of cells, `SAMPLES` for each pixel.
    """

    left: float
    bottom: float
    cell: float
    rows: int
    columns: int

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Left, right, bottom and top."""
        right, top = self.left + self.columns * self.cell, self.bottom + self.rows * self.cell
        return self.left, right, self.bottom, top

    def place(self, seen: NDArray[np.floating]) -> NDArray[np.float64]:
        """Return column and row of points, (n, 2); whole numbers at samples."""
        return np.asarray((seen[:, :2] - (self.left, self.bottom)) / self.cell - 0.5, np.float64)


class DepthPicture:
    """The nearest triangle at each sample.

    Parameters
    ----------
    seen : (n, 3), from `Camera.project`: right, up, and the height towards the viewer.
    faces : (m, 3) rows of `seen`.
    camera : the one that saw them.
    grid : the samples.
    """

    def __init__(self, seen: NDArray[np.float32], faces: NDArray[np.int64], camera: Camera, grid: Grid) -> None:
        self._camera, self._grid = camera, grid
        self._face = np.full((grid.rows, grid.columns), -1, np.int32)
        self._nearness = np.zeros(self._face.shape, np.float32)
        corners = np.column_stack([grid.place(seen), camera.nearness(seen[:, 2])])
        paint_nearest(corners[faces], self._face, self._nearness)

    def colored(self, colors: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the picture of pixels, (rows, columns, 4), of faces in these colours (m, 3); clear beside them."""
        rows, columns = self._face.shape
        pixels = np.zeros((rows // SAMPLES, columns // SAMPLES, 4), np.float32)
        mean_colors(self._face, colors, pixels)
        return pixels

    def hides(self, seen: NDArray[np.floating]) -> NDArray[np.bool_]:
        """Return (m,) whether points lie behind the surface. Where it is flat the lowest sample around is below it.

        What is hidden by less than a line's width beside it counts as seen: an edge along the outline is not broken
        where facets turn it away.
        """
        column, row = np.floor(self._grid.place(seen)).astype(np.int64).T
        rows, columns = self._face.shape
        around = (
            self._nearness[np.clip(row + up, 0, rows - 1), np.clip(column + along, 0, columns - 1)]
            for up in _AROUND
            for along in _AROUND
        )
        lowest = np.minimum.reduce(list(around))
        height = self._camera.height(np.where(lowest > 0.0, lowest, 1.0))
        return np.asarray((lowest > 0.0) & (seen[:, 2] < height - _BEHIND * self._grid.cell))
