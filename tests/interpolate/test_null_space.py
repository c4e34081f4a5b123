"""Singular operators: found for what they are, and answered by the least solution."""

import numpy as np
import pytest
import scipy.sparse as sp

from shapes.parameters import SOME
from shapes.zoo import mesh_of
from subdfit.interpolate import METHODS, LimitOperator, interpolate_points
from subdfit.interpolate.null_space import NullSpace
from subdfit.mesh.topology import Topology
from subdfit.schemes import SCHEMES

CUBE = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


def prism(n, first=0):
    """Faces of a prism over an n-gon."""
    low, high = [*range(first, first + n)], [*range(first + n, first + 2 * n)]
    sides = [[low[i], low[(i + 1) % n], high[(i + 1) % n], high[i]] for i in range(n)]
    return [low[::-1], high, *sides]


def topology_of(faces):
    offsets = np.cumsum([0, *map(len, faces)])
    return Topology.from_faces(offsets, np.concatenate(faces), max(map(max, faces)) + 1)


def quad_mask(topology):
    """Catmull-Clark's limit rows on closed meshes of valence 3, by the formula: (6 V + 2 sum E + 4 sum C) / 24."""
    n = topology.vertex_count
    rows = np.zeros((n, n))
    for f in range(topology.face_count):
        corners = topology.face_vertices[topology.face_offsets[f] : topology.face_offsets[f + 1]]
        rows[np.ix_(corners, corners)] += 4 / len(corners) / 24
        for a, b in zip(corners, np.roll(corners, 1), strict=True):
            rows[a, b] += 1 / 24  # each edge is met from both of its faces
            rows[b, a] += 1 / 24
    return LimitOperator.of(sp.csr_array(rows + np.eye(n) * 6 / 24))


@pytest.mark.parametrize("faces", [CUBE, prism(6), prism(4), prism(8)])
def test_even_faces_and_valence_three_are_singular(faces):
    topology = topology_of(faces)
    B = quad_mask(topology)
    assert NullSpace.of(B, topology).count == 1
    values = np.linalg.svd(B.matrix.toarray(), compute_uv=False)
    assert np.count_nonzero(values < 1e-12) == 1


@pytest.mark.parametrize("faces", [prism(3), prism(5)])
def test_odd_faces_are_not(faces):
    topology = topology_of(faces)
    B = quad_mask(topology)
    assert NullSpace.of(B, topology).count == 0
    assert np.linalg.svd(B.matrix.toarray(), compute_uv=False).min() > 1e-3


@pytest.mark.parametrize("method", METHODS)
def test_the_least_solution(method):
    """As the pseudo-inverse gives it, for components one of which is singular, and data that are out of reach."""
    topology = topology_of([*prism(6), *prism(5, 12), *prism(4, 22)])
    B = quad_mask(topology)
    data = np.random.default_rng(3).normal(size=(B.size, 3))
    found = interpolate_points(B, topology, data, method, 1e-12, 20_000)
    assert found.null_vectors == 2
    assert found.status == "best_effort"
    np.testing.assert_allclose(found.points, np.linalg.pinv(B.matrix.toarray(), rtol=1e-10) @ data, atol=1e-9)
    assert found.residuals[-1] <= 1e-12
    assert found.distances.max() > 0.01


@pytest.mark.parametrize("method", METHODS)
def test_reachable_data_are_reached(method):
    topology = topology_of(prism(6))
    B = quad_mask(topology)
    data = B.times(np.random.default_rng(4).normal(size=(B.size, 3)))
    found = interpolate_points(B, topology, data, method, 1e-12, 20_000)
    assert found.null_vectors == 1
    assert found.status == "within_tolerance"


@pytest.mark.parametrize(("n", "null"), [(3, 2), (4, 0), (6, 2)])
def test_faces_back_to_back(n, null):
    """Two n-gons with the same corners, beside a prism: Catmull-Clark's limits of two triangles are their centroid."""
    pair = [[*range(n)], [*range(n)][::-1]]
    topology = topology_of([*pair, *prism(5, n)])
    B = LimitOperator.of(SCHEMES["catmull-clark"].limit_rows(topology))
    data = np.random.default_rng(5).normal(size=(B.size, 3))
    for method in ("cg", "progressive"):
        found = interpolate_points(B, topology, data, method, 1e-12, 20_000)
        assert found.null_vectors == null
        assert (found.status == "within_tolerance") == (null == 0)
        np.testing.assert_allclose(found.points, np.linalg.pinv(B.matrix.toarray(), rtol=1e-10) @ data, atol=1e-9)


@pytest.mark.parametrize("case", SOME, ids=["-".join(case).replace(" ", "_") for case in SOME])
def test_alternating_vectors_are_all_there_are(case):
    scheme, name = case
    topology = mesh_of(name).topology
    B = LimitOperator.of(SCHEMES[scheme].limit_rows(topology))
    values = np.linalg.svd(B.matrix.toarray(), compute_uv=False)
    assert np.count_nonzero(values < 1e-10) == NullSpace.of(B, topology).count


@pytest.mark.parametrize("case", SOME, ids=["-".join(case).replace(" ", "_") for case in SOME])
def test_the_least_solution_of_the_zoo(case):
    """As the pseudo-inverse gives it, symmetric or not."""
    scheme, name = case
    mesh = mesh_of(name)
    B = LimitOperator.of(SCHEMES[scheme].limit_rows(mesh.topology))
    found = interpolate_points(B, mesh.topology, mesh.points, "cg", 1e-12, 1000)
    np.testing.assert_allclose(found.points, np.linalg.pinv(B.matrix.toarray(), rtol=1e-10) @ mesh.points, atol=1e-9)
