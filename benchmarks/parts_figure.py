"""The picture of parts like Lavoue et al.'s Figures 12 and 13: control meshes, and limit surfaces with the patches."""

import sys
from pathlib import Path

import numpy as np

import subdfit
from benchmarks.common import MODELS
from subdfit.api.triangulate import triangles_of
from subdfit.draw.camera import camera_for
from subdfit.draw.fit_picture import SURFACE
from subdfit.draw.gallery import Panel, gallery
from subdfit.limit.surface import LimitSurface

FITS = (
    ("block", {"method": "lavoue"}),
    ("casting", {"method": "lavoue"}),
    ("club", {"thin": True}),
    ("rocker-arm", {"method": "lavoue"}),
)
LEVEL = 4
"""Patches are drawn as 4^LEVEL facets or twice as many, and lines along their sides with the facets."""
EDGE, CREASE = (0.11, 0.15, 0.2), (0.75, 0.22, 0.17)
"""Colours of lines."""


def draw(path: str | Path) -> None:
    """Write the picture, a column a part."""
    columns = [column(name, **how) for name, how in FITS]
    gallery(path, [panels[k] for k in range(2) for panels in columns], columns=len(columns), panel_width=3.6)


def column(name: str, **how: object) -> list[Panel]:
    """One part: its control mesh, and the limit surface that lies within .3 % of it."""
    found = subdfit.fit(MODELS / f"{name}.ply", max_error="0.3%", scheme="quad-triangle", **how)
    mesh, topology = found.control_mesh, found.control_mesh.topology
    flat = mesh.points, triangles_of(mesh.to_data())
    ends = mesh.points[topology.edge_vertices]
    shown = found.surface.tessellate(LEVEL)
    camera = camera_for(*flat)
    counts = f"{topology.vertex_count} control vertices, {topology.face_count} faces"
    lines, sharp = patch_sides(LimitSurface(mesh))
    errors = f"largest error {100 * found.measurement.max:.2f} %" + (", certified" if found.certified else "")
    return [
        Panel(*flat, f"{name}: {counts}", colors=(0.97, 0.97, 0.96), lines=ends, camera=camera,
              line_colors=colors(topology.sharpness > 0), line_width=0.6),
        Panel(shown.points, shown.triangles, errors, colors=SURFACE, lines=lines, camera=camera,
              line_colors=colors(sharp), line_width=0.6),
    ]  # fmt: skip


def patch_sides(surface: LimitSurface) -> tuple[np.ndarray, np.ndarray]:
    """Short segments along the sides of all patches, (k, 2, 3), and which are sharp, (k,)."""
    domain = surface.domain
    cell, side = np.nonzero(domain.present)
    knots = np.linspace(0, 1, 2**LEVEL + 1)
    uv = domain.along(np.repeat(cell, len(knots)), np.repeat(side, len(knots)), np.tile(knots, len(cell)))
    at = surface.evaluate(np.repeat(cell, len(knots)).astype(np.int32), uv).position.reshape(-1, len(knots), 3)
    lines = np.stack([at[:, :-1], at[:, 1:]], axis=2).reshape(-1, 2, 3)
    return lines, np.repeat(domain.sharp[cell, side], 2**LEVEL)


def colors(sharp: np.ndarray) -> np.ndarray:
    """Colours of lines, (k, 3), sharp ones in red."""
    return np.where(sharp[:, None], CREASE, EDGE)


if __name__ == "__main__":
    draw(sys.argv[1] if len(sys.argv) > 1 else "parts.png")
