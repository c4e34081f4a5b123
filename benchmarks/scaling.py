"""How time grows: with the points, igea at five sizes; with the control vertices, igea at five tolerances."""

import time

import numpy as np

import subdfit
from benchmarks.common import MODELS, percent, table
from subdfit.initial import decimate
from subdfit.io import read
from subdfit.mesh.repair import mend

SIZES = (8_400, 16_800, 33_600, 67_200)
TOLERANCES = ("0.4%", "0.2%", "0.1%", "0.05%", "0.025%")


def fitted(target: object, name: str, bound: str) -> list[str]:
    """Fit and return a row."""
    begun = time.process_time()
    result = subdfit.fit(target, max_error=bound, creases="none")  # type: ignore[arg-type]
    m, cpu = result.measurement, time.process_time() - begun
    return [
        name,
        bound,
        f"{result.control_mesh.topology.vertex_count:,}",
        str(len(result.history) - 1),
        percent(m.max),
        percent(m.reverse_max),
        "yes" if result.certified else "no",
        f"{result.seconds['total']:.1f}",
        f"{cpu:.1f}",
    ]


def run() -> str:
    """Fit all sizes and tolerances and return the table."""
    data = mend(read(MODELS / "igea.ply")).data
    points, triangles = data.points, data.face_vertices.reshape(-1, 3)
    rows = []
    for size in SIZES:
        found = decimate(points, triangles, size)
        rows.append(fitted((found.points, found.triangles), f"{len(found.points):,}", "0.1%"))
    count = len(np.unique(triangles))
    rows += [fitted((points, triangles), f"{count:,}", bound) for bound in TOLERANCES]
    head = ["points of igea", "asked", "vertices", "iterations", "E_max %", "reverse %", "certified", "s", "CPU s"]
    return table(head, rows)
