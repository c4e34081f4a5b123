"""`subdfit.subdivide`: a control mesh refined."""

from subdfit.api.cages import control_mesh_of
from subdfit.api.memory import check_refinement
from subdfit.api.sources import MeshSource
from subdfit.api.targets import check_count
from subdfit.errors import InputError
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.schemes import scheme_named

MOST_CORNERS = 2**31 - 1
"""Face corners are numbered by 32-bit integers; every step of every scheme makes four of each."""


def subdivide(
    mesh: ControlMesh | MeshSource, levels: int, scheme: str | None = None, *, limit: bool = False
) -> ControlMesh:
    """Refine a control mesh; creases and corners go with it.

    Parameters
    ----------
    mesh
        A `ControlMesh`, or a path or object that holds one.
    levels
        How many times; 0 gives the mesh itself.
    scheme
        Overrides the mesh's own; None takes that, else Loop where all faces are triangles, Catmull-Clark elsewhere.
    limit
        Put the refined vertices on the limit surface. The result is then no control mesh of that surface any more, and
        names no scheme.

    Raises
    ------
    InputError
        The mesh cannot be read or refined, or would become too large.
    """
    check_count(levels, "levels", 0)
    control = control_mesh_of(mesh, scheme)
    rules = scheme_named(control.scheme or "loop")
    rules.validate(control.topology)
    corners = len(control.topology.face_vertices)
    if levels >= 16 or corners * 4**levels > MOST_CORNERS:
        raise InputError(f"{levels} levels would make more than {MOST_CORNERS:,} face corners; ask for fewer")
    check_refinement(corners, levels)
    topology, points = control.topology, control.points
    for _ in range(levels):
        step = rules.refine(topology)
        topology, points = step.child, step.refined(points)
    if limit:
        return ControlMesh(topology, rules.limit_points(topology, points))
    return ControlMesh(topology, points, rules.name)
