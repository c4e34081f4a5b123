"""Samples aimed at what faces like the surface: at slits."""

import numpy as np
import pytest

from subdfit.fit.aim import FARTHER, AimedSamples
from subdfit.fit.data import FitData
from subdfit.fit.reverse import Samples, strays
from subdfit.fit.spots import Spot
from subdfit.fit.state import FitState
from subdfit.fit.tangent import TangentSettings
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.target.target import Target, mesh_target

WIDTH, NEAR = 0.2, 0.08
"""Of the slit, and how far from one of its walls the samples lie."""


@pytest.fixture(scope="module")
def slit() -> Target:
    """Walls y = 0 and y = `WIDTH`, facing one another, and the slit's end between them at x = 0, facing along x."""
    points = np.array([(x, y, z) for y in (0, WIDTH) for x in (0, 2) for z in (-1, 1)], np.float64)
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]]
    return mesh_target(points, np.array(faces), creases=30.0)


def across(x: float, back: bool = False) -> LimitSurface:
    """Two triangles across the slit that face along x, or back."""
    points = np.array([(x, -1, -1), (x, 1, -1), (x, 1, 1), (x, -1, 1)], np.float64)
    faces = [[0, 1, 2], [0, 2, 3]]
    mesh = ControlMesh.from_triangles(points, [face[::-1] for face in faces] if back else faces)
    mesh.topology.corner_sharpness[:] = np.inf
    return LimitSurface(mesh, "loop")


def sample(surface: LimitSurface, target: Target) -> Samples:
    """A sample so near to a wall that this is nearest."""
    uv = np.array([[u, v] for u in np.linspace(0.02, 0.96, 95) for v in np.linspace(0.02, 0.96 - u, 95) if v > 0])
    face = np.zeros(len(uv), np.int32)
    place = surface.evaluate(face, uv).position
    best = np.argmin(np.abs(place[:, 1] - NEAR) + np.abs(place[:, 2]))
    return Samples.of(surface, target, face[[best]], uv[[best]])


@pytest.mark.parametrize("times", [1.2, 0.9 * FARTHER])
def test_what_crosses_a_slit_is_drawn_to_its_end(slit: Target, times: float) -> None:
    surface = across(times * NEAR)
    nearest = sample(surface, slit)
    aimed = AimedSamples.aim(nearest, surface, slit, np.inf)
    np.testing.assert_allclose(nearest.normal, [[0, -1, 0]], atol=1e-9)
    np.testing.assert_allclose(aimed.normal, [[-1, 0, 0]], atol=1e-9)
    np.testing.assert_allclose(aimed.gap, times * NEAR, rtol=1e-9)
    moved = surface.with_points(surface.control_mesh.points - [0.01, 0, 0])
    np.testing.assert_allclose(aimed.renewed(moved, slit).gap, times * NEAR - 0.01, rtol=1e-9)


def test_nothing_is_aimed_farther_than_asked(slit: Target) -> None:
    surface = across(1.2 * NEAR)
    nearest = sample(surface, slit)
    aimed = AimedSamples.aim(nearest, surface, slit, 1.1 * NEAR)
    np.testing.assert_array_equal(aimed.normal, nearest.normal)


def folded(depth: float) -> ControlMesh:
    """The slit's walls from x = 1 to 0 and its end, in small triangles; the middle of the end lies at x = `depth`."""
    along = np.linspace(1, 0, 13)
    profile = [(x, WIDTH) for x in along] + [(depth, WIDTH / 2)] + [(x, 0.0) for x in along[::-1]]
    points = np.array([(x, y, z) for x, y in profile for z in np.linspace(-0.5, 0.5, 9)])
    low = (np.arange(len(profile) - 1)[:, None] * 9 + np.arange(8)).ravel()
    faces = np.concatenate([np.column_stack([low, low + 9, low + 10]), np.column_stack([low, low + 10, low + 1])])
    return ControlMesh.from_triangles(points, faces)


def test_a_spot_leaves_a_slit_that_the_nearest_would_hold_it_in() -> None:
    bound = 0.05
    mesh = folded(0.0)
    target = mesh_target(mesh.points, mesh.topology.face_vertices.reshape(-1, 3), creases="none")
    surface = LimitSurface(folded(0.2), "loop")
    moving = np.abs(surface.control_mesh.points[:, 1] - WIDTH / 2) < 0.11
    state = FitState.start(FitData.of(target, 1.0).subset(np.empty(0, np.int64)), surface)
    spot = Spot(state, np.ones(surface.domain.face_count, np.bool_), moving, 3, TangentSettings(), bound)

    def farthest(points: np.ndarray) -> float:
        return float(strays(surface.with_points(points), target, bound, share=0.0).gap.max())

    before = farthest(surface.control_mesh.points)
    assert before > 1.5 * bound
    nearest = spot._settled(state, spot._samples(state), 1.0)
    assert farthest(nearest.surface.control_mesh.points) > 0.95 * before
    assert farthest(spot.moved(1.0)) < 0.5 * bound


@pytest.mark.parametrize(("times", "back"), [(1.2, True), (1.2 * FARTHER, False)])
def test_where_nothing_near_faces_alike_the_nearest_draws(slit: Target, times: float, back: bool) -> None:
    surface = across(times * NEAR, back)
    nearest = sample(surface, slit)
    aimed = AimedSamples.aim(nearest, surface, slit, np.inf)
    np.testing.assert_array_equal(aimed.normal, nearest.normal)
    np.testing.assert_array_equal(aimed.gap, nearest.gap)
