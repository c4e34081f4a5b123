"""The largest components of a control mesh, and of the surface through a cloud of points."""

import logging
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from subdfit.api.triangulate import triangles_of
from subdfit.initial.components import keep_components
from subdfit.initial.reconstruct import Reconstructed
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.data import MeshData
from subdfit.wording import counted

logger = logging.getLogger(__name__)


def largest_components(mesh: ControlMesh, count: int | None) -> ControlMesh:
    """Keep the components of largest area, all where `count` is None; vertices and faces stay in their order."""
    if count is None:
        return mesh
    data = mesh.to_data()
    rows = keep_components(data.points, triangles_of(data), count).point_rows
    return mesh if len(rows) == len(data.points) else ControlMesh.from_data(_part(data, rows))


def largest_of_cloud(found: Reconstructed, count: int | None, name: str) -> Reconstructed:
    """Keep the components of largest area, all where `count` is None; the points of the others are left out."""
    if count is None:
        return found
    kept = keep_components(found.points, found.triangles, count)
    stays, others = min(count, kept.component_count), len(found.points) - len(kept.points)
    logger.info(
        "%s: kept %d of %s, left %s out",
        name,
        stays,
        counted(kept.component_count, "component"),
        counted(others, "point"),
    )
    rows = found.point_rows[kept.point_rows] if len(found.point_rows) else found.point_rows
    left_out = np.union1d(found.left_out, np.setdiff1d(found.point_rows, rows))
    return replace(found, points=kept.points, triangles=kept.triangles, point_rows=rows, left_out=left_out)


def _part(data: MeshData, rows: NDArray[np.int64]) -> MeshData:
    """Chosen vertices, of whole components, with their faces and tags."""
    place = np.full(len(data.points), -1, np.int64)
    place[rows] = np.arange(len(rows))
    size = np.diff(data.face_offsets)
    corners = place[data.face_vertices]
    sizes = size[place[data.face_vertices[data.face_offsets[:-1]]] >= 0]
    creases, tagged = place[data.crease_edges], place[data.corner_vertices]
    return MeshData(
        points=data.points[rows],
        face_offsets=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64),
        face_vertices=corners[corners >= 0],
        crease_edges=creases[creases[:, 0] >= 0],
        crease_sharpness=data.crease_sharpness[creases[:, 0] >= 0],
        corner_vertices=tagged[tagged >= 0],
        corner_sharpness=data.corner_sharpness[tagged >= 0],
        scheme=data.scheme,
        interpolate_boundary=data.interpolate_boundary,
    )
