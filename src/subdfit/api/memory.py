"""How much memory a job will need, told before it begins.

A fit peaks in its last rounds and in the certificate, whose samples and search trees grow with the control vertices.
The rates are rounded up from peaks of resident memory on Linux, two threads at most, kernels compiled already; where
they have yet to be compiled, that takes 150 MiB more, which the estimate holds room for:

============ ============= ======= ======== ======== ========
target       scheme         points vertices peak MiB estimate
============ ============= ======= ======== ======== ========
bunny        loop           35,947    4,348      386      595
igea         loop          134,345  107,693    1,769    2,223
dragon       loop          437,645    2,000      811    1,166
noisy sphere loop           41,000   41,000      844    1,128
sphere       catmull-clark  40,000   23,044      788    1,156
sphere       doo-sabin      40,000   15,000      529      941
sphere       quad-triangle  40,000   23,327      651    1,241
============ ============= ======= ======== ======== ========

Refining peaks with the last step, at 45 to 70 bytes a face corner in any scheme; when the mesh is written, at 105 in a
binary file and 195 in a text.
"""

import os
from pathlib import Path

from subdfit.api.lengths import show_bytes
from subdfit.errors import InputError
from subdfit.parallel import threads
from subdfit.wording import counted

_PROGRAM, _PER_THREAD = 440 * 1024**2, 20 * 1024**2
"""Bytes of the interpreter, its libraries and the kernels, while these are compiled; and of each thread's work."""

_TYPES = {"quad-triangle": 2**28}
"""Bytes of the types of patches that are kept for the next control mesh, by scheme, where they are many."""

_PER_FILE_BYTE = 12
"""Bytes for each byte of a text file while it is parsed; binary files take half."""

_PER_POINT, _PER_CORNER = 500, 180
"""Bytes for each point and each face corner of a target while it is fitted."""

_PER_VERTEX, _PER_OTHER_VERTEX = {"loop": 15000, "quad-triangle": 20000}, 28000
"""Bytes for each control vertex of the finest control mesh, by scheme, and those of other schemes."""

_PER_REFINED_CORNER = 200
"""Bytes for each face corner of a refined mesh that is written."""


def estimate(points: int, corners: int, vertices: int = 0, scheme: str = "loop", *, threads: int = 1) -> int:
    """Bytes that fitting takes at its peak.

    Parameters
    ----------
    points, corners
        The target's points and face corners; a cloud has none of these yet, and two triangles a point once joined.
    vertices
        The most control vertices.
    scheme
        The subdivision scheme's name.
    threads
        As many work at once.
    """
    target = _PER_POINT * points + _PER_CORNER * (corners or 6 * points)
    program = _PROGRAM + _PER_THREAD * threads + _TYPES.get(scheme, 0)
    return program + target + _per_vertex(scheme) * vertices


def vertices_within(limit: int, points: int, corners: int, scheme: str) -> int:
    """The most control vertices that fitting such a target may have in `limit` bytes."""
    return max(0, limit - estimate(points, corners, 0, scheme, threads=threads())) // _per_vertex(scheme)


def _per_vertex(scheme: str) -> int:
    return _PER_VERTEX.get(scheme, _PER_OTHER_VERTEX)


def check_file(path: str | os.PathLike[str], limit: int | None) -> None:
    """Raise InputError, with the estimate, where reading a file would alone need more than `limit` bytes."""
    if limit is not None and Path(path).is_file():
        need = _PROGRAM + _PER_FILE_BYTE * Path(path).stat().st_size
        _refuse(need, limit, f"{Path(path).name}: reading it")


def check_job(points: int, corners: int, limit: int | None, name: str, vertices: int = 0, scheme: str = "loop") -> None:
    """Raise InputError, with the estimate, where a job would need more than `limit` bytes; see `estimate`."""
    if limit is not None:
        surface = f" and {counted(vertices, 'control vertex')}" if vertices else ""
        need = estimate(points, corners, vertices, scheme, threads=threads())
        fewer = " or fewer control vertices" if vertices else ""
        _refuse(need, limit, f"{name}: a job with {counted(points, 'point')}{surface}", fewer)


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


def _refuse(need: int, limit: int, what: str, fewer: str = "") -> None:
    if need > limit:
        raise InputError(
            f"{what} needs about {show_bytes(need)} of memory and {show_bytes(limit)} are allowed; allow more, or give "
            f"a coarser mesh{fewer}"
        )
