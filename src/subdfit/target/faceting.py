"""How far a smooth surface through the vertices of a mesh lies off its facets."""

import numpy as np
from numpy.typing import NDArray

from subdfit.parallel import map_chunks
from subdfit.target import _faceting_kernels as kernels
from subdfit.target.features import edges_among, mesh_edges
from subdfit.target.normals import sector_normals, vertex_normals

Floats = NDArray[np.float64]

CHUNK = 16384

TIP = 0.7
"""A vertex whose normal leans against a side by more than this sine is a tip: no smooth surface is known there."""
ALIKE = 8.0
"""A smooth surface bends alike at both ends of a side: of the bend at one, so many times that at the other counts at
most. Noise bends them unlike as well, so that this is not to be small."""


def rises(points: Floats, triangles: NDArray[np.integer], crease_edges: NDArray[np.integer]) -> Floats:
    """Vectors from the middles of the sides of triangles to the smooth surface they stand for, (m, 3, 3) float64.

    Row ``[t, i]`` belongs to the side from corner i to the next. That surface is taken as the curved PN triangle
    (Vlachos et al., Curved PN triangles, 2001, section 3) over normals that are averaged within smooth sectors only, so
    that creases do not count as curvature. With ``w_ij = (p_j - p_i) . n_i`` it lies ``-(w_ij n_i + w_ji n_j) / 8`` off
    the middle of side ij. Both triangles beside a side have the same; beside a crease, the longer of theirs.

    A mesh says this of smooth surfaces alone. At the tip of a cone the averaged normal is the axis, and such a triangle
    bulges by a tenth of its length where the surface is straight. So `w_ij` is 0 at a tip, and at
    most `ALIKE` times that of the side's other end, which is 0 where the side is straight there.

    Parameters
    ----------
    points : (n, 3) float64.
    triangles : (m, 3) int, rows of `points`, oriented alike.
    crease_edges : (c, 2) int, rows of `points`: edges across which the surface is not smooth.
    """
    creases = np.asarray(crease_edges, np.int64).reshape(-1, 2)
    normals = _corner_normals(points, triangles, creases)
    corners = points[triangles]
    found = np.empty((len(triangles), 3, 3))
    for i in range(3):
        j = (i + 1) % 3
        chord, n_i, n_j = corners[:, j] - corners[:, i], normals[:, i], normals[:, j]
        w_i, w_j = _bends(chord, n_i, n_j)
        found[:, i] = -(w_i[:, None] * n_i + w_j[:, None] * n_j)
    found /= 8.0
    return _shared_at_creases(found, triangles, creases)


def height(rise: Floats, triangle: NDArray[np.integer], uv: Floats) -> Floats:
    """How far the smooth surface lies off points of triangles, (k,) float64: 0 at vertices, continuous across sides.

    The terms of second order of the curved PN triangle, ``4 |sum of b_i b_j rise_ij|`` at barycentric b: exact in the
    middle of the sides and of the triangle. On a sphere or a cylinder it is right up to terms of fourth order in the
    angle of the facet.

    Parameters
    ----------
    rise : (m, 3, 3) float64, `rises`.
    triangle : (k,) int, and uv (k, 2) float64: where the points lie, at barycentric (1 - u - v, u, v).
    """
    rows, uv, found = np.asarray(triangle, np.int32), np.ascontiguousarray(uv), np.empty(len(triangle))
    map_chunks(lambda start, stop: kernels.heights(rise, rows, uv, start, stop, found), len(triangle), CHUNK)
    return found


def sagitta(rise: Floats) -> Floats:
    """Largest height over each of some triangles, (m,) float64: in the middle of a side or of the triangle.

    Parameters
    ----------
    rise : (m, 3, 3) float64, the triangles' `rises`.
    """
    centre = np.linalg.norm(rise.sum(axis=1), axis=1) * (4.0 / 9.0)
    return np.asarray(np.maximum(np.linalg.norm(rise, axis=2).max(axis=1, initial=0.0), centre))


def _bends(chord: Floats, n_i: Floats, n_j: Floats) -> tuple[Floats, Floats]:
    """``w_ij`` and ``w_ji`` of sides, (m,) each, as far as a smooth surface may be meant."""
    w = np.stack([np.einsum("td,td->t", chord, n_i), -np.einsum("td,td->t", chord, n_j)])
    w[np.abs(w) > TIP * np.linalg.norm(chord, axis=1)] = 0.0
    most = ALIKE * np.abs(w).min(axis=0)
    w_i, w_j = np.clip(w, -most, most)
    return w_i, w_j


def _shared_at_creases(rise: Floats, triangles: NDArray[np.integer], creases: NDArray[np.int64]) -> Floats:
    """Rises (m, 3, 3) where the two triangles beside each crease have the longer of theirs."""
    if len(creases) == 0:
        return rise
    sides = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    count = int(triangles.max()) + 1
    key = sides @ [count, 1]
    sharp = np.flatnonzero(np.isin(key, np.sort(creases, axis=1) @ [count, 1]))
    rows = rise.reshape(-1, 3)
    order = sharp[np.lexsort((-np.linalg.norm(rows[sharp], axis=1), key[sharp]))]
    longest = np.diff(key[order], prepend=-1) != 0
    rows[order] = rows[order[longest]][np.cumsum(longest) - 1]
    return rise


def _corner_normals(points: Floats, triangles: NDArray[np.integer], creases: NDArray[np.int64]) -> Floats:
    """Normals of the corners' smooth sectors, (m, 3, 3): the vertices' own where no crease meets them."""
    normals = vertex_normals(points, triangles)[triangles]
    at_crease = np.zeros(len(points), np.bool_)
    at_crease[creases] = True
    touched = at_crease[triangles]
    rows = np.flatnonzero(touched.any(axis=1))
    edges = mesh_edges(points, triangles[rows])
    smooth = (edges.valence == 2) & ~edges_among(edges.vertices, creases)
    sectors = sector_normals(points, triangles[rows], edges.vertices[smooth], edges.faces[smooth])
    normals[rows] = np.where(touched[rows][:, :, None], sectors, normals[rows])
    return np.asarray(normals)
