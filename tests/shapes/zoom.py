"""A second evaluator, which knows nothing of patches: refine, keep only what surrounds the point, refine again."""

import numpy as np

from shapes.parameters import CORNERS, DUAL, child_of, face_corners
from shapes.zoo import mesh_of
from subdfit.mesh.topology import Topology
from subdfit.schemes import SCHEMES


def can_be_cut_out(scheme, name):
    """Whether refinement of a part is that of the whole.

    For dual schemes the edge of a part is a curve, which joins those that are there already.
    """
    t = mesh_of(name).topology
    return scheme not in DUAL or not ((t.sharpness > 0).any() or (t.corner_sharpness > 0).any())


def neighbourhood(topology, points, face, rings=1):
    """Cut out the faces that touch `face`, with their tags; returns (topology, points, row of the face)."""
    t, touching = topology, np.array([face])
    for _ in range(rings):
        touching = np.unique(t.face[np.isin(t.face_vertices, t.face_vertices[np.isin(t.face, touching)])])
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


def dual_neighbourhood(topology, points, cell):
    """The same for the cell of a face corner; faces at the edge of the cut have masks of their own."""
    corner = face_corners(topology)[cell]
    face = topology.face[corner]
    cut, kept, row = neighbourhood(topology, points, face, rings=2)
    corner = cut.face_offsets[row] + corner - topology.face_offsets[face]
    return cut, kept, int(np.searchsorted(face_corners(cut), corner))


def zoom(scheme_name, mesh, cell, uv, levels=30):
    """The limit point at (u, v) of one cell, by refinement alone.

    The last face's limit corners are interpolated linearly, which errs by the square of its size. Of a dual scheme's
    last cell, which is smaller, the limit of one corner is taken.
    """
    levels = 44 if scheme_name in DUAL else levels
    scheme = SCHEMES[scheme_name]
    topology, points, uv = mesh.topology, mesh.points, np.asarray(uv)[None]
    for level in range(levels):
        step = scheme.refine(topology)
        (cell,), uv, _ = child_of(scheme_name, topology, [cell], uv)
        topology, points = step.child, step.refined(points)
        # Only from the second level on does a face's neighbourhood not touch itself again; cells are faces by then.
        if level >= 1 and scheme_name in DUAL:
            topology, points, cell = dual_neighbourhood(topology, points, cell)
        elif level >= 1:
            topology, points, cell = neighbourhood(topology, points, cell)
    if scheme_name in DUAL:
        return (scheme.limit_rows(topology) @ points)[topology.face_vertices[face_corners(topology)[cell]]]
    corners = topology.face_vertices[topology.face == cell]
    limits = (scheme.limit_rows(topology) @ points)[corners]
    (u, v), n = uv[0], len(corners)
    weights = [1 - u - v, u, v] if n == 3 else [(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v]
    assert len(CORNERS[n]) == n
    return np.array(weights) @ limits
