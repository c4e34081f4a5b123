"""``subdfit fit``: its files, its document, its exit codes."""

import json

import numpy as np
import pytest

import subdfit
from subdfit.cli import main

KEYS = {
    "scheme", "method", "status", "certified", "iterations", "control_vertices", "control_faces", "crease_edges",
    "diagonal", "unit", "errors", "seconds", "settings", "version", "history",
}  # fmt: skip
ERRORS = {
    "max", "rms", "mean", "reverse_max", "reverse_rms", "reverse_mean", "boundary", "crease", "excluded",
    "target_faceting",
}  # fmt: skip
ROW = {"iteration", "control_vertices", "max", "rms", "mean", "seconds"}


@pytest.fixture(scope="module")
def fitted(sphere, tmp_path_factory):
    """Fit once, with every kind of output."""
    folder = tmp_path_factory.mktemp("fitted")
    names = ("cage.obj", "cage.ply", "cage.json", "surface.stl", "surface.glb")
    outputs = [word for name in names for word in ("-o", str(folder / name))]
    extra = ["--json", str(folder / "run.json"), "--picture", str(folder / "run.png"), "--unit", "mm"]
    extra += ["--plot", str(folder / "plot.png"), "--run", str(folder / "saved")]
    assert main(["fit", str(sphere), *outputs, "--max-error", "0.3%", "--quiet", *extra]) == 0
    return folder


def test_the_document_holds_what_is_promised(fitted):
    document = json.loads((fitted / "run.json").read_text())
    assert set(document) == KEYS
    assert set(document["errors"]) == ERRORS
    assert all(set(row) == ROW for row in document["history"])
    assert document["status"] == "within_tolerance"
    assert document["certified"] is True
    assert document["unit"] == "mm"
    assert document["version"] == subdfit.__version__
    assert 0 < document["errors"]["max"] <= 0.003
    assert document["settings"]["max_error"] == pytest.approx(0.003)
    assert {"total", "compile", "read", "write"} <= set(document["seconds"])
    stages = sum(document["seconds"][name] for name in ("read", "prepare", "fit", "write"))
    assert document["seconds"]["total"] >= stages - document["seconds"]["compile"] - 1e-6


def test_control_meshes_come_back_exactly(fitted):
    meshes = [subdfit.read(fitted / name) for name in ("cage.obj", "cage.ply", "cage.json")]
    for mesh in meshes:
        assert mesh.scheme == "loop"
        np.testing.assert_array_equal(mesh.points, meshes[0].points)
    document = json.loads((fitted / "run.json").read_text())
    assert len(meshes[0].points) == document["control_vertices"]
    assert meshes[0].face_count == document["control_faces"]


def test_drawn_formats_hold_the_limit_surface(fitted):
    surface = subdfit.LimitSurface(fitted / "cage.obj")
    for name in ("surface.stl", "surface.glb"):
        drawn = subdfit.read(fitted / name)
        assert drawn.face_count == 16 * surface.topology.face_count
        assert surface.closest(drawn.points).distance.max() < 1e-6


@pytest.mark.parametrize("name", ["run.png", "plot.png"])
def test_the_pictures_are_pictures(fitted, name):
    assert (fitted / name).read_bytes().startswith(b"\x89PNG")


def test_the_saved_run_holds_what_a_page_needs(fitted):
    saved = fitted / "saved"
    document = json.loads((saved / "run.json").read_text())
    assert document == json.loads((fitted / "run.json").read_text())
    assert (saved / "control_mesh.json").read_bytes() == (fitted / "cage.json").read_bytes()
    assert np.load(saved / "distances.npy").max() == pytest.approx(document["errors"]["max"] * document["diagonal"])


def test_the_same_run_writes_the_same_bytes(fitted, sphere, tmp_path):
    again = tmp_path / "cage.obj"
    assert main(["fit", str(sphere), "-o", str(again), "--max-error", "0.3%", "--threads", "1", "--quiet"]) == 0
    assert again.read_bytes() == (fitted / "cage.obj").read_bytes()


def test_an_independent_measurement_agrees(fitted, sphere, tmp_path, capsys):
    path = tmp_path / "measured.json"
    assert main(["measure", str(fitted / "cage.obj"), str(sphere), "--json", str(path)]) == 0
    measured, run = json.loads(path.read_text()), json.loads((fitted / "run.json").read_text())
    assert set(measured) == KEYS - {"history"}
    assert set(measured["errors"]) == ERRORS
    for name in ("max", "rms", "mean", "reverse_max", "target_faceting"):
        assert measured["errors"][name] == pytest.approx(run["errors"][name], rel=1e-5)
    table = capsys.readouterr().out
    assert "data to surface" in table
    assert f"{100 * run['errors']['max']:.4g} %" in table


def test_tessellate_forces_triangles_into_any_format(sphere, tmp_path, capsys):
    out = tmp_path / "surface.obj"
    call = ["fit", str(sphere), "-o", str(out), "--tessellate", "1", "--max-error", "1%", "--json", str(tmp_path / "j")]
    assert main(call) == 0
    document = json.loads((tmp_path / "j").read_text())
    drawn = subdfit.read(out)
    assert drawn.face_count == 4 * document["control_faces"]
    assert drawn.scheme is None


def test_the_summary_says_what_holds(sphere, tmp_path, capsys):
    assert main(["fit", str(sphere), "-o", str(tmp_path / "a.obj"), "--max-error", "0.5%", "--unit", "mm"]) == 0
    said = capsys.readouterr()
    assert said.out.count("\n") == 1
    for word in ("control vertices", "certified", "E_max", "E_rms", "mm)", "reverse", " s"):
        assert word in said.out


def test_best_effort_is_written_and_says_so(sphere, tmp_path, capsys):
    out, document = tmp_path / "a.obj", tmp_path / "a.json"
    budget = ["--control-vertices", "20", "--max-control-vertices", "30"]
    call = ["fit", str(sphere), "-o", str(out), "--max-error", "0.001%", *budget, "--json", str(document)]
    assert main(call) == 1
    assert len(subdfit.read(out).points) <= 30
    told = json.loads(document.read_text())
    assert (told["status"], told["certified"]) == ("best_effort", False)
    said = capsys.readouterr().out
    assert "tolerance not reached" in said
    assert "certified" not in said


def test_quiet_keeps_warnings_only(sphere, tmp_path, capsys):
    lonely = tmp_path / "lonely.ply"
    data = subdfit.read(sphere)
    points = np.vstack([data.points, [[9, 9, 9]]])
    subdfit.write(lonely, subdfit.MeshData(points, data.face_offsets, data.face_vertices))
    assert main(["fit", str(lonely), "-o", str(tmp_path / "a.obj"), "--max-error", "1%", "--quiet"]) == 0
    assert capsys.readouterr().err == "subdfit: warning: lonely.ply: 1 isolated vertex left out\n"


@pytest.mark.parametrize(
    ("extra", "says"),
    [
        (["-o", "x.doc"], "cannot write files of type .doc"),
        (["-o", "x.obj", "-o", "./x.obj"], "is named twice"),
        (["-o", "x.obj", "--json", "x.obj"], "is named twice"),
        (["-o", "x.obj", "--picture", "x.jpg"], "pictures are PNG"),
        (["-o", "x.obj", "--plot", "x.pdf"], "pictures are PNG"),
        (["-o", "x.obj", "--picture", "x.png", "--plot", "x.png"], "is named twice"),
        (["-o", "x.obj", "--tessellate", "-1"], "--tessellate is -1"),
        (["-o", "x.obj", "--max-error", "tight"], "max_error is 'tight'"),
        (["-o", "x.obj", "--creases", "sharp"], "creases is 'sharp'"),
        (["-o", "x.obj", "--memory", "1M"], "of memory and 1M are allowed"),
        (["-o", "x.obj", "--threads", "0"], "threads is 0"),
    ],
)
def test_bad_options_write_nothing(sphere, tmp_path, monkeypatch, capsys, extra, says):
    monkeypatch.chdir(tmp_path)
    assert main(["fit", str(sphere), *extra]) == 2
    said = capsys.readouterr().err
    assert said.startswith("subdfit: error: ")
    assert says in said
    assert said.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_the_target_is_not_overwritten(sphere, capsys):
    before = sphere.read_bytes()
    assert main(["fit", str(sphere), "-o", str(sphere)]) == 2
    assert "is the input" in capsys.readouterr().err
    assert sphere.read_bytes() == before


@pytest.mark.parametrize("option", ["-o", "--json", "--picture", "--plot"])
def test_places_that_cannot_be_written_fail_before_the_work(option, sphere, tmp_path, capsys):
    names = {"-o": "a.obj", "--json": "a.json", "--picture": "a.png", "--plot": "b.png"}
    outputs = {name: tmp_path / file for name, file in names.items()}
    outputs[option] = tmp_path / "missing" / outputs[option].name
    call = [word for name, path in outputs.items() for word in (name, str(path))]
    assert main(["fit", str(sphere), *call, "--max-error", "1%"]) == 3
    said = capsys.readouterr().err
    assert "there is no folder" in said
    assert "reading" not in said
    assert not list(tmp_path.iterdir())


def test_a_cloud_of_points_is_fitted_and_its_outliers_are_listed(sphere, tmp_path):
    cloud, document = tmp_path / "cloud.xyz", tmp_path / "a.json"
    points = subdfit.read(sphere).points
    points[[7, 400]] *= 1.5
    np.savetxt(cloud, points)
    call = ["fit", str(cloud), "-o", str(tmp_path / "a.obj"), "--max-error", "0.5%", "--json", str(document), "--quiet"]
    assert main(call) == 0
    said = json.loads(document.read_text())
    assert said["certified"]
    assert said["errors"]["excluded"] == 2
    assert said["excluded_rows"] == [7, 400]
    assert main([*call, "--robust", "100%"]) == 2


def test_the_options_of_the_geometric_method_reach_it(sphere, tmp_path):
    out, run = str(tmp_path / "cage.obj"), tmp_path / "run.json"
    options = ["--method", "geometric", "--over-relaxation", "1.5", "--nesterov", "--no-boundary-step"]
    assert main(["fit", str(sphere), "-o", out, "--max-error", "1%", *options, "--json", str(run), "--quiet"]) == 0
    asked = json.loads(run.read_text())["settings"]
    assert (asked["over_relaxation"], asked["nesterov"], asked["boundary_step"]) == (1.5, True, False)


def test_a_factor_with_which_nothing_converges_is_refused(sphere, tmp_path, capsys):
    out = tmp_path / "cage.obj"
    assert main(["fit", str(sphere), "-o", str(out), "--over-relaxation", "2", "--quiet"]) == 2
    assert "over_relaxation is 2.0" in capsys.readouterr().err
    assert not out.exists()
