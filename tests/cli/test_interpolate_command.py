"""``subdfit interpolate``."""

import json

import numpy as np
import pytest

import subdfit
from subdfit.cli import main


@pytest.mark.parametrize("method", ["cg", "progressive"])
def test_the_surface_passes_through_every_vertex(sphere, tmp_path, method, capsys):
    out, document = tmp_path / "cage.obj", tmp_path / "i.json"
    call = ["interpolate", str(sphere), "-o", str(out), "--method", method, "--json", str(document), "--quiet"]
    assert main(call) == 0
    points = subdfit.read(sphere).points
    limits = subdfit.LimitSurface(out).vertex_limits()
    assert np.linalg.norm(limits - points, axis=1).max() < 4e-12
    found = json.loads(document.read_text())
    assert found["status"] == "within_tolerance"
    assert found["residuals"][-1] <= 1e-12
    assert found["control_vertices"] == len(points)
    assert found["seconds"]["total"] > 0
    said = capsys.readouterr()
    assert said.out.startswith("642 control vertices, largest relative error")
    assert said.err == ""


def test_best_effort_is_exit_code_one(sphere, tmp_path, capsys):
    out = tmp_path / "cage.ply"
    assert main(["interpolate", str(sphere), "-o", str(out), "--tolerance", "1e-19", "--quiet"]) == 1
    assert "tolerance not reached" in capsys.readouterr().out
    assert out.exists()


def test_creases_of_the_file_are_kept(cage, tmp_path):
    out = tmp_path / "cage.obj"
    assert main(["interpolate", str(cage), "-o", str(out), "-o", str(tmp_path / "s.glb"), "--quiet"]) == 0
    found = subdfit.read(out)
    assert len(found.crease_edges) == 2
    assert len(found.corner_vertices) == 1
    assert (tmp_path / "s.glb").stat().st_size > 100


def test_fair(cage, tmp_path, capsys):
    out, document = tmp_path / "fair.obj", tmp_path / "f.json"
    call = ["interpolate", str(cage), "-o", str(out), "--fair", "--json", str(document), "--quiet"]
    assert main([*call, "--picture", str(tmp_path / "fair.png")]) == 0
    assert (tmp_path / "fair.png").stat().st_size > 1000
    assert "with 4 crease edges" in capsys.readouterr().out
    limits = subdfit.LimitSurface(out).vertex_limits()
    assert np.abs(limits[:6] - subdfit.read(cage).points).max() < 1e-12
    assert json.loads(document.read_text())["energy"]["fair"] >= 0


def test_bad_calls_write_nothing(sphere, tmp_path, capsys):
    out = str(tmp_path / "cage.obj")
    for more in (["--tolerance", "2"], ["--creases", "sharp"], ["--scheme", "loop", "--method", "magic"]):
        assert main(["interpolate", str(sphere), "-o", out, *more]) == 2
        assert len(capsys.readouterr().err.splitlines()) == 1
    assert not list(tmp_path.iterdir())
