"""The whole algorithm for open surfaces: optimisation and enrichment in a nested loop.

Lavoué, Dupont and Baskurt 2007, section 6.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.lavoue_enrichment import Faces, is_diffuse, principal_error_field
from subdfit.fit.lavoue_optimisation import optimise
from subdfit.limit.surface import LimitSurface
from subdfit.limit.tessellate import lattice
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.schemes import scheme_named
from subdfit.target.curvature import CurvatureField
from subdfit.target.features import mesh_edges
from subdfit.target.target import Target

Floats = NDArray[np.float64]

_SEGMENTS = 6
"""Segments a side into which the surface is cut for its error field."""


@dataclass(frozen=True)
class OpenFit:
    """A control mesh fitted to an open surface.

    Attributes
    ----------
    mesh : the control mesh; its boundary is that of the first one.
    mean : mean distance of its samples from the target, in the target's unit.
    history : control vertices and mean distance after each optimisation.
    """

    mesh: ControlMesh
    mean: float
    history: list[tuple[int, float]]


def fit_open(
    start: ControlMesh,
    target: Target,
    field: CurvatureField,
    *,
    tolerance: float | None = None,
    rounds: int = 5,
    most_vertices: int = 1000,
) -> OpenFit:
    """Fit the inside of an open surface, boundary control points held, with as few more as the tolerance needs.

    Parameters
    ----------
    start : the first control mesh, such as `boundary_start` makes.
    target, field : the mesh and the curvature at its vertices.
    tolerance : mean distance of samples from the target, in its unit; None is the paper's 5e-3 of the longest side of
        the bounding box.
    rounds : of an optimisation at most; m0 in the paper.
    most_vertices : where to stop enriching.
    """
    if tolerance is None:
        tolerance = 5e-3 * float(np.ptp(target.points[target.used], axis=0).max())
    mesh, history = start, []
    best: OpenFit | None = None
    while True:
        held = np.zeros(len(mesh.points), np.bool_)
        held[mesh.topology.edge_vertices[mesh.topology.boundary_edges]] = True
        found = optimise(mesh, target, field, rounds=rounds, fixed=held, enough=tolerance)
        mesh, mean = found.mesh, float(found.mean.min())
        history.append((len(mesh.points), mean))
        if best is None or mean < best.mean:
            best = OpenFit(mesh, mean, history)
        if mean <= tolerance or len(mesh.points) >= most_vertices:
            return best
        mesh = enriched(mesh, target)


def enriched(mesh: ControlMesh, target: Target) -> ControlMesh:
    """One enrichment: of the faces in which the principal error field lies.

    A field with a centre is a fault of the connectivity: its faces are merged round a new vertex. A diffuse one, or one
    that holds a control vertex already, lacks freedom: each of its faces is refined.
    """
    surface = LimitSurface(mesh, scheme_named(mesh.scheme or "loop"))
    grid = lattice(surface.domain, _SEGMENTS)
    samples = surface.evaluate(grid.face, grid.uv).position
    nearest = target.tree.closest(samples)
    field = principal_error_field(nearest.distance, mesh_edges(samples, grid.triangles).vertices)
    face = np.repeat(mesh.topology.face[surface.domain.half_edge], np.diff(grid.begin))
    chosen = np.unique(face[field[grid.triangles].any(axis=1)]).tolist()
    faces = Faces.of(mesh)
    inner = np.ones(len(mesh.points), np.bool_)
    inner[mesh.topology.edge_vertices[mesh.topology.boundary_edges]] = False
    around = [set(np.flatnonzero(mesh.topology.face_vertices == v)) for v in np.flatnonzero(inner)]
    holds_vertex = any({int(mesh.topology.face[h]) for h in corners} <= set(chosen) for corners in around)
    worst = int(np.argmax(nearest.distance))
    place = target.on_triangles(nearest.triangle[[worst]], nearest.uv[[worst]])[0]
    local = len(chosen) > 1 and not holds_vertex and not is_diffuse(nearest.distance, field)
    if not (local and faces.merge_and_insert(chosen, place)):
        faces.enrich_each(chosen)
    return faces.frozen(mesh)
