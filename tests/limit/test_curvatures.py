"""Principal curvatures of the limit surface: exact on quadrics, convergent on a torus, undefined where they are."""

import numpy as np
import pytest

from shapes.parameters import CORNERS, SOME, inside, surface_of
from shapes.zoo import grid_data, scattered
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology

SCHEMES = ["loop", "catmull-clark"]


def over_grid(scheme, rows, columns, place, **closed):
    """A regular mesh with vertices at ``place(x, y)`` of grid points; `closed` joins its sides."""
    points, faces = grid_data(rows, columns, **closed)
    if scheme != "loop":
        pairs = faces.reshape(2, -1, 3)
        faces = np.column_stack([pairs[0], pairs[1][:, 2]])
    corners = faces.shape[1]
    topology = Topology.from_faces(np.arange(0, corners * len(faces) + 1, corners), faces.ravel(), len(points))
    return LimitSurface(ControlMesh(topology, place(*points[:, :2].T)), scheme)


def clear_of_boundary(surface):
    """Parameters inside cells whose patches are regular and see no boundary."""
    t = surface.topology
    faces = t.face_vertices.reshape(t.face_count, -1)
    touched = np.isin(faces, t.edge_vertices[t.boundary_edges]).any(axis=1)
    face, uv = inside(surface.domain, per_cell=3)
    keep = ~touched[face]
    return face[keep], uv[keep]


@pytest.mark.parametrize("scheme", SCHEMES)
def test_exact_on_a_quadric(scheme):
    """Quadratics are reproduced up to a constant; Monge's formula gives their curvatures."""
    a, b, c = 0.11, -0.07, 0.05
    surface = over_grid(scheme, 7, 7, lambda x, y: np.column_stack([x, y, a * x * x + b * x * y + c * y * y]))
    face, uv = clear_of_boundary(surface)
    found, (x, y, _) = surface.curvatures(face, uv), surface.evaluate(face, uv).position.T
    p, q = 2 * a * x + b * y, b * x + 2 * c * y
    w = 1 + p * p + q * q
    gauss = (4 * a * c - b * b) / w**2
    mean = (2 * a * (1 + q * q) - 2 * b * p * q + 2 * c * (1 + p * p)) / (2 * w**1.5)
    np.testing.assert_allclose(found.minimum * found.maximum, gauss, atol=1e-13)
    # The surface bends towards its normal where the second derivatives are positive.
    np.testing.assert_allclose(found.minimum + found.maximum, -2 * mean, atol=1e-13)
    np.testing.assert_allclose(found.normal * np.sqrt(w)[:, None], np.column_stack([-p, -q, 1 + 0 * p]), atol=1e-13)
    hessian = np.array([[2 * a, b], [b, 2 * c]])
    for value, direction in [
        (found.minimum, found.minimum_direction),
        (found.maximum, found.maximum_direction),
    ]:
        planar = direction[:, :2]
        bend = np.einsum("ki,ij,kj->k", planar, hessian, planar) / np.sqrt(w)
        np.testing.assert_allclose(-bend, value, atol=1e-13)


RING, TUBE = 3.0, 1.0


def torus_error(scheme, n):
    """Largest error of both curvatures where the tube's angle is read off the surface itself."""

    def place(x, y):
        s, t = 2 * np.pi * y / n, 2 * np.pi * x / (2 * n)
        return np.stack(
            [(RING + TUBE * np.cos(s)) * np.cos(t), (RING + TUBE * np.cos(s)) * np.sin(t), TUBE * np.sin(s)], 1
        )

    surface = over_grid(scheme, n, 2 * n, place, close_rows=True, close_columns=True)
    face, uv = inside(surface.domain, per_cell=2)
    found, position = surface.curvatures(face, uv), surface.evaluate(face, uv).position
    radial = np.hypot(*position[:, :2].T)
    angle = np.arctan2(position[:, 2], radial - RING)
    outward = np.column_stack([np.cos(angle)[:, None] * position[:, :2] / radial[:, None], np.sin(angle)])
    side = np.sign(np.einsum("kx,kx->k", found.normal, outward))
    assert np.abs(side).min() == 1
    assert (side == side[0]).all()
    around, along = side / TUBE, side * np.cos(angle) / (RING + TUBE * np.cos(angle))
    expected = np.sort(np.column_stack([around, along]), axis=1)
    return np.abs(expected - np.column_stack([found.minimum, found.maximum])).max()


@pytest.mark.parametrize("scheme", SCHEMES)
def test_second_order_on_a_torus(scheme):
    """Control points on a smooth surface: curvatures err by the square of the spacing."""
    errors = [torus_error(scheme, n) for n in (10, 20, 40)]
    assert np.log2(errors[0] / errors[1]) > 1.8
    assert np.log2(errors[1] / errors[2]) > 1.9


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_cylinder_bends_one_way(scheme):
    """A ring of n points repeated along an axis: one curvature is zero, and its direction the axis."""
    n = 24

    def place(x, y):
        return np.column_stack([np.cos(2 * np.pi * x / n), np.sin(2 * np.pi * x / n), y])

    surface = over_grid(scheme, 6, n, place, close_columns=True)
    face, uv = clear_of_boundary(surface)
    found = surface.curvatures(face, uv)
    radius = np.hypot(*surface.evaluate(face, uv).position[:, :2].T)
    assert np.abs(found.minimum).max() < 1e-12
    np.testing.assert_allclose(found.maximum, 1 / radius, rtol=0.02)
    np.testing.assert_allclose(np.abs(found.minimum_direction[:, 2]), 1, atol=1e-12)


def eigenvalues(scheme, n):
    """The tangents' eigenvalue round an inner vertex, and the largest that bends the surface: frequencies 0 and 2.

    At three there is no frequency 2. There Loop's is 1/8, that of the cubics along the edges: for the second ring.
    """
    c1, c2 = np.cos(2 * np.pi / n), np.cos(4 * np.pi / n)
    if scheme == "loop":
        tangents = 3 / 8 + c1 / 4
        return tangents, max(tangents**2, 3 / 8 + c2 / 4 if n > 3 else 1 / 8)
    tangents, saddle = ((5 + c + np.sqrt((c + 9) * (c + 1))) / 16 for c in (c1, c2))
    return tangents, max((3 * n - 7 + np.sqrt(5 * n * n - 30 * n + 49)) / (8 * n), saddle if n > 4 else 0)


@pytest.mark.parametrize(
    ("scheme", "name", "n"),
    [
        *(("loop", name, n) for name, n in [("tetrahedron", 3), ("pyramid 5", 5), ("pyramid 7", 7), ("pyramid 9", 9)]),
        *(("catmull-clark", name, n) for name, n in [("quad fan 3", 3), ("rhombic 5", 5), ("rhombic 9", 9)]),
    ],
)
def test_rates_towards_an_inner_vertex(scheme, name, n):
    """Curvatures change by mu / lambda^2 a level: Loop's double at three, are bounded from four to six and diverge from
    seven on, Catmull-Clark's tend to zero at three and diverge from five on.

    Control points are strewn at random, so that every frequency is there.
    """
    surface = surface_of(scheme, name)
    surface = surface.with_points(scattered(surface.control_mesh).points)
    assert surface.domain.vertex[0, 0] == 0
    found = surface.curvatures([0, 0], 2.0 ** -np.array([24, 28])[:, None] * [0.37, 0.31])
    size = np.hypot(found.minimum, found.maximum)
    tangents, bending = eigenvalues(scheme, n)
    assert (size[1] / size[0]) ** 0.25 == pytest.approx(bending / tangents**2, rel=0.02)
    assert (bending / tangents**2 > 1 + 1e-12) == (n == 3 or n > 6 if scheme == "loop" else n > 4)


@pytest.mark.parametrize(("scheme", "name"), [("loop", "crowded"), ("catmull-clark", "extruded")])
def test_frames_are_orthonormal_and_scale_as_they_should(scheme, name):
    surface = surface_of(scheme, name)
    face, uv = inside(surface.domain)
    found = surface.curvatures(face, uv)
    frame = np.stack([found.minimum_direction, found.maximum_direction, found.normal], axis=1)
    np.testing.assert_allclose(frame @ frame.transpose(0, 2, 1), np.tile(np.eye(3), (len(face), 1, 1)), atol=1e-12)
    np.testing.assert_allclose(found.normal, surface.normals(face, uv), atol=1e-12)
    larger = surface.with_points(8 * surface.control_mesh.points).curvatures(face, uv)
    np.testing.assert_allclose(8 * larger.maximum, found.maximum, rtol=1e-10, atol=1e-9)
    mirrored = surface.with_points(surface.control_mesh.points * [-1, 1, 1]).curvatures(face, uv)
    np.testing.assert_allclose(-mirrored.minimum, found.maximum, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(("scheme", "name"), SOME)
def test_undefined_at_irregular_corners_alone(scheme, name):
    """Where the scheme's derivatives vanish or diverge curvature is nan; the normal is the tangents' own."""
    surface = surface_of(scheme, name)
    domain, table = surface.domain, surface.compiled.table
    cell, corner = np.nonzero(domain.present)
    uv = np.array([CORNERS[int(domain.shape[c])][k] for c, k in zip(cell, corner, strict=True)])
    irregular = np.zeros(len(cell), bool)
    for row, (c, k) in enumerate(zip(cell, corner, strict=True)):
        patch = table.cell_node[c]
        while patch < 0:
            patch = table.node_children[~patch, k]
        irregular[row] = table.type_levels[table.patch_type[patch]] > 0 and table.patch_corner[patch] == k
    found = surface.curvatures(cell, uv)
    np.testing.assert_array_equal(found.normal, surface.normals(cell, uv))
    for value in (found.minimum, found.maximum, found.maximum_direction[:, 0]):
        assert np.isnan(value[irregular]).all()
        assert np.isfinite(value[~irregular]).all()
    face, inner = inside(domain, per_cell=2)
    assert np.isfinite(surface.curvatures(face, inner).minimum).all()
