"""All schemes on the same models at the same tolerance: vertices, errors, seconds, quads."""

import time

import numpy as np

import subdfit
from benchmarks.common import MODELS, percent, table
from subdfit.schemes import SCHEMES

NAMES = ("igea", "bunny", "rocker-arm", "armadillo_50k", "holes", "blade")
BOUND = "0.15%"


def run() -> str:
    """Fit every model with every scheme by ``auto`` and return the table."""
    rows = []
    schemes = [name for name in SCHEMES if name != "doo-sabin-averaging"]
    for scheme in schemes:
        subdfit.fit(MODELS / "cylinder.ply", max_error="0.5%", scheme=scheme)  # compile first
    for name in NAMES:
        for scheme in schemes:
            clock = time.process_time()
            result = subdfit.fit(MODELS / f"{name}.ply", max_error=BOUND, scheme=scheme)
            clock = time.process_time() - clock
            topology, m = result.control_mesh.topology, result.measurement
            rows.append(
                [
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
            )
    head = ["model", "scheme", "vertices", "quads", "E_max %", "E_rms %", "reverse %", "certified", "CPU s"]
    return table(head, rows)
