"""Laws of hole filling: closed, manifold, oriented, and as flat or small as can be."""

import initial_laws as laws
import numpy as np
import pytest

from subdfit.errors import InputError
from subdfit.initial import fill_holes, keep_components


def without(points, triangles, rows):
    """Take triangles out, and the points that only they used."""
    left = np.delete(triangles, rows, axis=0)
    used, renamed = np.unique(left, return_inverse=True)
    return points[used], renamed.reshape(-1, 3)


def test_missing_triangles_of_a_closed_mesh_come_back():
    points, triangles = laws.sphere(3)
    filled = fill_holes(*without(points, triangles, [0, 100, 300]), 3)
    assert (filled.filled, filled.left) == (3, 0)
    assert laws.shape_of(len(filled.points), filled.triangles) == laws.Shape(1, 0, 2)
    assert {tuple(np.sort(t)) for t in filled.triangles} == {tuple(np.sort(t)) for t in triangles}


def test_hole_in_a_plane_is_filled_in_the_plane_without_overlap():
    points, triangles = laws.square(12)
    centre = points[triangles].mean(axis=1)
    inside = np.flatnonzero(np.linalg.norm(centre[:, :2] - 0.45, axis=1) < 0.25)
    holed = without(points, triangles, inside)
    filled = fill_holes(*holed, 40)
    assert (filled.filled, filled.left) == (1, 1)
    assert len(filled.points) == len(holed[0])
    areas = laws.normals(filled.points, filled.triangles)[:, 2]
    assert abs(areas.sum()) == pytest.approx(abs(laws.normals(points, triangles)[:, 2].sum()), rel=1e-12)
    assert len(set(np.sign(areas[np.abs(areas) > 1e-12]))) == 1


def test_only_loops_up_to_the_limit_are_filled():
    points, triangles = laws.annulus(3, 10)
    for limit, filled, left in ((9, 0, 2), (10, 2, 0)):
        result = fill_holes(points, triangles, limit)
        assert (result.filled, result.left) == (filled, left)
        shape = laws.shape_of(len(result.points), result.triangles)
        assert shape == laws.Shape(1, left, 2 - left)


def test_area_is_least_on_a_saddle_quadrilateral():
    corners = np.array([[0, 0, 0], [2, 0, 0.0], [2, 2, 0], [0, 2, 0]], float)
    points = np.concatenate([corners, corners * 2 - [1, 1, 1]])
    i, j = np.arange(4), (np.arange(4) + 1) % 4
    triangles = np.concatenate([np.stack([i, i + 4, j], axis=1), np.stack([j, i + 4, j + 4], axis=1)])
    result = fill_holes(points, triangles, 4)
    assert laws.shape_of(8, result.triangles) == laws.Shape(1, 0, 2)
    areas = 0.5 * np.linalg.norm(laws.normals(result.points, result.triangles[len(triangles) :]), axis=1)
    assert areas.sum() == pytest.approx(4 + 16)


def test_hole_whose_every_chord_is_taken_gets_a_centre():
    i = np.arange(7)
    torus = np.concatenate([np.stack([i, (i + 1) % 7, (i + 3) % 7], 1), np.stack([i, (i + 3) % 7, (i + 2) % 7], 1)])
    points = np.random.default_rng(0).normal(size=(7, 3))
    assert laws.shape_of(7, torus) == laws.Shape(1, 0, 0)
    star = np.flatnonzero((torus == 6).any(axis=1))
    result = fill_holes(*without(points, torus, star), 6)
    assert laws.shape_of(7, result.triangles) == laws.Shape(1, 0, 0)
    np.testing.assert_allclose(result.points[6], points[:6].mean(axis=0))


def test_lone_triangle_and_tetrahedron_without_two_faces_become_closed_surfaces():
    lone = fill_holes(np.eye(3), [[0, 1, 2]], 3)
    assert laws.shape_of(len(lone.points), lone.triangles) == laws.Shape(1, 0, 2)
    assert len(lone.points) == 4
    points, triangles = laws.tetrahedron()
    open_book = fill_holes(points, triangles[:2], 4)
    assert laws.shape_of(len(open_book.points), open_book.triangles) == laws.Shape(1, 0, 2)
    assert len(open_book.points) == 4


@pytest.mark.parametrize("name", ["holes", "plane_holes", "bunny"])
def test_real_holes_are_closed(meshes, name):
    points, triangles = laws.read(meshes, name)
    before = laws.shape_of(len(points), triangles)
    result = fill_holes(points, triangles, 60)
    after = laws.shape_of(len(result.points), result.triangles)
    assert after.loops == result.left == before.loops - result.filled
    assert after.euler == before.euler + result.filled
    np.testing.assert_array_equal(result.points[: len(points)], points)
    np.testing.assert_array_equal(result.triangles[: len(triangles)], triangles)


def test_dragon_holes_are_closed(meshes):
    kept = keep_components(*laws.read(meshes, "dragon"), 1)
    result = fill_holes(kept.points, kept.triangles, 50)
    assert (result.filled, result.left) == (252, 5)
    assert laws.loop_lengths(result.triangles)[0] > 50
    again = fill_holes(result.points, result.triangles, 50)
    assert again.filled == 0


def test_bad_input_is_refused():
    points, triangles = laws.tetrahedron()
    with pytest.raises(InputError, match="edge"):
        fill_holes(points, np.concatenate([triangles, triangles]), 4)
    with pytest.raises(InputError, match="not finite"):
        fill_holes(points * np.inf, triangles, 4)
