"""The sagitta against the surfaces that meshes stand for."""

import numpy as np
import pytest
import trimesh

from subdfit.target.faceting import sagitta
from subdfit.target.features import crease_edges
from subdfit.target.normals import face_normals, sector_normals, vertex_normals

NO_EDGES = np.empty((0, 2), int)


def sphere_sagitta(mesh):
    """The true distance of each facet from the unit sphere: it is largest at the foot of the centre."""
    normals = face_normals(mesh.vertices, mesh.faces)
    return 1.0 - np.einsum("fk,fk->f", normals, mesh.vertices[mesh.faces[:, 0]])


def test_sphere_error_is_of_higher_order():
    errors = []
    for level in (2, 3, 4):
        mesh = trimesh.creation.icosphere(level)
        true = sphere_sagitta(mesh)
        errors.append(np.abs(sagitta(mesh.vertices, mesh.faces, NO_EDGES) - true).max())
        assert errors[-1] < 0.15 * true.max()
    assert errors[0] / errors[1] > 3.5
    assert errors[1] / errors[2] > 3.5


def test_cylinder_with_creased_rims():
    sections, radius = 48, 2.0
    mesh = trimesh.creation.cylinder(radius, 5.0, sections=sections)
    found = sagitta(mesh.vertices, mesh.faces, crease_edges(mesh.vertices, mesh.faces, 45.0))
    side = np.abs(face_normals(mesh.vertices, mesh.faces)[:, 2]) < 0.5
    true = radius * (1.0 - np.cos(np.pi / sections))
    np.testing.assert_allclose(found[side], true, rtol=0.2)
    assert found[~side].max() < 1e-12


def test_creases_are_not_curvature():
    mesh = trimesh.creation.box().subdivide().subdivide()
    creases = crease_edges(mesh.vertices, mesh.faces, 45.0)
    assert sagitta(mesh.vertices, mesh.faces, creases).max() < 1e-15
    assert sagitta(mesh.vertices, mesh.faces, creases[:, ::-1]).max() < 1e-15
    assert sagitta(mesh.vertices, mesh.faces, NO_EDGES).max() > 0.01


def test_sagitta_scales_and_does_not_move_with_the_model():
    mesh = trimesh.creation.torus(3.0, 1.0)
    base = sagitta(mesh.vertices, mesh.faces, NO_EDGES)
    moved = sagitta(1e3 * np.asarray(mesh.vertices) + 7.0, mesh.faces, NO_EDGES)
    np.testing.assert_allclose(moved, 1e3 * base, rtol=1e-9)


@pytest.mark.parametrize(
    ("name", "low", "high"), [("fandisk", 0.05, 0.15), ("rocker-arm", 0.08, 0.2), ("casting", 0.1, 0.2)]
)
def test_real_models_are_in_the_known_range(meshes, name, low, high):
    mesh = trimesh.load(meshes / f"{name}.ply", process=False)
    found = sagitta(mesh.vertices, mesh.faces, crease_edges(mesh.vertices, mesh.faces, 45.0))
    top = 100.0 * np.percentile(found, 99.9) / np.linalg.norm(mesh.extents)
    assert low < top < high


def test_normals_of_a_sphere_and_of_isolated_points():
    mesh = trimesh.creation.icosphere(3)
    points = np.concatenate([mesh.vertices, [[9.0, 9.0, 9.0]]])
    normals = vertex_normals(points, mesh.faces)
    assert np.sum(normals[:-1] * mesh.vertices, axis=1).min() > 0.9999
    np.testing.assert_array_equal(normals[-1], 0.0)


def test_sectors_without_smooth_edges_are_the_faces():
    mesh = trimesh.creation.icosphere(1)
    normals = sector_normals(mesh.vertices, mesh.faces, NO_EDGES, NO_EDGES)
    expected = np.repeat(face_normals(mesh.vertices, mesh.faces)[:, None], 3, axis=1)
    np.testing.assert_allclose(normals, expected, atol=1e-14)
