"""Types of patches, made many at a time and kept for the next compilations of the process."""

from collections.abc import Callable, Hashable, Sequence
from threading import Lock
from typing import Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from subdfit.schemes.patch_table import PatchType

Kind = TypeVar("Kind", bound=Hashable)
Value = TypeVar("Value")


class PlacedType(NamedTuple):
    """A type whose matrices begin at `offset` of an array; the others are attributes of `PatchType`."""

    size: int
    levels: int
    strips: tuple[int, int, int]
    offset: int


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
        offset = np.cumsum([0, *(len(one.matrices) for one in types)])
        placed = [PlacedType(*one[:3], int(begin)) for one, begin in zip(types, offset, strict=False)]
        return cls.placed(placed, np.concatenate([np.empty(0), *(one.matrices for one in types)]))

    @classmethod
    def placed(cls, types: Sequence[PlacedType], matrices: NDArray[np.float64]) -> "Types":
        """Types in an array."""
        return cls(
            np.array([one.size for one in types], np.int32),
            np.array([one.levels for one in types], np.int32),
            np.array([one.strips for one in types], np.int8).reshape(-1, 3),
            np.array([one.offset for one in types], np.int64),
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


class Arena:
    """An array that is filled from its beginning on; it moves if it must grow beyond its first capacity."""

    def __init__(self, capacity: int) -> None:
        # What is not used is never touched, and costs no memory.
        self._array, self._used = np.empty(capacity), 0

    @property
    def filled(self) -> NDArray[np.float64]:
        """What is filled."""
        return self._array[: self._used]

    def room(self, count: int) -> tuple[int, NDArray[np.float64]]:
        """Where the next numbers begin, and the place to write them to before more room is asked for."""
        begin, self._used = self._used, self._used + count
        if self._used > len(self._array):
            larger = np.empty(2 * self._used)
            larger[:begin] = self._array[:begin]
            self._array = larger
        return begin, self._array[begin : self._used]


class TypeStore(Generic[Kind]):
    """Types by kind, whose matrices lie in one array that tables share: a type may have half a megabyte of them.

    `make` makes types in an arena. When that would hold more than `limit` numbers, a new one begins; tables keep
    theirs.
    """

    def __init__(self, make: Callable[[list[Kind], Arena], list[PlacedType]], limit: int = 2**25) -> None:
        self._make, self._limit, self._lock = make, limit, Lock()
        self._found: dict[Kind, PlacedType] = {}
        self._arena = Arena(0)

    def types(self, kinds: Sequence[Kind]) -> Types:
        """The types of kinds."""
        with self._lock:
            wanted = list(dict.fromkeys(kinds))
            self._learn([kind for kind in wanted if kind not in self._found])
            if len(self._arena.filled) > self._limit and len(self._found) > len(wanted):
                self._found = {}
                self._learn(wanted)
            return Types.placed([self._found[kind] for kind in kinds], self._arena.filled)

    def _learn(self, kinds: list[Kind]) -> None:
        if not self._found:
            # The types that first exceed the limit fit as well: to move all would take as long as to make many.
            self._arena = Arena(self._limit + self._limit // 4)
        if kinds:
            self._found |= zip(kinds, self._make(kinds, self._arena), strict=True)
