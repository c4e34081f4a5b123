"""Tables 1 and 2 of Nishiyama, Morioka and Maekawa (2008) beside ours, both methods, on the models we have."""

from dataclasses import dataclass

import subdfit
from benchmarks.common import MODELS, percent, table


@dataclass(frozen=True)
class Row:
    """One fit: the model, what is asked, and what the paper prints for its own file of that name."""

    model: str
    start: int
    max_error: str
    rms_error: str | None
    mean_error: str | None
    printed: str
    same_file: bool


ROWS = [
    Row("bunny", 612, "0.049%", "0.0108%", None, "7,098 vertices, 22 s", True),
    Row("bunny", 612, "0.05%", None, "0.01%", "21 iterations", True),
    Row("igea", 336, "0.238%", "0.0701%", None, "1,572 vertices, 68 s", True),
    Row("igea", 1343, "0.05%", None, "0.01%", "12,445 vertices, 32 iterations", True),
    Row("armadillo_50k", 433, "0.248%", "0.0618%", None, "3,267 vertices, 109 s", False),
]


def run() -> str:
    """Fit every row with both methods and return the table."""
    rows = []
    for row in ROWS:
        path = MODELS / f"{row.model}.ply"
        for method in ("geometric", "auto"):
            result = subdfit.fit(
                path,
                method=method,
                creases="none",
                max_error=row.max_error,
                rms_error=row.rms_error,
                mean_error=row.mean_error,
                control_vertices=row.start,
            )
            m = result.measurement
            asked = ", ".join(
                f"{name} {value}"
                for name, value in (("max", row.max_error), ("rms", row.rms_error), ("mean", row.mean_error))
                if value
            )
            rows.append(
                [
                    row.model + ("" if row.same_file else " (decimated: not the paper's file)"),
                    str(row.start),
                    asked,
                    method,
                    str(len(result.history) - 1),
                    f"{result.control_mesh.topology.vertex_count:,}",
                    percent(m.max),
                    percent(m.rms),
                    percent(m.mean),
                    percent(m.reverse_max),
                    "yes" if result.certified else "no",
                    f"{result.seconds['total']:.1f}",
                    row.printed,
                ]
            )
    head = ["model", "from", "asked", "method", "iterations", "vertices", "E_max %", "E_rms %", "E_mean %", "reverse %"]
    return table([*head, "certified", "s", "the paper prints"], rows)
