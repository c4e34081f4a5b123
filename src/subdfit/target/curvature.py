"""Curvature of triangle meshes by the normal cycle, averaged over balls of a chosen radius.

Cohen-Steiner and Morvan, Restricted Delaunay triangulations and normal cycle, 2003: a polyhedron's curvature lies
in its edges. Over a region B of area |B|, ``sum(angle(e) |e in B| e e^T) / |B|`` tends to the tensor of curvature
with its two principal values exchanged. Nothing is asked of the triangles' shape.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.limit.curvature import PrincipalCurvature, principal_curvature, unit
from subdfit.mesh.checks import finite_points, numbers, row_numbers, triangle_rows
from subdfit.parallel import map_chunks
from subdfit.target._curvature_kernels import ball_measures
from subdfit.target.features import Edges, mesh_edges
from subdfit.target.local_quadrics import NEAREST, local_quadrics
from subdfit.target.normals import face_normals, vertex_normals

Floats = NDArray[np.float64]
Integers = NDArray[np.integer]

_CHUNK = 1024
_SPACING = 4.0
_ROUNDING = 1e-9
"""How far outside a triangle parameters may lie."""
_LEAST, _MOST = 0.015, 0.08
"""The default radius: four times the median edge, but within these shares of the diagonal."""


@dataclass(frozen=True)
class CurvatureField:
    """Curvature tensors at the vertices of a triangle mesh, and between them.

    Attributes
    ----------
    triangles : (m, 3) int, rows of the vertices.
    tensors : (n, 3, 3) float64, the shape operator as a symmetric matrix that maps the normal to zero.
    normals : (n, 3) float64, unit vectors, averaged as the tensors are.
    """

    triangles: Integers
    tensors: Floats
    normals: Floats

    def require_mesh(self, points: Floats, triangles: Integers) -> None:
        """Raise InputError unless this is the curvature of these points and triangles."""
        own, count = len(self.tensors), len(points)
        if own != count:
            raise InputError(f"curvature of {own} vertices for {count} points; give that of the mesh")
        if not np.array_equal(self.triangles, triangles):
            raise InputError("the curvature is that of other triangles; give that of the mesh")

    def at_vertices(self) -> PrincipalCurvature:
        """Principal curvatures at all vertices."""
        return principal_curvature(self.tensors, self.normals)

    def at(self, triangle: Integers, uv: Floats) -> PrincipalCurvature:
        """Principal curvatures at barycentric (1 - u - v, u, v) of triangles (k,), from interpolated tensors.

        Raises
        ------
        InputError
            No such triangle, or parameters that lie outside it.
        """
        triangle, uv = row_numbers(triangle, len(self.triangles), "triangle numbers"), numbers(uv, "parameters")
        if uv.shape != (len(triangle), 2):
            raise InputError(f"parameters of the shape {uv.shape} for {len(triangle)} triangles; give one pair each")
        inside = (uv >= -_ROUNDING).all(axis=1) & (uv.sum(axis=1) <= 1 + _ROUNDING)
        if not inside.all():
            row = int(np.argmin(inside))
            raise InputError(f"row {row}: parameters {uv[row]} lie outside the triangle; give u, v >= 0, u + v <= 1")
        weights = np.column_stack([1 - uv.sum(axis=1), uv])
        corners = self.triangles[triangle]
        tensors = np.einsum("kc,kcij->kij", weights, self.tensors[corners])
        return principal_curvature(tensors, np.einsum("kc,kcj->kj", weights, self.normals[corners]))


def curvature_field(points: Floats, triangles: Integers, radius: float | Floats | None = None) -> CurvatureField:
    """Curvature tensors at the vertices of a triangle mesh.

    Parameters
    ----------
    points : (n, 3) float64.
    triangles : (m, 3) int, rows of `points`, oriented alike, at most two an edge.
    radius
        Of the ball round each vertex over which curvature is averaged, in the unit of the points: one number or (n,).
        It should reach over several edges in the direction in which the surface bends. Default: `default_radius`.

    Returns
    -------
    CurvatureField
        Vertices of no triangle have zero tensors and normals.

    Raises
    ------
    InputError
        Points that are not finite, a row that is no point, or a radius that is not positive.
    """
    points = finite_points(points, "mesh")
    faces = np.ascontiguousarray(triangle_rows(triangles, len(points)), np.int32)
    edges = mesh_edges(points, faces)
    if radius is None:
        radius = default_radius(points, edges)
    seeds = np.full(len(points), -1, np.int32)
    seeds[faces[::-1]] = np.arange(len(faces), dtype=np.int32)[::-1, None]
    used = np.flatnonzero(seeds >= 0)
    radii = numbers(radius, "radii")
    if radii.shape not in ((), (len(points),)):
        raise InputError(f"radii of the shape {radii.shape} for {len(points)} points; give one number, or one a point")
    radii = np.broadcast_to(radii, len(points))[used]
    tensors, normals = ball_curvature(points, faces, edges, points[used], seeds[used], radii)
    field = CurvatureField(faces, np.zeros((len(points), 3, 3)), np.zeros((len(points), 3)))
    field.tensors[used], field.normals[used] = tensors, normals
    return field


def curvature_in_noise(points: Floats, triangles: Integers, noise: float) -> CurvatureField:
    """Curvature tensors at the vertices of a smooth piece of surface whose triangles noise turns; by local quadrics.

    Where it has too few vertices for these, the tensors are those of `curvature_field`.

    Parameters
    ----------
    points : (n, 3) float64, all of the piece.
    triangles : (m, 3) int, rows of `points`, oriented alike, at most two an edge.
    noise : standard deviation of the points, more than 0.
    """
    if len(points) < NEAREST:
        return curvature_field(points, triangles)
    found = local_quadrics(points, points, noise)
    facing = np.sum(found.normals * vertex_normals(points, triangles), axis=1)
    side = np.where(facing < 0, -1.0, 1.0)
    tensors, normals = side[:, None, None] * found.tensors, side[:, None] * found.normals
    return CurvatureField(np.ascontiguousarray(triangles, np.int32), tensors, normals)


def default_radius(points: Floats, edges: Edges) -> float:
    """Four times the median length of the edges, at least 1.5 % and at most 8 % of the diagonal of the used points."""
    lengths = np.linalg.norm(points[edges.vertices[:, 1]] - points[edges.vertices[:, 0]], axis=1)
    diagonal = float(np.linalg.norm(np.ptp(points[edges.vertices.ravel()], axis=0)))
    return float(np.clip(_SPACING * np.median(lengths), _LEAST * diagonal, _MOST * diagonal))


def ball_curvature(
    points: Floats,
    triangles: NDArray[np.int32],
    edges: Edges,
    centres: Floats,
    seeds: NDArray[np.int32],
    radii: Floats,
    walls: NDArray[np.bool_] | None = None,
    borders: NDArray[np.bool_] | None = None,
) -> tuple[Floats, Floats]:
    """Shape operators and normals of the pieces of surface within balls.

    A piece is connected inside its ball, so that another sheet of the surface that passes near does not count.
    Integrals carry the weight ``1 - (distance / radius)^2``, with which edges enter and leave the ball gently.

    Parameters
    ----------
    points, triangles, edges : the mesh, and its `mesh_edges`.
    centres : (c, 3) float64, points of the surface.
    seeds : (c,) int32, a triangle that holds each centre.
    radii : (c,) float64.
    walls : (e,) bool, edges that a piece does not cross and whose bend does not count.
    borders : (e,) bool, edges that it does not cross, but half of whose bend counts for each side.

    Returns
    -------
    tensors : (c, 3, 3) float64.
    normals : (c, 3) float64, unit vectors.
    """
    radii = np.require(radii, np.float64, ["C", "W"])
    if not np.all(radii > 0.0):
        raise InputError("the radius of curvature estimation must be positive; give a length in the mesh's unit")
    measures = np.empty((len(centres), 10))
    none = np.zeros(len(edges.angle), np.bool_)
    walls, borders = none if walls is None else walls, none if borders is None else borders
    bend = np.where(walls, 0.0, 0.5 * np.radians(signed_angles(points, triangles, edges)))
    passable = (edges.valence == 2) & ~walls & ~borders
    beyond = np.where(passable[edges.of_face], _beyond(edges), -1)
    arguments = (
        np.require(points, np.float64, ["C", "W"]),
        np.require(triangles, np.int32, ["C", "W"]),
        np.require(beyond, np.int32, ["C", "W"]),
        face_normals(points, triangles),
        bend[edges.of_face],
        np.require(centres, np.float64, ["C", "W"]),
        np.require(seeds, np.int32, ["C", "W"]),
        radii,
    )
    map_chunks(lambda start, stop: ball_measures(*arguments, start, stop, measures), len(centres), _CHUNK)
    return _shape_operators(measures)


def signed_angles(points: Floats, triangles: Integers, edges: Edges) -> Floats:
    """Degrees across each edge, (e,): positive where the surface is convex, seen from where the normals point."""
    inner = np.flatnonzero(edges.valence == 2)
    first, second = edges.faces[inner, 0], edges.faces[inner, 1]
    centres = points[triangles[second]].mean(axis=1) - points[edges.vertices[inner, 0]]
    below = np.sum(centres * face_normals(points, triangles[first]), axis=1) <= 0.0
    angle = np.zeros(len(edges.angle))
    angle[inner] = np.where(below, 1.0, -1.0) * edges.angle[inner]
    return angle


def _beyond(edges: Edges) -> NDArray[np.int64]:
    """Triangle across each side of each triangle, (m, 3), -1 on the boundary."""
    pair = edges.faces[edges.of_face]
    own = np.arange(len(pair))[:, None]
    return np.where(pair[..., 0] == own, pair[..., 1], pair[..., 0])


def _shape_operators(measures: Floats) -> tuple[Floats, Floats]:
    """Shape operators and unit normals from the integrals over balls.

    The normal cycle's tensor T has the principal values exchanged: in the tangent plane the shape operator is
    ``tr(T) - T``.
    """
    normals = unit(measures[:, 1:4])
    area = measures[:, 0]
    T = measures[:, [[4, 5, 6], [5, 7, 8], [6, 8, 9]]] / np.where(area > 0.0, area, 1.0)[:, None, None]
    P = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    T = P @ T @ P
    return np.trace(T, axis1=1, axis2=2)[:, None, None] * P - T, normals
