"""Short edges shrunk to points: what is left, and how it remembers what it was."""

import numpy as np
import pytest
import trimesh

from shapes import slivers
from subdfit.mesh.short_edges import without_short_edges


def shrunk(points, triangles, least):
    return without_short_edges(np.asarray(points), np.asarray(triangles), least, np.ones(len(points)))


@pytest.mark.parametrize("shape", ["torus", "cylinder"])
def test_what_is_left_is_a_manifold_of_the_same_kind(shape):
    """A torus has a handle, an open cylinder two boundaries."""
    mesh = getattr(slivers, shape)(2000, 4.0)
    before = trimesh.Trimesh(mesh.points, mesh.triangles, process=False)
    coarse = shrunk(mesh.points, mesh.triangles, 0.1)
    after = trimesh.Trimesh(coarse.points, coarse.triangles, process=False)
    assert len(after.faces) < 0.7 * len(before.faces)
    assert after.euler_number == before.euler_number
    assert after.is_watertight == before.is_watertight
    assert after.is_winding_consistent
    if shape == "cylinder":
        assert len(after.outline().entities) == len(before.outline().entities)
    assert np.mean(after.edges_unique_length < 0.1) < 0.02


def test_means_vertices_and_triangles_are_remembered():
    mesh = slivers.torus(1000, 4.0)
    coarse = shrunk(mesh.points, mesh.triangles, 0.1)
    for k in range(len(coarse.points)):
        np.testing.assert_allclose(coarse.points[k], mesh.points[coarse.merged == k].mean(axis=0), atol=1e-12)
    np.testing.assert_array_equal(coarse.merged[mesh.triangles[coarse.rows]], coarse.triangles)


def test_heavy_vertices_stay():
    mesh = trimesh.creation.icosphere(3)
    weights = np.ones(len(mesh.vertices))
    weights[:12] = 1e9
    coarse = without_short_edges(mesh.vertices, mesh.faces, 0.2, weights)
    assert len(coarse.points) < len(mesh.vertices)
    np.testing.assert_allclose(coarse.points[coarse.merged[:12]], mesh.vertices[:12], atol=1e-8)


@pytest.mark.parametrize(
    ("faces", "left"),
    [([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], 4), ([[0, 2, 1], [0, 1, 3]], 1), ([[0, 2, 1]], 1)],
)
def test_something_is_left_of_the_smallest_meshes(faces, left):
    """Of a tetrahedron, two triangles, and one."""
    assert len(shrunk(np.eye(4)[:, :3], np.array(faces), 9.0).triangles) == left


def test_long_edges_stay():
    mesh = trimesh.creation.icosphere(1)
    np.testing.assert_array_equal(shrunk(mesh.vertices, mesh.faces, 1e-3).triangles, mesh.faces)
