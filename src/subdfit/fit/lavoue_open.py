"""The whole algorithm for open surfaces: optimisation and enrichment in a nested loop.

Lavoué, Dupont and Baskurt 2007, section 6.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.fit.lavoue import SCHEMES
from subdfit.fit.lavoue_enrichment import Faces, is_diffuse, principal_error_field
from subdfit.fit.lavoue_optimisation import ROUNDS, optimise
from subdfit.limit.surface import LimitSurface
from subdfit.limit.tessellate import lattice
from subdfit.measure.facing import MOST_AWAY, share_facing_away
from subdfit.mesh.checks import positive_length
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.target.bvh import TriangleTree
from subdfit.target.curvature import CurvatureField
from subdfit.target.features import mesh_edges
from subdfit.target.target import Target

Floats = NDArray[np.float64]

_SEGMENTS, _FINE = 6, 16
"""Segments a side into which the surface is cut for its error field, and for its errors."""
_VAIN = 12
"""Enrichments in a row that bring nothing before giving up: of a surface that folds, more only crumple it."""


@dataclass(frozen=True)
class OpenFit:
    """A control mesh fitted to an open surface.

    Attributes
    ----------
    mesh : the control mesh; its boundary is that of the first one.
    mean : the larger of the mean distances of the surface from the target and of the target's points from the surface,
        in the target's unit.
    away : share of the surface's area that faces against the target.
    within : whether the mean is within the tolerance, and the surface not folded.
    history : control vertices and mean distance after each optimisation.
    """

    mesh: ControlMesh
    mean: float
    away: float
    within: bool
    history: list[tuple[int, float]]


def fit_open(
    start: ControlMesh,
    target: Target,
    field: CurvatureField,
    *,
    tolerance: float | None = None,
    rounds: int = ROUNDS,
    most_vertices: int = 1000,
) -> OpenFit:
    """Fit the inside of an open surface, boundary control points held, with as few more as the tolerance needs.

    Parameters
    ----------
    start : the first control mesh, such as `boundary_start` makes.
    target, field : the mesh and the curvature at its vertices.
    tolerance : mean distance between surface and target, either way, in the target's unit; None is the paper's 5e-3 of
        the longest side of the bounding box.
    rounds : of an optimisation at most; m0 in the paper.
    most_vertices : where to stop enriching.

    Raises
    ------
    InputError
        The scheme has no faces of any number of sides, the tolerance is not positive, the target is a point cloud, the
        curvature another mesh's, or one of start and target is open and the other closed.
    """
    if start.scheme not in SCHEMES:
        raise InputError(f"faces are enriched by quads and triangles; choose the scheme {' or '.join(SCHEMES)}")
    if tolerance is None:
        tolerance = 5e-3 * float(np.ptp(target.points[target.used], axis=0).max())
    tolerance = positive_length(tolerance, "the tolerance of the mean distance")
    mesh, best, vain, refined = start, None, 0, None
    history: list[tuple[int, float]] = []
    while True:
        found = optimised(mesh, target, field, tolerance, rounds, history)
        history.append((len(found.mesh.points), found.mean))
        if best is None or _rank(found) < _rank(best):
            best, vain = found, 0
        vain += 1
        if found.within or vain > _VAIN or len(mesh.points) >= most_vertices:
            return best
        # Folds stay, however many vertices follow: once it folds, the best is refined where it got a vertex before.
        folds = found.away > MOST_AWAY >= best.away and best is not refined
        refined = best if folds else refined
        mesh = enriched(best.mesh if folds else found.mesh, target, diffuse=folds)


def optimised(
    mesh: ControlMesh,
    target: Target,
    field: CurvatureField,
    tolerance: float,
    rounds: int,
    history: list[tuple[int, float]],
) -> OpenFit:
    """One optimisation, boundary control points held, by as few rounds as the tolerance needs.

    Parameters
    ----------
    mesh, target, field, tolerance, rounds : as in `fit_open`.
    history : what the result is to carry of the optimisations before.
    """
    # Near enough by few samples is not enough, nor where sheets have fallen together: then all rounds are run.
    for enough in (tolerance, 0.0):
        step = optimise(
            mesh, target, field, rounds=rounds, fixed=mesh.topology.boundary_vertices, enough=enough, data=True
        )
        mesh, (mean, away) = step.mesh, _errors(step.mesh, target)
        found = OpenFit(mesh, mean, away, mean <= tolerance and away <= MOST_AWAY, history)
        if step.mean.min() > tolerance or found.within:
            break
    return found


def _rank(fit: OpenFit) -> tuple[bool, bool, float]:
    """The better, the less: what folds comes after what does not, however near."""
    return not fit.within, fit.away > MOST_AWAY, fit.mean


def _errors(mesh: ControlMesh, target: Target) -> tuple[float, float]:
    """The larger of the mean distances to the target and from it, and the share of the area that faces away."""
    surface = LimitSurface(mesh)
    grid = lattice(surface.domain, _FINE)
    samples = surface.evaluate(grid.face, grid.uv).position
    there = target.tree.closest(samples)
    back = TriangleTree(samples, grid.triangles).closest(target.points[target.used])
    away = share_facing_away(samples, grid.triangles, target, there.triangle)
    return float(max(there.distance.mean(), back.distance.mean())), away


def enriched(mesh: ControlMesh, target: Target, *, diffuse: bool = False) -> ControlMesh:
    """One enrichment: of the faces in which the principal error field lies.

    A field with a centre is a fault of the connectivity: its faces are merged round a new vertex. A diffuse one, or one
    that holds a control vertex already, lacks freedom: each of its faces is refined.
    """
    surface = LimitSurface(mesh)
    grid = lattice(surface.domain, _SEGMENTS)
    samples = surface.evaluate(grid.face, grid.uv).position
    distance, place = _field(target, samples, grid.triangles)
    field = principal_error_field(distance, mesh_edges(samples, grid.triangles).vertices)
    face = np.repeat(mesh.topology.face[surface.domain.half_edge], np.diff(grid.begin))
    chosen = concerned(field, grid.triangles, face)
    faces = Faces.of(mesh)
    inner = np.flatnonzero(~mesh.topology.boundary_vertices)
    around = [set(np.flatnonzero(mesh.topology.face_vertices == v)) for v in inner]
    holds_vertex = any({int(mesh.topology.face[h]) for h in corners} <= set(chosen) for corners in around)
    local = not diffuse and not holds_vertex and not is_diffuse(distance, field)
    if not (local and faces.merge_and_insert(chosen, place)):
        faces.enrich_each(chosen)
    return faces.frozen(mesh)


def concerned(field: NDArray[np.bool_], triangles: NDArray[np.int32], face: NDArray[np.integer]) -> list[int]:
    """Faces that hold samples of a field inside, not just on their sides; without any, those that it touches."""
    low, high = np.full(len(field), face.max()), np.zeros(len(field), np.int64)
    np.minimum.at(low, triangles, face[:, None])
    np.maximum.at(high, triangles, face[:, None])
    inside = field & (low == high)
    found = low[inside] if inside.any() else face[field[triangles].any(axis=1)]
    return [int(k) for k in np.unique(found)]


def _field(target: Target, samples: Floats, triangles: NDArray[np.int32]) -> tuple[Floats, Floats]:
    """Distances of samples, or of what of the target is nearest to them, and the target's place of the largest."""
    there = target.tree.closest(samples)
    data = target.points[target.used]
    back = TriangleTree(samples, triangles).closest(data)
    distance = there.distance.copy()
    np.maximum.at(distance, triangles[back.triangle], back.distance[:, None])
    far, worst = int(np.argmax(back.distance)), int(np.argmax(there.distance))
    if back.distance[far] > there.distance[worst]:
        return distance, data[far]
    return distance, target.on_triangles(there.triangle[[worst]], there.uv[[worst]])[0]
