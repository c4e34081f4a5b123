"""`subdfit.fit`: what it accepts, what it promises."""

import logging

import numpy as np
import pytest
from tests.shapes.zoo import octahedron_data

import subdfit
from subdfit.errors import InputError


@pytest.fixture(scope="module")
def result(sphere):
    return subdfit.fit(sphere, max_error="0.3%", unit="mm", progress=lambda step: None)


def test_certified_means_that_an_independent_measurement_agrees(result, sphere):
    assert result.certified
    assert result.status == "within_tolerance"
    found = subdfit.measure(result.control_mesh, sphere)
    assert found.max == pytest.approx(result.measurement.max, rel=1e-9)
    assert found.max <= 0.003
    distance = result.surface.closest(sphere[0]).distance
    assert distance.max() / found.diagonal == pytest.approx(found.max, rel=1e-6)
    np.testing.assert_allclose(result.distances, distance, atol=1e-7 * found.diagonal)


def test_the_default_tolerance_is_a_tenth_of_a_per_cent(sphere):
    result = subdfit.fit(sphere, max_control_vertices=300)
    assert result.settings.tolerance.max == pytest.approx(1e-3)
    assert result.settings.tolerance.rms is None


def test_a_length_and_its_share_are_the_same_tolerance(result, sphere):
    diagonal = np.linalg.norm(np.ptp(sphere[0], axis=0))
    other = subdfit.fit(sphere, max_error=0.003 * diagonal)
    np.testing.assert_array_equal(other.control_mesh.points, result.control_mesh.points)


def test_threads_do_not_change_the_bytes(result, sphere):
    from subdfit import parallel

    before = parallel.threads()
    other = subdfit.fit(sphere, max_error="0.3%", threads=1)
    assert parallel.threads() == before
    np.testing.assert_array_equal(other.control_mesh.points, result.control_mesh.points)


def test_size_does_not_matter(result, sphere):
    other = subdfit.fit((256 * sphere[0], sphere[1]), max_error="0.3%")
    np.testing.assert_array_equal(other.control_mesh.points, 256 * result.control_mesh.points)
    assert other.to_dict()["errors"] == result.to_dict()["errors"]


def test_place_does_not_matter(sphere):
    """A part in millimetres, a kilometre from the origin."""
    points = 250.0 * sphere[0] + np.array([1e6, -3e5, 4e4])
    result = subdfit.fit((points, sphere[1]), max_error="0.3%")
    assert result.certified
    assert result.surface.closest(points).distance.max() <= 0.003 * result.measurement.diagonal
    assert result.distances.max() / result.measurement.diagonal == pytest.approx(result.measurement.max)


def test_what_was_asked_is_recorded(sphere):
    result = subdfit.fit(sphere, max_error="0.5%", creases=40, boundary="fixed", memory="4G", seed=7)
    settings = result.to_dict()["settings"]
    assert settings["max_error"] == pytest.approx(0.005)
    assert settings["rms_error"] is None
    asked = {"creases": 40.0, "boundary": "fixed", "fixed_boundary": True, "memory": 4 * 1024**3, "seed": 7}
    assert settings.items() >= asked.items()


def test_progress_is_told_of_usable_control_meshes(sphere):
    steps = []
    subdfit.fit(sphere, max_error="0.3%", progress=steps.append)
    assert [step.iteration for step in steps] == list(range(len(steps)))
    last = subdfit.measure(steps[-1].control_mesh, sphere)
    assert last.max == pytest.approx(steps[-1].max, rel=1e-3)


def test_an_interrupt_while_thinning_returns_the_lightest_so_far(sphere):
    counts = []

    def interrupt(step):
        counts.append(step.control_vertices)
        if step.stage == "thin":
            raise KeyboardInterrupt

    result = subdfit.fit(sphere, max_error="0.1%", thin=True, progress=interrupt)
    assert result.status == "interrupted"
    assert result.certified
    assert len(result.control_mesh.points) == counts[-1] < counts[-2]
    assert result.measurement.max == pytest.approx(subdfit.measure(result.control_mesh, sphere).max, rel=1e-6)


def test_an_interrupt_returns_the_best_so_far(sphere):
    def interrupt(step):
        if step.iteration == 1:
            raise KeyboardInterrupt

    result = subdfit.fit(sphere, max_error="0.0001%", progress=interrupt)
    assert result.status == "interrupted"
    assert not result.certified
    assert result.control_mesh.topology.vertex_count > 3


def test_a_budget_gives_the_best_effort(sphere):
    result = subdfit.fit(sphere, max_error="0.001%", control_vertices=20, max_control_vertices=30)
    assert result.status == "best_effort"
    assert result.control_mesh.topology.vertex_count <= 30


def test_polygons_are_cut_into_triangles():
    cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    result = subdfit.fit((cube, quads), max_error="20%")
    assert result.target.triangles.shape == (12, 3)


def test_creases_of_the_file_are_kept(sheet):
    data = subdfit.api.mesh_data(sheet)
    row = np.arange(25) * 25 + 12
    edges = np.column_stack([row[:-1], row[1:]])
    tagged = subdfit.MeshData(
        data.points, data.face_offsets, data.face_vertices, crease_edges=edges, crease_sharpness=np.full(24, 10.0)
    )
    result = subdfit.fit(tagged, max_error="0.5%")
    np.testing.assert_array_equal(result.target.crease_edges, edges)
    assert len(result.control_mesh.topology.crease_edges) > 0
    assert len(subdfit.fit(tagged, max_error="0.5%", creases="none").target.crease_edges) == 0


def test_components_and_holes(sphere, caplog):
    points, faces = sphere
    two = np.concatenate([points, points + np.array([3, 0, 0])]), np.concatenate([faces[1:], faces[5:] + len(points)])
    with caplog.at_level(logging.INFO, "subdfit"):
        result = subdfit.fit(two, max_error="1%", keep_components=1, fill_holes=10)
    assert len(result.target.used) == len(points)
    assert len(result.target.boundary_edges) == 0
    assert "kept 1 of 2 components" in caplog.text
    assert "closed 1 hole" in caplog.text


def test_mending_warns_with_a_count(sphere, caplog):
    lonely = np.vstack([sphere[0], np.full((3, 3), 9.0)])
    result = subdfit.fit((lonely, sphere[1]), max_error="1%")
    assert "3 isolated vertices" in caplog.text
    assert result.measurement.diagonal == pytest.approx(np.linalg.norm(np.ptp(sphere[0], axis=0)))


def test_memory_is_refused_with_the_estimate(sphere, tmp_path):
    with pytest.raises(InputError, match=r"mesh: a job with 642 points needs about \d+M of memory and 64M are allowed"):
        subdfit.fit(sphere, memory="64M")
    path = tmp_path / "large.ply"
    path.write_bytes(b"ply\n" + bytes(2_000_000))
    with pytest.raises(InputError, match=r"large\.ply: reading it needs about"):
        subdfit.fit(path, memory="100M")


def with_bad_point(points):
    return np.vstack([points[:-1], [[np.nan, 0, 0]]])


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"scheme": "lop"}, "unknown scheme 'lop'"),
        ({"method": "best"}, "unknown method 'best'"),
        ({"max_error": "-1%"}, "max_error is '-1%'"),
        ({"creases": "sharp"}, "creases is 'sharp'"),
        ({"creases": 200}, "creases is '200'"),
        ({"boundary": "free"}, "boundary is 'free'"),
        ({"keep_components": 0}, "keep_components is 0"),
        ({"fill_holes": 2.5}, "fill_holes is 2.5"),
        ({"control_vertices": 3}, "control_vertices is 3"),
        ({"control_vertices": 50, "max_control_vertices": 40}, "start with no more"),
        ({"threads": 0}, "threads is 0"),
        ({"seed": -1}, "seed is -1"),
        ({"memory": "much"}, "memory is 'much'"),
    ],
)
def test_bad_options_are_refused_before_the_work(sphere, options, says):
    with pytest.raises(InputError, match=says) as caught:
        subdfit.fit((with_bad_point(sphere[0]), sphere[1]), **options)
    assert "\n" not in str(caught.value)


def test_points_that_cannot_be_used(sphere):
    with pytest.raises(InputError, match="not finite"):
        subdfit.fit((with_bad_point(sphere[0]), sphere[1]))
    with pytest.raises(InputError, match="not finite"):
        subdfit.fit(with_bad_point(sphere[0]))
    with pytest.raises(InputError, match="lie on a line; a surface needs points beside it"):
        subdfit.fit(np.linspace(0, 1, 90).reshape(30, 3))
    with pytest.raises(InputError, match="no points"):
        subdfit.fit(np.empty((0, 3)))
    with pytest.raises(InputError, match="points: all points coincide"):
        subdfit.fit(np.ones((5, 3)))
    with pytest.raises(InputError, match=r"points: all points lie within 1e-300 of each other"):
        subdfit.fit(1e-300 * np.eye(3))
    with pytest.raises(InputError, match="mesh: its points are complex"):
        subdfit.fit(subdfit.MeshData(sphere[0] + 0j, 3 * np.arange(len(sphere[1]) + 1), sphere[1].ravel()))
    with pytest.raises(InputError, match="they are complex"):
        subdfit.ControlMesh.from_triangles(sphere[0] + 0j, sphere[1])


def test_no_more_control_vertices_than_data(caplog):
    subdfit.fit(octahedron_data(), control_vertices=10, max_error="20%")
    assert "mesh: control_vertices is 10, but there are only 6 data points to start from" in caplog.messages
