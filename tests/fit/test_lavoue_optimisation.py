"""Squared-distance optimisation: known surfaces found again, and faster than point to point (Figure 9)."""

from dataclasses import replace

import numpy as np
import pytest

import subdfit
from shapes import grids
from subdfit.errors import InputError
from subdfit.fit.lavoue_optimisation import distance_metric, optimise, refined_limit_rows
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.schemes import scheme_named
from subdfit.target.curvature import curvature_field
from subdfit.target.target import mesh_target, point_target

SCHEMES = {"loop": 0, "catmull-clark": 5, "quad-triangle": 2}
"""Rows of quads that are left whole, of five."""


def patch(scheme, n=6):
    """A wavy square of n x n control points, of quads, of triangles, or of both."""
    x, y = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    points = np.stack([x, y, 0.8 * np.sin(x) * np.cos(0.7 * y)], -1).reshape(-1, 3) / n
    whole, others = np.split(grids.quads_of(grids.vertices(n, n)), [SCHEMES[scheme] * (n - 1)])
    faces = [*whole, *grids.cut(others)]
    offsets = np.cumsum([0, *map(len, faces)])
    return ControlMesh(Topology.from_faces(offsets, np.concatenate(faces), n * n), points, scheme)


def dense(mesh):
    found = subdfit.LimitSurface(mesh).tessellate(4)
    target = mesh_target(found.points, found.triangles, creases="none")
    return target, curvature_field(target.points, target.triangles, 0.08)


def inner(mesh):
    return ~mesh.topology.boundary_vertices


def spoiled(mesh, size=0.12):
    """A bad start: inner control points pushed about, along the surface most of all."""
    moved = mesh.points.copy()
    rows = inner(mesh)
    moved[rows] += size * np.random.default_rng(2).uniform(-1, 1, (rows.sum(), 3)) * [1, 1, 0.6]
    return mesh.with_points(moved)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_rows_are_limits_after_refinement(scheme):
    mesh = patch(scheme)
    C = refined_limit_rows(mesh.topology, scheme_named(scheme), 2)
    np.testing.assert_allclose(C @ mesh.points, subdfit.subdivide(mesh, 2, limit=True).points, atol=1e-14)
    np.testing.assert_allclose(C.sum(axis=1), 1, atol=1e-14)


@pytest.mark.parametrize("size", [0.12, 0.7])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_figure_9(scheme, size):
    """From the same bad start the squared distance is ahead of the footpoints after one round and after five."""
    mesh = patch(scheme)
    target, field = dense(mesh)
    start, held = spoiled(mesh, size), ~inner(mesh)
    ours = optimise(start, target, field, fixed=held)
    theirs = optimise(start, target, field, fixed=held, metric="point")
    assert ours.mean[0] == theirs.mean[0] > 0.04 * size
    assert ours.mean[1] < theirs.mean[1]
    assert ours.mean[5] < 0.5 * theirs.mean[5]
    assert ours.mean[5] < 0.1 * ours.mean[0]


@pytest.mark.parametrize("scheme", SCHEMES)
def test_fixed_control_points_stay(scheme):
    mesh = patch(scheme)
    target, field = dense(mesh)
    held = ~inner(mesh)
    found = optimise(spoiled(mesh), target, field, fixed=held, rounds=2)
    np.testing.assert_array_equal(found.mesh.points[held], mesh.points[held])
    assert len(found.mean) == len(found.rms) == len(found.max) == 3


def test_the_best_round_is_kept_and_enough_is_enough():
    mesh = patch("loop")
    target, field = dense(mesh)
    held = ~inner(mesh)
    found = optimise(spoiled(mesh), target, field, fixed=held, enough=1e9)
    assert len(found.mean) == 1
    np.testing.assert_array_equal(found.mesh.points, spoiled(mesh).points)
    again = optimise(optimise(spoiled(mesh), target, field, fixed=held).mesh, target, field, fixed=held, rounds=3)
    final = optimise(again.mesh, target, field, fixed=held, rounds=0)
    assert final.mean[0] == again.mean.min()


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_surface_on_its_target_stays(scheme):
    mesh = patch(scheme)
    target, field = dense(mesh)
    found = optimise(mesh, target, field, fixed=~inner(mesh), rounds=1)
    assert np.abs(found.mesh.points - mesh.points).max() < 2e-3
    assert found.max[1] < 1e-3


def test_metric_is_the_squared_distance_to_a_sphere():
    """Second differences of the true squared distance, on the side where eq. 1 with unsigned radii is exact."""
    from trimesh.creation import icosphere

    ball = icosphere(5)
    field = curvature_field(ball.vertices, ball.faces, 0.15)
    face, uv = np.arange(40), np.full((40, 2), 1 / 3)
    foot = np.asarray(ball.vertices)[ball.faces[face]].mean(axis=1)
    normal = foot / np.linalg.norm(foot, axis=1, keepdims=True)
    for d, signed in ((0.3, False), (0.3, True), (-0.4, True)):
        metric = distance_metric(field, face, uv, d * normal, signed=signed)
        true = max(0.0, d / (1 + d))
        np.testing.assert_allclose(np.trace(metric, axis1=1, axis2=2), 1 + 2 * true, atol=0.02)
        np.testing.assert_allclose(np.einsum("ki,kij,kj->k", normal, metric, normal), 1, atol=0.01)


def test_bad_calls_are_refused():
    mesh = patch("loop")
    target, field = dense(mesh)
    with pytest.raises(InputError, match="faces"):
        optimise(mesh, point_target(mesh.points), field)
    with pytest.raises(InputError, match="metric"):
        optimise(mesh, target, field, metric="chamfer")
    with pytest.raises(InputError, match="rounds"):
        optimise(mesh, target, field, rounds=-1)
    with pytest.raises(InputError, match="fixed"):
        optimise(mesh, target, field, fixed=np.ones(3, np.bool_))
    with pytest.raises(InputError, match="bool"):
        optimise(mesh, target, field, fixed=np.ones(len(mesh.points), int))
    with pytest.raises(InputError, match="curvature"):
        optimise(mesh, target, replace(field, tensors=field.tensors[1:]))
