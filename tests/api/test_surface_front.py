"""`subdfit.LimitSurface` and `subdfit.subdivide`: the surface is the same however one asks."""

import numpy as np
import pytest

import subdfit
from subdfit.api import memory
from subdfit.errors import InputError

POINTS = np.vstack([np.eye(3), -np.eye(3)]) * [3.0, 2.0, 1.0]
FACES = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])


@pytest.fixture(scope="module")
def cage():
    return subdfit.ControlMesh.from_triangles(POINTS, FACES, crease_edges=[[0, 1], [1, 3]], corner_vertices=[4])


@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_closest_points_of_points_off_the_surface(cage, offset):
    surface = subdfit.LimitSurface(cage.with_points(cage.points + offset))
    drawn = surface.tessellate(3)
    found = surface.closest(drawn.points + 1e-3 * drawn.normals)
    assert found.distance.max() <= 1e-3 * (1 + 1e-4)
    again = surface.closest(surface.evaluate(found.face, found.uv).position)
    assert again.distance.max() < 1e-7


def test_closest_refuses_what_are_no_points(cage):
    surface = subdfit.LimitSurface(cage)
    for bad in ([1.0, 2.0, 3.0], [[np.nan, 0, 0]]):
        with pytest.raises(InputError, match="finite points"):
            surface.closest(bad)


@pytest.mark.parametrize("level", [0, 1, 3])
def test_tessellation_lies_on_the_surface(cage, level):
    drawn = subdfit.LimitSurface(cage).tessellate(level)
    assert len(drawn.triangles) == 8 * 4**level
    assert len(drawn.points) == 2 + 4 * 4**level
    np.testing.assert_allclose(np.linalg.norm(drawn.normals, axis=1), 1.0)
    outward = np.einsum("ij,ij->i", drawn.normals, drawn.points)
    assert (outward > 0).all()


@pytest.mark.parametrize("level", [-1, 9, 1.5])
def test_levels_that_cannot_be(cage, level):
    with pytest.raises(InputError, match="level"):
        subdfit.LimitSurface(cage).tessellate(level)


def test_a_surface_of_anything_that_holds_a_cage(cage, tmp_path):
    path = tmp_path / "cage.obj"
    subdfit.write(path, cage)
    kinds = (path, subdfit.read(path), cage)
    first, *others = (subdfit.LimitSurface(kind).tessellate(2).points for kind in kinds)
    for other in others:
        np.testing.assert_array_equal(other, first)


def test_subdividing_leaves_the_limit_surface(cage):
    fine = subdfit.subdivide(cage, 2)
    assert fine.topology.face_count == 8 * 16
    assert len(fine.topology.crease_edges) == 2 * 4
    assert fine.scheme == "loop"
    found = subdfit.LimitSurface(cage).closest(subdfit.LimitSurface(fine).tessellate(1).points)
    assert found.distance.max() < 1e-7


def test_subdividing_at_limit_positions(cage):
    fine = subdfit.subdivide(cage, 2, limit=True)
    expected = subdfit.LimitSurface(subdfit.subdivide(cage, 2)).vertex_limits()
    np.testing.assert_allclose(fine.points, expected)
    assert fine.scheme is None
    assert subdfit.LimitSurface(cage).closest(fine.points).distance.max() < 1e-7
    np.testing.assert_array_equal(subdfit.subdivide(cage, 0).points, cage.points)


@pytest.mark.parametrize("levels", [-1, 1.5, 40, 7])
def test_levels_of_subdivision_that_cannot_be(cage, levels, monkeypatch):
    """The last would need more memory than the machine has."""
    monkeypatch.setattr(memory, "machine_memory", lambda: 256 * 2**20)
    with pytest.raises(InputError, match="levels"):
        subdfit.subdivide(cage, levels)


def test_writing_refuses_what_is_no_mesh(tmp_path):
    with pytest.raises(InputError, match="cannot write a str"):
        subdfit.write(tmp_path / "x.obj", "mesh")
