"""The method ``auto``: damped tangent-distance steps, and splits of the faces whose maximum is too large."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.adapt import refined
from subdfit.fit.changes import cells_moved_by, changed_cells, ring
from subdfit.fit.faults import Faults, all_sides, curve_sides, cutting_sides, large_enough
from subdfit.fit.places import Places
from subdfit.fit.reverse import CurveSamples, Samples, inner_samples, strays, strays_in
from subdfit.fit.settings import FitSettings
from subdfit.fit.state import Errors, FitState
from subdfit.fit.stop import CURVE_FACTOR, badness, error_that_matters
from subdfit.fit.tangent import TangentSettings, curve_reverse_rows, merit, reverse_rows, tangent_step
from subdfit.limit.surface import LimitSurface

STEPS = 3
"""Most steps in a round."""
GAIN = 0.9
"""A round ends when a step leaves more than this share of the energy."""
ENOUGH = 8
"""Points for each triangle of a face that take part in the steps while the control mesh still changes; errors are those
of all points."""
SPARSE = 3
"""Faces with fewer points than this are sampled, for nothing else keeps them near the target."""
CAP = 0.25
"""Most triangles, as a share, that one adaptation refines for their error."""
POLYGON_CAP = CAP / 4
"""The same for other faces: one is as large as two triangles, and to cut it takes two vertices or three."""
MISSING = 0.7
"""Share of the vertices that seem to be missing for mean and rms, which one adaptation adds."""
FEW = 0.01
"""When fewer faces than this share are too far off, triangles are split on all sides and no edge is flipped; as many
faces again may be split because the surface strays there."""
LAST = 2
"""So few polygons are cut on all sides as well: one cut may go the wrong way."""
LATE_DAMPING = 1e-2
"""Least damping after a late split, which has few points to hold it."""
REACH = 2
"""Rings of control vertices round the faults that move with them when faults are few."""
NEARLY = 1.5
"""Errors within this many tolerances are nearly there: the reverse side is looked at."""
ROBUST = 3.0
"""Points farther than so many tolerances pull no harder, where outliers are expected."""
DAMPING_RANGE = (1e-6, 1.0)
"""Levenberg damping falls by 3 after a step that is kept and rises by 10 after one that is not, within this range."""
GIVE = 1.05
"""A step is kept if it raises the error by no more than this factor; the driver keeps the best state."""


Flags = NDArray[np.bool_]


class Auto:
    """Rounds of a few damped tangent-distance steps, the control mesh adapted before each but the first."""

    patience = 12

    def __init__(self, settings: FitSettings, weights: TangentSettings | None = None) -> None:
        self.settings = settings
        robust = ROBUST * error_that_matters(settings.tolerance) if settings.robust else np.inf
        self.weights = weights or TangentSettings(robust=robust)
        self._damping = self.weights.damping
        self._begun = self._drawn = False
        self._seen: tuple[LimitSurface, Samples] | None = None

    def advance(self, state: FitState) -> FitState:
        """One round: the control mesh is adapted, then moved until that gains little; only there, if faults are few."""
        nearly = badness(state, self.settings.tolerance) <= NEARLY
        topology, focus = state.surface.topology, None
        if self._begun:
            state, focus = self.adapt(state)
        final = self._begun and state.surface.topology is topology
        self._begun, self._drawn = True, nearly
        samples = self._sparse(state)
        if nearly:
            samples = samples.joined(self._strays(state))
        free = self._free(state, focus)
        if focus is not None:
            cells = cells_moved_by(state.surface, free)
            some, rows = state.near(cells)
            return state.followed(self._moved(some, samples[cells[samples.face]], free), rows)
        if final:
            return self._moved(state, samples, free)
        some, rows = state.thinned(ENOUGH)
        return state.followed(self._moved(some, samples, free), rows)

    def settled(self, state: FitState) -> bool:
        """Whether no sample of the surface strays beyond the tolerance."""
        bound = self.settings.tolerance.max
        if bound is None:
            return True
        if np.any(np.abs(self._strays(state).gaps(state.surface)) > bound):
            return False
        # Samples were carried from state to state, and their density is that of an earlier one.
        self._seen = None
        return not np.any(np.abs(self._strays(state).gaps(state.surface)) > bound)

    def _free(self, state: FitState, focus: Flags | None) -> Flags:
        """Control vertices that may move, (n,): all, or those within `REACH` rings of the focus."""
        topology = state.surface.topology
        free = np.ones(topology.vertex_count, np.bool_)
        if focus is not None:
            free = focus
            for _ in range(REACH):
                free = ring(topology, free)
        if self.settings.fixed_boundary:
            free[topology.edge_vertices[topology.boundary_edges].ravel()] = False
        return free

    def _moved(self, state: FitState, samples: Samples, free: Flags) -> FitState:
        """Steps, each kept if it lowers the energy with new footpoints, until one gains little."""
        bound = error_that_matters(self.settings.tolerance)
        low, high = DAMPING_RANGE
        on_curves = self._sparse_curves(state)
        energy = merit(state, samples, on_curves, self.weights, bound)
        for _ in range(STEPS):
            pulled = [reverse_rows(state, self.weights, samples, bound)]
            pulled += [curve_reverse_rows(state, self.weights, found) for found in on_curves]
            points = tangent_step(state, self.weights, self._damping, pulled, free)
            moved = state.moved(points)
            left = merit(moved, samples, on_curves, self.weights, bound)
            # A step also serves what is in no error: the shape of the control mesh. That may cost a little.
            if left > GIVE * energy:
                self._damping = min(self._damping * 10, high)
                continue
            self._damping = max(self._damping / 3, low)
            gain = left / energy
            state, energy = moved, left
            if gain > GAIN:
                break
        return state

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
        straying = self._stray_faces(state) if few else np.empty(0, np.int64)
        focus = np.concatenate([faces, straying])
        # Strays are drawn back for a round before their faces are split.
        if few and self._drawn:
            found = large_enough(state, straying)
            found = found[~np.isin(found, faces)]
            faces = np.concatenate([faces, found[: max(10, int(FEW * state.surface.topology.face_count))]])
        last = few and (self._triangles(state) or len(faces) <= LAST)
        marks = all_sides(state, faces) if last else cutting_sides(state, faces)
        if tolerance.max is not None and not self.settings.fixed_boundary:
            marks |= curve_sides(state, CURVE_FACTOR * tolerance.max)
        marks = self._within_budget(state, marks, faces)
        finer = refined(state, marks, regularise=not few) if marks.any() else state
        budget = self.settings.max_control_vertices
        if budget is not None and finer.surface.topology.vertex_count > budget:
            finer = state
        if few and finer is not state:
            self._damping = max(self._damping, LATE_DAMPING)
        return finer, self._focus(state, finer, focus, marks) if few and len(focus) else None

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

    def _sparse(self, state: FitState) -> Samples:
        """Samples of faces with few data points."""
        face = Places(state.surface).face
        count = np.bincount(face[state.face], minlength=state.surface.topology.face_count)
        return inner_samples(state.surface, state.data.target, np.flatnonzero(count[face] < SPARSE))

    @staticmethod
    def _sparse_curves(state: FitState) -> list[CurveSamples]:
        """Samples of sides of curves with few data points."""
        trees = (state.data.target.boundary_tree, state.data.target.crease_tree)
        samples = []
        for found, curves, tree in zip(state.held, state.curves, trees, strict=True):
            if found is not None and curves is not None and tree is not None:
                count = np.bincount(found.side, minlength=len(curves))
                samples.append(CurveSamples.of(curves, np.flatnonzero(count < SPARSE), tree))
        return samples

    def _strays(self, state: FitState) -> Samples:
        """Samples of the surface that stray by half the tolerance or more."""
        bound = self.settings.tolerance.max
        if bound is None or state.data.target.cloud:
            return Samples.none()
        surface, target = state.surface, state.data.target
        if self._seen is None:
            self._seen = (surface, strays(surface, target, bound / 2))
        elif self._seen[0] is not surface:
            before, found = self._seen
            changed = changed_cells(before, surface)
            kept = found[~changed[found.face]] if not changed.all() else Samples.none()
            self._seen = (surface, kept.joined(strays_in(surface, target, bound / 2, changed)))
        return self._seen[1]

    def _stray_faces(self, state: FitState) -> NDArray[np.int64]:
        """Faces whose samples stray beyond the tolerance, or nearly; the farthest first."""
        bound, found = self.settings.tolerance.max, self._strays(state)
        gap = np.zeros(state.surface.topology.face_count)
        np.maximum.at(gap, Places(state.surface).face[found.face], np.abs(found.gaps(state.surface)))
        order = np.argsort(-gap, kind="stable")
        return order[gap[order] > 0.9 * (bound or np.inf)]

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

    def _within_budget(self, state: FitState, marks: Flags, faces: NDArray[np.int64]) -> Flags:
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
