"""`subdfit.reconstruct` and ``subdfit reconstruct``."""

import json

import numpy as np
import pytest

import subdfit
from subdfit.api.reconstructing import METHODS
from subdfit.cli import main
from subdfit.cli import reconstruct as command


@pytest.fixture
def cloud(sphere, tmp_path):
    """Write the points of a sphere, one twice, with normals that point inward."""
    points = np.concatenate([sphere[0], sphere[0][:1]])
    path = tmp_path / "cloud.xyz"
    np.savetxt(path, np.concatenate([points, -points], axis=1), fmt="%.17g")
    return path


def volume(mesh):
    return np.linalg.det(mesh.points[mesh.face_vertices.reshape(-1, 3)]).sum() / 6


def test_methods_are_named_alike():
    assert METHODS == command.METHODS


def test_arrays_files_and_meshes_give_the_same_triangles(sphere, cloud):
    points, faces = sphere
    from_points = subdfit.reconstruct(points)
    from_mesh = subdfit.reconstruct((points, faces))
    np.testing.assert_array_equal(from_points.mesh.face_vertices, from_mesh.mesh.face_vertices)
    from_file = subdfit.reconstruct(cloud)
    assert from_file.mesh.face_count == from_points.mesh.face_count == len(faces)
    assert volume(from_points.mesh) == pytest.approx(-volume(from_file.mesh))
    assert volume(from_points.mesh) > 0
    assert from_file.repeated == 1


def test_command_writes_mesh_and_document(cloud, tmp_path, capsys):
    out, document = tmp_path / "mesh.ply", tmp_path / "mesh.json"
    assert main(["reconstruct", str(cloud), "-o", str(out), "--json", str(document), "--quiet"]) == 0
    mesh, said = subdfit.read(out), json.loads(document.read_text())
    assert (len(mesh.points), mesh.face_count) == (said["vertices"], said["faces"]) == (642, 1280)
    assert (said["left_out"], said["repeated"]) == ([], 1)
    assert capsys.readouterr().out.startswith("642 vertices, 1,280 triangles, 0 points left out")


@pytest.mark.parametrize("method", ["greedy"])
def test_the_same_bytes_on_one_thread_and_on_two(cloud, tmp_path, method):
    written = []
    for threads in (1, 2):
        out = tmp_path / f"{threads}.ply"
        assert main(["reconstruct", str(cloud), "-o", str(out), "--method", method, "--threads", str(threads)]) == 0
        written.append(out.read_bytes())
    assert written[0] == written[1]


def test_simplified_to_data_points(cloud, tmp_path, sphere):
    out, document = tmp_path / "mesh.ply", tmp_path / "mesh.json"
    call = ["reconstruct", str(cloud), "-o", str(out), "--vertices", "100", "--keep-data-points", "--quiet"]
    assert main([*call, "--json", str(document)]) == 0
    mesh = subdfit.read(out)
    assert len(mesh.points) == json.loads(document.read_text())["vertices"] == 100
    given = set(map(tuple, np.float32(sphere[0]).tolist()))
    assert set(map(tuple, np.float32(mesh.points).tolist())) <= given


def test_simplified_to_a_tolerance(sphere):
    diagonal = 2 * np.sqrt(3)
    found = subdfit.reconstruct(sphere[0], max_error="0.5%", keep_data_points=True)
    assert 0 < found.error <= 0.005 * diagonal * (1 + 1e-12)
    assert len(found.mesh.points) < 642
    np.testing.assert_array_equal(sphere[0][found.point_rows], found.mesh.points)
    assert subdfit.reconstruct(sphere[0], max_error="0.5%").point_rows is None


def test_bad_calls_are_refused_in_one_line(tmp_path, cloud, capsys):
    line = tmp_path / "line.xyz"
    np.savetxt(line, np.linspace(0, 1, 40)[:, None] * [1, 1, 1])
    out, alone = tmp_path / "out.ply", [str(cloud), "--keep-data-points"]
    for call in ([str(line)], [str(cloud), "--gap", "0"], [str(cloud), "--vertices", "3"], alone, ["none.xyz"]):
        assert main(["reconstruct", *call, "-o", str(out), "--quiet"]) == 2
        assert len(capsys.readouterr().err.splitlines()) == 1
    assert not out.exists()


def test_a_count_out_of_reach_is_told(caplog):
    """A torus has seven vertices or more; a cloud has no more than its own."""
    u, v = 2 * np.pi * np.mgrid[:20, :15].reshape(2, -1) / [[20], [15]]
    around = 2 + np.cos(v)
    points = np.stack([around * np.cos(u), around * np.sin(u), np.sin(v)], axis=1)
    assert len(subdfit.reconstruct(points, vertices=4).mesh.points) >= 7
    assert len(subdfit.reconstruct(points, vertices=301).mesh.points) == 300
    assert "not 4: fewer would fold faces or change the topology" in caplog.messages[0]
    assert caplog.messages[1] == "the mesh through the points has 300 vertices, 301 were asked for: not simplified"


def test_unknown_methods_are_refused(sphere):
    with pytest.raises(subdfit.InputError, match="unknown method 'ball'; choose one of greedy"):
        subdfit.reconstruct(sphere[0], method="ball")
