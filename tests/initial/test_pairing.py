"""Pairing triangles to quads: the surface stays, creases are not crossed, few triangles are left."""

import numpy as np
import pytest

from initial.initial_laws import annulus, read, sphere, square, torus
from shapes.zoo import euler
from subdfit.initial.decimate import decimate
from subdfit.initial.pairing import pair_quality, pair_triangles
from subdfit.mesh.control_mesh import ControlMesh


def sizes(mesh: ControlMesh) -> np.ndarray:
    return np.diff(mesh.topology.face_offsets)


def directed_edges(mesh: ControlMesh) -> set[tuple[int, int]]:
    t = mesh.topology
    return set(zip(t.face_vertices.tolist(), t.face_vertices[t.following].tolist(), strict=True))


@pytest.mark.parametrize("shape", [torus(12, 8), square(7), annulus(5, 12)])
def test_the_grid_is_found_again(shape) -> None:  # type: ignore[no-untyped-def]
    mesh = ControlMesh.from_triangles(*shape)
    quads = pair_triangles(mesh)
    assert set(sizes(quads)) == {4}
    assert quads.topology.face_count == mesh.topology.face_count // 2
    assert directed_edges(quads) < directed_edges(mesh)
    inner = ~mesh.topology.boundary_vertices
    assert set(quads.topology.valence[inner]) <= {4}


def test_a_quad_of_right_angles_is_best() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    mesh = ControlMesh.from_triangles(points, [[0, 1, 2], [0, 2, 3]])
    quality = pair_quality(mesh.points, mesh.topology)
    assert sorted(quality)[-2:] == pytest.approx([1, 1])
    assert np.count_nonzero(quality) == 2
    folded = mesh.with_points(points + np.array([[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 1.0]]))
    assert pair_quality(folded.points, mesh.topology).max() < 0.7


def test_few_triangles_are_left_and_none_overlap(meshes) -> None:  # type: ignore[no-untyped-def]
    for name, count in (("rocker-arm", 500), ("bunny", 900)):
        found = decimate(*read(meshes, name), count)
        mesh = ControlMesh.from_triangles(found.points, found.triangles)
        t = mesh.topology
        paired = pair_triangles(mesh)
        p = paired.topology
        assert p.vertex_count == t.vertex_count
        assert euler(p) == euler(t)
        assert np.count_nonzero(p.boundary_edges) == np.count_nonzero(t.boundary_edges)
        assert 2 * np.sum(sizes(paired) == 4) + np.sum(sizes(paired) == 3) == t.face_count
        assert np.mean(sizes(paired) == 4) > 0.9
        assert p.valence[~p.boundary_vertices].min() >= 3


def test_creases_and_corners_stay(meshes) -> None:  # type: ignore[no-untyped-def]
    points, triangles = sphere(2)
    mesh = ControlMesh.from_triangles(points, triangles)
    t = mesh.topology
    equator = np.flatnonzero(np.all(np.abs(points[t.edge_vertices][:, :, 2]) < 1e-9, axis=1))
    tagged = ControlMesh.from_triangles(
        points, triangles, crease_edges=t.edge_vertices[equator], corner_vertices=[0], corner_sharpness=[2.0]
    )
    paired = pair_triangles(tagged).topology
    kept = {tuple(sorted(e)) for e in paired.edge_vertices[paired.crease_edges].tolist()}
    assert kept == {tuple(sorted(e)) for e in t.edge_vertices[equator].tolist()}
    assert paired.corner_sharpness[0] == 2.0


def test_poor_pairs_stay_triangles() -> None:
    strip = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0.9, 0.1, 0]])
    mesh = ControlMesh.from_triangles(strip[[0, 1, 3, 2]], [[0, 1, 2], [1, 3, 2]])
    assert set(sizes(pair_triangles(mesh))) == {3}, "the quad would not be convex"
