"""Trials of many changes of a control mesh at once, while most of them stand: what is to blame leaves the batch."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.changes import faces_at, ring
from subdfit.fit.places import Places
from subdfit.fit.reverse import strays
from subdfit.fit.state import FitState
from subdfit.fit.thinning_changes import Change, disjoint, faces_made, made
from subdfit.fit.thinning_hold import Hold, Kept, drawn
from subdfit.limit.surface import LimitSurface
from subdfit.mesh.polygon_edits import PolygonEdits

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

PROMISING = 4.0
"""How many times what is asked the largest error near a change may be, before any step, if it is to be in a batch."""
LEAST = 0.5
"""Share of a batch's promising changes that must stand: else they are rather tried each by itself."""
MANY = 20
"""Fewest changes of a batch: on small meshes trials apart keep as many in the same time."""


class Batches:
    """Changes that have no vertex of their faces in common, made at once, and moved near all of them at once.

    Parameters
    ----------
    hold
        What must go on to hold; a largest error is among it.
    """

    patience = 2
    """Batches in sequence of which nothing is kept, after which no more is tried."""

    def __init__(self, hold: Hold) -> None:
        self._hold = hold
        self._most = hold.tolerance.max or np.inf

    def chosen(self, state: FitState, edits: PolygonEdits, changes: list[Change]) -> list[Change]:
        """Those of the changes, first ones first, that may be made at once; none where these are few."""
        found = disjoint(edits, changes)
        return found if len(found) >= MANY else []

    def kept(self, state: FitState, changes: list[Change]) -> Kept | None:
        """The fit with those changes that leave it within tolerance; None where fewer than half do that promised to."""
        error = _Batch.of(self._hold, state, changes).changed_errors()
        left = np.flatnonzero(error <= PROMISING * self._most)
        least = LEAST * len(left)
        while len(left) > least:
            batch = _Batch.of(self._hold, state, [changes[k] for k in left]).moved(self._hold)
            guilty = batch.guilty(error[left], self._most)
            if not guilty.any():
                return batch.kept if self._hold.holds_elsewhere(batch.kept.state) else None
            left = left[~guilty]
        return None


@dataclass(frozen=True, eq=False)
class _Batch:
    """A fit with some changes.

    Attributes
    ----------
    kept : the fit.
    near : (changes, n) bool, vertices of its mesh near each.
    """

    kept: Kept
    near: Flags

    @classmethod
    def of(cls, hold: Hold, state: FitState, changes: list[Change]) -> "_Batch":
        """The changes made, and nothing moved but what draws the surface near where it was."""
        before = state.surface
        mesh, rows, near = made(before, changes)
        moving = near.any(axis=0) & hold.free(mesh.topology)
        points = drawn(mesh, before.scheme, Places(before).vertices()[rows], moving)
        surface = LimitSurface(replace(mesh, points=points), before.scheme)
        touched = np.zeros(before.topology.vertex_count, np.bool_)
        touched[rows] = near.any(axis=0)
        gone = np.ones(before.topology.vertex_count, np.bool_)
        gone[rows] = False
        around = ring(before.topology, ring(before.topology, touched | gone))
        return cls(Kept(FitState.start(state.data, surface), rows, around), near)

    def moved(self, hold: Hold) -> "_Batch":
        """The same, optimised near the changes."""
        state = hold.moved_near(self.kept.state, np.asarray(self.near.any(axis=0)))
        return replace(self, kept=hold.assured(replace(self.kept, state=state)))

    @cached_property
    def _changed(self) -> Flags:
        """The faces that each change makes, (changes, f)."""
        return faces_made(self.kept.state.surface.topology, self.near)

    def changed_errors(self) -> Floats:
        """How far off the data are at most in the faces that each change makes, (changes,)."""
        return np.asarray(np.where(self._changed, self._data_errors(), 0.0).max(axis=1))

    def guilty(self, error: Floats, most: float) -> Flags:
        """The changes that are to blame for faces too far off, (changes,).

        Those that made one, and of those that moved one that of most error.
        """
        state = self.kept.state
        t = state.surface.topology
        stray = strays(state.surface, state.data.target, most).face
        bad = self._data_errors() > most
        bad[Places(state.surface).face[stray]] = True
        moved = np.array([faces_at(t, ring(t, flags)) for flags in self.near])
        moved = moved[:, bad & moved.any(axis=0)]
        blamed = np.asarray((self._changed & bad).any(axis=1))
        blamed[np.argmax(np.where(moved, error[:, None], -1.0), axis=0)] = True
        return blamed

    def _data_errors(self) -> Floats:
        """How far off data are at most in each face, and of its curves, (f,)."""
        state, face = self.kept.state, Places(self.kept.state.surface).face
        worst = np.zeros(state.surface.topology.face_count)
        np.maximum.at(worst, face[state.face], state.excess)
        for found in state.held:
            if found is not None:
                np.maximum.at(worst, face[found.face], found.distance)
        return worst
