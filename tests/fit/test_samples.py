"""Parts of the data and samples of the surface: what takes part in a round of ``auto``."""

import numpy as np
import pytest

from subdfit.fit.data import FitData
from subdfit.fit.reverse import inner_samples, strays
from subdfit.fit.state import FitState
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.target.frame import Frame
from subdfit.target.target import Target


@pytest.fixture(scope="module")
def state(dome: Target) -> FitState:
    """A coarse dome under a dense one."""
    from subdfit.initial.start import start_mesh

    inside = dome.normalised(Frame.of(dome.points))
    mesh = start_mesh(inside, 60, 1e-3)
    return FitState.start(FitData.of(inside, 0.1), LimitSurface(mesh, "loop"))


def test_thinning_keeps_so_many_a_cell_and_every_curve_point(state: FitState) -> None:
    some, rows = state.thinned(4)
    count = np.bincount(state.face, minlength=state.surface.domain.face_count)
    inner = state.data.surface_rows
    kept = np.bincount(state.face[rows][inner[rows]], minlength=len(count))
    assert np.all(kept <= 4)
    assert np.all(kept[(np.bincount(state.face[~inner], minlength=len(count)) == 0) & (count >= 4)] == 4)
    assert np.array_equal(rows[some.data.boundary], state.data.boundary)
    assert np.array_equal(some.data.points, state.data.points[rows])
    assert np.array_equal(some.distance, state.distance[rows])
    everything, all_rows = state.thinned(10**6)
    assert everything.data is state.data
    assert np.array_equal(all_rows, np.arange(len(state.face)))


def test_following_a_part_gives_what_following_all_gives(state: FitState) -> None:
    points = 1.001 * state.surface.control_mesh.points
    some, rows = state.thinned(4)
    together, alone = state.followed(some.moved(points), rows), state.moved(points)
    np.testing.assert_allclose(together.distance, alone.distance, atol=1e-7)


def test_gaps_are_distances_beyond_the_allowance(state: FitState) -> None:
    target = state.data.target
    samples = inner_samples(state.surface, target, np.arange(state.surface.domain.face_count))
    place = state.surface.evaluate(samples.face, samples.uv).position
    found = target.tree.closest(place)
    beyond = np.maximum(found.distance - target.sagitta[found.triangle], 0.0)
    np.testing.assert_allclose(np.abs(samples.gaps(state.surface)), beyond, atol=1e-12)


def test_gaps_follow_the_surface_when_it_moves(state: FitState) -> None:
    step = 1e-3
    samples = inner_samples(state.surface, state.data.target, np.arange(state.surface.domain.face_count))
    moved = state.surface.with_points(state.surface.control_mesh.points + np.array([step, 0, 0]))
    place = moved.evaluate(samples.face, samples.uv).position
    true = state.data.target.tree.closest(place).distance
    height = np.einsum("kd,kd->k", samples.foot - place, samples.normal)
    assert np.median(np.abs(np.abs(height) - true)) < 0.02 * step


def test_strays_are_all_that_stray(state: FitState) -> None:
    bound = 1e-3
    found = strays(state.surface, state.data.target, bound)
    assert len(found)
    assert np.all(np.abs(found.gaps(state.surface)) > bound)
    assert len(strays(state.surface, state.data.target, 1.0)) == 0


def test_a_cloud_has_no_reverse_side() -> None:
    from subdfit.target.target import point_target

    points = np.random.default_rng(0).normal(size=(50, 3))
    mesh = ControlMesh.from_triangles(np.eye(4, 3), [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    assert len(strays(LimitSurface(mesh, "loop"), point_target(points), 1e-3)) == 0
