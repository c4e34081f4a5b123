"""What a lighter fit must go on to hold, and all its control points moved to hold it better."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.changes import cells_moved_by
from subdfit.fit.descent import FIRM, Descent, Part
from subdfit.fit.reverse import (
    DRAWN,
    Samples,
    even_samples,
    even_strays,
    reverse_badness,
    sparse_curve_samples,
    sparse_samples,
    strays,
)
from subdfit.fit.settings import FitSettings
from subdfit.fit.state import FitState
from subdfit.fit.stop import error_between_data, within
from subdfit.fit.tangent import TangentSettings
from subdfit.measure import reverse_segments
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.schemes import Scheme

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]
Flags = NDArray[np.bool_]

ENOUGH = 24
"""Points for each triangle of a face that take part in steps: large faces swing between fewer."""
STEPS, GAIN = 4, 0.98
"""Most steps, which end when one leaves more than this share of the energy."""
REDRAWN = 20
"""Steps that draw the limit points of what is left to where they were; nothing is refined here, and little swings."""

SETTLING = 8
"""Rounds of steps in which both sides may come within tolerance."""


def drawn(mesh: ControlMesh, scheme: Scheme, limits: Floats, moving: Flags) -> Floats:
    """Control points, (n, 3), of which the flagged ones are moved so that their limit points come near `limits`.

    Cheng et al. 2009, section 2.
    """
    points, masks = mesh.points.copy(), scheme.limit_rows(mesh.topology)
    for _ in range(REDRAWN):
        points[moving] += (limits - masks @ points)[moving]
    return points


@dataclass(frozen=True, eq=False)
class Kept:
    """A fit after some changes.

    Attributes
    ----------
    state : the fit.
    rows : of its control vertices in the mesh before.
    near : (n,) bool, vertices of that mesh near what has changed.
    """

    state: FitState
    rows: Rows
    near: Flags


class Hold:
    """What is asked of a fit.

    Parameters
    ----------
    settings
        The tolerance, and whether the boundary is held.
    """

    def __init__(self, settings: FitSettings) -> None:
        self.tolerance = settings.tolerance
        self.bound = error_between_data(settings.tolerance)
        self._fixed_boundary = settings.fixed_boundary

    def holds(self, state: FitState) -> bool:
        """Whether both sides are within tolerance."""
        if not within(state, self.tolerance):
            return False
        if self.tolerance.max is not None:
            return len(strays(state.surface, state.data.target, self.tolerance.max)) == 0
        return reverse_badness(state, self.tolerance) <= 1

    def holds_elsewhere(self, state: FitState) -> bool:
        """The same, where the surface is known to hold near what has changed, and no mask reaches farther."""
        return self.holds(state) if state.surface.scheme.whole_curves else within(state, self.tolerance)

    def free(self, topology: Topology) -> Flags:
        """Control vertices that may move at all, (n,)."""
        if self._fixed_boundary:
            return ~topology.boundary_vertices
        return np.ones(topology.vertex_count, np.bool_)

    def moved(self, state: FitState) -> FitState:
        """All control points optimised, by some of the points."""
        return self._moved(state, sparse_samples(state), self.free(state.surface.topology))

    def moved_near(self, state: FitState, moving: Flags) -> FitState:
        """The control points that are flagged, (n,), optimised by some of the points and many samples."""
        segments = max(reverse_segments(state.surface.domain) // 2, 1)
        cells = cells_moved_by(state.surface, moving)
        samples = even_samples(state.surface, state.data.target, segments, cells)
        return self._moved(state, samples, self.free(state.surface.topology) & moving)

    def _moved(self, state: FitState, samples: Samples, free: Flags) -> FitState:
        some, rows = state.thinned(ENOUGH)
        samples = samples.joined(self._strays(state))
        curves = sparse_curve_samples(some, np.ones(state.surface.domain.face_count, np.bool_))
        part = Part(some, samples, curves, free, STEPS, GAIN)
        return state.followed(Descent(TangentSettings(), self.bound, FIRM).moved(part), rows)

    def _strays(self, state: FitState) -> Samples:
        """What strays by half the bound and more, peaks between samples only where a largest error is asked."""
        if self.tolerance.max is None:
            return even_strays(state, DRAWN * self.bound)
        return strays(state.surface, state.data.target, self.bound, share=DRAWN)

    def assured(self, kept: Kept) -> Kept:
        """The same fit, no point of which counts as too far off because its footpoint was missed."""
        return kept if self.tolerance.max is None else replace(kept, state=kept.state.assured(self.tolerance.max))

    def settled(self, state: FitState) -> FitState:
        """The state moved until both its sides hold; as it was, where a few rounds do not bring that about."""
        moved = state
        for _ in range(SETTLING):
            if self.holds(moved):
                return moved
            moved = self.moved(moved)
        return state

    def room(self, state: FitState) -> float:
        """How much the sum of the errors that are asked for may grow; of their squares, where an rms is asked."""
        asked, count = self.tolerance, state.data.vertices
        if asked.rms is not None:
            return count * (asked.rms**2 - state.errors.rms**2)
        return count * (asked.mean - state.errors.mean) if asked.mean is not None else np.inf

    @property
    def power(self) -> int:
        """Of the errors whose sum has room."""
        return 1 if self.tolerance.rms is None else 2
