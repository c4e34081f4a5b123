"""A first run: what the second process compiles is what a fit needs, and it is started only where it may."""

import os
import subprocess
import sys

import pytest

import subdfit
from subdfit.api import rehearsal
from subdfit.cli import ahead
from subdfit.compiled import CompileClock
from subdfit.schemes import SCHEMES

FIT_AND_COUNT = """
import numba.core.event as event, subdfit
compiled = []
class Compiled(event.Listener):
    def on_start(self, started): compiled.append(started.data["dispatcher"].py_func.__qualname__)
    def on_end(self, ended): pass
event.register("numba:compile", Compiled())
result = subdfit.fit({path!r}, max_error="0.2%")
assert result.certified
print(" ".join(compiled))
"""


class _Process:
    """What is started instead of a process."""

    def __init__(self, arguments, **_):
        self.arguments, self.calls = arguments, []

    def kill(self):
        self.calls.append("kill")

    def wait(self):
        self.calls.append("wait")


@pytest.fixture
def started(monkeypatch):
    """Processes that were asked for, with a clock that has seen nothing compiled and two cores."""
    processes = []

    def start(arguments, **rest):
        processes.append(_Process(arguments, **rest))
        return processes[-1]

    monkeypatch.setattr(subprocess, "Popen", start)
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    monkeypatch.setattr("subdfit.compiled.compile_clock", CompileClock())
    return processes


def _compile_twice():
    from subdfit.compiled import compile_clock

    for _ in range(2):
        compile_clock.on_start(None)
        compile_clock.on_end(None)


def test_after_a_rehearsal_a_fit_compiles_nothing(sphere, tmp_path):
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    code = "from subdfit.api.rehearsal import rehearse; rehearse('loop')"
    subprocess.run([sys.executable, "-c", code], env=environment, check=True)
    code = FIT_AND_COUNT.format(path=str(sphere))
    fitted = subprocess.run([sys.executable, "-c", code], env=environment, check=True, capture_output=True, text=True)
    assert fitted.stdout.split() == []


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_rehearsal_ends_with_a_fit_by_the_scheme(scheme, monkeypatch):
    results = []
    monkeypatch.setattr(rehearsal, "fit", lambda *args, **how: results.append(subdfit.fit(*args, **how)))
    rehearsal.rehearse(scheme)
    (result,) = results
    assert result.control_mesh.scheme == scheme
    assert len(result.history) > 1
    assert result.measurement.reverse_max > 0


def test_one_process_helps_from_the_first_kernel_on_and_ends_with_the_fit(started):
    with ahead.compiling_ahead("doo-sabin", None, None):
        assert started == []
        _compile_twice()
        (process,) = started
        assert "doo-sabin" in process.arguments[-1]
        assert process.calls == []
    assert process.calls == ["kill", "wait"]
    _compile_twice()
    assert len(started) == 1


@pytest.mark.parametrize(("threads", "memory", "cores"), [(1, None, 2), (None, "1G", 2), (None, None, 1)])
def test_none_helps_where_one_thread_or_little_memory_is_asked_or_one_core_is_there(
    started, monkeypatch, threads, memory, cores
):
    monkeypatch.setattr(os, "cpu_count", lambda: cores)
    with ahead.compiling_ahead("loop", threads, memory):
        _compile_twice()
    assert started == []


def test_a_process_that_cannot_be_started_is_done_without(started, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError("no more processes")

    monkeypatch.setattr(subprocess, "Popen", refuse)
    with ahead.compiling_ahead("loop", None, None):
        _compile_twice()
    assert started == []
