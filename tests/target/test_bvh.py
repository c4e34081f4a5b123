"""Closest points against brute force, and the laws of the tree."""

import numpy as np
import pytest
import trimesh

from subdfit import parallel
from subdfit.errors import InputError
from subdfit.target._bvh_build_kernels import STACK_SIZE
from subdfit.target._bvh_kernels import nearest
from subdfit.target.bvh import SegmentTree, TriangleTree


def on_segment(p, a, b):
    """Parameter of the closest point of the segment ab."""
    d = b - a
    return float(np.clip((p - a) @ d / (d @ d), 0.0, 1.0)) if d @ d > 0 else 0.0


def triangle_distance(p, a, b, c):
    """Distance of a point from a triangle, from its edges and, where the foot is inside, its plane."""
    best = min(np.linalg.norm(p - x - on_segment(p, x, y) * (y - x)) for x, y in ((a, b), (b, c), (c, a)))
    n = np.cross(b - a, c - a)
    sides = [np.cross(y - x, p - x) @ n for x, y in ((a, b), (b, c), (c, a))]
    if n @ n > 0 and min(sides) >= 0:
        best = min(best, abs((p - a) @ n) / np.linalg.norm(n))
    return best


def brute(points, triangles, queries):
    """All distances (q, m)."""
    return np.array([[triangle_distance(q, *points[t]) for t in triangles] for q in queries])


def place(points, triangles, found):
    """The closest points that the answer names."""
    a, b, c = (points[triangles[found.triangle, k]] for k in range(3))
    return a + found.uv[:, :1] * (b - a) + found.uv[:, 1:] * (c - a)


def soup(seed, count=60):
    """Random triangles, among them slivers, segments, points and repeated ones."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(40, 3))
    points[1] = points[0] + 1e-9
    points[3] = 0.5 * (points[2] + points[4])
    triangles = rng.integers(0, 40, (count, 3))
    triangles[:6] = [[0, 1, 5], [2, 3, 4], [6, 7, 7], [8, 8, 9], [10, 11, 10], [12, 12, 12]]
    triangles[6] = triangles[7]
    return points, triangles, rng.normal(size=(50, 3)) * 2.0


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_closest_agrees_with_brute_force(seed):
    points, triangles, queries = soup(seed)
    queries[:10] = points[:10]
    found = TriangleTree(points, triangles).closest(queries)
    np.testing.assert_allclose(found.distance, brute(points, triangles, queries).min(axis=1), atol=1e-14)
    gap = np.linalg.norm(place(points, triangles, found) - queries, axis=1)
    np.testing.assert_allclose(gap, found.distance, atol=1e-14)
    assert found.uv.min() >= 0.0
    assert found.uv.sum(axis=1).max() <= 1.0 + 1e-15


def test_closest_agrees_with_another_library_on_a_sphere():
    mesh = trimesh.creation.icosphere(3)
    queries = np.random.default_rng(0).normal(size=(40, 3))
    found = TriangleTree(mesh.vertices, mesh.faces).closest(queries)
    for query, distance in zip(queries, found.distance, strict=True):
        spots = trimesh.triangles.closest_point(mesh.triangles, np.tile(query, (len(mesh.faces), 1)))
        assert distance == pytest.approx(np.linalg.norm(spots - query, axis=1).min(), abs=1e-14)


def test_points_on_the_surface_of_a_scan_are_found(meshes):
    mesh = trimesh.load(meshes / "rocker-arm.ply", process=False)
    rng = np.random.default_rng(0)
    row = rng.integers(0, len(mesh.faces), 5000)
    weights = rng.dirichlet(np.ones(3), len(row))
    queries = np.einsum("qk,qkd->qd", weights, mesh.triangles[row])
    found = TriangleTree(mesh.vertices, mesh.faces).closest(queries)
    assert found.distance.max() < 1e-14 * mesh.scale
    same = found.triangle == row
    assert same.mean() > 0.99
    np.testing.assert_allclose(found.uv[same], weights[same, 1:], atol=1e-8)


def test_answers_do_not_depend_on_order_batch_or_threads():
    mesh = trimesh.creation.icosphere(4)
    tree = TriangleTree(mesh.vertices, mesh.faces)
    queries = np.random.default_rng(1).normal(size=(9000, 3))
    whole = tree.closest(queries)
    shuffle = np.random.default_rng(2).permutation(len(queries))
    shuffled = tree.closest(queries[shuffle])
    np.testing.assert_array_equal(shuffled.triangle, whole.triangle[shuffle])
    np.testing.assert_array_equal(shuffled.uv, whole.uv[shuffle])
    few = tree.closest(queries[:7])
    np.testing.assert_array_equal(few.distance, whole.distance[:7])
    before = parallel.threads()
    try:
        for threads in (1, 3):
            parallel.set_threads(threads)
            again = TriangleTree(mesh.vertices, mesh.faces).closest(queries)
            np.testing.assert_array_equal(again.triangle, whole.triangle)
            np.testing.assert_array_equal(again.distance, whole.distance)
    finally:
        parallel.set_threads(before)


def test_a_start_changes_no_distance():
    points, triangles, queries = soup(3)
    tree = TriangleTree(points, triangles)
    cold = tree.closest(queries)
    start = np.random.default_rng(0).integers(-1, len(triangles), len(queries))
    np.testing.assert_array_equal(tree.closest(queries, start=start).distance, cold.distance)
    np.testing.assert_array_equal(tree.closest(queries, start=cold.triangle).distance, cold.distance)


def test_refit_equals_a_new_tree():
    points, triangles, queries = soup(4)
    tree = TriangleTree(points, triangles)
    boxes = tree.boxes.copy()
    tree.refit(points)
    np.testing.assert_array_equal(tree.boxes, boxes)
    moved = points @ np.diag([1.0, -3.0, 0.2]) + 5.0
    tree.refit(moved)
    np.testing.assert_array_equal(
        tree.closest(queries).distance, TriangleTree(moved, triangles).closest(queries).distance
    )


def test_within_lists_exactly_the_inflated_triangles_in_reach():
    points, triangles, queries = soup(5)
    rng = np.random.default_rng(0)
    inflation, radii = rng.uniform(0.0, 0.8, len(triangles)), rng.uniform(0.0, 1.5, len(queries))
    bound = brute(points, triangles, queries) - inflation
    offsets, found, bounds = TriangleTree(points, triangles, inflation=inflation).within(queries, radii)
    assert offsets[-1] == len(found) > 100
    for q in range(len(queries)):
        mine = slice(offsets[q], offsets[q + 1])
        np.testing.assert_array_equal(np.sort(found[mine]), np.flatnonzero(bound[q] <= radii[q]))
        np.testing.assert_allclose(bounds[mine], bound[q, found[mine]], atol=1e-14)


def test_inflation_may_change_with_a_refit():
    points, triangles, queries = soup(6)
    tree = TriangleTree(points, triangles)
    inflation = np.full(len(triangles), 0.5)
    tree.refit(points, inflation=inflation)
    offsets, found, _ = tree.within(queries, np.full(len(queries), 0.25))
    expected = TriangleTree(points, triangles).within(queries, np.full(len(queries), 0.75))
    np.testing.assert_array_equal(offsets, expected[0])
    assert set(found) == set(expected[1])
    np.testing.assert_array_equal(
        tree.closest(queries).distance, TriangleTree(points, triangles).closest(queries).distance
    )


def test_what_is_near_enough_is_not_sought_further_and_what_is_not_is_exact():
    points, triangles, queries = soup(7)
    tree = TriangleTree(points, triangles)
    exact = tree.closest(queries)
    enough = float(np.median(exact.distance))
    found = tree.closest(queries, enough=enough)
    far = exact.distance > enough
    np.testing.assert_array_equal(found.distance[far], exact.distance[far])
    np.testing.assert_array_equal(found.triangle[far], exact.triangle[far])
    assert np.all(found.distance[~far] <= enough)
    assert np.any(found.distance[~far] > exact.distance[~far])


def test_the_kernel_seeks_only_strictly_nearer_triangles():
    points, triangles, queries = soup(7)
    tree = TriangleTree(points, triangles)
    nodes, bounds = np.empty(STACK_SIZE, np.int32), np.empty(STACK_SIZE)
    for query, distance in zip(queries, tree.closest(queries).distance, strict=True):
        arrays = tree.boxes, tree.children, tree.corners
        slot, squared = nearest(*arrays, *query, distance**2 * 1.001, 0.0, nodes, bounds)
        assert slot >= 0
        assert squared == pytest.approx(distance**2)
        assert nearest(*arrays, *query, distance**2 * 0.999, 0.0, nodes, bounds)[0] == -1


@pytest.mark.parametrize("count", [1, 2, 5])
def test_few_triangles(count):
    points, triangles, queries = soup(8)
    triangles = triangles[10 : 10 + count]
    found = TriangleTree(points, triangles).closest(queries)
    np.testing.assert_allclose(found.distance, brute(points, triangles, queries).min(axis=1), atol=1e-14)


def test_coincident_and_exponentially_spaced_triangles_do_not_overflow_the_stack():
    same = np.tile([[0, 1, 2]], (5000, 1))
    found = TriangleTree(np.eye(3), same).closest(np.zeros((1, 3)))
    assert found.distance[0] == pytest.approx(1.0 / np.sqrt(3.0))
    size = 2.0 ** -np.arange(240.0)
    points = (size[:, None, None] * np.eye(3)).reshape(-1, 3)
    queries = size[::30, None] * np.ones(3) / 3.0
    found = TriangleTree(points, np.arange(720).reshape(-1, 3)).closest(queries)
    np.testing.assert_array_equal(found.triangle, np.arange(240)[::30])


def test_no_queries():
    tree = TriangleTree(np.eye(3), np.array([[0, 1, 2]]))
    assert len(tree.closest(np.empty((0, 3))).distance) == 0
    assert tree.within(np.empty((0, 3)), np.empty(0))[0].tolist() == [0]


def test_segments_agree_with_brute_force():
    rng = np.random.default_rng(9)
    points, queries = rng.normal(size=(30, 3)), rng.normal(size=(200, 3))
    edges = rng.integers(0, 30, (40, 2))
    edges[0] = 3
    found = SegmentTree(points, edges).closest(queries)
    t = np.array([[on_segment(q, points[a], points[b]) for a, b in edges] for q in queries])
    spots = points[edges[:, 0]] + t[:, :, None] * (points[edges[:, 1]] - points[edges[:, 0]])
    distance = np.linalg.norm(spots - queries[:, None], axis=2)
    np.testing.assert_allclose(found.distance, distance.min(axis=1), rtol=1e-14)
    row = np.arange(len(queries))
    np.testing.assert_allclose(found.parameter, t[row, found.segment], atol=1e-13)
    np.testing.assert_allclose(distance[row, found.segment], found.distance, rtol=1e-14)


def test_points_on_a_chain_of_segments_are_found_on_them():
    """Segments are triangles without area; a query in line with one must not be taken for a point inside it."""
    chain = np.linspace([0, 0, 0], [1, 2, 3], 30)
    rows = np.arange(29)
    for t in (0.0, 0.25, 0.5, 0.75):
        queries = chain[:-1] + t * (chain[1:] - chain[:-1])
        found = SegmentTree(chain, np.stack([rows, rows + 1], 1)).closest(queries)
        np.testing.assert_allclose(found.distance, 0.0, atol=1e-15)
        np.testing.assert_allclose(found.segment + found.parameter, rows + t, atol=1e-12)


@pytest.mark.parametrize(
    ("points", "triangles", "text"),
    [
        (np.eye(3), np.empty((0, 3), int), "at least one triangle"),
        (np.eye(3), [[0, 1, 3]], "outside 0..2"),
        (np.diag([1.0, np.nan, 1.0]), [[0, 1, 2]], "point 1 .* not finite"),
        (np.eye(2), [[0, 1, 1]], "three coordinates"),
    ],
)
def test_bad_input_is_named(points, triangles, text):
    with pytest.raises(InputError, match=text):
        TriangleTree(points, np.array(triangles))


def test_bad_queries_and_segments_are_named():
    tree = TriangleTree(np.eye(3), np.array([[0, 1, 2]]))
    with pytest.raises(InputError, match=r"query 1 .* not finite"):
        tree.closest(np.array([[0.0, 0.0, 0.0], [np.inf, 0.0, 0.0]]))
    with pytest.raises(InputError, match="at least one segment"):
        SegmentTree(np.eye(3), np.empty((0, 2), int))
    with pytest.raises(InputError, match="one each"):
        tree.refit(np.eye(3), inflation=np.zeros(2))
    with pytest.raises(InputError, match="check the faces"):
        tree.refit(np.eye(3)[:2])
    with pytest.raises(InputError, match="start must name"):
        tree.closest(np.eye(3), start=np.array([0, 0, 1]))
    with pytest.raises(InputError, match="radii"):
        tree.within(np.eye(3), np.ones(2))
