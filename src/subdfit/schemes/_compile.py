"""Patches of schemes whose patches are faces: what is plain at one level is listed there, the rest is refined."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.mesh.topology import Topology
from subdfit.schemes._corner_type import CornerType, pack, unpack
from subdfit.schemes._level import Level, Piece
from subdfit.schemes.patch_table import LEVELS, PatchTable
from subdfit.schemes.scheme import Refinement

Indices = NDArray[np.int32]
Rows = NDArray[np.int64]
Matrix = NDArray[np.float64]

REGULAR = CornerType(0, 0, closed=True, dart=False, pinned=False)
"""Stands for patches without an irregular corner."""


class FacePatches(Protocol):
    """What the patches of a scheme's faces are."""

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

    def refine(self, topology: Topology) -> Refinement:
        """One step of the scheme; children of face f are faces 4 f to 4 f + 3, one at each corner first."""
        ...


@dataclass(frozen=True, eq=False)
class _Pending:
    """Cells, or parts of them, that are faces of one level.

    `face` (k,) of that level, `slot` (k,) where their node goes, `turn` (k,) the corner of the part at which the face's
    first corner lies.
    """

    face: Rows
    slot: Rows
    turn: Rows

    def __getitem__(self, chosen: NDArray[np.bool_]) -> "_Pending":
        return _Pending(self.face[chosen], self.slot[chosen], self.turn[chosen])


@dataclass(frozen=True, eq=False)
class _Patches:
    """Patches of one level: their type keys, first corners, sizes and points."""

    keys: Rows
    corner: Rows
    sizes: Rows
    points: Indices


def compile_patches(rules: FacePatches, topology: Topology, matrix: sp.csr_array | None = None) -> PatchTable:
    """Compile a mesh whose faces are the cells, in their order.

    Parameters
    ----------
    rules
        The scheme's patches.
    topology
        The mesh.
    matrix
        Its vertices as combinations of the control points; None where they are the control points.
    """
    control = topology.vertex_count if matrix is None else matrix.shape[1]
    rows: list[sp.csr_array] = [sp.csr_array(sp.eye_array(control))]
    count, patch_count, cut_count = control, 0, 0
    nodes, patches = [np.empty(topology.face_count, np.int32)], []
    cells = np.arange(topology.face_count)
    pending = _Pending(cells, cells, np.zeros_like(cells))
    while len(pending.face):
        level = Level.of(topology)
        plain = _plain(level, pending, rules.corners)
        here = pending[plain]
        vertices = 0 if matrix is None else count
        mirrors_begin = count if matrix is None else count + topology.vertex_count
        found, mirrors = _list_patches(rules, level, here, np.array([vertices, mirrors_begin]))
        if matrix is None:
            matrix = rows[0]
        else:
            rows.append(matrix)
        rows.append(sp.csr_array(_mirror_matrix(mirrors, topology.vertex_count) @ matrix))
        count = mirrors_begin + len(mirrors)
        patches.append(found)
        flat = np.concatenate(nodes)
        flat[here.slot] = patch_count + np.arange(len(here.face))
        patch_count += len(here.face)
        cut = pending[~plain]
        flat[cut.slot] = ~(cut_count + np.arange(len(cut.face)))
        nodes = [flat, np.empty(4 * len(cut.face), np.int32)]
        pending = _children(cut, len(flat), turns=rules.corners == 4)
        cut_count += len(cut.face)
        if len(cut.face):
            piece = Piece.round(topology, cut.face)
            step = rules.refine(piece.topology)
            topology, matrix = step.child, sp.csr_array(step.matrix @ piece.rows(matrix))
    flat = np.concatenate(nodes)
    stacked = sp.csr_array(sp.vstack(rows, format="csr"))
    return _table(rules, stacked, patches, flat[: len(cells)], flat[len(cells) :].reshape(-1, 4))


def _plain(level: Level, pending: _Pending, corners: int) -> NDArray[np.bool_]:
    """Whether each part is a patch as it is: one irregular corner at most, and no rule that is going to change."""
    half_edges = level.topology.face_offsets[pending.face][:, None] + np.arange(corners)
    regular = level.regular[half_edges].sum(axis=1) >= corners - 1
    return np.asarray(regular & ~level.semi_sharp[level.topology.face_vertices[half_edges]].any(axis=1))


def _children(cut: _Pending, slots: int, turns: bool) -> _Pending:
    """The four parts of each face that is cut: where the piece round them is refined, faces 4 k to 4 k + 3.

    A quad's child has its first corner at the corner where it lies; a triangle's keeps its parent's order.
    """
    part = np.tile(np.arange(4), len(cut.face))
    at = (part + np.repeat(cut.turn, 4)) % 4 if turns else part
    slot = slots + 4 * np.repeat(np.arange(len(cut.face)), 4) + at
    return _Pending(np.arange(len(part)), slot, at if turns else np.zeros_like(at))


def _list_patches(rules: FacePatches, level: Level, here: _Pending, offsets: Rows) -> tuple[_Patches, Indices]:
    half_edges = level.topology.face_offsets[here.face][:, None] + np.arange(rules.corners)
    regular = level.regular[half_edges]
    corner = np.argmin(regular, axis=1)
    h = half_edges[np.arange(len(corner)), corner]
    vertex = level.topology.face_vertices[h]
    closed = level.sharp_count[vertex] < 2
    dart = level.sharp_count[vertex] == 1
    keys = pack(level.faces[h], np.where(closed & ~dart, 0, level.position[h]), closed, dart, level.pinned[vertex])
    plain = regular.all(axis=1)
    keys[plain] = _key(REGULAR)
    faces = level.faces[h].astype(np.int64)
    sizes = np.where(plain, rules.regular_size, rules.sizes(faces, faces + ~closed))
    start = np.concatenate([[0], np.cumsum(sizes)])
    points, mirrors = rules.points(level, here.face, corner, start, offsets)
    return _Patches(keys, (corner + here.turn) % rules.corners, sizes, points), mirrors


def _key(kind: CornerType) -> int:
    one = (np.array([value]) for value in (kind.faces, kind.position, kind.closed, kind.dart, kind.pinned))
    return int(pack(*one)[0])


def _mirror_matrix(corners: Indices, vertex_count: int) -> sp.csr_array:
    rows = np.repeat(np.arange(len(corners)), 3)
    values = np.tile([1.0, 1.0, -1.0], len(corners))
    return sp.csr_array((values, (rows, corners.ravel())), shape=(len(corners), vertex_count))


def _table(
    rules: FacePatches, matrix: sp.csr_array, patches: list[_Patches], cell_node: Indices, children: Indices
) -> PatchTable:
    points = np.concatenate([p.points for p in patches])
    matrix, points = only_used(matrix, points)
    types, patch_type = np.unique(np.concatenate([p.keys for p in patches]), return_inverse=True)
    kinds = [unpack(int(key)) for key in types]
    blocks = [rules.matrices(kind) for kind in kinds]
    sizes = np.concatenate([p.sizes for p in patches])
    first = np.cumsum(sizes) - sizes
    _, example = np.unique(patch_type, return_index=True)
    return PatchTable(
        point_matrix=matrix,
        cell_node=cell_node,
        node_children=children,
        patch_type=patch_type.astype(np.int32),
        patch_corner=np.concatenate([p.corner for p in patches]).astype(np.int8),
        patch_offset=np.concatenate([first, [len(points)]]).astype(np.int64),
        patch_points=points,
        type_size=sizes[example].astype(np.int32),
        type_levels=np.array([0 if kind == REGULAR else LEVELS for kind in kinds], np.int32),
        type_offset=np.cumsum([0, *(len(block) for block in blocks)])[:-1].astype(np.int64),
        matrices=np.concatenate(blocks),
    )


def only_used(matrix: sp.csr_array, points: Indices) -> tuple[sp.csr_array, Indices]:
    """Drop local points that no patch lists; the control points stay."""
    used = np.zeros(matrix.shape[0], np.bool_)
    used[points] = True
    used[: matrix.shape[1]] = True
    renumber = np.cumsum(used, dtype=np.int32) - np.int32(1)
    return sp.csr_array(matrix[np.flatnonzero(used)]), renumber[points]
