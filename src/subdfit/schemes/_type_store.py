"""Types of patches, made many at a time and kept for the next compilations of the process."""

from collections.abc import Callable, Hashable, Sequence
from threading import Lock
from typing import Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from subdfit.schemes.patch_table import PatchType

Kind = TypeVar("Kind", bound=Hashable)
Value = TypeVar("Value")


class Types(NamedTuple):
    """Types of a table, see the attributes of `PatchTable` of the same names."""

    size: NDArray[np.int32]
    levels: NDArray[np.int32]
    strips: NDArray[np.int8]
    offset: NDArray[np.int64]
    matrices: NDArray[np.float64]

    @classmethod
    def of(cls, types: Sequence[PatchType]) -> "Types":
        """Join types to a table of their own."""
        offset = np.cumsum([0, *(len(one.matrices) for one in types)])[:-1]
        return cls.placed(types, offset, np.concatenate([np.empty(0), *(one.matrices for one in types)]))

    @classmethod
    def placed(cls, types: Sequence[PatchType], offset: NDArray[np.int64], matrices: NDArray[np.float64]) -> "Types":
        """Types whose matrices begin at offsets of an array."""
        return cls(
            np.array([one.size for one in types], np.int32),
            np.array([one.levels for one in types], np.int32),
            np.array([one.strips for one in types], np.int8).reshape(-1, 3),
            offset.astype(np.int64),
            matrices,
        )


class Kept(Generic[Kind, Value]):
    """Values by kind, made many at a time; when there would be more than `limit`, all are forgotten first."""

    def __init__(self, make: Callable[[list[Kind]], list[Value]], limit: int) -> None:
        self._make, self._limit = make, limit
        self._found: dict[Kind, Value] = {}

    def of(self, kinds: Sequence[Kind]) -> list[Value]:
        """The values of kinds."""
        found = self._found
        missing = [kind for kind in dict.fromkeys(kinds) if kind not in found]
        if len(found) + len(missing) > self._limit:
            found, missing = {}, list(dict.fromkeys(kinds))
        if missing:
            # A new dictionary, for other threads may read the old one.
            found = found | dict(zip(missing, self._make(missing), strict=True))
            self._found = found
        return [found[kind] for kind in kinds]


class TypeStore(Generic[Kind]):
    """Types by kind, whose matrices lie in one array that tables share: a type may have half a megabyte of them.

    The array grows at its end only. When it would hold more than `limit` numbers, a new one begins; tables keep theirs.
    """

    def __init__(self, make: Callable[[list[Kind]], list[PatchType]], limit: int = 2**25) -> None:
        self._make, self._limit, self._lock = make, limit, Lock()
        self._forget()

    def _forget(self) -> None:
        self._found: dict[Kind, tuple[PatchType, int]] = {}
        self._matrices, self._used = np.empty(0), 0

    def types(self, kinds: Sequence[Kind]) -> Types:
        """The types of kinds."""
        with self._lock:
            self._learn([kind for kind in dict.fromkeys(kinds) if kind not in self._found])
            if self._used > self._limit and len(self._found) > len(set(kinds)):
                self._forget()
                self._learn(list(dict.fromkeys(kinds)))
            found = [self._found[kind] for kind in kinds]
            offset = np.array([begin for _, begin in found], np.int64)
            return Types.placed([one for one, _ in found], offset, self._matrices[: self._used])

    def _learn(self, kinds: list[Kind]) -> None:
        made = self._make(kinds) if kinds else []
        self._reserve(sum(len(one.matrices) for one in made))
        for kind, one in zip(kinds, made, strict=True):
            begin, self._used = self._used, self._used + len(one.matrices)
            self._matrices[begin : self._used] = one.matrices
            self._found[kind] = one._replace(matrices=self._matrices[:0]), begin

    def _reserve(self, more: int) -> None:
        if self._used + more > len(self._matrices):
            larger = np.empty(max(2 * len(self._matrices), self._used + more))
            larger[: self._used] = self._matrices[: self._used]
            self._matrices = larger
