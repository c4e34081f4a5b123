"""`subdfit.interpolate`: what callers give and get."""

import numpy as np
import pytest

import subdfit
from shapes.zoo import mesh_of, octahedron_data
from subdfit.interpolate import METHODS


def relative_errors(result, points):
    return np.linalg.norm(result.surface.vertex_limits() - points, axis=1) / result.diagonal


@pytest.mark.parametrize("method", METHODS)
def test_arrays_in_surface_through_them_out(method):
    points, faces = octahedron_data()
    result = subdfit.interpolate((points, faces), method=method, unit="mm")
    assert result.status == "within_tolerance"
    assert relative_errors(result, points).max() <= 1e-12
    np.testing.assert_array_equal(result.control_mesh.topology.triangles, faces)
    document = result.to_dict()
    assert document["residuals"][-1] <= 1e-12 < document["residuals"][0]
    assert document["iterations"] == len(document["residuals"]) - 1
    assert document["errors"]["max"] == pytest.approx(relative_errors(result, points).max(), abs=1e-15)
    assert document["errors"]["boundary"] is None
    assert document["errors"]["crease"] is None
    assert (document["scheme"], document["method"], document["unit"]) == ("loop", method, "mm")


def test_size_and_place_do_not_matter():
    """Beyond the digits that coordinates a million sizes away from the origin have lost."""
    mesh = mesh_of("tagged sphere 1")
    near = subdfit.interpolate(mesh).control_mesh.points
    far = subdfit.interpolate(mesh.with_points(1e-3 * mesh.points + 1e3)).control_mesh.points
    np.testing.assert_allclose((far - 1e3) * 1e3, near, atol=1e-8)


def test_tagged_creases_and_corners_are_interpolated_by_their_curves():
    """The curve of a crease depends on its own vertices, so that both sides meet there in the data."""
    mesh = mesh_of("crease across")
    result = subdfit.interpolate(mesh)
    assert result.to_dict()["errors"]["crease"]["max"] <= 1e-12
    assert result.to_dict()["errors"]["boundary"]["max"] <= 1e-12
    np.testing.assert_array_equal(result.control_mesh.topology.sharpness, mesh.topology.sharpness)
    line = [10, 11, 12, 13, 14]
    rows = np.zeros((5, 5))
    rows[[0, 4], [0, 4]] = 1.0
    for k in (1, 2, 3):
        rows[k, k - 1 : k + 2] = [1 / 6, 4 / 6, 1 / 6]
    np.testing.assert_allclose(result.control_mesh.points[line], np.linalg.solve(rows, mesh.points[line]), atol=1e-11)


def test_creases_by_angle_and_none():
    corner = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = [t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])]
    sharp = subdfit.interpolate((corner, triangles), creases=30)
    assert len(sharp.control_mesh.topology.crease_edges) == 12
    np.testing.assert_allclose(sharp.control_mesh.points, corner, atol=1e-14)  # all corners: they stay
    smooth = subdfit.interpolate(sharp.control_mesh, creases="none")
    assert len(smooth.control_mesh.topology.crease_edges) == 0
    assert relative_errors(smooth, corner).max() <= 1e-12
    assert np.abs(smooth.control_mesh.points - corner).max() > 0.1


def test_the_same_bytes_on_one_thread_and_many(meshes):
    found = [subdfit.interpolate(meshes / "rocker-arm.ply", threads=n).control_mesh.points for n in (1, 2)]
    assert found[0].tobytes() == found[1].tobytes()


def test_points_that_coincide_or_lie_in_a_plane():
    points, faces = octahedron_data()
    for flat in (points * 0.0 + 7.0, points * [1, 1, 0]):
        result = subdfit.interpolate((flat, faces), creases="none")
        assert result.status == "within_tolerance"
        np.testing.assert_allclose(result.surface.vertex_limits(), flat, atol=1e-11)


def test_fair_keeps_the_vertices_first():
    mesh = mesh_of("crease across")
    result = subdfit.interpolate(mesh, fair=True)
    n = mesh.topology.vertex_count
    assert result.control_mesh.topology.vertex_count > 3 * n
    assert np.linalg.norm(result.surface.vertex_limits()[:n] - mesh.points, axis=1).max() <= 1e-12 * result.diagonal
    document = result.to_dict()
    assert document["energy"]["fair"] <= document["energy"]["plain"]
    assert document["errors"]["crease"]["max"] <= 1e-12


def test_the_largest_components():
    mesh = mesh_of("two components")
    whole = subdfit.interpolate(mesh)
    part = subdfit.interpolate(mesh, keep_components=1)
    kept = part.control_mesh.topology.vertex_count
    assert 3 < kept < mesh.topology.vertex_count
    rows = [np.flatnonzero((mesh.points == p).all(axis=1))[0] for p in part.given.points]
    assert rows == sorted(rows)
    np.testing.assert_allclose(part.control_mesh.points, whole.control_mesh.points[rows], atol=1e-10)


def test_bad_options():
    data = octahedron_data()
    with pytest.raises(subdfit.InputError, match="has no mask"):
        subdfit.interpolate(data, scheme="loop", mask="averaging")
    for option in (
        {"method": "magic"},
        {"tolerance": 0},
        {"tolerance": "x"},
        {"most_iterations": 0},
        {"creases": "so"},
    ):
        with pytest.raises(subdfit.InputError):
            subdfit.interpolate(data, **option)
    with pytest.raises(subdfit.InputError, match="points only"):
        subdfit.interpolate(data[0])


def test_it_shows_itself():
    assert "6 points, within tolerance" in repr(subdfit.interpolate(octahedron_data()))


def test_what_cannot_be_met_is_told_and_fairness_meets_it(caplog):
    corner = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    corner[0] -= 0.3
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    plain, fair = (subdfit.interpolate((corner, quads), creases="none", fair=fair) for fair in (False, True))
    assert (plain.status, fair.status) == ("best_effort", "within_tolerance")
    assert plain.null_vectors == 1
    told = [text for text in caplog.messages if "cannot move all vertices" in text]
    assert ["the option fair meets every vertex" in text for text in told] == [True, False]
    assert relative_errors(plain, corner).max() == pytest.approx(plain.distances.max())
