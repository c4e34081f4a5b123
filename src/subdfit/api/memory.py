"""How much memory a job will need, told before it begins."""

from subdfit.api.lengths import show_bytes
from subdfit.errors import InputError

_PROGRAM = 300 * 1024**2
"""Bytes of the interpreter, its libraries and the compiled kernels."""

_PER_POINT = 1000
_PER_CORNER = 100
"""Bytes for each point and each face corner of the target at the peak."""


def estimate(points: int, corners: int) -> int:
    """Bytes that fitting takes at its peak, for a target of so many points and face corners."""
    return _PROGRAM + _PER_POINT * points + _PER_CORNER * corners


def check_memory(points: int, corners: int, limit: int | None, name: str) -> None:
    """Raise InputError, with the estimate, where a job would need more than `limit` bytes."""
    need = estimate(points, corners)
    if limit is not None and need > limit:
        raise InputError(
            f"{name}: {points:,} points need about {show_bytes(need)} of memory and {show_bytes(limit)} are allowed; "
            "allow more, or give a coarser mesh"
        )
