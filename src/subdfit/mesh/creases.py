"""Creases of control meshes."""

from dataclasses import replace

import numpy as np

from subdfit.mesh.control_mesh import ControlMesh


def without_loose_creases(mesh: ControlMesh) -> ControlMesh:
    """Smooth the crease edges at vertices with no other sharp edge, until there are none."""
    t = mesh.topology
    sharpness = t.sharpness.copy()
    while True:
        count = np.bincount(t.edge_vertices[sharpness > 0].ravel(), minlength=t.vertex_count)
        loose = (sharpness > 0) & ~t.boundary_edges & (count[t.edge_vertices] == 1).any(axis=1)
        if not loose.any():
            return replace(mesh, topology=replace(t, sharpness=sharpness))
        sharpness[loose] = 0.0
