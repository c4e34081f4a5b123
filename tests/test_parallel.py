"""Threads: results come in order, and work within work stays where it is."""

import threading

import numpy as np
import pytest

from subdfit import parallel
from subdfit.parallel import map_chunks, map_items


@pytest.fixture(params=[1, 2, 5])
def threads(request):
    before = parallel.threads()
    parallel.set_threads(request.param)
    yield request.param
    parallel.set_threads(before)


def test_items_within_items_come_in_order_and_on_one_thread(threads):
    def inner(first, last):
        return threading.get_ident(), list(range(first, last))

    def outer(n):
        here = threading.get_ident()
        parts = map_chunks(inner, n, 3)
        assert threads == 1 or all(thread == here for thread, _ in parts)
        return [k for _, part in parts for k in part]

    assert map_items(outer, iter(range(40))) == [list(range(n)) for n in range(40)]


def test_an_error_in_one_item_is_raised(threads):
    with pytest.raises(ZeroDivisionError):
        map_items(lambda n: 1 / n, np.arange(5).tolist())
