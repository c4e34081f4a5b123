"""`subdfit.LimitSurface` and `subdfit.subdivide`: the surface is the same however one asks."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

import subdfit
from subdfit.api import memory
from subdfit.errors import InputError

POINTS = np.vstack([np.eye(3), -np.eye(3)]) * [3.0, 2.0, 1.0]
FACES = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])


@pytest.fixture(scope="module")
def cage():
    return subdfit.ControlMesh.from_triangles(POINTS, FACES, crease_edges=[[0, 1], [1, 3]], corner_vertices=[4])


@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_closest_points_of_points_off_the_surface(cage, offset):
    surface = subdfit.LimitSurface(cage.with_points(cage.points + offset))
    drawn = surface.tessellate(3)
    found = surface.closest(drawn.points + 1e-3 * drawn.normals)
    assert found.distance.max() <= 1e-3 * (1 + 1e-4)
    again = surface.closest(surface.evaluate(found.face, found.uv).position)
    assert again.distance.max() < 1e-7


def test_closest_refuses_what_are_no_points(cage):
    surface = subdfit.LimitSurface(cage)
    for bad in ([1.0, 2.0, 3.0], [[np.nan, 0, 0]]):
        with pytest.raises(InputError, match="finite points"):
            surface.closest(bad)


@pytest.mark.parametrize("level", [0, 1, 3])
def test_tessellation_lies_on_the_surface(cage, level):
    drawn = subdfit.LimitSurface(cage).tessellate(level)
    assert len(drawn.triangles) == 8 * 4**level
    assert len(drawn.points) == 2 + 4 * 4**level
    np.testing.assert_allclose(np.linalg.norm(drawn.normals, axis=1), 1.0)
    outward = np.einsum("ij,ij->i", drawn.normals, drawn.points)
    assert (outward > 0).all()


def sharp_cube():
    """A cube whose edges are all creases, one of them only as far as a dart."""
    corners = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    edges = np.unique([sorted((f[i], f[i - 1])) for f in faces for i in range(4)], axis=0)
    data = subdfit.api.mesh_data((corners, faces))
    return replace(data, crease_edges=edges, crease_sharpness=np.full(12, np.inf), scheme="catmull-clark")


def facet_normals(drawn):
    """Unit normals of the triangles."""
    a, b, c = drawn.points[drawn.triangles].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


@pytest.mark.parametrize("level", [0, 1, 3])
def test_apart_each_side_of_a_crease_has_its_normals(level):
    surface = subdfit.LimitSurface(sharp_cube())
    joined, apart = surface.tessellate(level), surface.tessellate(level, apart=True)
    np.testing.assert_array_equal(joined.points[joined.triangles], apart.points[apart.triangles])
    own = np.einsum("tcx,tx->tc", apart.normals[apart.triangles], facet_normals(apart))
    np.testing.assert_allclose(own, 1.0)
    side = 2**level + 1
    assert len(apart.points) == 6 * side**2
    assert len(joined.points) == 6 * side**2 - 12 * side + 8


def test_what_is_smooth_stays_joined_apart(cage):
    """Three sharp edges in sequence: their inner vertices come twice, the ends once, as all others do."""
    surface = subdfit.LimitSurface(
        subdfit.ControlMesh.from_triangles(POINTS, FACES, crease_edges=[[0, 1], [1, 3], [3, 4]])
    )
    joined, apart = surface.tessellate(2), surface.tessellate(2, apart=True)
    assert len(apart.points) == len(joined.points) + 3 * 4 - 1
    smooth = subdfit.LimitSurface(subdfit.ControlMesh.from_triangles(POINTS, FACES))
    assert len(smooth.tessellate(2, apart=True).points) == len(smooth.tessellate(2).points)


@pytest.mark.parametrize("extension", [".glb", ".stl"])
def test_polygons_are_cut_for_formats_of_triangles(tmp_path, extension):
    path = tmp_path / f"cube{extension}"
    subdfit.write(path, subdfit.subdivide(sharp_cube(), 1))
    assert len(trimesh.load_mesh(path).faces) == 2 * 24


BAD_PLACES = [
    ([0.9], [[0.2, 0.2]], "whole numbers"),
    ([2**32], [[0.2, 0.2]], "face 4294967296"),
    ([-1], [[0.2, 0.2]], "face -1"),
    ([[0, 0]], [[0.2, 0.2]], "give \\(k,\\)"),
    ([0, 1], [[0.2, 0.2]], "one pair a face"),
    ([0], [[0.2, 0.2, 0.2]], "give \\(k, 2\\)"),
    ([0], "here", "no numbers"),
    ([0], [[0.2, np.nan]], "not on the surface"),
]


@pytest.mark.parametrize(("face", "uv", "match"), BAD_PLACES)
def test_places_that_are_not_on_the_surface(cage, face, uv, match):
    surface = subdfit.LimitSurface(cage)
    for ask in (surface.evaluate, surface.weights, surface.curvatures, surface.normals):
        with pytest.raises(InputError, match=match):
            ask(face, uv)


@pytest.mark.parametrize("order", [-1, 6, 100, 1.0, "1", True, None])
def test_derivatives_that_there_are_none_of(cage, order):
    surface = subdfit.LimitSurface(cage)
    for ask in (surface.evaluate, surface.weights):
        with pytest.raises(InputError, match="give a whole number from 0 to"):
            ask([0], [[0.2, 0.2]], order)


@pytest.mark.parametrize("scheme", [3, "lop", ["loop"]])
def test_what_is_no_scheme(cage, scheme):
    with pytest.raises(InputError, match="choose one of loop"):
        subdfit.LimitSurface(cage, scheme)
    with pytest.raises(InputError, match="choose one of loop"):
        subdfit.fit(cage, scheme=scheme)


@pytest.mark.parametrize("level", [-1, 9, 1.5])
def test_levels_that_cannot_be(cage, level):
    with pytest.raises(InputError, match="level"):
        subdfit.LimitSurface(cage).tessellate(level)


def test_a_surface_of_anything_that_holds_a_cage(cage, tmp_path):
    path = tmp_path / "cage.obj"
    subdfit.write(path, cage)
    kinds = (path, subdfit.read(path), cage)
    first, *others = (subdfit.LimitSurface(kind).tessellate(2).points for kind in kinds)
    for other in others:
        np.testing.assert_array_equal(other, first)


def test_subdividing_leaves_the_limit_surface(cage):
    fine = subdfit.subdivide(cage, 2)
    assert fine.topology.face_count == 8 * 16
    assert len(fine.topology.crease_edges) == 2 * 4
    assert fine.scheme == "loop"
    found = subdfit.LimitSurface(cage).closest(subdfit.LimitSurface(fine).tessellate(1).points)
    assert found.distance.max() < 1e-7


def test_subdividing_at_limit_positions(cage):
    fine = subdfit.subdivide(cage, 2, limit=True)
    expected = subdfit.LimitSurface(subdfit.subdivide(cage, 2)).vertex_limits()
    np.testing.assert_allclose(fine.points, expected)
    assert fine.scheme is None
    assert subdfit.LimitSurface(cage).closest(fine.points).distance.max() < 1e-7
    np.testing.assert_array_equal(subdfit.subdivide(cage, 0).points, cage.points)


@pytest.mark.parametrize("levels", [-1, 1.5, 40, 7])
def test_levels_of_subdivision_that_cannot_be(cage, levels, monkeypatch):
    """The last would need more memory than the machine has."""
    monkeypatch.setattr(memory, "machine_memory", lambda: 256 * 2**20)
    with pytest.raises(InputError, match="levels"):
        subdfit.subdivide(cage, levels)


def test_writing_refuses_what_is_no_mesh(tmp_path):
    with pytest.raises(InputError, match="cannot write a str"):
        subdfit.write(tmp_path / "x.obj", "mesh")
