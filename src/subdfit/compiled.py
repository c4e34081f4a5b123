"""Compiled kernels: how every ``_kernels.py`` compiles, where the machine code is cached, what it cost.

Numba's own cache notices a changed source file but not a changed callee in another module. Our cache directories are
therefore keyed by a hash over a kernel's file and all kernel files it imports.
"""

import hashlib
import logging
import os
import re
import tempfile
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba
import numba.core.config
import numba.core.event
import platformdirs

logger = logging.getLogger(__name__)

_PACKAGE = Path(__file__).parent


def kernel(function: Callable[..., Any]) -> Any:
    """Compile `function` on its first call, without the interpreter lock, and keep the machine code on disk.

    Products and sums may be contracted to fused multiply-adds; nothing else of the arithmetic is
    reordered, so that results do not depend on the number of threads.
    """
    return _compile(function)


def inner_kernel(function: Callable[..., Any]) -> Any:
    """Compile as `kernel` does, for callers that are kernels: the way in from Python is half of a small one's cost."""
    return _compile(function, no_cpython_wrapper=True)


def inlined_kernel(function: Callable[..., Any]) -> Any:
    """Compile as `inner_kernel` does, but contained in its callers: for the small steps of hot loops.

    Such a kernel must not allocate, slice or return arrays: it counts no references to them, which in a loop over
    points would cost more than the arithmetic.
    """
    return _compile(function, no_cpython_wrapper=True, forceinline=True, _nrt=False)


def _compile(function: Callable[..., Any], **options: bool) -> Any:
    before = numba.core.config.CACHE_DIR
    numba.core.config.CACHE_DIR = cache_directory(function.__module__)
    try:
        return numba.njit(
            nogil=True,
            cache=True,
            error_model="numpy",
            fastmath={"contract"},
            no_cfunc_wrapper=True,
            **options,
        )(function)
    finally:
        numba.core.config.CACHE_DIR = before


@cache
def cache_directory(module: str) -> str:
    """Where a module's machine code is kept: NUMBA_CACHE_DIR, else beside the package, else the user's cache."""
    name = f"kernels-{_sources_hash(module)}"
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    own = [_PACKAGE / "__pycache__", Path(platformdirs.user_cache_dir("subdfit"))]
    for folder in [Path(chosen)] if chosen else own:
        if _writable(folder / name):
            return str(folder / name)
    return tempfile.mkdtemp(prefix="subdfit-kernels-")


def _sources_hash(module: str) -> str:
    digest = hashlib.sha256(Path(__file__).read_bytes())
    for path in sorted(_sources(module)):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _sources(module: str) -> set[Path]:
    """The module's file and those of the kernel modules it imports, directly or not; none for modules elsewhere."""
    if not module.startswith("subdfit."):
        return set()
    found: set[Path] = set()
    waiting = [module]
    while waiting:
        path = _PACKAGE.joinpath(*waiting.pop().split(".")[1:]).with_suffix(".py")
        if path not in found:
            found.add(path)
            text = path.read_text(encoding="utf-8")
            waiting += re.findall(r"^from (subdfit[.\w]*_kernels) import", text, re.MULTILINE)
    return found


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


class CompileClock(numba.core.event.Listener):
    """Counts the seconds spent compiling, and tells the user once that it happens.

    Attributes
    ----------
    seconds : spent compiling so far.
    at_first : called once, when the first kernel of the process is about to be compiled; None is nothing.
    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self.at_first: Callable[[], None] | None = None
        self._depth = 0
        self._started = 0.0
        self._told = False

    def so_far(self) -> float:
        """Seconds spent compiling, those of a kernel that is being compiled included."""
        return self.seconds + (time.perf_counter() - self._started if self._depth else 0.0)

    def on_start(self, event: Any) -> None:
        """Numba begins to compile a kernel (or, nested, one that it calls)."""
        if self._depth == 0:
            self._started = time.perf_counter()
            if not self._told:
                logger.info("compiling kernels for this machine (first run only; kept for the next)")
                self._told = True
                if self.at_first is not None:
                    self.at_first()
        self._depth += 1

    def on_end(self, event: Any) -> None:
        """The kernel is compiled."""
        self._depth -= 1
        if self._depth == 0:
            self.seconds += time.perf_counter() - self._started


compile_clock = CompileClock()
numba.core.event.register("numba:compile", compile_clock)
