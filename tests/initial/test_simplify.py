"""Simplification: the count asked for or the error allowed, the same topology, data points where they were."""

import clouds
import numpy as np
import pytest
from initial_laws import shape_of
from scipy.spatial import cKDTree

import subdfit
from subdfit.initial.reconstruct import reconstruct
from subdfit.initial.simplify import CLOSE_ENOUGH, simplify
from subdfit.target.bvh import TriangleTree

SUBSET = pytest.mark.parametrize("keep", [False, True], ids=["best points", "data points"])


@pytest.fixture(scope="module")
def torus():
    found = reconstruct(clouds.torus(3000))
    return found.points, found.triangles


def distances(points, simple):
    return TriangleTree(simple.points, simple.triangles).closest(points).distance


@SUBSET
@pytest.mark.parametrize("count", [2000, 300, 40])
def test_count_and_topology(torus, keep, count):
    points, triangles = torus
    simple = simplify(points, triangles, vertices=count, keep_points=keep)
    assert len(simple.points) == count
    assert shape_of(count, simple.triangles) == shape_of(len(points), triangles)
    assert simple.error == pytest.approx(distances(points, simple).max())


@SUBSET
def test_boundaries_stay(keep):
    found = reconstruct(clouds.square(2000, hole=0.2))
    simple = simplify(found.points, found.triangles, vertices=200, keep_points=keep)
    assert shape_of(200, simple.triangles) == shape_of(len(found.points), found.triangles)


def test_data_points_are_kept_to_the_last_bit(torus):
    points, triangles = torus
    offset = points * 1e-3 + [1e4, -3.0, 7.0]
    simple = simplify(offset, triangles, vertices=250, keep_points=True)
    np.testing.assert_array_equal(offset[simple.point_rows], simple.points)
    assert len(np.unique(simple.point_rows)) == 250


def test_free_points_are_nearer_than_data_points(torus):
    points, triangles = torus
    free, kept = (simplify(points, triangles, vertices=300, keep_points=keep) for keep in (False, True))
    assert free.point_rows is None
    assert cKDTree(points).query(free.points)[0].max() > 1e-6
    assert np.sqrt(np.mean(distances(points, free) ** 2)) < np.sqrt(np.mean(distances(points, kept) ** 2))


@SUBSET
def test_tolerance_holds_and_is_used(torus, keep):
    points, triangles = torus
    simple = simplify(points, triangles, max_error=0.02, keep_points=keep)
    assert distances(points, simple).max() <= 0.02
    assert shape_of(len(simple.points), simple.triangles) == shape_of(len(points), triangles)
    below = simplify(points, triangles, vertices=int(len(simple.points) / CLOSE_ENOUGH**2), keep_points=keep)
    assert len(simple.points) < 0.5 * len(points)
    assert below.error > 0.02


def test_count_is_the_least_where_both_are_asked_for(torus):
    points, triangles = torus
    assert len(simplify(points, triangles, vertices=1000, max_error=0.05).points) == 1000
    assert len(simplify(points, triangles, vertices=20, max_error=0.02).points) > 100


def test_a_tolerance_below_the_sampling_leaves_the_points(torus):
    points, triangles = torus
    simple = simplify(points, triangles, max_error=1e-9, keep_points=True)
    np.testing.assert_array_equal(simple.points, points)
    assert simple.error == 0.0


def test_poisson_passes_near_noisy_points(meshes):
    pytest.importorskip("open3d", reason="the extra poisson is not installed")
    found = subdfit.reconstruct(meshes / "mechpart_points_synthetic_noisy.ply", method="poisson")
    shape = shape_of(len(found.mesh.points), found.mesh.face_vertices.reshape(-1, 3))
    assert (shape.components, shape.loops, shape.euler) == (1, 0, -4)
    points = subdfit.read(meshes / "mechpart_points_synthetic_noisy.ply").points
    tree = TriangleTree(found.mesh.points, found.mesh.face_vertices.reshape(-1, 3))
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    assert np.sqrt(np.mean(tree.closest(points).distance ** 2)) < 0.003 * diagonal


def test_poisson_is_trimmed_where_there_are_no_points():
    pytest.importorskip("open3d", reason="the extra poisson is not installed")
    points = clouds.sphere(6000)
    bowl = np.concatenate([points[points[:, 2] < 0.3], [[0.0, 0.0, 1.5]]])
    found = subdfit.reconstruct(bowl, method="poisson")
    mesh = found.mesh
    assert found.left_out.tolist() == [len(bowl) - 1]
    tree = TriangleTree(mesh.points, mesh.face_vertices.reshape(-1, 3))
    assert found.error == pytest.approx(tree.closest(bowl[:-1]).distance.max())
    assert mesh.points[:, 2].max() < 0.45
    assert shape_of(len(mesh.points), mesh.face_vertices.reshape(-1, 3)).loops == 1
    assert np.abs(np.linalg.norm(mesh.points, axis=1) - 1).max() < 0.05


def test_a_missing_open3d_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "open3d", None)
    with pytest.raises(subdfit.InputError, match=r"pip install 'subdfit\[poisson\]'"):
        subdfit.reconstruct(clouds.sphere(200), method="poisson")
