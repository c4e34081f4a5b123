"""What all measurements share: where the models lie, the machine, tables in Markdown."""

import os
import platform
import sys
from pathlib import Path

import numba
import numpy as np

MODELS = Path(os.environ.get("SUBDFIT_MESHES", Path(__file__).parents[2] / "shared" / "meshes"))


def machine() -> str:
    """Return one line that names the machine and the versions that matter."""
    versions = f"Python {platform.python_version()}, numpy {np.__version__}, numba {numba.__version__}"
    return f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores; {versions}"


def table(head: list[str], rows: list[list[str]]) -> str:
    """Return a Markdown table."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def percent(value: float) -> str:
    """Return a share of the diagonal in per cent."""
    return f"{100 * value:.4f}"


def peak() -> str:
    """Return the process's peak memory so far in MiB, or a dash where the platform does not tell."""
    try:
        import resource
    except ImportError:
        return "-"
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return f"{used / (2**20 if sys.platform == 'darwin' else 2**10):,.0f}"
