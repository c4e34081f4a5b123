"""The limit surface as users call it: shapes, sharing, refusals."""

import numpy as np
import pytest

from shapes.parameters import inside, surface_of
from shapes.zoo import mesh_of
from subdfit.errors import InputError
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh


def test_shapes_of_what_comes_back():
    surface = surface_of("loop", "crowded")
    face, uv = inside(surface.domain)
    value = surface.evaluate(face, uv, 2)
    assert value.position.shape == (len(face), 3)
    assert value.first.shape == (len(face), 2, 3)
    assert value.second.shape == (len(face), 3, 3)
    assert surface.weights(face, uv).shape == (len(face), surface.topology.vertex_count)
    assert surface.evaluate(face, uv).first is None


def test_no_points_give_no_rows():
    surface = surface_of("loop", "octahedron")
    value = surface.evaluate([], np.empty((0, 2)), 2)
    assert [array.shape for array in value] == [(0, 3), (0, 2, 3), (0, 3, 3)]
    assert surface.weights([], np.empty((0, 2))).shape == (0, 6)


def test_one_face_one_pair_of_parameters():
    surface = surface_of("loop", "octahedron")
    np.testing.assert_array_equal(
        surface.evaluate(3, [0.2, 0.3]).position, surface.evaluate([3], [[0.2, 0.3]]).position
    )


@pytest.mark.parametrize(
    ("face", "uv", "text"),
    [
        ([8], [[0.1, 0.1]], "row 0: face 8"),
        ([0, -1], [[0.1, 0.1], [0.1, 0.1]], "row 1: face -1"),
        ([0], [[0.6, 0.5]], "row 0"),
        ([0], [[-0.1, 0.5]], "not on the surface"),
        ([0], [[np.nan, 0.5]], "not on the surface"),
        ([0, 1], [[0.1, 0.1]], "2 faces but 1 parameter pairs"),
    ],
)
def test_refuses_what_is_not_on_the_surface(face, uv, text):
    surface = surface_of("loop", "octahedron")
    for call in (surface.evaluate, surface.weights):
        with pytest.raises(InputError, match=text):
            call(face, uv)


def test_parameters_off_by_rounding_are_on_the_surface():
    surface = surface_of("loop", "octahedron")
    outside = surface.evaluate([0, 0, 0], [[1 + 1e-12, -1e-12], [0.5, 0.5 + 1e-12], [-1e-12, 0.3]], 1)
    within = surface.evaluate([0, 0, 0], [[1, 0], [0.5, 0.5], [0, 0.3]], 1)
    np.testing.assert_allclose(outside.position, within.position, atol=1e-11)
    np.testing.assert_allclose(outside.first[1:], within.first[1:], atol=1e-10)


def test_other_points_share_the_compiled_topology():
    surface = surface_of("loop", "crease ring")
    moved = surface.with_points(2 * surface.control_mesh.points)
    assert moved.compiled is surface.compiled
    face, uv = inside(surface.domain)
    np.testing.assert_array_equal(moved.evaluate(face, uv).position, 2 * surface.evaluate(face, uv).position)
    fresh = LimitSurface(moved.control_mesh)
    np.testing.assert_array_equal(moved.evaluate(face, uv).position, fresh.evaluate(face, uv).position)
    with pytest.raises(InputError, match="positions for 18 vertices"):
        surface.with_points(np.zeros((17, 3)))


def test_the_mesh_states_its_scheme():
    mesh = mesh_of("octahedron")
    assert LimitSurface(ControlMesh(mesh.topology, mesh.points, "loop")).scheme.name == "loop"
    with pytest.raises(InputError, match="unknown scheme 'quadric'"):
        LimitSurface(ControlMesh(mesh.topology, mesh.points, "quadric"))


def test_normals_are_unit_outward_and_zero_where_there_is_no_plane():
    surface = surface_of("loop", "icosahedron")
    face, uv = inside(surface.domain)
    normal, position = surface.normals(face, uv), surface.evaluate(face, uv).position
    assert np.linalg.norm(normal, axis=1) == pytest.approx(1)
    assert (np.einsum("kx,kx->k", normal, position) > 0).all()
    flat = surface.with_points(np.zeros((12, 3)))
    np.testing.assert_array_equal(flat.normals(face, uv), 0)
