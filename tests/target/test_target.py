"""The target brings it together."""

import numpy as np
import pytest
import trimesh

from subdfit.errors import InputError
from subdfit.target.target import mesh_target, point_target


def test_a_box_with_an_isolated_point():
    mesh = trimesh.creation.box(extents=(1.0, 2.0, 2.0)).subdivide()
    points = np.concatenate([mesh.vertices, [[50.0, 0.0, 0.0]]])
    target = mesh_target(points, mesh.faces)
    assert target.is_mesh
    assert target.diagonal == pytest.approx(3.0)
    assert len(target.used) == len(points) - 1
    assert len(target.crease_edges) == 24
    assert target.boundary_tree is None
    assert target.crease_tree is target.crease_tree is not None
    assert target.tree.closest(np.array([[0.0, 0.0, 1.5]])).distance[0] == pytest.approx(0.5)
    assert target.crease_tree.closest(np.array([[0.0, 0.0, 1.0]])).distance[0] == pytest.approx(0.5)
    assert target.faceting < 1e-14


def test_creases_by_choice():
    mesh = trimesh.creation.box().subdivide()
    assert len(mesh_target(mesh.vertices, mesh.faces, creases="none").crease_edges) == 0
    assert len(mesh_target(mesh.vertices, mesh.faces, creases=60.0).crease_edges) == 24
    assert len(mesh_target(mesh.vertices, mesh.faces, creases=95.0).crease_edges) == 0


def test_creases_within_run_along_the_surface():
    mesh = trimesh.creation.icosphere(4)
    target = mesh_target(mesh.vertices, mesh.faces)
    assert target.creased_within(np.empty((0, 2, 3))) is target
    ends = np.array([[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]])
    creased = target.creased_within(ends)
    assert np.linalg.norm(creased.within, axis=2) == pytest.approx(1.0, abs=0.01)
    np.testing.assert_allclose(creased.within[[0, -1], [0, 1]], ends[0], atol=1e-12)
    np.testing.assert_array_equal(creased.within[1:, 0], creased.within[:-1, 1])
    assert creased.crease_tree is not None
    middle = creased.crease_tree.closest(np.array([[0.6, 0.6, 0.0]])).distance[0]
    assert middle == pytest.approx(1 - 0.6 * np.sqrt(2), abs=0.01)
    assert creased.creased_within(np.empty((0, 2, 3))).crease_tree is None


def test_an_open_surface_has_a_boundary_search():
    target = mesh_target(np.eye(3), np.array([[0, 1, 2]]))
    assert target.boundary_edges.tolist() == [[0, 1], [1, 2], [2, 0]]
    assert target.boundary_tree is not None
    found = target.boundary_tree.closest(np.array([[0.5, 0.5, -1.0]]))
    assert found.segment[0] == 0
    assert found.parameter[0] == pytest.approx(0.5)


def test_points_only():
    points = np.random.default_rng(0).uniform(size=(20, 3))
    target = point_target(points)
    assert not target.is_mesh
    assert target.diagonal == pytest.approx(np.linalg.norm(np.ptp(points, axis=0)))
    assert target.boundary_tree is target.crease_tree is None
    assert not target.normals.any()
    np.testing.assert_array_equal(point_target(points, points).normals, points)


def test_bad_targets_are_named():
    face = np.array([[0, 1, 2]])
    with pytest.raises(InputError, match="no triangles"):
        mesh_target(np.eye(3), np.empty((0, 3), int))
    with pytest.raises(InputError, match=r"outside 0\.\.2"):
        mesh_target(np.eye(3), face + 1)
    with pytest.raises(InputError, match=r"point 2 .* not finite"):
        mesh_target(np.diag([1.0, 1.0, np.inf]), face)
    with pytest.raises(InputError, match="coincide"):
        mesh_target(np.ones((3, 3)), face)
    with pytest.raises(InputError, match="three coordinates"):
        point_target(np.empty((0, 3)))
    with pytest.raises(InputError, match="one a point"):
        point_target(np.eye(3), np.eye(2))
