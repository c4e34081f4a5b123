"""The picture of a cloud: dots where points are seen, a panel for each stage."""

import numpy as np
import pytest
from matplotlib.image import imread
from pixels import sphere

import subdfit
from subdfit.draw.cloud_picture import cloud_picture
from subdfit.errors import InputError

POINTS, TRIANGLES = sphere(20)
SIDES = POINTS[TRIANGLES[:, :2]]


def drawn(path, points, **options):
    cloud_picture(path, points=points, mesh=(POINTS, TRIANGLES), **options)
    return imread(path)[:, :, :3]


def dark(picture):
    """Which pixels of the first of two panels are ink."""
    return picture[: int(0.93 * len(picture)), : picture.shape[1] // 2].max(axis=2) < 0.24


def test_each_stage_is_a_panel(tmp_path):
    two = drawn(tmp_path / "two.png", POINTS)
    three = drawn(tmp_path / "three.png", POINTS, surface=(POINTS, TRIANGLES, SIDES, 42))
    assert three.shape[1] == pytest.approx(1.5 * two.shape[1], rel=0.02)


def test_points_on_the_far_side_are_hidden(tmp_path):
    halves = POINTS[POINTS[:, 2] > 0.3], POINTS[POINTS[:, 2] < -0.3]
    seen = [dark(drawn(tmp_path / f"{k}.png", half)).sum() for k, half in enumerate(halves)]
    assert max(seen) > 4 * min(seen)


def test_points_below_the_facets_are_seen(tmp_path):
    front = POINTS[POINTS[:, 2] > 0.3]
    on, below = (dark(drawn(tmp_path / f"{share}.png", share * front)).sum() for share in (1.0, 0.9))
    assert below > 0.9 * on


def test_each_point_is_a_dot_of_some_pixels(tmp_path):
    mixed = np.random.default_rng(0).permutation(POINTS)
    first, second = mixed[:150], mixed[:300]
    few, many = (dark(drawn(tmp_path / f"{len(p)}.png", p)).sum() for p in (first, second))
    assert 1.6 < many / few < 2.4


def test_reconstructions_and_fits_to_clouds_are_drawn(tmp_path):
    points = np.random.default_rng(0).standard_normal((600, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    subdfit.picture(tmp_path / "mesh.png", subdfit.reconstruct(points))
    subdfit.picture(tmp_path / "fit.png", subdfit.fit(points, max_error="1%"))
    assert imread(tmp_path / "fit.png").shape[1] > imread(tmp_path / "mesh.png").shape[1]


def test_interpolations_are_drawn_whole(tmp_path):
    """The surface through a cube's corners bulges far beyond the cube."""
    corner = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    subdfit.picture(tmp_path / "a.png", subdfit.interpolate((corner, quads), creases="none"))
    picture = imread(tmp_path / "a.png")[:, :, :3]
    edge = np.concatenate([picture[0], picture[:, -1], picture[: int(0.9 * len(picture)), picture.shape[1] * 2 // 3]])
    assert edge.min() > 0.9


def test_a_picture_needs_triangles(tmp_path):
    with pytest.raises(InputError):
        cloud_picture(tmp_path / "a.png", points=POINTS, mesh=(POINTS, np.empty((0, 3), np.int64)))
    assert not list(tmp_path.iterdir())
