"""OBJ as modellers and OpenSubdiv write it."""

import numpy as np
import pytest

from subdfit.errors import InputError
from subdfit.io import read


@pytest.fixture
def parse(tmp_path):
    def _parse(text: str):
        (tmp_path / "a.obj").write_bytes(text.encode())
        return read(tmp_path / "a.obj")

    return _parse


SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def test_indices_of_all_kinds(parse):
    text = SQUARE + "vt 0 0\nvn 0 0 1\nf 1 2/1 3/1/1 \\\n 4//1\nf -4 -3 -2\nv 5 5 5\nf -1/-1/-1 1 2\n"
    data = parse(text)
    np.testing.assert_array_equal(data.face_offsets, [0, 4, 7, 10])
    np.testing.assert_array_equal(data.face_vertices, [0, 1, 2, 3, 0, 1, 2, 4, 0, 1])


def test_unknown_statements_colours_and_line_ends_are_skipped(parse):
    data = parse(
        "mtllib a.mtl\r\no thing\r\n\tv 0 0 0 1 0 0\r\nv 1 0 0 .5\r\nv 0 1 0\r\ns 1\r\nusemtl x\r\nf 1 2 3\r\n"
    )
    assert data.points.shape == (3, 3)
    np.testing.assert_array_equal(data.face_vertices, [0, 1, 2])


def test_opensubdiv_tags(parse):
    tags = "t crease 2/1/0 0 1 2.5\nt crease 3/1/0 1 2 3 10\nt crease 3/2/0 0 2 3 1 0\n"
    tags += "t corner 2/1/0 0 3 4\nt hole 1/0/0 0\n"
    data = parse("# subdivision scheme: loop\n" + SQUARE + "f 1 2 3 4\n" + tags + "t interpolateboundary 1/0/0 1\n")
    np.testing.assert_array_equal(data.crease_edges, [[0, 1], [1, 2], [2, 3], [0, 2]])
    np.testing.assert_array_equal(data.crease_sharpness, [2.5, 10, 10, 1])
    np.testing.assert_array_equal(data.corner_vertices, [0, 3])
    np.testing.assert_array_equal(data.corner_sharpness, [4, 4])
    assert (data.scheme, data.interpolate_boundary) == ("loop", 1)


def test_normals_count_where_each_vertex_has_one(parse):
    normals = "vn 0 0 1\nvn 0 1 0\n"
    one_each = parse(SQUARE + normals + "f 1//1 2//2 3//2\nf 1//1 3//2 4//1\n")
    np.testing.assert_array_equal(one_each.normals[:, 1], [0, 1, 1, 0])
    assert parse(SQUARE + normals + "f 1//1 2//2 3//2\nf 1//2 3//2 4//1\n").normals is None


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("v 1 2\n", "line 1: .* fewer than 3"),
        ("v 1 2 3\n# x\n\n\tv 1 2 x3\n", "line 4: 'x3' is not a number"),
        ("v 1 2 3\nv 1 2 \\\n3\r\nv 1 \\\r\n2 x3\n", "line 4: 'x3' is not a number"),
        ("v 1 2 3\nvn 1 0 0\nvn 0 0,5 1\n", "line 3: '0,5' is not a number"),
        (SQUARE + "f 1 2 0\n", "line 5: .* counts from 1"),
        (SQUARE + "f 1 2 -5\n", "line 5: .* before the first"),
        (SQUARE + "f 1 2 5\n", "line 5: names row 5, there are 4"),
        (SQUARE + "f 1 2 a\n", "line 5: 'a' is not an index"),
        (SQUARE + "f 1 2 3 4\n\nf 1 2 1.5\n", "line 7: '1.5' is not an index"),
        (SQUARE + "vn 0 0 1\nf 1//1 2//1 3//2\n", "line 6: names row 2, there are 1"),
        (SQUARE + "f 1 2 99999999999999999999\n", "is not an index"),
        (SQUARE + "v nan 0 0\n", "not finite"),
        (SQUARE + "v 1e999 0 0\n", "not finite"),
        (SQUARE + "t crease 2/1/0 0 1\n", "announces"),
        (SQUARE + "t crease 2/1/0 0 9 1\n", "names vertex 9"),
        (SQUARE + "t crease 2/1/0 0 1 -1\n", "sharpness is -1"),
        (SQUARE + "t interpolateboundary 1/0/0 3\n", "must be 0, 1 or 2"),
        ("f 1 2 3\n", "line 1: names row 1, there are 0"),
        ("hello\n", "no points"),
    ],
)
def test_refusals_say_why(parse, text, says):
    with pytest.raises(InputError, match=says) as caught:
        parse(text)
    assert "\n" not in str(caught.value)
    assert "a.obj" in str(caught.value)
