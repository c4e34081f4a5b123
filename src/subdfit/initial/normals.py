"""Normals of unorganised points: planes through neighbours, their sides handed on from point to point."""

import logging

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree
from scipy.spatial import cKDTree

from subdfit.wording import counted

logger = logging.getLogger(__name__)

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

NEIGHBOURS, HEIRS = 16, 12
"""Points that a normal is estimated from, and that its side is handed on to."""


def known_normals(normals: ArrayLike, name: str) -> Floats:
    """Given normals, (n, 3), those that are not finite counted in a warning and 0, as where none is known."""
    known = np.array(normals, np.float64).reshape(-1, 3)
    unknown = ~np.isfinite(known).all(axis=1)
    if unknown.any():
        logger.warning("%s: %s not finite, not used", name, counted(int(unknown.sum()), "normal"))
        known[unknown] = 0.0
    return known


def estimated_normals(points: Floats) -> Floats:
    """Unit normals of the planes of least squares through each point's neighbours, consistently oriented.

    Parameters
    ----------
    points : (n, 3) float64, n >= 4.

    Returns
    -------
    (n, 3) float64. Of each piece of the surface that neighbours join, the topmost point's looks up.

    References
    ----------
    Hoppe, DeRose, Duchamp, McDonald and Stuetzle, Surface reconstruction from unorganized points, SIGGRAPH 1992.
    """
    near = np.asarray(cKDTree(points).query(points, min(NEIGHBOURS + 1, len(points)))[1], np.int64)
    across = points[near] - points[near].mean(axis=1, keepdims=True)
    _, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", across, across))
    normals: Floats = axes[:, :, 0]
    return normals * _sides(points, normals, near[:, 1 : HEIRS + 1])[:, None]


def _sides(points: Floats, normals: Floats, near: Rows) -> Floats:
    """1 for normals that are on the right side, -1 for others.

    Sides are handed on along the tree between neighbours on which normals turn least (section 3.3). Its root, row n,
    stands above each component's topmost point.
    """
    n = len(points)
    parent = _parents(points, normals, near)
    up = np.vstack([normals, [0.0, 0.0, 1.0]])
    side = np.where(np.einsum("nk,nk->n", up, up[parent]) < 0.0, -1.0, 1.0)
    while (parent != n).any():  # the product of all signs on the way to the root, twice as far each time
        side *= side[parent]
        parent = parent[parent]
    return side[:n]


def _parents(points: Floats, normals: Floats, near: Rows) -> Rows:
    """The row before each on the way to the root n, which is its own, (n + 1,)."""
    n = len(points)
    own = np.repeat(np.arange(n), near.shape[1])
    turn = 1.0 - np.abs(np.einsum("nk,nk->n", normals[own], normals[near.ravel()]))
    links = coo_array((turn + 1e-9, (own, near.ravel())), shape=(n, n)).tocsr()  # 0 would be no link
    tree = minimum_spanning_tree(links).tocoo()
    _, component = connected_components(tree, directed=False)
    rising = np.lexsort((points[:, 2], component))
    top = rising[np.append(np.flatnonzero(np.diff(component[rising])), n - 1)]
    ends = np.concatenate([[tree.row, tree.col], [np.full(len(top), n), top]], axis=1)
    rooted = coo_array((np.ones(ends.shape[1]), tuple(ends)), shape=(n + 1, n + 1)).tocsr()
    _, parent = breadth_first_order(rooted, n, directed=False)
    parent[n] = n
    return np.asarray(parent, np.int64)
