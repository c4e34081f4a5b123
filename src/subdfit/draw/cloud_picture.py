"""The picture of a cloud on its way to a surface: the points, the polyhedron through them, the fitted surface."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from subdfit.draw.camera import camera_for
from subdfit.draw.fit_picture import SURFACE, Mesh
from subdfit.draw.gallery import Panel, gallery
from subdfit.target.bvh import TriangleTree
from subdfit.target.features import mesh_edges
from subdfit.wording import counted

_DOT = 2e-4
"""Length of the stroke that stands for a point, as a share of the diagonal: its round ends make a dot."""

GROUND = (0.97, 0.97, 0.96)
"""Colour of the polyhedron that hides the points on its far side."""


def cloud_picture(
    path: str | Path,
    *,
    points: ArrayLike,
    mesh: Mesh,
    surface: tuple[ArrayLike, ArrayLike, ArrayLike | None, int] | None = None,
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
        mesh's edges or None, and the number of control vertices; None where there is none.
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
    panels = [_points_panel(cloud, (vertices, triangles)), _polyhedron_panel(vertices, triangles)]
    if surface is not None:
        caption = f"surface: {counted(surface[3], 'control vertex')}"
        panels.append(Panel(surface[0], surface[1], caption, colors=SURFACE, lines=surface[2], line_width=0.5))
    panels[0] = replace(panels[0], camera=camera_for(*_together(panels)))
    gallery(path, panels, title=title, panel_width=4.3)


def _together(panels: list[Panel]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Vertices and triangles of all panels, which the camera frames: the surface may bulge beyond the polyhedron."""
    offsets = np.cumsum([0, *(len(np.asarray(panel.vertices)) for panel in panels[:-1])])
    triangles = [np.asarray(panel.triangles) + start for panel, start in zip(panels, offsets, strict=True)]
    return np.concatenate([np.asarray(panel.vertices, np.float64) for panel in panels]), np.concatenate(triangles)


def dots(points: NDArray[np.float64], mesh: Mesh) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lines that stand for points near a mesh, and their anchors, for `Panel`.

    Points are seen where the nearest place on the mesh is, even if they lie below its facets.
    """
    vertices, triangles = np.asarray(mesh[0], np.float64), np.asarray(mesh[1], np.int64)
    nearest = TriangleTree(vertices, triangles).closest(points)
    shares = np.column_stack([1.0 - nearest.uv.sum(axis=1), nearest.uv])
    feet = np.einsum("pc,pci->pi", shares, vertices[triangles[nearest.triangle]])
    stroke = np.array([0.0, _DOT * np.linalg.norm(np.ptp(points, axis=0))])[None, :, None]
    return points[:, None] + stroke, feet[:, None] + stroke


def _points_panel(cloud: NDArray[np.float64], mesh: Mesh) -> Panel:
    """The points, before the polyhedron that hides those on its far side."""
    lines, anchors = dots(cloud, mesh)
    return Panel(
        *mesh,
        counted(len(cloud), "point"),
        colors=GROUND,
        lines=lines,
        line_anchors=anchors,
        line_width=float(np.clip(1.6 * (10_000 / max(len(cloud), 1)) ** 0.5, 0.3, 1.8)),
    )


def _polyhedron_panel(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> Panel:
    """The polyhedron with all its edges."""
    return Panel(
        vertices,
        triangles,
        f"polyhedron: {counted(len(np.unique(triangles)), 'vertex')}, {counted(len(triangles), 'triangle')}",
        lines=vertices[mesh_edges(vertices, triangles).vertices],
        line_width=float(np.clip(0.4 * (30_000 / max(len(triangles), 1)) ** 0.5, 0.1, 0.5)),
    )
