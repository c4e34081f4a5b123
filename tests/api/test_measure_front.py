"""`subdfit.measure`: errors that are known beforehand."""

import numpy as np
import pytest

import subdfit
from subdfit.api import compare
from subdfit.errors import InputError


@pytest.fixture(scope="module")
def cage():
    import trimesh

    mesh = trimesh.creation.icosphere(1)
    return subdfit.ControlMesh.from_triangles(mesh.vertices, mesh.faces)


def test_samples_of_the_surface_lie_on_it(cage):
    drawn = subdfit.LimitSurface(cage).tessellate(3)
    found = subdfit.measure(cage, (drawn.points, drawn.triangles))
    assert found.max < 1e-7
    assert found.reverse_max <= 1.02 * found.faceting
    cloud = subdfit.measure(cage, drawn.points)
    assert cloud.max < 1e-7


def test_a_known_distance(cage):
    """Points moved off along the normal by a hundredth of the diagonal."""
    drawn = subdfit.LimitSurface(cage).tessellate(3)
    points = drawn.points + 0.03 * drawn.normals
    found = subdfit.measure(cage, (points, drawn.triangles))
    assert found.max * found.diagonal == pytest.approx(0.03, rel=1e-3)
    assert found.rms * found.diagonal == pytest.approx(0.03, rel=1e-3)
    assert found.reverse_mean * found.diagonal == pytest.approx(0.03, rel=0.1)


def test_judged_by_a_tolerance_only_where_asked(cage):
    drawn = subdfit.LimitSurface(cage).tessellate(3)
    target = drawn.points + 0.03 * drawn.normals, drawn.triangles
    plain, near, far = (compare(cage, target, max_error=bound) for bound in (None, 0.05, 0.01))
    assert (plain.status, plain.certified) == (None, False)
    assert (near.status, near.certified) == ("within_tolerance", True)
    assert (far.status, far.certified) == ("best_effort", False)
    assert far.to_dict()["settings"]["max_error"] == pytest.approx(0.01 / far.measurement.diagonal)


def test_the_scheme_of_a_cage(cage, caplog):
    points, faces = cage.points, cage.topology.triangles
    assert subdfit.api.control_mesh_of((points, faces)).scheme == "loop"
    named = subdfit.MeshData(points, np.arange(0, 3 * len(faces) + 1, 3), faces.ravel().astype(int), scheme="bilinear")
    with pytest.raises(InputError, match="its scheme is bilinear, which is not supported"):
        subdfit.measure(named, points)
    subdfit.measure(named, points, scheme="loop")
    assert "says that its scheme is bilinear; taken as loop" in caplog.text
    quads = np.eye(4)[:, :3], [[0, 1, 2, 3]]
    assert subdfit.api.control_mesh_of(quads).scheme == "catmull-clark"
    with pytest.raises(InputError, match="points only"):
        subdfit.measure(points, points)


def test_boundary_rules_of_a_file(caplog):
    """Rule 1 makes corners of boundary vertices with one face; rule 0 is not supported and says so."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    data = subdfit.api.mesh_data((points, [[0, 1, 2], [0, 2, 3]]))
    from dataclasses import replace

    smooth = subdfit.api.control_mesh_of(replace(data, interpolate_boundary=2))
    assert not smooth.topology.corner_sharpness.any()
    cornered = subdfit.api.control_mesh_of(replace(data, interpolate_boundary=1))
    np.testing.assert_array_equal(np.flatnonzero(cornered.topology.corner_sharpness), [1, 3])
    np.testing.assert_allclose(subdfit.LimitSurface(cornered).vertex_limits()[[1, 3]], points[[1, 3]])
    subdfit.api.control_mesh_of(replace(data, interpolate_boundary=0))
    assert "asks for no rule at its boundary" in caplog.text
