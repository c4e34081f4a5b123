"""The synthetic scan: a manifold of genus one with two boundaries, irregular, and as noisy as it says."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from subdfit.errors import InputError
from subdfit.target.synthetic_scan import NOISE, figure, synthetic_scan


@pytest.fixture(scope="module")
def scan():
    return synthetic_scan()


def directed_edges(triangles):
    return np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)


def boundary(triangles, count):
    """Directed edges that no other triangle runs through the other way."""
    edges = directed_edges(triangles)
    return edges[~np.isin(edges @ [count, 1], edges @ [1, count])]


def pieces(edges, count):
    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
    labels = connected_components(graph, directed=False)[1]
    return len(np.unique(labels[edges.ravel()]))


@pytest.mark.parametrize(("seed", "vertices"), [(0, 40_000), (1, 40_000), (2, 10_000), (3, 16_000)])
def test_the_topology_is_as_designed(seed, vertices):
    points, triangles = synthetic_scan(seed, vertices)
    assert points.dtype == np.float64
    assert triangles.dtype == np.int64
    count = len(points)
    assert count == pytest.approx(vertices, rel=0.03)
    np.testing.assert_array_equal(np.unique(triangles), np.arange(count))
    edges = directed_edges(triangles)
    assert len(np.unique(edges @ [count, 1])) == len(edges), "each directed edge once: manifold edges, oriented"
    assert pieces(edges, count) == 1
    open_edges = boundary(triangles, count)
    assert pieces(open_edges, count) == 2
    assert np.bincount(open_edges[:, 0]).max() == 1, "a boundary vertex is passed once"
    assert len(np.unique(np.sort(edges, axis=1), axis=0)) == (len(edges) + len(open_edges)) // 2
    handles, loops = 1, 2
    assert count - (len(edges) + len(open_edges)) // 2 + len(triangles) == 2 - 2 * handles - loops


def test_each_vertex_has_one_fan(scan):
    points, triangles = scan
    count = len(points)
    corners = triangles.ravel()
    links = np.stack([np.roll(triangles, -1, axis=1), np.roll(triangles, -2, axis=1)], axis=2).reshape(-1, 2)
    ends = np.concatenate([corners[:, None] * count + links[:, :1], corners[:, None] * count + links[:, 1:]], axis=1)
    names, nodes = np.unique(ends, return_inverse=True)
    nodes = nodes.reshape(-1, 2)
    graph = coo_array((np.ones(len(nodes)), (nodes[:, 0], nodes[:, 1])), shape=(len(names), len(names)))
    assert connected_components(graph, directed=False)[0] == count


def test_triangles_look_outwards_and_are_well_shaped(scan):
    points, triangles = scan
    a, b, c = points[triangles].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    ahead = (a + b + c) / 3.0 + 0.4 * normals / np.linalg.norm(normals, axis=1, keepdims=True)
    behind = 2.0 * (a + b + c) / 3.0 - ahead
    assert np.mean(figure(*ahead.T) > figure(*behind.T)) > 0.999
    sides = np.stack([np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a))])
    quality = 2.0 * np.sqrt(3.0) * np.linalg.norm(normals, axis=1) / np.sum(sides**2, axis=0)
    assert np.quantile(quality, 0.01) > 0.6
    valence = np.bincount(np.unique(np.sort(directed_edges(triangles), axis=1), axis=0).ravel())
    assert np.mean((valence >= 4) & (valence <= 8)) > 0.99
    assert np.mean(valence == 6) < 0.6, "a scanner's mesh is not a regular grid"


def test_the_noise_has_the_stated_size(scan):
    points, triangles = scan
    step = 1e-5
    slope = np.stack([(figure(*(points + h).T) - figure(*(points - h).T)) / (2 * step) for h in step * np.eye(3)])
    distance = figure(*points.T) / np.linalg.norm(slope, axis=0)
    inner = np.setdiff1d(np.arange(len(points)), boundary(triangles, len(points)))
    sigma = NOISE * np.linalg.norm(np.ptp(points, axis=0))
    spread = np.quantile(distance[inner] / sigma, [0.023, 0.159, 0.5, 0.841, 0.977])
    np.testing.assert_allclose(spread, [-2.0, -1.0, 0.0, 1.0, 2.0], atol=0.06)


def test_it_is_the_size_of_a_hand_and_stands_on_its_open_foot(scan):
    points, triangles = scan
    assert 100.0 < np.ptp(points[:, 1]) < 130.0
    foot = points[boundary(triangles, len(points)).ravel(), 1]
    assert np.mean(foot < 2.0) > 0.8
    assert points[:, 1].min() > -0.5


def test_the_same_seed_gives_the_same_mesh_and_another_another(scan):
    again = synthetic_scan()
    np.testing.assert_array_equal(scan[0], again[0])
    np.testing.assert_array_equal(scan[1], again[1])
    other = synthetic_scan(seed=1)
    assert other[0].shape != scan[0].shape or np.any(other[0] != scan[0])


def test_too_few_vertices_are_refused():
    with pytest.raises(InputError, match="ask for 10000 or more"):
        synthetic_scan(vertices=500)
