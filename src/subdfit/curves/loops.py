"""Boundary loops as subdivision curves: cut at sharp points, each smooth part fitted, the parts joined at corners."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.curves.fitting import FINE, checked_tolerance, farthest, fit_curve, fit_with, two_sided_error
from subdfit.curves.polyline import Polyline
from subdfit.curves.subdivision_curve import SubdivisionCurve
from subdfit.errors import InputError

Floats = NDArray[np.float64]

POINTS = 2
"""Points of a polyline for a control point, at least: with fewer its own segments are the better curve."""
TURN = 0.8
"""A chain that no curve follows is cut where it turns by so much of the most it does."""


@dataclass(frozen=True)
class FittedLoop:
    """A closed piecewise smooth subdivision curve.

    Attributes
    ----------
    points : (k, 3) float64, the control points round the loop, k >= 3.
    corners : (k,) bool, those that stay: the sharp points.
    limits : (k, 3) float64, where the control points go in the limit.
    error : largest distance between curve and target, either way.
    """

    points: Floats
    corners: NDArray[np.bool_]
    limits: Floats
    error: float


def fit_loop(target: Polyline, tolerance: float, *, least: int = 3) -> FittedLoop:
    """Fit a closed polyline with sharp points (Lavoué et al. 2007, section 4.2.2).

    Parameters
    ----------
    target : closed.
    tolerance : largest distance between curve and target, in the target's unit.
    least : number of control points to have at least, 3 or more.

    Returns
    -------
    FittedLoop
        Begins at the first sharp point, if there is one.

    Raises
    ------
    InputError
        The polyline is open or has no length, or the tolerance is not positive.
    """
    if not target.closed:
        raise InputError("the polyline is open; give a closed one, or fit it with fit_curve")
    tolerance = checked_tolerance(target, tolerance)
    cuts = target.sharp_points()
    if len(cuts) == 0:
        fit = fit_curve(target, tolerance)
        if fit.error <= tolerance:
            return _joined(target, [fit.curve if len(fit.curve.points) >= least else fit_with(target, least).curve])
        cuts = target.sharpest(TURN)
    parts = [piece for part in target.parts(cuts) for piece in _pieces(part, tolerance)]
    # A single part begins and ends at one point: three segments are the least that enclose anything.
    curves = [curve for _, curve in parts]
    if len(parts) == 1 and len(curves[0].points) < 4:
        curves = [fit_with(parts[0][0], 4).curve]
    while sum(curve.length for curve in curves) < least:
        longest = int(np.argmax([part.total / curve.length for (part, _), curve in zip(parts, curves, strict=True)]))
        curves[longest] = fit_with(parts[longest][0], len(curves[longest].points) + 1).curve
    return _joined(target, curves)


def _pieces(part: Polyline, tolerance: float) -> list[tuple[Polyline, SubdivisionCurve]]:
    """An open part and its curve; cut where it turns most while none of few control points meets the tolerance."""
    fit = fit_curve(part, tolerance, most=max(len(part.points) // POINTS, 2))
    if fit.error <= tolerance or len(part.points) == 2:
        return [(part, fit.curve)]
    return [piece for half in part.parts(part.sharpest(TURN)) for piece in _pieces(half, tolerance)]


def _joined(target: Polyline, curves: list[SubdivisionCurve]) -> FittedLoop:
    if curves[0].closed:
        corners = np.zeros(len(curves[0].points), np.bool_)
        return FittedLoop(curves[0].points, corners, curves[0].limit_points(), two_sided_error(target, curves[0]))
    corners = np.concatenate([np.arange(curve.length) == 0 for curve in curves])
    drawn = Polyline(np.concatenate([curve.polyline(FINE)[:-1] for curve in curves]), closed=True)
    return FittedLoop(
        np.concatenate([curve.points[:-1] for curve in curves]),
        corners,
        np.concatenate([curve.limit_points()[:-1] for curve in curves]),
        farthest(target, drawn)[0],
    )
