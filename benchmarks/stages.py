"""Where the time goes, as in Table 2 of Nishiyama et al. (2008): shares of each stage, both methods."""

import importlib
import time
from collections.abc import Callable
from typing import Any

import subdfit
from benchmarks.common import MODELS, table
from benchmarks.paper import ROWS, Row

STAGES = {
    "start (QEM)": [("subdfit.fit.starts", "start_mesh")],
    "footpoints": [
        ("subdfit.closest.projection.Projector", "refine"),
        ("subdfit.closest.projection.Projector", "start"),
    ],
    "remesh": [("subdfit.fit.tangential", "refined"), ("subdfit.fit.geometric", "refined")],
    "rows and solve": [("subdfit.fit.descent", "tangent_system"), ("subdfit.fit.geometric.Geometric", "displacements")],
    "reverse side": [("subdfit.fit.strays.Strays", "samples"), ("subdfit.fit.reverse.Samples", "of")],
    "certificate": [("subdfit.fit.driver", "measure")],
}


class Clock:
    """Seconds of each stage; a stage within another counts for itself alone."""

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(STAGES, 0.0)
        self._inner = [0.0]

    def timed(self, stage: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function, its time counted for a stage."""

        def call(*args: Any, **others: Any) -> Any:
            begun = time.perf_counter()
            self._inner.append(0.0)
            try:
                return function(*args, **others)
            finally:
                spent = time.perf_counter() - begun
                self.seconds[stage] += spent - self._inner.pop()
                self._inner[-1] += spent

        return call


def owner_of(path: str) -> Any:
    """The module or class of that dotted name."""
    try:
        return importlib.import_module(path)
    except ModuleNotFoundError:
        module, name = path.rsplit(".", 1)
        return getattr(importlib.import_module(module), name)


def shares(row: Row, method: str) -> list[str]:
    """Fit a row and return the shares of its stages, and what is left."""
    clock, kept = Clock(), []
    for stage, functions in STAGES.items():
        for path, name in functions:
            owner = owner_of(path)
            kept.append((owner, name, getattr(owner, name)))
            setattr(owner, name, clock.timed(stage, getattr(owner, name)))
    begun = time.perf_counter()
    try:
        result = subdfit.fit(MODELS / f"{row.model}.ply", method=method, creases="none", **row.asked())
    finally:
        for owner, name, function in kept:
            setattr(owner, name, function)
    total = time.perf_counter() - begun
    rest = total - sum(clock.seconds.values())
    spent = [*clock.seconds.values(), rest]
    return [row.model, method, str(len(result.history) - 1), *(f"{100 * s / total:.0f} %" for s in spent)]


def run() -> str:
    """Fit the paper's rows at .05 % and mean .01 %, and return the table."""
    rows = [shares(row, method) for row in ROWS if row.mean_error for method in ("geometric", "auto")]
    return table(["model", "method", "iterations", *STAGES, "reading and the rest"], rows)
