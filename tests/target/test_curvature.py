"""Curvature by the normal cycle, against surfaces of known curvature and integrals in closed form."""

import numpy as np
import pytest
import trimesh

from shapes import grids, slivers
from subdfit.errors import InputError
from subdfit.target.curvature import ball_curvature, curvature_field, principal_curvature, signed_angles
from subdfit.target.features import mesh_edges

SHAPES = {"cylinder": slivers.cylinder, "torus": slivers.torus}


def degrees_between(a, b):
    """Angle between undirected unit vectors."""
    return np.degrees(np.arccos(np.clip(np.abs(np.sum(a * b, axis=1)), 0, 1)))


def direction_errors(shape, radius=None):
    found = curvature_field(shape.points, shape.triangles, radius).at_vertices()
    return degrees_between(found.minimum_direction, shape.minimum_direction)


def worst_aspect(shape):
    """95th percentile of the longest side over the height on it."""
    corners = shape.points[shape.triangles]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return np.percentile(sides**2 / area, 95)


@pytest.mark.parametrize("stretch", [0.3, 1.0, 3.0])
@pytest.mark.parametrize("name", SHAPES)
def test_directions_on_slivers(name, stretch):
    shape = SHAPES[name](3000, stretch)
    errors = direction_errors(shape)
    assert worst_aspect(shape) > 7
    assert np.median(errors) <= 3.0
    assert np.percentile(errors, 95) <= 10.0


@pytest.mark.parametrize("name", SHAPES)
def test_converges_under_refinement(name):
    """With balls that shrink more slowly than the triangles: radius ~ sqrt(h), h ~ 1 / sqrt(count)."""
    counts, directions, values = np.array([1000, 4000, 16000]), [], []
    for count in counts:
        shape = SHAPES[name](count, 2.0)
        found = curvature_field(shape.points, shape.triangles, 1.6 * count**-0.25).at_vertices()
        directions.append(np.median(degrees_between(found.minimum_direction, shape.minimum_direction)))
        values.append(np.median(np.abs(found.maximum - shape.maximum) + np.abs(found.minimum - shape.minimum)))
    for errors in (directions, values):
        rate = -np.diff(np.log(errors)) / np.diff(np.log(np.sqrt(counts)))
        assert np.all(rate > 0.7)


def test_sign_follows_the_orientation():
    mesh = trimesh.creation.icosphere(4, radius=2.0)
    outward = curvature_field(mesh.vertices, mesh.faces).at_vertices()
    inward = curvature_field(mesh.vertices, mesh.faces[:, ::-1]).at_vertices()
    np.testing.assert_allclose(outward.maximum, 0.5, rtol=0.02)
    np.testing.assert_allclose(inward.minimum, -0.5, rtol=0.02)
    assert np.all(outward.isotropic())


def test_interpolates_between_vertices():
    shape = slivers.torus(6000, 1.0)
    rng = np.random.default_rng(1)
    triangle = rng.integers(len(shape.triangles), size=2000)
    uv = rng.dirichlet([1, 1, 1], size=2000)[:, 1:]
    found = curvature_field(shape.points, shape.triangles).at(triangle, uv)
    weights = np.column_stack([1 - uv.sum(axis=1), uv])
    corners = shape.triangles[triangle]
    along = np.einsum("kc,kcd->kd", weights, shape.minimum_direction[corners])
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    assert np.median(degrees_between(found.minimum_direction, along)) < 1.0
    np.testing.assert_allclose(np.median(found.maximum), 2.5, rtol=0.05)
    np.testing.assert_allclose(np.sum(found.normal * found.maximum_direction, axis=1), 0, atol=1e-12)


def test_rotates_and_scales_with_the_mesh():
    shape = slivers.torus(1500, 1.0)
    rotation = np.array([[2.0, -2.0, 1.0], [1.0, 2.0, 2.0], [-2.0, -1.0, 2.0]]) / 3.0
    here = curvature_field(shape.points, shape.triangles, 0.3)
    there = curvature_field(100.0 * shape.points @ rotation.T, shape.triangles, 30.0)
    np.testing.assert_allclose(100.0 * there.tensors, rotation @ here.tensors @ rotation.T, atol=1e-8)


@pytest.mark.parametrize("distance", [0.0, 0.3, 0.8])
def test_ball_across_a_fold_has_its_closed_form(distance):
    """Two half planes at an angle: the tensor is the angle times a chord's weighted length over the weighted area."""
    angle, radius = 0.7, 1.0
    x, y = np.meshgrid(np.linspace(-2, 2, 9), np.linspace(-2, 2, 9), indexing="ij")
    x = np.where(np.abs(x) < 1.9, x + 0.1 * np.sin(7 * y) * (np.abs(x) > 0.01), x)
    over = np.maximum(x, 0)
    points = np.stack([x - over + over * np.cos(angle), y, -over * np.sin(angle)], -1).reshape(-1, 3)
    triangles = grids.triangles_of(grids.vertices(9, 9)).astype(np.int32)
    centre = np.array([[-distance, 0.123, 0.0]])
    inside = np.argmin(np.linalg.norm(points[triangles].mean(axis=1) - centre, axis=1))
    edges = mesh_edges(points, triangles)
    tensors, normals = ball_curvature(
        points, triangles, edges, centre, np.array([inside], np.int32), np.array([radius])
    )
    # Area by fine sums over both half planes, in their own coordinates.
    s = (np.arange(4000) + 0.5) / 1000 - 2
    S, T = np.meshgrid(s, s)
    squares = (
        np.where(S <= 0, (S + distance) ** 2, (S * np.cos(angle) + distance) ** 2 + (S * np.sin(angle)) ** 2) + T**2
    )
    area = np.sum(np.maximum(1 - squares, 0)) / 1000**2
    expected = angle * 4 / 3 * (1 - distance**2) ** 1.5 / area
    assert np.trace(tensors[0]) == pytest.approx(expected, rel=1e-4)
    assert principal_curvature(tensors, normals).minimum[0] == pytest.approx(0.0, abs=1e-12)


def test_a_wall_hides_what_is_beyond():
    mesh = trimesh.creation.box(extents=(1.0, 1.0, 1.0)).subdivide().subdivide().subdivide()
    points, triangles = np.asarray(mesh.vertices), np.asarray(mesh.faces, np.int32)
    edges = mesh_edges(points, triangles)
    centres = points[triangles].mean(axis=1)
    seeds, radii = np.arange(len(triangles), dtype=np.int32), np.full(len(triangles), 0.3)
    walled, normals = ball_curvature(points, triangles, edges, centres, seeds, radii, edges.angle > 45)
    np.testing.assert_allclose(walled, 0, atol=1e-12)
    assert np.all(np.abs(normals).max(axis=1) > 1 - 1e-12)
    open_, _ = ball_curvature(points, triangles, edges, centres, seeds, radii)
    assert np.abs(open_).max() > 1


def test_another_sheet_does_not_count():
    shape = slivers.cylinder(1000, 1.0)
    alone = curvature_field(shape.points, shape.triangles, 0.5)
    both = np.concatenate([shape.points, shape.points * [0.97, 0.97, 1]])
    shell = np.concatenate([shape.triangles, shape.triangles[:, ::-1] + len(shape.points)])
    np.testing.assert_array_equal(curvature_field(both, shell, 0.5).tensors[: len(alone.tensors)], alone.tensors)


def test_angles_are_positive_where_convex():
    mesh = trimesh.creation.box()
    edges = mesh_edges(mesh.vertices, mesh.faces)
    assert set(np.round(signed_angles(mesh.vertices, mesh.faces, edges)).tolist()) == {0.0, 90.0}
    inside_out = mesh.faces[:, ::-1]
    assert signed_angles(mesh.vertices, inside_out, mesh_edges(mesh.vertices, inside_out)).min() == pytest.approx(-90)


def test_isolated_vertices_have_no_curvature():
    mesh = trimesh.creation.icosphere(1)
    field = curvature_field(np.vstack([mesh.vertices, [[9.0, 9, 9]]]), mesh.faces)
    assert not field.tensors[-1].any()
    assert not field.normals[-1].any()


def test_a_radius_must_be_positive():
    mesh = trimesh.creation.icosphere(1)
    with pytest.raises(InputError, match="radius"):
        curvature_field(mesh.vertices, mesh.faces, 0.0)
