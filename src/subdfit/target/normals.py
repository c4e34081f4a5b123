"""Normals of faces, of vertices, and of the smooth sectors round a vertex."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components


def face_normals(points: NDArray[np.float64], triangles: NDArray[np.integer]) -> NDArray[np.float64]:
    """Unit normals of triangles, (m, 3) float64; zero where a triangle has no area."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return _unit(np.cross(b - a, c - a))


def vertex_normals(points: NDArray[np.float64], triangles: NDArray[np.integer]) -> NDArray[np.float64]:
    """Unit normals of points, (n, 3) float64, weighted by the corners' angles; zero at isolated points.

    Source: Thürmer and Wüthrich, Computing vertex normals from polygonal facets, 1998.
    """
    return _unit(_sum_corners(points, triangles, triangles.ravel(), len(points)))


def sector_normals(
    points: NDArray[np.float64],
    triangles: NDArray[np.integer],
    edges: NDArray[np.int64],
    edge_faces: NDArray[np.int64],
) -> NDArray[np.float64]:
    """Unit normals of face corners, each averaged over the faces of its smooth sector.

    Parameters
    ----------
    points : (n, 3) float64.
    triangles : (m, 3) int, rows of `points`.
    edges : (e, 2) int, rows of `points`: the edges across which the surface is smooth.
    edge_faces : (e, 2) int, the two triangles beside each of them.

    Returns
    -------
    (m, 3, 3) float64: face, corner, coordinate.
    """
    corners = np.concatenate(
        [3 * edge_faces + np.argmax(triangles[edge_faces] == edges[:, end, None, None], axis=2) for end in range(2)]
    )
    size = triangles.size
    links = coo_array((np.ones(len(corners), np.int8), (corners[:, 0], corners[:, 1])), shape=(size, size))
    sectors, sector = connected_components(links, directed=False)
    return _unit(_sum_corners(points, triangles, sector, sectors))[sector].reshape(-1, 3, 3)


def _sum_corners(
    points: NDArray[np.float64], triangles: NDArray[np.integer], group: NDArray[np.integer], groups: int
) -> NDArray[np.float64]:
    """Sum of face normals over the corners of each group, weighted by the corners' angles."""
    corners = [points[triangles[:, k]] for k in range(3)]
    sides = [corners[(k + 1) % 3] - corners[k] for k in range(3)]
    normals = np.cross(sides[0], sides[1])
    area = np.linalg.norm(normals, axis=1)
    angles = [np.arctan2(area, -np.einsum("fk,fk->f", sides[k], sides[k - 1])) for k in range(3)]
    weights = np.stack(angles, axis=1) / np.where(area > 0.0, area, 1.0)[:, None]
    return np.stack([np.bincount(group, (weights * normals[:, k, None]).ravel(), groups) for k in range(3)], 1)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    unit: NDArray[np.float64] = vectors / np.where(length > 0.0, length, 1.0)
    return unit
