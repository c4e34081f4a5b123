"""Subdivision curves fitted to polylines with the fewest control points that meet a tolerance.

The curve is moved by minimising second-order models of the squared distance (Pottmann and Leopoldseder 2003, the
active B-spline curve) from the target at the footpoints of samples of the curve. How many control points, and where
they begin, comes from the target's curvature: a cubic spline errs by the fourth power of the spacing times the fourth
derivative, so that control points lie densest where the target bends most.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.curves.polyline import Polyline
from subdfit.curves.squared_distance import tangential_weights
from subdfit.curves.subdivision_curve import SubdivisionCurve, curve_weights
from subdfit.errors import InputError
from subdfit.mesh.checks import positive_length

Floats = NDArray[np.float64]

_SAMPLES = 12
"""Samples of the curve a control segment, and the fewest of a curve."""
_FEWEST_SAMPLES = 48
_ROUNDS = 15
"""Rounds of minimisation of a curve at most."""
_SETTLED, _GAVE_UP = 1e-3, 2e-2
"""A fit has settled when its error changes by less than this share in a round; more where it will be moved again."""
_EVENNESS = 0.05
"""Share of control points that are spread evenly along the arc, whatever the curvature."""
_PLACEMENTS = ((0.5, 0.0), (0.25, 0.0), (0.5, 0.3), (0.25, 0.6))
"""Power of the curvature, and share drawn to the ends, of the placements that are tried."""
_MANY = 12
"""Control points from which on others are placed where the curve is farthest off, beginning with half as many."""
_VAIN = 8
"""Control points in a row that bring the curve no nearer, before giving up."""
FINE = 16
"""Samples of the curve a control segment where its error is measured."""
_IDLE = 4
"""Control points whose removal is tried at the end, of a curve that will be moved again."""
_SPARE = 3
"""Control points more with which the removal of all that can go begins as well."""
_END = 0.5
"""What counts as an end, in even segments."""
_STIFFNESS = 1e-7
"""Weight of second differences of control points, which only decides where nothing else does."""


@dataclass(frozen=True)
class _Effort:
    """How long a fit goes on: until its error is `enough`, or changes by less than a share."""

    signed: bool = False
    enough: float = 0.0
    settled: float = _SETTLED


@dataclass(frozen=True)
class CurveFit:
    """A subdivision curve fitted to a polyline.

    Attributes
    ----------
    curve : the subdivision curve; an open one begins and ends at the polyline's ends.
    error : largest distance of the polyline's points from the curve, and of samples of the curve from the polyline.
    iterations : rounds of minimisation after which it was nearest.
    """

    curve: SubdivisionCurve
    error: float
    iterations: int


def fit_curve(
    target: Polyline, tolerance: float, *, most: int = 200, signed: bool = False, quick: bool = False
) -> CurveFit:
    """Fit with the fewest control points that meet a tolerance.

    Parameters
    ----------
    target : a smooth chain; cut it at its sharp points first.
    tolerance : largest distance between the two curves, in the target's unit.
    most : number of control points at which to stop trying; never more than the target's points.
    signed : use signed radii of curvature in the model of the squared distance (see `tangential_weights`).
    quick
        Take the first that meets the tolerance and improve it no further, and give up sooner one that does not: for
        curves that will be moved again.

    Returns
    -------
    CurveFit
        One that meets the tolerance, by doubling and bisection from a straight line or a triangle, and, where that
        takes many control points, by growing where it is farthest off; without the control points that can go. Where
        `most` control points do not meet it, the best.

    Raises
    ------
    InputError
        The tolerance is not positive, or the chain has no length.
    """
    tolerance = checked_tolerance(target, tolerance)
    how = _Effort(signed, tolerance, _GAVE_UP) if quick else _Effort(signed)
    low, high = 1 + target.closed, 2 + target.closed
    most = max(min(most, len(target.points)), high)
    best = found = _placed(target, high, how)
    while found.error > tolerance and high < most:
        low, high = high, min(2 * high, most)
        found = _placed(target, high, how)
        best = min(best, found, key=lambda fit: fit.error)
    if found.error > tolerance:
        return best
    while high - low > 1:
        middle = (low + high) // 2
        tried = _placed(target, middle, how)
        low, high, found = (low, middle, tried) if tried.error <= tolerance else (middle, high, found)
    if quick:
        return _without_idle(target, found, tolerance, how)
    if high > _MANY:
        found = _grown(target, high - 1, tolerance, how) or found
    counts = range(len(found.curve.points) + 1, most + 1)[:_SPARE]
    begins = [found, *(_placed(target, count, how) for count in counts)]
    fits = [_without_knots(target, fit, tolerance, how) for fit in begins if fit.error <= tolerance]
    return min(fits, key=lambda fit: len(fit.curve.points))


def checked_tolerance(target: Polyline, tolerance: float) -> float:
    """The tolerance, where a chain can be fitted to it; else raises InputError."""
    if not target.total > 0:
        raise InputError("all points of the chain coincide; give a chain of some length")
    return positive_length(tolerance, "the tolerance of a curve")


def _grown(target: Polyline, most: int, tolerance: float, how: _Effort) -> CurveFit | None:
    """A curve that gets control points one by one where it is farthest off; None where `most` do not do.

    Where the curvature that is seen tells little of the curvature that is there, it needs fewer.
    """
    fit = best = _placed(target, _MANY // 2, how)
    vain = 0
    while fit.error > tolerance and vain < _VAIN and len(fit.curve.points) < most:
        fit = _minimised(target, _with_one_more(target, fit.curve), how)
        vain = 0 if fit.error < best.error else vain + 1
        best = min(best, fit, key=lambda one: one.error)
    return fit if fit.error <= tolerance else None


def _with_one_more(target: Polyline, curve: SubdivisionCurve) -> SubdivisionCurve:
    """The curve with a control point in the middle of the two between which it is farthest from the target."""
    _, at = farthest(target, Polyline(curve.polyline(FINE), curve.closed))
    before = min(at // FINE, curve.length - 1)
    after = (before + 1) % len(curve.points)
    middle = (curve.points[before] + curve.points[after]) / 2
    return SubdivisionCurve(np.insert(curve.points, before + 1, middle, axis=0), curve.closed)


def _without_idle(target: Polyline, fit: CurveFit, tolerance: float, how: _Effort) -> CurveFit:
    """Take out control points near the middle of their neighbours while the tolerance holds."""
    points, closed = fit.curve.points, fit.curve.closed
    if len(points) <= 2 + closed:
        return fit
    off = np.linalg.norm(points - (np.roll(points, 1, axis=0) + np.roll(points, -1, axis=0)) / 2, axis=1)
    inner = np.arange(len(points)) if closed else np.arange(1, len(points) - 1)
    for k in inner[np.argsort(off[inner], kind="stable")][:_IDLE]:
        fewer = _minimised(target, SubdivisionCurve(np.delete(points, k, axis=0), closed), how)
        if fewer.error <= tolerance:
            return _without_idle(target, fewer, tolerance, how)
    return fit


def fit_with(target: Polyline, count: int, *, signed: bool = False) -> CurveFit:
    """Fit with a given number of control points: the best of a few placements by the target's curvature."""
    return _placed(target, count, _Effort(signed))


def _placed(target: Polyline, count: int, how: _Effort) -> CurveFit:
    found: list[CurveFit] = []
    for power, ends in _PLACEMENTS[:2] if target.closed else _PLACEMENTS:
        arcs = placed_by_curvature(target, count, power, ends)
        found.append(_minimised(target, SubdivisionCurve(target.at(arcs), target.closed), how))
        if count <= 2 + target.closed or found[-1].error <= how.enough:
            break
    return min(found, key=lambda fit: fit.error)


def placed_by_curvature(target: Polyline, count: int, power: float = 0.5, ends: float = 0.0) -> Floats:
    """Arc lengths (count,) at which control points begin: equal shares of the integral of a power of the curvature.

    Parameters
    ----------
    target, count : the chain, and the number of control points.
    power
        A spline of spacing h on a curve of curvature k is off by about ``k (k h)^2 h`` over an arc and by ``k h^2``
        where the curvature jumps: evenly so when h goes with a root of 1 / k.
    ends
        Share of the control points that is drawn to the ends. The second derivative of an open subdivision curve is
        zero there (equation 3), and short segments are needed where the target's is not.
    """
    fine = np.linspace(0, target.total, 400)
    bend, _ = target.curvature(fine, target.total / 20)
    density = np.linalg.norm(bend, axis=1) ** power
    density += _EVENNESS * density.mean() + 1e-12 / target.total
    near = np.minimum(fine, target.total - fine) < _END * target.total / count
    density[near] += ends * density.sum() / max(near.sum(), 1)
    share = np.concatenate([[0], np.cumsum((density[1:] + density[:-1]) / 2)])
    steps = np.arange(count) / (count if target.closed else count - 1)
    return np.asarray(np.interp(steps * share[-1], share, fine))


def minimise(target: Polyline, curve: SubdivisionCurve, *, signed: bool = False) -> CurveFit:
    """Move a curve's control points until its distance from the target settles; ends of an open curve stay.

    Each round takes footpoints on the target of samples of the curve, and minimises the sum of second-order models of
    the squared distance there: linear least squares in the control points. The best round is kept.
    """
    return _minimised(target, curve, _Effort(signed))


def _minimised(target: Polyline, curve: SubdivisionCurve, how: _Effort) -> CurveFit:
    samples = max(_SAMPLES * curve.length, _FEWEST_SAMPLES)
    parameters = np.arange(samples) * curve.length / samples
    W = curve_weights(parameters, len(curve.points), curve.closed)
    window = max(target.total / 20, 3 * float(np.median(target.lengths)))
    best = CurveFit(curve, two_sided_error(target, curve), 0)
    previous = best.error
    for iteration in range(1, _ROUNDS + 1):
        curve = _step(target, curve, W, window, how.signed)
        error = two_sided_error(target, curve)
        if error < best.error:
            best = CurveFit(curve, error, iteration)
        if error <= how.enough or abs(previous - error) <= how.settled * error:
            break
        previous = error
    return best


def _step(target: Polyline, curve: SubdivisionCurve, W: Floats, window: float, signed: bool) -> SubdivisionCurve:
    at = W @ curve.points
    arcs, distances = target.closest(at)
    foot = target.at(arcs)
    bend, tangent = target.curvature(arcs, window)
    curvature = np.linalg.norm(bend, axis=1)
    radius = np.divide(1.0, curvature, out=np.full(len(curvature), np.inf), where=curvature > 0)
    side = np.sign(np.sum((at - foot) * bend, axis=1))
    along = tangential_weights(distances, np.where(side == 0, -1.0, side) * radius, signed=signed)
    # Squared distance: all of the displacement across the tangent, and so much of that along it.
    metric = np.eye(3) - (1 - along)[:, None, None] * tangent[:, :, None] * tangent[:, None, :]
    n = len(curve.points)
    free = np.arange(n) if curve.closed else np.arange(1, n - 1)
    if len(free) == 0:
        return curve
    A = _stiffness(n, curve.closed, float(len(W)))
    for i in range(3):
        for j in range(3):
            A[:, i, :, j] += W.T @ (metric[:, i, j, None] * W)
    right = W.T @ np.einsum("kij,kj->ki", metric, foot)
    right -= np.einsum("aibj,bj->ai", np.delete(A, free, axis=2), np.delete(curve.points, free, axis=0))
    system = A[free][:, :, free].reshape(3 * len(free), -1)
    points = curve.points.copy()
    points[free] = np.linalg.solve(system, right[free].ravel()).reshape(-1, 3)
    return SubdivisionCurve(points, curve.closed)


def _stiffness(count: int, closed: bool, samples: float) -> Floats:
    """Quadratic form of the second differences of control points, (n, 3, n, 3)."""
    D = np.eye(count) - (np.roll(np.eye(count), 1, axis=1) + np.roll(np.eye(count), -1, axis=1)) / 2
    if not closed:
        D = D[1:-1]
    form = _STIFFNESS * samples * (D.T @ D + 1e-3 * np.eye(count))
    return np.asarray(np.einsum("ab,ij->aibj", form, np.eye(3)))


def two_sided_error(target: Polyline, curve: SubdivisionCurve) -> float:
    """Largest distance of the target's points from the curve, and of fine samples of the curve from the target."""
    return farthest(target, Polyline(curve.polyline(FINE), curve.closed))[0]


def farthest(target: Polyline, drawn: Polyline) -> tuple[float, int]:
    """Largest distance of the points of two chains from the other chain, and the drawn one's segment or point there."""
    arcs, there = drawn.closest(target.points)
    _, back = target.closest(drawn.points)
    if there.max() > back.max():
        return float(there.max()), int(np.searchsorted(np.cumsum(drawn.lengths), arcs[np.argmax(there)]))
    return float(back.max()), int(np.argmax(back))


def knots_removed(target: Polyline, tolerance: float, *, begin: int) -> CurveFit:
    """Baseline: remove the control point whose loss hurts least, again and again while the tolerance holds.

    It begins with `begin` control points or, where they do not suffice, with the fewest above that do. After each
    removal the rest is fitted again. It tries every control point in every round, and takes far longer than
    `fit_curve`.

    Raises
    ------
    InputError
        The tolerance is not positive, the chain has no length, or there are too few control points to begin with.
    """
    tolerance, least = checked_tolerance(target, tolerance), 2 + target.closed
    if begin < least:
        raise InputError(f"knot removal begins with {begin} control points; give {least} or more")
    best = fit_with(target, begin)
    while best.error > tolerance and begin < len(target.points):
        begin += 1
        best = fit_with(target, begin)
    return _without_knots(target, best, tolerance, _Effort())


def _without_knots(target: Polyline, fit: CurveFit, tolerance: float, how: _Effort) -> CurveFit:
    """Take out the control point whose loss hurts least, again and again while the tolerance holds."""
    while len(fit.curve.points) > 2 + target.closed:
        points = fit.curve.points
        removable = range(len(points)) if target.closed else range(1, len(points) - 1)
        fewer = [SubdivisionCurve(np.delete(points, k, axis=0), target.closed) for k in removable]
        found = min((_minimised(target, curve, how) for curve in fewer), key=lambda fit: fit.error)
        if found.error > tolerance:
            break
        fit = found
    return fit
