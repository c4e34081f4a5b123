"""The picture of a cloud on its way to a surface: the points, the polyhedron through them, the fitted surface."""

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from subdfit.draw.fit_picture import SURFACE
from subdfit.draw.gallery import Panel, gallery

DOT = 2e-4
"""Length of the stroke that stands for a point, as a share of the diagonal: its round ends make a dot."""

GROUND = (0.97, 0.97, 0.96)
"""Colour of the polyhedron that hides the points on its far side."""


def cloud_picture(
    path: str | Path,
    *,
    points: ArrayLike,
    mesh: tuple[ArrayLike, ArrayLike],
    surface: tuple[ArrayLike, ArrayLike, ArrayLike, int] | None = None,
    title: str = "",
) -> None:
    """Write a PNG of two or three views side by side, after Figure 2 of Cheng et al.

    Parameters
    ----------
    path
        The PNG; written whole or not at all.
    points : (n, 3) the cloud.
    mesh : points and (m, 3) triangles of the polyhedron.
    surface : points and triangles of the tessellated limit surface, the (k, 2, 3) segments on it that draw the control
        mesh's edges, and the number of control vertices; None where there is none.
    title : one line over the picture.

    Raises
    ------
    InputError
        A mesh has no triangle.
    MachineError
        The file cannot be written.
    """
    cloud = np.asarray(points, np.float64)
    vertices, triangles = np.asarray(mesh[0], np.float64), np.asarray(mesh[1], np.int64)
    panels = [
        Panel(
            vertices,
            triangles,
            f"{len(cloud):,} points",
            colors=GROUND,
            lines=_dots(cloud),
            line_width=float(np.clip(1.6 * (10_000 / max(len(cloud), 1)) ** 0.5, 0.3, 1.8)),
        ),
        Panel(
            vertices,
            triangles,
            f"polyhedron: {len(np.unique(triangles)):,} vertices, {len(triangles):,} triangles",
            lines=_sides(vertices, triangles),
            line_width=float(np.clip(0.4 * (30_000 / max(len(triangles), 1)) ** 0.5, 0.1, 0.5)),
        ),
    ]
    if surface is not None:
        caption = f"surface: {surface[3]:,} control vertices"
        panels.append(Panel(surface[0], surface[1], caption, colors=SURFACE, lines=surface[2], line_width=0.5))
    gallery(path, panels, title=title, panel_width=4.3)


def _dots(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Strokes (n, 2, 3) as good as points."""
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    return np.stack([points, points + DOT * diagonal], axis=1)


def _sides(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    """The edges as segments, (k, 2, 3), each once."""
    ends = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])
    segments: NDArray[np.float64] = points[np.unique(np.sort(ends, axis=1), axis=0)]
    return segments
