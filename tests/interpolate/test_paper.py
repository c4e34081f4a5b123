"""Lemma and propositions of Cheng et al. as facts: the averaging mask's B = Lambda T on meshes of every kind."""

import numpy as np
import pytest

from shapes.parameters import CASES
from shapes.zoo import mesh_of
from subdfit.interpolate import LimitOperator
from subdfit.interpolate.progressive import progressive
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.schemes import SCHEMES

CLOSED = [
    name
    for scheme, name in CASES
    if scheme == "doo-sabin-averaging"
    and np.isfinite(mesh_of(name).topology.sharpness).all()
    and mesh_of(name).topology.valence.min() > 2
]
"""Without vertices of two faces, which the scheme takes away before it refines."""


def prism(n):
    """A prism over an n-gon, its points strewn at random: faces of n and of four corners."""
    low, high = [*range(n)], [*range(n, 2 * n)]
    faces = [low[::-1], high, *([low[i - 1], low[i], high[i], high[i - 1]] for i in range(n))]
    offsets = np.cumsum([0, *map(len, faces)])
    topology = Topology.from_faces(offsets, np.concatenate(faces), 2 * n)
    return ControlMesh(topology, np.random.default_rng(n).normal(size=(2 * n, 3)))


@pytest.fixture(params=[*CLOSED, 3, 5, 6, 9], ids=lambda name: str(name).replace(" ", "_"))
def closed(request):
    """A closed mesh and its dense operator."""
    mesh = mesh_of(request.param) if isinstance(request.param, str) else prism(request.param)
    return mesh, LimitOperator.of(SCHEMES["doo-sabin-averaging"].limit_rows(mesh.topology))


def printed_operator(t):
    """Equation 1, written out face by face: the row of V from its n faces of m corners each."""
    B = np.zeros((t.vertex_count, t.vertex_count))
    for f in range(t.face_count):
        corners = t.face_vertices[t.face_offsets[f] : t.face_offsets[f + 1]]
        m = len(corners)
        for k, v in enumerate(corners):
            row = B[v]
            row[v] += (4 * m + 2) / (8 * m)
            for j in range(1, m):
                row[corners[(k + j) % m]] += (m + 2) / (8 * m) if j in (1, m - 1) else 2 / (8 * m)
    return B / t.valence[:, None]


def test_equation_1(closed):
    mesh, B = closed
    np.testing.assert_allclose(B.matrix.toarray(), printed_operator(mesh.topology), atol=1e-15)


def test_lambda_and_t(closed):
    """B = Lambda T with Lambda = diag(1 / n): the weights of symmetry are the valences, up to a factor a component."""
    mesh, B = closed
    T = mesh.topology.valence[:, None] * B.matrix.toarray()
    np.testing.assert_allclose(T, T.T, atol=1e-14)
    ratio = B.weights / mesh.topology.valence
    np.testing.assert_allclose(B.matrix @ ratio, ratio, rtol=1e-12)  # constant on each component


def test_proposition_1_t_dominates_by_half_a_face(closed):
    """Strictly diagonally dominant, by the sum of 4 / 8m over the faces of a vertex, so positive definite."""
    mesh, B = closed
    t = mesh.topology
    T = t.valence[:, None] * B.matrix.toarray()
    margin = 2 * np.diag(T) - np.abs(T).sum(axis=1)
    size = np.diff(t.face_offsets)
    half = np.bincount(t.face_vertices, (1 / (2 * size))[t.face], t.vertex_count)
    np.testing.assert_allclose(margin, half, atol=1e-12)
    assert np.linalg.eigvalsh(T).min() > 0


def test_proposition_2_eigenvalues_and_norm(closed):
    """Eigenvalues in (0, 1], in fact from 1/4 on, and the infinity norm 1: the iteration converges."""
    _, B = closed
    dense = B.matrix.toarray()
    values = np.linalg.eigvals(dense)
    assert np.abs(values.imag).max() < 1e-8
    assert values.real.min() >= 1 / 4 - 1e-10
    assert values.real.max() <= 1 + 1e-12
    assert np.abs(dense).sum(axis=1).max() == pytest.approx(1, abs=1e-14)


def test_equation_3_differences_are_powers(closed):
    """D^k = (I - B)^k D^0."""
    mesh, B = closed
    dense = B.matrix.toarray()
    steps = progressive(B, mesh.points, mesh.points)
    D = mesh.points - dense @ mesh.points
    for _ in range(6):
        V, longest = next(steps)
        np.testing.assert_allclose(mesh.points - dense @ V, D, atol=1e-13)
        assert longest == pytest.approx(np.linalg.norm(D, axis=1).max(), abs=1e-13)
        D = D - dense @ D
