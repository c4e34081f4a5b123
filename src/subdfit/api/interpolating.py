"""`subdfit.interpolate`: the control mesh whose limit surface passes through every vertex of a given mesh."""

import logging
import time
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from subdfit.api.cages import control_mesh_of
from subdfit.api.creases import with_creases
from subdfit.api.fitting import elapsed
from subdfit.api.sources import MeshSource
from subdfit.api.surface import LimitSurface
from subdfit.api.targets import Preparation, check_count, stages
from subdfit.api.workers import workers
from subdfit.compiled import compile_clock
from subdfit.errors import InputError
from subdfit.fit.result import mesh_counts
from subdfit.interpolate import METHODS, Interpolation, LimitOperator, Status, interpolate_points
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.schemes import scheme_named
from subdfit.target.frame import Frame

logger = logging.getLogger(__name__)

DEFAULT_TOLERANCE = 1e-12
MOST_ITERATIONS = 10_000


@dataclass(frozen=True, eq=False, repr=False)
class InterpolationResult:
    """The control mesh whose limit surface passes through given points.

    Attributes
    ----------
    control_mesh : in the coordinates and unit of the given mesh; its vertices are that mesh's, in their order.
    method : the solver.
    status : ``within_tolerance``, ``best_effort`` or ``interrupted``.
    residuals : at each iteration, the largest distance of a limit point from its vertex, as a share of the diagonal.
    distances : (n,), these distances in the end, computed afresh, as shares of the diagonal.
    null_vectors : number of independent control meshes that the scheme shrinks to nothing; 0 almost always.
    diagonal : of the given mesh's bounding box.
    settings, seconds : what was asked; by stage.
    unit : its name, or None.
    """

    control_mesh: ControlMesh
    method: str
    status: Status
    residuals: tuple[float, ...]
    distances: NDArray[np.float64]
    null_vectors: int
    diagonal: float
    settings: dict[str, Any]
    seconds: dict[str, float] = field(default_factory=dict)
    unit: str | None = None

    @cached_property
    def surface(self) -> LimitSurface:
        """The limit surface."""
        return LimitSurface(self.control_mesh)

    @property
    def iterations(self) -> int:
        """Number of iterations."""
        return len(self.residuals) - 1

    def to_dict(self) -> dict[str, Any]:
        """The object that ``--json`` writes; errors and residuals are shares of the diagonal.

        The surface between the vertices is not measured, so that nothing is certified.
        """
        from subdfit import __version__

        return {
            "scheme": self.control_mesh.scheme,
            "method": self.method,
            "status": self.status,
            "certified": False,
            "iterations": self.iterations,
            **mesh_counts(self.control_mesh),
            "diagonal": self.diagonal,
            "unit": self.unit,
            "errors": _errors(self.control_mesh.topology, self.distances),
            "null_vectors": self.null_vectors,
            "seconds": self.seconds,
            "settings": self.settings,
            "version": __version__,
            "residuals": list(self.residuals),
        }

    def __repr__(self) -> str:
        return (
            f"<InterpolationResult {len(self.distances):,} points, {self.status.replace('_', ' ')}: "
            f"largest relative error {self.distances.max():.2g}, {self.iterations} iterations>"
        )


def interpolate(
    mesh: ControlMesh | MeshSource,
    *,
    scheme: str | None = None,
    method: str = "cg",
    creases: Literal["auto", "none"] | float = "auto",
    tolerance: float = DEFAULT_TOLERANCE,
    most_iterations: int = MOST_ITERATIONS,
    unit: str | None = None,
    threads: int | None = None,
) -> InterpolationResult:
    """Find the control mesh whose limit surface passes through every vertex of a mesh.

    Parameters
    ----------
    mesh
        A path, ``(vertices, faces)`` arrays, `MeshData`, a `ControlMesh`, a trimesh or a PyVista object: any size and
        topology that the scheme takes. A manifold keeps its vertices in their order; another mesh is mended first.
    scheme
        Overrides the mesh's own; None takes that, else Loop for triangles, Catmull-Clark for others.
    method
        ``cg`` solves corners, then curves, then the rest by conjugate gradients (by BiCGStab where no diagonal makes
        the system symmetric); ``progressive`` is the iteration of Cheng et al.; ``over-relaxation`` and ``chebyshev``
        are that one with better factors.
    creases
        ``auto`` takes the creases that the mesh tags, else edges that are surely sharp; ``none``; or an angle in
        degrees above which an edge is a crease. Boundaries and creases are interpolated by their own curves.
    tolerance
        Stop where no limit point is farther from its vertex than this share of the bounding box's diagonal.
    most_iterations
        Stop there in any case.
    unit
        The unit's name, for messages.
    threads
        Threads to use; None takes one a core. The result does not depend on it.

    Returns
    -------
    InterpolationResult
        Whether the tolerance was reached is in its `status`. Where the scheme's operator is singular a warning says so,
        and the control mesh is the least one among those that come nearest.

    Raises
    ------
    InputError
        The mesh or an option cannot be used; the text says why, and what to do.

    Examples
    --------
    >>> result = subdfit.interpolate("bunny.ply")  # doctest: +SKIP
    >>> result.surface.vertex_limits()  # the bunny's vertices  # doctest: +SKIP
    """
    _check(method, tolerance, most_iterations)
    how = Preparation(creases)
    begun, compiled = time.perf_counter(), compile_clock.seconds
    with workers(threads):
        stages.info("reading")
        given = with_creases(control_mesh_of(mesh, scheme), how.creases)
        read = time.perf_counter() - begun
        clock = time.perf_counter()
        stages.info("making the limit operator")
        rules = scheme_named(given.scheme or "loop")
        rules.validate(given.topology)
        operator = LimitOperator.of(rules.limit_rows(given.topology))
        made = time.perf_counter() - clock
        clock = time.perf_counter()
        stages.info("solving")
        frame = _frame(given.points)
        found = interpolate_points(
            operator, given.topology, frame.inside(given.points), method, tolerance, most_iterations
        )
        solved = time.perf_counter() - clock
    _warn(found)
    seconds = {"read": read, "operator": made, "solve": solved} | elapsed(begun, compiled)
    asked = {"method": method, "creases": how.creases, "tolerance": tolerance, "threads": threads}
    return InterpolationResult(
        given.with_points(frame.outside(found.points)),
        method,
        found.status,
        found.residuals,
        found.distances,
        found.null_vectors,
        frame.diagonal,
        asked,
        seconds,
        unit,
    )


def _check(method: str, tolerance: float, most_iterations: int) -> None:
    """Raise InputError for options that cannot be, before any work is done."""
    if method not in METHODS:
        raise InputError(f"unknown method '{method}'; choose one of {', '.join(METHODS)}")
    if isinstance(tolerance, bool) or not isinstance(tolerance, int | float) or not 0 < tolerance < 1:
        raise InputError(f"tolerance is {tolerance!r}; give a share of the diagonal between 0 and 1, such as 1e-10")
    check_count(most_iterations, "most_iterations", 1)


def _frame(points: NDArray[np.float64]) -> Frame:
    """The normalised frame; points that all coincide keep their unit."""
    frame = Frame.of(points)
    return frame if frame.diagonal > 0 else replace(frame, diagonal=1.0)


def _warn(found: Interpolation) -> None:
    if found.null_vectors:
        logger.warning(
            "the scheme cannot move every vertex by itself here (all valences 3, all faces even, in %d components): "
            "the least control mesh is given, its largest relative error is %.2g",
            found.null_vectors,
            found.distances.max(),
        )


def _errors(t: Topology, distances: NDArray[np.float64]) -> dict[str, Any]:
    """The errors as ``--json`` names them; the reverse side is not measured."""
    return {
        "max": float(distances.max()),
        "rms": float(np.sqrt(np.mean(distances**2))),
        "mean": float(distances.mean()),
        "reverse_max": None,
        "reverse_rms": None,
        "reverse_mean": None,
        "boundary": _curve_errors(t, t.boundary_edges, distances),
        "crease": _curve_errors(t, (t.sharpness > 0) & ~t.boundary_edges, distances),
        "excluded": 0,
        "target_faceting": None,
    }


def _curve_errors(t: Topology, edges: NDArray[np.bool_], distances: NDArray[np.float64]) -> dict[str, float] | None:
    vertices = np.unique(t.edge_vertices[edges])
    if not len(vertices):
        return None
    return {"max": float(distances[vertices].max()), "mean": float(distances[vertices].mean())}
