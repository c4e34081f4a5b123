"""What must not matter: numbering, orientation, the other side of a crease, order of evaluation, threads."""

import numpy as np
import pytest

from shapes.parameters import anywhere, inside, size, surface_of
from shapes.zoo import ZOO
from subdfit import parallel
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology


def renumbered(mesh, vertex, face, turn, reverse=False):
    """The same mesh with vertex `vertex[i]` in row i, face `face[j]` in row j, starting `turn[j]` corners later."""
    t = mesh.topology
    row = np.empty(t.vertex_count, int)
    row[vertex] = np.arange(t.vertex_count)
    triangles = row[t.triangles[face]]
    triangles = np.take_along_axis(triangles, (np.arange(3) + turn[:, None]) % 3, axis=1)
    tags = {
        "crease_edges": row[t.edge_vertices[t.crease_edges]],
        "corner_vertices": row[np.flatnonzero(t.corner_sharpness > 0)],
    }
    return ControlMesh.from_triangles(mesh.points[vertex], triangles[:, ::-1] if reverse else triangles, **tags)


def weights_of(uv):
    return np.column_stack([1 - uv.sum(axis=1), uv])


def test_numbering_does_not_matter(surface):
    mesh, random = surface.control_mesh, np.random.default_rng(5)
    t = mesh.topology
    order, turn = random.permutation(t.face_count), random.integers(0, 3, t.face_count)
    other = LimitSurface(renumbered(mesh, random.permutation(t.vertex_count), order, turn), surface.scheme)
    face, uv = anywhere(other.domain, nearest=6.0)
    turned = weights_of(uv)[np.arange(len(uv))[:, None], (np.arange(3) - turn[face][:, None]) % 3]
    expected = surface.evaluate(order[face], turned[:, 1:]).position
    assert np.abs(other.evaluate(face, uv).position - expected).max() < 1e-13 * 10 * size(mesh)


def test_orientation_does_not_matter(surface):
    mesh, t = surface.control_mesh, surface.topology
    plain = np.arange(t.vertex_count), np.arange(t.face_count), np.zeros(t.face_count, int)
    other = LimitSurface(renumbered(mesh, *plain, reverse=True), surface.scheme)
    face, uv = anywhere(surface.domain, nearest=6.0)
    there = other.evaluate(face, weights_of(uv)[:, ::-1][:, 1:]).position
    assert np.abs(there - surface.evaluate(face, uv).position).max() < 1e-13 * 10 * size(mesh)


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
