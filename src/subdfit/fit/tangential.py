"""The method ``tangent``: damped tangent-distance steps, and splits of the faces whose maximum is too large."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.adapt import refined
from subdfit.fit.changes import ring
from subdfit.fit.descent import Descent, Part
from subdfit.fit.faults import Faults, all_sides, curve_sides, cutting_sides, within_budget
from subdfit.fit.held import boundary_held
from subdfit.fit.reverse import Samples, sparse_curve_samples, sparse_samples
from subdfit.fit.settings import FitSettings
from subdfit.fit.spots import spots_moved
from subdfit.fit.state import Errors, FitState
from subdfit.fit.stop import CURVE_FACTOR, error_between_data, error_that_matters, within
from subdfit.fit.strays import Strays
from subdfit.fit.tangent import TangentSettings

STEPS, GAIN = 3, 0.9
"""Most steps in a round that moves everything, which ends when one leaves more than this share of the energy."""
FIRST_STEPS, FIRST_GAIN = 6, 0.95
"""The same before the first polygons are cut: a cut that one more step would have saved costs more vertices than one of
triangles."""
ENOUGH = 8
"""Points for each triangle of a face that take part in the steps while the control mesh still changes; errors are those
of all points."""
CAP = 0.25
"""Most triangles, as a share, that one adaptation refines for their error."""
POLYGON_CAP = CAP / 6
"""The same for other faces: one is as large as two triangles, and to cut it takes about three vertices."""
MISSING = 0.7
"""Share of the vertices that seem to be missing for mean and rms, which one adaptation adds."""
LATE, DENSE = 0.1, 4
"""When fewer faces than this share are too far off, samples that stray are drawn back in steps that move everything, if
there are so many points for each triangle that a face could be cut into: fewer would be outvoted."""
FEW = 0.003
"""When fewer faces than this share are too far off, triangles are split on all sides, no edge is flipped, and only what
lies near moves."""
LAST = 2
"""So few polygons are cut on all sides as well, a round after the first cut, which may have gone the wrong way."""
REACH = 2
"""Rings of control vertices round the faults that move with them when faults are few."""
ROBUST = 3.0
"""Points farther than so many tolerances pull no harder, where outliers are expected."""

Flags = NDArray[np.bool_]


class Tangential:
    """Rounds of a few damped tangent-distance steps, the control mesh adapted before each but the first."""

    patience = 16
    cuts_at_once = False
    """Whether a last polygon is cut on all sides before cutting it across was tried."""

    def __init__(self, settings: FitSettings, weights: TangentSettings | None = None) -> None:
        self.settings = settings
        robust = ROBUST * error_that_matters(settings.tolerance) if settings.robust else np.inf
        weights = weights or TangentSettings(robust=robust)
        self._descent = Descent(weights, error_between_data(settings.tolerance), weights.damping)
        self._strays = Strays(settings.tolerance.max)
        self._begun = self._cut = self._drawn = False

    def advance(self, state: FitState) -> FitState:
        """One round: the control mesh is adapted, then moved until that gains little; only there, if faults are few."""
        state = self._taken_back(state)
        topology, focus = state.surface.topology, None
        if self._begun:
            state, focus = self.adapt(state)
            if focus is None and within(state, self.settings.tolerance) and self.stray(state) <= 1:
                return state
        final = self._begun and state.surface.topology is topology
        self._cut, self._begun, self._drawn = self._begun, True, focus is not None
        return self._moved_everywhere(state, final) if focus is None else self._moved_near(state, focus)

    def _taken_back(self, state: FitState) -> FitState:
        """The state, or an earlier one where cuts between the points of a cloud made the surface stray.

        There, unlike inside the faces of a mesh, are no data that hold a finer surface.
        """
        cloud = state.data.target.cloud
        return self._strays.taken_back(state) if cloud and within(state, self.settings.tolerance) else state

    def stray(self, state: FitState) -> float:
        """How far samples of the surface lie off the target at most, in tolerances."""
        return self._strays.worst(state)

    def look_closer(self) -> None:
        """Allow less between the data from now on."""
        self._strays.allow_less()

    def _moved_everywhere(self, state: FitState, final: bool) -> FitState:
        """Move all control vertices, by some of the points as long as the control mesh still changes."""
        some, rows = (state, np.arange(len(state.face))) if final else state.thinned(ENOUGH)
        cells = np.ones(state.surface.domain.face_count, np.bool_)
        free = self._free(np.ones(state.surface.topology.vertex_count, np.bool_), state)
        first = not self._cut and not self._triangles(state)
        until = (FIRST_STEPS, FIRST_GAIN) if first else (STEPS, GAIN)
        part = Part(some, self._samples(state), sparse_curve_samples(state, cells), free, *until)
        return state.followed(self._descent.moved(part), rows)

    def _samples(self, state: FitState) -> Samples:
        """What is drawn to the target between the points when everything moves: near the end all that strays.

        But not where few points hold the surface, nor for a mesh with outliers, up whose triangles it would be drawn.
        """
        topology = state.surface.topology
        spiky = self.settings.robust > 0 and not state.data.target.cloud
        dense = state.data.vertices >= DENSE * (len(topology.face) - 2 * topology.face_count)
        late = len(self._bad_faces(state)) <= LATE * topology.face_count
        drawn = late and dense and not spiky
        return sparse_samples(state).joined(self._strays.even(state)) if drawn else sparse_samples(state)

    def _moved_near(self, state: FitState, focus: Flags) -> FitState:
        """Move the control vertices near some, one spot after the other, by all points and samples there."""
        topology, near = state.surface.topology, focus
        for _ in range(REACH):
            near = ring(topology, near)
        insistence = self._strays.insist(state, within(state, self.settings.tolerance))
        descent = self._descent
        return spots_moved(state, self._free(near, state), descent.weights, descent.bound, insistence)

    def _free(self, vertices: Flags, state: FitState) -> Flags:
        """Those of the flagged control vertices that may move."""
        return vertices & ~state.surface.topology.boundary_vertices if self.settings.fixed_boundary else vertices

    def adapt(self, state: FitState) -> tuple[FitState, Flags | None]:
        """Refine where the error asks for it: cut each bad face in two, and halve bad curve sides.

        Returns
        -------
        The state, and the control vertices to move, (n,): those of faces that are too far off, where these are few, and
        what their refinement touched; None is all.
        """
        tolerance = self.settings.tolerance
        state = state.refreshed(tolerance.max or 0.0)
        faces = self._bad_faces(state)
        few = len(faces) <= FEW * state.surface.topology.face_count
        straying = self._strays.faces(state) if few else np.empty(0, np.int64)
        focus = np.concatenate([faces, straying])
        # Strays are drawn back for a round before their faces are split.
        if few and self._drawn:
            cut = self._strays.to_cut(state, straying)
            faces = np.concatenate([faces, cut[~np.isin(cut, faces)]])
        last = few and (self._triangles(state) or ((self._drawn or self.cuts_at_once) and len(faces) <= LAST))
        marks = all_sides(state, faces) if last else cutting_sides(state, faces)
        if tolerance.max is not None:
            marks |= curve_sides(state, CURVE_FACTOR * tolerance.max)
        marks = within_budget(state, marks, faces, self.settings.max_control_vertices)
        finer = self._refined(state, marks, few)
        return finer, self._focus(state, finer, focus, marks) if few and len(focus) else None

    def _refined(self, state: FitState, marks: Flags, few: bool) -> FitState:
        """The refined state, where there is something to refine and room for it."""
        if not marks.any():
            return state
        finer = refined(state, marks, regularise=not few)
        if self.settings.fixed_boundary:
            finer = boundary_held(finer, self.settings)
        budget = self.settings.max_control_vertices
        if budget is not None and finer.surface.topology.vertex_count > budget:
            return state
        return finer

    def _focus(self, state: FitState, finer: FitState, faces: NDArray[np.int64], marks: Flags) -> Flags | None:
        """Corners of some faces, ends of marked sides, and all new vertices; None where mean or rms ask for all."""
        if not replace(self.settings.tolerance, max=None).met(np.inf, finer.errors.rms, finer.errors.mean):
            return None
        topology = state.surface.topology
        chosen = marks | all_sides(state, faces)
        focus = np.ones(finer.surface.topology.vertex_count, np.bool_)
        focus[: topology.vertex_count] = False
        focus[topology.face_vertices[chosen]] = focus[topology.face_vertices[topology.following[chosen]]] = True
        return focus

    @staticmethod
    def _triangles(state: FitState) -> bool:
        return state.surface.scheme.faces == "triangles"

    def _bad_faces(self, state: FitState) -> NDArray[np.int64]:
        """Faces whose maximum is too large, worst first and capped; where a mean is, those with the largest sums."""
        tolerance, errors = self.settings.tolerance, state.errors
        faults = Faults.of(state)
        worst = faults.maximum
        cap = max(10, int((CAP if self._triangles(state) else POLYGON_CAP) * len(worst)))
        bad = np.empty(0, np.int64)
        if tolerance.max is not None:
            bad = np.flatnonzero(worst > tolerance.max)
            bad = bad[np.argsort(-worst[bad], kind="stable")[:cap]]
        if not replace(tolerance, max=None).met(errors.max, errors.rms, errors.mean):
            wanted = int(min(MISSING * self._missing(errors) * state.surface.topology.vertex_count, cap))
            largest = np.argsort(-faults.squares, kind="stable")[: max(1, wanted)]
            bad = np.concatenate([bad, np.setdiff1d(largest, bad)])
        return bad

    def _missing(self, errors: Errors) -> float:
        """Growth of the control vertices that mean and rms seem to need: errors fall about as vertices grow."""
        asked = self.settings.tolerance
        ratios = [e / b for e, b in ((errors.rms, asked.rms), (errors.mean, asked.mean)) if b is not None]
        return max(ratios) - 1
