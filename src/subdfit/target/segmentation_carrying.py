"""Regions of a mesh with fewer vertices carried over to all triangles of the mesh that it comes from."""

import numpy as np
from numpy.typing import NDArray

from subdfit.mesh.short_edges import Coarsened
from subdfit.target.features import Edges, edges_among, mesh_edges

Floats = NDArray[np.float64]
Labels = NDArray[np.int64]
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
    found = _spread(points, edges, found)
    between = (edges.valence == 2) & (found[edges.faces[:, 0]] != found[edges.faces[:, 1]])
    ends = coarse.merged[edges.vertices]
    # A border runs beside the feature that it was where triangles between the two are gone.
    along = between & np.isin(ends, features).all(axis=1)
    within = ~between & edges_among(ends, features)
    return found, edges.vertices[along | within]


def _spread(points: Floats, edges: Edges, labels: Labels) -> Labels:
    """Labels (m,), with those below 0 taken from neighbours, across their longest sides first."""
    labels = labels.copy()
    length = np.linalg.norm(points[edges.vertices[:, 1]] - points[edges.vertices[:, 0]], axis=1)
    inner = np.flatnonzero(edges.valence == 2)
    inner = inner[np.argsort(length[inner], kind="stable")]
    one, other = np.concatenate([edges.faces[inner], edges.faces[inner, ::-1]], axis=1).reshape(-1, 2).T
    while True:
        reached = (labels[one] < 0) & (labels[other] >= 0)
        if not reached.any():
            return labels
        # Where several reach a triangle, the last counts.
        labels[one[reached]] = labels[other[reached]]
