"""Normals of points alone, against those of the surfaces that the points are from."""

import clouds
import numpy as np
import pytest

from subdfit.initial.normals import estimated_normals


def test_normals_are_the_torus_own_all_on_one_side():
    """With sixteen times the points neighbours are a quarter as far, and so is the angle over which normals turn."""
    errors = []
    for count in (1500, 24000):
        points = clouds.torus(count)
        ring = points * [1, 1, 0]
        exact = (points - 2 * ring / np.linalg.norm(ring, axis=1, keepdims=True)) / 0.7
        across = np.einsum("nk,nk->n", estimated_normals(points), exact)
        assert abs(np.sign(across).sum()) == count
        errors.append(np.sqrt(np.mean(1 - np.minimum(np.abs(across), 1))))
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.1)


def test_every_piece_looks_up_at_its_top():
    balls, sheet = [clouds.sphere(800), clouds.sphere(500, seed=1)], clouds.square(400)
    found = estimated_normals(np.concatenate([balls[0], np.add(balls[1], [5, 0, 0]), np.add(sheet, [0, 5, 0])]))
    out = np.concatenate([*balls, np.tile([0.0, 0.0, 1.0], (400, 1))])
    assert (np.einsum("nk,nk->n", found, out) > 0.9).all()
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1)


def test_repeated_points_do_no_harm():
    points = np.tile(clouds.sphere(300), (3, 1))
    assert (np.einsum("nk,nk->n", estimated_normals(points), points) > 0.6).all()
