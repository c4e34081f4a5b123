"""Edges, creases by angle, and the automatic rule: all of a machined part's, none of a scan's."""

import numpy as np
import pytest
import trimesh

from subdfit.target.features import automatic_creases, crease_edges, mesh_edges


def box(levels=3):
    mesh = trimesh.creation.box(extents=(1.0, 2.0, 3.0))
    for _ in range(levels):
        mesh = mesh.subdivide()
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)


def on_box_edges(points, edges):
    """Whether both ends lie on one common edge line of the box."""
    at_side = np.isclose(np.abs(points), [0.5, 1.0, 1.5])
    return np.sum(at_side[edges[:, 0]] & at_side[edges[:, 1]], axis=1) >= 2


def sharp_edges(path):
    """Vertices, faces, and the edges tagged in the `edge` element of a PLY file."""
    head, body = path.read_bytes().split(b"end_header\n", 1)
    counts = [int(line.split()[-1]) for line in head.split(b"\n") if line.startswith(b"element")]
    points = np.frombuffer(body, "<f4", 3 * counts[0]).reshape(-1, 3).astype(float)
    face, edge = np.dtype([("n", "u1"), ("v", "<i4", 3)]), np.dtype([("v", "<i4", 2), ("s", "<f4")])
    faces = np.frombuffer(body, face, counts[1], 12 * counts[0])["v"]
    tagged = np.frombuffer(body, edge, counts[2], 12 * counts[0] + 13 * counts[1])["v"]
    return points, faces.astype(int), {tuple(sorted(pair)) for pair in tagged.tolist()}


def test_edges_of_a_closed_surface_satisfy_euler():
    mesh = trimesh.creation.icosphere(2)
    edges = mesh_edges(mesh.vertices, mesh.faces)
    assert len(mesh.vertices) - len(edges.vertices) + len(mesh.faces) == 2
    assert np.all(edges.valence == 2)
    ends = np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 3, 2), axis=2)
    np.testing.assert_array_equal(edges.vertices[edges.of_face], ends)
    for side in range(2):
        assert np.all(np.any(edges.of_face[edges.faces[:, side]] == np.arange(len(edges.faces))[:, None], axis=1))


def test_angles_agree_with_another_library():
    mesh = trimesh.creation.annulus(0.5, 1.0, 0.7)
    edges = mesh_edges(mesh.vertices, mesh.faces)
    known = dict(zip(map(tuple, mesh.face_adjacency_edges.tolist()), mesh.face_adjacency_angles, strict=True))
    expected = [known[tuple(pair)] for pair in edges.vertices.tolist()]
    np.testing.assert_allclose(edges.angle, np.degrees(expected), atol=1e-5)


def test_boundary_and_nonmanifold_edges_have_no_angle():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0]], float)
    edges = mesh_edges(points, np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]]))
    assert edges.valence[edges.vertices.tolist().index([0, 1])] == 3
    assert np.all(edges.angle == 0.0)
    assert np.all(edges.faces[edges.valence == 1, 1] == -1)


def test_creases_by_angle_are_the_edges_of_a_box():
    points, faces = box()
    found = crease_edges(points, faces, 89.0)
    assert len(found) == 12 * 8
    assert np.all(on_box_edges(points, found))
    assert len(crease_edges(points, faces, 91.0)) == 0


@pytest.mark.parametrize("levels", [0, 1, 3])
def test_automatic_creases_of_a_box(levels):
    points, faces = box(levels)
    found = automatic_creases(points, faces)
    assert len(found) == 12 * 2**levels
    assert np.all(on_box_edges(points, found))


def test_automatic_creases_follow_scale_and_rotation():
    mesh = trimesh.creation.cylinder(1.0, 3.0, sections=40)
    rims = automatic_creases(mesh.vertices, mesh.faces)
    assert len(rims) == 80
    rotation = np.array([[2.0, -2.0, 1.0], [1.0, 2.0, 2.0], [-2.0, -1.0, 2.0]]) / 3.0
    turned = 1e-6 * np.asarray(mesh.vertices) @ rotation
    np.testing.assert_array_equal(automatic_creases(turned, mesh.faces), rims)


def test_length_counts_in_automatic_creases_and_not_how_many_edges():
    x = np.concatenate([[0.0], 20.0 + np.arange(25), [64.0]])
    slope = np.clip(0.14 * np.abs(x - 32.0) - 0.68, 0.3, 1.0)
    ridge = np.stack([np.repeat(x, 3), np.tile([-0.5, 0.0, 0.5], len(x)), np.zeros(3 * len(x))], axis=1)
    ridge[:, 2] = -np.repeat(slope, 3) * np.abs(ridge[:, 1])
    corner = 3 * np.arange(len(x) - 1)[:, None] + np.arange(2)
    quads = np.stack([corner, corner + 3, corner + 4, corner + 1], axis=-1).reshape(-1, 4)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    angles = mesh_edges(ridge, faces).angle
    assert np.median(angles[angles > 25]) < 40
    found = automatic_creases(ridge, faces)
    assert set(map(tuple, found.tolist())) >= {(3 * k + 1, 3 * k + 4) for k in range(len(x) - 1)}


@pytest.mark.parametrize("noise", [0.0, 0.1, 0.3, 0.6])
def test_smooth_and_noisy_surfaces_have_no_automatic_creases(noise):
    mesh = trimesh.creation.icosphere(4)
    length = mesh.edges_unique_length.mean()
    points = mesh.vertices + np.random.default_rng(0).normal(size=mesh.vertices.shape) * noise * length
    assert len(automatic_creases(points, mesh.faces)) == 0
    assert noise < 0.3 or len(crease_edges(points, mesh.faces, 40.0)) > 100


@pytest.mark.parametrize("name", ["bunny", "armadillo_50k", "rangemap_lato000", "rocker-arm", "igea"])
def test_scans_have_no_automatic_creases(meshes, name):
    mesh = trimesh.load(meshes / f"{name}.ply", process=False)
    assert len(automatic_creases(mesh.vertices, mesh.faces)) == 0


@pytest.mark.parametrize("name", ["fandisk", "block", "casting"])
def test_machined_parts_keep_their_sharp_edges(meshes, name):
    mesh = trimesh.load(meshes / f"{name}.ply", process=False)
    found = set(map(tuple, automatic_creases(mesh.vertices, mesh.faces).tolist()))
    strong = set(map(tuple, crease_edges(mesh.vertices, mesh.faces, 60.0).tolist()))
    assert len(found & strong) >= 0.95 * len(strong)
    assert found <= set(map(tuple, crease_edges(mesh.vertices, mesh.faces, 25.0 - 1e-9).tolist()))


@pytest.mark.parametrize(("name", "recall"), [("mechpart", 0.98), ("club", 0.8)])
def test_automatic_creases_against_tags_made_by_others(meshes, name, recall):
    points, faces, tagged = sharp_edges(meshes / f"{name}.ply")
    found = set(map(tuple, automatic_creases(points, faces).tolist()))
    assert len(found - tagged) <= 0.01 * len(found)
    assert len(found & tagged) >= recall * len(tagged)
