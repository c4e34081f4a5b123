"""Samples aimed at what faces like the surface: at slits."""

import numpy as np
import pytest

from subdfit.fit.aim import FARTHEST, AimedSamples
from subdfit.fit.reverse import Samples
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
    return Samples.of(surface, target, face[best:][:1], uv[best:][:1])


@pytest.mark.parametrize("times", [1.2, 0.9 * FARTHEST])
def test_what_crosses_a_slit_is_drawn_to_its_end(slit: Target, times: float) -> None:
    surface = across(times * NEAR)
    nearest = sample(surface, slit)
    aimed = AimedSamples.aim(nearest, surface, slit)
    np.testing.assert_allclose(nearest.normal, [[0, -1, 0]], atol=1e-9)
    np.testing.assert_allclose(aimed.normal, [[-1, 0, 0]], atol=1e-9)
    np.testing.assert_allclose(aimed.gap, times * NEAR, rtol=1e-9)
    moved = surface.with_points(surface.control_mesh.points - [0.01, 0, 0])
    np.testing.assert_allclose(aimed.renewed(moved, slit).gap, times * NEAR - 0.01, rtol=1e-9)


@pytest.mark.parametrize(("times", "back"), [(1.2, True), (1.2 * FARTHEST, False)])
def test_where_nothing_near_faces_alike_the_nearest_draws(slit: Target, times: float, back: bool) -> None:
    surface = across(times * NEAR, back)
    nearest = sample(surface, slit)
    aimed = AimedSamples.aim(nearest, surface, slit)
    np.testing.assert_array_equal(aimed.normal, nearest.normal)
    np.testing.assert_array_equal(aimed.gap, nearest.gap)
