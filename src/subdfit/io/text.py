"""Numbers from text, strictly: what is no number is an error that names the word."""

from collections.abc import Callable, Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError

Place = Callable[[int], str]
"""Where a word, or a row, of some number stands: asked for only once something is wrong with it."""


def floats(words: Sequence[bytes], where: Place) -> NDArray[np.float64]:
    """Convert words to float64; raises InputError that quotes the first one that is no number."""
    try:
        return np.array(list(map(float, words)), np.float64)
    except ValueError:
        bad = _first_bad(words, float)
        raise InputError(f"{where(bad)}: '{quote(words[bad])}' is not a number; export the file again") from None


def integers(words: Sequence[bytes], where: Place) -> NDArray[np.int64]:
    """Convert words to int64; raises InputError that quotes the first one that is no integer."""
    try:
        return np.array(list(map(int, words)), np.int64)
    except (ValueError, OverflowError):
        bad = _first_bad(words, int)
        raise InputError(f"{where(bad)}: '{quote(words[bad])}' is not an index; export the file again") from None


class Rows(NamedTuple):
    """Lines cut into words: all words in a row, and how many each line has."""

    words: list[bytes]
    sizes: NDArray[np.int64]

    @classmethod
    def of(cls, lines: list[bytes]) -> "Rows":
        """Cut lines, all at once where they have equally many words."""
        width = len(lines[0].split()) if lines else 0
        words = b" ; ".join(lines).split()
        breaks = max(len(lines) - 1, 0)
        alike = len(words) == width * len(lines) + breaks and words.count(b";") == breaks
        if alike and words[width :: width + 1] == [b";"] * breaks:
            del words[width :: width + 1]
            return cls(words, np.full(len(lines), width, np.int64))
        rows = [line.split() for line in lines]
        return cls(list(chain.from_iterable(rows)), np.array([len(row) for row in rows], np.int64))

    def part(self, skip: int, counts: NDArray[np.int64]) -> list[bytes]:
        """Return ``counts[i]`` words of each row i, after the first `skip`."""
        if len(counts) and (counts == counts[0]).all() and (self.sizes == self.sizes[0]).all():
            count, width = int(counts[0]), int(self.sizes[0])
            words = [b""] * (count * len(counts))
            for i in range(count):
                words[i::count] = self.words[skip + i :: width]
            return words
        starts = (np.cumsum(self.sizes) - self.sizes + skip).tolist()
        pieces = (self.words[a : a + n] for a, n in zip(starts, counts.tolist(), strict=True))
        return list(chain.from_iterable(pieces))

    def row(self, number: int) -> bytes:
        """Return one row, to quote it."""
        start = int(self.sizes[:number].sum())
        return b" ".join(self.words[start : start + int(self.sizes[number])])


def table(rows: Rows, columns: int, where: Place, skip: int = 0) -> NDArray[np.float64]:
    """Convert `columns` words of each row, after the first `skip`, to (n, columns) float64.

    Raises InputError, with the place of the row, where one is too short or a word is no number.
    """
    short = np.flatnonzero(rows.sizes < skip + columns)
    if len(short):
        shown = quote(rows.row(int(short[0])))
        raise InputError(f"{where(int(short[0]))}: '{shown}' has fewer than {columns} numbers; export the file again")
    words = rows.part(skip, np.full(len(rows.sizes), columns, np.int64))
    return floats(words, lambda word: where(word // columns)).reshape(-1, columns)


def row_of(word: int, sizes: NDArray[np.int64]) -> int:
    """The row to which a word belongs, of rows of so many words."""
    return int(np.searchsorted(np.cumsum(sizes), word, side="right"))


def quote(text: bytes) -> str:
    """Short printable form of a piece of a file."""
    shown = text[:40].decode("ascii", "backslashreplace")
    return shown if shown.isprintable() else repr(shown)[1:-1]


def _first_bad(words: Sequence[bytes], kind: type[int] | type[float]) -> int:
    """Number of the first word that is no number of a kind, of 64 bits; -1 where all are."""
    for place, word in enumerate(words):
        try:
            value = kind(word)
        except ValueError:
            return place
        if kind is int and abs(value) >= 2**63:
            return place
    return -1
