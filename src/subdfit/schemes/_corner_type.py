"""What distinguishes irregular corners of patches, for every scheme whose patches are faces."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class CornerType:
    """The sector that a patch's irregular corner V lies in.

    `faces` round the vertex in its sector, `position` of the patch's face in it, `closed` when the sector goes all the
    way round, `dart` when one sharp edge (ring index 0) ends there, `pinned` for a corner vertex.
    """

    faces: int
    position: int
    closed: bool
    dart: bool
    pinned: bool

    @property
    def edges(self) -> int:
        """Edges from V in the sector."""
        return self.faces if self.closed else self.faces + 1

    def sharp(self, j: int) -> bool:
        """Whether the edge number `j` round V is sharp."""
        if self.closed:
            return self.dart and j == 0
        return j in (0, self.faces)


def pack(
    faces: NDArray[np.int32],
    position: NDArray[np.int32],
    closed: NDArray[np.bool_],
    dart: NDArray[np.bool_],
    pinned: NDArray[np.bool_],
) -> NDArray[np.int64]:
    """Corner types as numbers."""
    key: NDArray[np.int64] = faces.astype(np.int64) << 32 | position.astype(np.int64) << 3
    key = key | closed.astype(np.int64) << 2 | dart.astype(np.int64) << 1 | pinned
    return key


def unpack(key: int) -> CornerType:
    """The corner type of a number."""
    return CornerType(key >> 32, (key >> 3) & 0x1FFFFFFF, bool(key & 4), bool(key & 2), bool(key & 1))
