"""Vertices taken out of an open surface's control mesh where the error allows.

Enrichment refines whole faces of an error field (Lavoué, Dupont and Baskurt 2007, section 5.2): more than the tolerance
needs.
"""

from subdfit.fit.lavoue_enrichment import Faces
from subdfit.fit.lavoue_open import OpenFit, optimised
from subdfit.fit.lavoue_optimisation import ROUNDS
from subdfit.mesh.checks import positive_length
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.target.curvature import CurvatureField
from subdfit.target.target import Target


def lightened(
    found: OpenFit, target: Target, field: CurvatureField, tolerance: float, *, rounds: int = ROUNDS
) -> OpenFit:
    """Take inner vertices out of a fit one by one, merging the faces round each, while the tolerance is met.

    Parameters
    ----------
    found : a fit within the tolerance; another is returned as it is.
    target, field : the mesh and the curvature at its vertices.
    tolerance : mean distance between surface and target, either way, in the target's unit.
    rounds : of an optimisation at most.

    Returns
    -------
    OpenFit
        From which no single vertex can be taken out; the boundary is as it was, and no more of the surface faces away.

    Raises
    ------
    InputError
        The tolerance is not positive, or the curvature another mesh's.
    """
    tolerance = positive_length(tolerance, "the tolerance of the mean distance")
    field.require_mesh(target.points, target.triangles)
    most_away = found.away
    while found.within:
        before = found
        # The last vertices came by the finest enrichments.
        for vertex in range(len(found.mesh.points) - 1, -1, -1):
            mesh = _without(found.mesh, vertex) if vertex < len(found.mesh.points) else None
            if mesh is not None:
                tried = optimised(mesh, target, field, tolerance, rounds, found.history)
                found = tried if tried.within and tried.away <= most_away else found
        if found is before:
            break
    return found


def _without(mesh: ControlMesh, vertex: int) -> ControlMesh | None:
    """The control mesh with the faces round an inner vertex as one; None where they are not to be merged."""
    if mesh.topology.boundary_vertices[vertex]:
        return None
    faces = Faces.of(mesh)
    return faces.frozen(mesh) if faces.take_out(vertex) else None
