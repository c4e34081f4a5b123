"""All schemes on the same models at the same tolerance: vertices, errors, seconds, quads."""

import time

import numpy as np

import subdfit
from benchmarks.common import MODELS, percent, table
from subdfit.schemes import SCHEMES

NAMES = ("igea", "bunny", "rocker-arm", "armadillo_50k", "holes", "blade")
GEOMETRIC = ("bunny", "rocker-arm", "holes")
BOUND = "0.15%"


def run() -> str:
    """Fit models with every scheme, by ``auto`` and then by ``geometric``, and return the tables."""
    for scheme in schemes():
        for method in ("auto", "geometric"):
            subdfit.fit(MODELS / "cylinder.ply", max_error="0.5%", scheme=scheme, method=method)  # compile first
    return f"{_fits(NAMES, 'auto')}\n\n`geometric`:\n\n{_fits(GEOMETRIC, 'geometric')}"


def schemes() -> list[str]:
    """Names of the schemes that are compared: Doo-Sabin by its original masks alone."""
    return [name for name in SCHEMES if name != "doo-sabin-averaging"]


def _fits(names: tuple[str, ...], method: str) -> str:
    rows = [_row(name, scheme, method) for name in names for scheme in schemes()]
    head = ["model", "scheme", "vertices", "quads", "E_max %", "E_rms %", "reverse %", "certified", "CPU s"]
    return table(head, rows)


def _row(name: str, scheme: str, method: str) -> list[str]:
    clock = time.process_time()
    result = subdfit.fit(MODELS / f"{name}.ply", max_error=BOUND, scheme=scheme, method=method)
    clock = time.process_time() - clock
    topology, m = result.control_mesh.topology, result.measurement
    return [
        name,
        scheme,
        f"{topology.vertex_count:,}",
        f"{100 * np.mean(np.diff(topology.face_offsets) == 4):.0f} %",
        percent(m.max),
        percent(m.rms),
        percent(m.reverse_max),
        "yes" if result.certified else "no",
        f"{clock:.1f}",
    ]
