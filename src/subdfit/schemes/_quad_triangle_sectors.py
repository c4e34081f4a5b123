"""Limit masks and tangents of the quad-triangle scheme, which depend on the order of the faces round a vertex."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subdfit.schemes import _irregular, _tangents
from subdfit.schemes._corner_type import CornerType
from subdfit.schemes._quad_triangle_masks import correction, ring_matrix

Matrix = NDArray[np.float64]
Rows = NDArray[np.int64]

KEPT = 2**13
"""Sectors whose masks are kept."""


class Sector(NamedTuple):
    """The faces round a vertex between two sharp edges, or all of them: counter-clockwise, a letter each, T or Q.

    `closed` sectors go all the way round; a `dart`'s sharp edge begins its face 0; `pinned` marks corner vertices.
    """

    order: str
    closed: bool = True
    dart: bool = False
    pinned: bool = False

    @property
    def first(self) -> int:
        """The face with which all sectors that are like this one but for their beginning begin."""
        if self.dart or not self.closed:
            return 0
        return min(range(len(self.order)), key=lambda i: self.order[i:] + self.order[:i])

    def turned(self, first: int) -> "Sector":
        """The same beginning with another face."""
        return self._replace(order=self.order[first:] + self.order[:first])

    @property
    def edges(self) -> Rows:
        """Which points of a vertex and its ring, counter-clockwise from edge 0, are its neighbours by edge."""
        places: Rows = 1 + np.cumsum([0, *(1 + (letter == "Q") for letter in self.order)])
        return places[:-1] if self.closed else places


@lru_cache(KEPT)
def limit_mask(sector: Sector) -> Matrix:
    """Weights of a vertex and its ring, counter-clockwise from edge 0, for its limit point, (r,)."""
    first = sector.first
    return _begun(_limit_mask(sector.turned(first)), sector, first)


@lru_cache(KEPT)
def edge_tangents(sector: Sector) -> Matrix:
    """Weights of a vertex and its ring for limit tangents along its edges, (edges, r); see `_tangents`."""
    first = sector.first
    return _begun(np.roll(_edge_tangents(sector.turned(first)), first, axis=0), sector, first)


def _begun(weights: Matrix, sector: Sector, first: int) -> Matrix:
    """Weights (..., r) over the ring of a sector, from those over its ring from edge `first` on."""
    shift = int(sector.edges[first]) - 1
    out: Matrix = np.concatenate([weights[..., :1], np.roll(weights[..., 1:], shift, axis=-1)], axis=-1)
    return out


@lru_cache(KEPT)
def _limit_mask(sector: Sector) -> Matrix:
    return _irregular.limit_mask(_step(sector))


@lru_cache(KEPT)
def _edge_tangents(sector: Sector) -> Matrix:
    kind = CornerType(len(sector.order), 0, sector.closed, sector.dart, sector.pinned)
    return _tangents.edge_tangents(_step(sector), kind, sector.edges)


def _step(sector: Sector) -> Matrix:
    """One step of subdivision of the vertex and its ring, counter-clockwise, (r, r)."""
    order, closed, dart, pinned = sector
    smooth = closed and not pinned
    step = ring_matrix(order, correction(order) if smooth else 0.0, dart, closed, pinned)
    # There all neighbours by edge come before the far corners of quads.
    edges = sector.edges
    far = np.setdiff1d(np.arange(1, len(step)), edges)
    place = np.concatenate([[0], edges, far])
    turned = np.empty_like(step)
    turned[np.ix_(place, place)] = step
    return turned
