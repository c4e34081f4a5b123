"""How many threads work: our own over chunks, and one for the linear algebra library under each."""

from collections.abc import Iterator
from contextlib import contextmanager

import scipy.linalg  # noqa: F401  (a library can be held to one thread only once it is loaded)
from threadpoolctl import threadpool_limits

from subdfit import parallel
from subdfit.api.targets import check_count


@contextmanager
def workers(threads: int | None) -> Iterator[None]:
    """Use so many threads inside the block, None as many as are set; BLAS stays on one, as it would compete with ours.

    Raises
    ------
    InputError
        Fewer than one thread.
    """
    check_count(threads, "threads", 1)
    before = parallel.threads()
    with threadpool_limits(1, user_api="blas"):
        try:
            if threads is not None:
                parallel.set_threads(threads)
            yield
        finally:
            if threads is not None:
                parallel.set_threads(before)
