"""Every broken file is mended with a warning or refused in a line."""

import pytest

from subdfit.cli import main

MENDED = {
    "duplicate_face.ply": "1 duplicate face",
    "duplicate_vertices.ply": "114 repeated positions",
    "inconsistent_orientation.ply": "faces turned",
    "isolated_vertices.ply": "7 isolated vertices",
    "nonmanifold_vertex.ply": "1 vertex shared by separate fans",
    "zero_area.ply": "zero-area faces",
}
CLOUD = "empty_faces.ply"
REPAIRED = {"moebius.ply": "cannot be oriented", "nonmanifold_edge.ply": "more than two faces"}
REFUSED = {
    "index_out_of_range.off": "names vertex 9",
    "nan_inf.ply": "not finite",
    "truncated.ply": "the file ends",
}


def run(meshes, name, folder, *extra):
    out = folder / "out.obj"
    call = [
        "fit",
        str(meshes / "broken" / name),
        "-o",
        str(out),
        "--max-error",
        "2%",
        "--max-control-vertices",
        "200",
        "--quiet",
        *extra,
    ]
    return main(call), out.exists()


def test_every_file_is_judged(meshes):
    there = {path.name for path in (meshes / "broken").iterdir()}
    assert there == MENDED.keys() | REPAIRED.keys() | REFUSED.keys() | {CLOUD}


def test_a_file_without_faces_is_a_cloud(meshes, tmp_path, capsys):
    assert run(meshes, CLOUD, tmp_path) == (0, True)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(("name", "says"), MENDED.items())
def test_mended(meshes, name, says, tmp_path, capsys):
    assert run(meshes, name, tmp_path) == (0, True)
    warnings = capsys.readouterr().err.splitlines()
    assert any(line.startswith(f"subdfit: warning: {name}: ") and says in line for line in warnings)


@pytest.mark.parametrize(("name", "says"), (REFUSED | REPAIRED).items())
def test_refused(meshes, name, says, tmp_path, capsys):
    assert run(meshes, name, tmp_path) == (2, False)
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert lines[0].startswith(f"subdfit: error: {name}: ")
    assert says in lines[0]


@pytest.mark.parametrize("name", REPAIRED)
def test_repaired_where_asked(meshes, name, tmp_path, capsys):
    code, written = run(meshes, name, tmp_path, "--repair")
    assert code in (0, 1)
    assert written
    assert "cut" in capsys.readouterr().err


@pytest.mark.parametrize("name", REFUSED)
def test_not_even_repair_mends(meshes, name, tmp_path):
    assert run(meshes, name, tmp_path, "--repair") == (2, False)
