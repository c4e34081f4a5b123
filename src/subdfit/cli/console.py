"""What the user sees while a command works: one live line, or plain lines where there is no terminal.

Everything but results goes to standard error. Plain lines wait until the input has proved usable, so that a refusal is
one line, no more.
"""

import logging
import os
import sys
import time
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Self

from subdfit.wording import counted

if TYPE_CHECKING:
    from subdfit import ControlMesh, Progress

PAUSE = 2.0
"""Least seconds between two plain lines of progress, and before the first."""

_SPOKEN = ("subdfit.compiled", "subdfit.api")
"""Loggers whose information the user is told; of the others only warnings."""


def one_line(text: object) -> str:
    """A text without line breaks."""
    return " ".join(str(text).split())


def say(text: str) -> None:
    """Write a result to standard output, which may have been closed."""
    try:
        sys.stdout.write(text + "\n")
        sys.stdout.flush()
    except BrokenPipeError:
        with suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


class Console(logging.Handler):
    """Shows progress, warnings and errors on standard error, for the time of a ``with`` block.

    Attributes
    ----------
    best : the control mesh of least maximum error that was reported, or the lightest, once a fit thins; or None.
    """

    def __init__(self, *, quiet: bool) -> None:
        super().__init__(logging.INFO)
        self.quiet = quiet
        self.best: ControlMesh | None = None
        self._best_error = float("inf")
        self._text = ""
        self._waiting: list[str] | None = []
        self._begun = self._working_clock()
        self._spoken = time.perf_counter()
        self._live: Any = None

    def __enter__(self) -> Self:
        logger = logging.getLogger("subdfit")
        self._before = logger.level, logger.propagate
        logger.setLevel(logging.INFO)
        logger.propagate = False
        logger.addHandler(self)
        if not self.quiet and sys.stderr.isatty():
            from rich.console import Console as Terminal
            from rich.live import Live

            terminal = Terminal(stderr=True, highlight=False, markup=False, soft_wrap=True)
            self._live = Live(
                get_renderable=self._line,
                console=terminal,
                transient=True,
                refresh_per_second=4,
                redirect_stdout=False,
                redirect_stderr=False,
            )
            self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.rest()
        logger = logging.getLogger("subdfit")
        logger.removeHandler(self)
        logger.setLevel(self._before[0])
        logger.propagate = self._before[1]

    def rest(self) -> None:
        """Take the live line away, for good, and say what has waited."""
        if self._live is not None:
            self._live.stop()
            self._live = None
        self._usable()

    def emit(self, record: logging.LogRecord) -> None:
        """Show a message of the library."""
        message = one_line(record.getMessage())
        if record.levelno >= logging.ERROR:
            self._write(f"subdfit: error: {message}")
        elif record.levelno >= logging.WARNING:
            self._write(f"subdfit: warning: {message}")
        elif record.name == "subdfit.api.stages":
            self.stage(message)
        elif not self.quiet and record.name.startswith(_SPOKEN):
            self._write(f"subdfit: {message}")

    def error(self, message: str) -> None:
        """Show why the command ends, and of all that has waited nothing."""
        self._waiting = []
        self.rest()
        self._write(f"subdfit: error: {message}")

    def stage(self, name: str) -> None:
        """Show what is being done; from the first stage on seconds are counted."""
        if not self._text:
            self._begun = self._working_clock()
        self._text = name
        self._plain()

    def progress(self, step: "Progress") -> None:
        """Show an iteration of a fit, and keep its control mesh if it is the best."""
        self._usable()
        if step.stage == "thin" or step.max < self._best_error:
            self.best, self._best_error = step.control_mesh, step.max
        self._text = (
            f"{step.stage} {step.iteration}: {counted(step.control_vertices, 'control vertex')}, "
            f"E_max {100 * step.max:.3g} %, E_rms {100 * step.rms:.3g} %"
        )
        self._plain()

    def _line(self) -> str:
        return f"{self._text}, {self._working_clock() - self._begun:.1f} s" if self._text else ""

    @staticmethod
    def _working_clock() -> float:
        """A clock that stands still while kernels compile, as that of results does."""
        compiled = sys.modules.get("subdfit.compiled")  # never loaded for the clock alone: numba is slow to load
        clock = getattr(compiled, "compile_clock", None)
        return time.perf_counter() - (clock.so_far() if clock else 0.0)

    def _usable(self) -> None:
        """The input has proved usable: write the lines that have waited, and others from now on at once."""
        waiting, self._waiting = self._waiting, None
        for line in waiting or []:
            self._write(line)

    def _plain(self) -> None:
        now = time.perf_counter()
        if self._live is None and self._waiting is None and not self.quiet and now - self._spoken >= PAUSE:
            self._spoken = now
            self._write(f"subdfit: {self._line()}")

    def _write(self, line: str) -> None:
        if self._live is not None:
            self._live.console.print(line)
        elif self._waiting is not None:
            self._waiting.append(line)
        else:
            with suppress(BrokenPipeError):
                sys.stderr.write(line + "\n")
                sys.stderr.flush()
