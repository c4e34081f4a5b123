"""One driver for all solvers: from data to control points, until a tolerance holds or nothing improves."""

import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subdfit.interpolate.krylov import krylov
from subdfit.interpolate.null_space import NullSpace
from subdfit.interpolate.operator import LimitOperator
from subdfit.interpolate.progressive import Step, chebyshev, over_relaxed, progressive
from subdfit.interpolate.specks import Specks
from subdfit.mesh.topology import Topology

logger = logging.getLogger(__name__)

Floats = NDArray[np.float64]
Status = Literal["within_tolerance", "best_effort", "interrupted"]
Solver = Callable[[LimitOperator, Floats, Floats], Iterator[Step]]

METHODS: dict[str, Solver] = {
    "cg": krylov,
    "chebyshev": chebyshev,
    "over-relaxation": over_relaxed,
    "progressive": progressive,
}
"""Solvers by name: from operator, data and a first iterate they give iterates for ever, each with its error."""

PATIENCE = 100
"""Iterations without a new least error after which there is no hope."""


@dataclass(frozen=True, eq=False)
class Interpolation:
    """Control points whose limit points are the data.

    Attributes
    ----------
    points : (n, 3).
    residuals : at each iteration, from the start on, the largest distance of a limit point from its datum.
    distances : (n,), those distances in the end, computed afresh.
    status : ``within_tolerance``, ``best_effort`` or ``interrupted``.
    null_vectors : how many independent control meshes have the limit 0; where there are any, `points` is the least
        solution, and `residuals` leave out what no control mesh can reach.
    """

    points: Floats
    residuals: tuple[float, ...]
    distances: Floats
    status: Status
    null_vectors: int


def interpolate_points(
    B: LimitOperator, topology: Topology, data: Floats, method: str, tolerance: float, most_iterations: int
) -> Interpolation:
    """Find control points with limit points at the data, to a tolerance that is a length.

    Where B has an eigenvalue below 0, as Catmull-Clark's may beside inner vertices of two faces, all methods but ``cg``
    diverge, and it takes over.

    Parameters
    ----------
    B
        Limit operator of the topology.
    data
        (n, 3), of a size near 1 and centred near 0, that rounding may not matter.
    method
        One of `METHODS`.
    """
    specks = Specks.of(B, topology)
    regular = specks.settled(B)
    null_space = NullSpace.of(regular, topology)
    compact, order = regular.breadth_first()
    reachable = null_space.reachable(specks.solved(data))
    solved = _solve(compact, reachable[order], method, tolerance, most_iterations)
    points = np.empty_like(data)
    points[order] = solved.points
    points = null_space.least(points)
    distances = B.distances(points, data)
    status: Status = "interrupted" if solved.interrupted else "best_effort"
    if distances.max() <= tolerance:
        status = "within_tolerance"
    return Interpolation(points, tuple(solved.residuals), distances, status, null_space.count + specks.null_vectors)


class _Solved(NamedTuple):
    points: Floats
    residuals: list[float]
    interrupted: bool


def _solve(B: LimitOperator, data: Floats, method: str, tolerance: float, most_iterations: int) -> _Solved:
    """Iterate from the data themselves, and again from where rounding ended the iteration, while that helps."""
    residuals: list[float] = []
    points, least = data, np.inf
    while True:
        points, interrupted = _iterate(METHODS[method](B, data, points), residuals, tolerance, most_iterations)
        true = float(B.distances(points, data).max())
        if not interrupted and true > residuals[0] and len(residuals) < most_iterations and method != "cg":
            logger.warning("%s does not converge on this mesh; cg takes over", method)
            method, points = "cg", data
            continue
        if interrupted or true <= tolerance or not true < least / 2 or len(residuals) >= most_iterations:
            return _Solved(points, residuals, interrupted)
        least = true


def _iterate(
    steps: Iterator[Step], residuals: list[float], tolerance: float, most_iterations: int
) -> tuple[Floats, bool]:
    """Take steps until one is within tolerance, too many, or none has been better for long; Ctrl-C ends them too."""
    points, error = next(steps)
    residuals.append(error)
    best, since = error, 0
    try:
        while error > tolerance and len(residuals) < most_iterations and since < PATIENCE:
            following = next(steps, None)
            if following is None:
                break
            points, error = following
            residuals.append(error)
            best, since = (error, 0) if error < best else (best, since + 1)
    except KeyboardInterrupt:
        return points, True
    return points, False
