"""Sectors: the cells round a vertex between sharp sides, found from the domain alone."""

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from shapes.parameters import CORNERS, DUAL
from subdfit.schemes._doo_sabin_curves import Curves


class Corners(NamedTuple):
    """Corners of cells: where each is, its sector's number, the cells in that sector, and what kind of vertex it is."""

    face: np.ndarray
    uv: np.ndarray
    sector: np.ndarray
    cells: np.ndarray
    sharp_sides: np.ndarray
    pinned: np.ndarray


def corners_of(surface):
    """All corners of cells that stand for a control vertex."""
    domain = surface.domain
    pinned = np.isinf(surface.topology.corner_sharpness)
    if surface.scheme.name in DUAL:
        pinned = Curves.of(surface.topology).corner
    number = np.array([len(CORNERS[int(shape)]) for shape in domain.shape])
    face, side = np.nonzero((domain.neighbour >= 0) & ~domain.sharp)
    beyond, other = domain.neighbour[face, side], domain.neighbour_side[face, side]
    here = np.concatenate([4 * face + side, 4 * face + (side + 1) % number[face]])
    there = np.concatenate([4 * beyond + (other + 1) % number[beyond], 4 * beyond + other])
    graph = sp.coo_array((np.ones(len(here)), (here, there)), shape=(4 * len(number),) * 2)
    _, sector = connected_components(graph, directed=False)
    face, corner = np.nonzero(domain.vertex >= 0)
    sector = np.unique(sector[4 * face + corner], return_inverse=True)[1]
    vertex = domain.vertex[face, corner]
    return Corners(
        face,
        np.array([CORNERS[int(domain.shape[f])][c] for f, c in zip(face, corner, strict=True)]),
        sector,
        np.bincount(sector)[sector],
        sharp_sides(domain)[vertex],
        pinned[vertex],
    )


def sharp_sides(domain):
    """Number of sharp edges at each control vertex."""
    count = np.zeros(domain.vertex.max() + 1, int)
    for face, side in zip(*np.nonzero(domain.sharp), strict=True):
        once = domain.neighbour[face, side] < face
        if once:
            corners = len(CORNERS[int(domain.shape[face])])
            for vertex in domain.vertex[face, [side, (side + 1) % corners]]:
                count[vertex] += vertex >= 0
    return count
