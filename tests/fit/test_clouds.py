"""Fits to clouds: judged by the points alone, whatever mesh was made of them."""

import numpy as np
import pytest

import subdfit
from shapes.zoo import euler
from subdfit.api.measuring import compare
from subdfit.fit.data import FitData
from subdfit.fit.state import FitState
from subdfit.fit.strays import Strays
from subdfit.fit.tangent import huber
from subdfit.limit.surface import LimitSurface
from subdfit.measure import far_points, outliers
from subdfit.mesh.topology import Topology
from subdfit.target.target import cloud_target, mesh_target


def random_sphere(count, seed=0):
    points = np.random.default_rng(seed).standard_normal((count, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def distances(result, points):
    """Distances by a search of its own, as shares of the diagonal."""
    found = subdfit.LimitSurface(result.control_mesh).closest(points).distance
    return found / result.measurement.diagonal


def radius_error(result):
    count = result.surface.domain.face_count
    fine = result.surface.evaluate(np.arange(count), np.full((count, 2), 0.3))
    return np.abs(np.linalg.norm(fine.position, axis=1) - 1)


def test_every_point_lies_within_the_tolerance():
    points = random_sphere(3000)
    result = subdfit.fit(points, max_error="0.1%", robust=0)
    assert result.certified
    assert len(result.measurement.excluded) == 0
    assert distances(result, points).max() <= 1e-3 * (1 + 1e-6)
    assert radius_error(result).max() < 3e-3 * result.measurement.diagonal
    assert result.control_mesh.topology.vertex_count < 300


def test_outliers_are_left_out_and_listed():
    points = random_sphere(3000)
    wild = np.arange(100, 3000, 300)
    points[wild] *= np.linspace(1.1, 1.6, len(wild))[:, None]
    result = subdfit.fit(points, max_error="0.2%")
    assert result.certified
    assert set(wild) <= set(result.measurement.excluded.tolist())
    document = result.to_dict()
    assert document["errors"]["excluded"] == len(document["excluded_rows"]) <= 0.005 * 3000
    kept = np.delete(points, document["excluded_rows"], axis=0)
    assert distances(result, kept).max() <= 2e-3 * (1 + 1e-6)
    assert radius_error(result).max() < 4e-3 * result.measurement.diagonal


def test_components_are_those_of_the_surface_through_the_points(caplog):
    """Two balls, a stray point near each, one row repeated: what is nearer to the smaller one is as if it were not."""
    large, small = random_sphere(1500), 0.4 * random_sphere(300, seed=1) + [3, 0, 0]
    points = np.concatenate([small, [[3.6, 0, 0]], large, [[1.2, 0, 0]], large[:1], small[:1]])
    with caplog.at_level("INFO"):
        result = subdfit.fit(points, max_error="0.5%", keep_components=1)
    ours = np.r_[301:1803]
    assert result.certified
    np.testing.assert_array_equal(result.target.used, ours)
    assert len(result.distances) == len(ours)
    assert result.to_dict()["excluded_rows"] == [1801]
    assert any("kept 1 of 2 components, left 300 points out" in message for message in caplog.messages)
    alone = subdfit.fit(points[ours], max_error="0.5%")
    np.testing.assert_allclose(alone.distances, result.distances, atol=1e-12)
    found = subdfit.measure(result.control_mesh, points, keep_components=1)
    np.testing.assert_allclose(found.footpoints.distance, result.measurement.footpoints.distance, atol=1e-9)
    mesh = subdfit.reconstruct(points, keep_components=1)
    np.testing.assert_array_equal(mesh.left_out, np.r_[0:301, 1801])


def test_nothing_is_left_out_where_that_is_not_allowed():
    points = random_sphere(2000)
    points[5] *= 1.3
    result = subdfit.fit(points, max_error="0.2%", robust=0, max_control_vertices=150)
    assert result.status == "best_effort"
    assert result.measurement.max > 0.01
    assert result.to_dict()["errors"]["excluded"] == 0


def test_meshes_leave_out_nothing_unless_told(ball):
    points = ball.points.copy()
    points[17] *= 1.3
    target = (points, ball.triangles)
    # So thin a spike cannot be followed with so few control vertices.
    untold = subdfit.fit(target, max_error="0.2%", max_control_vertices=150)
    told = subdfit.fit(target, max_error="0.2%", robust="0.1%", max_control_vertices=150)
    assert untold.status == "best_effort"
    assert len(untold.measurement.excluded) == 0
    assert told.status == "within_tolerance"
    assert 17 in told.measurement.excluded
    assert told.measurement.max <= 0.002 < untold.measurement.max / 2


def test_noise_judged_by_rms_is_smoothed_not_followed():
    rng = np.random.default_rng(1)
    sigma = 0.01
    points = random_sphere(6000) * (1 + sigma * rng.standard_normal((6000, 1)))
    result = subdfit.fit(points, rms_error=1.1 * sigma)
    assert result.status == "within_tolerance"
    assert result.control_mesh.topology.vertex_count < 400
    assert np.sqrt(np.mean(radius_error(result) ** 2)) < 0.5 * sigma


def test_an_open_surface_covers_its_ragged_boundary():
    points = random_sphere(6000)
    points = points[points[:, 2] > 0]
    result = subdfit.fit(points, max_error="0.2%")
    assert result.certified
    kept = np.delete(np.arange(len(points)), result.measurement.excluded)
    assert distances(result, points[kept]).max() <= 2e-3 * (1 + 1e-6)
    topology = result.control_mesh.topology
    assert euler(topology) == 1
    assert result.control_mesh.points[:, 2].min() > -0.15


def test_holes_of_the_surface_through_the_points_are_closed():
    points = random_sphere(800)
    points = points[points[:, 2] < 0.9]
    filled = subdfit.fit(points, max_error="2%", fill_holes=100)
    assert filled.certified
    assert len(filled.distances) == len(points)
    topology = filled.control_mesh.topology
    assert euler(topology) == 2
    found = subdfit.measure(filled.control_mesh, points, fill_holes=100)
    np.testing.assert_allclose(found.reverse_max, filled.measurement.reverse_max, rtol=1e-6)


def test_what_strays_between_the_points_is_not_certified():
    """A control vertex is lifted that moves the surface only where there are no points."""
    points = random_sphere(1000)
    points = points[np.linalg.norm(points - [0, 0, 1], axis=1) > 0.2]
    cage = subdfit.subdivide(subdfit.fit(points, max_error="1%", robust=0).control_mesh, 3)
    lifted = cage.points.copy()
    lifted[np.argmax(lifted[:, 2])] *= 1.2
    sound, crumpled = (compare(cage.with_points(p), points, max_error="1%") for p in (cage.points, lifted))
    assert sound.certified
    assert crumpled.status == "within_tolerance"
    assert not crumpled.certified


def test_cuts_that_make_the_surface_stray_are_taken_back():
    """To the state that strayed least, with its samples, though its control mesh is coarser than that of the last."""
    points = random_sphere(1000)
    target = cloud_target(points, subdfit.reconstruct(points).mesh.face_vertices.reshape(-1, 3))
    data, strays = FitData.of(target, spacing=1.0), Strays(1e-3)
    coarse = subdfit.fit((target.points, target.triangles), max_error="1%").control_mesh
    crumpled = subdfit.subdivide(coarse, 1).points.copy()
    crumpled[-1] *= 1.3
    fine = subdfit.subdivide(coarse, 1).with_points(crumpled)
    first, second = (FitState.start(data, LimitSurface(mesh)) for mesh in (coarse, fine))
    assert strays.taken_back(first) is first
    strays.to_cut(first, np.arange(3))
    assert strays.taken_back(second) is second
    assert len(strays.to_cut(second, np.arange(9))) == 0
    assert strays.taken_back(second) is first
    np.testing.assert_array_equal(strays.samples(first).gap, Strays(1e-3).samples(first).gap)


def test_beyond_a_ragged_rim_the_surface_may_reach_for_the_next_point():
    """In the plane of the triangle, by the length of the edge; above it by the sagitta, which is 0 on a plane."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [3, 3, 0]], float)
    target = cloud_target(points, [[0, 1, 2], [2, 1, 3]])
    queries = np.array([[0.3, -0.2, 0], [0.3, -0.2, 0.3], [0.3, -1.4, 0.3], [0.2, 0.3, 0.1], [1, 1, 0.2], [4, 4, 0]])
    found = target.tree.closest(queries)
    held = found.distance - target.allowance(queries, found)
    np.testing.assert_allclose(held, [0, 0.3, 0.5, 0.1, 0.2, 0], atol=1e-12)


@pytest.mark.parametrize("bound", [0.5, None])
def test_outliers_are_the_worst_beyond_the_bound_and_no_more_than_allowed(bound):
    distance = np.abs(np.random.default_rng(2).standard_normal(1000)) * 0.1
    distance[[3, 500, 999]] = [5.0, 7.0, 6.0]
    assert outliers(distance, 0.01, bound).tolist() == [3, 500, 999]
    assert outliers(distance, 0.002, bound).tolist() == [500, 999]
    assert outliers(distance, 0.0, bound).size == 0
    assert set(far_points(distance, bound)) >= {3, 500, 999}
    assert outliers(np.full(50, 0.4), 0.5, 0.5).size == 0


def test_huber_meets_its_tangent():
    d, scale = np.linspace(0, 3, 301), 1.0
    value = huber(d, scale)
    np.testing.assert_allclose(value[d <= 1], d[d <= 1] ** 2)
    np.testing.assert_allclose(np.diff(value)[d[:-1] >= 1], 2 * scale * 0.01)
    np.testing.assert_array_equal(huber(d, np.inf), d**2)


def test_points_off_the_triangles_count_and_are_suspects(ball):
    points = np.concatenate([ball.points, [[0.0, 0.0, 1.3]]])
    target = cloud_target(points, ball.triangles)
    assert target.used.tolist() == list(range(len(points)))
    data = FitData.of(target, spacing=1e-3)
    assert data.vertices == len(data.points) == len(points)
    assert data.suspects.tolist() == [len(points) - 1]
    guide = mesh_target(ball.points, ball.triangles)
    state = FitState.start(data, LimitSurface(subdfit.fit((guide.points, guide.triangles)).control_mesh))
    assert state.errors.max > 0.29
    assert state.excusing(1e-3, 0.05).errors.max < 0.05
    assert state.excusing(0.0, 0.05) is state


def test_real_clouds(meshes):
    smooth = subdfit.fit(meshes / "kitten_points.ply", max_error="0.2%")
    noisy = subdfit.fit(meshes / "mechpart_points_synthetic_noisy.ply", rms_error="0.25%")
    sparse = subdfit.fit(meshes / "cactus_points.ply", max_error="0.2%", scheme="doo-sabin")
    assert sparse.measurement.reverse_max < 0.005
    for result, most in ((smooth, 500), (noisy, 900), (sparse, 300)):
        assert result.certified
        assert result.control_mesh.topology.vertex_count <= most
        assert len(result.measurement.excluded) <= 0.005 * len(result.target.points)
    topology = smooth.control_mesh.topology
    assert isinstance(topology, Topology)
    assert euler(topology) == 0
