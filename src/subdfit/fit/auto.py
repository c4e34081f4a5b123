"""The method ``auto``: damped tangent-distance steps, and splits of the faces whose maximum is too large."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.adapt import refined
from subdfit.fit.faults import Faults, all_sides, curve_sides, cutting_sides, large_enough
from subdfit.fit.places import Places
from subdfit.fit.reverse import Strays, strays
from subdfit.fit.settings import FitSettings
from subdfit.fit.state import FitState
from subdfit.fit.stop import CURVE_FACTOR, badness, error_that_matters
from subdfit.fit.system import Rows
from subdfit.fit.tangent import TangentSettings, merit, pull, reverse_rows, sparse_samples, tangent_step

STEPS = 3
"""Steps between adaptations."""
CAP = 0.25
"""Most faces, as a share, that one adaptation refines for their error."""
FEW = 0.01
"""When fewer faces than this share are too far off, they are split on all sides and no edge is flipped."""
LATE_DAMPING = 1e-2
"""Least damping after a late split, which has few points to hold it."""
NEARLY = 1.5
"""Errors within this many tolerances are nearly there: the reverse side is looked at."""
DAMPING_RANGE = (1e-6, 1.0)
"""Levenberg damping falls by 3 after a step that is kept and rises by 10 after one that is not, within this range."""
GIVE = 1.05
"""A step is kept if it raises the error by no more than this factor; the driver keeps the best state."""
STRAY_WEIGHT = 10.0
"""Weight of a sample of the surface that strayed, against a data point."""


class Auto:
    """Tangent-distance minimisation with Levenberg damping; adapts every few steps."""

    two_sided = True

    def __init__(self, settings: FitSettings, weights: TangentSettings | None = None) -> None:
        self.settings = settings
        self.weights = weights or TangentSettings()
        self._damping = self.weights.damping
        self._steps = 0
        self._watched: Strays | None = None
        self._sampled: tuple[FitState, Strays] | None = None

    def advance(self, state: FitState) -> FitState:
        """One step, kept if the true error falls; every `STEPS` steps the control mesh is adapted first."""
        if self._steps >= STEPS:
            self._steps = 0
            state = self.adapt(state)
        self._steps += 1
        bound = error_that_matters(self.settings.tolerance)
        samples = self._samples(state)
        rows = [*self._sample_rows(state, samples, bound), *self._stray_rows(state)]
        points = tangent_step(state, self.weights, self._damping, rows, self.settings.fixed_boundary)
        moved = state.moved(points)
        low, high = DAMPING_RANGE
        # A step also serves what is in no error: the shape of the control mesh. That may cost a little.
        before = merit(state, samples, self.weights, bound)
        if merit(moved, self._samples(moved), self.weights, bound) < GIVE * before:
            self._damping = max(self._damping / 3, low)
            return moved
        self._damping = min(self._damping * 10, high)
        return state

    def adapt(self, state: FitState) -> FitState:
        """Refine where the error asks for it: cut each bad face in two, and halve bad curve sides."""
        tolerance = self.settings.tolerance
        state = state.refreshed(tolerance.max or 0.0)
        faces = self._bad_faces(state)
        few = len(faces) <= FEW * state.surface.topology.face_count
        if few:
            straying = large_enough(state, self._stray_faces(state))
            faces = np.concatenate([faces, np.setdiff1d(straying, faces)])
        marks = all_sides(state, faces) if few else cutting_sides(state, faces)
        if tolerance.max is not None and not self.settings.fixed_boundary:
            marks |= curve_sides(state, CURVE_FACTOR * tolerance.max)
        marks = self._within_budget(state, marks, faces)
        if not marks.any():
            return state
        if few:
            self._damping = max(self._damping, LATE_DAMPING)
        self._watched = None
        finer = refined(state, marks, regularise=not few)
        budget = self.settings.max_control_vertices
        return finer if budget is None or finer.surface.topology.vertex_count <= budget else state

    def _samples(self, state: FitState) -> Strays:
        """Samples of the state's sparse faces, found once a state."""
        if self._sampled is None or self._sampled[0] is not state:
            self._sampled = (state, sparse_samples(state))
        return self._sampled[1]

    def _sample_rows(self, state: FitState, samples: Strays, bound: float) -> list[Rows]:
        if len(samples) == 0:
            return []
        weight = pull(samples, self.weights, bound)
        return [reverse_rows(state, self.weights, samples.face, samples.uv, samples.gap, weight)]

    def _strays(self, state: FitState) -> Strays | None:
        """Samples of the surface that stray, once the data's side is nearly within tolerance."""
        bound = self.settings.tolerance.max
        if bound is None or badness(state, self.settings.tolerance) > NEARLY:
            return None
        return strays(state, 0.9 * bound)

    def _stray_rows(self, state: FitState) -> list[Rows]:
        """Pull strays back; once seen they are watched until the connectivity changes."""
        found = self._strays(state)
        if found is not None and len(found):
            self._watched = found if self._watched is None else self._watched.joined(found)
        if self._watched is None:
            return []
        self._watched = self._watched.follow(state)
        w = self._watched
        return [reverse_rows(state, self.weights, w.face, w.uv, w.gap, np.full(len(w), STRAY_WEIGHT))]

    def _stray_faces(self, state: FitState) -> NDArray[np.int64]:
        found = self._strays(state)
        return np.unique(Places(state.surface).face[found.face]) if found is not None else np.empty(0, np.int64)

    def _bad_faces(self, state: FitState) -> NDArray[np.int64]:
        """Faces whose maximum is too large, worst first and capped; where a mean is, those with the largest sums."""
        tolerance, errors = self.settings.tolerance, state.errors
        faults = Faults.of(state)
        worst = faults.maximum
        cap = max(10, int(CAP * len(worst)))
        bad = np.empty(0, np.int64)
        if tolerance.max is not None:
            bad = np.flatnonzero(worst > tolerance.max)
            bad = bad[np.argsort(-worst[bad], kind="stable")[:cap]]
        if not replace(tolerance, max=None).met(errors.max, errors.rms, errors.mean):
            largest = np.argsort(-faults.squares, kind="stable")[: max(1, cap // 5)]
            bad = np.concatenate([bad, np.setdiff1d(largest, bad)])
        return bad

    def _within_budget(self, state: FitState, marks: NDArray[np.bool_], faces: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Drop marks, all but those of the worst faces, where they would exceed the budget of vertices."""
        budget = self.settings.max_control_vertices
        if budget is None:
            return marks
        room = budget - state.surface.topology.vertex_count
        if room <= 0:
            return np.zeros_like(marks)
        if np.count_nonzero(marks) <= room:
            return marks
        cost = np.bincount(state.surface.topology.face, marks, minlength=state.surface.topology.face_count)
        return marks & all_sides(state, faces[np.cumsum(cost[faces]) <= room])
