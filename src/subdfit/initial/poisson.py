"""Poisson reconstruction by the Open3D library, an extra: a smooth surface near noisy points, not through them."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from subdfit.errors import InputError
from subdfit.initial.cloud_checks import check_extent
from subdfit.initial.delaunay import spacing
from subdfit.initial.distinct import distinct, normalised
from subdfit.initial.normals import estimated_normals, known_normals
from subdfit.initial.orient import components_of, oriented_outward
from subdfit.mesh.data import MeshData
from subdfit.mesh.repair import mend
from subdfit.target.frame import Frame

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

SHALLOWEST, DEEPEST = 5, 10
"""Levels of the octree: 2^10 cells along the longest side resolve more than most scans hold."""

CRUMB = 0.01
"""Share of the largest component's area below which a component is no part of the object."""


@dataclass(frozen=True, eq=False)
class PoissonMesh:
    """A manifold triangle mesh near a cloud.

    Attributes
    ----------
    points : (k, 3) float64, in the cloud's unit.
    triangles : (m, 3) int64, oriented outward.
    reach : distance from the cloud's points beyond which it was cut away.
    """

    points: Floats
    triangles: Rows
    reach: float


def poisson_mesh(
    points: ArrayLike, normals: ArrayLike | None = None, *, gap: float, name: str = "points"
) -> PoissonMesh:
    """Fit an implicit function to points with normals and take its zero surface, where there are data.

    Parameters
    ----------
    points : (n, 3)
    normals : (n, 3), optional
        Estimated, and oriented from neighbour to neighbour, where there are none.
    gap : float
        Triangles farther than so many spacings from all points are cut away.

    Raises
    ------
    InputError
        Open3D is not installed, there are too few points, or nothing is left near the data.

    References
    ----------
    Kazhdan and Hoppe, Screened Poisson surface reconstruction, ACM Transactions on Graphics 32, 2013.
    """
    positions = np.asarray(points, np.float64).reshape(-1, 3)
    frame = Frame.of(positions)
    inside = normalised(positions, name)
    own = inside[distinct(inside)]
    check_extent(own, len(positions), name)
    distance = float(np.median(spacing(own)))
    known = estimated_normals(inside) if normals is None else known_normals(normals, name)
    vertices, triangles = _zero_surface(inside, known, _depth(inside, distance), name)
    near = np.asarray(cKDTree(inside).query(vertices)[0]) <= gap * distance
    triangles = triangles[near[triangles].all(axis=1)]
    if not len(triangles):
        raise InputError(f"{name}: the Poisson surface does not come near the points; check their normals")
    vertices, triangles = _compact(vertices, triangles)
    mesh = mend(MeshData(vertices, 3 * np.arange(len(triangles) + 1), triangles.ravel()), repair=True, name=name).data
    kept, triangles = _without_crumbs(mesh.points, mesh.face_vertices.reshape(-1, 3))
    if normals is None:
        triangles = oriented_outward(kept, triangles)
    return PoissonMesh(frame.outside(kept), triangles, gap * distance * frame.diagonal)


def _zero_surface(points: Floats, normals: Floats, depth: int, name: str) -> tuple[Floats, Rows]:
    library = _open3d()
    cloud = library.geometry.PointCloud(library.utility.Vector3dVector(points))
    cloud.normals = library.utility.Vector3dVector(normals)
    mesh, _ = library.geometry.TriangleMesh.create_from_point_cloud_poisson(cloud, depth=depth, n_threads=1)
    vertices, triangles = np.asarray(mesh.vertices), np.asarray(mesh.triangles, np.int64)
    if not len(triangles):
        raise InputError(f"{name}: Poisson reconstruction finds no surface; give more points, or check their normals")
    return vertices, triangles


def _depth(points: Floats, distance: float) -> int:
    """Level at which the octree's cells are as large as the spacing."""
    side = float(np.ptp(points, axis=0).max())
    return int(np.clip(np.ceil(np.log2(side / distance)), SHALLOWEST, DEEPEST))


def _without_crumbs(points: Floats, triangles: Rows) -> tuple[Floats, Rows]:
    """Leave out components of less than a hundredth of the largest one's area: bubbles round outliers."""
    component, count = components_of(triangles, len(points))
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = np.bincount(component, np.linalg.norm(np.cross(b - a, c - a), axis=1), count)
    return _compact(points, triangles[(area >= CRUMB * area.max())[component]])


def _compact(points: Floats, triangles: Rows) -> tuple[Floats, Rows]:
    """The points that triangles use, and these in terms of them."""
    used, rows = np.unique(triangles, return_inverse=True)
    return points[used], rows.reshape(-1, 3).astype(np.int64)


def _open3d() -> Any:
    try:
        import open3d
    except ImportError:
        raise InputError("method poisson needs Open3D; install it: pip install 'subdfit[poisson]'") from None
    return open3d
