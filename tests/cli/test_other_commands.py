"""``subdfit subdivide``, ``measure`` and ``demo``."""

import json
import logging

import numpy as np
import pytest

import subdfit
from subdfit.cli import main
from subdfit.cli.console import Console
from subdfit.cli.demo import FILES


@pytest.mark.parametrize("levels", [1, 2])
def test_subdivide_keeps_creases_and_corners(cage, tmp_path, levels, capsys):
    out = tmp_path / "fine.obj"
    assert main(["subdivide", str(cage), "-o", str(out), "--levels", str(levels), "--quiet"]) == 0
    fine = subdfit.read(out)
    assert fine.face_count == 8 * 4**levels
    assert len(fine.crease_edges) == 2 * 2**levels
    assert len(fine.corner_vertices) == 1
    assert fine.scheme == "loop"
    np.testing.assert_array_equal(fine.points[fine.corner_vertices], [[0, -1, 0]])
    said = capsys.readouterr()
    assert said.out == f"{len(fine.points):,} vertices, {fine.face_count:,} faces\n"
    assert said.err == ""


def test_subdivide_at_the_limit(cage, tmp_path):
    out = tmp_path / "fine.ply"
    assert main(["subdivide", str(cage), "-o", str(out), "--levels", "2", "--limit", "--quiet"]) == 0
    assert subdfit.LimitSurface(cage).closest(subdfit.read(out).points).distance.max() < 1e-7


def test_subdivide_refuses_bad_levels(cage, tmp_path, capsys):
    for levels in ("-1", "40"):
        assert main(["subdivide", str(cage), "-o", str(tmp_path / "x.obj"), "--levels", levels, "--quiet"]) == 2
        assert "levels" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_measure_judges_where_a_tolerance_is_given(cage, sphere, tmp_path, capsys):
    document = tmp_path / "m.json"
    call = ["measure", str(cage), str(sphere), "--json", str(document)]
    assert main(call) == 0
    assert json.loads(document.read_text())["status"] is None
    assert main([*call, "--max-error", "1%"]) == 1
    assert json.loads(document.read_text())["status"] == "best_effort"
    assert main([*call, "--max-error", "90%"]) == 0
    assert json.loads(document.read_text())["certified"] is True


def test_demo_on_a_file(sphere, tmp_path, capsys):
    folder = tmp_path / "shown"
    assert main(["demo", str(sphere), "-o", str(folder), "--max-error", "1%"]) == 0
    assert {path.name for path in folder.iterdir()} == set(FILES)
    said = capsys.readouterr().out
    assert all(name in said for name in FILES)
    assert "certified" in said.splitlines()[-1]
    assert "synthetic" not in said


def test_demo_says_that_its_model_is_synthetic(tmp_path, monkeypatch, capsys):
    import trimesh

    ball = trimesh.creation.icosphere(3)
    monkeypatch.setattr("subdfit.target.synthetic_scan.synthetic_scan", lambda seed: (ball.vertices, ball.faces))
    monkeypatch.chdir(tmp_path)
    assert main(["demo", "--max-error", "1%", "--quiet"]) == 0
    folder = tmp_path / "subdfit-demo"
    assert {path.name for path in folder.iterdir()} == {*FILES, "scan.ply"}
    assert "synthetic" in capsys.readouterr().out.splitlines()[0]


def test_demo_folder_that_cannot_be_made(sphere, tmp_path, capsys):
    (tmp_path / "taken").write_text("a file")
    assert main(["demo", str(sphere), "-o", str(tmp_path / "taken"), "--quiet"]) == 3
    assert "cannot make the folder" in capsys.readouterr().err


def test_plain_lines_where_there_is_no_terminal(sphere, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("subdfit.cli.console.PAUSE", 0.0)
    assert main(["fit", str(sphere), "-o", str(tmp_path / "a.obj"), "--max-error", "0.5%"]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert all(line.startswith("subdfit: ") and line.endswith(" s") for line in lines)
    assert any("control vertices, E_max" in line and "E_rms" in line for line in lines)


def test_compiling_is_told(capsys):
    with Console(quiet=False):
        logging.getLogger("subdfit.compiled").info("compiling kernels for this machine (first run only)")
        logging.getLogger("subdfit.initial.decimate").info("not for users")
    with Console(quiet=True):
        logging.getLogger("subdfit.compiled").info("compiling")
    assert capsys.readouterr().err == "subdfit: compiling kernels for this machine (first run only)\n"


def test_the_console_leaves_logging_as_it_was():
    logger = logging.getLogger("subdfit")
    before = logger.level, logger.propagate, list(logger.handlers)
    with Console(quiet=True):
        assert len(logger.handlers) == len(before[2]) + 1
    assert (logger.level, logger.propagate, list(logger.handlers)) == before


def test_the_live_line_on_a_terminal(monkeypatch, capsys):
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    monkeypatch.setenv("TERM", "xterm")
    with Console(quiet=False) as console:
        console.stage("reading")
        logging.getLogger("subdfit").warning("careful")
    said = capsys.readouterr().err
    assert "reading, 0." in said
    assert "subdfit: warning: careful" in said
