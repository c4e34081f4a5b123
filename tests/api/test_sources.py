"""Every kind of object that may be a target gives the same arrays."""

from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

import subdfit
from shapes.plates import bent_plate
from subdfit.api.sources import source_of
from subdfit.api.targets import Preparation, prepare
from subdfit.errors import InputError
from subdfit.mesh.data import MeshData


def pyvista_like(points, faces):
    """Imitate ``pyvista.PolyData``: faces are padded with their sizes."""
    return SimpleNamespace(points=points, faces=np.concatenate([[len(face), *face] for face in faces]), n_strips=0)


def test_all_kinds_agree(sphere, tmp_path):
    points, faces = sphere
    path = tmp_path / "sphere.ply"
    data = source_of(sphere).data
    subdfit.write(path, data)
    mesh = subdfit.ControlMesh.from_data(data)
    kinds = [
        path,
        str(path),
        data,
        mesh,
        (points, faces),
        [points, faces.tolist()],
        trimesh.Trimesh(points, faces, process=False),
        pyvista_like(points, faces),
    ]
    for kind in kinds:
        found = source_of(kind).data
        np.testing.assert_array_equal(found.points, points)
        np.testing.assert_array_equal(found.face_vertices, faces.ravel())
        np.testing.assert_array_equal(np.diff(found.face_offsets), 3)


def test_points_alone(sphere):
    points = sphere[0]
    for kind in (points, points.tolist(), SimpleNamespace(points=points), trimesh.PointCloud(points)):
        found = source_of(kind).data
        assert found.face_count == 0
        np.testing.assert_array_equal(found.points, points)


def test_polygons_of_several_sizes():
    points = np.zeros((6, 3))
    faces = [[0, 1, 2], [2, 1, 3, 4], [4, 3, 5]]
    for kind in ((points, faces), pyvista_like(points, faces)):
        found = source_of(kind).data
        np.testing.assert_array_equal(found.face_offsets, [0, 3, 7, 10])
        np.testing.assert_array_equal(found.face_vertices, np.concatenate(faces))


def test_a_grid_of_cells_gives_its_surface(sphere):
    grid = SimpleNamespace(points=np.zeros((9, 3)), extract_surface=lambda: pyvista_like(*sphere))
    np.testing.assert_array_equal(source_of(grid).data.points, sphere[0])


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (3.0, "type float is not understood"),
        (None, "type NoneType is not understood"),
        (np.zeros((4, 2)), "shape \\(4, 2\\)"),
        ((np.zeros((3, 3)), [[0.5, 1, 2]]), "no integers"),
        ((np.zeros((3, 3)), np.zeros(3, int)), "shape \\(3,\\)"),
        ([["a", "b", "c"]], "no array of numbers"),
        (np.zeros((4, 3), complex), "they are complex"),
    ],
)
def test_what_is_no_mesh_is_refused_in_a_line(given, says):
    with pytest.raises(InputError, match=says) as caught:
        source_of(given)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("creases", "corners"), [("auto", 4), (30.0, 4), ("none", 0)])
def test_a_sheet_has_its_corners_whether_or_not_its_creases_are_tagged(creases, corners):
    points, triangles = bent_plate()
    inner = triangles[len(triangles) // 2, :2]
    data = MeshData(points, 3 * np.arange(len(triangles) + 1), triangles.ravel(), inner[None], np.array([10.0]))
    for given in (data, (points, triangles)):
        assert len(prepare(given, Preparation(creases=creases)).target.corners) == corners
    tagged = prepare(data, Preparation()).target
    assert sorted(tagged.crease_edges.ravel().tolist()) == sorted(inner.tolist())
