"""The picture of Cheng et al.'s four models: data points, simplified polyhedra, Doo-Sabin surfaces through these."""

from pathlib import Path

import numpy as np

import subdfit
from benchmarks.interpolation import TABLE_1, cube_with_hole, model
from subdfit.draw.camera import camera_for
from subdfit.draw.cloud_picture import dots
from subdfit.draw.fit_picture import SURFACE
from subdfit.draw.gallery import Panel, gallery
from subdfit.initial.simplify import simplify
from subdfit.target.features import mesh_edges

DOTS = 6000
"""About so many of the data points are drawn."""
UP = {"goblet": "z"}
"""Models that do not stand along y."""


def draw(path: str | Path) -> None:
    """Write the picture, a column a model."""
    columns = [column(*row[:3]) for row in TABLE_1]
    gallery(path, [panels[k] for k in range(3) for panels in columns], columns=len(columns), panel_width=3.2)


def column(name: str, count: int, vertices: int) -> list[Panel]:
    """One model: refined to the paper's number of points, reconstructed from these, simplified, interpolated."""
    mesh = cube_with_hole() if name == "cube with a hole" else model(name)
    while mesh.topology.vertex_count < count:
        mesh = subdfit.subdivide(mesh, 1, "loop")
    points = simplify(mesh.points, mesh.topology.triangles.astype(np.int64), vertices=count, keep_points=True).points
    polyhedron = subdfit.reconstruct(points, vertices=vertices, keep_data_points=True).mesh
    triangles = polyhedron.face_vertices.reshape(-1, 3)
    surface = subdfit.interpolate(polyhedron, scheme="doo-sabin", creases="none").surface.tessellate(1)
    lines = polyhedron.points[mesh_edges(polyhedron.points, triangles).vertices]
    shown = polyhedron.points, triangles
    strokes, anchors = dots(points[:: -(-len(points) // DOTS)], shown)
    camera = camera_for(*shown, up=UP.get(name, "y"))
    return [
        Panel(*shown, f"{name}: {len(points):,} points", colors=(0.97, 0.97, 0.96), camera=camera,
              lines=strokes, line_anchors=anchors, line_width=1.2),
        Panel(*shown, f"polyhedron: {len(polyhedron.points):,} vertices", lines=lines, line_width=0.2, camera=camera),
        Panel(surface.points, surface.triangles, "Doo-Sabin surface through them", colors=SURFACE, camera=camera),
    ]  # fmt: skip


if __name__ == "__main__":
    draw("points-paper.png")
