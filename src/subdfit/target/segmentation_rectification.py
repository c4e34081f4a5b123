"""Boundary rectification: borders of regions moved to where curvature changes, along lines of curvature.

Lavoué, Dupont and Baskurt 2005 keep the border edges that run along a principal direction and trace the rest anew
along such directions. Here both wishes are one minimum cut between two neighbours at a time (the swap move of Boykov,
Veksler and Zabih 2001): triangles near the border choose the region whose curvature is theirs, and the border that
parts them costs its length times its angle to the lines of curvature, little where the mesh bends sharply.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from subdfit.target.minimum_cut import source_side
from subdfit.target.segmentation_facets import Facets, Flags, Labels

Floats = NDArray[np.float64]

_BAND = 1.5
"""Half the width of the band in which a border may move, in radii of the curvature's balls."""
_STRAIGHT = 0.2
"""What a border costs that runs along a line of curvature, as a share of one at 45 degrees to it."""
_BEND = 20.0
"""Degrees across an edge that make a border there cost half."""
_CORE = 0.3
"""Share of a thin region's width that stays its own."""


def border_costs(facets: Facets, directions: Floats) -> Floats:
    """What it costs a border to run along each edge, (e,): its length times at most one, nothing if it is sharp.

    Parameters
    ----------
    facets : the mesh.
    directions : (m, 2, 3) float64, principal directions of the triangles.
    """
    along = facets.points[facets.edges.vertices[:, 1]] - facets.points[facets.edges.vertices[:, 0]]
    along /= np.maximum(facets.lengths, 1e-300)[:, None]
    beside = np.maximum(facets.edges.faces, 0)
    cosine = np.abs(np.einsum("ei,efki->efk", along, directions[beside])).max(axis=2)
    off = np.degrees(np.arccos(np.clip(cosine, 0, 1))).mean(axis=1) / 45.0
    costs = facets.lengths * (_STRAIGHT + (1 - _STRAIGHT) * np.minimum(off, 1)) / (1 + facets.edges.angle / _BEND)
    return np.where(facets.sharp, 0.0, costs)


def rectify(facets: Facets, labels: Labels, curvatures: Floats, costs: Floats) -> Labels:
    """Move the borders of all neighbouring regions once, pair by pair, the longest border first.

    Parameters
    ----------
    facets : the mesh.
    labels : (m,) int, the region of each triangle.
    curvatures : (m, 2) float64, averaged over balls that borders do not stop: halfway where it is midway.
    costs : (e,) float64, from `border_costs`.
    """
    labels = labels.copy()
    for a, b in _pairs(facets, labels):
        _swap(facets, labels, a, b, curvatures, costs)
    return labels


def _pairs(facets: Facets, labels: Labels) -> list[tuple[int, int]]:
    """Regions that meet where nothing is sharp, the longest common border first."""
    border = np.flatnonzero(facets.borders(labels) & ~facets.sharp)
    ends = np.sort(labels[facets.edges.faces[border]], axis=1)
    pairs, place = np.unique(ends, axis=0, return_inverse=True)
    length = np.bincount(place.ravel(), facets.lengths[border], len(pairs))
    return [(int(a), int(b)) for a, b in pairs[np.argsort(-length, kind="stable")]]


def _swap(facets: Facets, labels: Labels, a: int, b: int, curvatures: Floats, costs: Floats) -> None:
    """Let the triangles near the border of two regions choose between them anew, in place."""
    band = _band(facets, labels, a, b)
    core = [np.flatnonzero((labels == region) & ~band) for region in (a, b)]
    near = np.flatnonzero(band)
    known = [part if len(part) else np.flatnonzero(labels == region) for part, region in zip(core, (a, b), strict=True)]
    mean = [np.average(curvatures[part], axis=0, weights=facets.areas[part]) for part in known]
    gap = np.linalg.norm(mean[1] - mean[0])
    if gap == 0.0:
        return
    unlike = [np.linalg.norm(curvatures[near] - m, axis=1) / gap * facets.areas[near] / facets.radius for m in mean]
    place = np.full(len(labels), -1)
    place[core[0]], place[core[1]] = 0, 1
    place[near] = np.arange(len(near)) + 2
    sides = place[facets.edges.faces[facets.inner]]
    inside = (sides >= 0).all(axis=1) & (sides.max(axis=1) >= 2) & (sides[:, 0] != sides[:, 1])
    sides, cut = sides[inside], costs[facets.inner[inside]]
    nodes = np.arange(len(near)) + 2
    heads = np.concatenate([sides[:, 0], sides[:, 1], np.zeros_like(nodes), nodes])
    tails = np.concatenate([sides[:, 1], sides[:, 0], nodes, np.ones_like(nodes)])
    capacity = np.concatenate([cut, cut, unlike[1], unlike[0]])
    chosen = np.where(source_side(heads, tails, capacity, len(near) + 2)[2:], a, b)
    # A region is not given up here, however little speaks for it: merging is another step's task.
    if all(len(part) or np.any(chosen == region) for part, region in zip(core, (a, b), strict=True)):
        labels[near] = chosen


def _band(facets: Facets, labels: Labels, a: int, b: int) -> Flags:
    """Triangles of two regions that lie near where they meet smoothly, (m,)."""
    sides = labels[facets.edges.faces[facets.inner]]
    between = (sides.min(axis=1) == min(a, b)) & (sides.max(axis=1) == max(a, b))
    shared = facets.inner[between & ~facets.sharp[facets.inner]]
    ends = facets.points[facets.edges.vertices[shared]]
    border = cKDTree(np.concatenate([ends[:, 0], ends[:, 1], ends.mean(axis=1)]))
    band = np.zeros(len(labels), np.bool_)
    for region in (a, b):
        members = np.flatnonzero(labels == region)
        distance, _ = border.query(facets.centres[members])
        reach = min(_BAND * facets.radius, (1 - _CORE) / 2 * facets.width(labels == region))
        band[members[distance < reach]] = True
    return band
