"""Which faces of a mesh of triangles and quads are patches as they are, and of what kind.

A *seam* is a smooth edge between a triangle and a quad; a *seam vertex* is regular if it is smooth and has three
triangles in sequence and two quads. Patches are of three kinds: all corners regular; one irregular corner; or none,
but corners on regular seams: a *strip*, which a seam bounds on one side or touches in corners.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subdfit.mesh.topology import Topology
from subdfit.schemes import _quad_triangle_kernels as kernels
from subdfit.schemes._level import Level
from subdfit.schemes._quad_triangle_sectors import Sector

Indices = NDArray[np.int32]
Flags = NDArray[np.bool_]
Rows = NDArray[np.int64]


class Regular(NamedTuple):
    """A face of so many corners, all of them regular."""

    size: int


class Strip(NamedTuple):
    """A face of so many corners beside regular seams: one runs along its first side, or some touch a triangle.

    `touching` counts the corners that seams touch, from the first corner on; it is 0 where a seam runs along the side.
    """

    size: int
    touching: int


class Corner(NamedTuple):
    """A face with one irregular corner, its first.

    `order` has a letter for each face of the corner's sector, counter-clockwise, T or Q. The patch's face is the one
    at `position`, 0 where the sector goes all round without a sharp edge (`closed`, no `dart`). A dart's sharp edge
    begins its face 0. `pinned` marks corner vertices.
    """

    order: str
    position: int
    closed: bool
    dart: bool
    pinned: bool

    @property
    def sector(self) -> Sector:
        """The corner's sector."""
        return Sector(self.order, self.closed, self.dart, self.pinned)

    @property
    def size(self) -> int:
        """Corners of the patch's face."""
        return 3 if self.order[self.position] == "T" else 4


Kind = Regular | Strip | Corner


class Group(NamedTuple):
    """Patches of one kind: rows of the faces asked about, and the half-edges that leave their first corners."""

    kind: Kind
    rows: Rows
    half_edges: Rows


def groups(level: Level, faces: Rows) -> list[Group]:
    """Sort the faces that are patches by kind; the others, and those near tags of finite sharpness, are left out."""
    return [group for size in (3, 4) for group in _groups_of_size(level, faces, size)]


def _groups_of_size(level: Level, faces: Rows, size: int) -> list[Group]:
    t = level.topology
    rows = np.flatnonzero((t.face_offsets[faces + 1] - t.face_offsets[faces]) == size)
    if len(rows) == 0:
        return []
    half_edges = t.face_offsets[faces[rows]].astype(np.int64)[:, None] + np.arange(size)
    stays = ~level.semi_sharp[t.face_vertices[half_edges]].any(axis=1)
    rows, half_edges = rows[stays], half_edges[stays]
    seam = _seams(level)
    regular, on_seam, side = level.regular[half_edges], _regular_seam(level, seam)[half_edges], seam[half_edges]
    irregular = ~regular & ~on_seam
    found: list[tuple[Kind, Flags, Rows]] = [(Regular(size), regular.all(axis=1), np.zeros_like(rows))]
    found += _strips(on_seam, side, irregular, size)
    out = [Group(kind, rows[at], half_edges[at, first[at]]) for kind, at, first in found if at.any()]
    single, first = _single_corner(on_seam, side, irregular)
    return out + _by_corner(level, rows[single], half_edges[single, first[single]])


def _seams(level: Level) -> Flags:
    """Half-edges of smooth edges between faces of unlike size, (h,)."""
    t = level.topology
    size = np.diff(t.face_offsets)[t.face]
    return np.asarray((t.twin >= 0) & ~level.sharp & (size != size[t.twin]))


def _regular_seam(level: Level, seam: Flags) -> Flags:
    """Whether the origin of each half-edge is a smooth vertex with three triangles in sequence and two quads, (h,)."""
    t = level.topology
    size = np.diff(t.face_offsets)[t.face]
    triangles, quads, seams = (
        np.bincount(t.face_vertices[chosen], minlength=t.vertex_count) for chosen in (size == 3, size == 4, seam)
    )
    smooth = (level.sharp_count == 0) & ~level.pinned
    return np.asarray((smooth & (t.valence == 5) & (triangles == 3) & (quads == 2) & (seams == 2))[t.face_vertices])


def _strips(on_seam: Flags, side: Flags, irregular: Flags, size: int) -> list[tuple[Kind, Flags, Rows]]:
    """Strips among faces of one size: kind, whether each face is one, and which corner is first."""
    smooth = ~irregular.any(axis=1)
    count, sides = on_seam.sum(axis=1), side.sum(axis=1)
    found: list[tuple[Kind, Flags, Rows]] = [
        (Strip(size, 0), smooth & (sides == 1) & (count == 2), np.argmax(side, axis=1))
    ]
    if size == 3:
        # Of two corners the first is the one after a corner that no seam touches.
        first = np.argmax(on_seam & ~np.roll(on_seam, 1, axis=1), axis=1)
        found += [(Strip(3, k), smooth & (sides == 0) & (count == k), first) for k in (1, 2, 3)]
    return found


def _single_corner(on_seam: Flags, side: Flags, irregular: Flags) -> tuple[Flags, Rows]:
    """Faces with one irregular corner, and no seams at the others but those from this corner; and which it is."""
    first = np.argmax(irregular, axis=1)
    row = np.arange(len(first))
    seams = side[row, first].astype(np.int64) + side[row, first - 1]
    return np.asarray((irregular.sum(axis=1) == 1) & (on_seam.sum(axis=1) == seams)), first


def _by_corner(level: Level, rows: Rows, half_edges: Rows) -> list[Group]:
    """Group faces by their irregular corners."""
    t, out = level.topology, []
    larger = larger_faces(t)
    vertex = t.face_vertices[half_edges]
    closed, dart, pinned = level.sharp_count[vertex] < 2, level.sharp_count[vertex] == 1, level.pinned[vertex]
    position = np.where(closed & ~dart, 0, level.position[half_edges])
    for faces in np.unique(level.faces[half_edges]):
        some = np.flatnonzero(level.faces[half_edges] == faces)
        begin = np.where(level.sharp_count[vertex[some]] == 0, half_edges[some], level.first[half_edges[some]])
        tags = np.column_stack([position, closed, dart, pinned])[some]
        rows_of = np.column_stack([tags, sector_quads(t, larger, level.preceding, begin, int(faces))])
        kinds, which = np.unique(rows_of, axis=0, return_inverse=True)
        for k, (place, *flags) in enumerate(kinds.tolist()):
            chosen = some[which.ravel() == k]
            corner = Corner(letters(flags[3:]), place, *map(bool, flags[:3]))
            out.append(Group(corner, rows[chosen], half_edges[chosen]))
    return out


def by_order(t: Topology, preceding: Indices, half_edges: Indices) -> list[tuple[str, Rows]]:
    """Group half-edges that leave inner vertices by the order of the faces round them: order, rows."""
    found = []
    valence, larger = t.valence[t.face_vertices[half_edges]], larger_faces(t)
    for faces in np.unique(valence):
        some = np.flatnonzero(valence == faces)
        quads = sector_quads(t, larger, preceding, half_edges[some], int(faces))
        orders, which = np.unique(quads, axis=0, return_inverse=True)
        found += [(letters(order), some[which.ravel() == k]) for k, order in enumerate(orders.tolist())]
    return found


def letters(quads: list[bool]) -> str:
    """An order of faces in letters."""
    return "".join("Q" if quad else "T" for quad in quads)


def larger_faces(t: Topology) -> Flags:
    """Whether the face of each half-edge is no triangle, (h,)."""
    return np.asarray(np.diff(t.face_offsets)[t.face] > 3)


def larger_round(t: Topology, corners: int) -> Indices:
    """Number of faces round each vertex with more than so many corners, (n,)."""
    count: Indices = kernels.larger_round(t.face_offsets, t.face_vertices, t.vertex_count, corners)
    return count


def sector_quads(t: Topology, larger: Flags, preceding: Indices, begin: Indices, faces: int) -> Flags:
    """Whether each of so many faces round the origins of half-edges, counter-clockwise, is no triangle; (k, faces)."""
    out = np.empty((len(begin), faces), np.bool_)
    h = begin
    for i in range(faces):
        out[:, i] = larger[h]
        h = t.twin[preceding[h]]
    return out
