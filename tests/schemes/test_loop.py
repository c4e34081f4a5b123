"""Loop's own truths: masks, eigenvalues, precision, and what other programs make of the same meshes."""

import meshio
import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from shapes.parameters import CORNERS, anywhere, inside, sides, size, surface_of
from shapes.zoo import ZOO, grid_data, mesh_of
from subdfit.errors import InputError
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.schemes import SCHEMES, scheme_named
from subdfit.schemes._loop_types import CornerType, limit_mask, subdivide

LOOP = SCHEMES["loop"]


def eigenvalue(valence):
    """Subdominant eigenvalue of an inner vertex."""
    return 3 / 8 + np.cos(2 * np.pi / valence) / 4


def ring_matrix(kind):
    """Subdivision of a corner's sector: the vertex and its ring."""
    return subdivide(kind)[0][: kind.edges + 1, : kind.edges + 1]


def open_corner(faces, pinned=False):
    return CornerType(faces, 0, closed=False, dart=False, pinned=pinned)


def smooth_corner(faces):
    return CornerType(faces, 0, closed=True, dart=False, pinned=False)


# Masks


@pytest.mark.parametrize("n", [*range(4, 13), 25])
def test_smooth_vertex_and_its_limit(n):
    alpha = (3 / 8 + np.cos(2 * np.pi / n) / 4) ** 2 + 3 / 8
    beta = 3 / (11 - 8 * alpha)
    topology = mesh_of(f"pyramid {n}").topology
    for own, matrix in [(alpha, LOOP.refine(topology).matrix), (beta, LOOP.limit_rows(topology))]:
        row = matrix.toarray()[0]
        assert row[0] == pytest.approx(own, abs=1e-15)
        assert row[1:] == pytest.approx((1 - own) / n, abs=1e-15)


def test_regular_limit_is_a_half_and_twelfths():
    row = LOOP.limit_rows(mesh_of("torus 4 7").topology).toarray()[0]
    assert sorted(row[row > 0]) == pytest.approx([1 / 12] * 6 + [1 / 2])


def test_edge_boundary_crease_and_corner_rules():
    mesh = mesh_of("two triangles")
    rows = LOOP.refine(mesh.topology).matrix.toarray()
    np.testing.assert_allclose(rows[:4] * 8, [[6, 1, 0, 1], [1, 6, 1, 0], [0, 1, 6, 1], [1, 0, 1, 6]])
    ends = mesh.topology.edge_vertices
    for edge, row in zip(ends, rows[4:], strict=True):
        inner = set(edge.tolist()) == {0, 2}
        expected = np.full(4, 1 / 8 if inner else 0.0)
        expected[edge] = 3 / 8 if inner else 1 / 2
        np.testing.assert_allclose(row, expected)
    limits = LOOP.limit_rows(mesh.topology).toarray() * 6
    np.testing.assert_allclose(limits, [[4, 1, 0, 1], [1, 4, 1, 0], [0, 1, 4, 1], [1, 0, 1, 4]])
    star = mesh_of("star 5").topology
    for matrix in (LOOP.refine(star).matrix, LOOP.limit_rows(star)):
        np.testing.assert_array_equal(matrix.toarray()[0], np.eye(6)[0])
    parted = LOOP.limit_rows(mesh_of("parted 9 4").topology).toarray()[0]
    np.testing.assert_allclose(parted[[0, 1, 5]] * 6, [4, 1, 1])
    assert np.count_nonzero(parted) == 3


def test_dart_of_six_has_a_limit_mask_of_its_own():
    mask = LOOP.limit_rows(mesh_of("boundary dart 6").topology).toarray()[0]
    # The crease runs to vertex 2; the ring goes on 3, 4, 5, 6, 1.
    expected = [0.51643, 0.09859, 0.06808, 0.08216, 0.08451, 0.08216, 0.06808]
    np.testing.assert_allclose(mask[[0, 2, 3, 4, 5, 6, 1]], expected, atol=5e-6)


def test_dart_keeps_the_smooth_vertex_rule_and_its_edge_the_midpoint():
    topology = mesh_of("dart 7").topology
    plain = mesh_of("pyramid 7").topology
    rows = LOOP.refine(topology).matrix.toarray()
    np.testing.assert_array_equal(rows[0], LOOP.refine(plain).matrix.toarray()[0])
    np.testing.assert_allclose(rows[8 + topology.crease_edges[0]], [0.5, 0, 0, 0.5, 0, 0, 0, 0])


@pytest.mark.parametrize("name", ZOO)
def test_no_weight_of_a_position_is_negative(name):
    surface = surface_of("loop", name)
    face, uv = anywhere(surface.domain)
    assert surface.weights(face, uv).min() > -1e-15
    assert LOOP.refine(surface.topology).matrix.min() >= 0


# Eigenvalues


@pytest.mark.parametrize("n", [*range(3, 13), 25])
def test_smooth_spectrum(n):
    """Loop 1987: 1, then 3/8 + cos(2 pi j/N)/4 in pairs, and alpha - 3/8."""
    values = np.linalg.eigvals(ring_matrix(smooth_corner(n)))
    expected = [1, eigenvalue(n) ** 2, *(3 / 8 + np.cos(2 * np.pi * j / n) / 4 for j in range(1, n))]
    np.testing.assert_allclose(np.sort(values.real), np.sort(expected), atol=1e-12)
    assert np.abs(values.imag).max() < 1e-7


@pytest.mark.parametrize("k", range(1, 9))
@pytest.mark.parametrize("pinned", [False, True])
def test_sector_spectrum(k, pinned):
    """1/2 along the curve and 3/8 + cos(pi j/k)/4 across; a crease has 1/4 beside, a corner 1/2 twice."""
    values = np.sort(np.linalg.eigvals(ring_matrix(open_corner(k, pinned))).real)
    across = [3 / 8 + np.cos(np.pi * j / k) / 4 for j in range(1, k)]
    np.testing.assert_allclose(values, np.sort([1, 1 / 2, 1 / 2 if pinned else 1 / 4, *across]), atol=2e-8)


@pytest.mark.parametrize("n", [3, 4, 5, 7])
def test_jordan_block_at_valence_three_only(n):
    """At N = 3 the eigenvalue 1/16 of the patch's matrix has fewer eigenvectors than its multiplicity."""
    matrix = subdivide(smooth_corner(n))[0]
    multiplicity = int((np.abs(np.linalg.eigvals(matrix) - 1 / 16) < 1e-4).sum())
    vectors = len(matrix) - np.linalg.matrix_rank(matrix - np.eye(len(matrix)) / 16, tol=1e-9)
    assert multiplicity >= 1
    assert (vectors < multiplicity) == (n == 3)


@pytest.mark.parametrize(
    "kind", [smooth_corner(5), open_corner(4), open_corner(2, True), CornerType(7, 3, True, True, False)]
)
def test_limit_mask_is_the_left_eigenvector_of_one(kind):
    mask = limit_mask(kind)
    np.testing.assert_allclose(mask @ ring_matrix(kind), mask, atol=1e-15)
    assert mask.sum() == pytest.approx(1, abs=1e-15)


@pytest.mark.parametrize("n", [3, 4, 5, 7, 8, 9])
def test_rates_of_derivatives_towards_an_extraordinary_vertex(n):
    """First derivatives scale like (2 lambda)^k, second like (4 lambda)^k (at N = 3 they stay bounded)."""
    surface = surface_of("loop", f"fan {n}")
    uv = 2.0 ** -np.array([34, 35])[:, None] * [0.37, 0.31]
    value = surface.evaluate([0, 0], uv, 2)
    first, second = (np.linalg.norm(array, axis=(1, 2)) for array in value[1:])
    assert first[1] / first[0] == pytest.approx(2 * eigenvalue(n), rel=1e-4)
    assert second[1] / second[0] == pytest.approx(4 * eigenvalue(n), rel=1e-4)


# Precision and smoothness


def grid_surface(function, cells=7):
    points, faces = grid_data(cells, cells)
    points[:, 2] = function(points[:, 0], points[:, 1])
    return LimitSurface(ControlMesh.from_triangles(points, faces), "loop")


def clear_of(surface, vertices, rings):
    """Faces that do not touch `vertices`, nor (rings = 2) a face that does."""
    triangles = surface.topology.triangles
    for _ in range(rings):
        touched = np.isin(triangles, vertices).any(axis=1)
        vertices = np.unique(triangles[touched])
    return np.flatnonzero(~touched)


def test_quadratics_are_reproduced_up_to_a_constant():
    """A quadratic q gives q + c, c = (1/12) sum of its quadratic part over the six lattice directions.

    At a lattice point this is the limit mask 1/2, 1/12 applied to q; elsewhere the box spline's moments do not
    depend on where one stands.
    """
    surface = grid_surface(lambda x, y: 0.3 * x * x - 0.7 * x * y + 0.2 * y * y + 2 * x - y)
    t = surface.topology
    faces = clear_of(surface, np.flatnonzero(t.boundary_vertices), 1)
    uv = np.random.default_rng(1).dirichlet([1, 1, 1], len(faces))[:, 1:]
    x, y, z = surface.evaluate(faces, uv).position.T
    ring = np.array([(1, 0), (0, 1), (1, 1)])
    constant = 2 * sum(0.3 * a * a - 0.7 * a * b + 0.2 * b * b for a, b in ring) / 12
    corner = surface.control_mesh.points[t.triangles[faces]]
    weights = np.column_stack([1 - uv.sum(axis=1), uv])
    np.testing.assert_allclose(np.stack([x, y]), np.einsum("kc,kcx->xk", weights, corner)[:2], atol=1e-14)
    np.testing.assert_allclose(z, 0.3 * x * x - 0.7 * x * y + 0.2 * y * y + 2 * x - y + constant, atol=1e-13)


def test_linear_functions_are_reproduced_along_straight_boundaries():
    """Up to the boundary a regular grid gives back its own lattice: all but where the square's corners reach."""
    surface = grid_surface(lambda x, y: 2 * x - 3 * y)
    faces = clear_of(surface, [0, 7, 56, 63], 2)
    assert (surface.domain.neighbour[faces, :3] < 0).any()
    for uv in ([0.2, 0.3], [0.5, 0.0], [0.0, 0.5], [0.0, 0.0], [1e-12, 0.0]):
        value = surface.evaluate(faces, np.tile(uv, (len(faces), 1)), 1)
        corner = surface.control_mesh.points[surface.topology.triangles[faces]]
        weights = np.array([1 - sum(uv), *uv])
        np.testing.assert_allclose(value.position, np.einsum("c,kcx->kx", weights, corner), atol=1e-14)
        np.testing.assert_allclose(value.first, corner[:, 1:] - corner[:, :1], atol=1e-13)


@pytest.mark.parametrize("name", ["torus 3 3", "disc", "icosahedron", "crowded", "dart 7", "tagged sphere 1"])
def test_twice_differentiable_across_smooth_edges_in_unfolded_parameters(name):
    """Two cells unfold to a parallelogram; in its parameters derivatives to the second order agree."""
    surface = surface_of("loop", name)
    face, side, beyond, other = sides(surface.domain, False)
    here, there = CORNERS[3][(side[:, None] + np.arange(3)) % 3], CORNERS[3][(other[:, None] + [1, 0, 2]) % 3]
    # Corners of the neighbour in our parameters: the shared two, and the fourth of the parallelogram.
    ours = np.stack([here[:, 0], here[:, 1], here[:, 0] + here[:, 1] - here[:, 2]], axis=1)
    jacobian = np.linalg.solve(ours[:, 1:] - ours[:, :1], there[:, 1:] - there[:, :1])
    for t in (0.11, 0.47, 0.83):
        a = surface.evaluate(face, (1 - t) * here[:, 0] + t * here[:, 1], 2)
        b = surface.evaluate(beyond, (1 - t) * there[:, 0] + t * there[:, 1], 2)
        np.testing.assert_allclose(np.einsum("kpc,kcx->kpx", jacobian, b.first), a.first, atol=1e-12)
        full = b.second[:, [0, 1, 1, 2]].reshape(-1, 2, 2, 3)
        mapped = np.einsum("kpc,kqd,kcdx->kpqx", jacobian, jacobian, full).reshape(-1, 4, 3)[:, [0, 1, 3]]
        np.testing.assert_allclose(mapped, a.second, atol=1e-10)


@pytest.mark.parametrize("faces", [1, 2])
def test_corners_are_spanned_by_their_sharp_edges(faces):
    """A tagged boundary vertex: the tangents in its cells lie in the plane of its two boundary edges."""
    mesh = ZOO[f"half fan {faces}"]()
    mesh = ControlMesh.from_triangles(mesh.points, mesh.topology.triangles, corner_vertices=[0])
    surface, p = LimitSurface(mesh), mesh.points
    normal = np.cross(p[1] - p[0], p[faces + 1] - p[0])
    normal /= np.linalg.norm(normal)
    cells = np.arange(faces)
    found = surface.normals(cells, np.zeros((faces, 2)))
    assert np.abs(np.einsum("kx,x->k", found, normal)) == pytest.approx(1)
    along = surface.evaluate([0], [[0, 0]], 1).first[0, 0]
    assert np.linalg.norm(np.cross(along, p[1] - p[0])) < 1e-12 * size(mesh)


# Other programs


def read_triangles(path):
    mesh = meshio.read(path)
    triangles = mesh.cells_dict["triangle"]
    used, rows = np.unique(triangles, return_inverse=True)
    return mesh.points[used].astype(float), rows.reshape(-1, 3)


@pytest.mark.parametrize(
    ("name", "wrong"), [("igea", 0), ("bunny_closed", 0), ("holes", 0), ("blade", 0), ("bunny", 4), ("cylinder", 4)]
)
def test_refinement_equals_trimesh(meshes, name, wrong):
    """Trimesh errs at boundary vertices that an inner edge joins to another boundary vertex, and only there."""
    points, faces = read_triangles(meshes / f"{name}.ply")
    theirs, _ = trimesh.remesh.subdivide_loop(points, faces, iterations=1)
    t = Topology.from_triangles(faces, len(points))
    ours = LOOP.refine(t).matrix @ points
    tolerance = 1e-12 * np.linalg.norm(np.ptp(points, axis=0))
    inner = t.edge_vertices[~t.boundary_edges]
    joined = np.unique(inner[t.boundary_vertices[inner].all(axis=1)])
    differ = np.flatnonzero(np.linalg.norm(ours - theirs, axis=1)[: len(points)] > tolerance)
    np.testing.assert_array_equal(differ, joined)
    assert len(joined) == wrong
    assert cKDTree(theirs[len(points) :]).query(ours[len(points) :])[0].max() < tolerance


def nothing(points, topology, step):
    return np.zeros(len(points), bool)


def one_faced(points, topology, step):
    return topology.valence == 1


def half_of_the_patches(points, topology, step):
    """Two triangles have no corners; of the others' six, two are sharp for ever, then one, and two expire half-way."""
    top, upper = np.abs(points[:, 0] - 0.75) < 0.1, points[:, 2] > 0
    return (topology.valence == 1) & (points[:, 0] > 0) & np.where(upper, ~top, top | (step == 0))


@pytest.mark.parametrize(
    ("name", "levels", "pinned"),
    [
        ("cube", 3, nothing),
        ("icosahedron", 3, nothing),
        ("saddle_edgecorner", 2, one_faced),
        ("triangle_edgeonly", 2, half_of_the_patches),
    ],
)
def test_refinement_equals_opensubdiv(meshes, name, levels, pinned):
    points, faces = read_triangles(meshes / "quad" / f"osd_loop_{name}_level0.ply")
    theirs, their_faces = read_triangles(meshes / "quad" / f"osd_loop_{name}_level{levels}.ply")
    for step in range(levels):
        plain = Topology.from_triangles(faces, len(points))
        corners = np.flatnonzero(pinned(points, plain, step))
        refinement = LOOP.refine(Topology.from_triangles(faces, len(points), corner_vertices=corners))
        faces, points = refinement.child.triangles, refinement.matrix @ points
    distance, row = cKDTree(theirs).query(points)
    assert distance.max() < 2e-7 * np.linalg.norm(np.ptp(theirs, axis=0))
    assert len(np.unique(row)) == len(theirs)

    def canonical(triangles):
        return {tuple(np.roll(face, -int(np.argmin(face)))) for face in triangles}

    assert canonical(row[faces]) == canonical(their_faces)


# What Loop refuses


def test_refuses_what_it_cannot_take():
    quad = Topology.from_faces([0, 4], [0, 1, 2, 3], 4)
    with pytest.raises(InputError, match="triangles only"):
        LOOP.validate(quad)
    pillow = Topology.from_triangles([[0, 1, 2], [0, 2, 1]], 3)
    with pytest.raises(InputError, match="vertex 0 has valence 2"):
        LOOP.validate(pillow)


def test_schemes_go_by_name():
    assert scheme_named("loop") is LOOP
    assert scheme_named(LOOP) is LOOP
    with pytest.raises(InputError, match="unknown scheme 'lop'"):
        scheme_named("lop")


@pytest.mark.parametrize("name", ["pyramid 5", "crease ring", "pinned boundary"])
def test_the_surface_stays_within_the_control_points(name):
    """Weights are convex: no point of the surface leaves the control points' bounding box."""
    surface = surface_of("loop", name)
    face, uv = inside(surface.domain, per_cell=10)
    position, control = surface.evaluate(face, uv).position, surface.control_mesh.points
    assert (position >= control.min(axis=0) - 1e-14).all()
    assert (position <= control.max(axis=0) + 1e-14).all()
