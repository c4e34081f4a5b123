"""Fewer control vertices and faces while the error stays within tolerance: edges collapsed, faces merged.

Hoppe et al. 1994 try one collapse at a time and optimise round it. Here many that lie apart are tried at once, the
control points near each optimised; where the surface leaves the tolerance, the changes near it are taken back.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.adapt import drawn_near
from subdfit.fit.changes import faces_at, ring
from subdfit.fit.descent import Descent, Part
from subdfit.fit.held import boundary_vertices
from subdfit.fit.places import Places
from subdfit.fit.reverse import Samples, reverse_badness, sparse_curve_samples, sparse_samples, strays
from subdfit.fit.settings import FitSettings
from subdfit.fit.spots import spots_moved
from subdfit.fit.state import FitState
from subdfit.fit.stop import error_that_matters, within
from subdfit.fit.tangent import TangentSettings
from subdfit.fit.thinning_changes import Change, collapses, merges
from subdfit.limit.surface import LimitSurface
from subdfit.mesh.polygon_edits import PolygonEdits
from subdfit.mesh.topology import Topology

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]
Flags = NDArray[np.bool_]
Candidates = Callable[[PolygonEdits, Floats, "Tried"], list[Change]]
Tried = set[tuple[int, int]]
Move = Callable[[FitState, Flags], FitState]

ENOUGH = 24
"""Points for each triangle of a face that take part in the steps of a trial: large faces swing between fewer."""
STEPS, GAIN = 4, 0.98
"""Most steps of a trial, which ends when one leaves more than this share of the energy."""
DAMPING = 1e-2
"""Their first damping: large faces leave directions in which little holds their vertices."""
DRAWN = 20
"""Steps that draw the limit points of what is left to where they were; nothing is refined here, and little swings."""
SETTLING = 8
"""Rounds in which the reverse side may come within tolerance before anything is taken out."""
PATIENCE = 3
"""Trials in sequence from which nothing is kept, after which no more is tried."""


@dataclass(frozen=True, eq=False)
class _Trial:
    """Some changes made at once, and the surface optimised.

    Attributes
    ----------
    state : the fit.
    rows : of its control vertices in the mesh before.
    excess : (changes,) how far off the surface is at most near each.
    loss : (changes,) what each adds to the sum of the errors that are asked for.
    """

    state: FitState
    rows: Rows
    excess: Floats
    loss: Floats


class Thinning:
    """Changes of the control mesh that leave less of it, tried on a fit.

    Parameters
    ----------
    settings
        What must go on to hold.
    """

    def __init__(self, settings: FitSettings) -> None:
        self.settings = settings
        self._bound = error_that_matters(settings.tolerance)

    def lighter(self, state: FitState) -> Iterator[FitState]:
        """Ever lighter fits, both sides of each within tolerance, from one whose data are."""
        state = self._settled(state)
        candidates = (collapses,) if state.surface.scheme.faces == "triangles" else (collapses, merges)
        for move, found in product(self._moves(), candidates):
            for lighter in self._thinned(state, found, move):
                state = lighter
                yield state

    def _moves(self) -> tuple[Move, ...]:
        """How control points are optimised: all of them, which spreads the error; then those near what changed.

        A fit that just holds its largest error is not the least sum of squares, and does not hold it when all move.
        """
        return (self._moved,) if self.settings.tolerance.max is None else (self._moved, self._moved_near)

    def _thinned(self, state: FitState, candidates: Candidates, move: Move) -> Iterator[FitState]:
        """Ever lighter fits by changes of one kind, until several trials in sequence keep none."""
        names, tried, fruitless = np.arange(state.surface.topology.vertex_count), Tried(), 0
        while fruitless < PATIENCE and (changes := self._apart(state, names, tried, candidates)):
            tried |= {change.named(names) for change in changes}
            trial = self._kept(state, changes, move)
            fruitless += 1
            if trial is not None:
                state, names, fruitless = trial.state, names[trial.rows], 0
                yield state

    def _settled(self, state: FitState) -> FitState:
        """The state moved until both its sides hold; as it was, where a few rounds do not bring that about."""
        moved = state
        for _ in range(SETTLING):
            if self._holds(moved):
                return moved
            moved = self._moved(moved)
        return state

    def _apart(self, state: FitState, names: Rows, tried: Tried, candidates: Candidates) -> list[Change]:
        """Changes that have no vertex of their faces in common, cheapest first."""
        edits = PolygonEdits(state.surface.control_mesh)
        taken: set[int] = set()
        chosen = []
        limits = Places(state.surface).vertices()
        for change in sorted(candidates(edits, limits, self._rows(tried, names)), key=lambda change: change.cost):
            near = change.near(edits)
            if not near & taken:
                taken |= near
                chosen.append(change)
        return chosen

    @staticmethod
    def _rows(tried: Tried, names: Rows) -> Tried:
        row = {int(name): k for k, name in enumerate(names)}
        return {(row[a], row[b]) for a, b in tried if a in row and b in row}

    def _kept(self, state: FitState, changes: list[Change], move: Move) -> _Trial | None:
        """The trial of as many of the changes as leave the fit within tolerance."""
        while changes:
            trial = self._trial(state, changes, move)
            if self._holds(trial.state):
                return trial
            changes = self._fewer(state, changes, trial)
        return None

    def _fewer(self, state: FitState, changes: list[Change], trial: _Trial) -> list[Change]:
        """Those changes near which the error allows it, of these the cheapest for which there is room."""
        bound = self.settings.tolerance.max or np.inf
        left = [k for k in range(len(changes)) if trial.excess[k] <= bound]
        order = sorted(left, key=lambda k: trial.loss[k])
        room = self._room(state)
        fit = np.searchsorted(np.cumsum(np.maximum(trial.loss[order], 0.0)), room, side="right")
        most = fit if fit < len(order) or len(order) < len(changes) else len(order) // 2
        return [changes[k] for k in sorted(order[:most])]

    def _room(self, state: FitState) -> float:
        """How much the sum of the errors that are asked for may grow."""
        asked, count = self.settings.tolerance, state.data.vertices
        if asked.rms is not None:
            return count * (asked.rms**2 - state.errors.rms**2)
        return count * (asked.mean - state.errors.mean) if asked.mean is not None else np.inf

    def _trial(self, state: FitState, changes: Sequence[Change], move: Move) -> _Trial:
        edits = PolygonEdits(state.surface.control_mesh)
        near = [change.near(edits) for change in changes]
        for change in changes:
            change.make(edits)
        mesh, rows = edits.frozen()
        scheme = state.surface.scheme
        limits = Places(state.surface).vertices()[rows]
        mesh = replace(mesh, points=drawn_near(mesh, scheme, limits, DRAWN))
        row = {int(v): k for k, v in enumerate(rows)}
        flags = np.zeros((len(changes), len(rows)), np.bool_)
        for k, vertices in enumerate(near):
            flags[k, [row[v] for v in vertices if v in row]] = True
        moved = move(FitState.start(state.data, LimitSurface(mesh, scheme)), np.any(flags, axis=0))
        return _Trial(moved, rows, *self._judged(state, moved, flags))

    def _moved_near(self, state: FitState, changed: Flags) -> FitState:
        """Control points near changed ones, (n,), optimised."""
        topology = state.surface.topology
        moving = ring(topology, changed) & self._free(topology)
        return spots_moved(state, moving, TangentSettings(), self._bound, 1.0)

    def _moved(self, state: FitState, changed: Flags | None = None) -> FitState:
        """All control points optimised, by some of the points, whatever has changed."""
        some, rows = state.thinned(ENOUGH)
        samples = sparse_samples(some).joined(self._strays(state))
        cells = np.ones(state.surface.domain.face_count, np.bool_)
        free = self._free(state.surface.topology)
        descent = Descent(TangentSettings(), self._bound, DAMPING)
        part = Part(some, samples, sparse_curve_samples(some, cells), free, STEPS, GAIN)
        return state.followed(descent.moved(part), rows)

    def _free(self, topology: Topology) -> Flags:
        """Control vertices that may move at all, (n,)."""
        if self.settings.fixed_boundary:
            return ~boundary_vertices(topology)
        return np.ones(topology.vertex_count, np.bool_)

    def _strays(self, state: FitState) -> Samples:
        return strays(state.surface, state.data.target, self._bound / 2)

    def _judged(self, before: FitState, after: FitState, near: Flags) -> tuple[Floats, Floats]:
        """Largest excess and loss by change, from the faces with two corners and more `near` it, (changes, n).

        Faces that lie so near none are those of all that moved them.
        """
        t, places = after.surface.topology, Places(after.surface)
        hit = np.add.reduceat(near[:, t.face_vertices].astype(np.int64), t.face_offsets[:-1], axis=1) >= 2
        around = np.array([faces_at(t, ring(t, flags)) for flags in near]).reshape(hit.shape)
        hit |= around & ~hit.any(axis=0)
        worst = np.zeros(t.face_count)
        np.maximum.at(worst, places.face[after.face], after.excess)
        for found in after.held:
            if found is not None:
                np.maximum.at(worst, places.face[found.face], found.distance)
        samples = self._strays(after)
        np.maximum.at(worst, places.face[samples.face], samples.gap)
        power = 1 if self.settings.tolerance.rms is None else 2
        vertices = slice(0, after.data.vertices)
        grown = after.distance[vertices] ** power - before.distance[vertices] ** power
        loss = np.bincount(places.face[after.face[vertices]], grown, minlength=t.face_count)
        return np.max(np.where(hit, worst, 0.0), axis=1), np.asarray(hit @ loss, np.float64)

    def _holds(self, state: FitState) -> bool:
        """Whether both sides are within tolerance."""
        tolerance = self.settings.tolerance
        if not within(state, tolerance):
            return False
        if tolerance.max is not None:
            return float(self._strays(state).gap.max(initial=0.0)) <= tolerance.max
        return reverse_badness(state, tolerance) <= 1
