"""What must not matter: numbering, orientation, the other side of a crease, order of evaluation, threads."""

import numpy as np
import pytest

from shapes.parameters import DUAL, anywhere, face_corners, inside, size, surface_of
from shapes.zoo import ZOO
from subdfit import parallel
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.schemes._doo_sabin_thin import without_thin_vertices
from subdfit.schemes.domain import CORNERS as DOMAIN_CORNERS
from subdfit.schemes.domain import TRIANGLE


def renumbered(mesh, vertex, face, turn, reverse=False):
    """The same mesh with vertex `vertex[i]` in row i, face `face[j]` in row j, starting `turn[j]` corners later."""
    t = mesh.topology
    row = np.empty(t.vertex_count, int)
    row[vertex] = np.arange(t.vertex_count)
    corners = [row[t.face_vertices[t.face_offsets[f] : t.face_offsets[f + 1]]] for f in face]
    corners = [np.roll(c, -k)[:: -1 if reverse else 1] for c, k in zip(corners, turn, strict=True)]
    pinned = np.flatnonzero(t.corner_sharpness > 0)
    topology = Topology.from_faces(
        np.cumsum([0, *(len(c) for c in corners)]),
        np.concatenate(corners),
        t.vertex_count,
        crease_edges=row[t.edge_vertices[t.crease_edges]],
        crease_sharpness=t.sharpness[t.crease_edges],
        corner_vertices=row[pinned],
        corner_sharpness=t.corner_sharpness[pinned],
    )
    return ControlMesh(topology, mesh.points[vertex])


def seen_from(corners, uv, shape):
    """Parameters in a cell in which the corners of ours lie at `corners` (k, 4, 2)."""
    last = np.where((shape == TRIANGLE)[:, None], corners[:, 2], corners[:, 3])
    u, v = uv.T[:, :, None]
    return corners[:, 0] + u * (corners[:, 1] - corners[:, 0]) + v * (last - corners[:, 0])


def named_cells(t, vertex, reverse=False):
    """Cells of a dual scheme by the vertices at, after and before their face corners; centroids by their faces'.

    Vertex i goes by the name `vertex[i]`, after and before are exchanged where faces are reversed.
    """
    whole, matrix = without_thin_vertices(t)
    rows = [[v] for v in range(t.vertex_count)] if matrix is None else np.split(matrix.indices, matrix.indptr[1:-1])
    names = [frozenset(vertex[row].tolist()) for row in rows]
    around = np.empty((len(whole.twin), 3), int)
    around[:, 0] = whole.face_vertices
    around[:, 1] = whole.face_vertices[whole.following]
    around[whole.following, 2] = whole.face_vertices
    chosen = around[face_corners(whole)][:, [0, 2, 1] if reverse else [0, 1, 2]]
    return [tuple(names[v] for v in corner) for corner in chosen]


def dual_before(surface, other, vertex, reverse, cell):
    """The same as `before` for dual schemes."""
    old = {name: k for k, name in enumerate(named_cells(surface.topology, np.arange(surface.topology.vertex_count)))}
    names = named_cells(other, vertex, reverse)
    assert len(old) == surface.domain.face_count == len(names)
    turned = [0, 3, 2, 1] if reverse else [0, 1, 2, 3]
    return np.array([old[names[k]] for k in cell]), DOMAIN_CORNERS[4, np.tile(turned, (len(cell), 1))]


def before(surface, order, turn, reverse, cell):
    """Where cells of a `renumbered` mesh lay before: (cell, corners (k, 4, 2) there of the cells')."""
    t, domain = surface.topology, surface.domain
    size = np.diff(t.face_offsets)
    if domain.face_count == t.face_count:
        old, n = order[cell], size[order[cell]][:, None]
        corner = ((n - 1 - np.arange(4) if reverse else np.arange(4)) + turn[cell][:, None]) % n
        return old, DOMAIN_CORNERS[n, corner]
    # One cell a face corner, which it keeps, and one in the middle of a face that stays a triangle.
    cells = np.where((size == 3) & (surface.scheme.faces == "mixed"), 4, size)
    begin, begin_before = np.cumsum([0, *cells[order]]), np.cumsum([0, *cells])
    face = np.searchsorted(begin, cell, side="right") - 1
    old, place = order[face], cell - begin[face]
    n = size[old]

    def corner_of(k):
        return ((n - 1 - k if reverse else k) + turn[face]) % n

    child = begin_before[old] + np.where(place < n, corner_of(place), place)
    turned = [0, 3, 2, 1] if reverse else [0, 1, 2, 3]
    triangle = (domain.shape[child] == TRIANGLE)[:, None]
    corner = np.where(triangle, np.stack([corner_of(k) for k in range(4)], axis=1), turned)
    return child, DOMAIN_CORNERS[domain.shape[child].astype(int)[:, None], corner]


def check_renumbered(surface, vertex, order, turn, reverse):
    other = LimitSurface(renumbered(surface.control_mesh, vertex, order, turn, reverse), surface.scheme)
    cell, uv = anywhere(other.domain, nearest=6.0)
    if surface.scheme.name in DUAL:
        old, corners = dual_before(surface, other.topology, vertex, reverse, cell)
    else:
        old, corners = before(surface, order, turn, reverse, cell)
    there = np.clip(seen_from(corners, uv, other.domain.shape[cell]), 0, 1)
    gap = other.evaluate(cell, uv).position - surface.evaluate(old, there).position
    assert np.abs(gap).max() < 1e-13 * 10 * size(surface.control_mesh)


def test_numbering_does_not_matter(surface):
    t, random = surface.topology, np.random.default_rng(5)
    order, turn = random.permutation(t.face_count), random.integers(0, 3, t.face_count)
    check_renumbered(surface, random.permutation(t.vertex_count), order, turn, reverse=False)


def test_orientation_does_not_matter(surface):
    t = surface.topology
    plain = np.arange(t.vertex_count), np.arange(t.face_count), np.zeros(t.face_count, int)
    check_renumbered(surface, *plain, reverse=True)


def cut_out(mesh, faces, corners):
    t = mesh.topology
    kept, triangles = np.unique(t.triangles[faces], return_inverse=True)
    topology = Topology.from_triangles(
        triangles.reshape(-1, 3), len(kept), corner_vertices=np.flatnonzero(np.isin(kept, corners))
    )
    return ControlMesh(topology, mesh.points[kept])


@pytest.mark.parametrize("name", ["crease ring", "crease across"])
def test_each_side_of_a_crease_is_a_surface_of_its_own(name):
    """A closed crease, or one between corners, parts the surface: what is beyond does not matter."""
    surface = surface_of("loop", name)
    t, domain = surface.topology, surface.domain
    sharp_ends = np.bincount(t.edge_vertices[t.sharpness > 0].ravel(), minlength=t.vertex_count)
    side, frontier = np.full(t.face_count, -1), [0]
    side[0] = 0
    while frontier:
        f = frontier.pop()
        for beyond in domain.neighbour[f][(domain.neighbour[f] >= 0) & ~domain.sharp[f]]:
            if side[beyond] < 0:
                side[beyond] = 0
                frontier.append(beyond)
    assert 0 < (side == 0).sum() < t.face_count
    for faces in (np.flatnonzero(side == 0), np.flatnonzero(side < 0)):
        alone = LimitSurface(cut_out(surface.control_mesh, faces, np.flatnonzero(sharp_ends >= 3)))
        face, uv = anywhere(alone.domain, nearest=6.0)
        expected = surface.evaluate(faces[face], uv).position
        assert np.abs(alone.evaluate(face, uv).position - expected).max() < 1e-13


def test_components_do_not_know_of_each_other():
    both = surface_of("loop", "two components")
    face, uv = inside(both.domain)
    rows = both.weights(face, uv).toarray()
    assert not rows[face < 6][:, 5:].any()
    assert not rows[face >= 6][:, :5].any()


def test_order_and_threads_do_not_change_a_bit(surface):
    face, uv = anywhere(surface.domain, per_cell=3)
    order = np.random.default_rng(11).permutation(len(face))
    straight, mixed = surface.evaluate(face, uv, 2), surface.evaluate(face[order], uv[order], 2)
    for a, b in zip(straight, mixed, strict=True):
        np.testing.assert_array_equal(a[order], b)


def test_many_threads_give_the_bytes_of_one():
    surface = surface_of("loop", "crowded")
    random = np.random.default_rng(0)
    face = random.integers(0, surface.domain.face_count, 40_000)
    uv = random.dirichlet([1, 1, 1], len(face))[:, 1:]
    results, before = [], parallel.threads()
    for count in (1, 4):
        parallel.set_threads(count)
        results.append((surface.evaluate(face, uv, 2), surface.weights(face, uv, 1)))
    parallel.set_threads(before)
    for a, b in zip(*(result[0] for result in results), strict=True):
        np.testing.assert_array_equal(a, b)
    np.testing.assert_array_equal(results[0][1].data, results[1][1].data)


def test_the_zoo_is_the_same_on_every_visit():
    for name, make in ZOO.items():
        once, again = make(), make()
        np.testing.assert_array_equal(once.points, again.points, err_msg=name)
