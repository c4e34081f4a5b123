"""What is written comes back, in every format, bit for bit where the format can hold it."""

import io
import logging
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from subdfit.errors import InputError
from subdfit.io import read, write
from subdfit.mesh.data import MeshData


def assert_same_surface(a: MeshData, b: MeshData) -> None:
    assert a.points.dtype == b.points.dtype == np.float64
    assert a.points.tobytes() == b.points.tobytes() or np.array_equal(a.points, b.points)
    np.testing.assert_array_equal(a.face_offsets, b.face_offsets)
    np.testing.assert_array_equal(a.face_vertices, b.face_vertices)


@pytest.mark.parametrize("extension", ["obj", "ply", "json"])
def test_control_mesh_keeps_everything(house, tmp_path, extension):
    write(tmp_path / f"a.{extension}", house)
    back = read(tmp_path / f"a.{extension}")
    assert_same_surface(back, house)
    np.testing.assert_array_equal(back.crease_edges, house.crease_edges)
    np.testing.assert_array_equal(back.crease_sharpness, [10, 2.5])  # 10 is how files say for ever
    np.testing.assert_array_equal(back.corner_vertices, [4])
    np.testing.assert_array_equal(back.corner_sharpness, [3.25])
    assert (back.scheme, back.interpolate_boundary) == ("catmull-clark", 2)


@pytest.mark.parametrize("extension", ["obj", "ply", "json"])
def test_normals_come_back(tetrahedron, tmp_path, extension):
    data = replace(tetrahedron, normals=np.random.default_rng(1).normal(size=(4, 3)))
    write(tmp_path / f"a.{extension}", data)
    np.testing.assert_array_equal(read(tmp_path / f"a.{extension}").normals, data.normals)


@pytest.mark.parametrize("extension", ["obj", "ply", "json"])
def test_points_alone_come_back(tmp_path, extension):
    cloud = MeshData(np.random.default_rng(2).normal(size=(20, 3)), np.zeros(1, np.int64), np.empty(0, np.int64))
    write(tmp_path / f"a.{extension}", cloud)
    assert_same_surface(read(tmp_path / f"a.{extension}"), cloud)


def test_labels_of_faces_come_back(house, tmp_path):
    labels = np.arange(house.face_count) % 3
    write(tmp_path / "a.ply", replace(house, face_labels=labels))
    back = read(tmp_path / "a.ply")
    assert_same_surface(back, house)
    np.testing.assert_array_equal(back.face_labels, labels)
    assert "property int label" in (tmp_path / "a.ply").read_bytes().split(b"end_header")[0].decode()


def test_nothing_unsaid_is_written(tetrahedron, tmp_path):
    write(tmp_path / "a.obj", tetrahedron)
    assert {line.split()[0] for line in (tmp_path / "a.obj").read_text().splitlines()} == {"v", "f"}


def test_off_keeps_polygons_and_warns_of_the_rest(house, tmp_path, caplog):
    with caplog.at_level(logging.WARNING):
        write(tmp_path / "a.off", house)
    assert len(caplog.records) == 1
    assert "scheme" in caplog.text
    assert "creases" in caplog.text
    assert_same_surface(read(tmp_path / "a.off"), house)


@pytest.mark.parametrize("extension", ["stl", "glb"])
def test_tessellations_come_back(tetrahedron, tmp_path, extension):
    write(tmp_path / f"a.{extension}", tetrahedron)
    back = read(tmp_path / f"a.{extension}")
    assert back.triangles_only
    np.testing.assert_array_equal(back.points[back.face_vertices], tetrahedron.points[tetrahedron.face_vertices])


@pytest.mark.parametrize("extension", ["stl", "glb"])
def test_tessellations_are_understood_elsewhere(tetrahedron, tmp_path, extension):
    write(tmp_path / f"a.{extension}", replace(tetrahedron, normals=np.eye(4, 3) + 0.5))
    other = trimesh.load_mesh(tmp_path / f"a.{extension}")
    assert other.is_watertight
    assert other.volume == pytest.approx(1 / 12)


@pytest.mark.parametrize("extension", ["stl", "glb"])
def test_polygons_are_no_tessellation(house, tmp_path, extension):
    with pytest.raises(InputError, match="triangles only"):
        write(tmp_path / f"a.{extension}", house)
    assert not list(tmp_path.iterdir())


def test_scene_of_two_meshes_is_read_in_place(tmp_path):
    box = trimesh.creation.box()
    moved = box.copy().apply_translation([5, 0, 0])
    (tmp_path / "a.glb").write_bytes(trimesh.Scene([box, moved]).export(file_type="glb"))
    data = read(tmp_path / "a.glb")
    assert data.face_count == 24
    np.testing.assert_allclose([data.points.min(axis=0), data.points.max(axis=0)], [[-0.5] * 3, [5.5, 0.5, 0.5]])


def test_ascii_stl(tmp_path):
    (tmp_path / "a.stl").write_text(trimesh.creation.box().export(file_type="stl_ascii"))
    assert read(tmp_path / "a.stl").face_count == 12


def test_a_cut_binary_stl_is_told_by_its_counts(tmp_path):
    content = trimesh.creation.box().export(file_type="stl")
    (tmp_path / "a.stl").write_bytes(content[:-60])
    with pytest.raises(InputError, match=r"states 12 triangles, the file holds 10\.8"):
        read(tmp_path / "a.stl")


@pytest.mark.parametrize("extension", ["obj", "ply", "json", "off", "stl", "glb"])
def test_same_mesh_same_bytes(tetrahedron, tmp_path, extension):
    for name in "ab":
        write(tmp_path / f"{name}.{extension}", tetrahedron)
    assert (tmp_path / f"a.{extension}").read_bytes() == (tmp_path / f"b.{extension}").read_bytes()


def test_large_polygons_in_ply(tmp_path):
    angles = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    ring = np.stack([np.cos(angles), np.sin(angles), np.zeros(300)], axis=1)
    polygon = MeshData(ring, np.array([0, 300, 303]), np.append(np.arange(300), [0, 5, 9]))
    write(tmp_path / "a.ply", polygon)
    assert_same_surface(read(tmp_path / "a.ply"), polygon)


def test_xyz(tmp_path):
    rows = np.random.default_rng(3).normal(size=(7, 6))
    for columns, mark in ((3, " "), (6, " "), (3, ","), (6, "; ")):
        text = io.StringIO()
        np.savetxt(text, rows[:, :columns], fmt="%.17g", header="points", delimiter=mark)
        (tmp_path / "a.xyz").write_text(text.getvalue())
        data = read(tmp_path / "a.xyz")
        np.testing.assert_array_equal(data.points, rows[:, :3])
        assert data.face_count == 0
        assert (data.normals is None) == (columns == 3)
