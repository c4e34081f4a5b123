"""`subdfit.segment` and ``subdfit segment``."""

import numpy as np
import pytest

import subdfit
from shapes import parts
from subdfit.cli import main


@pytest.fixture(scope="module")
def can(tmp_path_factory):
    """A PLY file of a closed cylinder."""
    path = tmp_path_factory.mktemp("parts") / "can.ply"
    subdfit.write(path, subdfit.api.mesh_data(parts.can()))
    return path


def test_the_command_writes_labels_features_and_a_picture(can, tmp_path, capsys):
    out, picture = tmp_path / "can_faces.ply", tmp_path / "can.png"
    assert main(["segment", str(can), "-o", str(out), "--picture", str(picture), "--quiet"]) == 0
    found = subdfit.segment(can)
    back = subdfit.read(out)
    np.testing.assert_array_equal(back.face_labels, found.labels)
    np.testing.assert_array_equal(np.sort(back.crease_edges), np.sort(found.feature_edges))
    np.testing.assert_array_equal(back.crease_sharpness, 10)
    assert picture.read_bytes()[:4] == b"\x89PNG"
    assert capsys.readouterr().out == f"{found.count} faces, {len(found.feature_edges)} feature edges\n"
    assert found.count == 3


def test_tagged_creases_are_taken(can, tmp_path):
    """A file's own tags part regions; those of one rim only leave wall and bottom to the curvature."""
    data = subdfit.read(can)
    rim = subdfit.segment(can).feature_edges
    upper = rim[(data.points[rim][:, :, 2] > 0).all(axis=1)]
    tagged = subdfit.MeshData(data.points, data.face_offsets, data.face_vertices, upper, np.full(len(upper), np.inf))
    found = subdfit.segment(tagged)
    np.testing.assert_array_equal(np.unique(found.feature_edges, axis=0), np.unique(np.sort(upper, axis=1), axis=0))


def test_the_same_bytes_on_one_thread_and_two(can, tmp_path):
    for threads in ("1", "2"):
        assert main(["segment", str(can), "-o", str(tmp_path / f"{threads}.ply"), "--threads", threads, "--quiet"]) == 0
    assert (tmp_path / "1.ply").read_bytes() == (tmp_path / "2.ply").read_bytes()


def test_bad_calls_are_refused_in_one_line(can, tmp_path, capsys):
    turns = [["-o", "x.ply", "--least-turn", turn] for turn in ("nan", "-5", "inf")]
    radius, creases = ["-o", "x.ply", "--radius", "-1"], ["-o", "x.ply", "--creases", "sharp"]
    for options in (["-o", "faces.obj"], radius, creases, *turns):
        assert main(["segment", str(can), *options[:1], str(tmp_path / options[1]), *options[2:], "--quiet"]) == 2
        assert capsys.readouterr().err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_radius_may_be_a_share_of_the_diagonal(can):
    diagonal = np.linalg.norm([2, 2, 3])
    share, length = (subdfit.segment(can, radius=radius) for radius in ("5%", 0.05 * diagonal))
    np.testing.assert_array_equal(share.labels, length.labels)
