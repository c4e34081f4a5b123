"""Threads over chunks of fixed size: the result does not depend on how many threads there are."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")

_threads = os.cpu_count() or 1
_pool: ThreadPoolExecutor | None = None


def set_threads(count: int | None) -> None:
    """Use `count` threads from now on; ``None`` means one a core."""
    global _threads, _pool
    _threads = count or os.cpu_count() or 1
    _pool = None


def threads() -> int:
    """Return the number of threads in use."""
    return _threads


def map_chunks(job: Callable[[int, int], T], count: int, size: int = 4096) -> list[T]:
    """Call ``job(start, stop)`` for consecutive chunks of ``range(count)``; results come in chunk order.

    Parameters
    ----------
    job
        Called with the first row and the row after the last of a chunk; should release the interpreter
        lock (our kernels do). An exception in one chunk is raised here.
    count
        Number of rows in all; 0 gives an empty list.
    size
        Rows in a chunk: fixed, never derived from the number of threads.
    """
    bounds = [(start, min(start + size, count)) for start in range(0, count, size)]
    if _threads == 1 or len(bounds) <= 1:
        return [job(start, stop) for start, stop in bounds]
    return list(_shared_pool().map(lambda bound: job(*bound), bounds))


def _shared_pool() -> ThreadPoolExecutor:
    global _pool
    if _pool is None:
        _pool = ThreadPoolExecutor(_threads, thread_name_prefix="subdfit")
    return _pool
