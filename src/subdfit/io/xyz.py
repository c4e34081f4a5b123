"""XYZ point clouds: a line a point, ``x y z`` or ``x y z nx ny nz``; ``#`` starts a comment.

Numbers stand between blanks or, all of a file's, between commas or semicolons.
"""

import logging
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.io.text import Rows, floats, quote
from subdfit.mesh.data import MeshData
from subdfit.wording import counted

logger = logging.getLogger(__name__)

_COMMENT = re.compile(rb"#[^\r\n]*")
_BLANKS = bytes.maketrans(b",;", b"  ")
_UNCLEAR = re.compile(rb"[^,;\s][ \t]+[^,;\s]|[,;][ \t]*[,;]|^[ \t]*[,;]|,.*;|;.*,")
"""In a line with commas or semicolons: numbers without one between, no number between two, or both."""


def parse(content: bytes, path: Path) -> MeshData:
    """Read points, and normals where each line has six numbers; raises InputError that names the line."""
    plain = _COMMENT.sub(b"", content).splitlines()
    number = [k for k, line in enumerate(plain, 1) if line.strip()]
    rows = Rows.of(_between_blanks(plain, number, path))
    columns = int(rows.sizes[0]) if number else 3
    other = np.flatnonzero(rows.sizes != columns)
    if columns not in (3, 6):
        raise _refused(path, plain, number[0], f"has {counted(columns, 'word')}, not 3 numbers, or 6 with a normal")
    if len(other):
        raise _refused(path, plain, number[other[0]], f"has not {counted(columns, 'number')} as the lines before")
    values = floats(rows.words, lambda word: _place(path, plain, number[word // columns])).reshape(-1, columns)
    points, more = np.ascontiguousarray(values[:, :3]), np.ascontiguousarray(values[:, 3:])
    return MeshData(points, np.zeros(1, np.int64), np.empty(0, np.int64), normals=_normals(more, path))


def _between_blanks(plain: list[bytes], number: list[int], path: Path) -> list[bytes]:
    """The lines of some numbers, from 1, with blanks for commas or semicolons, if it is clear that these separate."""
    lines = [plain[k - 1] for k in number]
    if not any(mark in line for line in lines for mark in (b",", b";")):
        return lines
    for k, line in zip(number, lines, strict=True):
        if _UNCLEAR.search(line):
            raise _refused(path, plain, k, "has commas or semicolons, but not one between any two numbers")
    return [line.translate(_BLANKS) for line in lines]


def _refused(path: Path, lines: list[bytes], number: int, what: str) -> InputError:
    return InputError(f"{_place(path, lines, number)}, {what}; mend or remove it")


def _place(path: Path, lines: list[bytes], number: int) -> str:
    return f"{path.name}: line {number}, '{quote(lines[number - 1].strip())}'"


def _normals(given: NDArray[np.float64], path: Path) -> NDArray[np.float64] | None:
    """The second three numbers of each line, unless they are colours: whole numbers from 0 to 255, some above 1."""
    if not given.size:
        return None
    if given.min() >= 0 and 1 < given.max() <= 255 and np.array_equal(given, np.floor(given)):
        logger.warning("%s: the last three numbers of each line are taken as colours, not as normals", path.name)
        return None
    return given
