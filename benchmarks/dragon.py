"""The dragon at .05 %, as it is and with its largest component's holes closed: time and peak memory, warm."""

import sys

import subdfit
from benchmarks.common import MODELS, percent, table


def peak() -> str:
    """Return the process's peak memory so far in MiB, or a dash where the platform does not tell."""
    try:
        import resource
    except ImportError:
        return "-"
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return f"{used / (2**20 if sys.platform == 'darwin' else 2**10):,.0f}"


def run() -> str:
    """Fit both rows and return the table."""
    rows = []
    for name, options in (("as it is", {}), ("one component, holes closed", {"keep_components": 1, "fill_holes": 50})):
        result = subdfit.fit(MODELS / "dragon.ply", max_error="0.05%", creases="none", **options)
        m = result.measurement
        rows.append(
            [
                name,
                f"{result.control_mesh.topology.vertex_count:,}",
                percent(m.max),
                percent(m.rms),
                percent(m.reverse_max),
                "yes" if result.certified else "no",
                f"{result.seconds['total']:.0f}",
                peak(),
            ]
        )
    return table(["dragon", "vertices", "E_max %", "E_rms %", "reverse %", "certified", "s", "peak MiB"], rows)
