"""Polygons cut into triangles: the shortest diagonal first, never one that is an edge already."""

import numpy as np
from numpy.typing import NDArray

from subdfit.api._ear_kernels import cut_ears
from subdfit.mesh.data import MeshData

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]


def triangles_of(data: MeshData) -> Rows:
    """Return the faces of a mended mesh as triangles.

    Each polygon loses one ear after the other, of those that do not turn the surface over the one with the shortest
    diagonal; a quad is thus cut along its shorter diagonal. A diagonal that joins vertices which an edge joins already
    would give that edge more than two faces, and is taken only where a polygon has no other.

    Returns
    -------
    (t, 3) int64
        Triangles first, in their order, then those of polygons.
    """
    sizes = np.diff(data.face_offsets)
    whole: Rows = data.face_vertices[data.face_offsets[:-1][sizes == 3, None] + np.arange(3)]
    if len(whole) == len(sizes):
        return whole
    corners = data.face_vertices[np.repeat(sizes > 3, sizes)]
    offsets = np.concatenate([[0], np.cumsum(sizes[sizes > 3])])
    pieces = np.empty((len(corners) - 2 * len(offsets) + 2, 3), np.int64)
    cut_ears(data.points, _flat(data.points[corners], offsets), offsets, corners, _edges(data), pieces)
    return np.concatenate([whole, pieces])


def _flat(corners: Floats, offsets: Rows) -> Floats:
    """Corners (c, 3) of polygons as seen along the normal of each, counter-clockwise, (c, 2)."""
    starts, sizes = offsets[:-1], np.diff(offsets)
    about = corners - np.repeat(corners[starts], sizes, axis=0)
    normal = np.add.reduceat(np.cross(about, about[_following(offsets)]), starts)  # Newell's
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    right = np.cross(np.eye(3)[np.argmin(np.abs(normal), axis=1)], normal)
    axes = np.repeat(np.stack([right, np.cross(normal, right)], axis=1), sizes, axis=0)
    return np.asarray(np.einsum("cad,cd->ca", axes, about))


def _edges(data: MeshData) -> Rows:
    """The ends of the edges of all faces, (e, 2), the lower row first."""
    ends = np.column_stack([data.face_vertices, data.face_vertices[_following(data.face_offsets)]])
    return np.unique(np.sort(ends, axis=1), axis=0)


def _following(offsets: Rows) -> Rows:
    """The next corner in the same polygon of each corner."""
    following = np.arange(1, offsets[-1] + 1)
    following[offsets[1:] - 1] = offsets[:-1]
    return following
