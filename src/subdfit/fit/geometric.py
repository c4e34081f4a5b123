"""The method ``geometric``: Loop fitting by geometric algorithms (Nishiyama, Morioka and Maekawa 2008), step by step.

No linear system: each control vertex moves by the mean error vector of the points over its one-ring, weighted by their
barycentric coordinates (equations 3 to 5). Every five iterations vertices are inserted where the error is large.
"""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.closest.projection import Projector, corner_weights
from subdfit.fit.adapt import refined
from subdfit.fit.faults import Faults, all_sides, curve_sides, within_budget
from subdfit.fit.held import boundary_held
from subdfit.fit.places import Places
from subdfit.fit.reverse import Samples
from subdfit.fit.settings import FitSettings
from subdfit.fit.state import FOOTPOINT_TOLERANCE, FitState
from subdfit.fit.stop import CURVE_FACTOR, within
from subdfit.fit.strays import Strays
from subdfit.limit.surface import LimitSurface

Floats = NDArray[np.float64]

INSERTION_PERIOD = 5
"""Control vertices are inserted once in five iterations (section 5)."""
SETTLED = 1e-4
"""A footpoint that moved less than this share of the diagonal counts as settled."""
BESIDE = 1e-9
"""A point with less weight than this beside a curve pulls at the curve alone."""


class Geometric:
    """Nishiyama's algorithm as printed until the data are within tolerance.

    The boundary step, what is done about strays after that, over-relaxation and momentum are ours.
    """

    patience = 24

    def __init__(self, settings: FitSettings) -> None:
        self.settings = settings
        self._iteration = 0
        self._momentum = 1.0
        self._before: Floats | None = None
        self._settled: NDArray[np.bool_] | None = None
        self._strays = Strays(settings.tolerance.max)

    def advance(self, state: FitState) -> FitState:
        """One iteration: insertion when due, displacement, new footpoints."""
        if self._iteration and self._iteration % INSERTION_PERIOD == 0:
            state = self.insert_control_vertices(state)
        self._iteration += 1
        start = self._extrapolated(state)
        points = start.surface.control_mesh.points + self.settings.over_relaxation * self.displacements(start)
        return self.recompute_footpoints(start, points)

    def stray(self, state: FitState) -> float:
        """How far samples of the surface lie off the target at most, in tolerances."""
        return self._strays.worst(state)

    def look_closer(self) -> None:
        """Allow less between the data from now on."""
        self._strays.allow_less()

    def displacements(self, state: FitState) -> Floats:
        """Displacement of each control vertex, (n, 3): equations 3 and 4. Where the weights sum to zero it is zero."""
        surface = state.surface
        error = state.data.points - surface.evaluate(state.face, state.uv).position
        inside = np.arange(len(error))
        if self.settings.boundary_step:
            inside = np.flatnonzero(state.data.surface_rows)
        samples = self._samples(state)
        face = np.concatenate([state.face[inside], samples.face])
        pulls = influence(surface, face, np.concatenate([state.uv[inside], samples.uv]))
        errors = np.concatenate([error[inside], samples.gap[:, None] * samples.normal])
        displacement = weighted_means(pulls, errors)
        if self.settings.boundary_step or self.settings.fixed_boundary:
            self.curve_displacements(state, displacement, pulls, errors)
        return displacement

    def _samples(self, state: FitState) -> Samples:
        """What is drawn to the target like data, once these are within tolerance: samples that stray between them."""
        return self._strays.samples(state) if within(state, self.settings.tolerance) else Samples.none()

    def curve_displacements(
        self, state: FitState, displacement: Floats, surface_pulls: sp.csr_array, error: Floats
    ) -> None:
        """Our boundary step: vertices on curves move by the errors of curve points, by their weights along it.

        Of the surface's points only those pull as well that pull at no other vertex, as where the surface ends short
        of them: nothing else would reach them.

        Parameters
        ----------
        displacement : (n, 3), written at the vertices on curves.
        surface_pulls, error : (k, n) and (k, 3), weights and error vectors of the surface's points.
        """
        shares = Places(state.surface).corner_shares
        for found, curves, rows in zip(
            (state.boundary, state.crease), state.curves, (state.data.boundary, state.data.crease), strict=True
        ):
            if found is None or curves is None:
                continue
            pulls = (
                sp.csr_array(
                    (
                        np.column_stack([1 - found.t, found.t]).ravel(),
                        curves.ends[found.side].ravel(),
                        2 * np.arange(len(rows) + 1),
                    ),
                    shape=(len(rows), shares.shape[0]),
                )
                @ shares
            )
            on_curve = np.zeros(shares.shape[0])
            on_curve[curves.ends] = 1.0
            along = (shares.T @ on_curve) > 0
            displacement[along] = 0.0
            if not (self.settings.fixed_boundary and found is state.boundary):
                alone = np.flatnonzero(surface_pulls @ ~along <= BESIDE)
                errors = np.concatenate([state.data.points[rows] - found.position, error[alone]])
                displacement[along] = weighted_means(sp.vstack([pulls, surface_pulls[alone]]), errors)[along]

    def recompute_footpoints(self, state: FitState, points: Floats) -> FitState:
        """Newton's method from the footpoints before, by the tangent-plane linearisation; settled ones stay frozen.

        The driver computes all footpoints afresh before it believes a fit.
        """
        surface = state.surface.with_points(points)
        projector = Projector(surface, FOOTPOINT_TOLERANCE, second_order=False)
        rows = projector.order(state.face)
        if self._settled is not None and len(self._settled) == len(state.face):
            rows = rows[~self._settled[rows]]
        found = projector.refine(state.data.points, state.face, state.uv, rows)
        position = surface.evaluate(found.face, found.uv).position
        distance = np.linalg.norm(position - state.data.points, axis=1)
        step = np.linalg.norm(position - surface.evaluate(state.face, state.uv).position, axis=1)
        frozen = np.ones(len(step), np.bool_)
        frozen[rows] = step[rows] < SETTLED * 1e-2
        self._settled = frozen
        moved = replace(state, surface=surface, face=found.face, uv=found.uv, distance=distance)
        return moved.with_curves_of(surface)

    def insert_control_vertices(self, state: FitState) -> FitState:
        """Topological adjustment (section 5): 1-to-4 splits with crack-fixing, regularisation, flips for angles."""
        self._settled = None
        self._before, self._momentum = None, 1.0
        tolerance = self.settings.tolerance
        state = state.refreshed(tolerance.max or 0.0)
        chosen, budget = self._faces_to_split(state), self.settings.max_control_vertices
        worst = chosen[np.argsort(-Faults.of(state).maximum[chosen], kind="stable")]
        marks = within_budget(state, all_sides(state, chosen), worst, budget)
        if not marks.any():
            return state
        finer = refined(state, marks, whole_faces=True)
        if self.settings.fixed_boundary:
            finer = boundary_held(finer, self.settings)
        # Splits that close cracks may take more than was marked.
        return state if budget is not None and finer.surface.topology.vertex_count > budget else finer

    def _faces_to_split(self, state: FitState) -> NDArray[np.int64]:
        """Where the error does not become small enough: the face maximum, or its mean where only that is asked.

        Once it is, where the surface strays between the data.
        """
        tolerance, errors, faults = self.settings.tolerance, state.errors, Faults.of(state)
        if within(state, tolerance):
            return self._strays.to_cut(state, self._strays.faces(state))
        chosen = np.zeros(len(faults.count), np.bool_)
        if tolerance.max is not None:
            chosen |= faults.maximum > tolerance.max
            chosen[state.surface.topology.face[curve_sides(state, CURVE_FACTOR * tolerance.max)]] = True
        if not replace(tolerance, max=None).met(errors.max, errors.rms, errors.mean):
            mean = faults.sums / np.maximum(faults.count, 1)
            chosen[np.argsort(-mean, kind="stable")[: max(1, len(chosen) // 20)]] = True
        return np.flatnonzero(chosen)

    def _extrapolated(self, state: FitState) -> FitState:
        """Nesterov's momentum on the control points, where it is asked for."""
        if not self.settings.nesterov:
            return state
        points = state.surface.control_mesh.points
        before = self._before if self._before is not None and len(self._before) == len(points) else points
        following = (1 + np.sqrt(1 + 4 * self._momentum**2)) / 2
        share = (self._momentum - 1) / following
        self._momentum, self._before = float(following), points
        return replace(state, surface=state.surface.with_points(points + share * (points - before)))


def influence(surface: LimitSurface, face: NDArray[np.int32], uv: Floats) -> sp.csr_array:
    """Weights u by which points pull at control vertices, (k, n) sparse: barycentric coordinates (equation 3).

    In quads they are bilinear. Where cells are parts of faces, what falls to the middle of a side or of a face goes to
    its corners in equal shares.
    """
    domain = surface.domain
    shares = Places(surface).corner_shares
    corner = domain.present[face]
    offsets = np.concatenate([[0], np.cumsum(domain.shape[face], dtype=np.int64)])
    values, columns = corner_weights(domain.shape[face], uv)[corner], domain.points[face][corner]
    return sp.csr_array(sp.csr_array((values, columns, offsets), shape=(len(face), shares.shape[0])) @ shares)


def weighted_means(pulls: sp.csr_array, error: Floats) -> Floats:
    """Mean error vector of each control vertex, (n, 3), by (k, n) weights; zero where these sum to zero."""
    moved, weight = np.asarray(pulls.T @ error, np.float64), np.asarray(pulls.sum(axis=0), np.float64)
    return np.divide(moved, weight[:, None], out=np.zeros_like(moved), where=weight[:, None] > 1e-9)
