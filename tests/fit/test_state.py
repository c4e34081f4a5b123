"""Footpoints of a state: what is told to be far off is."""

import numpy as np

import subdfit
from subdfit.fit.data import FitData
from subdfit.fit.state import FitState
from subdfit.limit.surface import LimitSurface
from subdfit.target.frame import Frame


def test_far_footpoints_are_assured_and_no_others(meshes) -> None:
    """From one face all points walk to where descent ends; beyond a threshold the nearest places are found."""
    fit = subdfit.fit(meshes / "holes.ply", max_error="1%")
    frame = Frame.of(fit.target.points[fit.target.used])
    data = FitData.of(fit.target.normalised(frame), spacing=1.0)
    surface = LimitSurface(fit.control_mesh.with_points(frame.inside(fit.control_mesh.points)))
    count, threshold = len(data.points), 0.01
    astray = FitState.follow(data, surface, np.zeros(count, np.int32), np.full((count, 2), 0.3))
    far = astray.distance > threshold
    assert far.sum() > 100
    found = astray.assured(threshold)
    np.testing.assert_allclose(found.distance[far], astray.verified().distance[far], atol=1e-6)
    np.testing.assert_array_equal(found.distance[~far], astray.distance[~far])
    assert found.distance.max() < 0.02
    assert found.assured(0.02) is found
