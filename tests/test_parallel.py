"""Threads: results come in order, and threads without work share that of others."""

import threading
from contextlib import contextmanager

import numpy as np
import pytest

from subdfit import parallel
from subdfit.parallel import map_chunks, map_items


@contextmanager
def using(count):
    before = parallel.threads()
    parallel.set_threads(count)
    try:
        yield count
    finally:
        parallel.set_threads(before)


@pytest.fixture(params=[1, 2, 5])
def threads(request):
    with using(request.param) as count:
        yield count


def test_items_within_items_come_in_order_and_no_more_at_once_than_threads(threads):
    working, most, lock = 0, 0, threading.Lock()

    def inner(first, last):
        nonlocal working, most
        with lock:
            working += 1
            most = max(most, working)
        rows = list(range(first, last))
        with lock:
            working -= 1
        return rows

    def outer(n):
        return [k for part in map_chunks(inner, n, 3) for k in part]

    assert map_items(outer, iter(range(40))) == [list(range(n)) for n in range(40)]
    assert 1 <= most <= threads


def test_a_thread_without_work_shares_the_chunks_of_another():
    both = threading.Barrier(2, timeout=20)

    def outer(chunks):
        # Two chunks that wait for each other need two threads.
        return map_chunks(lambda first, last: both.wait() if chunks > 1 else first, chunks, 1)

    with using(2):
        found = map_items(outer, [2, 1])
    assert [len(parts) for parts in found] == [2, 1]


def test_an_error_in_one_item_is_raised(threads):
    with pytest.raises(ZeroDivisionError):
        map_items(lambda n: 1 / n, np.arange(5).tolist())
