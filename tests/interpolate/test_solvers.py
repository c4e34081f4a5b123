"""Solvers: every one reaches the data, at the rate that the eigenvalues promise."""

import numpy as np
import pytest

from shapes.parameters import SOME, anywhere
from shapes.zoo import mesh_of, torus
from subdfit.interpolate import METHODS, LimitOperator, interpolate_points
from subdfit.interpolate.krylov import conjugate_gradients
from subdfit.interpolate.null_space import NullSpace
from subdfit.interpolate.progressive import chebyshev, over_relaxed, progressive, smallest_eigenvalue
from subdfit.io import read
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.repair import mend
from subdfit.schemes import SCHEMES
from subdfit.target.frame import Frame

IDS = ["-".join(case).replace(" ", "_") for case in SOME]


def symmetric(case):
    """Whether the shape's operator is regular, and symmetric with weights among the vertices off curves."""
    topology = mesh_of(case[1]).topology
    B = LimitOperator.of(SCHEMES[case[0]].limit_rows(topology))
    return B.weights is not None and not B.on_curves.all() and NullSpace.of(B, topology).count == 0


SYMMETRIC = [case for case in SOME if symmetric(case)]

FLOOR = 1e-14
"""What rounding leaves of errors of normalised points."""


def setting(scheme, mesh):
    """Operator and normalised data."""
    SCHEMES[scheme].validate(mesh.topology)
    return LimitOperator.of(SCHEMES[scheme].limit_rows(mesh.topology)), Frame.of(mesh.points).inside(mesh.points)


def real_mesh(path):
    return ControlMesh.from_data(mend(read(path)).data)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("case", SOME, ids=IDS)
def test_every_method_reaches_the_data(case, method):
    """To 1e-12 of the diagonal, with the control points that elimination gives."""
    scheme, name = case
    mesh = mesh_of(name)
    B, data = setting(scheme, mesh)
    found = interpolate_points(B, mesh.topology, data, method, 1e-12, 10_000)
    if found.null_vectors:
        # What is reached then is told in test_null_space.
        assert np.linalg.matrix_rank(B.matrix.toarray()) == B.size - found.null_vectors
        return
    assert found.status == "within_tolerance"
    assert np.linalg.norm(B.matrix @ found.points - data, axis=1).max() <= 1e-12
    np.testing.assert_allclose(found.points, np.linalg.solve(B.matrix.toarray(), data), atol=3e-11)
    assert found.residuals[0] == pytest.approx(np.linalg.norm(data - B.matrix @ data, axis=1).max())


@pytest.mark.parametrize("case", SOME, ids=IDS)
def test_the_surface_passes_through_the_data(case):
    """By the patches, which share nothing with the limit masks."""
    scheme, name = case
    mesh = mesh_of(name)
    B, data = setting(scheme, mesh)
    found = interpolate_points(B, mesh.topology, data, "cg", 1e-12, 10_000)
    if found.null_vectors:
        # What is reached then is told in test_null_space.
        assert np.linalg.matrix_rank(B.matrix.toarray()) == B.size - found.null_vectors
        return
    surface = LimitSurface(mesh.with_points(found.points), scheme)
    face, uv = anywhere(surface.domain)
    corners = np.flatnonzero(np.isin(uv, (0.0, 1.0)).all(axis=1))
    at = surface.evaluate(face[corners], uv[corners]).position
    for vertex in range(mesh.topology.vertex_count):
        assert np.linalg.norm(at - data[vertex], axis=1).min() < 1e-10


def test_where_iterations_diverge_cg_takes_over_and_that_is_told(caplog):
    """Beside inner vertices of two faces Catmull-Clark's operator has an eigenvalue below 0."""
    mesh = mesh_of("rhombic 2")
    B, data = setting("catmull-clark", mesh)
    assert np.linalg.eigvals(B.matrix.toarray()).real.min() < -0.01
    found = interpolate_points(B, mesh.topology, data, "progressive", 1e-12, 10_000)
    assert found.status == "within_tolerance"
    assert caplog.messages == ["progressive does not converge on this mesh; cg takes over"]


# Rates


@pytest.mark.parametrize("scheme", SCHEMES)
def test_plain_iteration_falls_by_the_smallest_eigenvalue(scheme):
    """On tori the slowest part of the error shrinks by 1 - lambda a step, and the bounds on steps to 1e-6 hold."""
    mesh = torus(9, 12)
    B, data = setting(scheme, mesh)
    low = np.linalg.eigvals(B.matrix.toarray()).real.min()
    assert smallest_eigenvalue(B) == pytest.approx(low, rel=1e-2)
    assert 0.85 * (1 - low) <= final_rate(errors_of(progressive(B, data, data), 80)) <= 1.02 * (1 - low)
    relaxed = errors_of(over_relaxed(B, data, data), 60)
    assert relaxed[40] <= 20 * ((1 - low) / (1 + low)) ** 40 * relaxed[0] + FLOOR


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("name", ["rocker-arm", "holes"])
def test_rates_on_real_meshes(scheme, name, meshes):
    """The quotient of successive errors tends to 1 - lambda; Chebyshev keeps its guarantee in every step."""
    mesh = real_mesh(meshes / f"{name}.ply")
    B, data = setting(scheme, mesh)
    low = smallest_eigenvalue(B)
    assert 0.85 * (1 - low) <= final_rate(errors_of(progressive(B, data, data), 120)) <= 1.02 * (1 - low)
    root = np.sqrt(low)
    guaranteed = 2 * ((1 - root) / (1 + root)) ** np.arange(20)
    rms = rms_errors(B, data, chebyshev(B, data, data), 20)
    # The guarantee is for norms in which B is symmetric: the weights' spread is what it may lose in this one.
    spread = np.sqrt(B.weights.max() / B.weights[B.weights > 0].min()) if B.weights is not None else 10.0
    assert np.all(rms <= 3 * spread * guaranteed * rms[0] + FLOOR)


def final_rate(errors):
    """Mean quotient of successive errors over the later half of those above rounding."""
    later = errors[errors > FLOOR]
    later = later[len(later) // 2 :]
    return (later[-1] / later[0]) ** (1 / (len(later) - 1))


def errors_of(steps, count):
    return np.array([next(steps)[1] for _ in range(count)])


def rms_errors(B, data, steps, count):
    return np.array([np.sqrt(np.mean(B.distances(next(steps)[0], data) ** 2)) for _ in range(count)])


@pytest.mark.parametrize(("scheme", "name"), SYMMETRIC, ids=["-".join(c).replace(" ", "_") for c in SYMMETRIC])
def test_conjugate_gradients_keep_their_guarantee(scheme, name):
    """The energy norm falls at least by 2 ((sqrt(k) - 1) / (sqrt(k) + 1))^steps, k = largest / smallest eigenvalue."""
    mesh = mesh_of(name)
    B, data = setting(scheme, mesh)
    free = ~B.on_curves
    block = B.matrix.toarray()[np.ix_(free, free)]
    T = B.weights[free, None] * block
    values = np.linalg.eigvals(block).real
    root = np.sqrt(values.max() / values.min())
    residual = np.where(free[:, None], data, 0.0)
    truth = np.linalg.solve(block, residual[free])
    energies = []
    for x, _ in conjugate_gradients(B, B.weights, np.zeros_like(data), residual.copy()):
        left = truth - x[free]
        energies.append(np.sqrt(max(np.sum(left * (T @ left)), 0.0)))
        if len(energies) > 12:
            break
    bound = 2 * ((root - 1) / (root + 1)) ** np.arange(len(energies))
    assert np.all(np.array(energies) <= bound * energies[0] + 1e-13)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_cg_takes_the_fewest_iterations(scheme, meshes):
    mesh = real_mesh(meshes / "rocker-arm.ply")
    B, data = setting(scheme, mesh)
    steps = {m: len(interpolate_points(B, mesh.topology, data, m, 1e-6, 1000).residuals) for m in METHODS}
    assert steps["cg"] <= min(steps.values()) + 1
    assert steps["chebyshev"] < steps["over-relaxation"] < steps["progressive"]


# Curves


@pytest.mark.parametrize("scheme", SCHEMES)
def test_curves_are_the_curves_own(scheme):
    """Moving smooth vertices moves no control point of a boundary, crease or corner."""
    mesh = mesh_of("crease across")
    B, data = setting(scheme, mesh)
    other = data + np.where(B.on_curves[:, None], 0.0, np.random.default_rng(0).normal(size=data.shape))
    first = interpolate_points(B, mesh.topology, data, "cg", 1e-12, 1000).points
    second = interpolate_points(B, mesh.topology, other, "cg", 1e-11, 1000).points
    assert B.on_curves.sum() > 10
    np.testing.assert_array_equal(first[B.on_curves], second[B.on_curves])


# Limits


def test_what_cannot_be_reached_is_a_best_effort():
    mesh = mesh_of("disc")
    B, data = setting("loop", mesh)
    for method in METHODS:
        found = interpolate_points(B, mesh.topology, data, method, 1e-19, 10_000)
        assert found.status == "best_effort"
        assert found.distances.max() < 1e-15
        assert len(found.residuals) < 1000


def test_iterations_are_bounded():
    mesh = mesh_of("torus 4 7")
    B, data = setting("loop", mesh)
    found = interpolate_points(B, mesh.topology, data, "progressive", 1e-12, 5)
    assert found.status == "best_effort"
    assert len(found.residuals) == 5
