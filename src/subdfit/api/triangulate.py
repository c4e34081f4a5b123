"""Polygons cut into triangles: the shortest diagonal first, never one that is an edge already."""

import numpy as np
from numpy.typing import NDArray

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
    starts = data.face_offsets[:-1]
    pieces = [data.face_vertices[starts[sizes == 3, None] + np.arange(3)]]
    polygons = {
        int(size): data.face_vertices[starts[sizes == size, None] + np.arange(size)]
        for size in np.unique(sizes[sizes > 3])
    }
    taken = _edge_keys(data) if polygons else np.empty(0, np.int64)
    while polygons:
        size = max(polygons)
        rows = polygons.pop(size)
        normals = _newell(data.points[rows])
        while len(rows):
            ear = _best_ear(data.points, rows, normals, taken)
            ends = np.take_along_axis(rows, (ear[:, None] + np.array([-1, 1])) % size, axis=1)
            key = _keys(ends, len(data.points))
            now = np.zeros(len(rows), np.bool_)
            now[np.unique(key, return_index=True)[1]] = True  # two faces must not take one diagonal at once
            taken = np.union1d(taken, key)
            corner = rows[now, ear[now]]
            pieces.append(np.column_stack([ends[now, 0], corner, ends[now, 1]]))
            left = rows[now][np.arange(size) != ear[now, None]].reshape(-1, size - 1)
            if size == 4:
                pieces.append(left)
            else:
                polygons[size - 1] = np.concatenate([polygons.get(size - 1, np.empty((0, size - 1), np.int64)), left])
            rows, normals = rows[~now], normals[~now]
    return np.concatenate(pieces)


def _best_ear(points: Floats, rows: Rows, normals: Floats, taken: Rows) -> Rows:
    """Corner (m,) of each polygon (m, k) to cut off next."""
    before, after = np.roll(rows, 1, axis=1), np.roll(rows, -1, axis=1)
    a, b, c = points[before], points[rows], points[after]
    length = np.linalg.norm(c - a, axis=2)
    turned = np.einsum("mkd,md->mk", np.cross(b - a, c - b), normals) <= 0
    edge = np.isin(_keys(np.stack([before, after], axis=2), len(points)), taken)
    order = np.lexsort((length, turned | _covers_corner(a, b, c, normals), edge), axis=1)
    best: Rows = order[:, 0]
    return best


def _covers_corner(a: Floats, b: Floats, c: Floats, normals: Floats) -> NDArray[np.bool_]:
    """Whether another corner lies inside each ear (m, k), seen along the normal; b are the polygons' corners."""
    inside = np.ones((*b.shape[:2], b.shape[1]), np.bool_)
    for start, end in ((a, b), (b, c), (c, a)):
        inward = np.cross(normals[:, None], end - start)
        offset = np.einsum("mkd,mkd->mk", inward, start)
        inside &= np.einsum("mkd,mjd->mkj", inward, b) > offset[..., None]
    corners = np.arange(b.shape[1])
    for shift in (-1, 0, 1):
        inside[:, corners, (corners + shift) % len(corners)] = False
    return np.asarray(inside.any(axis=2))


def _newell(corners: Floats) -> Floats:
    """Area vectors (m, 3) of polygons (m, k, 3), whatever their shape."""
    about = corners - corners.mean(axis=1, keepdims=True)
    return np.asarray(np.cross(about, np.roll(about, -1, axis=1)).sum(axis=1))


def _edge_keys(data: MeshData) -> Rows:
    """The edges of all faces as sorted keys."""
    following = np.arange(1, len(data.face_vertices) + 1)
    following[data.face_offsets[1:] - 1] = data.face_offsets[:-1]
    pairs = np.column_stack([data.face_vertices, data.face_vertices[following]])
    return np.unique(_keys(pairs, len(data.points)))


def _keys(pairs: Rows, count: int) -> Rows:
    """One number for each unordered pair of vertices on the last axis."""
    keys: Rows = pairs.min(axis=-1) * count + pairs.max(axis=-1)
    return keys
