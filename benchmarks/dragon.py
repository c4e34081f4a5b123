"""The dragon at .05 %: as it is, with its largest component's holes closed, and by both methods from 4,091."""

import time
from typing import Any

import subdfit
from benchmarks.common import MODELS, peak, percent, table

ROWS: list[tuple[str, dict[str, Any]]] = [
    ("as it is", {}),
    ("one component, holes closed", {"keep_components": 1, "fill_holes": 50}),
    ("from 4,091", {"control_vertices": 4091}),
    ("from 4,091, geometric", {"control_vertices": 4091, "method": "geometric"}),
]


def run() -> str:
    """Fit all rows and return the table."""
    rows = []
    for name, options in ROWS:
        begun = time.process_time()
        result = subdfit.fit(MODELS / "dragon.ply", max_error="0.05%", creases="none", **options)
        m, cpu = result.measurement, time.process_time() - begun
        rows.append(
            [
                name,
                str(len(result.history) - 1),
                f"{result.control_mesh.topology.vertex_count:,}",
                percent(m.max),
                percent(m.rms),
                percent(m.reverse_max),
                "yes" if result.certified else "no",
                f"{result.seconds['total']:.0f}",
                f"{cpu:.0f}",
                peak(),
            ]
        )
    head = ["dragon", "iterations", "vertices", "E_max %", "E_rms %", "reverse %"]
    return table([*head, "certified", "s", "CPU s", "peak MiB"], rows)
