"""``subdfit convert``."""

import itertools

import numpy as np
import pytest

import subdfit
from subdfit.cli import main

KEEPING = (".obj", ".ply", ".json")
"""Formats that keep all that a control mesh is."""


@pytest.fixture
def quads(tmp_path):
    """Return an OBJ file of quads and pentagons with semi-sharp tags, its vertices in no special order."""
    path = tmp_path / "given.obj"
    angle = 2 * np.pi * np.arange(5) / 5
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0.1 * angle])
    points = np.vstack([ring, ring + np.array([0, 0, 1 / 3])])
    faces = [[4, 3, 2, 1, 0], [5, 6, 7, 8, 9], *([i, (i + 1) % 5, 5 + (i + 1) % 5, 5 + i] for i in range(5))]
    lines = ["# subdivision scheme: catmull-clark", *("v {!r} {!r} {!r}".format(*p) for p in points.tolist())]
    lines += ["f " + " ".join(str(v + 1) for v in face) for face in faces]
    lines += ["t crease 2/1/0 0 1 2.25", "t crease 2/1/0 6 7 10.0", "t corner 1/1/0 3 0.5"]
    path.write_text("\n".join(lines) + "\n")
    return path


def same(a, b):
    for name in ("points", "face_offsets", "face_vertices", "corner_vertices", "corner_sharpness"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)
    pairs = [
        {(*sorted(ends), s) for ends, s in zip(data.crease_edges.tolist(), data.crease_sharpness, strict=True)}
        for data in (a, b)
    ]
    assert pairs[0] == pairs[1]
    assert a.scheme == b.scheme


def test_nothing_is_lost_between_formats_that_keep_all(quads, tmp_path, capsys):
    chain = [quads]
    for number, suffix in enumerate((*KEEPING, *KEEPING[::-1])):
        chain.append(tmp_path / f"{number}{suffix}")
    given = subdfit.read(quads)
    for source, target in itertools.pairwise(chain):
        assert main(["convert", str(source), "-o", str(target), "--quiet"]) == 0
        said = capsys.readouterr()
        assert said.out == "catmull-clark: 10 vertices, 7 faces, 2 creases, 1 corner\n"
        assert said.err == ""
        same(subdfit.read(target), given)


def test_the_same_mesh_gives_the_same_bytes(quads, tmp_path):
    for suffix in (*KEEPING, ".off", ".glb"):
        for name in ("a", "b"):
            assert main(["convert", str(quads), "-o", str(tmp_path / (name + suffix)), "--quiet"]) == 0
        assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


def test_what_a_format_cannot_hold_is_named(quads, tmp_path, capsys):
    assert main(["convert", str(quads), "-o", str(tmp_path / "a.off"), "--quiet"]) == 0
    warning = capsys.readouterr().err
    assert all(word in warning for word in ("scheme", "creases", "corners"))
    assert warning.startswith("subdfit: warning: a.off: ")


def test_another_scheme_is_taken_with_a_warning(cage, tmp_path, capsys):
    loop, out = tmp_path / "loop.json", tmp_path / "a.json"
    assert main(["convert", str(cage), "-o", str(loop), "--quiet"]) == 0
    assert subdfit.read(loop).scheme == "loop"
    assert capsys.readouterr().err == ""
    assert main(["convert", str(loop), "-o", str(out), "--scheme", "catmull-clark", "--quiet"]) == 0
    said = capsys.readouterr()
    assert "says that its scheme is loop; taken as catmull-clark as asked" in said.err
    assert said.out.startswith("catmull-clark: ")
    assert subdfit.read(out).scheme == "catmull-clark"


def test_a_file_that_names_no_scheme_gets_one_by_its_faces(quads, cage, tmp_path):
    for source, scheme in ((cage, "loop"), (quads, "catmull-clark")):
        silent = tmp_path / f"{scheme}.off"
        assert main(["convert", str(source), "-o", str(silent), "--quiet"]) == 0
        assert main(["convert", str(silent), "-o", str(tmp_path / "x.obj"), "--quiet"]) == 0
        assert subdfit.read(tmp_path / "x.obj").scheme == scheme


def test_drawn_formats_get_the_limit_surface(quads, tmp_path):
    surface = subdfit.LimitSurface(quads)
    out = [tmp_path / "a.stl", tmp_path / "b.obj"]
    assert main(["convert", str(quads), "-o", str(out[0]), "--quiet"]) == 0
    assert main(["convert", str(quads), "-o", str(out[1]), "--tessellate", "1", "--quiet"]) == 0
    for path in out:
        assert surface.closest(subdfit.read(path).points).distance.max() < 1e-6
    assert subdfit.read(out[1]).scheme is None
    assert subdfit.read(out[1]).face_count == 8 * surface.domain.face_count


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (["-o", "x.doc"], "cannot write files of type .doc"),
        (["-o", "x.obj", "--scheme", "loop"], "takes triangles only"),
        (["-o", "x.obj", "--tessellate", "9"], "--tessellate is 9"),
        (["-o", "x.obj", "-o", "x.obj"], "is named twice"),
    ],
)
def test_bad_calls_write_nothing(quads, tmp_path, monkeypatch, capsys, call, says):
    folder = tmp_path / "empty"
    folder.mkdir()
    monkeypatch.chdir(folder)
    assert main(["convert", str(quads), *call, "--quiet"]) == 2
    said = capsys.readouterr().err
    assert says in said
    assert said.count("\n") == 1
    assert not list(folder.iterdir())


def test_points_alone_are_refused(tmp_path, capsys):
    cloud = tmp_path / "cloud.xyz"
    np.savetxt(cloud, np.eye(3))
    assert main(["convert", str(cloud), "-o", str(tmp_path / "a.obj"), "--quiet"]) == 2
    assert "has points only" in capsys.readouterr().err


def test_broken_files_never_end_in_a_traceback(meshes, tmp_path, capsys):
    for path in sorted((meshes / "broken").iterdir()):
        code = main(["convert", str(path), "-o", str(tmp_path / f"{path.stem}.obj"), "--quiet"])
        assert code in (0, 2)
        lines = capsys.readouterr().err.splitlines()
        assert all(line.startswith("subdfit: ") for line in lines)
        assert (tmp_path / f"{path.stem}.obj").exists() == (code == 0)
