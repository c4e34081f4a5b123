"""On a first run, a second process that compiles what a fit needs later, while the first reads and decimates."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress


@contextmanager
def compiling_ahead(scheme: str, threads: int | None, memory: str | None) -> Iterator[None]:
    """While the block runs, and from the moment when something has to be compiled, have a second process help.

    Both leave what they have compiled in the cache, where each finds the other's. No process is started where one
    thread or a limit of memory is asked, nor on a machine of one core; and no result depends on how it fares.
    """
    from subdfit.compiled import compile_clock

    helpers: list[subprocess.Popen[bytes]] = []

    def start() -> None:
        """Start the second process, if this machine lets us."""
        code = f"from subdfit.api.rehearsal import rehearse; rehearse({scheme!r})"
        quiet = subprocess.DEVNULL
        with suppress(OSError):
            helpers.append(
                subprocess.Popen([sys.executable, "-P", "-c", code], stdin=quiet, stdout=quiet, stderr=quiet)
            )

    if threads != 1 and memory is None and (os.cpu_count() or 1) > 1:
        compile_clock.at_first = start
    try:
        yield
    finally:
        compile_clock.at_first = None
        for helper in helpers:
            helper.kill()
            helper.wait()
