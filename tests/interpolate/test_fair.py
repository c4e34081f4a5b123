"""The thin-plate energy against geometry, and the surfaces of least energy through the data."""

from math import factorial

import numpy as np
import pytest

from shapes.parameters import SOME, surface_of
from shapes.zoo import grid_data, mesh_of
from subdfit.initial import decimate
from subdfit.initial.components import keep_components
from subdfit.interpolate import LimitOperator, fair_interpolation, interpolate_points
from subdfit.interpolate.energy import _RULES, thin_plate
from subdfit.io import read
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.repair import mend
from subdfit.schemes import SCHEMES
from subdfit.schemes.domain import QUAD, TRIANGLE
from subdfit.target.frame import Frame

IDS = ["-".join(case).replace(" ", "_") for case in SOME]
SMALL = [case for case in SOME if mesh_of(case[1]).topology.face_count < 60]


def interpolated(scheme, mesh):
    """The data in normalised coordinates, and control points through them."""
    data = mesh.with_points(Frame.of(mesh.points).inside(mesh.points))
    B = LimitOperator.of(SCHEMES[scheme].limit_rows(mesh.topology))
    return data, interpolate_points(B, mesh.topology, data.points, "cg", 1e-13, 10_000).points


# The energy


@pytest.mark.parametrize("case", SOME, ids=IDS)
def test_the_energy_is_a_form_that_knows_no_place(case):
    surface = surface_of(*case)
    K = thin_plate(surface)
    scale = max(abs(K).max(), 1e-3)  # over one triangle alone all is affine, without energy
    assert abs(K - K.T).max() <= 1e-12 * scale
    assert np.abs(K @ np.ones(K.shape[0])).max() <= 1e-9 * scale
    assert np.linalg.eigvalsh(K.toarray()).min() >= -1e-10 * scale


@pytest.mark.parametrize(("shape", "degree"), [(TRIANGLE, 4), (QUAD, 5)])
def test_quadrature_is_exact_for_polynomials(shape, degree):
    uv, weights = _RULES[shape]
    for i in range(degree + 1):
        for j in range(degree + 1 - i):
            exact = factorial(i) * factorial(j) / factorial(i + j + 2) if shape == TRIANGLE else 1 / ((i + 1) * (j + 1))
            assert weights @ (uv[:, 0] ** i * uv[:, 1] ** j) == pytest.approx(exact, rel=1e-13)


def round_torus(rows, columns, major=2.0, minor=1.0):
    """A torus of revolution, triangulated regularly."""
    points, faces = grid_data(rows, columns, close_rows=True, close_columns=True)
    phi, theta = 2 * np.pi * points[:, 1] / rows, 2 * np.pi * points[:, 0] / columns
    radius = major + minor * np.cos(theta)
    points = np.stack([radius * np.cos(phi), radius * np.sin(phi), minor * np.sin(theta)], axis=1)
    return ControlMesh.from_triangles(points, faces)


def test_a_surface_over_itself_has_the_energy_of_its_curvatures():
    """Its second covariant derivative is its second fundamental form: the integral is that of k1^2 + k2^2."""
    theta = 2 * np.pi * np.arange(400) / 400
    across = np.cos(theta) / (2 + np.cos(theta))
    exact = (2 * np.pi) ** 2 * np.mean((1 + across**2) * (2 + np.cos(theta)))
    errors = []
    for k in (1, 2, 4):
        data, control = interpolated("loop", round_torus(12 * k, 8 * k))
        energy = thin_plate(LimitSurface(data.with_points(control), "loop"))
        errors.append(abs(np.vdot(control, energy @ control) / exact - 1))
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert rates.min() > 1.7
    assert errors[-1] < 2e-3


def test_parameters_do_not_matter():
    """The same surface, described by its refined control mesh, has nearly the same energy: only quadrature differs."""
    surface = surface_of("loop", "torus 4 7")
    step = SCHEMES["loop"].refine(surface.topology)
    fine = LimitSurface(ControlMesh(step.child, step.matrix @ surface.control_mesh.points), "loop")
    values = [np.vdot(s.control_mesh.points, thin_plate(s) @ s.control_mesh.points) for s in (surface, fine)]
    assert values[0] == pytest.approx(values[1], rel=0.1)


# Least energy


@pytest.mark.parametrize("case", SMALL, ids=["-".join(case).replace(" ", "_") for case in SMALL])
def test_the_data_are_met_and_nothing_is_lower(case):
    scheme, name = case
    data, plain = interpolated(scheme, mesh_of(name))
    fair = fair_interpolation(SCHEMES[scheme], data, plain)
    n = data.topology.vertex_count
    assert fair.distances.max() <= 1e-12
    assert fair.after <= fair.before + 1e-9
    step = SCHEMES[scheme].refine(data.topology)
    rows = fair.limit_rows.toarray()
    # Points of the same surface: the refined mesh's rows after refining are the mesh's own.
    np.testing.assert_allclose(
        rows @ step.matrix.toarray(), SCHEMES[scheme].limit_rows(data.topology).toarray(), atol=1e-13
    )
    energy = thin_plate(LimitSurface(ControlMesh(step.child, step.matrix @ data.points), scheme)).toarray()
    _, _, right = np.linalg.svd(rows)
    kept = right[n:].T  # changes that keep the limit points
    slope = kept.T @ (energy @ fair.control_mesh.points)
    assert np.abs(slope).max() <= 1e-6 * max(np.abs(kept.T @ energy @ kept).max(), 1e-3)


@pytest.mark.parametrize(("scheme", "name"), [("loop", "beethoven"), ("catmull-clark", "beethoven"), ("loop", "bunny")])
def test_ripples_become_fewer_on_real_meshes(scheme, name, meshes):
    """The bust without its specks of two triangles; the bunny decimated to 2,000 vertices, for time."""
    data = mend(read(meshes / f"{name}.ply")).data
    found = keep_components(data.points, data.face_vertices.reshape(-1, 3), 1)
    if name == "bunny":
        found = decimate(found.points, found.triangles, 2000)
    mesh = ControlMesh.from_triangles(found.points, found.triangles)
    SCHEMES[scheme].validate(mesh.topology)
    data, plain = interpolated(scheme, mesh)
    fair = fair_interpolation(SCHEMES[scheme], data, plain)
    assert fair.distances.max() <= 1e-12
    assert fair.after < 0.9 * fair.before
