"""The sagitta against the surfaces that meshes stand for."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from subdfit.target.faceting import rises, sagitta
from subdfit.target.features import crease_edges, mesh_edges
from subdfit.target.normals import face_normals, sector_normals, vertex_normals
from subdfit.target.target import mesh_target

NO_EDGES = np.empty((0, 2), int)
TURN = 2 * np.pi


def sphere(level):
    mesh = trimesh.creation.icosphere(level)
    places = np.random.default_rng(1).standard_normal((4000, 3))
    normals = places / np.linalg.norm(places, axis=1, keepdims=True)
    return mesh.vertices, mesh.faces, normals, normals


def uneven_sphere(level):
    points = np.random.default_rng(0).standard_normal((60 * 4**level, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    triangles = ConvexHull(points).simplices
    inward = np.linalg.det(points[triangles]) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return points, triangles, *sphere(0)[2:]


def torus(level):
    mesh = trimesh.creation.torus(3.0, 1.0, major_sections=10 * 2**level, minor_sections=5 * 2**level)
    u, v = np.random.default_rng(1).uniform(0, TURN, (2, 4000))
    along, up = np.stack([np.cos(u), np.sin(u), 0 * u], 1), np.array([0.0, 0.0, 1.0])
    normals = np.cos(v)[:, None] * along + np.sin(v)[:, None] * up
    return mesh.vertices, mesh.faces, 3 * along + normals, normals


def capped_cylinder(level):
    """Its rims are creases, and its caps fans of long triangles."""
    mesh = trimesh.creation.cylinder(1.0, 2.0, sections=10 * 2**level)
    u, v = np.random.default_rng(1).uniform(0, 1, (2, 4000))
    round_, up = np.stack([np.cos(TURN * u), np.sin(TURN * u), 0 * u], 1), np.array([0.0, 0.0, 1.0])
    side, cap = round_ + (2 * v - 1)[:, None] * up, np.sqrt(v)[:, None] * round_ + up
    return mesh.vertices, mesh.faces, np.concatenate([side, cap]), np.concatenate([round_, np.tile(up, (4000, 1))])


@pytest.mark.parametrize(
    ("shape", "share"), [(sphere, 0.15), (torus, 0.2), (capped_cylinder, 0.1), (uneven_sphere, 0.65)]
)
def test_the_true_surface_is_allowed_and_no_other(shape, share):
    """Points on it, coarse or fine, lie off the facets by what is allowed there; offset, by as much more."""
    for level in (1, 2, 3):
        points, triangles, places, normals = shape(level)
        target = mesh_target(points, triangles, creases=45.0)
        assert target.gaps(places).max() <= share * target.faceting
        off = 2.0 * target.faceting
        gaps = target.gaps(places + off * normals)
        assert gaps.min() > 0.49 * off
        assert np.median(gaps) > 0.98 * off


def test_sphere_error_is_of_higher_order():
    errors = []
    for level in (1, 2, 3):
        points, triangles, places, _ = sphere(level)
        errors.append(np.abs(mesh_target(points, triangles).gaps(places)).max())
    assert errors[0] / errors[1] > 3.5
    assert errors[1] / errors[2] > 3.5


@pytest.mark.parametrize("shape", [torus, capped_cylinder])
def test_what_is_allowed_is_the_same_from_both_sides_of_an_edge_and_nothing_at_vertices(shape):
    points, triangles, _, _ = shape(1)
    target = mesh_target(points, triangles, creases=45.0)
    edges = mesh_edges(points, triangles)
    found = []
    for side in range(2):
        triangle = edges.faces[:, side]
        low, high = (triangles[triangle] == edges.vertices[:, end, None] for end in range(2))
        weight = 0.3 * low + 0.7 * high
        found.append(target.sagitta(triangle, weight[:, 1:]))
    np.testing.assert_allclose(found[0], found[1], atol=1e-14)
    assert found[0].max() > 0.8 * target.faceting
    for corner in ([0.0, 0.0], [1.0, 0.0], [0.0, 1.0]):
        assert not target.sagitta(np.arange(len(triangles)), np.tile(corner, (len(triangles), 1))).any()


def test_creases_are_not_curvature():
    mesh = trimesh.creation.box().subdivide().subdivide()
    creases = crease_edges(mesh.vertices, mesh.faces, 45.0)
    for edges, low, high in ((creases, 0, 1e-15), (creases[:, ::-1], 0, 1e-15), (NO_EDGES, 0.01, 1)):
        assert low <= sagitta(rises(mesh.vertices, mesh.faces, edges)).max() < high


@pytest.mark.parametrize("height", [0.1, 0.3, 1.0, 2.0, 6.0])
@pytest.mark.parametrize("rim", ["crease", "smooth", "double"])
def test_a_tip_is_not_curvature(height, rim):
    """The facets of a cone reach from rim to tip: along them it is straight, and only in the rim does it lie off."""
    sections = 64
    angle = TURN * np.arange(sections) / sections
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(sections)])
    points = np.concatenate([ring, [[0.0, 0.0, height], [0.0, 0.0, -height if rim == "double" else 0.0]]])
    here = np.arange(sections)
    there = np.roll(here, -1)
    up = np.column_stack([here, there, np.full(sections, sections)])
    down = np.column_stack([there, here, np.full(sections, sections + 1)])
    edges = np.column_stack([here, there])
    found = rises(points, np.concatenate([up, down]), NO_EDGES if rim == "smooth" else edges)
    # Between the rim and its chords.
    assert sagitta(found).max() <= 1.1 * (1 - np.cos(TURN / 2 / sections))


def test_sagitta_scales_and_does_not_move_with_the_model():
    mesh = trimesh.creation.torus(3.0, 1.0)
    base = rises(mesh.vertices, mesh.faces, NO_EDGES)
    moved = rises(1e3 * np.asarray(mesh.vertices) + 7.0, mesh.faces, NO_EDGES)
    np.testing.assert_allclose(moved, 1e3 * base, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "low", "high"), [("fandisk", 0.05, 0.15), ("rocker-arm", 0.08, 0.2), ("casting", 0.1, 0.2)]
)
def test_real_models_are_in_the_known_range(meshes, name, low, high):
    mesh = trimesh.load(meshes / f"{name}.ply", process=False)
    found = sagitta(rises(mesh.vertices, mesh.faces, crease_edges(mesh.vertices, mesh.faces, 45.0)))
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
