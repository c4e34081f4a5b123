"""The method ``auto``: damped tangent-distance steps, and splits of the faces whose maximum is too large."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.adapt import close_editor, face_maxima, longest_sides, open_editor, place_subdivided, side_marks
from subdfit.fit.settings import FitSettings
from subdfit.fit.state import FitState
from subdfit.fit.stop import CURVE_FACTOR, within
from subdfit.fit.tangent import TangentSettings, merit, tangent_step

STEPS = 3
"""Steps between adaptations."""
CAP = 0.25
"""Most faces, as a share, that one adaptation refines for their error."""
FROZEN = 0.002
"""When fewer faces than this share are too far off, connectivity is left alone."""
DAMPING_RANGE = (1e-6, 1e3)


class Auto:
    """Tangent-distance minimisation with Levenberg damping; adapts every few steps."""

    def __init__(self, settings: FitSettings, weights: TangentSettings | None = None) -> None:
        self.settings = settings
        self.weights = weights or TangentSettings()
        self._damping = self.weights.damping
        self._steps = 0

    def advance(self, state: FitState) -> FitState:
        """One step, kept if the true error falls; every `STEPS` steps the control mesh is adapted first."""
        if self._steps >= STEPS:
            self._steps = 0
            state = self.adapt(state)
        self._steps += 1
        before = merit(state, self.weights)
        points = tangent_step(state, self.weights, self._damping, self.settings.fixed_boundary)
        moved = state.moved(points)
        low, high = DAMPING_RANGE
        if merit(moved, self.weights) < before:
            self._damping = max(self._damping / 3, low)
            return moved
        self._damping = min(self._damping * 10, high)
        return state

    def adapt(self, state: FitState) -> FitState:
        """Refine where the error asks for it: the longest side of each bad face, and bad curve sides."""
        tolerance = self.settings.tolerance
        state = state.refreshed(tolerance.max or 0.0)
        if within(state, tolerance):
            return state
        faces = self._bad_faces(state)
        marks = longest_sides(state, faces)
        if tolerance.max is not None and not self.settings.fixed_boundary:
            marks |= side_marks(state, CURVE_FACTOR * tolerance.max)
        marks = self._within_budget(state, marks, faces)
        if not marks.any():
            return state
        editor = open_editor(state)
        editor.mark()
        place_subdivided(editor, editor.split_edges(marks), state)
        if len(faces) > FROZEN * state.surface.topology.face_count:
            region = editor.touched()
            editor.regularise_connectivity(region)
            editor.improve_angles(region, max_rise=0)
        return close_editor(editor, state)

    def _bad_faces(self, state: FitState) -> NDArray[np.int64]:
        """Faces whose maximum is too large, worst first and capped; where a mean is, those with the largest sums."""
        tolerance, errors = self.settings.tolerance, state.errors
        worst = face_maxima(state)
        cap = max(10, int(CAP * len(worst)))
        bad = np.empty(0, np.int64)
        if tolerance.max is not None:
            bad = np.flatnonzero(worst > tolerance.max)
            bad = bad[np.argsort(-worst[bad], kind="stable")[:cap]]
        if not replace(tolerance, max=None).met(errors.max, errors.rms, errors.mean):
            sums = np.bincount(state.face, state.distance**2, minlength=len(worst))
            bad = np.union1d(bad, np.argsort(-sums, kind="stable")[: max(1, cap // 5)])
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
        allowed = np.zeros_like(marks)
        allowed[faces[:room]] = marks[faces[:room]]
        return allowed
