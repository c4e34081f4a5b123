"""The quad-triangle scheme's own truths: published numbers, spectra, both pure schemes, strips beside seams."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from shapes.mixed import MIXED, ORDERS, ladder_data, mixed_fan, mixed_torus
from shapes.parameters import anywhere, inside, size, surface_of
from shapes.polygons import polygons
from shapes.zoo import mesh_of
from subdfit.errors import InputError
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.schemes import SCHEMES
from subdfit.schemes._level import Level
from subdfit.schemes._quad_triangle_kinds import Corner, Regular, Strip, groups
from subdfit.schemes._quad_triangle_masks import correction, ring_matrix
from subdfit.schemes._quad_triangle_parts import parts
from subdfit.schemes._quad_triangle_strips import NEAR, STRIPS, strips

SCHEME = SCHEMES["quad-triangle"]

PUBLISHED = {(2, 1): -0.20505, (3, 1): 0.80597, (3, 2): 0.61539, (4, 1): 0.34792, (4, 2): 0.21380, (4, 3): 0.10550}
"""Stam and Loop's corrections by valence and number of quads (2003, section 5)."""


def spectrum(order, eta=None):
    """Eigenvalues of a vertex and its ring, largest first."""
    values = np.linalg.eigvals(ring_matrix(order, correction(order) if eta is None else eta))
    assert np.abs(values.imag).max() < 1e-7
    return np.sort(values.real)[::-1]


# Masks and spectra


def test_the_regular_seam_needs_no_correction():
    assert correction("TTTQQ") == 0
    values = spectrum("TTTQQ")
    assert values[:6] == pytest.approx([1, 1 / 2, 1 / 2, 1 / 4, 1 / 4, 1 / 4], abs=1e-9)
    assert values[6] < 1 / 4


def test_masks_along_a_regular_seam():
    """Times 64: 38 itself, 5 along the seam, 6 among quads, 4 among triangles, 1 at far corners; edges times 16."""
    mesh = mixed_fan("TTTQQ")
    rows = SCHEME.refine(mesh.topology).matrix.toarray()
    assert rows[0] == pytest.approx(np.array([38, 5, 4, 4, 5, 6, 1, 1]) / 64, abs=1e-15)
    t = mesh.topology
    seam = next(e for e, ends in enumerate(t.edge_vertices) if set(ends) == {0, 1})
    far = [v for v in range(t.vertex_count) if v in (6, 7) and {1, v} in [set(e) for e in t.edge_vertices.tolist()]]
    expected = np.zeros(t.vertex_count)
    expected[[0, 1, 2, 5, far[0]]] = np.array([6, 6, 2, 1, 1]) / 16
    assert rows[t.vertex_count + seam] == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize(("order", "key"), [("QT", (2, 1)), ("QTTT", (4, 1)), ("QQTT", (4, 2)), ("QQQT", (4, 3))])
def test_published_corrections_meet_their_aim(order, key):
    """The third eigenvalue is the square of the first, as far as five printed digits go."""
    values = np.sort(np.abs(np.linalg.eigvals(ring_matrix(order, PUBLISHED[key]))))[::-1]
    assert values[3] == pytest.approx(values[1] ** 2, abs=2e-4)
    if key[0] > 2:
        assert correction(order) == pytest.approx(PUBLISHED[key], abs=2e-4)


@pytest.mark.parametrize(("order", "key"), [("QTT", (3, 1)), ("QQT", (3, 2))])
def test_three_faces_get_the_published_correction_which_makes_the_matrix_singular(order, key):
    assert correction(order) == pytest.approx(PUBLISHED[key], abs=1e-5)
    values = spectrum(order)
    assert values[-1] == pytest.approx(0, abs=1e-12)
    assert values[3] > values[1] ** 2


def test_alternating_faces_need_another_correction():
    assert correction("QTQT") == correction("TQTQ") == pytest.approx(0.27026, abs=1e-5)
    values = spectrum("QTQT")
    assert values[3] == pytest.approx(values[1] ** 2, abs=1e-10)


def mixed_orders(longest):
    """All orders of faces of both shapes, one for each that is the same but for its beginning."""
    words = ("".join(word) for n in range(3, longest + 1) for word in product("QT", repeat=n))
    return [w for w in words if len(set(w)) == 2 and w == min(w[i:] + w[:i] for i in range(len(w)))]


@pytest.mark.parametrize("order", mixed_orders(6))
def test_every_order_makes_a_tangent_plane_and_loses_nothing_to_its_correction(order):
    values, plain = spectrum(order), spectrum(order, 0.0)
    assert values[0] == pytest.approx(1, abs=1e-12)
    assert values[1] < 1 - 1e-9
    assert values[2] > values[3] + 0.01
    assert values[-1] > -1e-12
    assert values[3] <= plain[3] + 1e-12
    bounded = values[3] <= values[1] ** 2 + 1e-9
    assert bounded == (len(order) in (4, 5) and order not in ("QQQQT", "QQQTT", "QQTQT"))


@pytest.mark.parametrize("order", ORDERS)
def test_refinement_round_a_vertex_has_the_spectrum_of_its_ring(order):
    """The scheme itself, on a mesh, against the matrix that the correction is computed from."""
    t = mixed_fan(order).topology
    step = SCHEME.refine(t)
    edges = [next(e for e, ends in enumerate(t.edge_vertices) if set(ends) == {0, 1 + i}) for i in range(len(order))]
    centroids = t.vertex_count + t.edge_count + np.arange(order.count("Q"))
    ring = np.r_[0, step.edge_row[edges], centroids]
    matrix = step.matrix.toarray()[ring]
    values = np.sort(np.abs(np.linalg.eigvals(matrix)))[::-1]
    assert values == pytest.approx(np.sort(np.abs(spectrum(order)))[::-1], abs=1e-8)


def test_flat_grids_stay_as_they_are_across_a_seam():
    """Linear precision: a regular grid's limit is the grid, its triangles isosceles with their bases along the seam."""
    points, faces = ladder_data("QQQQTTTT", 8)
    mesh = polygons((points, faces), "flat ladder")
    isosceles = points[:, :2] - np.outer(np.maximum(points[:, 1] - 4, 0) / 2, [1, 0])
    sheared = isosceles @ np.array([[1, 0.2, 0.5], [0.1, 1, -0.3]])
    surface = LimitSurface(mesh.with_points(sheared), SCHEME)
    face, uv = inside(surface.domain)
    # The corners of the boundary's square are rounded.
    far = np.all(np.abs(points[surface.domain.vertex[face]][:, :3, :2] - 4) <= 2, axis=(1, 2))
    face, uv = face[far], uv[far]
    corners = sheared[surface.domain.vertex[face]]
    u, v = uv.T[:, :, None]
    last = np.where((surface.domain.shape[face] == 3)[:, None], corners[:, 2], corners[:, 3])
    expected = corners[:, 0] + u * (corners[:, 1] - corners[:, 0]) + v * (last - corners[:, 0])
    assert len(face) > 100
    assert np.abs(surface.evaluate(face, uv).position - expected).max() < 1e-14 * 10


# Both pure schemes


def same_refinement(mesh, other):
    one, two = SCHEME.refine(mesh.topology), other.refine(mesh.topology)
    np.testing.assert_array_equal(one.child.face_offsets, two.child.face_offsets)
    np.testing.assert_array_equal(one.child.face_vertices, two.child.face_vertices)
    np.testing.assert_array_equal(one.child.twin, two.child.twin)
    ends = [
        {tuple(sorted(e)): s for e, s in zip(c.edge_vertices.tolist(), c.sharpness, strict=True)}
        for c in (one.child, two.child)
    ]
    assert ends[0] == ends[1]
    assert np.abs((one.matrix - two.matrix).toarray()).max() < 1e-15
    return np.abs((SCHEME.limit_rows(mesh.topology) - other.limit_rows(mesh.topology)).toarray()).max()


@pytest.mark.parametrize("name", ["pyramid 7", "tagged sphere 0", "disc", "boundary dart 6", "star 5", "semi 0"])
def test_equals_loop_on_triangles(name):
    mesh = mesh_of(name)
    assert same_refinement(mesh, SCHEMES["loop"]) < 2e-15
    check_same_surface(mesh, "loop")


@pytest.mark.parametrize(
    "name", ["prism 4", "rhombic 5", "extruded", "tagged quads 1", "quad dart 4", "quad parted 6 2", "semi quads 1"]
)
def test_equals_catmull_clark_on_quads(name):
    mesh = mesh_of(name)
    assert same_refinement(mesh, SCHEMES["catmull-clark"]) < 2e-15
    check_same_surface(mesh, "catmull-clark")


@pytest.mark.parametrize("name", ["hanging", "single 6", "prism 8"])
def test_equals_catmull_clark_on_larger_polygons_too(name):
    mesh = mesh_of(name)
    assert same_refinement(mesh, SCHEMES["catmull-clark"]) < 2e-15
    check_same_surface(mesh, "catmull-clark")


def check_same_surface(mesh, name):
    one, two = LimitSurface(mesh, SCHEME), LimitSurface(mesh, name)
    face, uv = anywhere(one.domain, nearest=3.0)
    found, expected = one.evaluate(face, uv, 2), two.evaluate(face, uv, 2)
    assert np.abs(found.position - expected.position).max() < 1e-13 * size(mesh)
    for values, others in [(found.first, expected.first), (found.second, expected.second)]:
        scale = np.maximum(np.abs(others).max(axis=(1, 2)), size(mesh))[:, None, None]
        assert (np.abs(values - others) / scale).max() < 1e-11


# Patches and strips


@pytest.mark.parametrize("name", MIXED)
def test_after_one_step_every_face_is_a_patch(name):
    """Unless a rule is going to change."""
    step = SCHEME.refine(mesh_of(name).topology)
    level = Level.of(step.child)
    found = groups(level, np.arange(step.child.face_count))
    listed = np.sort(np.concatenate([group.rows for group in found]))
    soft = level.semi_sharp[step.child.face_vertices]
    expected = np.setdiff1d(np.arange(step.child.face_count), step.child.face[soft])
    np.testing.assert_array_equal(listed, expected)


def test_only_cells_beside_seams_are_strips():
    surface = LimitSurface(mixed_torus("QQQTTT", 5), SCHEME)
    table, rows = surface.compiled.table, np.repeat([0, 1, 2, 3, 4, 5], [5, 5, 5, 10, 10, 10])
    strip = table.type_strips[table.patch_type[table.cell_node], 0] >= 0
    np.testing.assert_array_equal(strip, np.isin(rows, [0, 2, 3, 5]))


@pytest.mark.parametrize("kind", [Strip(3, 0), Strip(3, 1), Strip(3, 2), Strip(3, 3), Strip(4, 0)])
def test_strips_are_closed_under_refinement(kind):
    for part in parts([kind])[0]:
        assert isinstance(part.kind, Regular | Strip)
        np.testing.assert_allclose(part.matrix.sum(axis=1), 1, rtol=0, atol=1e-15)


def test_strip_matrices_keep_constants_to_the_last_digit():
    """The first number is a point, the others are relative to it."""
    first = strips().matrices.reshape(-1, 16, 16)[:, 0]
    np.testing.assert_array_equal(first, np.broadcast_to(np.eye(16)[0], first.shape))


def with_strips(surface, **changes):
    table = surface.compiled.table
    compiled = replace(surface.compiled)
    vars(compiled)["table"] = replace(table, strips=table.strips._replace(**changes))
    other = object.__new__(LimitSurface)
    other._set(compiled, surface.control_mesh)
    return other


def on_seams(surface, count=8):
    """Random places on sides where a triangle meets a quad: both cells and parameters."""
    domain, random = surface.domain, np.random.default_rng(0)
    face, side = np.nonzero((domain.neighbour >= 0) & ~domain.sharp)
    chosen = domain.shape[face] < domain.shape[domain.neighbour[face, side]]
    face, side = np.repeat(face[chosen], count), np.repeat(side[chosen], count)
    t = random.random(len(face))
    beyond, other = domain.neighbour[face, side], domain.neighbour_side[face, side]
    return (face, domain.along(face, side, t)), (beyond, domain.along(beyond, other, 1 - t))


SEAMED = ["mixed torus QQTT", "seam sphere 1", "mixed fan QQTQTTQT", "dart across a seam", "mixed half fan QQTT"]


@pytest.mark.parametrize("name", SEAMED)
def test_strips_err_by_far_less_than_the_stated_bound(name):
    """On the seams themselves, where the error is largest, against strips followed until nothing is left of them.

    A level divides the error of positions by six and more, and that of derivatives by four; the bound is 1e-8.
    """
    surface, length = surface_of("quad-triangle", name), size(mesh_of(name))
    for face, uv in on_seams(surface):
        exact = with_strips(surface, levels=40).evaluate(face, uv, 1)
        found = [with_strips(surface, levels=levels).evaluate(face, uv, 1) for levels in (4, 6, 8, 10)]
        position = np.array([np.abs(f.position - exact.position).max() for f in found])
        scale = np.maximum(np.abs(exact.first).max(axis=(1, 2)), length)[:, None, None]
        first = np.array([(np.abs(f.first - exact.first) / scale).max() for f in found])
        assert position[-1] < position[0] / 6.0**6
        assert first[-1] < first[0] / 3.5**6
        value = surface.evaluate(face, uv, 1)
        assert np.abs(value.position - exact.position).max() < 1e-14 * length
        assert (np.abs(value.first - exact.first) / scale).max() < 1e-11


@pytest.mark.parametrize("name", SEAMED)
def test_several_levels_at_once_are_as_good_as_one_by_one(name):
    surface = surface_of("quad-triangle", name)
    single = with_strips(surface, sides=np.full_like(strips().sides, -1))
    for face, uv in on_seams(surface):
        value, expected = surface.evaluate(face, uv, 1), single.evaluate(face, uv, 1)
        assert np.abs(value.position - expected.position).max() < 1e-14 * size(mesh_of(name))
        assert np.abs(value.first - expected.first).max() < 1e-14 * np.abs(expected.first).max()
        assert np.abs(surface.weights(face, uv) - single.weights(face, uv)).max() < 1e-14


def test_second_derivatives_stay_bounded_towards_a_regular_seam():
    """They have no limit there, but the third eigenvalue 1/4 bounds them."""
    surface = surface_of("quad-triangle", "mixed torus QQTT")
    for face, uv in on_seams(surface):
        middle = np.where(surface.domain.shape[face] == 3, 1 / 3, 1 / 2)[:, None]
        sizes = [np.abs(surface.evaluate(face, uv + 2.0**-k * (middle - uv), 2).second).max() for k in range(2, 18)]
        assert max(sizes) < 2 * sizes[0]


def test_a_strip_touches_the_limit_in_its_corners():
    """The polynomial at the end has the exact limit points: those of `limit_rows`."""
    surface = surface_of("quad-triangle", "mixed torus QQTT")
    shallow = with_strips(surface, levels=0)
    face, corner = np.nonzero(surface.domain.present)
    uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])[corner]
    triangle = surface.domain.shape[face] == 3
    uv[triangle] = np.array([[0, 0], [1, 0], [0, 1.0], [0, 0]])[corner[triangle]]
    expected = surface.vertex_limits()[surface.domain.vertex[face, corner]]
    assert np.abs(shallow.evaluate(face, uv).position - expected).max() < 1e-14 * 10
    deep = surface.evaluate(face, uv, 1)
    assert np.abs(shallow.evaluate(face, uv, 1).first - deep.first).max() < 1e-13 * size(surface.control_mesh)


def test_there_is_a_strip_for_every_kind_and_turn():
    assert len(set(STRIPS)) == len(STRIPS) == len(strips().parts)
    assert strips().parts.max() < len(STRIPS)
    assert np.finfo(float).eps > 2.0**-NEAR


def test_corners_lead_to_polynomials_and_strips_alone():
    for order, position in [("QQTT", 0), ("TTQQ", 0), ("QTQT", 0), ("TQTQ", 0), ("TTTQ", 0)]:
        first, *others = parts([Corner(order, position, closed=True, dart=False, pinned=False)])[0]
        assert isinstance(first.kind, Corner)
        assert all(isinstance(part.kind, Regular | Strip) for part in others)


# What is refused


def test_valence_two_is_refused():
    mesh = ControlMesh(
        Topology.from_faces([0, 4, 7, 10, 13], [0, 1, 2, 3, 0, 3, 4, 3, 2, 4, 2, 1, 4], 5), np.zeros((5, 3))
    )
    SCHEME.validate(mesh.topology)
    thin = Topology.from_faces([0, 4, 8], [0, 1, 2, 3, 0, 3, 2, 4], 5)
    with pytest.raises(InputError, match="inner vertex 3 has valence 2"):
        SCHEME.validate(thin)
