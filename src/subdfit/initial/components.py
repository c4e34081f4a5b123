"""Keep the largest connected pieces of a triangle mesh."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from subdfit.errors import InputError


@dataclass(frozen=True, eq=False)
class KeptMesh:
    """Some components of a mesh, rows in the order of the input.

    Attributes
    ----------
    points : (k, 3) float64.
    triangles : (t, 3) int64, rows of `points`.
    point_rows : (k,) int64, the input's row of each point.
    triangle_rows : (t,) int64, the input's row of each triangle.
    component_count : number of components of the input; vertices without a face are none.
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.int64]
    point_rows: NDArray[np.int64]
    triangle_rows: NDArray[np.int64]
    component_count: int


def keep_components(points: ArrayLike, triangles: ArrayLike, count: int = 1) -> KeptMesh:
    """Keep the `count` connected components of largest area; drop the rest and all unused points.

    Parameters
    ----------
    points : (n, 3)
        Positions, in any unit.
    triangles : (m, 3)
        Rows of `points`; triangles that share a vertex are connected.
    count : int
        Components to keep, at least 1; of equal ones the first in the file stays.

    Raises
    ------
    InputError
        `count` is less than 1, or a triangle names a point that does not exist.
    """
    positions = np.asarray(points, np.float64).reshape(-1, 3)
    faces = np.asarray(triangles, np.int64).reshape(-1, 3)
    if count < 1:
        raise InputError(f"count is {count}; keep at least 1 component")
    if len(faces) and (faces.min() < 0 or faces.max() >= len(positions)):
        raise InputError(f"a triangle names a point outside 0..{len(positions) - 1}; mend the face list")
    label, component_count = _face_components(faces, len(positions))
    area = np.bincount(label, weights=_areas(positions, faces), minlength=component_count)
    largest = np.argsort(-area, kind="stable")[:count]
    triangle_rows = np.flatnonzero(np.isin(label, largest))
    point_rows, kept = np.unique(faces[triangle_rows], return_inverse=True)
    return KeptMesh(
        points=np.ascontiguousarray(positions[point_rows]),
        triangles=np.ascontiguousarray(kept.reshape(-1, 3), np.int64),
        point_rows=point_rows,
        triangle_rows=triangle_rows,
        component_count=component_count,
    )


def _face_components(faces: NDArray[np.int64], vertex_count: int) -> tuple[NDArray[np.int64], int]:
    """Number the components by their first face; return each face's number and how many there are."""
    ends = np.concatenate([faces[:, :2], faces[:, 1:]])
    links = coo_array((np.ones(len(ends), np.bool_), (ends[:, 0], ends[:, 1])), shape=(vertex_count, vertex_count))
    _, vertex_label = connected_components(links, directed=False)
    _, first, label = np.unique(vertex_label[faces[:, 0]], return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[label], len(first)


def _areas(points: NDArray[np.float64], faces: NDArray[np.int64]) -> NDArray[np.float64]:
    a, b, c = (points[faces[:, i]] for i in range(3))
    areas: NDArray[np.float64] = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return areas
