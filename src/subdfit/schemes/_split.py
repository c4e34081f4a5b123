"""One step of refinement of a topology: triangles in four, other faces in a quad a corner."""

import numpy as np

from subdfit.mesh.topology import Creases, Topology
from subdfit.schemes import _split_kernels as kernels
from subdfit.schemes._stencils import later


def split(t: Topology, quads_from: int) -> Topology:
    """Cut faces of `quads_from` corners or more in a quad a corner, smaller ones (triangles) in four.

    Vertices keep their rows; the new vertex of edge e is row n + e; the centroids of the faces cut in quads follow in
    the faces' order. The first half of half-edge h is half-edge 4 h. A triangle's children keep its order, one at each
    corner and then the middle one turned by half; a quad begins at its corner, and runs over the middle of h, the
    centroid and the middle before.
    """
    n, size = t.vertex_count, np.diff(t.face_offsets)
    quads = size >= quads_from
    offsets = np.empty(int(np.where(quads, size, 4).sum()) + 1, np.int32)
    corners, twin = np.empty(4 * len(t.twin), np.int32), np.full(4 * len(t.twin), -1, np.int32)
    mesh = (t.face_offsets, t.face_vertices, t.following, t.face, t.twin, t.edge)
    kernels.split_faces(*mesh, n, t.edge_count, quads_from, offsets, corners, twin)
    # An edge's two halves are the first halves of its half-edges; those of the boundary are sharp anyway.
    halves = 4 * t.creases.half_edges
    creases = Creases.of(np.concatenate([halves, twin[halves]]), np.tile(later(t.creases.sharpness), 2))
    child = Topology.from_twins(offsets, corners, twin, n + t.edge_count + int(np.count_nonzero(quads)), creases)
    child.corner_sharpness[:n] = later(t.corner_sharpness)
    return child
