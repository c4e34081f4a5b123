"""Which side of a surface is outside."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]


def oriented_outward(points: Floats, triangles: Rows, normals: Floats | None = None) -> Rows:
    """Turn whole components of a consistently oriented mesh so that their normals point outward.

    Given normals vote, weighted by the triangles' areas. Without them, or where they balance, a closed component
    encloses a positive volume, and an open one does so together with the cone from its centre.

    Parameters
    ----------
    points : (n, 3) float64, each in a triangle.
    triangles : (m, 3) int64.
    normals : (n, 3) float64, zero where unknown.

    Returns
    -------
    (m, 3) int64, the same triangles; those of turned components with two corners exchanged.
    """
    component, count = components_of(triangles, len(points))
    corners = points[triangles]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sums = np.stack([np.bincount(component, corners[:, :, k].mean(axis=1), count) for k in range(3)], axis=1)
    centre = sums / np.bincount(component, minlength=count)[:, None]
    volume = np.einsum("fk,fk->f", area, corners.mean(axis=1) - centre[component])
    vote = np.bincount(component, volume, count)
    if normals is not None:
        given = np.bincount(component, np.einsum("fk,fck->f", area, normals[triangles]), count)
        vote = np.where(given == 0.0, vote, given)
    return np.where((vote < 0.0)[component][:, None], triangles[:, [0, 2, 1]], triangles)


def components_of(triangles: NDArray[np.integer], count: int) -> tuple[Rows, int]:
    """Component of each triangle, and how many there are; all points are in triangles."""
    ends = np.concatenate([triangles[:, :2], triangles[:, 1:]])
    links = coo_array((np.ones(len(ends), np.int8), (ends[:, 0], ends[:, 1])), shape=(count, count))
    components, label = connected_components(links, directed=False)
    return label[triangles[:, 0]].astype(np.int64), int(components)
