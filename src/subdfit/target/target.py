"""What is known of the data to be fitted: its points, faces, normals, curves, and searches among them."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from subdfit.errors import InputError
from subdfit.mesh.checks import finite_points, triangle_rows
from subdfit.target.bvh import Closest, SegmentTree, TriangleTree
from subdfit.target.curves import boundary_corners, boundary_edges
from subdfit.target.faceting import height, rises, sagitta
from subdfit.target.features import automatic_creases, crease_edges
from subdfit.target.frame import Frame
from subdfit.target.normals import face_normals, vertex_normals

Creases = Literal["auto", "none"] | float

_PIECES = 8
"""Segments along the surface between two points."""
_ON_RIM = 1e-9
"""Feet this near the boundary, as a share of the diagonal, lie on it."""


@dataclass(frozen=True)
class Target:
    """A dense mesh, or a point cloud where there are no triangles.

    Make one with `mesh_target` or `point_target`.

    Attributes
    ----------
    points : (n, 3) float64, in the file's unit; a row number is the point's name.
    triangles : (m, 3) int32, rows of `points`; m = 0 for a point cloud.
    normals : (n, 3) float64, unit vectors; zero where none is known.
    boundary_edges : (b, 2) int64, with the triangles on the left.
    crease_edges : (c, 2) int64.
    corners : (k,) int64, points of the boundary at which it turns sharply.
    used : (k,) int64, the points that count: those of triangles, or all of a point cloud.
    diagonal : length of the diagonal of the bounding box of the used points.
    cloud : the triangles were made from the points: they guide, but only the points count as data.
    within : (k, 2, 3) float64, segments on the surface along which a control mesh has a crease and the target none.
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.int32]
    normals: NDArray[np.float64]
    boundary_edges: NDArray[np.int64]
    crease_edges: NDArray[np.int64]
    corners: NDArray[np.int64]
    used: NDArray[np.int64]
    diagonal: float
    cloud: bool = False
    within: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 2, 3)))

    @property
    def is_mesh(self) -> bool:
        """Whether there are triangles."""
        return len(self.triangles) > 0

    @cached_property
    def tree(self) -> TriangleTree:
        """Search for closest points on the triangles; a point cloud raises `InputError`."""
        return TriangleTree(self.points, self.triangles)

    @cached_property
    def boundary_tree(self) -> SegmentTree | None:
        """Search for closest points on the boundary; None where there is none."""
        return SegmentTree(self.points, self.boundary_edges) if len(self.boundary_edges) else None

    @cached_property
    def crease_tree(self) -> SegmentTree | None:
        """Search for closest points on the creases, and on what stands for them `within`; None where there are none."""
        own = len(self.points) + np.arange(2 * len(self.within)).reshape(-1, 2)
        edges = np.concatenate([self.crease_edges, own])
        return SegmentTree(np.concatenate([self.points, self.within.reshape(-1, 3)]), edges) if len(edges) else None

    def on_triangles(self, triangle: NDArray[np.integer], uv: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (k, 3) at barycentric (1 - u - v, u, v) of triangles (k,)."""
        weights = np.column_stack([1 - uv.sum(axis=1), uv])
        corners = self.points[self.triangles[triangle]]
        return np.asarray(np.einsum("kc,kcd->kd", weights, corners), np.float64)

    def normalised(self, frame: Frame) -> "Target":
        """The same data in the normalised coordinates of a frame."""
        within = frame.inside(self.within.reshape(-1, 3)).reshape(-1, 2, 3)
        return replace(self, points=frame.inside(self.points), diagonal=self.diagonal / frame.diagonal, within=within)

    def creased_within(self, ends: NDArray[np.float64]) -> "Target":
        """The same data with other segments `within`: along the surface between pairs of points, (k, 2, 3)."""
        if len(ends) == len(self.within) == 0:
            return self
        share = np.linspace(0.0, 1.0, _PIECES + 1)[:, None]
        chords = ends[:, :1] * (1 - share) + ends[:, 1:] * share
        found = self.tree.closest(chords.reshape(-1, 3))
        along = self.on_triangles(found.triangle, found.uv).reshape(chords.shape)
        return replace(self, within=np.stack([along[:, :-1], along[:, 1:]], axis=2).reshape(-1, 2, 3))

    def nearest_point(self, queries: NDArray[np.float64]) -> NDArray[np.float64]:
        """Distances of (q, 3) queries from the nearest used point, (q,): what a cloud knows of closeness."""
        distance, _ = cKDTree(self.points[self.used]).query(queries)
        return np.asarray(distance, np.float64)

    @cached_property
    def _rises(self) -> NDArray[np.float64]:
        return rises(self.points, self.triangles, self.crease_edges)

    @cached_property
    def faceting(self) -> float:
        """How far the surface that the mesh stands for may lie off its triangles, at most; 0 for a point cloud."""
        return float(sagitta(self._rises).max()) if self.is_mesh else 0.0

    def sagitta(self, triangle: NDArray[np.integer], uv: NDArray[np.float64]) -> NDArray[np.float64]:
        """How far that surface lies off points of triangles, (k,): 0 at vertices, continuous across edges."""
        return height(self._rises, triangle, uv)

    def allowance(self, queries: NDArray[np.float64], found: Closest) -> NDArray[np.float64]:
        """How far queries, (q, 3), may lie off their feet `found` on the triangles for no fault of the surface, (q,).

        By the sagitta at the foot; and beyond the rim of a cloud, which is as ragged as the points are apart, in the
        plane of the triangle, by the distance to the next point along it.
        """
        allowed = self.sagitta(found.triangle, found.uv)
        if not self.cloud or self.boundary_tree is None:
            return allowed
        feet = self.on_triangles(found.triangle, found.uv)
        rim = self.boundary_tree.closest(feet)
        on_rim = rim.distance <= _ON_RIM * self.diagonal
        step = np.linalg.norm(np.diff(self.points[self.boundary_edges[rim.segment]], axis=1)[:, 0], axis=1)
        normal = face_normals(self.points, self.triangles[found.triangle])
        above = np.abs(np.einsum("kd,kd->k", queries - feet, normal))
        beyond = np.sqrt(np.maximum(found.distance**2 - above**2, 0.0))
        held = np.hypot(above, np.maximum(beyond - step, 0.0))
        return allowed + np.where(on_rim, found.distance - held, 0.0)

    def gaps(self, queries: NDArray[np.float64], near: NDArray[np.int32] | None = None) -> NDArray[np.float64]:
        """How far queries, (q, 3), lie off the triangles beyond their allowance, (q,); see `TriangleTree.closest`."""
        found = self.tree.closest(queries, start=near)
        return found.distance - self.allowance(queries, found)


def mesh_target(points: NDArray[np.float64], triangles: NDArray[np.integer], *, creases: Creases = "auto") -> Target:
    """Gather what is known of a triangle mesh.

    Parameters
    ----------
    points : (n, 3) float64; those of no triangle stay but do not count.
    triangles : (m, 3) int, rows of `points`, oriented alike, at most two an edge.
    creases : ``"auto"`` for edges that are surely sharp, ``"none"``, or the angle in degrees above which
        an edge is a crease. Corners of the boundary are looked for unless it is ``"none"``.

    Raises
    ------
    InputError
        No triangles, a row that is no point, a coordinate that is not finite, or no extent.
    """
    points = finite_points(points, "target")
    faces = np.ascontiguousarray(triangle_rows(triangles, len(points)), np.int32)
    used = np.unique(faces).astype(np.int64)
    boundary = boundary_edges(faces)
    return Target(
        points=points,
        triangles=faces,
        normals=vertex_normals(points, faces),
        boundary_edges=boundary,
        crease_edges=_creases(points, faces, creases),
        corners=np.empty(0, np.int64) if creases == "none" else boundary_corners(points, boundary),
        used=used,
        diagonal=_diagonal(points[used]),
    )


def point_target(points: NDArray[np.float64], normals: NDArray[np.float64] | None = None) -> Target:
    """Gather what is known of a point cloud.

    Parameters
    ----------
    points : (n, 3) float64, n >= 1.
    normals : (n, 3) float64, optional; zero rows where unknown.

    Raises
    ------
    InputError
        No points, a coordinate that is not finite, no extent, or not one normal a point.
    """
    points = finite_points(points, "target")
    if normals is not None and np.shape(normals) != points.shape:
        raise InputError(f"{len(normals)} normals for {len(points)} points; give one a point, or none")
    return Target(
        points=points,
        triangles=np.empty((0, 3), np.int32),
        normals=np.zeros_like(points) if normals is None else np.ascontiguousarray(normals, np.float64),
        boundary_edges=np.empty((0, 2), np.int64),
        crease_edges=np.empty((0, 2), np.int64),
        corners=np.empty(0, np.int64),
        used=np.arange(len(points)),
        diagonal=_diagonal(points),
    )


def cloud_target(
    points: NDArray[np.float64],
    triangles: NDArray[np.integer],
    *,
    creases: Creases = "none",
    used: NDArray[np.int64] | None = None,
) -> Target:
    """Gather what is known of a point cloud and of a mesh through most of its points; arguments as for `mesh_target`.

    The `used` points (k,) count as data, those of no triangle too; all where it is None. Others may be in triangles.
    """
    guide = mesh_target(points, triangles, creases=creases)
    used = np.arange(len(guide.points)) if used is None else used
    diagonal, none = _diagonal(guide.points[used]), np.empty(0, np.int64)
    return replace(guide, corners=none, used=used, diagonal=diagonal, cloud=True)


def _diagonal(points: NDArray[np.float64]) -> float:
    diagonal = float(np.linalg.norm(points.max(axis=0) - points.min(axis=0)))
    if not diagonal > 0.0:
        raise InputError("all points of the target coincide; there is nothing to fit")
    return diagonal


def _creases(points: NDArray[np.float64], triangles: NDArray[np.integer], creases: Creases) -> NDArray[np.int64]:
    if creases == "none":
        return np.empty((0, 2), np.int64)
    if creases == "auto":
        return automatic_creases(points, triangles)
    return crease_edges(points, triangles, float(creases))
