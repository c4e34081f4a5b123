"""Patches of schemes whose patches are faces: what is plain at one level is listed there, the rest is refined."""

from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.mesh.topology import Topology
from subdfit.schemes._level import Level, Piece
from subdfit.schemes._type_store import Types
from subdfit.schemes.patch_table import PatchTable, Strips
from subdfit.schemes.scheme import Refinement

Indices = NDArray[np.int32]
Rows = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Listed:
    """Faces of a level that are patches.

    Attributes
    ----------
    rows : (k,), which of the faces asked about they are.
    kinds : what tells their types apart; which : (k,) rows of `kinds`.
    corner : (k,), the corner of its face at which each patch begins.
    sizes : (k,), points of each; points : int32, all their points.
    mirrors : (m, 3) int32 vertices a, b, c of the level, for the mirror points a + b - c.
    """

    rows: Rows
    kinds: list[Hashable]
    which: Rows
    corner: Rows
    sizes: Rows
    points: Indices
    mirrors: Indices


class FacePatches(Protocol):
    """What the patches of a scheme's faces are."""

    @property
    def strips(self) -> Strips:
        """The strips that types name."""
        ...

    def listed(self, level: Level, faces: Rows, offsets: Rows) -> Listed:
        """List the patches among faces of a level.

        `offsets` (2,) are the rows from which the level's vertices and its mirror points are counted.
        """
        ...

    def types(self, kinds: list[Hashable]) -> Types:
        """The types of kinds of patches."""
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

    def __getitem__(self, chosen: Rows) -> "_Pending":
        return _Pending(self.face[chosen], self.slot[chosen], self.turn[chosen])


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
    nodes, patches = [np.empty(topology.face_count, np.int32)], list[Listed]()
    cells = np.arange(topology.face_count)
    pending = _Pending(cells, cells, np.zeros_like(cells))
    while len(pending.face):
        level = Level.of(topology)
        vertices = 0 if matrix is None else count
        mirrors_begin = count if matrix is None else count + topology.vertex_count
        found = rules.listed(level, pending.face, np.array([vertices, mirrors_begin]))
        if matrix is None:
            matrix = rows[0]
        else:
            rows.append(matrix)
        rows.append(sp.csr_array(_mirror_matrix(found.mirrors, topology.vertex_count) @ matrix))
        count = mirrors_begin + len(found.mirrors)
        here = pending[found.rows]
        corner = (found.corner + here.turn) % np.diff(topology.face_offsets)[here.face]
        patches.append(replace(found, corner=corner))
        flat = np.concatenate(nodes)
        flat[here.slot] = patch_count + np.arange(len(here.face))
        patch_count += len(here.face)
        left = np.ones(len(pending.face), np.bool_)
        left[found.rows] = False
        cut = pending[np.flatnonzero(left)]
        flat[cut.slot] = ~(cut_count + np.arange(len(cut.face)))
        nodes = [flat, np.empty(4 * len(cut.face), np.int32)]
        pending = _children(cut, len(flat), np.diff(topology.face_offsets)[cut.face] == 4)
        cut_count += len(cut.face)
        if len(cut.face):
            piece = Piece.round(topology, cut.face)
            step = rules.refine(piece.topology)
            topology, matrix = step.child, sp.csr_array(step.matrix @ piece.rows(matrix))
    flat = np.concatenate(nodes)
    stacked = sp.csr_array(sp.vstack(rows, format="csr"))
    return _table(rules, stacked, patches, flat[: len(cells)], flat[len(cells) :].reshape(-1, 4))


def _children(cut: _Pending, slots: int, quad: Flags) -> _Pending:
    """The four parts of each face that is cut: where the piece round them is refined, faces 4 k to 4 k + 3.

    A quad's child has its first corner at the corner where it lies; a triangle's keeps its parent's order.
    """
    part, turn, turns = np.tile(np.arange(4), len(cut.face)), np.repeat(cut.turn, 4), np.repeat(quad, 4)
    at = np.where(turns, (part + turn) % 4, part)
    slot = slots + 4 * np.repeat(np.arange(len(cut.face)), 4) + at
    return _Pending(np.arange(len(part)), slot, np.where(turns, at, 0))


def _mirror_matrix(corners: Indices, vertex_count: int) -> sp.csr_array:
    rows = np.repeat(np.arange(len(corners)), 3)
    values = np.tile([1.0, 1.0, -1.0], len(corners))
    return sp.csr_array((values, (rows, corners.ravel())), shape=(len(corners), vertex_count))


def _table(
    rules: FacePatches, matrix: sp.csr_array, patches: list[Listed], cell_node: Indices, children: Indices
) -> PatchTable:
    matrix, points = only_used(matrix, np.concatenate([p.points for p in patches]))
    number: dict[Hashable, int] = {}
    for kind in (kind for p in patches for kind in p.kinds):
        number.setdefault(kind, len(number))
    patch_type = np.concatenate([np.array([number[kind] for kind in p.kinds], np.int32)[p.which] for p in patches])
    types = rules.types(list(number))
    sizes = np.concatenate([p.sizes for p in patches])
    return PatchTable(
        point_matrix=matrix,
        cell_node=cell_node,
        node_children=children,
        patch_type=patch_type,
        patch_corner=np.concatenate([p.corner for p in patches]).astype(np.int8),
        patch_offset=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64),
        patch_points=points,
        type_size=types.size,
        type_levels=types.levels,
        type_offset=types.offset,
        type_strips=types.strips,
        matrices=types.matrices,
        strips=rules.strips,
    )


def only_used(matrix: sp.csr_array, points: Indices) -> tuple[sp.csr_array, Indices]:
    """Drop local points that no patch lists; the control points stay."""
    used = np.zeros(matrix.shape[0], np.bool_)
    used[points] = True
    used[: matrix.shape[1]] = True
    renumber = np.cumsum(used, dtype=np.int32) - np.int32(1)
    return sp.csr_array(matrix[np.flatnonzero(used)]), renumber[points]
