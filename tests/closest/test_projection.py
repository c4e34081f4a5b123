"""Footpoints on limit surfaces: never farther than brute force, never farther than their start."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from shapes.parameters import size
from shapes.zoo import ZOO, mesh_of, scattered
from subdfit.closest.curves import SurfaceCurves
from subdfit.closest.projection import Projector
from subdfit.errors import InputError
from subdfit.initial import decimate
from subdfit.io import read
from subdfit.limit import LimitSurface
from subdfit.limit.tessellate import lattice
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.repair import mend
from subdfit.target.frame import Frame


def _surface(name: str) -> LimitSurface:
    mesh = mesh_of(name)
    return LimitSurface(ControlMesh(mesh.topology, mesh.points / size(mesh)), "loop")


def _loop_shapes() -> list[str]:
    accepted = []
    for name in ZOO:
        try:
            _surface(name)
        except InputError:
            continue
        accepted.append(name)
    return accepted


@pytest.mark.parametrize("name", _loop_shapes())
def test_certain_footpoints_are_as_near_as_brute_force(name: str) -> None:
    surface = _surface(name)
    rng = np.random.default_rng(7)
    queries = rng.uniform(-1, 1, (200, 3)) + surface.control_mesh.points.mean(axis=0)
    found = Projector(surface).certain(queries)
    fine = lattice(surface.domain, 24)
    vertices = surface.evaluate(fine.face, fine.uv).position
    brute = np.linalg.norm(queries[:, None] - vertices[None], axis=2).min(axis=1)
    assert np.all(found.distance <= brute + 1e-6)


@pytest.mark.parametrize("name", ["icosahedron", "octahedron"])
def test_distance_is_that_of_the_named_footpoint(name: str) -> None:
    surface = _surface(name)
    queries = np.random.default_rng(3).normal(size=(500, 3))
    found = Projector(surface).nearest(queries)
    position = surface.evaluate(found.face, found.uv).position
    np.testing.assert_allclose(np.linalg.norm(position - queries, axis=1), found.distance, atol=1e-12)
    assert found.converged.all()


def test_points_on_the_surface_find_themselves() -> None:
    surface = _surface("icosahedron")
    rng = np.random.default_rng(5)
    face = rng.integers(0, surface.domain.face_count, 1000)
    uv = rng.dirichlet([1, 1, 1], 1000)[:, 1:]
    points = surface.evaluate(face, uv).position
    assert Projector(surface).nearest(points).distance.max() < 1e-7


@pytest.mark.parametrize("second", [False, True])
def test_no_footpoint_ends_farther_than_it_began(second: bool) -> None:
    mesh = scattered(mesh_of("icosahedron"), 3)
    surface = LimitSurface(mesh, "loop")
    rng = np.random.default_rng(11)
    queries = rng.normal(size=(400, 3))
    face = rng.integers(0, surface.domain.face_count, 400).astype(np.int32)
    uv = rng.dirichlet([1, 1, 1], 400)[:, 1:].copy()
    before = np.linalg.norm(surface.evaluate(face, uv).position - queries, axis=1)
    after = Projector(surface, second_order=second).refine(queries, face, uv)
    assert np.all(after.distance <= before + 1e-15)
    inside = after.uv.min(axis=1) >= 0
    assert inside.all()
    assert np.all(after.uv.sum(axis=1) <= 1 + 1e-12)


def test_the_gap_is_normal_to_a_smooth_closed_surface() -> None:
    surface = _surface("icosahedron")
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


@pytest.mark.parametrize("inner", [False, True])
def test_curve_footpoints_match_a_dense_sampling(inner: bool) -> None:
    name = "annulus" if not inner else "crease ring"
    if name not in ZOO:
        name = next(n for n in ZOO if len(SurfaceCurves(_surface(n), inner)) > 3)
    surface = _surface(name)
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
