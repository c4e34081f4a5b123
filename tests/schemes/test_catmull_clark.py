"""Catmull-Clark's own truths: masks, eigenvalues, precision, curves."""

import numpy as np
import pytest

from shapes.parameters import CORNERS, sides, size, surface_of
from shapes.polygons import POLYGONS, quad_grid_data
from shapes.zoo import mesh_of
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.schemes import SCHEMES
from subdfit.schemes._corner_type import CornerType
from subdfit.schemes._quad_patches import QuadPatches

CATMULL_CLARK = SCHEMES["catmull-clark"]


def faces_of(t):
    return [t.face_vertices[a:b] for a, b in zip(t.face_offsets[:-1], t.face_offsets[1:], strict=True)]


def centroid(t, face, scale=1.0):
    """A row with the weights of a face's centroid."""
    row = np.zeros(t.vertex_count)
    row[faces_of(t)[face]] = scale / len(faces_of(t)[face])
    return row


def round_vertex(t, v):
    """Neighbours of a vertex and the faces round it."""
    edges = t.edge_vertices[(t.edge_vertices == v).any(axis=1)]
    return edges[edges != v], np.flatnonzero([v in face for face in faces_of(t)])


# Masks


@pytest.mark.parametrize("name", ["quad fan 3", "quad fan 7", "prism 5", "hanging", "house"])
def test_face_edge_and_vertex_points(name):
    """Centroid; mean of the ends and the centroids beside; (Q + 2 R + (n - 3) V) / n with means Q, R of those."""
    t = mesh_of(name).topology
    rows, n, eye = CATMULL_CLARK.refine(t).matrix.toarray(), t.vertex_count, np.eye(t.vertex_count)
    inner = np.setdiff1d(np.arange(n), t.edge_vertices[t.boundary_edges])
    for v in inner:
        neighbours, faces = round_vertex(t, v)
        q = np.mean([centroid(t, f) for f in faces], axis=0)
        r = np.mean([(eye[v] + eye[w]) / 2 for w in neighbours], axis=0)
        valence = len(neighbours)
        np.testing.assert_allclose(rows[v], (q + 2 * r + (valence - 3) * eye[v]) / valence, atol=1e-15)
    for e, ends in enumerate(t.edge_vertices):
        middle = eye[ends].mean(axis=0)
        if t.boundary_edges[e]:
            np.testing.assert_allclose(rows[n + e], middle)
        else:
            inside = np.mean([centroid(t, f) for f in t.face[t.edge == e]], axis=0)
            np.testing.assert_allclose(rows[n + e], (middle + inside) / 2, atol=1e-15)
    for f in range(t.face_count):
        np.testing.assert_allclose(rows[n + t.edge_count + f], centroid(t, f), atol=1e-15)


@pytest.mark.parametrize("n", [3, 4, 5, 7])
def test_limit_among_quads(n):
    """Halstead, Kass and DeRose 1993: n / (n + 5), then 4 and 1 over n (n + 5) for neighbours and far corners."""
    row = CATMULL_CLARK.limit_rows(mesh_of(f"quad fan {n}").topology).toarray()[0]
    expected = np.r_[n * n, np.tile([4, 1], n)] / (n * (n + 5))
    np.testing.assert_allclose(row, expected, atol=1e-15)


@pytest.mark.parametrize("name", ["prism 3", "prism 5", "prism 8", "house", "hanging"])
def test_limit_among_any_polygons(name):
    """(n (n - 1) V + 2 sum E + 4 sum C) / (n (n + 5)): the quads' mask applied to what one refinement gives."""
    t = mesh_of(name).topology
    step = CATMULL_CLARK.refine(t)
    rows, fine = CATMULL_CLARK.limit_rows(t).toarray(), step.matrix.toarray()
    child_faces = faces_of(step.child)
    inner = np.setdiff1d(np.arange(t.vertex_count), t.edge_vertices[t.boundary_edges])
    assert len(inner)
    for v in inner:
        neighbours, faces = round_vertex(t, v)
        n, eye = len(neighbours), np.eye(t.vertex_count)
        formula = n * (n - 1) * eye[v] + 2 * eye[neighbours].sum(axis=0)
        formula += 4 * np.sum([centroid(t, f) for f in faces], axis=0)
        np.testing.assert_allclose(rows[v], formula / (n * (n + 5)), atol=1e-15)
        around = [face for face in child_faces if v in face]
        edges = np.unique([[np.roll(face, -list(face).index(v))[k] for k in (1, 3)] for face in around])
        far = [np.roll(face, -list(face).index(v))[2] for face in around]
        quads = n * n * fine[v] + 4 * fine[edges].sum(axis=0) + fine[far].sum(axis=0)
        np.testing.assert_allclose(rows[v], quads / (n * (n + 5)), atol=1e-15)


def test_boundary_crease_and_corner_rules():
    t = mesh_of("single 4").topology
    np.testing.assert_allclose(CATMULL_CLARK.refine(t).matrix.toarray()[:4] * 8, 6 * np.eye(4) + cyclic(4))
    np.testing.assert_allclose(CATMULL_CLARK.limit_rows(t).toarray() * 6, 4 * np.eye(4) + cyclic(4))
    crease = mesh_of("prism crease").topology
    for matrix, scale, own in [(CATMULL_CLARK.refine(crease).matrix, 8, 6), (CATMULL_CLARK.limit_rows(crease), 6, 4)]:
        rows = matrix.toarray()[5:10] * scale
        np.testing.assert_allclose(rows[:, 5:], own * np.eye(5) + cyclic(5), atol=1e-15)
        assert not rows[:, :5].any()
    for name, corner in [("quad star", 0), ("quad pinned", 12)]:
        t = mesh_of(name).topology
        for matrix in (CATMULL_CLARK.refine(t).matrix, CATMULL_CLARK.limit_rows(t)):
            np.testing.assert_array_equal(matrix.toarray()[corner], np.eye(t.vertex_count)[corner])


def cyclic(n):
    """One for each of the two neighbours on a closed curve."""
    return np.roll(np.eye(n), 1, axis=1) + np.roll(np.eye(n), -1, axis=1)


def dart_step(n):
    """Refinement of a dart of valence n among quads and its ring, by the rules: (2 n + 1, 2 n + 1).

    Rows and columns are the vertex, its neighbours from the sharp edge on, and the far corner after each neighbour.
    """
    eye = np.eye(2 * n + 1)
    vertex, edge, far = eye[0], eye[1 : n + 1], eye[n + 1 :]
    face = np.array([(vertex + edge[i] + edge[(i + 1) % n] + far[i]) / 4 for i in range(n)])
    middle = np.array([(vertex + edge[i] + face[i] + face[i - 1]) / 4 for i in range(n)])
    middle[0] = (vertex + edge[0]) / 2
    new = ((n - 2) * vertex + edge.mean(axis=0) + face.mean(axis=0)) / n
    return np.vstack([new, middle, face])


@pytest.mark.parametrize("n", [3, 4, 6])
def test_dart_limit_is_a_left_eigenvector_and_not_the_smooth_mask(n):
    values, vectors = np.linalg.eig(dart_step(n).T)
    mask = vectors[:, np.argmax(values.real)].real
    mask /= mask.sum()
    t = mesh_of(f"quad dart {n}").topology
    row = CATMULL_CLARK.limit_rows(t).toarray()[0]
    # In the trapezohedron neighbours of pole 0 are 2, 4, 6 .., the far corners between them 3, 5, 7 ..
    around = np.r_[0, 2 + 2 * np.arange(n), 3 + 2 * np.arange(n)]
    np.testing.assert_allclose(row[around], mask, atol=1e-14)
    assert row[around].sum() == pytest.approx(1, abs=1e-14)
    assert mask[1] > 1.2 * mask[2]
    smooth = np.r_[n * n, np.full(n, 4), np.ones(n)] / (n * (n + 5))
    assert np.abs(mask - smooth).max() > 0.01


def test_dart_among_other_faces_takes_its_limit_one_level_later():
    """A dart between a pentagon and quads: its row is that of the dart in the refined mesh, which has quads only."""
    t = mesh_of("prism darts").topology
    step = CATMULL_CLARK.refine(t)
    later = CATMULL_CLARK.limit_rows(step.child)[[0]] @ step.matrix
    np.testing.assert_allclose(CATMULL_CLARK.limit_rows(t).toarray()[0], later.toarray()[0], atol=1e-15)


# Eigenvalues


def ring_matrix(kind):
    """Subdivision of a corner's sector: the vertex and its ring."""
    ring = 1 + kind.faces + kind.edges
    return QuadPatches(CATMULL_CLARK.refine).step(kind)[0][:ring, :ring]


def pair(angle):
    """Both eigenvalues of frequency `angle`, Ball and Storry 1988: their sum is (5 + cos) / 8, their product 1/16."""
    c = np.cos(angle)
    root = np.sqrt((c + 9) * (c + 1))
    return [(5 + c + root) / 16, (5 + c - root) / 16]


@pytest.mark.parametrize("n", [3, 4, 5, 6, 9, 14])
def test_smooth_spectrum(n):
    """1 and two of frequency zero, then a pair for each frequency; the largest two are the tangents'."""
    values = np.linalg.eigvals(ring_matrix(CornerType(n, 0, closed=True, dart=False, pinned=False)))
    root = np.sqrt(5 * n * n - 30 * n + 49)
    expected = [1, (3 * n - 7 + root) / (8 * n), (3 * n - 7 - root) / (8 * n)]
    for j in range(1, n):
        expected += pair(2 * np.pi * j / n)
    np.testing.assert_allclose(np.sort(values.real), np.sort(expected), atol=1e-7)
    assert np.abs(values.imag).max() < 1e-7
    np.testing.assert_allclose(np.sort(values.real)[-3:], [pair(2 * np.pi / n)[0]] * 2 + [1], atol=1e-12)


@pytest.mark.parametrize("k", range(1, 7))
@pytest.mark.parametrize("pinned", [False, True])
def test_sector_spectrum(k, pinned):
    """The curve has 1, 1/2, 1/4, a corner's edges 1/2 twice; inside the frequencies are multiples of pi / k."""
    values = np.linalg.eigvals(ring_matrix(CornerType(k, 0, closed=False, dart=False, pinned=pinned)))
    expected = [1, 1 / 2, 1 / 2 if pinned else 1 / 4, 1 / 4]
    for j in range(1, k):
        expected += pair(np.pi * j / k)
    np.testing.assert_allclose(np.sort(values.real), np.sort(expected), atol=1e-7)
    assert np.abs(values.imag).max() < 1e-7


@pytest.mark.parametrize("n", [5, 6, 9])
def test_rates_of_derivatives_towards_an_extraordinary_vertex(n):
    """First derivatives scale like (2 lambda)^k, second like (4 lambda)^k."""
    surface = surface_of("catmull-clark", f"rhombic {n}")
    assert surface.domain.vertex[0, 0] == 0
    uv = 2.0 ** -np.array([34, 35])[:, None] * [0.37, 0.31]
    value = surface.evaluate([0, 0], uv, 2)
    first, second = (np.linalg.norm(array, axis=(1, 2)) for array in value[1:])
    eigenvalue = pair(2 * np.pi / n)[0]
    assert first[1] / first[0] == pytest.approx(2 * eigenvalue, rel=1e-4)
    assert second[1] / second[0] == pytest.approx(4 * eigenvalue, rel=1e-4)


# Precision and smoothness


def test_bicubics_are_reproduced_up_to_their_second_derivatives():
    """Control values f give (1 + dxx / 6) (1 + dyy / 6) f for bicubic f, with all derivatives.

    The cubic B-spline's odd moments vanish, its second is 1/3; the fourth is not needed.
    """
    coefficients = np.random.default_rng(4).normal(size=(4, 4))
    smoothed = coefficients + derivative(coefficients, 2, 0) / 6
    smoothed = smoothed + derivative(smoothed, 0, 2) / 6
    points, faces = quad_grid_data(7, 7)
    centre = points[:, :2] - 3.5
    points[:, 2] = np.polynomial.polynomial.polyval2d(*centre.T, coefficients)
    surface = LimitSurface(quads(points, faces), "catmull-clark")
    t = surface.topology
    touched = np.isin(faces, t.edge_vertices[t.boundary_edges]).any(axis=1)
    cells = np.repeat(np.flatnonzero(~touched), 4)
    uv = np.random.default_rng(1).random((len(cells), 2))
    value = surface.evaluate(cells, uv, 2)
    x, y = (points[np.array(faces)[cells, 0], :2] + uv - 3.5).T

    def expected(i, j):
        return np.polynomial.polynomial.polyval2d(x, y, derivative(smoothed, i, j))

    np.testing.assert_allclose(value.position, np.column_stack([x + 3.5, y + 3.5, expected(0, 0)]), atol=1e-12)
    for d, order in enumerate([(1, 0), (0, 1)]):
        np.testing.assert_allclose(value.first[:, d, 2], expected(*order), atol=1e-11)
    for d, order in enumerate([(2, 0), (1, 1), (0, 2)]):
        np.testing.assert_allclose(value.second[:, d, 2], expected(*order), atol=1e-10)


def derivative(coefficients, i, j):
    """Coefficients (4, 4) of a derivative of a bicubic polynomial."""
    out = np.zeros((4, 4))
    taken = np.polynomial.polynomial.polyder(np.polynomial.polynomial.polyder(coefficients, i, axis=0), j, axis=1)
    out[: taken.shape[0], : taken.shape[1]] = taken
    return out


def quads(points, faces, **tags):
    topology = Topology.from_faces(np.arange(0, 4 * len(faces) + 1, 4), np.ravel(faces), len(points), **tags)
    return ControlMesh(topology, points)


@pytest.mark.parametrize("name", ["quad torus 4 6", "quad disc", "extruded", "rhombic 5", "house", "quad semi crease"])
def test_twice_differentiable_across_smooth_sides_in_unfolded_parameters(name):
    """Two cells unfold to a pair of unit squares; in its parameters derivatives to the second order agree."""
    surface = surface_of("catmull-clark", name)
    face, side, beyond, other = sides(surface.domain, False)
    here, there = CORNERS[4][(side[:, None] + np.arange(4)) % 4], CORNERS[4][(other[:, None] + np.arange(4)) % 4]
    # In our parameters the neighbour's sides leave the shared one as ours do, turned round.
    ours = np.stack([here[:, 1] - here[:, 0], here[:, 0] - here[:, 3]], axis=1)
    theirs = np.stack([there[:, 0] - there[:, 1], there[:, 2] - there[:, 1]], axis=1)
    jacobian = np.linalg.solve(ours, theirs)
    for t in (0.11, 0.47, 0.83):
        a = surface.evaluate(face, (1 - t) * here[:, 0] + t * here[:, 1], 2)
        b = surface.evaluate(beyond, (1 - t) * there[:, 1] + t * there[:, 0], 2)
        np.testing.assert_allclose(np.einsum("kpc,kcx->kpx", jacobian, b.first), a.first, atol=1e-12)
        full = b.second[:, [0, 1, 1, 2]].reshape(-1, 2, 2, 3)
        mapped = np.einsum("kpc,kqd,kcdx->kpqx", jacobian, jacobian, full).reshape(-1, 4, 3)[:, [0, 1, 3]]
        np.testing.assert_allclose(mapped, a.second, atol=1e-10)


CURVES = ["quad disc", "single 4", "single 6", "hanging", "prism crease", *(f"half quad fan {k}" for k in range(1, 6))]


@pytest.mark.parametrize("name", CURVES)
def test_closed_boundaries_and_creases_are_cubic_b_splines(name):
    """The curve over the edge from b to c between a and d is the uniform B-spline segment of a, b, c, d."""
    surface = surface_of("catmull-clark", name)
    t, points = surface.topology, surface.control_mesh.points
    on_one_side = (t.twin < 0) if t.boundary_edges.any() else np.diff(t.face_offsets)[t.face] == 5
    half = np.flatnonzero(np.isinf(t.sharpness[t.edge]) & on_one_side)
    ends = {int(t.face_vertices[h]): int(t.face_vertices[t.following[h]]) for h in half}
    starts = {end: start for start, end in ends.items()}
    assert len(half) >= 4
    s = np.linspace(0, 1, 9)
    basis = cubic_b_spline(s)
    for h in half:
        b = int(t.face_vertices[h])
        spline = basis @ points[[starts[b], b, ends[b], ends[ends[b]]]]
        np.testing.assert_allclose(along_half_edge(surface, h, s), spline, atol=1e-13 * size(surface.control_mesh))


def cubic_b_spline(s):
    """Weights of four points for the uniform segment between the middle two, (k, 4)."""
    return np.stack([(1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3], axis=1) / 6


def along_half_edge(surface, h, s):
    """Positions at shares `s` of a half-edge."""
    t = surface.topology
    if surface.domain.face_count == t.face_count:
        face = t.face[h]
        corner = CORNERS[4][(h - t.face_offsets[face] + np.arange(2)) % 4]
        return surface.evaluate(np.full(len(s), face), corner[0] + s[:, None] * (corner[1] - corner[0])).position
    first = s <= 0.5
    cell = np.where(first, h, t.following[h])
    uv = np.where(first[:, None], np.outer(s, [2, 0]), np.outer(1 - s, [0, 2]))
    return surface.evaluate(cell, uv).position


def test_a_crease_between_corners_is_a_clamped_curve():
    """Its ends stay, and next to them it is the B-spline of the points mirrored there."""
    surface = surface_of("catmull-clark", "quad crease across")
    p = surface.control_mesh.points[10:15]
    line = np.vstack([2 * p[0] - p[1], p, 2 * p[-1] - p[-2]])
    s = np.linspace(0, 1, 9)
    basis = cubic_b_spline(s)
    for i in range(4):
        cell = 8 + i
        assert surface.domain.vertex[cell, :2].tolist() == [10 + i, 11 + i]
        found = surface.evaluate(np.full(9, cell), np.column_stack([s, 0 * s])).position
        np.testing.assert_allclose(found, basis @ line[i : i + 4], atol=1e-13)


def test_each_side_of_a_closed_crease_is_a_surface_of_its_own():
    """What is beyond does not matter: moving it moves nothing on this side."""
    surface = surface_of("catmull-clark", "prism crease")
    moved = surface.control_mesh.points.copy()
    moved[:5] += 1.0
    other = surface.with_points(moved)
    top = np.arange(5, 10)
    np.testing.assert_array_equal(np.sort(surface.domain.vertex[top, 0]), np.arange(5, 10))
    uv = np.random.default_rng(2).random((len(top), 2))
    np.testing.assert_array_equal(other.evaluate(top, uv).position, surface.evaluate(top, uv).position)


@pytest.mark.parametrize("name", [name for name in POLYGONS if name != "single 6"])
def test_no_weight_of_refinement_is_negative(name):
    assert CATMULL_CLARK.refine(mesh_of(name).topology).matrix.min() >= 0


def test_inner_vertices_of_two_faces_have_no_tangent_plane_but_a_point():
    """Eigenvalues 1, then 1/4 twice and -1/4: (2 V + 2 sum E + 4 sum C) / 14 as for any valence, and no normal."""
    values = np.linalg.eigvals(ring_matrix(CornerType(2, 0, closed=True, dart=False, pinned=False)))
    np.testing.assert_allclose(np.sort(values.real), [-1 / 4, 1 / 8, 1 / 4, 1 / 4, 1], atol=1e-7)
    surface = surface_of("catmull-clark", "quad fan 2")
    points = surface.control_mesh.points
    limit = (4 * points[0] + 4 * points[[1, 3]].sum(axis=0) + points[[2, 4]].sum(axis=0)) / 14
    value = surface.evaluate([0, 1], [[0, 0], [0, 0]], 1)
    np.testing.assert_allclose(value.position, [limit, limit], atol=1e-14)
    assert not surface.normals([0, 1], [[0, 0], [0, 0]]).any()
