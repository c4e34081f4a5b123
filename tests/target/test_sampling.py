"""Samples inside large faces."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from subdfit.errors import InputError
from subdfit.target.sampling import face_samples


def random_faces(seed):
    """Triangles of all shapes: equilateral to sliver, small to large."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(60, 3)) * rng.uniform(0.02, 3.0, (60, 1))
    points[3:6] = [[0, 0, 0], [10, 0, 0], [10, 0.01, 0]]
    return points, np.arange(60).reshape(-1, 3)


def weights(uv):
    return np.concatenate([1.0 - uv.sum(axis=1, keepdims=True), uv], axis=1)


@pytest.mark.parametrize("spacing", [0.3, 1.0, 2.5])
def test_no_point_of_a_face_is_farther_than_the_spacing_from_a_sample_or_vertex(spacing):
    points, faces = random_faces(0)
    row, uv = face_samples(points, faces, spacing)
    assert weights(uv).min() > 0.0
    dense = np.random.default_rng(1).dirichlet(np.ones(3), 400)
    for f, face in enumerate(faces):
        known = np.concatenate([points[face], weights(uv[row == f]) @ points[face]])
        assert cKDTree(known).query(dense @ points[face])[0].max() <= spacing


def test_small_faces_have_none_and_slivers_one_row():
    points, faces = random_faces(1)
    row, _ = face_samples(points, faces, 0.5)
    longest = np.linalg.norm(points[faces] - points[np.roll(faces, 1, axis=1)], axis=2).max(axis=1)
    np.testing.assert_array_equal(np.unique(row), np.flatnonzero(longest > 0.5))
    assert np.sum(row == 1) == 21
    assert np.all(np.diff(row) >= 0)


def test_samples_do_not_depend_on_where_a_face_begins():
    points, faces = random_faces(2)
    row, uv = face_samples(points, faces, 0.4)
    turned, turned_uv = face_samples(points, np.roll(faces, 1, axis=1), 0.4)
    np.testing.assert_array_equal(turned, row)
    np.testing.assert_allclose(np.roll(weights(turned_uv), -1, axis=1), weights(uv), atol=1e-15)


@pytest.mark.parametrize("spacing", [0.0, -1.0, np.nan])
def test_bad_spacing_is_named(spacing):
    points, faces = random_faces(3)
    with pytest.raises(InputError, match="positive length"):
        face_samples(points, faces, spacing)
