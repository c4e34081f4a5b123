"""Ctrl-C: 130, and the best so far is written."""

import json
import os
import re
import signal
import subprocess
import sys
import threading
from importlib import import_module

import numpy as np
import pytest
import trimesh

import subdfit
from subdfit.cli import main
from subdfit.cli.console import Console
from subdfit.compiled import compile_clock


@pytest.mark.skipif(os.name == "nt", reason="sends a POSIX signal")
def test_the_program_writes_the_best_so_far(tmp_path_factory, tmp_path):
    # Dense enough not to be done before the signal arrives, however busy the machine is.
    mesh = trimesh.creation.icosphere(6)
    dense = tmp_path_factory.mktemp("targets") / "dense.ply"
    subdfit.write(dense, subdfit.api.mesh_data((np.array(mesh.vertices), np.array(mesh.faces))))
    out, document = tmp_path / "best.obj", tmp_path / "best.json"
    call = [
        "fit",
        str(dense),
        "-o",
        str(out),
        "--json",
        str(document),
        "--max-error",
        "1e-9%",
        "--method",
        "geometric",
    ]
    # Tests started in the background may have been told to ignore the signal, and so would what they start.
    code = (
        "import signal, sys, subdfit.cli.console as c; c.PAUSE = 0.0; from subdfit.cli import main; "
        "signal.signal(signal.SIGINT, signal.default_int_handler); sys.exit(main())"
    )
    with subprocess.Popen([sys.executable, "-c", code, *call], stderr=subprocess.PIPE, text=True) as process:
        for line in process.stderr:
            if line.startswith("subdfit: fit "):
                process.send_signal(signal.SIGINT)
                break
        rest = threading.Thread(target=process.stderr.read)
        rest.start()
        assert process.wait(60) == 130
        rest.join()
    assert json.loads(document.read_text())["status"] == "interrupted"
    assert subdfit.read(out).scheme == "loop"
    assert {path.name for path in tmp_path.iterdir()} == {"best.obj", "best.json"}


def interrupt(*_, **__):
    raise KeyboardInterrupt


def test_before_there_is_anything(sphere, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("subdfit.api.fitting.prepare", interrupt)
    assert main(["fit", str(sphere), "-o", str(tmp_path / "a.obj")]) == 130
    assert "interrupted before" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_again_while_the_best_is_measured(sphere, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(import_module("subdfit.fit.driver"), "measure", interrupt)
    others = ["--json", str(tmp_path / "a.json"), "--picture", str(tmp_path / "a.png")]
    assert main(["fit", str(sphere), "-o", str(tmp_path / "a.obj"), "--max-error", "1%", *others]) == 130
    assert "before they were measured; --json not written; --picture not written\n" in capsys.readouterr().out
    assert subdfit.read(tmp_path / "a.obj").scheme == "loop"
    assert [path.name for path in tmp_path.iterdir()] == ["a.obj"]


def test_the_best_is_the_lightest_once_a_fit_thins(sphere):
    told = []
    with Console(quiet=True) as console:

        def progress(step):
            console.progress(step)
            told.append(step)

        subdfit.fit(sphere, max_error="1%", thin=True, progress=progress)
    assert told[-1].stage == "thin"
    assert console.best is told[-1].control_mesh
    assert min(step.max for step in told) < told[-1].max


def test_seconds_of_progress_leave_out_compiling(monkeypatch):
    console = Console(quiet=True)
    console.stage("reading")
    console._begun -= 1000.0
    monkeypatch.setattr(compile_clock, "seconds", compile_clock.seconds + 1000.0)
    assert 0 <= float(re.fullmatch(r"reading, (.*) s", console._line())[1]) < 1000.0
