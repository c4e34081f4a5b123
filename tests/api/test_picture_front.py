"""`subdfit.picture`: its colours and numbers are those of the certificate."""

import numpy as np
import pytest
from tests.shapes.parts import can, shaft

import subdfit
from subdfit.draw import fit_picture


def drawn(result, path, monkeypatch):
    """What is given to be drawn."""
    given = {}
    monkeypatch.setattr(fit_picture, "fit_picture", lambda path, **options: given.update(options))
    subdfit.picture(path, result)
    return given


@pytest.mark.parametrize(("shape", "scheme"), [(can, "loop"), (shaft, "catmull-clark")])
def test_the_largest_distance_is_coloured_where_no_drawn_point_lies(shape, scheme, tmp_path, monkeypatch):
    result = subdfit.fit(shape(), max_error="0.3%", creases=30.0, scheme=scheme, max_control_vertices=60)
    given, m = drawn(result, tmp_path / "fit.png", monkeypatch), result.measurement
    assert given["largest"] == (m.max, m.reverse_max)
    assert given["surface_error"].max() == pytest.approx(max(m.max, m.reverse_max), rel=1e-9)


def test_data_that_the_surface_misses_colour_it(sphere, tmp_path, monkeypatch):
    points, triangles = sphere
    points = points.copy()
    points[100] *= 1.1
    result = subdfit.fit((points, triangles), max_error="0.3%", max_control_vertices=20)
    given, m = drawn(result, tmp_path / "fit.png", monkeypatch), result.measurement
    assert m.max > 1.2 * m.reverse_max
    assert given["surface_error"].max() == pytest.approx(m.max, rel=1e-9)
    corners, faces = given["surface"]
    reddest = corners[faces[given["surface_error"] == given["surface_error"].max()]].reshape(-1, 3)
    assert np.linalg.norm(reddest - points[100], axis=1).max() < 0.3
