"""The program: help, bad calls, failures, and the exit codes."""

import logging
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import subdfit
from subdfit.cli import main, options
from subdfit.errors import MachineError
from subdfit.mesh.repair import mend

COMMANDS = ("fit", "interpolate", "measure", "subdivide", "demo")


def test_the_names_are_those_of_the_registries():
    from subdfit.fit import METHODS
    from subdfit.interpolate import METHODS as INTERPOLATION_METHODS
    from subdfit.schemes import SCHEMES

    assert set(options.SCHEMES) == set(SCHEMES)
    assert set(options.METHODS) == set(METHODS)
    assert set(options.INTERPOLATION_METHODS) == set(INTERPOLATION_METHODS)


@pytest.mark.parametrize("call", [["--help"], *([command, "--help"] for command in COMMANDS)])
def test_help(call, capsys):
    assert main(call) == 0
    said = capsys.readouterr()
    assert said.out.startswith("usage: subdfit")
    assert "%%" not in said.out
    assert said.err == ""


def test_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"subdfit {subdfit.__version__}\n"


def test_help_loads_nothing_heavy():
    code = (
        "import sys\nfrom subdfit.cli import main\nmain(['fit', '--help'])\n"
        "assert not {'numpy', 'numba', 'scipy', 'rich', 'matplotlib'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)


@pytest.mark.parametrize(
    "call",
    [
        [],
        ["frobnicate"],
        ["fit"],
        ["fit", "a.ply"],
        ["fit", "a.ply", "-o", "b.obj", "--scheme", "butterfly"],
        ["fit", "a.ply", "-o", "b.obj", "--control-vertices", "many"],
        ["fit", "a.ply", "-o", "b.obj", "--max-err", "1%"],
        ["measure", "a.obj"],
        ["subdivide", "a.obj"],
    ],
)
def test_bad_calls_get_one_line(call, capsys):
    assert main(call) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("subdfit: error: ")
    assert said.err.count("\n") == 1


@pytest.mark.parametrize(
    ("fault", "says"),
    [
        (RuntimeError("two\nlines"), "a fault of subdfit itself (RuntimeError: two lines)"),
        (MemoryError(), "out of memory"),
        (OSError(28, "No space left on device"), "the machine failed"),
        (MachineError("cannot write x.obj: the disk is full"), "cannot write x.obj"),
    ],
)
def test_failures_keep_their_details(fault, says, sphere, tmp_path, monkeypatch, capsys):
    def fail(*_, **__):
        raise fault

    monkeypatch.setattr("subdfit.api.fit", fail)
    assert main(["fit", str(sphere), "-o", str(tmp_path / "out.obj")]) == 3
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert said.startswith(f"subdfit: error: {says}")
    kept = Path(said.strip().split("; details in ")[1])
    assert "Traceback" in kept.read_text()
    kept.unlink()
    assert not list(tmp_path.iterdir())


def test_details_that_cannot_be_kept(sphere, tmp_path, monkeypatch, capsys):
    def fail(*_, **__):
        raise RuntimeError("x")

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("subdfit.api.fit", fail)
    monkeypatch.setattr("tempfile.mkstemp", full)
    assert main(["fit", str(sphere), "-o", str(tmp_path / "out.obj")]) == 3
    assert capsys.readouterr().err.endswith("its details could not be kept\n")


def test_the_module_runs_as_a_program(sphere, tmp_path):
    call = [sys.executable, "-m", "subdfit", "fit", "missing.ply", "-o", str(tmp_path / "x.obj")]
    done = subprocess.run(call, capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr == "subdfit: error: missing.ply: no such file; check the path\n"


@pytest.mark.parametrize("quiet", [[], ["--quiet"]])
def test_a_refusal_is_one_line_whatever_was_said_before(tmp_path, monkeypatch, capsys, quiet):
    """Though reading and compiling took so long that they are worth a line, and something was mended."""
    monkeypatch.setattr("subdfit.cli.console.PAUSE", 0.0)
    points, path = np.random.default_rng(0).random((3000, 3)), tmp_path / "fan.ply"
    subdfit.write(path, subdfit.MeshData(points, 3 * np.arange(4), np.ravel([[0, 1, 2], [0, 1, 3], [0, 1, 4]])))
    said = []

    def compiling(data, **how):
        logging.getLogger("subdfit.compiled").info("compiling kernels")
        logging.getLogger("subdfit.mesh.repair").warning("fan.ply: 2,995 isolated vertices left out")
        said.append(how["name"])
        return mend(data, **how)

    monkeypatch.setattr("subdfit.api.targets.mend", compiling)
    assert main(["fit", str(path), "-o", str(tmp_path / "x.obj"), *quiet]) == 2
    assert said == ["fan.ply"]
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("subdfit: error: fan.ply: ")
