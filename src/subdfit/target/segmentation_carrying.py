"""Regions of a mesh with fewer vertices carried over to all triangles of the mesh that it comes from."""

import numpy as np
from numpy.typing import NDArray

from subdfit.mesh.short_edges import Coarsened
from subdfit.target.features import Edges, edges_among, mesh_edges
from subdfit.target.minimum_cut import source_side

Floats = NDArray[np.float64]
Labels = NDArray[np.int64]
Flags = NDArray[np.bool_]
Creases = NDArray[np.int64]


def on_all_triangles(
    points: Floats, triangles: NDArray[np.integer], coarse: Coarsened, labels: Labels, features: Creases
) -> tuple[Labels, Creases]:
    """Labels (m,) and feature edges (c, 2) of a mesh, from those of the mesh with fewer vertices.

    Parameters
    ----------
    points, triangles : the mesh.
    coarse : what was made of it.
    labels, features : the regions of the triangles of `coarse`, and its feature edges.
    """
    edges = mesh_edges(points, triangles)
    found = np.full(len(triangles), -1)
    found[coarse.rows] = labels
    lengths = np.linalg.norm(points[edges.vertices[:, 1]] - points[edges.vertices[:, 0]], axis=1)
    found = _with_short_borders(edges, lengths, _spread(edges, lengths, found), found < 0)
    between = (edges.valence == 2) & (found[edges.faces[:, 0]] != found[edges.faces[:, 1]])
    ends = coarse.merged[edges.vertices]
    # A border runs beside the feature that it was where triangles between the two are gone.
    along = between & np.isin(ends, features).all(axis=1)
    within = ~between & edges_among(ends, _within_regions(coarse, labels, features))
    return found, edges.vertices[along | within]


def _within_regions(coarse: Coarsened, labels: Labels, features: Creases) -> Creases:
    """Those of the feature edges that have the same region on both sides."""
    edges = mesh_edges(coarse.points, coarse.triangles)
    inner = (edges.valence == 2) & (labels[edges.faces[:, 0]] == labels[edges.faces[:, 1]])
    return features[edges_among(features, edges.vertices[inner])]


def _spread(edges: Edges, lengths: Floats, labels: Labels) -> Labels:
    """Labels (m,), with those below 0 taken from neighbours, across their longest sides first."""
    labels = labels.copy()
    inner = np.flatnonzero(edges.valence == 2)
    inner = inner[np.argsort(lengths[inner], kind="stable")]
    one, other = np.concatenate([edges.faces[inner], edges.faces[inner, ::-1]], axis=1).reshape(-1, 2).T
    while True:
        reached = (labels[one] < 0) & (labels[other] >= 0)
        if not reached.any():
            return labels
        # Where several reach a triangle, the last counts.
        labels[one[reached]] = labels[other[reached]]


def _with_short_borders(edges: Edges, lengths: Floats, labels: Labels, free: Flags) -> Labels:
    """Labels (m,), with the `free` ones (m,) chosen anew, two regions at a time, so that borders are short."""
    labels = labels.copy()
    inner = edges.valence == 2
    sides, lengths = edges.faces[inner], lengths[inner]
    ends = np.sort(labels[sides], axis=1)
    for a, b in np.unique(ends[ends[:, 0] < ends[:, 1]], axis=0).tolist():
        either = (labels == a) | (labels == b)
        near = np.flatnonzero(either & free)
        node = np.full(len(labels), -1)
        node[either] = labels[either] == b
        node[near] = np.arange(len(near)) + 2
        links = node[sides]
        inside = (links >= 0).all(axis=1) & (links.max(axis=1) >= 2)
        heads, tails = links[inside].T
        both = np.concatenate([heads, tails]), np.concatenate([tails, heads])
        first = source_side(*both, np.tile(lengths[inside], 2), len(near) + 2)
        labels[near] = np.where(first[2:], a, b)
    return labels
