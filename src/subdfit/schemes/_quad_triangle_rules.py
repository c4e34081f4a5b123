"""Quad-triangle refinement: the split of triangles and larger faces, and the rules of Stam and Loop (2003)."""

import numpy as np

from subdfit.mesh.topology import Topology
from subdfit.schemes import _quad_triangle_masks as masks
from subdfit.schemes._level import preceding
from subdfit.schemes._quad_triangle_kinds import by_order, larger_round
from subdfit.schemes._split import split
from subdfit.schemes._stencils import BESIDE_POLYGON, BESIDE_TRIANGLE, SmoothRules, Stencils, VertexMask
from subdfit.schemes.scheme import Refinement

QUADS_FROM = 4
"""Corners from which on faces are cut in quads."""


def refine(t: Topology) -> Refinement:
    """One step of subdivision, see `split`."""
    rows = np.arange(t.vertex_count + t.edge_count)
    return Refinement(split(t, QUADS_FROM), Stencils(t, _RULES), rows[: t.vertex_count], rows[t.vertex_count :])


def _vertex_mask(t: Topology) -> VertexMask:
    """The smooth vertex rule, corrected where triangles meet quads."""
    quads = larger_round(t, 3)
    vertices = np.flatnonzero((quads > 0) & (quads < t.valence) & ~t.boundary_vertices)
    correction = np.zeros(t.vertex_count)
    for order, chosen in by_order(t, preceding(t), t.outgoing[vertices]):
        correction[vertices[chosen]] = masks.correction(order)
    return masks.smooth_mask(t.valence, quads, correction)


_RULES = SmoothRules(_vertex_mask, BESIDE_TRIANGLE, BESIDE_POLYGON, centroids_from=QUADS_FROM)
