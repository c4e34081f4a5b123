"""Patches of a Doo-Sabin surface: a cell is one where one of its four faces is irregular at most, else four.

A face is irregular if it is no quad, or if a crease ends in it beside the cell.

Beyond plain curves stand mirror points (`mirrored_polygon`), with which boundary patches are ordinary ones.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.schemes._doo_sabin_cells import Cells
from subdfit.schemes._doo_sabin_curves import Curves
from subdfit.schemes._doo_sabin_masks import QUAD_CORNER_IMAGE, Face, mirrored_polygon
from subdfit.schemes._doo_sabin_refine import DualRows
from subdfit.schemes._doo_sabin_types import (
    AFTER,
    AVERAGING,
    BEFORE,
    CONE,
    ORIGINAL,
    OUTER,
    REGULAR,
    TIP,
    patch_matrices,
)
from subdfit.schemes.patch_table import LEVELS, NO_STRIPS, PatchTable

Rows = NDArray[np.integer]

KEY = 2**24
"""A patch's key is its code times this, plus how many corners its face at (0, 0) has."""


@dataclass(frozen=True, eq=False)
class Points:
    """Points that patches of a level list: its vertices, then the mirror points beyond its curves.

    Attributes
    ----------
    curves : the level, whose curves are plain.
    """

    curves: Curves

    @cached_property
    def imaged(self) -> Rows:
        """Face corners whose vertex has a mirror image through that face, in the order of the mirror points."""
        c = self.curves
        kind, sides = c.kind[c.topology.face], c.sides[c.topology.face]
        return np.flatnonzero(c.inner & ((kind == Face.HALF) | ((kind == Face.QUARTER) & (sides == 4))))

    @cached_property
    def image(self) -> Rows:
        """The mirror point of each face corner, (h,), -1 for none."""
        found = np.full(len(self.curves.sharp), -1, np.int64)
        found[self.imaged] = self.curves.topology.vertex_count + np.arange(len(self.imaged))
        return found

    @property
    def mirrors(self) -> sp.csr_array:
        """The mirror points from the level's vertices."""
        c, t = self.curves, self.curves.topology
        first = t.vertex_count
        rows, columns, values = [], [], []
        faces = np.unique(t.face[self.imaged])
        for m in np.unique(c.sides[faces]):
            for kind in (Face.HALF, Face.QUARTER):
                chosen = c.corners(faces[(c.sides[faces] == m) & (c.kind[faces] == kind)], int(m))
                half = kind == Face.HALF
                masks = mirrored_polygon(int(m))[: m - 3 : -1] if half else QUAD_CORNER_IMAGE[None]
                for corner, mask in enumerate(masks, start=2):
                    rows.append(np.repeat(self.image[chosen[:, corner]] - first, m))
                    columns.append(t.face_vertices[chosen].ravel())
                    values.append(np.tile(mask, len(chosen)))
        shape = (len(self.imaged), first)
        if not rows:
            return sp.csr_array(shape)
        triple = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        return sp.csr_array(triple, shape=shape)

    def beside(self, ring: Rows) -> Rows:
        """The points next to cells' vertices beyond their four sides, (k, 4)."""
        t = self.curves.topology
        leaving = np.roll(ring, -1, axis=1)
        head = t.face_vertices[t.following[leaving]]
        half = self.curves.kind == Face.HALF
        mirror = self.image[np.where(half[t.face[leaving]], leaving, ring)]
        return np.where(self.curves.on_curve[head], mirror, head)

    def tip(self, ring: Rows) -> Rows:
        """Whether a crease ends in the face at a corner, beside it: `BEFORE` it, `AFTER` it, 0 for not; (k, ...)."""
        c, t = self.curves, self.curves.topology
        ends = np.zeros(len(c.sharp), np.int64)
        ends[t.following[c.tips]] = BEFORE
        ends[c.before(c.tips)] = AFTER
        return ends[ring]

    def opposite(self, corner: Rows) -> Rows:
        """The points opposite to face corners, (k, ...), where the faces are quads."""
        c, t = self.curves, self.curves.topology
        kind, start = c.kind[t.face[corner]], c.start[t.face[corner]]
        beyond = self.across(corner)
        # In a half A, B, y1, y2 it is the image of the other one inside.
        other = np.where(beyond == start, t.following[corner], c.before(corner))
        found = np.where(kind == Face.HALF, self.image[other], t.face_vertices[beyond])
        return np.where(kind == Face.QUARTER, self.image[corner], found)

    def across(self, corner: Rows) -> Rows:
        """The corners of quads opposite to those given."""
        following = self.curves.topology.following
        return following[following[corner]]

    def polygon(self, corner: Rows, m: int) -> Rows:
        """The points of whole or half faces of m sides from corners inside, counter-clockwise, (k, M)."""
        c, t = self.curves, self.curves.topology
        face = t.face[corner]
        place = corner - t.face_offsets[face]
        if c.kind[face[0]] == Face.WHOLE:
            return t.face_vertices[t.face_offsets[face][:, None] + (place[:, None] + np.arange(m)) % m]
        corners, r = c.corners(face, m), m - 2
        whole = np.hstack([t.face_vertices[corners[:, 2:]], self.image[corners[:, :1:-1]]])
        first = np.argmax(corners == corner[:, None], axis=1) - 2
        return np.take_along_axis(whole, (first[:, None] + np.arange(2 * r)) % (2 * r), axis=1)


@dataclass(frozen=True, eq=False)
class Patches:
    """Patches of one level: their keys, the corners of their cells that are (0, 0), sizes and points."""

    keys: Rows
    corner: Rows
    sizes: Rows
    points: Rows


def list_patches(level: Points, ring: Rows, turn: Rows, averaging: bool) -> Patches:
    """List the patches of cells that have one irregular face at most.

    Parameters
    ----------
    level
        The level with the cells' vertices.
    ring
        (k, 4) the cells' corners, as in `Cells.ring`.
    turn
        (k,) which corner of the cell of the table is that of `ring`'s first.
    averaging
        Which mask whole faces take.
    """
    curves, face = level.curves, level.curves.topology.face
    irregular = irregular_corners(level, ring)
    first = np.argmax(irregular, axis=1)
    ring = np.take_along_axis(ring, (first[:, None] + np.arange(4)) % 4, axis=1)
    sides, kind = curves.sides[face[ring[:, 0]]], curves.kind[face[ring[:, 0]]]
    code = np.where(kind == Face.QUARTER, CONE, np.where((kind == Face.WHOLE) & averaging, AVERAGING, ORIGINAL))
    code[~irregular.any(axis=1)] = REGULAR
    tip = level.tip(ring[:, 0])
    code += TIP * tip
    own = np.where(kind == Face.WHOLE, sides, np.where(kind == Face.HALF, 2 * sides - 4, 4))
    sizes = own + OUTER
    start = np.cumsum(sizes) - sizes
    points = np.empty(int(sizes.sum()), np.int64)
    beside, opposite = level.beside(ring), level.opposite(ring[:, 1:])
    for side, place in ((BEFORE, 1), (AFTER, 3)):
        # Beside the face where a crease ends its own points stand, not their images.
        near = ring[tip == side, place]
        opposite[tip == side, place - 1] = level.curves.topology.face_vertices[level.across(near)]
    outer = np.column_stack([opposite[:, 0], beside[:, 1], opposite[:, 1], beside[:, 2], opposite[:, 2]])
    points[(start + own)[:, None] + np.arange(OUTER)] = outer
    for group in _alike(sides, kind):
        listed = _face_points(level, ring[group, 0], beside[group])
        points[start[group][:, None] + np.arange(listed.shape[1])] = listed
    return Patches(KEY * code + own, (first + turn) % 4, sizes, points)


def irregular_corners(level: Points, ring: Rows) -> NDArray[np.bool_]:
    """Which corners of cells are irregular, (k, 4)."""
    curves = level.curves
    return np.asarray((curves.sides[curves.topology.face[ring]] != 4) | (level.tip(ring) > 0))


def _face_points(level: Points, corner: Rows, beside: Rows) -> Rows:
    """The points of patches' faces at (0, 0), all of one kind and size, from the patches' corners in them."""
    curves, t = level.curves, level.curves.topology
    face = t.face[corner]
    m = int(curves.sides[face[0]])
    if curves.kind[face[0]] != Face.QUARTER:
        return level.polygon(corner, m)
    q = t.face_vertices[corner]
    if m == 4:
        return np.column_stack([q, beside[:, 3], level.opposite(corner), beside[:, 0]])
    return np.column_stack([t.face_vertices[curves.start[face]], q, beside[:, 3], beside[:, 0]])


def _alike(sides: Rows, kind: Rows) -> list[Rows]:
    """Rows that are alike, group by group."""
    _, member = np.unique(len(Face) * sides + kind, return_inverse=True)
    order = np.argsort(member, kind="stable")
    return np.split(order, np.cumsum(np.bincount(member))[:-1]) if len(order) else []


def compile_dual(cells: Cells, averaging: bool, matrix: sp.csr_array | None) -> PatchTable:
    """Compile the patches of all cells; `matrix` makes the mesh's vertices where they are not the control points."""
    plain = irregular_corners(Points(cells.child), cells.ring).sum(axis=1) <= 1
    whole, cut = np.flatnonzero(plain), np.flatnonzero(~plain)
    rows = DualRows(cells.parent, cells.numbers, averaging).matrix
    rows = rows if matrix is None else sp.csr_array(rows @ matrix)
    control = rows.shape[1]
    found, used = _numbered(cells, list_patches(Points(cells.child), cells.ring[whole], 0 * whole, averaging), control)
    patches, blocks = [found], [sp.csr_array(sp.eye_array(control)), sp.csr_array(used @ rows)]
    if len(cut):
        finer = Cells.of(cells.child)
        part = finer.numbers.of_face_corner[cells.ring[cut]].ravel()
        # A part's own first corner is in the middle of its cell.
        turn = np.tile((np.arange(4) + 2) % 4, len(cut))
        found = list_patches(Points(finer.child), finer.ring[part], turn, averaging)
        found, used = _numbered(finer, found, control + blocks[1].shape[0])
        patches.append(found)
        blocks.append(sp.csr_array(used @ DualRows(finer.parent, finer.numbers, averaging).matrix @ rows))
    node = np.empty(cells.count, np.int32)
    node[whole], node[cut] = np.arange(len(whole)), ~np.arange(len(cut))
    children = np.arange(len(whole), len(whole) + 4 * len(cut), dtype=np.int32).reshape(-1, 4)
    return _table(sp.csr_array(sp.vstack(blocks, format="csr")), patches, node, children)


def _numbered(cells: Cells, patches: Patches, first: int) -> tuple[Patches, sp.csr_array]:
    """Number the points that are used from `first` on; returns with them their matrix from the level's vertices."""
    used, points = np.unique(patches.points, return_inverse=True)
    count = cells.child.topology.vertex_count
    level = sp.vstack([sp.eye_array(count), Points(cells.child).mirrors], format="csr")
    return Patches(patches.keys, patches.corner, patches.sizes, first + points), sp.csr_array(level[used])


def _table(
    matrix: sp.csr_array, patches: list[Patches], node: NDArray[np.int32], children: NDArray[np.int32]
) -> PatchTable:
    sizes = np.concatenate([p.sizes for p in patches])
    types, patch_type = np.unique(np.concatenate([p.keys for p in patches]), return_inverse=True)
    blocks = [patch_matrices(int(key) // KEY, int(key) % KEY) for key in types]
    return PatchTable(
        point_matrix=matrix,
        cell_node=node,
        node_children=children,
        patch_type=patch_type.astype(np.int32),
        patch_corner=np.concatenate([p.corner for p in patches]).astype(np.int8),
        patch_offset=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64),
        patch_points=np.concatenate([p.points for p in patches]).astype(np.int32),
        type_size=(types % KEY + OUTER).astype(np.int32),
        type_levels=np.where(types // KEY == REGULAR, 0, LEVELS).astype(np.int32),
        type_offset=np.cumsum([0, *(len(block) for block in blocks)])[:-1].astype(np.int64),
        type_strips=np.full((len(types), 3), -1, np.int8),
        matrices=np.concatenate([np.empty(0), *blocks]),
        strips=NO_STRIPS,
        quad_degree=2,
    )
