"""Planes parted from what bends away from them: where a mesh is exactly flat, a face's border is known to the edge.

Where a plane goes over smoothly into a wide bend, a border found by averaged curvature may lie in the plane; the
curvature on its two sides is then the same, and both become one region.
"""

import numpy as np

from subdfit.target.segmentation_facets import FLAT, Facets, Labels

_MOST = 0.5
"""Share of a region that is flat in one piece if the region is a plane and what was taken for its continuation."""


def with_planes(facets: Facets, labels: Labels) -> Labels:
    """Regions (m,), with planes apart that are most of one and leave more than a ball of it, which bends away.

    Parameters
    ----------
    facets : the mesh.
    labels : (m,) int, the region of each triangle, from 0.
    """
    ball = np.pi * facets.radius**2
    piece = facets.connected((facets.edges.angle < FLAT) & ~facets.sharp)
    size, region = np.bincount(piece, facets.areas), np.bincount(labels, facets.areas)
    found = labels.copy()
    for k in np.flatnonzero(size >= ball):
        plane = piece == k
        inside = np.bincount(labels[plane], facets.areas[plane], len(region))
        mixed = (inside > _MOST * region) & (region - inside >= ball)
        if mixed.any() and facets.width(plane) >= facets.radius:
            found[plane] = len(region) + k
    return labels if np.array_equal(found, labels) else facets.connected(~facets.sharp & ~facets.borders(found))
