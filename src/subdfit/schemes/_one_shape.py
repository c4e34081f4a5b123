"""Patches of schemes whose faces all have one shape, with one irregular corner at most."""

from collections.abc import Hashable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from subdfit.schemes._compile import Listed
from subdfit.schemes._corner_type import CornerType, pack, unpack
from subdfit.schemes._level import Level
from subdfit.schemes._type_store import Types
from subdfit.schemes.patch_table import LEVELS, NO_STRIPS, PatchType, Strips

Indices = NDArray[np.int32]
Rows = NDArray[np.int64]
Matrix = NDArray[np.float64]

REGULAR = CornerType(0, 0, closed=True, dart=False, pinned=False)
"""Stands for patches without an irregular corner."""


class OneShape(Protocol):
    """What such patches are."""

    @property
    def corners(self) -> int:
        """Corners of a face: 3 or 4."""
        ...

    @property
    def regular_size(self) -> int:
        """Points of a regular patch."""
        ...

    def sizes(self, faces: Rows, edges: Rows) -> Rows:
        """Points of irregular patches whose corner has so many faces and edges in its sector."""
        ...

    def points(self, level: Level, chosen: Rows, corner: Rows, start: Rows, offsets: Rows) -> tuple[Indices, Indices]:
        """List the points of patches, and the mirror points among them.

        Parameters
        ----------
        level, chosen, corner
            (k,) faces of the level, and which of their corners is first.
        start
            (k + 1,) where each patch's points begin.
        offsets
            (2,) the rows from which the level's vertices and its mirror points are counted.

        Returns
        -------
        points : int32; mirrors : (m, 3) int32 vertices a, b, c of the level, for the points a + b - c.
        """
        ...

    def matrices(self, kind: CornerType) -> Matrix:
        """The matrices of a type, in the order that `PatchTable.matrices` documents."""
        ...


class OneShapePatches:
    """Fulfils `FacePatches` for a class that fulfils `OneShape`."""

    strips: Strips = NO_STRIPS

    def listed(self: OneShape, level: Level, faces: Rows, offsets: Rows) -> Listed:
        """List the faces that have one irregular corner at most, and no rule that is going to change."""
        t = level.topology
        half_edges = t.face_offsets[faces][:, None] + np.arange(self.corners)
        regular = level.regular[half_edges]
        plain = (regular.sum(axis=1) >= self.corners - 1) & ~level.semi_sharp[t.face_vertices[half_edges]].any(axis=1)
        rows = np.flatnonzero(plain)
        half_edges, regular = half_edges[rows], regular[rows]
        corner = np.argmin(regular, axis=1)
        h = half_edges[np.arange(len(corner)), corner]
        vertex = t.face_vertices[h]
        closed = level.sharp_count[vertex] < 2
        dart = level.sharp_count[vertex] == 1
        keys = pack(level.faces[h], np.where(closed & ~dart, 0, level.position[h]), closed, dart, level.pinned[vertex])
        plain = regular.all(axis=1)
        keys[plain] = _key(REGULAR)
        kinds, which = np.unique(keys, return_inverse=True)
        count = level.faces[h].astype(np.int64)
        sizes = np.where(plain, self.regular_size, self.sizes(count, count + ~closed))
        start = np.concatenate([[0], np.cumsum(sizes)])
        points, mirrors = self.points(level, faces[rows], corner, start, offsets)
        return Listed(rows, [unpack(int(key)) for key in kinds], which, corner, sizes, points, mirrors)

    def types(self: OneShape, kinds: list[Hashable]) -> Types:
        """The types of irregular corners, or of none."""
        return Types.of([_type_of(self, kind) for kind in kinds])


def _type_of(rules: OneShape, kind: Hashable) -> PatchType:
    assert isinstance(kind, CornerType)
    faces, edges = np.array([kind.faces]), np.array([kind.edges])
    if kind == REGULAR:
        return PatchType(rules.regular_size, 0, (-1, -1, -1), rules.matrices(kind))
    return PatchType(int(rules.sizes(faces, edges)[0]), LEVELS, (-1, -1, -1), rules.matrices(kind))


def _key(kind: CornerType) -> int:
    one = (np.array([value]) for value in (kind.faces, kind.position, kind.closed, kind.dart, kind.pinned))
    return int(pack(*one)[0])
