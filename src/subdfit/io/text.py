"""Numbers from text, strictly: what is no number is an error that names the word."""

from collections.abc import Sequence
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError


def floats(words: Sequence[bytes], where: str) -> NDArray[np.float64]:
    """Convert words to float64; raises InputError that quotes the first one that is no number."""
    try:
        return np.array(list(map(float, words)), np.float64)
    except ValueError:
        raise InputError(f"{where}: {_first_bad(words, float)} is not a number; export the file again") from None


def integers(words: Sequence[bytes], where: str) -> NDArray[np.int64]:
    """Convert words to int64; raises InputError that quotes the first one that is no integer."""
    try:
        return np.array(list(map(int, words)), np.int64)
    except (ValueError, OverflowError):
        raise InputError(f"{where}: {_first_bad(words, int)} is not an index; export the file again") from None


def table(rows: list[list[bytes]], columns: int, where: str) -> NDArray[np.float64]:
    """Convert the first `columns` words of each row to (n, columns) float64; raises InputError for a short row."""
    if rows and min(map(len, rows)) < columns:
        short = next(row for row in rows if len(row) < columns)
        raise InputError(
            f"{where}: '{quote(b' '.join(short))}' has fewer than {columns} numbers; export the file again"
        )
    words = list(chain.from_iterable(row[:columns] for row in rows))
    return floats(words, where).reshape(-1, columns)


def quote(text: bytes) -> str:
    """Short printable form of a piece of a file."""
    shown = text[:40].decode("ascii", "backslashreplace")
    return shown if shown.isprintable() else repr(shown)[1:-1]


def _first_bad(words: Sequence[bytes], kind: type[int] | type[float]) -> str:
    for word in words:
        try:
            if kind is int and abs(int(word)) < 2**63:
                continue
            if kind is float and float(word) is not None:
                continue
        except ValueError:
            pass
        return f"'{quote(word)}'"
    return "a word"
