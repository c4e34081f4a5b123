"""Subdivision curves fitted to polylines by the geometric algorithm of Nishiyama, Morioka and Maekawa 2008.

The paper says that its algorithm extends to curves; here it is. No linear system: each control point moves by the
mean error vector of the points over its two segments, weighted by their linear coordinates there (equations 3 and 4);
every five iterations segments where the error is too large are halved.
"""

import numpy as np
from numpy.typing import NDArray

from subdfit.curves.fitting import CurveFit, two_sided_error
from subdfit.curves.polyline import Polyline
from subdfit.curves.subdivision_curve import SubdivisionCurve
from subdfit.mesh.checks import positive_length

Floats = NDArray[np.float64]

INSERTION_PERIOD = 5
"""Control points are inserted once in five iterations (section 5)."""
_DRAWN = 16
"""Points a control segment among which footpoints begin."""


def fit_geometric(
    target: Polyline, curve: SubdivisionCurve, tolerance: float, *, iterations: int = 100, most: int = 200
) -> CurveFit:
    """Move a curve's control points, and insert more, until the target's points are within a tolerance.

    Parameters
    ----------
    target, curve
        The data, and the curve to begin with; the ends of an open curve stay.
    tolerance
        Largest distance of the target's points from the curve, in their unit.
    iterations, most
        How long to go on, and up to how many control points.

    Returns
    -------
    CurveFit
        The last curve.

    Raises
    ------
    InputError
        A tolerance that is not positive.
    """
    tolerance = positive_length(tolerance, "the tolerance of a curve")
    iteration = 0
    for iteration in range(iterations):
        parameters = footpoints(target.points, curve)
        errors = target.points - curve.evaluate(parameters)
        if np.linalg.norm(errors, axis=1).max() <= tolerance:
            break
        if iteration and iteration % INSERTION_PERIOD == 0:
            bad = _segments(curve, parameters)[np.linalg.norm(errors, axis=1) > tolerance]
            curve = inserted(curve, np.unique(bad)) if len(curve.points) < most else curve
        else:
            curve = SubdivisionCurve(curve.points + displacements(curve, parameters, errors), curve.closed)
    return CurveFit(curve, two_sided_error(target, curve), iteration)


def footpoints(points: Floats, curve: SubdivisionCurve) -> Floats:
    """Parameters (k,) of the nearest points of a curve: on its polyline, then one step along the tangent."""
    drawn = Polyline(curve.polyline(_DRAWN), curve.closed)
    arcs, _ = drawn.closest(points)
    parameters = np.interp(arcs, drawn.arc, np.arange(len(drawn.arc)) / _DRAWN)
    tangent = curve.evaluate(parameters, 1)
    ahead = np.einsum("kd,kd->k", points - curve.evaluate(parameters), tangent)
    parameters += ahead / np.maximum(np.einsum("kd,kd->k", tangent, tangent), 1e-300)
    return np.asarray(np.mod(parameters, curve.length) if curve.closed else np.clip(parameters, 0, curve.length))


def displacements(curve: SubdivisionCurve, parameters: Floats, errors: Floats) -> Floats:
    """Displacement of each control point, (n, 3): the mean error by linear coordinates; zero where there is none."""
    n, segment = len(curve.points), _segments(curve, parameters)
    ahead = parameters - segment
    moved, weight = np.zeros_like(curve.points), np.zeros(n)
    for end, share in ((segment, 1 - ahead), ((segment + 1) % n, ahead)):
        np.add.at(moved, end, share[:, None] * errors)
        np.add.at(weight, end, share)
    out = np.divide(moved, weight[:, None], out=np.zeros_like(moved), where=weight[:, None] > 0)
    if not curve.closed:
        out[[0, -1]] = 0.0
    return out


def inserted(curve: SubdivisionCurve, segments: NDArray[np.int64]) -> SubdivisionCurve:
    """Halve some segments by a step of subdivision; a control point moves by it if both of its segments are halved."""
    halved = np.zeros(len(curve.points), np.bool_)
    halved[segments] = True
    both = halved & np.roll(halved, 1)
    fine = curve.refined().points
    old = np.where(both[:, None], fine[0::2], curve.points)
    points = np.insert(old, segments + 1, fine[2 * segments + 1], axis=0)
    return SubdivisionCurve(points, curve.closed)


def _segments(curve: SubdivisionCurve, parameters: Floats) -> NDArray[np.int64]:
    return np.minimum(parameters.astype(np.int64), curve.length - 1)
