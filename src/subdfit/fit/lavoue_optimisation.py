"""Optimisation by squared distances from samples of the surface (Lavoué et al. 2007, section 5.1), for any scheme.

The samples are the limits of the control mesh refined a few times, and so fixed linear combinations of its control
points. Each round projects them to the target, takes the second-order model of the squared distance there from the
target's curvature, and minimises the sum: linear least squares in the control points.
"""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import spsolve

from subdfit.closest.projection import Projector
from subdfit.curves.squared_distance import tangential_weights
from subdfit.errors import InputError
from subdfit.limit.surface import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.schemes import Scheme, scheme_named
from subdfit.target.curvature import CurvatureField
from subdfit.target.target import Target

Floats = NDArray[np.float64]
Metric = Literal["squared-distance", "point"]

ROUNDS = 5
"""Rounds of optimisation, at most, before a control mesh is enriched: m0 in the paper's section 6."""
_OBLIQUE = 0.5
"""Share of an offset along the normal below which the nearest point is no foot of a perpendicular."""
_DAMPING = 1e-6
"""Weight of a control point's own displacement, as a share of the mean weight of the data; decides only what they leave
open."""


@dataclass(frozen=True)
class Optimised:
    """A control mesh after some rounds.

    Attributes
    ----------
    mesh : the control mesh of the round with the least mean distance.
    mean, rms, max : (rounds + 1,) float64 or fewer, distances of the samples from the target before each round and at
        the end, in the target's unit.
    """

    mesh: ControlMesh
    mean: Floats
    rms: Floats
    max: Floats


def refined_limit_rows(topology: Topology, scheme: Scheme, levels: int) -> sp.csr_array:
    """Rows (k, n) that take control points to the limits of the vertices after some refinements.

    Equation 7 of the paper in the order that holds: ``C = L M_l ... M_1``.
    """
    rows = sp.csr_array(sp.eye_array(topology.vertex_count, format="csr"))
    for _ in range(levels):
        step = scheme.refine(topology)
        topology, rows = step.child, sp.csr_array(step.matrix @ rows)
    return sp.csr_array(scheme.limit_rows(topology) @ rows)


def optimise(
    mesh: ControlMesh,
    target: Target,
    field: CurvatureField,
    *,
    rounds: int = ROUNDS,
    levels: int = 2,
    metric: Metric = "squared-distance",
    fixed: NDArray[np.bool_] | None = None,
    signed: bool = False,
    enough: float = 0.0,
    data: bool = False,
) -> Optimised:
    """Move control points until the samples of the surface lie on the target.

    Parameters
    ----------
    mesh : the control mesh, of any scheme.
    target : a mesh.
    field : curvature of the target's vertices.
    rounds : of projection and minimisation; m0 in the paper.
    levels : refinements before the limits are taken as samples; l0 in the paper.
    metric : ``squared-distance``, or ``point`` for the squared distance from the footpoint itself (Ma et al. 2004).
    fixed : (n,) bool, control points that stay, such as those of a boundary; default none.
    signed : use signed radii of curvature (see `tangential_weights`).
    enough : mean distance at which to stop.
    data : also draw the surface to the target's points, which samples that lie on a part of the target do not; the
        mean distance is then that of samples or of these points, whichever is larger.

    Raises
    ------
    InputError
        The target is a point cloud, the curvature another mesh's, one of mesh and target open and the other closed, the
        metric unknown, rounds below 0, or `fixed` not one flag a control point.
    """
    _require(mesh, target, field, rounds, metric, fixed)
    C = refined_limit_rows(mesh.topology, scheme_named(mesh.scheme or "loop"), levels)
    free = np.ones(len(mesh.points), np.bool_) if fixed is None else ~fixed
    points = best = mesh.points
    errors: list[tuple[float, float, float]] = []
    for k in range(rounds + 1):
        samples = C @ points
        nearest = target.tree.closest(samples)
        squares = nearest.distance**2
        mean = float(nearest.distance.mean())
        if data:
            pull = _pull(mesh.with_points(points), target)
            mean = max(mean, float(pull.distance.mean()))
        if k == 0 or mean < min(errors)[0]:
            best = points
        errors.append((mean, float(np.sqrt(squares.mean())), float(nearest.distance.max())))
        if k == rounds or mean <= enough or not free.any():
            break
        foot = target.on_triangles(nearest.triangle, nearest.uv)
        M = np.tile(np.eye(3), (len(foot), 1, 1))
        if metric == "squared-distance":
            M = distance_metric(field, nearest.triangle, nearest.uv, samples - foot, signed=signed)
        rows = C
        if data:
            rows, foot = sp.csr_array(sp.vstack([C, pull.rows])), np.concatenate([foot, pull.data])
            M = np.concatenate([M, pull.forms * (len(samples) / len(pull.data))])
        points = _least(rows, M, foot, points, free)
    return Optimised(mesh.with_points(best), *np.array(errors).T)


def _require(
    mesh: ControlMesh,
    target: Target,
    field: CurvatureField,
    rounds: int,
    metric: str,
    fixed: NDArray[np.bool_] | None,
) -> None:
    """Raise InputError for what `optimise` cannot take."""
    if not target.is_mesh:
        raise InputError("samples are projected to a target's faces, and it has none; use another method for points")
    field.require_mesh(target.points, target.triangles)
    kinds = ["open" if there.any() else "closed" for there in (mesh.topology.boundary_edges, target.boundary_edges)]
    if kinds[0] != kinds[1]:
        raise InputError(f"the control mesh is {kinds[0]} and the target {kinds[1]}; give both open or both closed")
    if metric not in ("squared-distance", "point"):
        raise InputError(f"metric is '{metric}'; give squared-distance or point")
    if rounds < 0:
        raise InputError(f"rounds is {rounds}; give 0 or more")
    if fixed is not None and (np.shape(fixed) != (len(mesh.points),) or np.asarray(fixed).dtype != np.bool_):
        raise InputError(
            f"fixed is {np.asarray(fixed).dtype} of the shape {np.shape(fixed)} for {len(mesh.points)} control points; "
            "give one bool each"
        )


def distance_metric(
    field: CurvatureField, triangle: NDArray[np.integer], uv: Floats, offset: Floats, *, signed: bool = False
) -> Floats:
    """Quadratic forms (k, 3, 3) of the squared distance about footpoints (equation 1).

    Weight one along the normal; along each principal direction the weight of `tangential_weights` for the distance and
    the radius of curvature. Where the offset is not along the normal, as beyond a boundary, the footpoint is the
    nearest point and not the foot of a perpendicular, and all directions weigh one.
    """
    found = field.at(triangle, uv)
    height = np.sum(offset * found.normal, axis=1)
    weights = []
    for curvature in (found.minimum, found.maximum):
        # Curvature is positive where the centre lies below the surface, at minus the radius.
        radius = np.divide(-1.0, curvature, out=np.full(len(curvature), np.inf), where=curvature != 0)
        weights.append(tangential_weights(height, radius, signed=signed))
    axes = (found.minimum_direction, found.maximum_direction, found.normal)
    forms = [a[:, :, None] * a[:, None, :] for a in axes]
    metric = weights[0][:, None, None] * forms[0] + weights[1][:, None, None] * forms[1] + forms[2]
    oblique = np.abs(height) < _OBLIQUE * np.linalg.norm(offset, axis=1)
    metric[oblique] = np.eye(3)
    return np.asarray(metric)


class _Pull(NamedTuple):
    """Rows (d, n) of the surface's points nearest to the target's `data`, their distances, and the squares' forms."""

    rows: sp.csr_array
    data: Floats
    distance: Floats
    forms: Floats


def _pull(mesh: ControlMesh, target: Target) -> _Pull:
    """What draws a surface to the target's points: along their normals, all ways where it ends before it comes near."""
    surface, data, normal = LimitSurface(mesh), target.points[target.used], target.normals[target.used]
    met = Projector(surface).nearest(data)
    height = np.sum((surface.evaluate(met.face, met.uv).position - data) * normal, axis=1)
    forms = normal[:, :, None] * normal[:, None, :]
    forms[np.abs(height) < _OBLIQUE * met.distance] = np.eye(3)
    return _Pull(surface.weights(met.face, met.uv), data, met.distance, forms)


def _least(C: sp.csr_array, M: Floats, foot: Floats, points: Floats, free: NDArray[np.bool_]) -> Floats:
    """Control points that minimise ``sum (C_k P - foot_k)^T M_k (C_k P - foot_k)``; those that are not free stay."""
    rest = foot - C @ points
    part = C[:, free]
    blocks = [[part.T @ sp.diags_array(M[:, i, j]) @ part for j in range(3)] for i in range(3)]
    right = np.concatenate([part.T @ np.einsum("kj,kj->k", M[:, i], rest) for i in range(3)])
    system = sp.csc_array(sp.block_array(blocks))
    damping = _DAMPING * float(system.diagonal().mean())
    step = spsolve(sp.csc_array(system + damping * sp.eye_array(len(right))), right)
    moved = points.copy()
    moved[free] += step.reshape(3, -1).T
    return moved
