"""A file is written whole or not at all."""

import os
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import EISDIR
from pathlib import Path
from stat import S_ISDIR
from typing import BinaryIO

from subdfit.errors import MachineError


@contextmanager
def atomic(path: str | Path) -> Iterator[BinaryIO]:
    """Open a binary file that takes its place only when the block ends without an exception.

    The bytes go to a temporary file in the same folder, which then replaces `path` in one step, so that a
    reader sees the old file or the new one; after an exception nothing is left behind.

    Raises
    ------
    MachineError
        The file or its folder cannot be written.
    """
    target, temporary = _places(path)
    try:
        try:
            with temporary.open("xb") as stream:
                yield stream
            temporary.replace(target)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise MachineError(cannot_write(path, error)) from error


def check_folder(path: str | Path) -> None:
    """Raise MachineError at once where `atomic` could only fail at the end."""
    try:
        target, probe = _places(path)
        probe.touch(exist_ok=False)
        probe.unlink()
        with suppress(FileNotFoundError):
            if S_ISDIR(target.stat().st_mode):
                raise IsADirectoryError(EISDIR, "it is a folder")
    except OSError as error:
        raise MachineError(cannot_write(path, error)) from error


def _places(path: str | Path) -> tuple[Path, Path]:
    """Return the file itself, behind links, and an unused name beside it."""
    target = Path(os.path.realpath(path))
    return target, target.parent / f".subdfit-{uuid.uuid4().hex}.part"


def cannot_write(path: str | Path, error: OSError) -> str:
    """One line that says which file could not be written, and why."""
    if isinstance(error, FileNotFoundError | NotADirectoryError):
        folder = Path(path).parent
        if folder.is_dir():
            return f"cannot write {path}: no file can be made in {folder}; choose another folder"
        return f"cannot write {path}: there is no folder {folder}; make it first"
    return f"cannot write {path}: {error.strerror or error}; choose a place with room and permission"
