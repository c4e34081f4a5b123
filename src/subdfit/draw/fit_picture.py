"""The picture of a fit: the target, the control mesh on its limit surface, and where the two differ."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from subdfit.draw.camera import Camera, camera_for
from subdfit.draw.error_scale import error_bar, error_scale, percent
from subdfit.draw.page import axes_at, new_figure, text_at, write_png
from subdfit.draw.render import render
from subdfit.errors import InputError
from subdfit.wording import counted

SURFACE = (0.69, 0.79, 0.89)
"""Colour of a fitted surface."""

_PANEL, _GAP, _BAR = 4.3, 0.15, 1.75
_TITLE, _CAPTION = 0.5, 0.6
"""Inches: width of a panel, space between, room for the colour bar; height of the title and the captions."""

Mesh = tuple[ArrayLike, ArrayLike]


def fit_picture(
    path: str | Path,
    *,
    target: Mesh,
    surface: Mesh,
    surface_error: ArrayLike,
    largest: tuple[float, float],
    control_edges: ArrayLike,
    control: Mesh,
    title: str = "",
    tolerance: float | None = None,
    unit: str | None = None,
    camera: Camera | None = None,
) -> None:
    """Write a PNG of three views side by side: target, control mesh on the limit surface, error colours.

    Parameters
    ----------
    path
        The PNG; written whole or not at all.
    target : (n, 3) points and (m, 3) triangles of the mesh that was fitted.
    surface : points and triangles of the tessellated limit surface, in the same unit.
    surface_error : (triangles of `surface`,) distances between it and the target as fractions of the target's diagonal;
        signed if any is negative.
    largest : of the data to the surface and of the surface to the data, as measured, in the same fractions.
    control_edges : (k, 2, 3) segments on the limit surface that draw the control mesh's edges.
    control : points and faces of the control mesh, for its counts in the caption.
    title : one line over the picture.
    tolerance : the largest distance allowed, as a fraction of the diagonal, or None.
    unit : name of the points' unit, or None when unknown.
    camera : where to look from; ``None`` frames the target.

    Raises
    ------
    InputError
        A mesh has no triangle, or there is not one error a triangle of `surface`.
    MachineError
        The file cannot be written.
    """
    errors = np.asarray(surface_error, np.float64)
    if errors.shape != (len(np.asarray(surface[1])),):
        raise InputError(
            f"surface_error has the shape {errors.shape}: give one number for each of the "
            f"{len(np.asarray(surface[1]))} triangles of the surface"
        )
    view = camera or camera_for(*target)
    scale = error_scale(errors, tolerance)
    figure, height = _figure(view, title)
    points, faces = np.asarray(target[0]), np.asarray(target[1])
    axes = [axes_at(figure, _GAP + k * (_PANEL + _GAP), _CAPTION, _PANEL, height) for k in range(3)]
    render(axes[0], points, faces, camera=view)
    edges = np.asarray(control_edges, np.float64)
    width = float(np.clip(0.5 * (60_000 / max(len(edges), 1)) ** 0.3, 0.22, 0.7))
    render(axes[1], *surface, camera=view, colors=SURFACE, lines=edges, line_width=width)
    render(axes[2], *surface, camera=view, colors=scale.cmap(scale.norm(errors))[:, :3])
    captions = (
        f"target\n{counted(len(np.unique(faces)), 'point')}, {counted(len(faces), 'triangle')}",
        "control mesh on the limit surface\n"
        f"{counted(len(np.asarray(control[0])), 'control vertex')}, {counted(len(control[1]), 'face')}",  # type: ignore[arg-type]
        "distance between the limit surface and the target, at most\n"
        f"{percent(largest[0], 4)} from data to surface, {percent(largest[1], 4)} from surface to data",
    )
    for k, caption in enumerate(captions):
        text_at(figure, _GAP + k * (_PANEL + _GAP) + _PANEL / 2, _CAPTION - 0.12, caption)
    bar_height = min(0.72 * height, 3.2)
    left = 3 * (_PANEL + _GAP) + 0.85
    cax = axes_at(figure, left, _CAPTION + 0.46 * (height - bar_height), 0.17, bar_height)
    error_bar(figure, cax, scale, _diagonal(points, faces), unit)
    write_png(path, figure)


def _figure(view: Camera, title: str) -> tuple[Figure, float]:
    """Return the empty figure with its title, and the height of a panel in inches."""
    height = float(np.clip(_PANEL / view.aspect, 0.45 * _PANEL, 1.35 * _PANEL))
    top = _TITLE if title else 0.1
    figure = new_figure(3 * _PANEL + 4 * _GAP + _BAR, _CAPTION + height + top)
    if title:
        text_at(figure, (3 * _PANEL + 4 * _GAP + _BAR) / 2, _CAPTION + height + top - 0.12, title, size=13, bold=True)
    return figure, height


def _diagonal(points: NDArray[np.floating], faces: NDArray[np.integer]) -> float:
    """Return the bounding box diagonal of the points that a face uses."""
    used = points[np.unique(faces)]
    return float(np.linalg.norm(used.max(axis=0) - used.min(axis=0)))
