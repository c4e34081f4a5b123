"""Sharp borders of faces moved to where the faces' surfaces meet: noise turns triangles there, and low ones anyhow.

Triangles beside a border take the face whose surface their corners lie nearer to, measured by the noise, and the border
is short: a minimum cut between two faces at a time (the swap move of Boykov, Veksler and Zabih 2001), taken where it
makes borders shorter.
"""

import numpy as np
from numpy.typing import NDArray

from subdfit.target.features import Edges, edges_among, mesh_edges
from subdfit.target.local_quadrics import NEAREST, local_quadrics
from subdfit.target.minimum_cut import source_side

Floats = NDArray[np.float64]
Labels = NDArray[np.int64]
Flags = NDArray[np.bool_]
Creases = NDArray[np.int64]

_ROUNDS = 4
"""Rounds in which borders move, by a triangle each."""
_FARTHEST = 5.0
"""Standard deviations from which on a corner is simply off a surface."""


def where_faces_meet(
    points: Floats, triangles: NDArray[np.integer], labels: Labels, features: Creases, noise: float
) -> tuple[Labels, Creases]:
    """Labels (m,) and feature edges (c, 2) with the sharp borders where the faces' surfaces meet.

    Parameters
    ----------
    points, triangles : the mesh, with its noise.
    labels : (m,) int64, the regions.
    features : (c, 2) int64, edges that are sharp, between regions or within one.
    noise : its standard deviation.
    """
    edges = mesh_edges(points, triangles)
    labels, sharp = labels.copy(), edges_among(edges.vertices, features)
    for _ in range(_ROUNDS):
        before = labels.copy()
        border = _border(edges, before)
        for a, b in np.unique(np.sort(labels[edges.faces[border & sharp]], axis=1), axis=0).tolist():
            _part(points, triangles, edges, labels, sharp, (a, b), noise)
        now = _border(edges, labels)
        sharp = (sharp & (now | ~border)) | (now & ~border)
        if np.array_equal(before, labels):
            break
    return labels, edges.vertices[sharp]


def _border(edges: Edges, labels: Labels) -> Flags:
    return np.asarray((edges.valence == 2) & (labels[edges.faces[:, 0]] != labels[edges.faces[:, 1]]))


def _part(
    points: Floats,
    triangles: NDArray[np.integer],
    edges: Edges,
    labels: Labels,
    sharp: Flags,
    pair: tuple[int, int],
    noise: float,
) -> None:
    """Choose anew, in place, the labels of the triangles that touch the sharp border of two regions."""
    a, b = pair
    either = np.isin(labels, pair)
    between = sharp & _border(edges, labels) & either[edges.faces].all(axis=1)
    touching = np.isin(triangles, edges.vertices[between]).any(axis=1)
    band = np.flatnonzero(either & touching)
    surfaces = [points[np.unique(triangles[labels == region])] for region in pair]
    if min(map(len, surfaces)) < NEAREST:
        return
    costs = [_misfit(points, triangles[band], surface, noise) for surface in surfaces]
    node = np.full(len(labels), -1)
    node[either] = labels[either] == b
    node[band] = own = np.arange(len(band)) + 2
    links = node[edges.faces]
    free = (edges.valence == 2) & (links >= 0).all(axis=1) & (links.max(axis=1) >= 2)
    one, other = links[free].T
    lengths = np.linalg.norm(np.diff(points[edges.vertices], axis=1)[:, 0], axis=1)
    border = lengths[free] / np.median(lengths)
    first = source_side(
        np.concatenate([one, other, np.zeros_like(own), own]),
        np.concatenate([other, one, own, np.ones_like(own)]),
        np.concatenate([border, border, costs[1], costs[0]]),
        len(band) + 2,
    )
    tried = labels.copy()
    tried[band] = np.where(first[own], a, b)
    # A border loses teeth where it comes to lie right; one that grows has left what neither surface is.
    if lengths[_border(edges, tried)].sum() < lengths[_border(edges, labels)].sum():
        labels[band] = tried[band]


def _misfit(points: Floats, triangles: NDArray[np.integer], surface: Floats, noise: float) -> Floats:
    """What it costs triangles (k, 3) to belong to a surface, that of other points: how unlikely their corners are."""
    used, corner = np.unique(triangles, return_inverse=True)
    there = local_quadrics(surface, points[used], noise)
    off = np.minimum(np.abs(there.distance) / (there.spread * noise), _FARTHEST)
    return np.asarray(np.sum(off[corner.reshape(triangles.shape)] ** 2, axis=1) / 2)
