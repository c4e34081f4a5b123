"""Footpoints on limit surfaces: never farther than brute force, never farther than their start."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from shapes.parameters import SOME, inside, size
from shapes.zoo import mesh_of, scattered
from subdfit.closest.curves import SurfaceCurves
from subdfit.closest.projection import Projector
from subdfit.initial import decimate
from subdfit.io import read
from subdfit.limit import LimitSurface
from subdfit.limit.tessellate import lattice
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.repair import mend
from subdfit.target.frame import Frame

BOTH = [("loop", "icosahedron"), ("catmull-clark", "extruded")]


def _surface(name: str, scheme: str = "loop") -> LimitSurface:
    mesh = mesh_of(name)
    return LimitSurface(ControlMesh(mesh.topology, mesh.points / size(mesh)), scheme)


@pytest.mark.parametrize(("scheme", "name"), SOME)
def test_certain_footpoints_are_as_near_as_brute_force(scheme: str, name: str) -> None:
    surface = _surface(name, scheme)
    rng = np.random.default_rng(7)
    queries = rng.uniform(-1, 1, (200, 3)) + surface.control_mesh.points.mean(axis=0)
    found = Projector(surface).certain(queries)
    fine = lattice(surface.domain, 24 if scheme == "loop" else 16)
    brute, _ = cKDTree(surface.evaluate(fine.face, fine.uv).position).query(queries)
    assert np.all(found.distance <= brute + 1e-6)


@pytest.mark.parametrize("name", ["rhombic 2", "quad fan 2"])
@pytest.mark.parametrize("scheme", ["catmull-clark", "doo-sabin"])
def test_nothing_nearer_is_missed_round_an_inner_vertex_of_two_faces(scheme: str, name: str) -> None:
    """The tree's triangulation may hold a triangle there twice, and leave as much of the surface without one."""
    surface = _surface(name, scheme)
    face, uv = inside(surface.domain, per_cell=40, margin=0.0)
    points = surface.evaluate(face, uv).position
    queries = points + np.random.default_rng(5).normal(scale=0.1, size=points.shape)
    found = Projector(surface).certain(queries)
    fine = lattice(surface.domain, 32)
    brute, _ = cKDTree(surface.evaluate(fine.face, fine.uv).position).query(queries)
    assert np.all(found.distance <= brute + 1e-6)
    assert Projector(surface).certain(points).distance.max() < 1e-6


@pytest.mark.parametrize(("scheme", "name"), BOTH)
def test_distance_is_that_of_the_named_footpoint(scheme: str, name: str) -> None:
    surface = _surface(name, scheme)
    queries = np.random.default_rng(3).normal(size=(500, 3))
    found = Projector(surface).nearest(queries)
    position = surface.evaluate(found.face, found.uv).position
    np.testing.assert_allclose(np.linalg.norm(position - queries, axis=1), found.distance, atol=1e-12)
    assert found.converged.all()


@pytest.mark.parametrize(("scheme", "name"), BOTH)
def test_points_on_the_surface_find_themselves(scheme: str, name: str) -> None:
    surface = _surface(name, scheme)
    face, uv = inside(surface.domain, per_cell=30, margin=0.0)
    points = surface.evaluate(face, uv).position
    assert Projector(surface).nearest(points).distance.max() < 1e-7


@pytest.mark.parametrize("second", [False, True])
@pytest.mark.parametrize(("scheme", "name"), BOTH)
def test_no_footpoint_ends_farther_than_it_began(scheme: str, name: str, second: bool) -> None:
    mesh = scattered(mesh_of(name), 3)
    surface = LimitSurface(mesh, scheme)
    face, uv = inside(surface.domain, per_cell=20, margin=0.0)
    face = face.astype(np.int32)
    queries = np.random.default_rng(11).normal(size=(len(face), 3))
    before = np.linalg.norm(surface.evaluate(face, uv).position - queries, axis=1)
    after = Projector(surface, second_order=second).refine(queries, face, uv)
    assert np.all(after.distance <= before + 1e-15)
    assert after.uv.min() >= 0
    reach = after.uv.max(axis=1) if scheme == "catmull-clark" else after.uv.sum(axis=1)
    assert np.all(reach <= 1 + 1e-12)


@pytest.mark.parametrize(("scheme", "name"), BOTH)
def test_the_gap_is_normal_to_a_smooth_closed_surface(scheme: str, name: str) -> None:
    surface = _surface(name, scheme)
    queries = 1.5 * np.random.default_rng(2).normal(size=(300, 3))
    found = Projector(surface).nearest(queries)
    value = surface.evaluate(found.face, found.uv, 1)
    assert value.first is not None
    gap = queries - value.position
    slope = np.einsum("kid,kd->ki", value.first, gap) / np.linalg.norm(value.first, axis=2)
    assert np.abs(slope).max() < 1e-6


def test_result_does_not_depend_on_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    from subdfit import parallel

    surface = _surface("icosahedron")
    queries = np.random.default_rng(1).normal(size=(20000, 3))
    results = []
    for count in (1, 3):
        parallel.set_threads(count)
        results.append(Projector(surface).certain(queries))
    parallel.set_threads(None)
    assert np.array_equal(results[0].face, results[1].face)
    assert np.array_equal(results[0].uv, results[1].uv)


@pytest.mark.parametrize(
    ("scheme", "name", "inner"),
    [
        ("loop", "annulus", False),
        ("loop", "crease ring", True),
        ("catmull-clark", "quad disc", False),
        ("catmull-clark", "prism crease", True),
    ],
)
def test_curve_footpoints_match_a_dense_sampling(scheme: str, name: str, inner: bool) -> None:
    surface = _surface(name, scheme)
    curves = SurfaceCurves(surface, inner)
    side = np.repeat(np.arange(len(curves)), 401)
    t = np.tile(np.linspace(0, 1, 401), len(curves))
    dense = surface.evaluate(*curves.locate(side, t)).position
    queries = dense[::57] + 0.02 * np.random.default_rng(4).normal(size=dense[::57].shape)
    found = curves.closest(queries)
    brute = np.linalg.norm(queries[:, None] - dense[None], axis=2).min(axis=1)
    assert np.all(found.distance <= brute + 1e-9)
    assert np.all(found.distance >= brute - 1e-2)


@pytest.mark.parametrize("model", ["bunny", "igea"])
def test_no_scanned_point_has_a_nearer_point_on_the_five_times_refined_surface(model: str, meshes: Path) -> None:
    data = mend(read(meshes / f"{model}.ply")).data
    frame = Frame.of(data.points)
    points = frame.inside(data.points)
    found = decimate(points, data.face_vertices.reshape(-1, 3), 1000)
    surface = LimitSurface(ControlMesh.from_triangles(found.points, found.triangles), "loop")
    fine = lattice(surface.domain, 2**5)
    vertices = surface.evaluate(fine.face, fine.uv).position
    queries = points[::5]
    brute, _ = cKDTree(vertices).query(queries)
    assert np.all(Projector(surface).certain(queries).distance <= brute + 1e-6)


def test_points_of_a_curve_keep_to_its_strand_where_two_run_side_by_side() -> None:
    """As at slits and at the rims of thin parts: the nearest strand is the wrong one once a point is half across."""
    width, count = 0.3, 11
    points = np.array([(x, y, 0.0) for y in (0.0, width) for x in range(count)])
    lower = np.arange(count - 1)
    triangles = np.concatenate(
        [np.stack([lower, lower + 1, lower + count], 1), np.stack([lower + 1, lower + 1 + count, lower + count], 1)]
    )
    curves = SurfaceCurves(LimitSurface(ControlMesh.from_triangles(points, triangles), "loop"), inner=False)
    queries = np.column_stack([np.linspace(2, 8, 50), np.full(50, 0.2), np.zeros(50)])
    along = np.tile([1.0, 0.0, 0.0], (50, 1))
    upper, own = curves.closest(queries), curves.closest(queries, along)
    assert np.allclose(upper.position[:, 1], width)
    assert np.allclose(own.position, queries - [0.0, 0.2, 0.0])
    near = curves.closest(queries, along, apart=0.11)
    assert np.array_equal(near.position, upper.position)
    unknown = curves.closest(queries, np.zeros_like(along))
    assert np.array_equal(unknown.position, upper.position)
