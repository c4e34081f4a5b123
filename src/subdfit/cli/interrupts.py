"""Ctrl-C where Python drops exceptions: in a callback of a library, or while something is taken away."""

import _thread
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Timer
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

AGAIN = 0.02
"""Seconds after which a lost Ctrl-C is raised again: by then its callback has returned, or loses it once more."""


@contextmanager
def interrupts_kept() -> Iterator[None]:
    """For the time of a ``with`` block, raise KeyboardInterrupt again in the main thread wherever it was lost.

    Numba compiles and loads kernels for seconds, with callbacks that Python cannot raise through.
    """
    before, waiting = sys.unraisablehook, list[Timer]()

    def hook(lost: "UnraisableHookArgs") -> None:
        if not issubclass(lost.exc_type, KeyboardInterrupt):
            before(lost)
            return
        waiting.append(Timer(AGAIN, _thread.interrupt_main))
        waiting[-1].daemon = True
        waiting[-1].start()

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before
        for timer in waiting:
            timer.cancel()
