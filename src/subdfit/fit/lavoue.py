"""The method ``lavoue``: a part's own faces and edges make the control mesh (Lavoué, Dupont and Baskurt 2007).

The paper fits every patch of a segmented part by itself, boundaries held, and joins them. Here patches share their
curves from the start (`lavoue_whole`), and are optimised together, so that curves move as well: rounds of the steps of
`tangent`, in which points on creases are tied to crease curves, and enrichment when these have settled too far off.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.fit.descent import FIRM
from subdfit.fit.faults import Faults
from subdfit.fit.lavoue_enrichment import SIGNIFICANT
from subdfit.fit.lavoue_optimisation import ROUNDS
from subdfit.fit.lavoue_whole import cut_part, whole_start
from subdfit.fit.places import Places
from subdfit.fit.reverse import Samples, even_strays, reverse_badness, sparse_samples, strays
from subdfit.fit.settings import FitSettings
from subdfit.fit.state import FitState
from subdfit.fit.stop import badness, within
from subdfit.fit.tangential import Tangential
from subdfit.fit.thinning_hold import Hold
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.target.features import along_edges
from subdfit.target.target import Target

Rows = NDArray[np.int64]

SCHEMES = ("quad-triangle", "catmull-clark")
"""Schemes whose control meshes may have quads and triangles."""
CURVES = {"max": 0.5, "rms": 4.0, "mean": 7.5}
"""The first curves lie within so many times what is asked of the largest, the rms and the mean error."""
GAIN = 0.95
"""A round that leaves more than this share of the error is the last before the control mesh is enriched."""
NEAR = 1.5
"""How many times what is asked the error is at most when the control mesh is enriched in every round."""
FOLD = 4.0
"""Samples farther off than so many times the rms error of the data are drawn back: no freedom would mend them."""


class Lavoue(Tangential):
    """Rounds of optimisation of all patches together, and enrichment once they have settled too far off."""

    cuts_at_once = True

    def __init__(self, settings: FitSettings) -> None:
        super().__init__(settings)
        self._rounds, self._before = 0, np.inf
        self._hold = Hold(settings)

    def advance(self, state: FitState) -> FitState:
        """One round of steps, the control mesh enriched first where that is due."""
        # Large faces leave directions in which little holds their vertices.
        self._descent.damping = max(self._descent.damping, FIRM)
        # Large faces turn far in a round: footpoints that follow them get lost, and speak of errors where none are.
        state, tolerance = super().advance(state).refreshed(self._descent.bound), self.settings.tolerance
        # Of a mean on both sides more steps may bring about what costs vertices otherwise.
        near = tolerance.max is None and badness(state, tolerance) <= NEAR
        return self._hold.settled(state) if near else state

    def stray(self, state: FitState) -> float:
        """How far the surface strays: samples of it at most, or on average where no largest error is asked."""
        tolerance = self.settings.tolerance
        return reverse_badness(state, tolerance) if tolerance.max is None else super().stray(state)

    def _samples(self, state: FitState) -> Samples:
        """Those of sparse faces, and of folds: samples much farther off than the data are; all once these hold.

        Where a largest error is asked that does not hold yet, without the peaks between them, which would pull hardest.
        """
        tolerance = self.settings.tolerance
        held = within(state, tolerance)
        least = max(self._descent.bound / 2, 0.0 if held else FOLD * state.errors.rms)
        if held or tolerance.max is None:
            return sparse_samples(state).joined(strays(state.surface, state.data.target, least))
        return sparse_samples(state).joined(even_strays(state, least))

    def _moved_everywhere(self, state: FitState, final: bool) -> FitState:
        """By all points: few of them would leave large faces free to swing between."""
        return super()._moved_everywhere(state, True)

    def adapt(self, state: FitState) -> tuple[FitState, NDArray[np.bool_] | None]:
        """Enrich, after `ROUNDS` at most, unless the rounds still gain; then all control vertices move."""
        error = badness(state, self.settings.tolerance)
        self._rounds += 1
        if self._rounds < ROUNDS and error < GAIN * self._before and error > NEAR:
            self._before = error
            return state, None
        self._rounds, self._before = 0, np.inf
        return super().adapt(state)

    def _bad_faces(self, state: FitState) -> Rows:
        """The faces of error fields only (section 5.2), of the data, then of the samples: others may do after these."""
        worst, faces = Faults.of(state).maximum, super()._bad_faces(state)
        if len(faces) == 0 and self.settings.tolerance.max is None:
            found = self._samples(state)
            worst = np.zeros(state.surface.topology.face_count)
            np.maximum.at(worst, Places(state.surface).face[found.face], found.gap)
            faces = np.flatnonzero(worst)
        return np.asarray(faces[worst[faces] >= SIGNIFICANT * worst[faces].max(initial=0.0)])


def require_lavoue(scheme: str, control_vertices: int | None) -> None:
    """Raise InputError for settings that the method ``lavoue`` cannot follow."""
    if scheme not in SCHEMES:
        raise InputError(f"the method lavoue joins quads and triangles; choose the scheme {' or '.join(SCHEMES)}")
    if control_vertices is not None:
        raise InputError("the method lavoue takes its first control vertices from the part's edges; give no number")


def lavoue_start(target: Target, settings: FitSettings) -> tuple[Target, ControlMesh]:
    """The target with those creases that are curves of the control mesh, and the first control mesh.

    Raises
    ------
    InputError
        The target is a cloud, or the settings do not suit the method.
    """
    require_lavoue(settings.scheme, settings.control_vertices)
    if target.cloud:
        raise InputError("the method lavoue takes the faces of a mesh; reconstruct one from the points first")
    part = cut_part(target)
    asked = {key: getattr(settings.tolerance, key) for key in CURVES}
    bound = min(CURVES[key] * value for key, value in asked.items() if value)
    mesh = replace(whole_start(part, bound), scheme=settings.scheme)
    return replace(target, crease_edges=along_edges(target.points, target.triangles, part.target.crease_edges)), mesh
