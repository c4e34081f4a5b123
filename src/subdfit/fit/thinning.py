"""Fewer control vertices and faces while the error stays within tolerance: edges collapsed, faces merged.

Hoppe et al. 1994 try one collapse at a time and optimise round it. Here many are tried at once. A largest error holds
or not near each change: large batches are made while most of their changes stand, then changes so far apart that each
stands or falls by itself. A mean is a matter of the whole:
all control points move, and what the changes cost must sum to no more than there is room for.

Where a largest error is asked, edges are first turned to follow the lines of curvature, if that brings the data nearer;
then faces are merged and edges collapsed by turns, until a whole turn keeps nothing. For a mean one turn does: edges
first, since each leaves less and what there is room for is soon spent.
"""

from collections.abc import Iterator
from itertools import product
from typing import Protocol

from subdfit.fit.settings import FitSettings
from subdfit.fit.state import FitState
from subdfit.fit.thinning_apart import Apart
from subdfit.fit.thinning_batches import Batches
from subdfit.fit.thinning_changes import Change, collapses, merges
from subdfit.fit.thinning_hold import Hold, Kept
from subdfit.fit.thinning_queue import Find, Queue
from subdfit.fit.thinning_together import Together
from subdfit.fit.thinning_turns import Alignment
from subdfit.mesh.polygon_edits import PolygonEdits


class Way(Protocol):
    """A way to try changes."""

    @property
    def patience(self) -> int:
        """Trials in sequence from which nothing is kept, after which no more is tried."""

    def chosen(self, state: FitState, edits: PolygonEdits, changes: list[Change]) -> list[Change]:
        """Those of the changes, first ones first, that may be tried at once."""

    def kept(self, state: FitState, changes: list[Change]) -> Kept | None:
        """The fit with those of the changes that leave it within tolerance; None where none does."""


class Thinning:
    """Changes of the control mesh that leave less of it, tried on a fit.

    Parameters
    ----------
    settings
        What must go on to hold.
    """

    def __init__(self, settings: FitSettings) -> None:
        self._hold = Hold(settings)
        self._mean = settings.tolerance.max is None
        self._ways: tuple[Way, ...] = (
            (Together(self._hold),) if self._mean else (Batches(self._hold), Apart(self._hold))
        )

    def lighter(self, state: FitState) -> Iterator[FitState]:
        """Ever lighter fits, both sides of each within tolerance, from one whose data are."""
        state = self._hold.settled(state)
        trials = [_Trials(find, way, state.surface.topology.vertex_count) for find, way in self._kinds(state)]
        before = None
        while before is not state:
            before = state
            for trial in trials:
                for kept in trial.lighter(state):
                    for one in trials:
                        one.queue.changed(kept.rows, kept.near)
                    state = kept.state
                    yield state
            if self._mean:
                break

    def _kinds(self, state: FitState) -> list[tuple[Find, Way]]:
        """Kinds of changes, and the ways in which they are tried, in their order."""
        kinds: tuple[Find, ...] = (collapses,)
        if state.surface.scheme.faces != "triangles":
            kinds = (collapses, merges) if self._mean else (merges, collapses)
        trials = list(product(kinds, self._ways))
        target = state.data.target
        if self._mean or target.cloud or not target.is_mesh:
            return trials
        return [(Alignment.of(target).turns, self._ways[-1]), *trials]


class _Trials:
    """Changes of one kind, tried in one way; what was tried once is not tried again."""

    def __init__(self, find: Find, way: Way, count: int) -> None:
        self.queue = Queue(find, count)
        self._way = way

    def lighter(self, state: FitState) -> Iterator[Kept]:
        """Ever lighter fits, until several trials in sequence keep nothing; each goes on from the one before."""
        fruitless = 0
        while fruitless < self._way.patience:
            edits = PolygonEdits(state.surface.control_mesh)
            changes = self._way.chosen(state, edits, self.queue.cheapest(state.surface, edits))
            if not changes:
                break
            self.queue.tried(changes)
            kept = self._way.kept(state, changes)
            fruitless += 1
            if kept is not None:
                state, fruitless = kept.state, 0
                yield kept
