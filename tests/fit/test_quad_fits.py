"""Fitting with schemes that take polygons: their own truths; those of all schemes are in `test_fit`."""

from dataclasses import replace

import numpy as np
import pytest

from subdfit.fit.adapt import drawn_near, refined
from subdfit.fit.changes import faces_at
from subdfit.fit.data import FitData
from subdfit.fit.driver import fit_target
from subdfit.fit.faults import all_sides, cutting_sides
from subdfit.fit.settings import FitSettings
from subdfit.fit.state import FitState
from subdfit.initial.start import start_mesh
from subdfit.limit import LimitSurface
from subdfit.measure import Tolerance
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.schemes import SCHEMES
from subdfit.target.frame import Frame
from subdfit.target.target import Target

OTHERS = pytest.mark.parametrize("scheme", [name for name in SCHEMES if name not in ("loop", "doo-sabin-averaging")])


def settings(scheme: str, bound: float, **others: object) -> FitSettings:
    return replace(FitSettings(scheme=scheme, tolerance=Tolerance(max=bound)), **others)  # type: ignore[arg-type]


def quad_share(mesh: ControlMesh) -> float:
    return float(np.mean(np.diff(mesh.topology.face_offsets) == 4))


def swing(surface: LimitSurface) -> float:
    """How far a control point lies off its limit point at most."""
    return float(np.linalg.norm(surface.control_mesh.points - surface.vertex_limits(), axis=1).max())


def state_of(target: Target, scheme: str, vertices: int) -> FitState:
    inside = target.normalised(Frame.of(target.points))
    mesh = start_mesh(inside, vertices, None, faces=SCHEMES[scheme].faces)
    return FitState.start(FitData.of(inside, 0.02), LimitSurface(mesh, scheme))


@OTHERS
@pytest.mark.parametrize("method", ["auto", "geometric"])
def test_a_sphere_is_certified(scheme: str, method: str, ball: Target) -> None:
    result = fit_target(ball, settings(scheme, 2e-3, method=method))
    assert result.certified
    assert result.control_mesh.scheme == scheme
    assert quad_share(result.control_mesh) > 0.5


@OTHERS
def test_refining_barely_moves_the_surface(scheme: str, ball: Target) -> None:
    state = state_of(ball, scheme, 150)
    before = state.errors
    some = np.arange(0, state.surface.topology.face_count, 3)
    for marks in (cutting_sides(state, some), all_sides(state, some)):
        finer = refined(state, marks)
        assert finer.surface.topology.vertex_count > state.surface.topology.vertex_count + 20
        assert finer.errors.rms < 1.5 * before.rms


@OTHERS
def test_refining_carries_footpoints_to_where_a_search_finds_them(scheme: str, ball: Target, dome: Target) -> None:
    """All but a few beside a coarse boundary, where there are several nearest points."""
    for target in (ball, dome):
        state = state_of(target, scheme, 150)
        finer = refined(state, cutting_sides(state, np.arange(0, state.surface.topology.face_count, 7)))
        anew = FitState.start(state.data, finer.surface)
        assert np.mean(np.abs(finer.distance - anew.distance) > 1e-6) < 2e-3


@OTHERS
def test_control_points_do_not_swing_when_a_rough_surface_is_refined_again_and_again(scheme: str, ball: Target) -> None:
    state = state_of(ball, scheme, 150)
    mesh = state.surface.control_mesh
    rough = mesh.with_points(mesh.points + np.random.default_rng(0).normal(0, 0.005, mesh.points.shape))
    state = FitState.start(state.data, LimitSurface(rough, scheme))
    before = swing(state.surface)
    for _ in range(2):
        near = np.linalg.norm(state.surface.vertex_limits() - [0.3, 0, 0], axis=1) < 0.25
        state = refined(state, all_sides(state, np.flatnonzero(faces_at(state.surface.topology, near))))
    assert swing(state.surface) < 1.1 * before


@OTHERS
def test_limits_are_drawn_to_where_they_are_wanted(scheme: str, dome: Target) -> None:
    mesh = state_of(dome, scheme, 100).surface.control_mesh
    wanted, limits = mesh.points, SCHEMES[scheme].limit_points
    for _ in range(20):
        mesh = mesh.with_points(drawn_near(mesh, SCHEMES[scheme], wanted))
    away = np.abs(limits(mesh.topology, mesh.points) - wanted).max()
    assert away < 0.1 * np.abs(limits(mesh.topology, wanted) - wanted).max()


@OTHERS
def test_creases_may_end_inside(scheme: str, box: Target) -> None:
    broken = replace(box, crease_edges=box.crease_edges[1:])
    result = fit_target(broken, settings(scheme, 5e-3))
    assert result.measurement.crease is not None
    assert result.certified
