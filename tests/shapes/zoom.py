"""A second evaluator, which knows nothing of patches: refine, keep only what surrounds the point, refine again."""

import numpy as np

from shapes.parameters import CORNERS, child_of
from subdfit.mesh.topology import Topology
from subdfit.schemes import SCHEMES


def neighbourhood(topology, points, face):
    """Cut out the faces that touch `face`, with their tags; returns (topology, points, row of the face)."""
    t = topology
    own = np.isin(t.face_vertices, t.face_vertices[t.face == face])
    touching = np.unique(t.face[own])
    corners = [t.face_vertices[t.face_offsets[f] : t.face_offsets[f + 1]] for f in touching]
    kept, rows = np.unique(np.concatenate(corners), return_inverse=True)
    row = np.full(t.vertex_count, -1)
    row[kept] = np.arange(len(kept))
    edges = t.edge_vertices[t.crease_edges]
    inner = np.isin(edges, t.face_vertices[t.face == face]).any(axis=1) & (row[edges] >= 0).all(axis=1)
    pinned = np.flatnonzero(t.corner_sharpness[kept] > 0)
    cut = Topology.from_faces(
        np.cumsum([0, *(len(c) for c in corners)]),
        rows,
        len(kept),
        crease_edges=row[edges[inner]],
        crease_sharpness=t.sharpness[t.crease_edges[inner]],
        corner_vertices=pinned,
        corner_sharpness=t.corner_sharpness[kept][pinned],
    )
    return cut, points[kept], int(np.searchsorted(touching, face))


def zoom(scheme_name, mesh, cell, uv, levels=30):
    """The limit point at (u, v) of one cell, by refinement alone.

    The last face's limit corners are interpolated linearly, which errs by the square of its size.
    """
    scheme = SCHEMES[scheme_name]
    topology, points, uv = mesh.topology, mesh.points, np.asarray(uv)[None]
    for level in range(levels):
        step = scheme.refine(topology)
        (cell,), uv, _ = child_of(scheme_name, topology, [cell], uv)
        topology, points = step.child, step.matrix @ points
        # Only from the second level on does a face's neighbourhood not touch itself again; cells are faces by then.
        if level >= 1:
            topology, points, cell = neighbourhood(topology, points, cell)
    corners = topology.face_vertices[topology.face == cell]
    limits = (scheme.limit_rows(topology) @ points)[corners]
    (u, v), n = uv[0], len(corners)
    weights = [1 - u - v, u, v] if n == 3 else [(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v]
    assert len(CORNERS[n]) == n
    return np.array(weights) @ limits
