"""Gaps of creases between regions, where what is left of noise hid them."""

import numpy as np
from numpy.typing import NDArray

from subdfit.target.curves import Curve
from subdfit.target.features import edges_among, mesh_edges
from subdfit.target.network import Cuts, network_arcs

_BENT = 25.0
"""Degrees by which half of a stretch of border bend at least where it is a crease."""


def crease_gaps(
    points: NDArray[np.float64],
    triangles: NDArray[np.integer],
    labels: NDArray[np.int64],
    features: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Edges, (k, 2) int64, of the stretches of borders between feature edges that bend clearly.

    Parameters
    ----------
    points, triangles : the mesh.
    labels : (m,) int64, the regions.
    features : (c, 2) int64, edges known to be sharp.
    """
    edges = mesh_edges(points, triangles)
    sides = labels[edges.faces]
    border = (edges.valence == 2) & (sides[:, 0] != sides[:, 1])
    ends, angle = edges.vertices[border], edges.angle[border]
    sharp = edges_among(ends, features)
    arcs = network_arcs(Cuts(ends, sharp, sharp))
    stretches = [Curve(arc.vertices, arc.closed).edges for arc in arcs if not arc.sharp]
    bent = [stretch for stretch in stretches if np.median(angle[edges_among(ends, stretch)]) >= _BENT]
    return np.concatenate([np.empty((0, 2), np.int64), *bent])
