"""Threads over chunks of fixed size: the result does not depend on how many threads there are."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

S = TypeVar("S")
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
    return map_items(lambda bound: job(*bound), bounds)


def map_items(job: Callable[[S], T], items: Iterable[S]) -> list[T]:
    """Call `job` for each of some items; results come in their order.

    The calling thread takes part, and takes what no other has begun: so a job may map chunks or items itself, which
    threads without work of their own then share, and none waits for one that waits for it.
    """
    items = list(items)
    if _threads == 1 or len(items) <= 1:
        return [job(item) for item in items]
    pool = _shared_pool()
    others = [pool.submit(job, item) for item in items[1:]]
    try:
        results = [job(items[0])]
        for item, other in zip(items[1:], others, strict=True):
            results.append(job(item) if other.cancel() else other.result())
    finally:
        for other in others:
            other.cancel()
    return results


def _shared_pool() -> ThreadPoolExecutor:
    """Threads beside the calling one."""
    global _pool
    if _pool is None:
        _pool = ThreadPoolExecutor(_threads - 1, thread_name_prefix="subdfit")
    return _pool
