"""How far a smooth surface through the vertices of a mesh lies off its facets."""

import numpy as np
from numpy.typing import NDArray

from subdfit.target.features import mesh_edges
from subdfit.target.normals import sector_normals, vertex_normals


def sagitta(
    points: NDArray[np.float64], triangles: NDArray[np.integer], crease_edges: NDArray[np.integer]
) -> NDArray[np.float64]:
    """Largest distance of each facet from the smooth surface it stands for, (m,) float64, in the points' unit.

    That surface is taken as the curved PN triangle (Vlachos et al., Curved PN triangles, 2001, section 3)
    over normals that are averaged within smooth sectors only, so that creases do not count as curvature.
    With ``w_ij = (p_j - p_i) . n_i`` it lies ``-(w_ij n_i + w_ji n_j) / 8`` off the middle of edge ij and
    ``-sum(w_ij n_i) / 18`` off the centre; the largest of the four lengths is returned. On a sphere or a
    cylinder this is the sagitta up to terms of fourth order in the angle of the facet.

    Parameters
    ----------
    points : (n, 3) float64.
    triangles : (m, 3) int, rows of `points`, oriented alike.
    crease_edges : (c, 2) int, rows of `points`: edges across which the surface is not smooth.
    """
    normals = _corner_normals(points, triangles, np.asarray(crease_edges, np.int64).reshape(-1, 2))
    corners = points[triangles]
    rise = np.zeros((3, len(triangles), 3))
    for i in range(3):
        j = (i + 1) % 3
        chord = corners[:, j] - corners[:, i]
        rise[i] += np.sum(chord * normals[:, i], axis=1, keepdims=True) * normals[:, i]
        rise[i] -= np.sum(chord * normals[:, j], axis=1, keepdims=True) * normals[:, j]
    middle: NDArray[np.float64] = np.linalg.norm(rise, axis=2).max(axis=0) / 8.0
    centre: NDArray[np.float64] = np.linalg.norm(rise.sum(axis=0), axis=1) / 18.0
    return np.maximum(middle, centre)


def _corner_normals(
    points: NDArray[np.float64], triangles: NDArray[np.integer], creases: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Normals of the corners' smooth sectors, (m, 3, 3): the vertices' own where no crease meets them."""
    normals = vertex_normals(points, triangles)[triangles]
    at_crease = np.zeros(len(points), np.bool_)
    at_crease[creases] = True
    touched = at_crease[triangles]
    rows = np.flatnonzero(touched.any(axis=1))
    edges = mesh_edges(points, triangles[rows])
    keys = np.sort(creases, axis=1) @ [len(points), 1]
    smooth = (edges.valence == 2) & ~np.isin(edges.vertices @ [len(points), 1], keys)
    sectors = sector_normals(points, triangles[rows], edges.vertices[smooth], edges.faces[smooth])
    normals[rows] = np.where(touched[rows][:, :, None], sectors, normals[rows])
    return np.asarray(normals)
