"""Where the surface strays from the target between its data: found, drawn back ever harder, cut while that helps."""

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.changes import changed_cells
from subdfit.fit.faults import large_enough
from subdfit.fit.places import Places
from subdfit.fit.reverse import Samples, strays
from subdfit.fit.state import FitState
from subdfit.limit.surface import LimitSurface

Faces = NDArray[np.int64]

FEW, FEWEST = 0.01, 10
"""As many faces, as a share and at least, are cut at once because the surface strays there: the farthest first."""
INSISTENCE = 2.0
MOST_INSISTENCE = 1e4
"""Strays that are left are drawn by so many times the weight of the round before, up to the second number."""


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
        self._seen: tuple[LimitSurface, Samples] | None = None
        self._carried = False
        self._cut = 0
        self._cutting_helps = True

    def samples(self, state: FitState) -> Samples:
        """Samples of the surface that stray by half the bound or more; only those of changed cells are found anew."""
        surface, target = state.surface, state.data.target
        if self.bound is None:
            return Samples.none()
        if self._seen is None:
            self._seen, self._carried = (surface, strays(surface, target, self.bound / 2)), False
        elif self._seen[0] is not surface:
            self._seen, self._carried = (surface, self._carried_over(*self._seen, state)), True
        return self._seen[1]

    def _carried_over(self, before: LimitSurface, found: Samples, state: FitState) -> Samples:
        changed = changed_cells(before, state.surface)
        kept = Samples.none() if changed.all() else found[~changed[found.face]]
        return kept.joined(strays(state.surface, state.data.target, (self.bound or np.inf) / 2, changed))

    def worst(self, state: FitState) -> float:
        """How far a sample strays at most, in bounds; where that is within it, with nothing carried over."""
        if self._carried and self._worst(state) <= 1:
            self._seen = None
        return self._worst(state)

    def _worst(self, state: FitState) -> float:
        return float(self.samples(state).gap.max(initial=0.0)) / (self.bound or np.inf)

    def faces(self, state: FitState) -> Faces:
        """Faces whose samples stray beyond the bound, or nearly; the farthest first."""
        found = self.samples(state)
        gap = np.zeros(state.surface.topology.face_count)
        np.maximum.at(gap, Places(state.surface).face[found.face], found.gap)
        order = np.argsort(-gap, kind="stable")
        return order[gap[order] > 0.9 * (self.bound or np.inf)]

    def insist(self, state: FitState, within: bool) -> float:
        """Weight with which to draw samples now: more each time that some stray and the data are `within` tolerance.

        After the most all begins anew.
        """
        if not within:
            self._insistence = max(self._insistence / INSISTENCE, 1.0)
        elif self._worst(state) > 1 and self._insistence < MOST_INSISTENCE:
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
