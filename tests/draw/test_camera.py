"""The camera: what it frames, and that its picture plane is a true one."""

import numpy as np
import pytest

from subdfit.draw.camera import camera_for
from subdfit.errors import InputError

BOX = np.array([[x, y, z] for x in (-3.0, 3.0) for y in (-2.0, 2.0) for z in (-1.0, 1.0)])
FACES = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]])
FACES = np.vstack([FACES, [[2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]])


@pytest.mark.parametrize("up", ["y", "z"])
@pytest.mark.parametrize("angles", [(None, None), (0.0, 0.0), (130.0, -35.0), (None, 60.0)])
def test_the_axes_are_orthonormal_and_right_handed(angles, up):
    rotation = camera_for(BOX, FACES, azimuth=angles[0], elevation=angles[1], up=up).rotation
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1.0)


def test_the_front_view_keeps_right_and_up():
    seen = camera_for(BOX, FACES, azimuth=0.0, elevation=0.0).project(np.eye(3))
    np.testing.assert_allclose(seen[0], [1, 0, 0], atol=1e-6)
    np.testing.assert_allclose(seen[1], [0, 1, 0], atol=1e-6)
    assert seen[2, 2] == pytest.approx(1.0)


def test_a_model_that_stands_along_z_looks_like_the_same_model_along_y():
    standing = BOX[:, [0, 2, 1]] * [1, -1, 1]
    along_y = camera_for(BOX, FACES).project(BOX)
    along_z = camera_for(standing, FACES, up="z").project(standing)
    np.testing.assert_allclose(along_y, along_z, atol=1e-5)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_the_window_is_tight_and_does_not_depend_on_the_unit(scale):
    camera = camera_for(BOX * scale + 7.0 * scale, FACES, margin=0.05)
    seen = camera.project(BOX * scale + 7.0 * scale)
    left, right, bottom, top = camera.window
    border = np.array(
        [seen[:, 0].min() - left, right - seen[:, 0].max(), seen[:, 1].min() - bottom, top - seen[:, 1].max()]
    )
    side = max(np.ptp(seen[:, 0]), np.ptp(seen[:, 1]))
    np.testing.assert_allclose(border / side, 0.05, atol=1e-5)
    assert camera.aspect == pytest.approx((right - left) / (top - bottom))


def test_what_is_nearer_is_larger():
    camera = camera_for(BOX, FACES, azimuth=0.0, elevation=0.0)
    near, far = camera.project(np.array([[1.0, 0.0, 1.0], [1.0, 0.0, -1.0]]))
    assert near[0] > 1.0 > far[0] > 0.0


def test_vertices_without_a_face_do_not_count():
    astray = np.vstack([BOX, [[500.0, -80.0, 1e4]]])
    alone, framed = camera_for(BOX, FACES), camera_for(astray, FACES)
    assert alone.window == framed.window
    assert np.all(np.isfinite(framed.project(astray)))


@pytest.mark.parametrize("normal", [0, 1, 2])
def test_a_flat_sheet_is_never_seen_edge_on(normal):
    sheet = np.insert(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), normal, 0.0, axis=1)
    rotation = camera_for(sheet, [[0, 1, 2], [0, 2, 3]]).rotation
    assert abs(rotation[2, normal]) > 0.5


def test_what_cannot_be_framed_is_refused():
    with pytest.raises(InputError, match="without triangles"):
        camera_for(BOX, np.empty((0, 3), int))
    with pytest.raises(InputError, match="'x' is not known"):
        camera_for(BOX, FACES, up="x")


def test_nearness_is_linear_on_the_picture_of_a_line():
    camera = camera_for(BOX, FACES)
    seen = camera.project(np.linspace(BOX[0], BOX[-1], 9)).astype(np.float64)
    near = camera.nearness(seen[:, 2])
    share = (seen[:, 0] - seen[0, 0]) / (seen[-1, 0] - seen[0, 0])
    np.testing.assert_allclose(near, near[0] + share * (near[-1] - near[0]), rtol=1e-6)
    np.testing.assert_allclose(camera.height(near), seen[:, 2], atol=1e-6)
