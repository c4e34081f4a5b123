"""Which edges of a control mesh are creases, as the option ``creases`` says."""

from dataclasses import replace

import numpy as np

from subdfit.api.triangulate import triangles_of
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.target.features import automatic_creases, crease_edges
from subdfit.target.target import Creases


def with_creases(mesh: ControlMesh, creases: Creases) -> ControlMesh:
    """Tag a mesh's creases afresh; corners stay.

    Parameters
    ----------
    creases
        ``auto`` keeps the mesh's own, or where it has none finds those that are surely sharp; ``none`` takes all away;
        a number takes the edges that bend by more than so many degrees. Polygons bend like the triangles beside the
        edge that they are cut into.
    """
    t = mesh.topology
    if creases == "auto" and len(t.crease_edges):
        return mesh
    sharpness = np.where(t.boundary_edges, t.sharpness, 0.0)
    if creases != "none":
        triangles = triangles_of(mesh.to_data())
        if creases == "auto":
            ends = automatic_creases(mesh.points, triangles)
        else:
            ends = crease_edges(mesh.points, triangles, creases)
        own, found = np.sort(t.edge_vertices, axis=1).astype(np.int64), np.sort(ends, axis=1)
        sharp = np.isin(own[:, 0] * t.vertex_count + own[:, 1], found[:, 0] * t.vertex_count + found[:, 1])
        sharpness[sharp & ~t.boundary_edges] = np.inf
    if np.array_equal(sharpness, t.sharpness):
        return mesh
    return replace(mesh, topology=t.with_sharpness(sharpness))
