"""Quadrics of noisy points of a cylinder, whose distance, normals and curvature are known."""

import numpy as np

from subdfit.target.curvature import curvature_field, curvature_in_noise
from subdfit.target.local_quadrics import NEAREST, local_quadrics

RADIUS, NOISE = 2.0, 0.001


def cylinder(count: int = 4000):
    """Points of a cylinder, and their normals."""
    rng = np.random.default_rng(0)
    angle, height = rng.uniform(0, 2 * np.pi, count), rng.uniform(-1, 1, count)
    normals = np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=1)
    return RADIUS * normals + height[:, None] * [0, 0, 1], normals


def found_in_noise(lift: float):
    points, normals = cylinder()
    noisy = points + NOISE * np.random.default_rng(1).normal(size=points.shape)
    found = local_quadrics(noisy, points + lift * normals, NOISE)
    return found, np.sign(np.sum(found.normals * normals, axis=1)), normals


def test_distances_are_true_to_a_part_of_the_noise():
    found, side, _ = found_in_noise(0.02)
    assert np.std(side * found.distance - 0.02) < 0.6 * NOISE


def test_curvature_is_that_of_the_cylinder():
    found, side, normals = found_in_noise(0.0)
    assert np.quantile(np.abs(np.sum(found.normals * normals, axis=1)), 0.05) > 0.999
    bent = np.linalg.eigvalsh(side[:, None, None] * found.tensors)
    np.testing.assert_allclose(np.median(bent, axis=0), [0, 0, 1 / RADIUS], atol=0.02)


def test_the_curvature_of_a_plane_is_none():
    rng = np.random.default_rng(2)
    points = np.concatenate([rng.uniform(-1, 1, (4000, 2)), NOISE * rng.normal(size=(4000, 1))], axis=1)
    found = local_quadrics(points, points, NOISE)
    assert np.mean(np.any(found.tensors, axis=(1, 2))) < 0.05


def test_points_of_another_surface_count_little():
    points, normals = cylinder()
    noisy = points + NOISE * np.random.default_rng(1).normal(size=points.shape)
    noisy[::8] += 0.1 * normals[::8]
    found = local_quadrics(noisy, points, NOISE)
    assert np.quantile(np.abs(found.distance), 0.95) < 2 * NOISE


def tube(around: int, along: int):
    """An open cylinder of radius `RADIUS` as a mesh, its normals outward."""
    k, j = np.meshgrid(np.arange(around), np.arange(along))
    angle = 2 * np.pi * (k.ravel() + j.ravel() / 2) / around
    points = np.stack([RADIUS * np.cos(angle), RADIUS * np.sin(angle), 0.1 * j.ravel()], axis=1)
    a, b = (j * around + k)[:-1].ravel(), (j * around + (k + 1) % around)[:-1].ravel()
    return points, np.concatenate([np.stack([a, b, b + around], 1), np.stack([a, b + around, a + around], 1)])


def test_curvature_in_noise_has_the_side_of_the_triangles_and_the_lines_of_the_cylinder():
    points, triangles = tube(64, 12)
    noisy = points + 5 * NOISE * np.random.default_rng(0).normal(size=points.shape)
    for faces, sign in ((triangles, 1), (triangles[:, ::-1], -1)):
        found = curvature_in_noise(noisy, faces, 5 * NOISE).at_vertices()
        strongest = np.where(sign > 0, found.maximum, found.minimum)
        assert abs(np.median(strongest) - sign / RADIUS) < 0.05


def test_a_piece_of_few_vertices_has_the_curvature_of_its_triangles():
    points, triangles = tube(12, 3)
    assert len(points) < NEAREST
    found = curvature_in_noise(points, triangles, NOISE)
    np.testing.assert_array_equal(found.tensors, curvature_field(points, triangles).tensors)
