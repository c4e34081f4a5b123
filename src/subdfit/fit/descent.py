"""Damped steps that move the control points of a part of the surface until they gain little."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.reverse import CurveSamples, Samples
from subdfit.fit.state import FitState
from subdfit.fit.system import System
from subdfit.fit.tangent import TangentSettings, curve_reverse_rows, merit, reverse_rows, tangent_system

DAMPING_RANGE = (1e-4, 1e3)
"""Levenberg damping falls by 3 after a step that is kept and rises by 10 after one that is not, within this range."""
FIRM = 1e-2
"""Damping to begin with where little holds some control vertices: few points, or the faces are large."""
TRIES = 2
"""Most steps tried for each that may be kept."""


@dataclass(frozen=True, eq=False)
class Part:
    """What takes part in some steps.

    Attributes
    ----------
    state : the surface and the points that pull.
    samples, curves : what is drawn to the target between the points.
    free : (n,) bool, the control vertices that may move.
    steps : most steps that are kept.
    gain : the steps end when one leaves more than this share of the energy.
    """

    state: FitState
    samples: Samples
    curves: list[CurveSamples]
    free: NDArray[np.bool_]
    steps: int
    gain: float


class Descent:
    """Steps whose damping is carried from part to part.

    Parameters
    ----------
    weights
        Of the terms of the energy.
    bound
        The error that matters, as a share of the diagonal.
    damping
        Levenberg's, to begin with.
    """

    def __init__(self, weights: TangentSettings, bound: float, damping: float) -> None:
        self.weights = weights
        self.bound = bound
        self.damping = damping

    def moved(self, part: Part, insistence: float = 1.0) -> FitState:
        """The part's state after steps, each kept if it lowers the energy with new footpoints on both sides.

        `insistence` is a factor on the weight of the samples.
        """
        state, samples, curves = part.state, part.samples, part.curves
        energy = merit(state, samples, curves, self.weights, self.bound, insistence)
        system: System | None = None
        kept = 0
        for _ in range(TRIES * part.steps):
            if system is None:
                system = self._system(state, samples, curves, part.free, insistence)
            moved = state.moved(state.surface.control_mesh.points + system.solve(self.damping))
            fresh = samples.renewed(moved.surface, state.data.target)
            left = merit(moved, fresh, curves, self.weights, self.bound, insistence)
            if left >= energy:
                if self.damping >= DAMPING_RANGE[1]:
                    break
                self.damping = min(self.damping * 10, DAMPING_RANGE[1])
                continue
            self.damping = max(self.damping / 3, DAMPING_RANGE[0])
            gain, kept = left / energy, kept + 1
            state, samples, energy, system = moved, fresh, left, None
            if gain > part.gain or kept == part.steps:
                break
        return state

    def _system(
        self,
        state: FitState,
        samples: Samples,
        curves: list[CurveSamples],
        free: NDArray[np.bool_],
        insistence: float,
    ) -> System:
        """The system of one step; the terms that it joins are forgotten, as they take as much memory as it does."""
        pulled = [reverse_rows(state, self.weights, samples, self.bound, insistence)]
        pulled += [curve_reverse_rows(state, self.weights, found) for found in curves]
        return tangent_system(state, self.weights, pulled, free)
