"""`subdfit.fit`: from whatever the caller has to a certified control mesh."""

import logging
import math
import time
from collections.abc import Callable
from typing import Any, Literal

from subdfit.api.lengths import Length, parse_bytes, parse_length, parse_share, share_of, show_bytes
from subdfit.api.memory import check_job, vertices_within
from subdfit.api.result import FitResult
from subdfit.api.sources import MeshSource
from subdfit.api.targets import Preparation, Prepared, check_count, joined, prepare, stages
from subdfit.api.workers import workers
from subdfit.compiled import compile_clock
from subdfit.errors import InputError
from subdfit.fit import METHODS, FitSettings, Progress, fit_target
from subdfit.fit.lavoue import require_lavoue
from subdfit.initial.start import LEAST_SHARE
from subdfit.measure import Tolerance
from subdfit.schemes import scheme_named
from subdfit.wording import counted

logger = logging.getLogger(__name__)

DEFAULT_MAX_ERROR = "0.1%"

CLOUD_SHARE = 0.005
"""Share of a cloud's points that may be left out where nothing else is said; of a mesh's none."""


def fit(
    target: MeshSource,
    *,
    scheme: str = "loop",
    method: str = "auto",
    max_error: float | str | None = None,
    rms_error: float | str | None = None,
    mean_error: float | str | None = None,
    control_vertices: int | None = None,
    max_control_vertices: int | None = None,
    creases: Literal["auto", "none"] | float = "auto",
    boundary: Literal["fit", "fixed"] = "fit",
    over_relaxation: float = 1.0,
    nesterov: bool = False,
    boundary_step: bool = True,
    thin: bool = False,
    repair: bool = False,
    keep_components: int | None = None,
    fill_holes: int | None = None,
    robust: float | str | None = None,
    progress: Callable[[Progress], None] | None = None,
    unit: str | None = None,
    seed: int = 0,
    threads: int | None = None,
    memory: int | str | None = None,
) -> FitResult:
    """Fit a control mesh whose limit surface lies within a tolerance of the target.

    A cloud of points is joined to a mesh first (see `subdfit.reconstruct`), which serves to begin with and as a guide
    between the points; the points are the data, and the reverse side is held to the mesh.

    Parameters
    ----------
    target
        A path, ``(vertices, faces)`` arrays, an array of points, a trimesh or a PyVista object, `MeshData` or a
        `ControlMesh`. Polygons are cut into triangles.
    scheme
        Subdivision scheme.
    method
        ``tangent`` (tangent distances), ``geometric`` (Nishiyama et al. 2008) or ``lavoue`` (Lavoué et al. 2007: for
        machined parts, whose faces and edges make the control mesh; schemes quad-triangle and catmull-clark). ``auto``
        is the best of them: ``lavoue`` for parts with many sharp edges, where that gives a certified fit, else
        ``tangent``.
    max_error, rms_error, mean_error
        Tolerances, all of which must hold: a number is a length in the target's unit, a string such as ``"0.05%"`` a
        share of its diagonal. Where none is given, `max_error` is 0.1 %.
    control_vertices
        Vertices to start from; None chooses from the tolerance. Not for ``lavoue``.
    max_control_vertices
        Budget, at which the best is returned; None is as many as the target has points.
    creases
        ``auto`` takes the creases that the file tags, else edges that are surely sharp; ``none``; or an angle in
        degrees above which an edge is a crease.
    boundary
        ``fit`` moves boundary control vertices by boundary data; ``fixed`` first of all, to hold them then.
    over_relaxation, nesterov, boundary_step
        Of the method ``geometric``: a factor on its displacements, above 0 and below 2; Nesterov's momentum; and our
        step for boundaries, without which boundary data pull as all others do. The paper has 1, no and no.
    thin
        In the end remove control vertices and merge faces while the tolerance holds on both sides: fewer by a sixth to
        a half, in several times the time. ``lavoue`` does so in any case.
    repair
        Cut apart edges with more than two faces and surfaces that cannot be oriented, instead of refusing them.
    keep_components
        Keep so many of the largest components; of a cloud, those of the surface through its points, and the points near
        them.
    fill_holes
        Close holes of at most so many edges; of a cloud, those of the surface through its points.
    robust
        Share of the data points that may be left out as outliers, such as ``"0.5%"``: the worst of those beyond the
        largest error asked (beyond four standard deviations where none is); the result lists them. None is 0.5 % for
        clouds, and 0 for meshes.
    progress
        Called after every iteration with a `Progress`, whose control mesh is usable as it is.
    unit
        The unit's name, for messages.
    seed
        Of random numbers; today's methods draw none.
    threads
        Threads to use; None takes one a core. The result does not depend on it.
    memory
        Bytes, or a string such as ``"2G"``: what would need more is refused at once, with an estimate, and the budget
        of control vertices is lowered to what the rest of the memory allows, which is told.

    Returns
    -------
    FitResult
        Whether the tolerance was reached is in its `status`. Ctrl-C returns the best so far as ``interrupted``.

    Raises
    ------
    InputError
        The target or an option cannot be used; the text says why, and what to do.
    KeyboardInterrupt
        Ctrl-C before there was a first control mesh.

    Examples
    --------
    >>> result = subdfit.fit("bunny.ply", max_error="0.05%")  # doctest: +SKIP
    >>> subdfit.write("bunny_cage.obj", result.control_mesh)  # doctest: +SKIP
    """
    lengths = tolerances(max_error, rms_error, mean_error)
    if not any(lengths.values()):
        lengths["max"] = parse_length(DEFAULT_MAX_ERROR, "max_error")
    share = parse_share(robust, "robust")
    how = Preparation(creases, repair, keep_components, fill_holes, parse_bytes(memory))
    _check(scheme, method, boundary, control_vertices, max_control_vertices, seed)
    _check_relaxation(over_relaxation)
    begun, compiled = time.perf_counter(), compile_clock.seconds
    with workers(threads):
        ready = prepare(target, how)
        budget = _budget(ready, how.memory, scheme, control_vertices, max_control_vertices)
        ready = joined(ready, how)
        _tell_of_too_many(control_vertices, ready)
        stages.info("first control mesh")
        settings = FitSettings(
            scheme=scheme,
            method=method,
            tolerance=shares(lengths, ready.target.diagonal),
            control_vertices=control_vertices,
            max_control_vertices=budget,
            robust=CLOUD_SHARE * ready.target.cloud if share is None else share,
            fixed_boundary=boundary == "fixed",
            over_relaxation=over_relaxation,
            nesterov=nesterov,
            boundary_step=boundary_step,
            thin=thin,
        )
        found = fit_target(ready.target, settings, progress, unit)
    seconds = ready.seconds | found.seconds | elapsed(begun, compiled)
    asked: dict[str, Any] = {
        "creases": how.creases,
        "boundary": boundary,
        "repair": repair,
        "keep_components": keep_components,
        "fill_holes": fill_holes,
        "seed": seed,
        "threads": threads,
        "memory": how.memory,
    }
    return FitResult.of(found, ready.target, asked, seconds)


def tolerances(
    max_error: float | str | None, rms_error: float | str | None, mean_error: float | str | None
) -> dict[str, Length | None]:
    """Read the three tolerances; raises InputError."""
    given = {"max": max_error, "rms": rms_error, "mean": mean_error}
    return {key: parse_length(value, f"{key}_error") for key, value in given.items()}


def shares(lengths: dict[str, Length | None], diagonal: float) -> Tolerance:
    """Tolerances as shares of a diagonal; raises InputError."""
    return Tolerance(**{key: share_of(length, f"{key}_error", diagonal) for key, length in lengths.items()})


def elapsed(begun: float, compiled: float) -> dict[str, float]:
    """Seconds since a start, compiling apart."""
    compiling = compile_clock.seconds - compiled
    return {"compile": compiling, "total": time.perf_counter() - begun - compiling}


def _budget(ready: Prepared, limit: int | None, scheme: str, start: int | None, asked: int | None) -> int | None:
    """The most control vertices: what was asked, or fewer where the memory allows no more, which is told.

    Raises
    ------
    InputError
        Not even the first control mesh would fit into the memory, of which None stands for any amount.
    """
    if limit is None:
        return asked
    points, corners = len(ready.target.points), ready.target.triangles.size
    check_job(points, corners, limit, ready.name, start or math.ceil(LEAST_SHARE * points), scheme)
    allowed = vertices_within(limit, points, corners, scheme)
    if allowed >= (asked or points):
        return asked
    most = counted(allowed, "control vertex")
    logger.warning("%s: %s of memory allow %s, and the fit takes no more", ready.name, show_bytes(limit), most)
    return allowed


def _check(
    scheme: str, method: str, boundary: str, control_vertices: int | None, budget: int | None, seed: int
) -> None:
    """Raise InputError for options that cannot be, before any work is done."""
    scheme_named(scheme)
    if method not in METHODS:
        raise InputError(f"unknown method '{method}'; choose one of {', '.join(METHODS)}")
    if method == "lavoue":
        require_lavoue(scheme, control_vertices)
    if boundary not in ("fit", "fixed"):
        raise InputError(f"boundary is '{boundary}'; choose fit or fixed")
    check_count(control_vertices, "control_vertices", 4)
    check_count(budget, "max_control_vertices", 4)
    check_count(seed, "seed", 0)
    if control_vertices and budget and control_vertices > budget:
        raise InputError(
            f"control_vertices is {control_vertices} and max_control_vertices {budget}; start with no more than that"
        )


def _tell_of_too_many(control_vertices: int | None, ready: Prepared) -> None:
    """Warn that a fit does not start from more control vertices than there are data."""
    count = len(ready.target.used)
    if control_vertices is not None and control_vertices > count:
        logger.warning(
            "%s: control_vertices is %d, but there are only %s to start from",
            ready.name,
            control_vertices,
            counted(count, "data point"),
        )


def _check_relaxation(factor: float) -> None:
    """Raise InputError for a factor with which no iteration converges."""
    if not 0 < factor < 2:
        raise InputError(f"over_relaxation is {factor}; choose a factor above 0 and below 2, 1 being the paper's")
