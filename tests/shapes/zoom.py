"""A second evaluator, which knows nothing of patches: refine, keep only what surrounds the point, refine again."""

import numpy as np

from shapes.parameters import child_of
from subdfit.mesh.topology import Topology
from subdfit.schemes import SCHEMES


def neighbourhood(topology, points, face):
    """Cut out the faces that touch `face`, with their tags; returns (topology, points, row of the face)."""
    triangles = topology.triangles
    touching = np.isin(triangles, triangles[face]).any(axis=1)
    kept = np.unique(triangles[touching])
    row = np.full(topology.vertex_count, -1)
    row[kept] = np.arange(len(kept))
    edges = topology.edge_vertices[topology.crease_edges]
    inner = np.isin(edges, triangles[face]).any(axis=1)
    pinned = np.flatnonzero(topology.corner_sharpness[kept] > 0)
    cut = Topology.from_triangles(
        row[triangles[touching]], len(kept), crease_edges=row[edges[inner]], corner_vertices=pinned
    )
    return cut, points[kept], int(touching[:face].sum())


def zoom(scheme_name, mesh, face, uv, levels=30):
    """The limit point at (u, v) of one face, by refinement alone.

    The last face's limit corners are interpolated linearly, which errs by the square of its size.
    """
    scheme = SCHEMES[scheme_name]
    topology, points, uv = mesh.topology, mesh.points, np.asarray(uv)[None]
    for level in range(levels):
        step = scheme.refine(topology)
        topology, points = step.child, step.matrix @ points
        (face,), uv, _ = child_of(scheme_name, [face], uv)
        # Only from the second level on does a face's neighbourhood not touch itself again.
        if level >= 1:
            topology, points, face = neighbourhood(topology, points, face)
    corners = (scheme.limit_rows(topology) @ points)[topology.triangles[face]]
    return np.array([1 - uv.sum(), *uv[0]]) @ corners
