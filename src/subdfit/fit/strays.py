"""Where the surface strays from the target between its data: found, drawn back ever harder, cut while that helps."""

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.changes import changed_cells
from subdfit.fit.faults import large_enough
from subdfit.fit.places import Places
from subdfit.fit.reverse import DRAWN, Samples, even_strays, strays
from subdfit.fit.state import FitState
from subdfit.limit.surface import LimitSurface
from subdfit.measure import reverse_segments

Faces = NDArray[np.int64]

FEW, FEWEST = 0.01, 10
"""As many faces, as a share and at least, are cut at once because the surface strays there: the farthest first."""
INSISTENCE = 2.0
MOST_INSISTENCE = 1e4
"""Strays that are left are drawn by so many times the weight of the round before, up to the second number."""
STUBBORN, GAIN = 16.0, 0.98
"""Strays drawn by more than the first number that a round leaves at more than the second share of their distance move
no further: what is missing there is freedom, not weight."""


LESS = 0.95
"""Share of the bound that is left each time that less is allowed."""


class Strays:
    """The strays of a surface that changes in parts.

    Parameters
    ----------
    bound
        How far samples of the surface may lie off the target, as a share of the diagonal; None asks nothing.
    """

    def __init__(self, bound: float | None) -> None:
        self.bound = bound
        self._insistence = 1.0
        self._left = np.inf
        self._seen: tuple[LimitSurface, Samples] | None = None
        self._steadiest: tuple[float, FitState, tuple[LimitSurface, Samples]] | None = None
        self._cut = 0
        self._cutting_helps = True

    def samples(self, state: FitState) -> Samples:
        """Samples of the surface that stray by half the bound or more; only those of changed cells are found anew."""
        surface = state.surface
        if self.bound is None:
            return Samples.none()
        if self._seen is None or self._seen[0] is not surface:
            self._seen = (surface, self._found(state))
        return self._seen[1]

    def allow_less(self) -> None:
        """Hold the surface to a smaller bound: peaks just below the bound were given up that were higher after all."""
        self.bound = LESS * self.bound if self.bound is not None else None
        self._seen = None

    def even(self, state: FitState) -> Samples:
        """Those of even samples that stray as far, without the peaks between them.

        While much is still too far off peaks would pull the hardest, and at tangled sheets to the wrong one.
        """
        return Samples.none() if self.bound is None else even_strays(state, DRAWN * self.bound)

    def _found(self, state: FitState) -> Samples:
        surface, bound = state.surface, self.bound or np.inf
        if self._seen is None or not _sampled_alike(self._seen[0], surface):
            return strays(surface, state.data.target, bound, share=DRAWN)
        before, found = self._seen
        changed = changed_cells(before, surface)
        if changed.all():
            return strays(surface, state.data.target, bound, share=DRAWN)
        return found[~changed[found.face]].joined(strays(surface, state.data.target, bound, changed, share=DRAWN))

    def worst(self, state: FitState) -> float:
        """How far a sample strays at most, in bounds."""
        return float(self.samples(state).gap.max(initial=0.0)) / (self.bound or np.inf)

    def taken_back(self, state: FitState) -> FitState:
        """The state, or once cutting left more strays that one of all given which strayed least."""
        worst = self.worst(state)
        if self._seen and (self._steadiest is None or worst < self._steadiest[0]):
            self._steadiest = (worst, state, self._seen)
        if self._cutting_helps or self._steadiest is None:
            return state
        _, state, self._seen = self._steadiest
        return state

    def faces(self, state: FitState) -> Faces:
        """Faces whose samples stray beyond the bound, the farthest first."""
        found = self.samples(state)
        gap = np.zeros(state.surface.topology.face_count)
        np.maximum.at(gap, Places(state.surface).face[found.face], found.gap)
        order = np.argsort(-gap, kind="stable")
        return order[gap[order] > (self.bound or np.inf)]

    def insist(self, state: FitState, within: bool) -> float:
        """Weight with which to draw samples now: more each time that some stray and the data are `within` tolerance.

        After the most, or where more gains nothing, all begins anew.
        """
        before, self._left = self._left, self.worst(state)
        stuck = self._insistence > STUBBORN and self._left > GAIN * before
        if not within:
            self._insistence = max(self._insistence / INSISTENCE, 1.0)
        elif self._left > 1 and self._insistence < MOST_INSISTENCE and not stuck:
            self._insistence *= INSISTENCE
        else:
            self._insistence, self._cutting_helps = 1.0, True
        return self._insistence

    def to_cut(self, state: FitState, faces: Faces) -> Faces:
        """Those of the straying faces to cut now; none once cutting left more of them, until `insist` begins anew.

        A surface with more freedom where there are no data may crumple, and then strays all the more.
        """
        self._cutting_helps &= not 0 < self._cut < len(faces)
        self._cut = len(faces) if self._cutting_helps else 0
        if not self._cutting_helps:
            return faces[:0]
        return large_enough(state, faces)[: max(FEWEST, int(FEW * state.surface.topology.face_count))]


def _sampled_alike(a: LimitSurface, b: LimitSurface) -> bool:
    return reverse_segments(a.domain) == reverse_segments(b.domain)
