"""Fitting: truths about the result, whatever the method."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from tests.shapes.parts import can

from subdfit.closest.projection import Projector
from subdfit.errors import InputError
from subdfit.fit.data import FitData
from subdfit.fit.driver import METHODS, Progress, _Run, fit_target
from subdfit.fit.settings import FitSettings
from subdfit.fit.state import FitState
from subdfit.fit.tangential import Tangential
from subdfit.initial.start import start_mesh
from subdfit.limit import LimitSurface
from subdfit.measure import Tolerance, measure
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.schemes import SCHEMES
from subdfit.target.frame import Frame
from subdfit.target.target import Target, mesh_target

EITHER = pytest.mark.parametrize("method", ["auto", "geometric"])
FITTED = [name for name in SCHEMES if name != "doo-sabin-averaging"]
EVERY = pytest.mark.parametrize("scheme", FITTED)


def settings(method: str, bound: float, **others: object) -> FitSettings:
    return replace(FitSettings(method=method, tolerance=Tolerance(max=bound)), **others)  # type: ignore[arg-type]


@EITHER
def test_errors_are_those_of_an_independent_measurement(method: str, ball: Target) -> None:
    result = fit_target(ball, settings(method, 2e-3))
    assert result.status == "within_tolerance"
    surface = LimitSurface(result.control_mesh, "loop")
    found = Projector(surface).certain(ball.points)
    assert found.distance.max() / ball.diagonal == pytest.approx(result.measurement.max, rel=1e-6)
    assert result.measurement.max <= 2e-3


def test_auto_certifies_a_sphere(ball: Target) -> None:
    result = fit_target(ball, settings("auto", 5e-4))
    assert result.certified
    count = result.surface.domain.face_count
    fine = result.surface.evaluate(np.arange(count), np.full((count, 2), 0.3))
    radius = np.linalg.norm(fine.position, axis=1)
    assert np.abs(radius - 1).max() <= 5e-4 * ball.diagonal + ball.faceting


def test_error_falls_with_the_square_of_the_spacing(ball: Target) -> None:
    errors = []
    for vertices in (40, 160):
        asked = settings("auto", 1e-9, control_vertices=vertices, max_control_vertices=vertices, max_iterations=12)
        errors.append(fit_target(ball, asked).measurement.rms)
    # Four times the vertices halve the spacing. Loop surfaces approximate to second order at extraordinary vertices,
    # of which a decimated mesh is full: a factor of four, were its triangles as well shaped however many they are.
    assert errors[0] / errors[1] > 2.8


@EVERY
@EITHER
def test_the_boundary_is_followed(scheme: str, method: str, dome: Target) -> None:
    result = fit_target(dome, settings(method, 2e-3, scheme=scheme))
    assert result.certified
    assert result.measurement.boundary is not None
    assert result.measurement.boundary.max <= 4e-3
    assert np.count_nonzero(result.control_mesh.topology.boundary_edges) >= 3


@EVERY
def test_a_held_boundary_follows_its_own_data_and_stays(scheme: str, petal: Target) -> None:
    meshes: list[ControlMesh] = []
    asked = settings("auto", 1e-3, scheme=scheme, fixed_boundary=True)
    result = fit_target(petal, asked, lambda p: meshes.append(p.control_mesh))
    assert result.certified
    assert result.measurement.boundary is not None
    assert result.measurement.boundary.max <= 1e-3
    free = fit_target(petal, replace(asked, fixed_boundary=False)).control_mesh
    assert result.control_mesh.topology.vertex_count <= 1.3 * free.topology.vertex_count
    rims = [mesh.points[np.unique(mesh.topology.edge_vertices[mesh.topology.boundary_edges])] for mesh in meshes]
    for before, after in pairwise(rims):
        if len(before) == len(after):
            np.testing.assert_allclose(after, before, atol=1e-12)


@pytest.mark.parametrize(("scheme", "method"), [("loop", "geometric"), *((name, "auto") for name in FITTED)])
def test_creases_make_a_box_of_few_vertices(scheme: str, method: str, box: Target) -> None:
    result = fit_target(box, settings(method, 1e-3, scheme=scheme))
    assert result.status == "within_tolerance"
    assert result.measurement.crease is not None
    assert result.measurement.crease.max <= 1e-3
    assert len(result.control_mesh.topology.crease_edges) >= 12
    assert result.control_mesh.topology.vertex_count < 150


@EITHER
def test_without_creases_a_box_takes_twice_as_many(method: str, box: Target) -> None:
    smooth = replace(box, crease_edges=np.empty((0, 2), np.int64))
    with_creases, without = (fit_target(b, settings(method, 1e-3, max_iterations=40)) for b in (box, smooth))
    assert with_creases.control_mesh.topology.vertex_count < without.control_mesh.topology.vertex_count / 2


@pytest.mark.parametrize(("scheme", "method"), [("loop", "geometric"), *((name, "auto") for name in FITTED)])
def test_the_same_input_gives_the_same_output_on_any_number_of_threads(scheme: str, method: str, dome: Target) -> None:
    from subdfit import parallel

    results = []
    for count in (1, 2):
        parallel.set_threads(count)
        results.append(fit_target(dome, settings(method, 3e-3, scheme=scheme)).control_mesh)
    parallel.set_threads(None)
    assert np.array_equal(results[0].points, results[1].points)
    assert np.array_equal(results[0].topology.face_vertices, results[1].topology.face_vertices)


def bent(dome: Target) -> np.ndarray:
    """A dome's points without its symmetries, as multiples of 2^-20: many motions move them without rounding."""
    points = dome.points + 0.1 * np.sin(dome.points @ [[1.0, 0.5, 1.7], [2.0, -1.3, 0.2], [0.3, 2.0, 1.0]])
    return np.asarray(np.round(points * 2**20) / 2**20, np.float64)


@EITHER
def test_size_and_place_do_not_matter(method: str, dome: Target) -> None:
    """Moved without rounding, every decision is the same; with rounding, the tolerance is met as cheaply."""
    points, asked = bent(dome), settings(method, 2e-3)
    near = fit_target(mesh_target(points, dome.triangles, creases="none"), asked)
    exact = np.array([3e6, -2e6, 1e6])
    far = fit_target(mesh_target(1024 * points + exact, dome.triangles, creases="none"), asked)
    assert np.array_equal(far.control_mesh.topology.face_vertices, near.control_mesh.topology.face_vertices)
    rounding = np.spacing(np.abs(exact).max())
    np.testing.assert_allclose(far.control_mesh.points - exact, 1024 * near.control_mesh.points, atol=rounding, rtol=0)
    assert far.measurement.max == near.measurement.max
    assert far.measurement.rms == near.measurement.rms
    # Whether conjugate gradients take a step more may hang on the last digit: paths part, what they cost hardly does.
    target = mesh_target(1000 * points + np.pi * exact, dome.triangles, creases="none")
    rounded = fit_target(target, asked)
    found = Projector(LimitSurface(rounded.control_mesh, "loop")).certain(target.points)
    assert found.distance.max() <= 2e-3 * target.diagonal
    vertices = [fit.control_mesh.topology.vertex_count for fit in (near, rounded)]
    assert vertices[1] == pytest.approx(vertices[0], rel=0.03)


def test_progress_gives_a_usable_mesh_at_every_iteration(dome: Target) -> None:
    seen: list[Progress] = []
    result = fit_target(dome, settings("geometric", 1e-3), seen.append)
    assert [p.iteration for p in seen] == [row.iteration for row in result.history]
    for p in seen:
        assert LimitSurface(p.control_mesh, "loop").vertex_limits().shape == (p.control_vertices, 3)


def test_an_interrupt_gives_the_best_so_far(dome: Target) -> None:
    def stop(p: Progress) -> None:
        if p.iteration == 3:
            raise KeyboardInterrupt

    result = fit_target(dome, settings("auto", 1e-6), stop)
    assert result.status == "interrupted"
    assert not result.certified
    assert result.measurement.max == pytest.approx(min(row.max for row in result.history), rel=0.05)


@pytest.mark.parametrize("method", ["auto", "geometric"])
def test_a_budget_is_kept_and_said(ball: Target, method: str) -> None:
    result = fit_target(ball, settings(method, 1e-7, control_vertices=50, max_control_vertices=70, max_iterations=30))
    assert result.status == "best_effort"
    assert not result.certified
    assert 50 < max(row.control_vertices for row in result.history) <= 70


def test_an_unknown_method_is_refused(ball: Target) -> None:
    with pytest.raises(InputError, match="unknown method"):
        fit_target(ball, settings("magic", 1e-3))


def test_a_surface_that_covers_a_hole_is_not_certified(dome: Target, ball: Target) -> None:
    whole = fit_target(ball, settings("auto", 2e-3)).control_mesh
    frame = Frame.of(dome.points)
    surface = LimitSurface(whole.with_points(frame.inside(whole.points)), "loop")
    found = measure(surface, dome.normalised(frame), 0.02, frame.diagonal)
    assert found.max < 5e-3
    assert found.reverse_max > 0.1
    assert not found.certifies(Tolerance(max=5e-3))


def test_a_mean_alone_is_certified_on_both_sides_or_not_at_all(dome: Target, ball: Target) -> None:
    whole = fit_target(ball, settings("auto", 2e-3)).control_mesh
    frame = Frame.of(dome.points)
    surface = LimitSurface(whole.with_points(frame.inside(whole.points)), "loop")
    found = measure(surface, dome.normalised(frame), 0.02, frame.diagonal)
    asked = Tolerance(mean=5e-3)
    assert asked.met(found.max, found.rms, found.mean)
    assert not found.certifies(asked)


def test_of_states_whose_data_hold_that_is_kept_which_strays_least(dome: Target) -> None:
    """The certificate asks for no curves: one that a curve keeps from being within tolerance may be certified."""
    inside = dome.normalised(Frame.of(dome.points))
    rough, good = (
        FitState.start(FitData.of(inside, 0.1), LimitSurface(start_mesh(inside, count, 1e-3), "loop"))
        for count in (20, 60)
    )
    off = good.curve_distances.max()
    bound = (max(good.errors.max, good.errors.excess) + off) / 2
    assert max(good.errors.max, good.errors.excess) < bound < off
    assert rough.errors.max > bound

    class Judge(Tangential):
        strays = 0.0

        def stray(self, state: FitState) -> float:
            return self.strays

    asked = settings("auto", bound)
    judge, run = Judge(asked), _Run(inside, asked, None)
    for state, strays in ((rough, 0.5), (good, 3.0), (rough, 0.1), (replace(good), 2.0), (replace(good), 2.5)):
        judge.strays = strays
        run.record("fit", state, judge)
        if state is rough and strays == 0.5:
            assert run.best is rough
    assert run.best is not rough
    assert run.best_iteration == 3
    wider = replace(asked, tolerance=Tolerance(max=2 * off))
    run.settings = wider
    judge.strays = 9.0
    run.record("fit", good, judge)
    assert run.best is good
    judge.strays = 4.0
    run.record("fit", replace(good), judge)
    best = run.best
    run.disproved(good, 20.0)
    assert run.best_standing == (0, 4.0)
    run.disproved(best, 6.0)
    judge.strays = 5.0
    last = replace(good)
    run.record("fit", last, judge)
    assert run.best is last


def test_a_fit_goes_on_that_is_within_tolerance_by_its_own_account_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    target = mesh_target(*can(sections=16, rows=3), creases=30.0)
    told = []

    class Blind(Tangential):
        """Sees nothing that strays until it is told to."""

        def stray(self, state: FitState) -> float:
            return super().stray(state) if told else 0.0

        def look_closer(self) -> None:
            told.append(True)
            super().look_closer()

    monkeypatch.setitem(METHODS, "auto", Blind)
    result = fit_target(target, settings("auto", 2e-3, scheme="loop"))
    assert told
    assert result.certified
