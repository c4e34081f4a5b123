"""The weights W with S(face, uv) = W P: what makes a subdivision surface affine."""

import numpy as np
import pytest

from shapes.parameters import anywhere, size
from shapes.zoo import scattered


def test_weights_sum_to_one_and_their_derivatives_to_zero(surface):
    face, uv = anywhere(surface.domain)
    assert np.abs(surface.weights(face, uv).sum(axis=1) - 1).max() < 1e-13
    for derivative in (1, 2):
        rows = surface.weights(face, uv, derivative)
        scale = np.maximum(np.abs(rows).sum(axis=1), 1)
        assert (np.abs(rows.sum(axis=1)) / scale).max() < 1e-13


def test_weights_depend_on_control_points_of_the_face_and_its_neighbours_only(surface):
    face, uv = anywhere(surface.domain, per_cell=2)
    rows = surface.weights(face, uv).tocoo()
    touching = np.zeros((surface.topology.face_count, surface.topology.vertex_count), bool)
    t = surface.topology
    member = np.zeros_like(touching)
    member[t.face, t.face_vertices] = True
    near = (member.astype(int) @ member.T.astype(int)) > 0
    touching = (near.astype(int) @ member.astype(int)) > 0
    vertices = surface.domain.vertex[face]
    for row, column in zip(rows.row, rows.col, strict=True):
        own = vertices[row][vertices[row] >= 0]
        assert touching[member[:, own].all(axis=1)][:, column].any()


@pytest.mark.parametrize("strewn", [False, True])
def test_evaluation_equals_weights_times_points(surface, strewn):
    if strewn:
        surface = surface.with_points(scattered(surface.control_mesh).points)
    face, uv = anywhere(surface.domain)
    points, value = surface.control_mesh.points, surface.evaluate(face, uv, 2)
    length = size(surface.control_mesh)
    assert np.abs(surface.weights(face, uv) @ points - value.position).max() < 1e-13 * length
    for d in (0, 1):
        rows = surface.weights(face, uv, d + 1)
        scale = np.maximum(np.abs(rows).sum(axis=1), 1)[:, None] * length
        assert (np.abs(rows @ points - value.first[:, d]) / scale).max() < 1e-13


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
