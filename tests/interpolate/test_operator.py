"""The limit operator's structure, for every scheme over every shape of the zoo."""

import numpy as np
import pytest

from shapes.kinds import edges_at
from shapes.parameters import SOME
from shapes.zoo import mesh_of
from subdfit import parallel
from subdfit.interpolate import LimitOperator
from subdfit.interpolate.null_space import NullSpace
from subdfit.schemes import SCHEMES

IDS = ["-".join(case).replace(" ", "_") for case in SOME]


def operator_of(scheme, mesh):
    return LimitOperator.of(SCHEMES[scheme].limit_rows(mesh.topology))


@pytest.fixture(params=SOME, ids=IDS)
def case(request):
    """An operator, as it is and dense, and the topology."""
    scheme, name = request.param
    mesh = mesh_of(name)
    B = operator_of(scheme, mesh)
    return B, B.matrix.toarray(), mesh.topology


def test_rows_sum_to_one_and_never_lengthen(case):
    """The infinity norm of B is 1: limit points are convex combinations (Cheng et al., proposition 2)."""
    _, dense, _ = case
    np.testing.assert_allclose(dense.sum(axis=1), 1, atol=1e-13)
    assert np.abs(dense).sum(axis=1).max() == pytest.approx(1, abs=1e-13)


def test_eigenvalues_let_the_iteration_converge(case):
    """In (0, 1], or 0 as often as there are alternating null vectors; beside darts complex, but less than 1 from 1.

    Catmull-Clark's operator is positive on control meshes that vanish at inner vertices of two faces, so that it has at
    most as many eigenvalues below 0 as there are such vertices.
    """
    B, dense, topology = case
    values = np.linalg.eigvals(dense)
    null, below = NullSpace.of(B, topology).count, np.count_nonzero(values.real < -1e-8)
    assert np.count_nonzero(np.abs(values) < 1e-8) == null
    assert np.count_nonzero(np.abs(1 - values) < 1 - 1e-8) == B.size - null - below
    faces = np.bincount(topology.face_vertices, minlength=B.size)
    inner = edges_at(topology, topology.boundary_edges) == 0
    assert below <= np.count_nonzero(inner & (faces == 2))
    if B.weights is not None:
        assert np.abs(values.imag).max() < 1e-6
        assert values.real.max() < 1 + 1e-10


def test_products_are_the_matrix_times_points(case):
    B, dense, _ = case
    x = np.random.default_rng(0).normal(size=(B.size, 3))
    np.testing.assert_allclose(B.times(x), dense @ x, rtol=0, atol=1e-14)


def test_breadth_first_it_is_the_same_operator_renumbered(case):
    """Row by row each vertex is the first of its component or a neighbour of an earlier one."""
    B, dense, _ = case
    compact, order = B.breadth_first()
    np.testing.assert_array_equal(np.sort(order), np.arange(B.size))
    np.testing.assert_array_equal(compact.matrix.toarray(), dense[np.ix_(order, order)])
    assert compact.matrix.has_canonical_format
    earlier = np.tril(compact.matrix.toarray(), -1).any(axis=1) | np.triu(compact.matrix.toarray(), 1).any(axis=0)
    for i in np.flatnonzero(~earlier):
        assert order[i] == np.setdiff1d(np.arange(B.size), order[:i]).min()


def test_distances_are_those_of_the_limit_points(case):
    B, dense, _ = case
    x, data = np.random.default_rng(1).normal(size=(2, B.size, 3))
    np.testing.assert_allclose(B.distances(x, data), np.linalg.norm(data - dense @ x, axis=1), rtol=1e-13)


def test_curves_are_the_sharp_vertices(case):
    """Curve rows are the corners and the vertices inside curves, but for curves that end in darts."""
    B, _, t = case
    curve = t.edge_vertices[np.isinf(t.sharpness)]
    sharp = np.bincount(curve.ravel(), minlength=t.vertex_count)
    corner = np.isinf(t.corner_sharpness) | (sharp >= 3)
    loose = ~corner & (sharp == 1)
    for _ in curve:
        reached = np.unique(curve[loose[curve].any(axis=1)])
        loose[reached[~corner[reached]]] = True
    np.testing.assert_array_equal(B.on_curves, (corner | (sharp == 2)) & ~loose)


def test_curves_do_not_depend_on_the_rest(case):
    B, dense, _ = case
    assert not dense[np.ix_(B.on_curves, ~B.on_curves)].any()


def test_weights_make_it_symmetric_where_some_do(case):
    B, dense, _ = case
    free = np.flatnonzero(~B.on_curves)
    block = dense[np.ix_(free, free)]
    if B.weights is None:
        # A matrix with such weights has equal products of entries round every triangle.
        pattern = (block != 0) != (block.T != 0)
        cycles = np.einsum("ij,jk,ki->ijk", block, block, block)
        assert pattern.any() or np.abs(cycles - cycles.transpose(0, 2, 1)).max() > 1e-9
        return
    assert not B.weights[B.on_curves].any()
    T = B.weights[free, None] * block
    np.testing.assert_allclose(T, T.T, rtol=0, atol=1e-12 * max(T.max(initial=0), 1))
    assert np.all(B.weights[free] > 0)


def test_threads_do_not_matter():
    mesh = mesh_of("torus 4 7")
    B = operator_of(next(iter(SCHEMES)), mesh)
    B = LimitOperator(B.matrix)
    x = np.random.default_rng(1).normal(size=(B.size, 3))
    found = []
    for threads in (1, 2):
        parallel.set_threads(threads)
        found.append(B.times(x))
    parallel.set_threads(None)
    np.testing.assert_array_equal(*found)
