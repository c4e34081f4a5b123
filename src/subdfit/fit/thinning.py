"""Fewer control vertices and faces while the error stays within tolerance: edges collapsed, faces merged.

Hoppe et al. 1994 try one collapse at a time and optimise round it. Here many are tried at once. A largest error holds
or not near each change: they lie so far apart that each stands or falls by itself. A mean is a matter of the whole:
all control points move, and what the changes cost must sum to no more than there is room for.
"""

from collections.abc import Iterator

from subdfit.fit.settings import FitSettings
from subdfit.fit.state import FitState
from subdfit.fit.thinning_apart import Apart
from subdfit.fit.thinning_changes import collapses, merges
from subdfit.fit.thinning_hold import Hold
from subdfit.fit.thinning_queue import Find, Queue
from subdfit.fit.thinning_together import Together
from subdfit.mesh.polygon_edits import PolygonEdits


class Thinning:
    """Changes of the control mesh that leave less of it, tried on a fit.

    Parameters
    ----------
    settings
        What must go on to hold.
    """

    def __init__(self, settings: FitSettings) -> None:
        self._hold = Hold(settings)
        self._trials = Together(self._hold) if settings.tolerance.max is None else Apart(self._hold)

    def lighter(self, state: FitState) -> Iterator[FitState]:
        """Ever lighter fits, both sides of each within tolerance, from one whose data are."""
        state = self._hold.settled(state)
        for find in (collapses,) if state.surface.scheme.faces == "triangles" else (collapses, merges):
            for lighter in self._thinned(state, find):
                state = lighter
                yield state

    def _thinned(self, state: FitState, find: Find) -> Iterator[FitState]:
        """Ever lighter fits by changes of one kind, until several trials in sequence keep none."""
        queue, fruitless = Queue(find, state.surface.topology.vertex_count), 0
        while fruitless < self._trials.patience:
            edits = PolygonEdits(state.surface.control_mesh)
            changes = self._trials.chosen(state, edits, queue.cheapest(state.surface, edits))
            if not changes:
                break
            queue.tried(changes)
            kept = self._trials.kept(state, changes)
            fruitless += 1
            if kept is not None:
                queue.changed(kept.rows, kept.near)
                state, fruitless = kept.state, 0
                yield state
