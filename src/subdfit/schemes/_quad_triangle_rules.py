"""Quad-triangle refinement: the split of triangles and larger faces, and the rules of Stam and Loop (2003)."""

import numpy as np

from subdfit.mesh.topology import Topology
from subdfit.schemes import _quad_triangle_masks as masks
from subdfit.schemes._level import preceding
from subdfit.schemes._quad_triangle_kinds import by_order
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
    n, h = t.vertex_count, np.arange(len(t.face_vertices), dtype=np.int32)
    size = np.diff(t.face_offsets)
    triangle, begin = size[t.face] == 3, 4 * t.face_offsets[t.face]
    corner = h - t.face_offsets[t.face]
    large = np.cumsum(size > 3) - 1
    before = preceding(t)
    middle = n + t.edge
    second = np.where(triangle, begin + 3 * corner + (corner + 1) % 3, 4 * h + 1)
    last = np.where(triangle, begin + 3 * corner + (corner + 2) % 3, 4 * h + 3)
    third = np.where(triangle, begin + 9 + (corner + 1) % 3, 4 * h + 2)
    corners, twin = np.empty(4 * len(h), np.int32), np.full(4 * len(h), -1, np.int32)
    corners[4 * h], corners[second], corners[last] = t.face_vertices, middle, middle[before]
    # The middle child's side that faces the child at h begins where that child ends.
    corners[third] = np.where(triangle, middle[before], n + t.edge_count + large[t.face])
    inner = np.where(triangle, third, third[t.following])
    twin[second], twin[inner] = inner, second
    paired = t.twin >= 0
    beyond = last[t.following[t.twin[paired]]]
    twin[4 * h[paired]], twin[beyond] = beyond, 4 * h[paired]
    counts, sizes = np.where(size == 3, 4, size), np.where(size == 3, 3, 4)
    offsets = np.concatenate([[0], np.cumsum(np.repeat(sizes, counts))]).astype(np.int32)
    child = Topology.from_twins(offsets, corners, twin, n + t.edge_count + int(np.count_nonzero(size > 3)))
    # An inner edge's two halves are the first halves of its half-edges; those of the boundary are sharp already.
    child.sharpness[child.edge[4 * h]] = later(t.sharpness)[t.edge]
    child.corner_sharpness[:n] = later(t.corner_sharpness)
    return child


def _vertex_mask(t: Topology) -> VertexMask:
    """The smooth vertex rule, corrected where triangles meet quads."""
    quads = np.bincount(t.face_vertices[np.diff(t.face_offsets)[t.face] > 3], minlength=t.vertex_count)
    mixed = (quads > 0) & (quads < t.valence)
    mixed[t.edge_vertices[t.boundary_edges]] = False
    vertices = np.flatnonzero(mixed)
    correction = np.zeros(t.vertex_count)
    for order, chosen in by_order(t, preceding(t), t.outgoing[vertices]):
        correction[vertices[chosen]] = masks.correction(order)
    return masks.smooth_mask(t.valence, quads, correction)


_RULES = SmoothRules(_vertex_mask, BESIDE_TRIANGLE, BESIDE_POLYGON, centroids_from=4)
