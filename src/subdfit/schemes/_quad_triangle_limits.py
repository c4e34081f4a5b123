"""Limit masks of the quad-triangle scheme, which depend on the order of the faces round a vertex."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.mesh.topology import Topology
from subdfit.schemes._level import Level, semi_sharp
from subdfit.schemes._limits import LimitMasks, curve_weights, vertex_kinds
from subdfit.schemes._quad_triangle_kinds import by_order, larger_round
from subdfit.schemes._quad_triangle_masks import pure_limit_mask
from subdfit.schemes._quad_triangle_patches import ring_sizes, rings
from subdfit.schemes._quad_triangle_sectors import Sector, limit_mask
from subdfit.schemes.scheme import Refinement

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class MixedLimits:
    """Limit masks in meshes of triangles and quads; `refine` is one step of the scheme."""

    refine: Callable[[Topology], Refinement]

    def masks(self, t: Topology) -> LimitMasks:
        """Crease and corner; smooth vertices among triangles or quads alone; the others, and darts, by their rings.

        Vertices at larger faces than quads have masks once they are refined.
        """
        smooth, dart, crease, pinned = vertex_kinds(t)
        quads = larger_round(t, 3)
        waiting = semi_sharp(t) | (larger_round(t, 4) > 0)
        weights = curve_weights(crease, pinned)
        mixed = (quads > 0) & (quads < t.valence)
        valences = np.arange(1, int(t.valence.max(initial=1)) + 1)
        for among_quads in (False, True):
            mask = np.column_stack(pure_limit_mask(valences, among_quads * valences))
            chosen = smooth & (quads == among_quads * t.valence)
            weights[chosen, :3] = mask[t.valence[chosen] - 1]
        return LimitMasks(weights, dart | (smooth & mixed), waiting)

    def ring_rows(self, level: Level, vertices: Flags) -> sp.csr_array:
        """Rows by the order of the faces round a vertex; a dart's ring begins at its sharp edge."""
        t, rows = level.topology, np.flatnonzero(vertices)
        dart = level.sharp_count[rows] == 1
        half_edges = np.where(dart, level.first[t.outgoing[rows]], t.outgoing[rows])
        sizes = ring_sizes(level)[half_edges] + 1
        start = np.concatenate([[0], np.cumsum(sizes)])
        columns = rings(level, half_edges.astype(np.int64), start[:-1] + 1, sizes - 1, int(start[-1]))[:, 0]
        columns[start[:-1]] = rows
        values = np.empty(len(columns))
        for sharp in (False, True):
            some = np.flatnonzero(dart == sharp)
            for order, chosen in by_order(t, level.preceding, half_edges[some]):
                mask = limit_mask(Sector(order, dart=sharp))
                values[start[some[chosen]][:, None] + np.arange(len(mask))] = mask
        offsets = np.concatenate([[0], np.cumsum(np.bincount(rows, sizes, len(vertices)))]).astype(np.int64)
        return sp.csr_array((values, columns, offsets), shape=(len(vertices), len(vertices)))
