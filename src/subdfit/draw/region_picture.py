"""The picture of a segmentation: a part from four sides, each region in a colour of its own."""

import colorsys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from subdfit.draw.camera import camera_for
from subdfit.draw.gallery import Panel, gallery
from subdfit.target.features import mesh_edges

_SIDES = ((32.0, 20.0), (212.0, -20.0), (122.0, 35.0), (302.0, 50.0))
"""Azimuth and elevation in degrees."""

_GOLDEN = 0.618034
"""Steps of the golden ratio round the circle of hues keep neighbours in number apart."""


def region_picture(
    path: str | Path,
    points: NDArray[np.float64],
    triangles: NDArray[np.integer],
    labels: NDArray[np.integer],
    feature_edges: NDArray[np.integer],
    *,
    title: str = "",
) -> None:
    """Write a PNG of regions: borders in white where they are smooth, feature edges in black.

    Parameters
    ----------
    path
        The PNG; written whole or not at all.
    points, triangles : the mesh.
    labels : (m,) region of each triangle.
    feature_edges : (c, 2) rows of `points`.
    title : one line over the picture.

    Raises
    ------
    InputError
        There is no triangle.
    MachineError
        The file cannot be written.
    """
    smooth = _borders(points, triangles, labels)
    lines = np.concatenate([points[smooth], points[feature_edges]])
    ink = np.repeat([[0.95, 0.95, 0.95], [0.08, 0.09, 0.1]], [len(smooth), len(feature_edges)], axis=0)
    panels = [
        Panel(
            points,
            triangles,
            colors=region_colors(labels),
            lines=lines,
            line_colors=ink,
            line_width=0.9,
            camera=camera_for(points, triangles, azimuth=azimuth, elevation=elevation),
        )
        for azimuth, elevation in _SIDES
    ]
    gallery(path, panels, columns=2, title=title, panel_width=5.0)


def region_colors(labels: NDArray[np.integer]) -> NDArray[np.float64]:
    """A colour for each label, (m, 3)."""
    wheel = [
        colorsys.hsv_to_rgb(_GOLDEN * k % 1, 0.35 + 0.4 * (0.37 * k % 1), 0.75 + 0.25 * (0.77 * k % 1))
        for k in range(int(labels.max(initial=0)) + 1)
    ]
    return np.asarray(np.array(wheel)[labels])


def _borders(
    points: NDArray[np.float64], triangles: NDArray[np.integer], labels: NDArray[np.integer]
) -> NDArray[np.int64]:
    """Edges between two regions, (k, 2)."""
    edges = mesh_edges(points, triangles)
    sides = labels[edges.faces]
    return np.asarray(edges.vertices[(edges.valence == 2) & (sides[:, 0] != sides[:, 1])])
