"""The picture of surfaces like those of Lavoue et al.'s Figure 12: targets, control meshes, limit surfaces."""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from tests.shapes.paper_patches import Mesh, boss, cushion, tube

from benchmarks.parts import open_start
from benchmarks.parts_figure import EDGE, LEVEL, patch_sides
from subdfit.api.surface import LimitSurface
from subdfit.api.triangulate import triangles_of
from subdfit.draw.camera import camera_for
from subdfit.draw.fit_picture import SURFACE
from subdfit.draw.gallery import Panel, gallery
from subdfit.fit.lavoue_open import fit_open
from subdfit.target.curvature import curvature_field
from subdfit.target.features import mesh_edges
from subdfit.target.target import mesh_target

VIEWS = {cushion: (25.0, 20.0), boss: (20.0, 40.0), tube: (32.0, 25.0)}
"""From where each is seen: azimuth and elevation in degrees."""
PALE = (0.97, 0.97, 0.96)


def draw(path: str | Path) -> None:
    """Write the picture, a row a surface."""
    gallery(path, [panel for make in VIEWS for panel in row(make)], columns=3, panel_width=3.6)


def row(make: Callable[[], Mesh]) -> list[Panel]:
    """One surface: its mesh, the control mesh within .005 of its side, and the limit surface with the patches."""
    points, triangles = make()
    side = float(np.ptp(points, axis=0).max())
    start = open_start(points, triangles, 5e-3 * side)
    found = fit_open(start, mesh_target(points, triangles), curvature_field(points, triangles))
    mesh, topology, surface = found.mesh, found.mesh.topology, LimitSurface(found.mesh)
    shown, cage = surface.tessellate(LEVEL), triangles_of(mesh.to_data())
    both = np.concatenate([points, mesh.points]), np.concatenate([triangles, cage + len(points)])
    azimuth, elevation = VIEWS[make]
    camera = camera_for(*both, azimuth=azimuth, elevation=elevation)
    sides = points[mesh_edges(points, triangles).vertices]
    counts = f"{topology.vertex_count} control vertices, {topology.face_count} faces"
    how = {"camera": camera, "line_colors": EDGE}
    return [
        Panel(points, triangles, f"{make.__name__}: {len(points)} vertices, {len(triangles):,} triangles",
              colors=PALE, lines=sides, line_width=0.3, **how),
        Panel(mesh.points, cage, counts, colors=PALE,
              lines=mesh.points[topology.edge_vertices], line_width=0.6, **how),
        Panel(shown.points, shown.triangles, f"mean error {1000 * found.mean / side:.2f}e-3 of the side",
              colors=SURFACE, lines=patch_sides(surface)[0], line_width=0.6, **how),
    ]  # fmt: skip


if __name__ == "__main__":
    draw(sys.argv[1] if len(sys.argv) > 1 else "open-surfaces.png")
