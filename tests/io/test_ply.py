"""PLY in all the shapes the world writes it in."""

import struct

import numpy as np
import pytest

from subdfit.errors import InputError
from subdfit.io import read

HEADER = """ply
format {order} 1.0
comment subdivision scheme: loop
obj_info made by hand
element light 2
property uchar brightness
property list ushort double spectrum
element vertex 5
property double x
property uchar red
property float y
property short z
element face 3
property uchar flags
property list int uint vertex_index
property list uchar float texcoord
element edge 2
property int vertex1
property int vertex2
property float sharpness
end_header
"""
LIGHTS = [(7, [0.5, 0.25]), (8, [])]
VERTICES = [(0.125, 1, 0.5, -3), (1, 2, 0, 0), (1, 3, 1, 2), (0, 4, 1, 7), (2, 5, 2, 9)]
FACES = [(1, [0, 1, 2], [0.5]), (2, [0, 2, 3, 4], []), (3, [1, 2, 4], [1, 2, 3])]
EDGES = [(0, 1, 2.0), (2, 3, 0.0)]


def as_text() -> bytes:
    rows = [f"{b} {len(s)} {' '.join(map(str, s))}" for b, s in LIGHTS]
    rows += [" ".join(map(str, row)) for row in VERTICES]
    rows += [f"{f} {len(v)} {' '.join(map(str, v))} {len(t)} {' '.join(map(str, t))}" for f, v, t in FACES]
    rows += [" ".join(map(str, row)) for row in EDGES]
    return (HEADER.format(order="ascii") + "\n".join(rows) + "\n").encode()


def as_bytes(order: str) -> bytes:
    code = {"little": "<", "big": ">"}[order]
    body = b"".join(struct.pack(f"{code}BH{len(s)}d", b, len(s), *s) for b, s in LIGHTS)
    body += b"".join(struct.pack(f"{code}dBfh", *row) for row in VERTICES)
    for flags, corners, coordinates in FACES:
        body += struct.pack(f"{code}Bi{len(corners)}I", flags, len(corners), *corners)
        body += struct.pack(f"{code}B{len(coordinates)}f", len(coordinates), *coordinates)
    body += b"".join(struct.pack(f"{code}iif", *row) for row in EDGES)
    return HEADER.format(order=f"binary_{order}_endian").encode() + body


@pytest.mark.parametrize("content", [as_text(), as_bytes("little"), as_bytes("big")], ids=["text", "little", "big"])
def test_strange_but_lawful_files(tmp_path, content):
    (tmp_path / "a.ply").write_bytes(content)
    data = read(tmp_path / "a.ply")
    np.testing.assert_array_equal(data.points, [[x, y, z] for x, _, y, z in VERTICES])
    np.testing.assert_array_equal(data.face_offsets, [0, 3, 7, 10])
    np.testing.assert_array_equal(data.face_vertices, [0, 1, 2, 0, 2, 3, 4, 1, 2, 4])
    np.testing.assert_array_equal(data.crease_edges, [[0, 1]])  # sharpness 0 is no crease
    np.testing.assert_array_equal(data.crease_sharpness, [2])
    assert data.scheme == "loop"


@pytest.mark.parametrize("newline", [b"\r\n", b"\r"])
def test_header_with_other_line_ends(tmp_path, newline):
    content = as_bytes("little")
    end = content.index(b"end_header\n") + len(b"end_header\n")
    (tmp_path / "a.ply").write_bytes(content[:end].replace(b"\n", newline) + content[end:])
    assert read(tmp_path / "a.ply").face_count == 3


def test_triangle_strips_alternate(tmp_path):
    """A strip up a ladder and a second one, with a repeated vertex that only steers it, agree in orientation."""
    strip = [0, 1, 2, 3, 4, 5, -1, 5, 4, 6, 6, 7]
    body = np.arange(24, dtype="<f4").tobytes() + struct.pack(f"<i{len(strip)}i", len(strip), *strip)
    header = "ply\nformat binary_little_endian 1.0\nelement vertex 8\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz")
    header += "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    (tmp_path / "a.ply").write_bytes(header.encode() + body)
    triangles = read(tmp_path / "a.ply").face_vertices.reshape(-1, 3)
    expected = [[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5], [5, 4, 6]]
    np.testing.assert_array_equal(triangles, expected)


@pytest.mark.parametrize("row", [0, 1])
@pytest.mark.parametrize("order", ["ascii", "little", "big"])
def test_claims_are_checked_before_allocation(tmp_path, order, row):
    content = as_text() if order == "ascii" else as_bytes(order)
    for element in (b"vertex 5", b"face 3", b"light 2"):
        name = element.split()[0]
        for count in (b"999999999999", b"9"):
            (tmp_path / "a.ply").write_bytes(content.replace(b"element " + element, b"element " + name + b" " + count))
            with pytest.raises(InputError, match=r"a\.ply"):
                read(tmp_path / "a.ply")


@pytest.mark.parametrize("content", [as_text(), as_bytes("little"), as_bytes("big")], ids=["text", "little", "big"])
def test_every_truncation_is_refused(tmp_path, content):
    last = len(content.rstrip()) if content.startswith(b"ply\nformat ascii") else len(content)
    for length in range(1, last - 3):  # of the last number as text, any part is a number
        (tmp_path / "a.ply").write_bytes(content[:length])
        with pytest.raises(InputError):
            read(tmp_path / "a.ply")


@pytest.mark.parametrize("content", [as_text(), as_bytes("little")], ids=["text", "little"])
def test_more_than_the_header_states_is_refused(tmp_path, content):
    (tmp_path / "a.ply").write_bytes(content + b"17")
    with pytest.raises(InputError, match=r"(1 word|2 bytes) after the last row"):
        read(tmp_path / "a.ply")


@pytest.mark.parametrize(
    "line", ["element vertex -1", "element vertex 1e3", "property quad x", "property list float int x", "nonsense"]
)
def test_bad_header_lines_are_quoted(tmp_path, line):
    (tmp_path / "a.ply").write_text(f"ply\nformat ascii 1.0\n{line}\nend_header\n")
    with pytest.raises(InputError, match=f"line 3 '{line[:20]}"):
        read(tmp_path / "a.ply")


def test_real_files(meshes):
    dragon = read(meshes / "dragon.ply")
    assert (len(dragon.points), dragon.face_count, dragon.triangles_only) == (437645, 871414, True)
    control = read(meshes / "mechpart_control.ply")
    assert len(control.crease_edges) == 113
    goblet = read(meshes / "goblet.ply")
    assert np.bincount(np.diff(goblet.face_offsets)).tolist() == [0, 0, 0, 20, 490]
    kitten = read(meshes / "kitten_points.ply")
    assert kitten.face_count == 0
    np.testing.assert_allclose(np.linalg.norm(kitten.normals, axis=1), 1, atol=1e-3)
