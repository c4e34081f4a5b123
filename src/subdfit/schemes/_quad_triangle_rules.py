"""Quad-triangle refinement: the split of triangles and larger faces, and the rules of Stam and Loop (2003)."""

import numpy as np

from subdfit.mesh.topology import Topology
from subdfit.schemes import _quad_triangle_kernels as kernels
from subdfit.schemes import _quad_triangle_masks as masks
from subdfit.schemes._level import preceding
from subdfit.schemes._quad_triangle_kinds import by_order, larger_round
from subdfit.schemes._stencils import BESIDE_POLYGON, BESIDE_TRIANGLE, SmoothRules, Stencils, VertexMask, later
from subdfit.schemes.scheme import Refinement


def refine(t: Topology) -> Refinement:
    """One step of subdivision, see `split`.

    Vertices keep their rows; the new vertex of edge e is row n + e; the centroids of the faces that are no triangles
    follow in the faces' order.
    """
    rows = np.arange(t.vertex_count + t.edge_count)
    return Refinement(split(t), Stencils(t, _RULES), rows[: t.vertex_count], rows[t.vertex_count :])


def split(t: Topology) -> Topology:
    """Cut triangles in four, one at each corner and the middle one, and any other face in a quad a corner.

    The first half of half-edge h is half-edge 4 h. A triangle's children keep its order, the middle one turned by half;
    a quad begins at its corner, and runs over the middle of h, the centroid and the middle before.
    """
    n, size = t.vertex_count, np.diff(t.face_offsets)
    mesh = (t.face_offsets, t.face_vertices, t.following, t.face, t.twin, t.edge)
    offsets, corners, twin = kernels.split_faces(*mesh, n, t.edge_count)
    child = Topology.from_twins(offsets, corners, twin, n + t.edge_count + int(np.count_nonzero(size > 3)))
    # An inner edge's two halves are the first halves of its half-edges; those of the boundary are sharp already.
    sharp = np.flatnonzero((t.sharpness > 0)[t.edge])
    child.sharpness[child.edge[4 * sharp]] = later(t.sharpness[t.edge[sharp]])
    child.corner_sharpness[:n] = later(t.corner_sharpness)
    return child


def _vertex_mask(t: Topology) -> VertexMask:
    """The smooth vertex rule, corrected where triangles meet quads."""
    quads = larger_round(t, 3)
    mixed = (quads > 0) & (quads < t.valence)
    mixed[t.ends(t.boundary_edges)] = False
    vertices = np.flatnonzero(mixed)
    correction = np.zeros(t.vertex_count)
    for order, chosen in by_order(t, preceding(t), t.outgoing[vertices]):
        correction[vertices[chosen]] = masks.correction(order)
    return masks.smooth_mask(t.valence, quads, correction)


_RULES = SmoothRules(_vertex_mask, BESIDE_TRIANGLE, BESIDE_POLYGON, centroids_from=4)
