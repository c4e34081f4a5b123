"""The weights W with S(face, uv) = W P: what makes a subdivision surface affine."""

import numpy as np
import pytest

from shapes.parameters import anywhere, inside, size
from shapes.zoo import scattered


def derivative_rows(surface, face, uv):
    """Rows of both first derivatives, and by how much the larger of the two multiplies the control points."""
    rows = [surface.weights(face, uv, derivative) for derivative in (1, 2)]
    return rows, np.maximum.reduce([np.abs(row).sum(axis=1) for row in rows]).clip(1)


def test_weights_sum_to_one_and_their_derivatives_to_zero(surface):
    face, uv = anywhere(surface.domain)
    assert np.abs(surface.weights(face, uv).sum(axis=1) - 1).max() < 1e-13
    rows, scale = derivative_rows(surface, face, uv)
    for row in rows:
        assert (np.abs(row.sum(axis=1)) / scale).max() < 1e-13


def test_weights_depend_on_the_faces_that_touch_their_own_only(surface):
    t = surface.topology
    corner_of = np.zeros((t.face_count, t.vertex_count), int)
    corner_of[t.face, t.face_vertices] = 1
    near = (corner_of @ corner_of.T @ corner_of) > 0
    face, uv = anywhere(surface.domain, per_cell=2)
    corners = surface.domain.vertex[face]
    own = np.array([(corner_of[:, row[row >= 0]] > 0).all(axis=1) for row in corners])
    rows = surface.weights(face, uv).toarray() != 0
    assert not (rows & ~((own.astype(int) @ near) > 0)).any()


@pytest.mark.parametrize("strewn", [False, True])
def test_evaluation_equals_weights_times_points(surface, strewn):
    if strewn:
        surface = surface.with_points(scattered(surface.control_mesh).points)
    face, uv = anywhere(surface.domain)
    points, value = surface.control_mesh.points, surface.evaluate(face, uv, 2)
    length = size(surface.control_mesh)
    assert np.abs(surface.weights(face, uv) @ points - value.position).max() < 1e-13 * length
    rows, scale = derivative_rows(surface, face, uv)
    for d in (0, 1):
        assert (np.abs(rows[d] @ points - value.first[:, d]) / scale[:, None]).max() < 1e-13 * length


def test_second_derivatives_equal_their_weights_times_points(surface):
    """Inside faces: at irregular corners the surface has none."""
    surface = surface.with_points(scattered(surface.control_mesh).points)
    face, uv = inside(surface.domain)
    second = surface.evaluate(face, uv, 2).second
    for column, derivative in enumerate((3, 4, 5)):
        rows = surface.weights(face, uv, derivative)
        scale = np.abs(rows).sum(axis=1).clip(1)[:, None]
        assert (np.abs(rows @ surface.control_mesh.points - second[:, column]) / scale).max() < 1e-13 * 20
        assert (np.abs(rows.sum(axis=1)) / scale[:, 0]).max() < 1e-13


def test_fewer_derivatives_do_not_change_the_rest(surface):
    face, uv = anywhere(surface.domain, per_cell=2)
    most = surface.evaluate(face, uv, 2)
    for derivatives in (0, 1):
        less = surface.evaluate(face, uv, derivatives)
        np.testing.assert_array_equal(less.position, most.position)
        assert less.second is None
        assert (less.first is None) == (derivatives == 0)
        if derivatives:
            np.testing.assert_array_equal(less.first, most.first)


def test_affine_maps_commute_with_evaluation(surface):
    face, uv = anywhere(surface.domain)
    random = np.random.default_rng(7)
    linear, shift = random.normal(size=(3, 3)), random.normal(size=3)
    mapped = surface.with_points(surface.control_mesh.points @ linear + shift).evaluate(face, uv, 1)
    value = surface.evaluate(face, uv, 1)
    np.testing.assert_allclose(mapped.position, value.position @ linear + shift, rtol=0, atol=1e-13 * 20)
    scale = np.maximum(np.abs(value.first).max(axis=(1, 2)), 1)[:, None, None]
    assert (np.abs(mapped.first - value.first @ linear) / scale).max() < 1e-12
