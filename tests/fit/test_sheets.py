"""Thin parts: a surface that mixes their sheets up is noticed, and the fit begins with more control vertices."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import trimesh

import subdfit
from subdfit.fit.data import FitData
from subdfit.fit.settings import FitSettings
from subdfit.fit.sheets import mixed, mixed_sheets
from subdfit.fit.starts import Start, parted, second_start
from subdfit.fit.state import FitState
from subdfit.fit.tangential import Tangential
from subdfit.fit.thinning import Thinning
from subdfit.initial.start import start_mesh
from subdfit.limit.surface import LimitSurface
from subdfit.measure import Measurement, Tolerance
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.target.frame import Frame
from subdfit.target.target import mesh_target


@pytest.mark.parametrize("turned", [False, True])
def test_the_share_of_a_ball_inside_out_is_one(turned: bool) -> None:
    ball, coarse = trimesh.creation.icosphere(4), trimesh.creation.icosphere(1)
    faces = np.asarray(coarse.faces)
    mesh = ControlMesh.from_triangles(coarse.vertices, faces[:, ::-1] if turned else faces)
    data = FitData.of(mesh_target(ball.vertices, ball.faces), 1.0)
    assert mixed(FitState.start(data, LimitSurface(mesh, "loop"))).share == pytest.approx(float(turned))


@pytest.mark.parametrize("scheme", ["loop", "doo-sabin"])
def test_a_casting_of_thin_plates_is_certified(meshes, scheme: str) -> None:
    """Its plates are a fiftieth of its diagonal thick, and a start of 5 % of its points turns some inside out."""
    result = subdfit.fit(meshes / "casting.ply", max_error="0.3%", scheme=scheme)
    assert result.certified
    assert result.history[0].control_vertices > 0.05 * 5096


def ball_with_plate(thickness: float) -> tuple[np.ndarray, np.ndarray]:
    """A ball that runs out into a plate, so many times as thick."""
    ball = trimesh.creation.icosphere(5)
    points = np.array(ball.vertices)
    points[:, 2] *= thickness + (1 - thickness) / (1 + np.exp(np.clip(12 * points[:, 0], -50, 50)))
    points[:, 0] += 3 * np.maximum(points[:, 0], 0)
    return points, np.asarray(ball.faces)


def test_sheets_are_parted_where_they_mix_and_nowhere_else() -> None:
    """The start is not made finer all over."""
    target = mesh_target(*ball_with_plate(1e-3), creases="none")
    target = target.normalised(Frame.of(target.points))
    settings = FitSettings(tolerance=Tolerance(max=1e-3))
    mesh = start_mesh(target, 300, 1e-3)
    state = FitState.start(FitData.of(target, 0.02), LimitSurface(mesh, "loop"))
    found = parted(state, settings, lambda: Tangential(settings))
    assert mixed_sheets(state, Tangential(settings))[0] is not None
    assert mixed_sheets(found.state, Tangential(settings))[0] is None
    assert 1.05 * 300 < found.state.surface.topology.vertex_count < 1.5 * 300


def test_after_sheets_fell_together_the_fit_begins_with_more_there() -> None:
    """Where they did not, or the number of control vertices was asked for, there is no second start."""
    settings = FitSettings(tolerance=Tolerance(max=1e-3))

    def again(thickness: float, asked: FitSettings) -> Start | None:
        target = mesh_target(*ball_with_plate(thickness), creases="none")
        target = target.normalised(Frame.of(target.points))
        state = FitState.start(FitData.of(target, 0.02), LimitSurface(start_mesh(target, 300, 1e-3), "loop"))
        begun = Start(state, Tangential(asked))
        return second_start(begun, state, asked, lambda: Tangential(asked))

    second = again(1e-3, settings)
    assert second is not None
    assert 300 < second.state.surface.topology.vertex_count < 1.5 * 300
    assert again(0.5, settings) is None
    assert again(1e-3, replace(settings, control_vertices=300)) is None
    assert again(1e-3, replace(settings, max_control_vertices=301)) is None


def test_the_round_that_was_looked_at_is_the_first_of_the_fit() -> None:
    target = mesh_target(*ball_with_plate(1e-3), creases="none")
    target = target.normalised(Frame.of(target.points))
    settings = FitSettings(tolerance=Tolerance(max=1e-3))
    state = FitState.start(FitData.of(target, 0.02), LimitSurface(start_mesh(target, 300, 1e-3), "loop"))
    fitter = Tangential(settings)
    advanced = mixed_sheets(state, fitter)[1]
    again = Tangential(settings)
    points = advanced.surface.control_mesh.points
    np.testing.assert_array_equal(points, again.advance(state).surface.control_mesh.points)
    second = fitter.advance(advanced).surface.control_mesh.points
    np.testing.assert_array_equal(second, again.advance(advanced).surface.control_mesh.points)


def test_a_plate_of_some_tolerances_is_certified() -> None:
    assert subdfit.fit(ball_with_plate(3e-3), max_error="0.1%", creases="none").certified


def test_a_fit_whose_sheets_fell_together_is_not_thinned_before_another_begins(monkeypatch: pytest.MonkeyPatch) -> None:
    """Between a ring's own curves 20 control vertices begin; the second start has more."""
    ring = trimesh.creation.annulus(0.5, 1, 0.6, sections=48).subdivide_to_size(0.25)
    target, thinned = (np.asarray(ring.vertices), np.asarray(ring.faces)), list[int]()

    def lighter(self: Thinning, state: FitState) -> Iterator[FitState]:
        thinned.append(state.surface.topology.vertex_count)
        return iter(())

    monkeypatch.setattr(Thinning, "lighter", lighter)
    subdfit.fit(target, scheme="quad-triangle", method="lavoue", max_error="0.5%")
    assert thinned == [20]
    thinned.clear()
    monkeypatch.setattr(Measurement, "sheets_fell_together", True)
    subdfit.fit(target, scheme="quad-triangle", method="lavoue", max_error="0.5%")
    assert len(thinned) == 1
    assert thinned[0] > 20
