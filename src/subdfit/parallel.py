"""Threads over chunks of fixed size: the result does not depend on how many threads there are."""

import os
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

S = TypeVar("S")
T = TypeVar("T")

_threads = os.cpu_count() or 1
_pool: ThreadPoolExecutor | None = None
_local = threading.local()


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
    return map_items(lambda bound: job(*bound), bounds)


def map_items(job: Callable[[S], T], items: Iterable[S]) -> list[T]:
    """Call `job` for each of some items; results come in their order.

    A job may map chunks or items itself: these then stay on its thread.
    """
    items = list(items)
    if _threads == 1 or len(items) <= 1 or getattr(_local, "works", False):
        return [job(item) for item in items]
    return list(_shared_pool().map(job, items))


def _shared_pool() -> ThreadPoolExecutor:
    global _pool
    if _pool is None:
        _pool = ThreadPoolExecutor(_threads, thread_name_prefix="subdfit", initializer=_mark_worker)
    return _pool


def _mark_worker() -> None:
    _local.works = True
