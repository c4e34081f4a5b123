"""What a fitting method is: settings, and one iteration from state to state. One driver runs them all."""

from typing import Protocol

from subdfit.fit.state import FitState


class Fitter(Protocol):
    """A fitting method; it holds what it must remember between iterations, the state holds everything else.

    Attributes
    ----------
    patience : iterations without gain after which more are of no use.
    """

    patience: int

    def advance(self, state: FitState) -> FitState:
        """One iteration: move the control points, adapting the control mesh first where that is due."""
        ...

    def stray(self, state: FitState) -> float:
        """How far the surface of a state within tolerance lies off the target between the data, in tolerances."""
        ...

    def look_closer(self) -> None:
        """The certificate found the surface farther off than `stray` had: allow less between the data from now on."""
        ...
