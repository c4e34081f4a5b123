"""How much memory a job will need, told before it begins.

A fit peaks twice: while a file is parsed, and while the footpoints of all data are searched on a control mesh that is
nearly dense enough. The rates are rounded up from fits to .05 % of the diagonal, peak resident memory on Linux:

======= ======= ======== ======== ========
scan    points  vertices peak MiB estimate
======= ======= ======== ======== ========
bunny    35,947    4,760      323      363
igea    134,345    7,029      419      686
dragon  437,645   24,845    1,064    1,665
======= ======= ======== ======== ========

Refining peaks with the last step, at 45 to 70 bytes a face corner in any scheme; when the mesh is written, at 105 in a
binary file and 195 in a text.
"""

import os
from pathlib import Path

from subdfit.api.lengths import show_bytes
from subdfit.errors import InputError
from subdfit.wording import counted

_PROGRAM = 250 * 1024**2
"""Bytes of the interpreter, its libraries and the compiled kernels."""

_PER_FILE_BYTE = 12
"""Bytes for each byte of a text file while it is parsed; binary files take half."""

_PER_POINT, _PER_CORNER = 1000, 400
"""Bytes for each point and each face corner of a target while it is fitted to .05 %."""


_PER_REFINED_CORNER = 200
"""Bytes for each face corner of a refined mesh that is written."""


def estimate(points: int, corners: int) -> int:
    """Bytes that fitting takes at its peak, for a target of so many points and face corners."""
    return _PROGRAM + _PER_POINT * points + _PER_CORNER * corners


def check_file(path: str | os.PathLike[str], limit: int | None) -> None:
    """Raise InputError, with the estimate, where reading a file would alone need more than `limit` bytes."""
    if limit is not None and Path(path).is_file():
        need = _PROGRAM + _PER_FILE_BYTE * Path(path).stat().st_size
        _refuse(need, limit, f"{Path(path).name}: reading it")


def check_job(points: int, corners: int, limit: int | None, name: str) -> None:
    """Raise InputError, with the estimate, where a job would need more than `limit` bytes."""
    if limit is not None:
        _refuse(estimate(points, corners), limit, f"{name}: a job with {counted(points, 'point')}")


def check_refinement(corners: int, levels: int) -> None:
    """Raise InputError, with the estimate, where refining so many face corners needs more than the machine has."""
    need, there = _PROGRAM + _PER_REFINED_CORNER * corners * 4**levels, machine_memory()
    if there is not None and need > there:
        raise InputError(
            f"{levels} levels would need about {show_bytes(need)} of memory, and this machine has {show_bytes(there)}; "
            "ask for fewer"
        )


def machine_memory() -> int | None:
    """Bytes of the machine's memory, where the system tells."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return None


def _refuse(need: int, limit: int, what: str) -> None:
    if need > limit:
        raise InputError(
            f"{what} needs about {show_bytes(need)} of memory and {show_bytes(limit)} are allowed; allow more, or give "
            "a coarser mesh"
        )
