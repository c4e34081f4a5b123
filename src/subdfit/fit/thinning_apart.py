"""Trials of changes of a control mesh, each on the part of the surface that it moves and no other does."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.changes import faces_at, ring
from subdfit.fit.descent import FIRM, Descent, Part
from subdfit.fit.places import Places
from subdfit.fit.regions import Region
from subdfit.fit.reverse import DRAWN, even_samples, sparse_curve_samples, strays
from subdfit.fit.state import FitState
from subdfit.fit.tangent import TangentSettings
from subdfit.fit.thinning_changes import Change
from subdfit.fit.thinning_hold import ENOUGH, GAIN, STEPS, Hold, Kept, drawn
from subdfit.limit.surface import LimitSurface
from subdfit.measure import reverse_segments
from subdfit.mesh.polygon_edits import PolygonEdits
from subdfit.mesh.topology import Topology

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Rows = NDArray[np.int64]

HOPELESS = 6.0
"""How many times what is asked the largest error is, before any step, of a change that no steps mend."""


@dataclass(frozen=True, eq=False)
class _Outcome:
    """What came of a change.

    Attributes
    ----------
    vertices, points : (k,) and (k, 3), control vertices of the mesh before, and where they are then.
    good : whether the largest error holds where they have moved the surface.
    loss : what they add to the sum of the errors that are asked for.
    """

    vertices: Rows
    points: Floats
    good: bool
    loss: float


class Apart:
    """Changes no two of which move the same face: each is optimised, and kept or not, by itself.

    Parameters
    ----------
    hold
        What must go on to hold; a largest error is among it.
    """

    patience = 12
    """Trials in sequence from which nothing is kept, after which no more is tried."""

    def __init__(self, hold: Hold) -> None:
        self._hold = hold

    def chosen(self, state: FitState, edits: PolygonEdits, changes: list[Change]) -> list[Change]:
        """Those of the changes, first ones first, that may be tried at once."""
        topology = state.surface.topology
        taken = np.zeros(topology.face_count, np.bool_)
        found = []
        for change in changes:
            moved = _faces_moved(topology, _near(topology, edits, change))
            if not np.any(moved & taken):
                taken |= moved
                found.append(change)
        return found

    def kept(self, state: FitState, changes: list[Change]) -> Kept | None:
        """The fit with those of the changes that leave it within tolerance; None where none does.

        Where errors are summed, those that add least, as many as there is room for, and then half as many, and so on.
        """
        tried = _Trial(self._hold, state, changes).outcomes()
        good = [
            k for k, outcome in enumerate(tried) if outcome.good and (outcome.loss <= 0 or not changes[k].must_gain)
        ]
        good.sort(key=lambda k: tried[k].loss)
        added = np.cumsum([max(tried[k].loss, 0.0) for k in good])
        most = int(np.searchsorted(added, self._hold.room(state), side="right"))
        while most > 0:
            some = sorted(good[:most])
            found = self._hold.assured(_made(state, [changes[k] for k in some], [tried[k] for k in some]))
            if self._hold.holds_elsewhere(found.state):
                return found
            most //= 2
        return None


class _Trial:
    """Changes that lie far apart, all made on one mesh."""

    def __init__(self, hold: Hold, state: FitState, changes: list[Change]) -> None:
        before, edits = state.surface, PolygonEdits(state.surface.control_mesh)
        self._hold, self._state = hold, state
        self._most = hold.tolerance.max or np.inf
        self._near = [_near(before.topology, edits, change) for change in changes]
        for change in changes:
            change.make(edits)
        mesh, self._rows = edits.frozen()
        free = hold.free(mesh.topology)
        self._moving = [flags[self._rows] & free for flags in self._near]
        points = drawn(mesh, before.scheme, Places(before).vertices()[self._rows], np.any(self._moving, axis=0))
        self._surface = LimitSurface(replace(mesh, points=points), before.scheme)

    def outcomes(self) -> list[_Outcome]:
        """What came of each change."""
        topology, face = self._state.surface.topology, Places(self._state.surface).face
        data = [self._state.rows_in(_faces_moved(topology, near)[face]) for near in self._near]
        return [self._outcome(moving, rows) for moving, rows in zip(self._moving, data, strict=True)]

    def _outcome(self, moving: Flags, data: Rows) -> _Outcome:
        """What comes of one change, from these rows of the data."""
        region = Region.of(self._surface, _faces_moved(self._surface.topology, moving))
        free = moving[region.vertices] & region.own
        state = FitState.start(self._state.data.subset(data), region.surface)
        if good := self._excess(state) <= HOPELESS * self._most:
            state = self._optimised(state, region.inner, free)
            good = self._excess(state) <= self._most and not self._strays(state, region.inner)
        vertices, power = state.data.vertices, self._hold.power
        loss = np.sum(state.distance[:vertices] ** power - self._state.distance[data[:vertices]] ** power)
        return _Outcome(self._rows[region.vertices[free]], state.surface.control_mesh.points[free], good, float(loss))

    def _optimised(self, state: FitState, inner: Flags, free: Flags) -> FitState:
        surface, target, segments = state.surface, state.data.target, reverse_segments(self._state.surface.domain)
        some, rows = state.thinned(ENOUGH)
        samples = even_samples(surface, target, segments, inner)
        samples = samples.joined(strays(surface, target, self._hold.bound, inner, segments, DRAWN))
        part = Part(some, samples, sparse_curve_samples(some, inner), free, STEPS, GAIN)
        return state.followed(Descent(TangentSettings(), self._hold.bound, FIRM).moved(part), rows)

    @staticmethod
    def _excess(state: FitState) -> float:
        """How far off the data are at most, on curves too."""
        return max(float(part.max(initial=0.0)) for part in (state.excess, state.curve_distances))

    def _strays(self, state: FitState, inner: Flags) -> bool:
        """Whether samples of the surface are too far off."""
        segments = reverse_segments(self._state.surface.domain)
        return len(strays(state.surface, state.data.target, self._most, inner, segments)) > 0


def _near(topology: Topology, edits: PolygonEdits, change: Change) -> Flags:
    """Vertices of the faces that change, (n,)."""
    flags = np.zeros(topology.vertex_count, np.bool_)
    flags[sorted(change.near(edits))] = True
    return flags


def _faces_moved(topology: Topology, moving: Flags) -> Flags:
    """Faces, (f,), that move where the flagged vertices do."""
    return faces_at(topology, ring(topology, moving))


def _made(state: FitState, changes: list[Change], outcomes: list[_Outcome]) -> Kept:
    """The fit with these changes and what came of them."""
    before, edits = state.surface, PolygonEdits(state.surface.control_mesh)
    topology, points = before.topology, before.control_mesh.points.copy()
    near = np.any([_near(topology, edits, change) for change in changes], axis=0)
    for change, outcome in zip(changes, outcomes, strict=True):
        change.make(edits)
        points[outcome.vertices] = outcome.points
    mesh, rows = edits.frozen()
    surface = LimitSurface(replace(mesh, points=points[rows]), before.scheme)
    return Kept(FitState.start(state.data, surface), rows, ring(topology, ring(topology, near)))
