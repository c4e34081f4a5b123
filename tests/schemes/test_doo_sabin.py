"""Doo-Sabin's own truths: masks and spectra, tensor-product B-splines, curves, limits, and what is refused."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from shapes.curved import CURVED
from shapes.parameters import anywhere, face_corners, inside, size, surface_of
from shapes.polygons import prism, quad_grid_data
from shapes.zoo import circle, fan_faces, grid_data, mesh_of, scattered
from subdfit.errors import InputError
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.schemes import SCHEMES
from subdfit.schemes._doo_sabin_masks import (
    averaging_mask,
    half_mask,
    mirrored_polygon,
    original_mask,
    quarter_mask,
)

BOTH = ("doo-sabin", "doo-sabin-averaging")
CLOSED = ("tetrahedron", "prism 5", "prism 8", "house", "quad torus 4 6", "extruded")


def eigenvalues(mask):
    return np.sort(np.linalg.eigvals(mask).real)[::-1]


# Masks


@pytest.mark.parametrize("m", [3, 4, 5, 7, 12])
def test_spectra_of_both_masks(m):
    assert eigenvalues(original_mask(m)) == pytest.approx([1, 1 / 2, 1 / 2, *[1 / 4] * (m - 3)])
    averaged = np.r_[1, 1 / 2 + np.cos(2 * np.pi * np.arange(1, m) / m) / 4]
    assert eigenvalues(averaging_mask(m)) == pytest.approx(np.sort(averaged)[::-1])


@pytest.mark.parametrize("m", [3, 4, 6])
def test_the_averaging_mask_is_the_mean_of_corner_midpoints_and_centroid(m):
    unit = np.eye(m)
    middle = (unit + np.roll(unit, -1, axis=0)) / 2
    expected = (unit + unit.mean(axis=0) + middle + np.roll(middle, 1, axis=0)) / 4
    np.testing.assert_allclose(averaging_mask(m), expected, atol=1e-15)
    assert np.allclose(original_mask(m), averaging_mask(m)) == (m == 4)


def test_halves_and_quarters_of_quads_are_tensor_products():
    along, across = np.array([[3, 1], [1, 3]]) / 4, np.array([[1, 0], [1 / 2, 1 / 2]])
    # Corners A, B, y1 over B, y2 over A.
    order = [0, 1, 3, 2]
    np.testing.assert_allclose(half_mask(4), np.kron(across, along)[np.ix_(order, order)], atol=1e-15)
    np.testing.assert_allclose(quarter_mask(4), np.kron(across, across)[np.ix_(order, order)], atol=1e-15)


@pytest.mark.parametrize("m", [4, 5, 6, 9])
def test_a_half_with_its_mirror_image_is_a_polygon_under_the_original_mask(m):
    whole = mirrored_polygon(m)
    np.testing.assert_allclose(original_mask(2 * (m - 2)) @ whole, whole @ half_mask(m), atol=1e-14)
    assert half_mask(m).sum(axis=1) == pytest.approx(1)
    assert half_mask(m).min() > -1e-15
    assert eigenvalues(half_mask(m)) == pytest.approx([1, 1 / 2, 1 / 2, *[1 / 4] * (m - 3)])


# Quads: B-splines


def knots(faces):
    """Clamped knots over which the faces' middles are whole numbers from 0 to faces - 1."""
    return np.concatenate([[0, 0], np.arange(faces), [faces - 1] * 2]).astype(float)


def grid(height, width, points):
    """Quads over (height + 1) x (width + 1) points."""
    _, faces = quad_grid_data(height, width)
    topology = Topology.from_faces(np.arange(0, 4 * len(faces) + 1, 4), np.ravel(faces), len(points))
    return LimitSurface(ControlMesh(topology, points), "doo-sabin")


def spline_parameters(surface, height, width, cell, uv):
    """Where parameters of cells lie on the tensor-product spline, (k, 2)."""
    t = surface.topology
    h = face_corners(t)[cell]
    size = [width, height]
    vertex = np.column_stack([t.face_vertices[h] % (width + 1), t.face_vertices[h] // (width + 1)])
    start = np.clip(vertex - 0.5, 0, np.array(size) - 1)
    middle = np.column_stack([t.face[h] % width, t.face[h] // width]).astype(float)
    along_x = (h % 2 == 0)[:, None]
    share = np.where(along_x, uv, uv[:, ::-1])
    return start + share * (middle - start)


@pytest.mark.parametrize(("height", "width"), [(2, 2), (3, 5), (6, 4)])
def test_open_quads_are_the_clamped_biquadratic_spline(height, width):
    points = np.random.default_rng(0).normal(size=((height + 1) * (width + 1), 3))
    surface = grid(height, width, points)
    cell, uv = anywhere(surface.domain)
    value = surface.evaluate(cell, uv, 1)
    x, y = spline_parameters(surface, height, width, cell, uv).T
    control = points.reshape(height + 1, width + 1, 3)
    rows = BSpline.design_matrix(np.clip(x, 0, width - 1), knots(width), 2).toarray()
    columns = BSpline.design_matrix(np.clip(y, 0, height - 1), knots(height), 2).toarray()
    expected = np.einsum("ki,kj,jix->kx", rows, columns, control)
    np.testing.assert_allclose(value.position, expected, atol=1e-13)


def test_quadratics_are_reproduced_up_to_the_boundary():
    """The control value of x^2 is the product of a basis function's inner knots (its polar form), of x their mean."""
    height, width = 5, 6
    x, y = np.meshgrid(np.arange(width + 1), np.arange(height + 1))
    tx, ty = knots(width), knots(height)
    mean = [(tx[x + 1] + tx[x + 2]) / 2, (ty[y + 1] + ty[y + 2]) / 2]
    square = tx[x + 1] * tx[x + 2] - 2 * mean[0] * mean[1] + 0.5 * ty[y + 1] * ty[y + 2]
    surface = grid(height, width, np.stack([*mean, square], axis=2).reshape(-1, 3))
    cell, uv = anywhere(surface.domain)
    px, py, pz = surface.evaluate(cell, uv).position.T
    np.testing.assert_allclose(pz, px**2 - 2 * px * py + 0.5 * py**2, atol=1e-12)


def test_each_side_of_a_creased_box_is_a_bezier_patch():
    surface = surface_of("doo-sabin", "box")
    t, points = surface.topology, surface.control_mesh.points
    assert surface.domain.face_count == 24
    for side in range(6):
        faces = np.arange(4 * side, 4 * side + 4)
        corners = np.array([t.face_vertices[t.face_offsets[f] : t.face_offsets[f + 1]] for f in faces])
        middle = next(v for v in corners[0] if (corners == v).any(axis=1).all())
        cells = np.flatnonzero(np.isin(t.face[face_corners(t)], faces))
        # The four cells meet in the patch's middle, from where each reaches a corner.
        for cell in cells:
            h = face_corners(t)[cell]
            assert t.face_vertices[h] == middle
            ring = [t.face_vertices[h], *(t.face_vertices[g] for g in walk(t, h, 3))]
            value = surface.evaluate([cell] * 2, [[0, 0], [1, 1]]).position
            rim = points[[v for v in np.unique(corners) if v != middle]]
            ends = [v for v in np.unique(corners) if (corners == v).sum() == 1]
            edges = [v for v in np.unique(corners) if (corners == v).sum() == 2]
            bezier = (4 * points[middle] + points[ends].sum(axis=0) + 2 * points[edges].sum(axis=0)) / 16
            assert len(rim) == 8
            np.testing.assert_allclose(value[0], bezier, atol=1e-14)
            np.testing.assert_allclose(value[1], points[ring[2]], atol=1e-14)


def walk(t, h, count):
    """The half-edges after one."""
    found = []
    for _ in range(count):
        h = t.following[h]
        found.append(h)
    return found


# Curves


def quadratic(a, b, c, t):
    """The uniform quadratic B-spline's span of three control points."""
    return (1 - t) ** 2 / 2 * a + (0.5 + t - t**2) * b + t**2 / 2 * c


@pytest.mark.parametrize(
    "name", ["open dodecahedron", "torus crease", "fan 5", "ring of quads", "crease ring", "annulus"]
)
def test_curves_are_quadratic_splines_of_their_polygons(name):
    surface = surface_of("doo-sabin", name)
    t, points, domain = surface.topology, surface.control_mesh.points, surface.domain
    sharp = t.edge_vertices[t.sharpness > 0]
    near = {v: {int(w) for e in sharp for w in e if v in e and w != v} for v in np.unique(sharp)}
    checked = 0
    for cell, side in zip(*np.nonzero(domain.sharp), strict=True):
        vertex = domain.vertex[cell, side]
        if vertex < 0 or len(near[vertex]) != 2:
            continue
        corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
        begin, end = corners[side], corners[(side + 1) % 4]
        share = np.array([0, 0.3, 0.8, 1])
        value = surface.evaluate([cell] * 4, begin + share[:, None] * (end - begin)).position
        a, b = (points[v] for v in near[vertex])
        # From the vertex' limit, in the middle of its span, to one of the span's ends.
        t_along = 0.5 + share[:, None] / 2
        gaps = [np.abs(value - quadratic(p, points[vertex], q, t_along)).max() for p, q in ((a, b), (b, a))]
        assert min(gaps) < 1e-13
        checked += 1
    assert checked >= len(near)


def tip_sides(surface):
    """Sides of cells along creases that end inside the surface, seen from both cells, and whether they begin there."""
    domain = surface.domain
    cell, side = np.nonzero(domain.sharp)
    once = (domain.neighbour[cell, side] < 0) | (domain.neighbour[cell, side] < cell)
    cell, side = cell[once], side[once]
    ends = np.array([surface.evaluate(cell, domain.along(cell, side, np.full(len(cell), t))).position for t in (0, 1)])
    _, number, count = np.unique(ends.reshape(-1, 3).round(9), axis=0, return_inverse=True, return_counts=True)
    single = count[number].reshape(2, -1) == 1
    chosen = single.any(axis=0)
    beyond, other = domain.neighbour[cell, side], domain.neighbour_side[cell, side]
    return cell[chosen], side[chosen], beyond[chosen], other[chosen], single[0, chosen]


@pytest.mark.parametrize("scheme", BOTH)
@pytest.mark.parametrize("name", ["quad dart 3", "quad dart 4", "dart 5", "boundary dart 6", "tip"])
def test_creases_fade_towards_their_tips(scheme, name):
    """The angle between both sides shrinks with the distance: the tangents' eigenvalue exceeds all that bend."""
    surface = surface_of(scheme, name)
    cell, side, beyond, other, begins = tip_sides(surface)
    assert len(cell) == (1 if name == "boundary dart 6" else 2)
    angle = []
    for share in (0.5, 2.0**-10, 2.0**-20):
        t = np.where(begins, share, 1 - share)
        here = surface.normals(cell, surface.domain.along(cell, side, t))
        there = surface.normals(beyond, surface.domain.along(beyond, other, 1 - t))
        angle.append(np.linalg.norm(np.cross(here, there), axis=1))
    assert angle[0].min() > 0.1
    # Original: 2^-level, times level where the eigenvalue has chains; averaging: mu / lambda = .677 in a heptagon.
    slowest = 2.0**-10 * 20 if scheme == "doo-sabin" else 0.68**10
    assert (angle[1] < 2 * slowest).all()
    assert (angle[2] < 2 * slowest**2).all()


@pytest.mark.parametrize("name", ["quad disc", "disc", "starred fan", "box", "lone pair", "pentagon corner"])
def test_corners_are_interpolated(name):
    surface = surface_of("doo-sabin", name)
    t = surface.topology
    sharp = np.bincount(t.edge_vertices[t.sharpness > 0].ravel(), minlength=t.vertex_count)
    corner = (sharp >= 3) | ((sharp == 2) & (t.valence == 1)) | (t.corner_sharpness > 0)
    assert corner.any()
    np.testing.assert_allclose(surface.vertex_limits()[corner], surface.control_mesh.points[corner], atol=1e-15)


def flat(surface):
    """The same connectivity, flattened to the plane z = 0."""
    return surface.with_points(surface.control_mesh.points * [1, 1, 0])


@pytest.mark.parametrize("scheme", BOTH)
@pytest.mark.parametrize(
    "name", ["fan 3", "fan 5", "fan 8", "quad fan 3", "quad fan 5", "disc", "quad disc", "single 6"]
)
def test_plane_meshes_have_plane_surfaces_without_folds(scheme, name):
    """The cross derivative does not vanish at the boundary, nor does the surface turn round."""
    surface = flat(LimitSurface(mesh_of(name), scheme))
    cell, uv = anywhere(surface.domain, nearest=5.0)
    first = surface.evaluate(cell, uv, 1).first
    area = np.cross(first[:, 0], first[:, 1])[:, 2]
    assert (np.sign(area) == np.sign(area[0])).all()
    # Towards a middle, derivatives under the averaging mask vanish or grow without bounds.
    assert np.abs(area).min() > (1e-3 if scheme == "doo-sabin" else 1e-5) * np.median(np.abs(area))


# Limits and refinement


@pytest.mark.parametrize("scheme", BOTH)
@pytest.mark.parametrize("name", CLOSED)
def test_eigenvalues_of_the_limit_operator(scheme, name):
    """In [1/4, 1]; of triangles at least 1/2 (original) and 3/8 (averaging)."""
    mesh = mesh_of(name)
    values = np.linalg.eigvals(SCHEMES[scheme].limit_rows(mesh.topology).toarray())
    least = 1 / 4
    if mesh.topology.triangles_only:
        least = 1 / 2 if scheme == "doo-sabin" else 3 / 8
    assert np.abs(values.imag).max() < 1e-12
    assert least - 1e-12 < values.real.min()
    assert values.real.max() < 1 + 1e-12


@pytest.mark.parametrize("scheme", BOTH)
@pytest.mark.parametrize("name", ["prism 5", "open dodecahedron", "disc"])
def test_refined_points_approach_their_limits_four_times_a_step(scheme, name):
    rules, mesh = SCHEMES[scheme], mesh_of(name)
    topology, points, far = mesh.topology, mesh.points, []
    for _ in range(5):
        step = rules.refine(topology)
        topology, points = step.child, step.refined(points)
        far.append(np.median(np.linalg.norm(rules.limit_rows(topology) @ points - points, axis=1)))
    assert far[-2] / far[-1] == pytest.approx(4, rel=0.1)


def test_faces_at_an_inner_vertex_of_two_faces_are_cut_at_their_centroids():
    mesh = mesh_of("quad fan 2")
    rules = SCHEMES["doo-sabin"]
    child = rules.refine(mesh.topology).child
    assert mesh.topology.valence[0] == 2
    # Eight triangles and ten smooth edges; strips on four edges of the boundary; seven vertices and centroids.
    assert child.face_count == 8 + 10 + 4 + 7
    domain = rules.domain(mesh.topology)
    assert set(np.unique(domain.vertex)) == {-1, *range(mesh.topology.vertex_count)}


@pytest.mark.parametrize("name", ["house", "hanging", "quad fan 5", "torus crease"])
def test_children_stand_for_faces_edges_and_vertices(name):
    t = mesh_of(name).topology
    child = SCHEMES["doo-sabin"].refine(t).child
    on_curve = np.isin(np.arange(t.vertex_count), t.edge_vertices[t.sharpness > 0])
    if not (t.sharpness > 0).any() or name in ("quad fan 5",):
        assert child.vertex_count == len(t.face_vertices)
    if name in ("house", "quad fan 5", "torus crease"):
        assert child.face_count == t.face_count + (t.sharpness == 0).sum() + (~on_curve).sum()
    offsets = child.face_offsets[: t.face_count + 1]
    assert (np.diff(offsets) == np.diff(t.face_offsets)).all()


def test_matrix_and_matrix_free_refinement_agree():
    for name in [*CLOSED, *CURVED]:
        mesh = mesh_of(name)
        step = SCHEMES["doo-sabin-averaging"].refine(mesh.topology)
        assert np.abs(step.matrix @ mesh.points - step.refined(mesh.points)).max() < 1e-14


def test_masks_differ_only_where_faces_are_no_quads():
    mesh = mesh_of("quad disc")
    cell, uv = inside(SCHEMES["doo-sabin"].domain(mesh.topology))
    values = [LimitSurface(mesh, scheme).evaluate(cell, uv).position for scheme in BOTH]
    np.testing.assert_allclose(*values, rtol=0, atol=1e-14)
    house = mesh_of("house")
    cell, uv = inside(SCHEMES["doo-sabin"].domain(house.topology))
    values = [LimitSurface(house, scheme).evaluate(cell, uv).position for scheme in BOTH]
    assert np.abs(values[0] - values[1]).max() > 1e-3 * size(house)


@pytest.mark.parametrize(("m", "size"), [(3, 1), (4, 1), (5, 2), (6, 2), (8, 2)])
def test_the_eigenvalue_of_curvature_has_chains_from_pentagons_on(m, size):
    """Beyond the face itself, each of its quads brings 1/4 too: from five corners on they join in Jordan blocks."""
    shifted = ring_matrix(m) - np.eye(4 * m) / 4
    ranks = [np.linalg.matrix_rank(np.linalg.matrix_power(shifted, k), tol=1e-9) for k in (1, 2, 3)]
    assert (ranks[0] > ranks[1]) == (size > 1)
    assert ranks[1] == ranks[2]


def ring_matrix(m):
    """One step towards a face: its corners, then for each the next corners of its quads, two beside, one opposite."""
    matrix = np.zeros((4 * m, 4 * m))
    matrix[:m, :m] = original_mask(m)
    for i in range(m):
        beside, beyond, opposite = m + 3 * i, m + 3 * i + 1, m + 3 * i + 2
        edge = [i, (i + 1) % m, beyond, beside]
        matrix[beside, edge], matrix[beyond, edge] = original_mask(4)[:2]
        matrix[opposite, [i, m + 3 * ((i - 1) % m) + 1, opposite, beside]] = original_mask(4)[0]
    return matrix


def curvatures_into_face(scheme, m):
    """Curvatures towards the middle of an m-gon, at levels 18, 30 and 42; points strewn have every frequency."""
    surface = LimitSurface(scattered(prism(m)), scheme)
    cell = np.flatnonzero(surface.topology.face[face_corners(surface.topology)] == 0)[:1]
    near = [[[1 - t, 1 - 0.6 * t]] for t in 2.0 ** -np.array([18, 30, 42])]
    return np.array([curvature(surface, cell, np.array(uv)) for uv in near])


def test_the_original_masks_curvature_is_bounded_in_a_triangle():
    near = curvatures_into_face("doo-sabin", 3)
    assert np.ptp(near) < 1e-2 * near[0]


@pytest.mark.parametrize("m", [5, 6, 7, 8])
def test_the_original_masks_curvature_is_like_the_logarithm_in_larger_faces(m):
    steps = np.diff(curvatures_into_face("doo-sabin", m))
    assert steps[0] > 0
    assert steps[0] == pytest.approx(steps[1], rel=0.05)


@pytest.mark.parametrize("m", [3, 5, 6, 7, 8])
def test_the_averaging_masks_curvature_is_a_power_of_the_distance(m):
    """The power is that of mu / lambda^2 a level: 1.78, then .893, .960, 1.033 and 1.092.

    lambda is 1/2 + cos(2 pi / m) / 4 and mu is 1/2 + cos(4 pi / m) / 4, but in a triangle the 1/4 of quads' quadratics.
    """
    tangents, bending = (1 / 2 + np.cos(2 * np.pi * k / m) / 4 for k in (1, 2))
    factor = (bending if m > 3 else 1 / 4) / tangents**2
    assert (factor > 1) == (m not in (5, 6))
    near = curvatures_into_face("doo-sabin-averaging", m)
    assert near[2] / near[1] == pytest.approx(factor**12, rel=0.02)


def curvature(surface, cell, uv):
    """Root of the sum of squares of the principal curvatures."""
    _, first, second = (array[0] for array in surface.evaluate(cell, uv, 2))
    normal = np.cross(*first) / np.linalg.norm(np.cross(*first))
    shape = np.linalg.solve(first @ first.T, (second @ normal)[[0, 1, 1, 2]].reshape(2, 2))
    return np.sqrt(np.trace(shape @ shape))


# What is refused


def test_what_is_refused():
    rules = SCHEMES["doo-sabin"]
    apex = np.vstack([[0, 0, 1.0], circle(6)])
    dart = ControlMesh.from_triangles(apex, fan_faces(6), crease_edges=[[0, 1]], corner_vertices=[0])
    inner = ControlMesh.from_triangles(apex, fan_faces(6), corner_vertices=[0])
    semi = ControlMesh.from_triangles(apex, fan_faces(6), crease_edges=[[0, 1], [0, 4]], crease_sharpness=[2, 2])
    for mesh, why in [(dart, "where a crease ends"), (inner, "tagged a corner"), (semi, "sharp for ever")]:
        with pytest.raises(InputError, match=why):
            rules.validate(mesh.topology)


def test_a_mesh_of_one_row_of_triangles_is_taken():
    points, faces = grid_data(1, 5)
    surface = LimitSurface(ControlMesh.from_triangles(points, faces), "doo-sabin")
    cell, uv = anywhere(surface.domain)
    value = surface.evaluate(cell, uv).position
    assert np.abs(value[:, 2]).max() < 1e-15
    assert value.min() > -1e-14
