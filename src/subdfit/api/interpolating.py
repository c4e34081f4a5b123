"""`subdfit.interpolate`: the control mesh whose limit surface passes through every vertex of a given mesh."""

import logging
import time
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from subdfit.api.cages import control_mesh_of
from subdfit.api.components import largest_components
from subdfit.api.creases import with_creases
from subdfit.api.fitting import elapsed
from subdfit.api.interpolation_result import InterpolationResult
from subdfit.api.sources import MeshSource
from subdfit.api.targets import Preparation, check_count, stages
from subdfit.api.workers import workers
from subdfit.compiled import compile_clock
from subdfit.errors import InputError
from subdfit.interpolate import (
    METHODS,
    Fair,
    Interpolation,
    LimitOperator,
    Status,
    fair_interpolation,
    interpolate_points,
)
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.schemes import SCHEMES, scheme_named
from subdfit.target.frame import Frame
from subdfit.wording import counted

logger = logging.getLogger(__name__)

DEFAULT_TOLERANCE = 1e-12
MOST_ITERATIONS = 10_000


def interpolate(
    mesh: ControlMesh | MeshSource,
    *,
    scheme: str | None = None,
    mask: Literal["original", "averaging"] = "original",
    method: str = "cg",
    fair: bool = False,
    creases: Literal["auto", "none"] | float = "auto",
    keep_components: int | None = None,
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
    mask
        ``original``, or ``averaging`` for the variant of Doo and Sabin's scheme that Cheng et al. use.
    method
        ``cg`` solves corners, then curves, then the rest by conjugate gradients (by BiCGStab where no diagonal makes
        the system symmetric); ``progressive`` is the iteration of Cheng et al.; ``over-relaxation`` and ``chebyshev``
        are that one with better factors. Where an iteration diverges a warning says so, and ``cg`` takes over.
    fair
        Refine once, and of the surfaces through all vertices take the one of least thin-plate energy (Halstead, Kass
        and DeRose 1993). It has about four times the control vertices, and fewer ripples.
    creases
        ``auto`` takes the creases that the mesh tags, else edges that are surely sharp; ``none``; or an angle in
        degrees above which an edge is a crease. Boundaries and creases are interpolated by their own curves.
    keep_components
        Interpolate so many of the largest components; vertices of the others are left out.
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
    asked = _Asked(method, fair, tolerance, most_iterations)
    how = Preparation(creases, keep_components=keep_components)
    begun, compiled = time.perf_counter(), compile_clock.seconds
    watch = _Watch()
    with workers(threads):
        watch.begin("read", "reading")
        cage = largest_components(_with_mask(control_mesh_of(mesh, scheme), mask), how.keep_components)
        given = with_creases(cage, how.creases)
        frame = _frame(given.points)
        data = given.with_points(frame.inside(given.points))
        found, smoothed = _solved(data, asked, watch)
    control = smoothed.control_mesh if smoothed else data.with_points(found.points)
    settings = {"mask": mask, "fair": fair, "creases": how.creases, "keep_components": keep_components}
    return InterpolationResult(
        control_mesh=control.with_points(frame.outside(control.points)),
        given=given,
        method=method,
        status=found.status,
        residuals=found.residuals,
        distances=found.distances,
        null_vectors=found.null_vectors,
        energy=(smoothed.before, smoothed.after) if smoothed else None,
        diagonal=frame.diagonal,
        settings=settings | {"tolerance": tolerance, "threads": threads},
        seconds=watch.seconds | elapsed(begun, compiled),
        unit=unit,
    )


@dataclass(frozen=True)
class _Asked:
    """How to interpolate; the fields are arguments of `interpolate`."""

    method: str
    fair: bool
    tolerance: float
    most_iterations: int

    def __post_init__(self) -> None:
        """Raise InputError for options that cannot be, before any work is done."""
        if self.method not in METHODS:
            raise InputError(f"unknown method '{self.method}'; choose one of {', '.join(METHODS)}")
        share = self.tolerance
        if isinstance(share, bool) or not isinstance(share, int | float) or not 0 < share < 1:
            raise InputError(f"tolerance is {share!r}; give a share of the diagonal between 0 and 1, such as 1e-10")
        check_count(self.most_iterations, "most_iterations", 1)


def _solved(data: ControlMesh, asked: _Asked, watch: "_Watch") -> tuple[Interpolation, Fair | None]:
    """The interpolation of a normalised mesh, and the fair one where that is asked."""
    rules = scheme_named(data.scheme or "loop")
    rules.validate(data.topology)
    watch.begin("operator", "making the limit operator")
    operator = LimitOperator.of(rules.limit_rows(data.topology))
    watch.begin("solve", "solving")
    found = interpolate_points(
        operator, data.topology, data.points, asked.method, asked.tolerance, asked.most_iterations
    )
    smoothed = None
    if asked.fair:
        watch.begin("fair", "making it fair")
        smoothed = fair_interpolation(rules, data, found.points)
        found = _of_fair(found, smoothed, asked.tolerance)
    watch.end()
    _warn(found, asked.fair)
    return found, smoothed


def _of_fair(plain: Interpolation, fair: Fair, tolerance: float) -> Interpolation:
    """The plain interpolation's history, ended by the fair one's errors."""
    largest = float(fair.distances.max())
    status: Status = "within_tolerance" if largest <= tolerance else plain.status
    return replace(plain, residuals=(*plain.residuals, largest), distances=fair.distances, status=status)


def _warn(found: Interpolation, fair: bool) -> None:
    """Say that the limit operator is singular, and what is given therefore."""
    if found.null_vectors:
        given = "the fair surface" if fair else "of the control meshes that come nearest the least"
        more = "" if fair or found.status == "within_tolerance" else "; the option fair meets every vertex"
        logger.warning(
            "this scheme cannot move all vertices of this mesh apart (%s the limit 0); "
            "%s is given, its largest relative error is %.2g%s",
            counted(found.null_vectors, "control mesh has", "control meshes have"),
            given,
            found.distances.max(),
            more,
        )


class _Watch:
    """Seconds by stage, each stage told to the user as it begins."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._running = ""
        self._since = 0.0

    def begin(self, stage: str, text: str) -> None:
        """Begin a stage, which ends the one before."""
        self.end()
        stages.info(text)
        self._running, self._since = stage, time.perf_counter()

    def end(self) -> None:
        """End the running stage."""
        if self._running:
            self.seconds[self._running] = time.perf_counter() - self._since
        self._running = ""


def _with_mask(mesh: ControlMesh, mask: str) -> ControlMesh:
    """The mesh, for the variant of its scheme that has another mask."""
    variant = f"{str(mesh.scheme).removesuffix(f'-{mask}')}-{mask}"
    if mask == "original":
        return mesh
    if variant not in SCHEMES:
        raise InputError(f"{mesh.scheme} has no mask '{mask}'; leave the mask out, or choose a scheme that has")
    return replace(mesh, scheme=variant)


def _frame(points: NDArray[np.float64]) -> Frame:
    """The normalised frame; points that all coincide keep their unit."""
    frame = Frame.of(points)
    return frame if frame.diagonal > 0 else replace(frame, diagonal=1.0)
