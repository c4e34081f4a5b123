"""Bytes flipped, cut and doubled: a mesh or one clean line, never anything else."""

from dataclasses import replace

import numpy as np
import pytest

from subdfit.errors import InputError
from subdfit.io import read, write
from subdfit.mesh.repair import mend


def damaged(content: bytes, rng: np.random.Generator) -> bytes:
    work = bytearray(content)
    kind = rng.integers(4)
    if kind == 0:
        return bytes(work[: rng.integers(len(work))])
    if kind == 1:
        start, length = rng.integers(len(work)), rng.integers(1, 40)
        return bytes(work[:start] + work[start : start + length] * 2 + work[start + length :])
    for _ in range(rng.integers(1, 6)):
        at = rng.integers(len(work))
        work[at] = rng.integers(256) if kind == 2 else work[at] ^ (1 << rng.integers(8))
    return bytes(work)


@pytest.mark.parametrize("extension", ["obj", "ply", "off", "json", "stl", "glb", "xyz"])
def test_damaged_files(house, tetrahedron, tmp_path, extension):
    path = tmp_path / f"a.{extension}"
    if extension == "xyz":
        path.write_text("0 0 0 0 0 1\n1 0 0.5 0 0 1\n-1 2e3 7 1 0 0\n")
    elif extension in ("stl", "glb"):
        write(path, tetrahedron)
    else:
        write(path, replace(house, normals=house.points) if extension != "off" else tetrahedron)
    content = path.read_bytes()
    rng = np.random.default_rng(20)
    outcomes = []
    for _ in range(400):
        path.write_bytes(damaged(content, rng))
        try:
            mend(read(path), repair=bool(rng.integers(2)), name=path.name)
            outcomes.append("")
        except InputError as error:
            outcomes.append(str(error))
    refusals = [line for line in outcomes if line]
    assert 0 < len(refusals) < len(outcomes)
    assert all(path.name in line and "\n" not in line for line in refusals)


def test_noise(tmp_path):
    rng = np.random.default_rng(21)
    for extension in ("obj", "ply", "off", "json", "stl", "glb", "gltf", "xyz"):
        for start in (b"", b"ply\n", b"OFF\n", b"glTF", b"{", b"solid x\n", b"v "):
            path = tmp_path / f"a.{extension}"
            path.write_bytes(start + rng.bytes(300))
            with pytest.raises(InputError):
                read(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x y z\n0 0 0\n", "line 1, 'x y z': 'x' is not a number"),
        ("# made by hand\n\n0 0 0\n0 0 1\nup and away\n", "line 5, 'up and away': 'up' is not a number"),
        ("0 0 0\n1 0 0 0 0 1\n", "line 2, .* has not 3 numbers"),
        ("0\n", "line 1, '0', has 1 word, not 3 numbers"),
        ("0,5 1,0 2,5\n", "line 1, '0,5 1,0 2,5', has commas or semicolons, but not one between any two numbers"),
        ("0,0,0\n1,,2,3\n", "line 2, .* not one between any two"),
        ("0,0,0\n1 2 3\n", "line 2, .* not one between any two"),
        ("0,5;1,0;2,5\n", "line 1, .* not one between any two"),
    ],
)
def test_lines_of_points_are_named(text, message, tmp_path):
    path = tmp_path / "a.xyz"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        read(path)


TRIANGLE = b"0 0 0\n1 0 %s\n0 1 0\n3 0 1 %s\n"
PLY = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
PLY += b"element face 1\nproperty list uchar int vertex_indices\nend_header\n"


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("a.off", b"OFF\n3 1 0\n\n# x\n" + TRIANGLE % (b"1,5", b"2"), "line 6: '1,5' is not a number"),
        ("a.off", b"OFF 3 1 0\n\n" + TRIANGLE % (b"0", b"2.5"), "line 6: '2.5' is not an index"),
        ("a.ply", PLY + TRIANGLE % (b"1,5", b"2"), "row 1 of 'vertex', z: '1,5' is not a number"),
        ("a.ply", PLY + TRIANGLE % (b"0", b"2.5"), "row 0 of 'face', vertex_indices: '2.5' is not an index"),
    ],
)
def test_the_place_of_what_is_no_number_is_named(name, content, says, tmp_path):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=says):
        read(tmp_path / name)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("a.off", b"OFF\n3 1 0\n" + TRIANGLE % (b"0", b"2")),
        ("a.ply", PLY + TRIANGLE % (b"0", b"2")),
        ("a.xyz", b"0 0 0\n1 0 0\n0 1 0\n"),
    ],
)
def test_a_byte_order_mark_is_no_content(name, content, tmp_path):
    (tmp_path / name).write_bytes(b"\xef\xbb\xbf" + content)
    np.testing.assert_array_equal(read(tmp_path / name).points, [[0, 0, 0], [1, 0, 0], [0, 1, 0]])


def test_colours_are_no_normals(tmp_path, caplog):
    path = tmp_path / "a.xyz"
    path.write_text("0 0 0 255 128 0\n0 0 1 9 0 77\n")
    assert read(path).normals is None
    assert "taken as colours" in caplog.text
