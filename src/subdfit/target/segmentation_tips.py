"""Creases that fade out inside a region, led on to the next crease or border.

Where two bores of one size cross, their crease fades out towards the places at which they touch, and segmentation sees
one region with slits. Its pieces are simple once the slits are joined.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import dijkstra

from subdfit.target.features import Edges, edges_among
from subdfit.target.network import Cuts, network_arcs
from subdfit.target.segmentation_facets import Facets

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]

_BEND = 5.0
"""Degrees across an edge that make a path along it half as long."""
_BACK = 3
"""Edges from which the direction of a chain's end is taken."""
_NECK = 0.5
"""Share of the seam between a piece and the rest that may be open where creases part the two."""
_SIDE = 2.0
"""How many times farther than where another crease ends a place beside one seems, to a crease that goes on."""


def across_necks(facets: Facets, least: float) -> Flags:
    """Edges (e,) across necks: with the sharp edges they part pieces that creases part from the rest nearly all round.

    Parameters
    ----------
    facets : the mesh.
    least : area of a piece.
    """
    led = continued(facets.points, facets.edges, facets.sharp | (facets.edges.valence == 1))
    pieces = facets.connected(~facets.sharp & ~led)
    within = ~facets.borders(facets.connected(~facets.sharp))
    seam, neck = (_lengths(facets, pieces, flags & facets.borders(pieces)) for flags in (within, led))
    whole = (neck <= _NECK * seam) & (np.bincount(pieces, facets.areas) >= least)
    return np.asarray(led & facets.borders(pieces) & whole[pieces[facets.edges.faces]].all(axis=1))


def _lengths(facets: Facets, pieces: Indices, flags: Flags) -> Floats:
    """Length of the flagged edges between pieces at each piece."""
    sides = pieces[facets.edges.faces[flags]]
    return np.asarray(np.bincount(sides.ravel(), np.repeat(facets.lengths[flags], 2), int(pieces.max()) + 1))


def continued(points: Floats, edges: Edges, cuts: Flags) -> Flags:
    """Edges (e,) that lead from ends of chains of cuts inside the surface to other cuts, along edges that bend.

    Parameters
    ----------
    points : (n, 3) float64.
    edges : of the mesh.
    cuts : (e,) bool, borders and creases, the mesh's boundary among them.
    """
    ends = points[edges.vertices]
    cost = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / (1 + edges.angle / _BEND)
    cuts, led = cuts.copy(), np.zeros(len(cuts), np.bool_)
    while True:
        degree = np.bincount(edges.vertices[cuts].ravel(), minlength=len(points))
        tips = np.flatnonzero(degree == 1).tolist()
        fading = degree == 1
        fading[edges.vertices[led]] = True
        paths = (_shortest(points, edges, cost, cuts, fading, tip) for tip in tips)
        path = next((path for path in paths if len(path)), None)
        if path is None:
            return led
        cuts[path] = led[path] = True


def led_along_borders(points: Floats, edges: Edges, sharp: Flags, borders: Flags) -> Flags:
    """Sharp edges (e,) and those of smooth borders along which creases go on that end on one, the most bent first.

    Parameters
    ----------
    points, edges : of the mesh.
    sharp, borders : (e,) bool, creases and boundary; where regions meet smoothly.
    """
    sharp = sharp.copy()
    while True:
        degree = np.bincount(edges.vertices[sharp].ravel(), minlength=len(points))
        smooth = np.flatnonzero(borders & ~sharp)
        at_tip = (degree[edges.vertices[smooth]] == 1).any(axis=1)
        if not at_tip.any():
            return sharp
        sharp[smooth[at_tip][np.argmax(edges.angle[smooth[at_tip]])]] = True


def _shortest(points: Floats, edges: Edges, cost: Floats, cuts: Flags, fading: Flags, tip: int) -> Indices:
    """Edges of the shortest path from a tip to a cut that is not its own chain; empty if there is none.

    A step costs up to three times as much the more it turns away from where the chain led; vertices at which cuts are
    `fading`, (n,) bool, seem nearer.
    """
    chain = _chain_from(edges.vertices[cuts], tip)
    on_cut = np.zeros(len(points), np.bool_)
    on_cut[edges.vertices[cuts]] = True
    # A path ends where it meets a cut: no step leads away from one, but from the tip.
    start, end = (np.concatenate([edges.vertices[:, k], edges.vertices[:, 1 - k]]) for k in range(2))
    allowed = np.flatnonzero((~on_cut[start] | (start == tip)) & ~np.isin(end, chain))
    start, end = start[allowed], end[allowed]
    ahead = _unit(points[tip] - points[chain[min(_BACK, len(chain) - 1)]])
    turn = 2 - _unit(points[end] - points[start]) @ ahead
    steps = np.maximum(cost[allowed % len(cost)] * turn, 1e-300)
    shape = (len(points), len(points))
    graph = csr_array(coo_array((steps, (start, end)), shape=shape))
    lengths, predecessors = dijkstra(graph, indices=[tip], return_predecessors=True)
    far = np.where(fading, lengths[0], _SIDE * lengths[0])
    length, before = np.where(on_cut, far, np.inf), predecessors[0]
    length[chain] = np.inf
    if not np.isfinite(length).any():
        return np.empty(0, np.int64)
    at, path = int(np.argmin(length)), []
    while at != tip:
        path.append((int(before[at]), at))
        at = int(before[at])
    return np.flatnonzero(edges_among(edges.vertices, np.array(path)))


def _chain_from(cuts: Indices, tip: int) -> Indices:
    """Vertices of the chain of cuts that ends at a tip, from there on."""
    flags = np.ones(len(cuts), np.bool_)
    chains = [arc.vertices for arc in network_arcs(Cuts(cuts, flags, flags)) if not arc.closed]
    chain = next(vertices for vertices in chains if tip in vertices[[0, -1]])
    return chain if chain[0] == tip else chain[::-1]


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300))
