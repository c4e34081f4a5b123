"""Limit masks of the quad-triangle scheme, which depend on the order of the faces round a vertex."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.mesh.topology import Topology
from subdfit.schemes._level import Level, semi_sharp
from subdfit.schemes._limits import LimitMasks, curve_weights, vertex_kinds
from subdfit.schemes._quad_triangle_kinds import by_order
from subdfit.schemes._quad_triangle_masks import limit_mask
from subdfit.schemes._quad_triangle_patches import corner_rings
from subdfit.schemes.scheme import Refinement

Rows = NDArray[np.int64]
Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class MixedLimits:
    """Limit masks in meshes of triangles and quads; `refine` is one step of the scheme."""

    refine: Callable[[Topology], Refinement]

    def masks(self, t: Topology) -> LimitMasks:
        """Crease and corner; smooth vertices and darts by their rings, at larger faces than quads once refined."""
        smooth, dart, crease, pinned = vertex_kinds(t)
        waiting = semi_sharp(t)
        waiting[t.face_vertices[np.diff(t.face_offsets)[t.face] > 4]] = True
        return LimitMasks(curve_weights(crease, pinned), smooth | dart, waiting)

    def ring_rows(self, level: Level, vertices: Flags) -> sp.csr_array:
        """Rows by the order of the faces round a vertex."""
        entries = [
            entry
            for dart in (False, True)
            for entry in _inner_masks(level, np.flatnonzero(vertices & (level.sharp_count == int(dart))), dart)
        ]
        rows, columns, values = (np.concatenate(arrays) for arrays in zip(*entries, strict=True))
        return sp.csr_array((values, (rows, columns)), shape=(len(vertices), len(vertices)))


def _inner_masks(level: Level, vertices: Rows, dart: bool) -> list[tuple[Rows, Rows, Floats]]:
    """Rows, columns and weights of smooth vertices, or of darts, whose rings begin at the sharp edge."""
    t, found = level.topology, []
    half_edges = t.outgoing[vertices]
    if dart:
        half_edges = level.first[half_edges]
    for order, chosen in by_order(t, level.preceding, half_edges):
        mask = limit_mask(order, dart)
        ring = corner_rings(level, half_edges[chosen])[:, :, 0]
        columns = np.column_stack([vertices[chosen], ring]).ravel()
        found.append((np.repeat(vertices[chosen], len(mask)), columns, np.tile(mask, len(chosen))))
    return found
