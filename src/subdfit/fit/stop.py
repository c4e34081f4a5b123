"""When a fit may stop: the tolerance, for surface and curves."""

from subdfit.fit.state import FitState
from subdfit.measure import Tolerance

CURVE_FACTOR = 1.0
"""Points on curves may lie this many tolerances from the fitted curve."""


def surface_within(state: FitState, tolerance: Tolerance) -> bool:
    """Whether the state's errors hold all that is asked, whatever its curves do."""
    errors = state.errors
    return tolerance.met(max(errors.max, errors.excess), errors.rms, errors.mean)


def within(state: FitState, tolerance: Tolerance) -> bool:
    """Whether the state's errors, curves too, hold all that is asked."""
    if not surface_within(state, tolerance):
        return False
    return tolerance.max is None or state.curve_distances.max(initial=0.0) <= CURVE_FACTOR * tolerance.max


def badness(state: FitState, tolerance: Tolerance) -> float:
    """Largest ratio of an error to what is asked: at most 1 within tolerance; orders best states."""
    errors = state.errors
    asked = (
        (tolerance.max, max(errors.max, errors.excess)),
        (tolerance.rms, errors.rms),
        (tolerance.mean, errors.mean),
    )
    return max((value / bound for bound, value in asked if bound), default=errors.max)


def error_between_data(tolerance: Tolerance) -> float:
    """The scale of errors between the data, as a share of the diagonal: only the maximum counts, where one is asked."""
    return tolerance.max or error_that_matters(tolerance)


def error_that_matters(tolerance: Tolerance) -> float:
    """The scale of errors, as a share of the diagonal: the maximum asked, or three times the mean or rms."""
    bounds = [tolerance.max] + [3 * bound for bound in (tolerance.rms, tolerance.mean) if bound is not None]
    return min((bound for bound in bounds if bound is not None), default=1e-3)
