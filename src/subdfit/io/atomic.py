"""A file is written whole or not at all."""

import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
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
    target = Path(path).resolve()
    temporary = target.parent / f".subdfit-{uuid.uuid4().hex}.part"
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
    if Path(path).is_dir():
        raise MachineError(f"cannot write {path}: it is a folder; name a file")
    folder = Path(path).resolve().parent
    probe = folder / f".subdfit-{uuid.uuid4().hex}.part"
    try:
        probe.touch(exist_ok=False)
        probe.unlink()
    except OSError as error:
        raise MachineError(cannot_write(path, error)) from error


def cannot_write(path: str | Path, error: OSError) -> str:
    """One line that says which file could not be written, and why."""
    folder = Path(path).resolve().parent
    if not folder.is_dir():
        return f"cannot write {path}: there is no folder {folder}; make it first"
    return f"cannot write {path}: {error.strerror or error}; choose a place with room and permission"
