"""What a fitting method is: settings, and one iteration from state to state. One driver runs them all."""

from typing import Protocol

from subdfit.fit.state import FitState


class Fitter(Protocol):
    """A fitting method; it holds what it must remember between iterations, the state holds everything else.

    Attributes
    ----------
    two_sided : it also draws a surface that strays back to the target, so that iterating is worth while.
    """

    two_sided: bool

    def advance(self, state: FitState) -> FitState:
        """One iteration: move the control points, adapting the control mesh first where that is due."""
        ...
