"""Tables 1 and 2 of Nishiyama, Morioka and Maekawa (2008) beside ours, both methods, on the models we have."""

import time
from dataclasses import dataclass
from typing import Any

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

    def asked(self) -> dict[str, Any]:
        """Arguments of `subdfit.fit`."""
        return {
            "max_error": self.max_error,
            "rms_error": self.rms_error,
            "mean_error": self.mean_error,
            "control_vertices": self.start,
        }


ROWS = [
    Row("bunny", 612, "0.049%", "0.0108%", None, "7,098 vertices, 22 s", True),
    Row("bunny", 612, "0.05%", None, "0.01%", "21 iterations", True),
    Row("igea", 336, "0.238%", "0.0701%", None, "1,572 vertices, 68 s", True),
    Row("igea", 1343, "0.05%", None, "0.01%", "12,445 vertices, 32 iterations", True),
    Row("armadillo_50k", 433, "0.248%", "0.0618%", None, "3,267 vertices, 109 s", False),
]


VARIANTS: list[tuple[str, dict[str, Any]]] = [
    ("geometric", {"method": "geometric"}),
    ("auto", {"method": "auto"}),
]
ACCELERATED: list[tuple[str, dict[str, Any]]] = [
    ("geometric, over-relaxed 1.7", {"method": "geometric", "over_relaxation": 1.7}),
    ("geometric, Nesterov", {"method": "geometric", "nesterov": True}),
]


def fitted(row: Row, name: str, options: dict[str, Any]) -> list[str]:
    """Fit a row and return the table's line."""
    begun = time.process_time()
    result = subdfit.fit(MODELS / f"{row.model}.ply", creases="none", **row.asked(), **options)
    m, cpu = result.measurement, time.process_time() - begun
    errors = (("max", row.max_error), ("rms", row.rms_error), ("mean", row.mean_error))
    return [
        row.model + ("" if row.same_file else " (not the paper's file)"),
        str(row.start),
        ", ".join(f"{what} {value}" for what, value in errors if value),
        name,
        str(len(result.history) - 1),
        f"{result.control_mesh.topology.vertex_count:,}",
        percent(m.max),
        percent(m.rms),
        percent(m.mean),
        percent(m.reverse_max),
        "yes" if result.certified else "no",
        f"{result.seconds['total']:.1f}",
        f"{cpu:.1f}",
        row.printed,
    ]


def run() -> str:
    """Fit every row with both methods, the first with accelerations too, and return the table."""
    rows = [fitted(row, *variant) for row in ROWS for variant in VARIANTS]
    rows += [fitted(ROWS[0], *variant) for variant in ACCELERATED]
    head = ["model", "from", "asked", "method", "iterations", "vertices", "E_max %", "E_rms %", "E_mean %", "reverse %"]
    return table([*head, "certified", "s", "CPU s", "the paper prints"], rows)
