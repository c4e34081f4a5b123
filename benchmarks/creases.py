"""Control vertices of machined parts with and without crease tags."""

import subdfit
from benchmarks.common import MODELS, percent, table

PARTS = [("fandisk", "0.1%"), ("mechpart", "0.3%"), ("block", "0.3%")]


def run() -> str:
    """Fit each part three ways and return the table."""
    rows = []
    for name, bound in PARTS:
        for creases in ("none", 40.0, "auto"):
            result = subdfit.fit(MODELS / f"{name}.ply", max_error=bound, creases=creases)
            m = result.measurement
            rows.append(
                [
                    name,
                    bound,
                    str(creases),
                    f"{result.control_mesh.topology.vertex_count:,}",
                    str(len(result.control_mesh.topology.crease_edges)),
                    percent(m.max),
                    percent(m.reverse_max),
                    percent(m.crease.max) if m.crease else "-",
                    "yes" if result.certified else "no",
                    f"{result.seconds['total']:.1f}",
                ]
            )
    head = ["part", "asked", "creases", "vertices", "crease edges", "E_max %", "reverse %", "crease E_max %"]
    return table([*head, "certified", "s"], rows)
