"""Limit points of the vertices of schemes whose vertices stay: as rows over the control points, or of points alone."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.mesh.topology import Topology
from subdfit.schemes._corner_type import CornerType
from subdfit.schemes._level import Level, Piece, semi_sharp, sharp_edges_round
from subdfit.schemes._stencils import VertexMask, mask_points, mask_rows
from subdfit.schemes.scheme import Refinement

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]


@dataclass(frozen=True)
class LimitRules:
    """What a scheme's limit masks are.

    Attributes
    ----------
    smooth : makes the limit masks of smooth vertices of a mesh.
    ring : weights of a corner's vertex and its ring (see `rings`).
    corners : corners of the faces that a ring may have.
    refine : one step of the scheme.
    """

    smooth: Callable[[Topology], VertexMask]
    ring: Callable[[CornerType], Floats]
    corners: int
    refine: Callable[[Topology], Refinement]


def limit_rows(rules: LimitRules, t: Topology, chosen: Rows | None = None) -> sp.csr_array:
    """Limit masks of the chosen vertices (all by default): smooth, crease and boundary 1/6, 4/6, 1/6, corner, dart.

    A vertex whose rules are going to change, and a dart among faces of another size, is refined first with what
    surrounds it.

    Returns
    -------
    csr_array
        (chosen, n).
    """
    weights, dart, waiting = _masks(rules, t)
    matrix, dart = mask_rows(t, weights), dart & ~waiting
    if dart.any():
        matrix = sp.csr_array(matrix + _darts(rules, Level.of(t), dart))
    if chosen is not None:
        matrix, waiting = sp.csr_array(matrix[chosen]), waiting[chosen]
    rows = np.flatnonzero(waiting)
    if len(rows) == 0:
        return matrix
    keep = sp.csr_array(sp.diags_array((~waiting).astype(np.float64)) @ matrix)
    vertices = rows if chosen is None else chosen[rows]
    late = _after_refining(rules, t, vertices)
    place = sp.csr_array((np.ones(len(rows)), (rows, np.arange(len(rows)))), shape=(matrix.shape[0], len(rows)))
    return sp.csr_array(keep + place @ late)


def limit_points(rules: LimitRules, t: Topology, points: Floats) -> Floats:
    """The limit points (n, 3) that `limit_rows` makes of points, with rows only for darts and what is refined first."""
    weights, dart, waiting = _masks(rules, t)
    found = mask_points(t, weights, points)
    rest = np.flatnonzero(dart | waiting)
    if len(rest):
        piece, rows = _piece_round(t, rest)
        found[rest] = limit_rows(rules, piece.topology, rows) @ points[piece.vertices]
    return found


def _other_faces(t: Topology, corners: int) -> NDArray[np.int64]:
    """Number of faces at each vertex that have another number of corners."""
    other = np.diff(t.face_offsets)[t.face] != corners
    return np.bincount(t.face_vertices[other], minlength=t.vertex_count)


def _masks(rules: LimitRules, t: Topology) -> tuple[Floats, NDArray[np.bool_], NDArray[np.bool_]]:
    """Weights (n, 5) of all masks but those of darts, which are zero; darts; and vertices to be refined first, (n,)."""
    count = sharp_edges_round(t, np.isinf(t.sharpness)[t.edge])
    pinned = np.isinf(t.corner_sharpness) | (count >= 3)
    smooth, dart, crease = (~pinned & (count == sharp) for sharp in range(3))
    weights = np.zeros((t.vertex_count, 5))
    for column, weight in enumerate(rules.smooth(t)):
        weights[:, column] = np.where(smooth, weight, 0.0)
    weights[crease, 0], weights[crease, 3] = 4 / 6, 1 / 6
    weights[pinned, 0] = 1.0
    return weights, dart, semi_sharp(t) | dart & (_other_faces(t, rules.corners) > 0)


def _darts(rules: LimitRules, level: Level, darts: NDArray[np.bool_]) -> sp.csr_array:
    """Rows of darts, whose mask is not the smooth one because their sharp edge takes its midpoint."""
    t = level.topology
    rows: list[Rows] = []
    columns: list[list[int]] = []
    values: list[Floats] = []
    for v in np.flatnonzero(darts):
        ring = _ring(level, int(v))
        columns.append(ring)
        rows.append(np.full(len(ring), v))
        values.append(rules.ring(CornerType(int(t.valence[v]), 0, closed=True, dart=True, pinned=False)))
    shape = (t.vertex_count, t.vertex_count)
    return sp.csr_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=shape)


def _ring(level: Level, v: int) -> list[int]:
    """A dart and its ring, counter-clockwise from its sharp edge: neighbours, and far corners of quads, by turns."""
    t = level.topology
    h = level.first[t.outgoing[v]]
    ring = [v]
    for _ in range(int(t.valence[v])):
        far = t.following[t.following[h]]
        ring.append(int(t.face_vertices[t.following[h]]))
        if t.following[far] != h:
            ring.append(int(t.face_vertices[far]))
        h = t.twin[level.preceding[h]]
    return ring


def _after_refining(rules: LimitRules, t: Topology, vertices: Rows) -> sp.csr_array:
    """Limit rows of some vertices, (k, n), taken one level later."""
    piece, row = _piece_round(t, vertices)
    step = rules.refine(piece.topology)
    fine = sp.csr_array(limit_rows(rules, step.child, step.vertex_row[row]) @ step.matrix)
    return sp.csr_array((fine.data, piece.vertices[fine.indices], fine.indptr), shape=(len(vertices), t.vertex_count))


def _piece_round(t: Topology, vertices: Rows) -> tuple[Piece, Rows]:
    """The part of the mesh that surrounds some vertices, and their rows in it."""
    near = np.zeros(t.vertex_count, np.bool_)
    near[vertices] = True
    piece = Piece.round(t, np.unique(t.face[near[t.face_vertices]]).astype(np.int64))
    order = np.argsort(piece.vertices, kind="stable")
    return piece, order[np.searchsorted(piece.vertices, vertices, sorter=order)]
