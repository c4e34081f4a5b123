"""Trials of changes of a control mesh that all control points move to make up for: the error is spread."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.changes import faces_at, ring
from subdfit.fit.places import Places
from subdfit.fit.state import FitState
from subdfit.fit.thinning_changes import Change, disjoint, faces_made, made
from subdfit.fit.thinning_hold import Hold, Kept, drawn
from subdfit.limit.surface import LimitSurface
from subdfit.mesh.polygon_edits import PolygonEdits

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class _Trial:
    """Some changes made at once, and what each adds to the sum of the errors that are asked for, (changes,)."""

    kept: Kept
    loss: Floats


class Together:
    """Changes that have no vertex of their faces in common, made at once.

    Parameters
    ----------
    hold
        What must go on to hold.
    """

    patience = 3
    """Trials in sequence from which nothing is kept, after which no more is tried."""

    def __init__(self, hold: Hold) -> None:
        self._hold = hold

    def chosen(self, state: FitState, edits: PolygonEdits, changes: list[Change]) -> list[Change]:
        """Those of the changes, first ones first, that may be made at once."""
        return disjoint(edits, changes)

    def kept(self, state: FitState, changes: list[Change]) -> Kept | None:
        """The fit with as many of the changes as leave it within tolerance; None where none does."""
        while changes:
            trial = self._trial(state, changes)
            if self._hold.holds(trial.kept.state):
                return trial.kept
            changes = self._fewer(state, changes, trial.loss)
        return None

    def _fewer(self, state: FitState, changes: list[Change], loss: Floats) -> list[Change]:
        """The cheapest of the changes for which there is room, half where there is for all."""
        order = np.argsort(loss, kind="stable")
        fit = np.searchsorted(np.cumsum(np.maximum(loss[order], 0.0)), self._hold.room(state), side="right")
        most = fit if fit < len(order) else len(order) // 2
        return [changes[k] for k in sorted(order[:most])]

    def _trial(self, state: FitState, changes: list[Change]) -> _Trial:
        before = state.surface
        mesh, rows, near = made(before, changes)
        everything = np.ones(len(rows), np.bool_)
        points = drawn(mesh, before.scheme, Places(before).vertices()[rows], everything)
        start = FitState.start(state.data, LimitSurface(replace(mesh, points=points), before.scheme))
        moved = self._hold.moved(start)
        return _Trial(
            Kept(moved, rows, np.ones(before.topology.vertex_count, np.bool_)), self._loss(state, moved, near)
        )

    def _loss(self, before: FitState, after: FitState, near: Flags) -> Floats:
        """What each change adds, from the faces with two corners and more `near` it, (changes, n).

        Faces that lie so near none are those of all that moved them.
        """
        t, places, power = after.surface.topology, Places(after.surface), self._hold.power
        hit = faces_made(t, near)
        around = np.array([faces_at(t, ring(t, flags)) for flags in near]).reshape(hit.shape)
        hit |= around & ~hit.any(axis=0)
        vertices = slice(0, after.data.vertices)
        grown = after.distance[vertices] ** power - before.distance[vertices] ** power
        return np.asarray(hit @ np.bincount(places.face[after.face[vertices]], grown, minlength=t.face_count))
