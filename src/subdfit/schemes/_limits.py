"""Limit points of the vertices of schemes whose vertices stay: as rows over the control points, or of points alone."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.mesh.topology import Topology
from subdfit.schemes._corner_type import CornerType
from subdfit.schemes._level import Level, Piece, semi_sharp, sharp_edges_round
from subdfit.schemes._stencils import VertexMask, mask_points, mask_rows
from subdfit.schemes.scheme import Refinement

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Rows = NDArray[np.int64]


class LimitMasks(NamedTuple):
    """Limit masks of a mesh's vertices.

    Attributes
    ----------
    weights : (n, 5), as in `Stencils.weights`; zero for those that follow.
    ringed : (n,), vertices whose mask tells their neighbours apart.
    waiting : (n,), vertices that have a mask only once they are refined.
    """

    weights: Floats
    ringed: Flags
    waiting: Flags


class LimitRules(Protocol):
    """What a scheme's limit masks are."""

    def masks(self, t: Topology) -> LimitMasks:
        """The masks of a mesh."""
        ...

    def ring_rows(self, level: Level, vertices: Flags) -> sp.csr_array:
        """Rows (n, n) of vertices whose mask tells their neighbours apart; those of others are empty."""
        ...

    @property
    def refine(self) -> Callable[[Topology], Refinement]:
        """One step of the scheme."""
        ...


@dataclass(frozen=True)
class OneShapeLimits:
    """Limit masks that treat neighbours alike but at darts, whose faces must all have one shape.

    Attributes
    ----------
    smooth : makes the limit masks of smooth vertices of a mesh.
    ring : weights of a dart and its ring (see `_ring`).
    corners : corners of the faces that a ring may have.
    refine : one step of the scheme.
    """

    smooth: Callable[[Topology], VertexMask]
    ring: Callable[[CornerType], Floats]
    corners: int
    refine: Callable[[Topology], Refinement]

    def masks(self, t: Topology) -> LimitMasks:
        """Smooth, crease, corner; darts by their rings, among faces of another size once refined."""
        smooth, dart, crease, pinned = vertex_kinds(t)
        weights = curve_weights(crease, pinned)
        for column, weight in enumerate(self.smooth(t)):
            np.copyto(weights[:, column], weight, where=smooth)
        return LimitMasks(weights, dart, semi_sharp(t) | dart & (_other_faces(t, self.corners) > 0))

    def ring_rows(self, level: Level, vertices: Flags) -> sp.csr_array:
        """Rows of darts, whose mask is not the smooth one because their sharp edge takes its midpoint."""
        return _darts(self, level, vertices)


def vertex_kinds(t: Topology) -> tuple[Flags, Flags, Flags, Flags]:
    """Which vertices are smooth, darts, on a crease or the boundary, corners, (n,) each, by what is sharp for ever."""
    count = sharp_edges_round(t, np.isinf(t.sharpness)[t.edge])
    pinned = np.isinf(t.corner_sharpness) | (count >= 3)
    smooth, dart, crease = (~pinned & (count == sharp) for sharp in range(3))
    return smooth, dart, crease, pinned


def curve_weights(crease: Flags, pinned: Flags) -> Floats:
    """Weights (n, 5) of crease and boundary vertices, 1/6, 4/6, 1/6, and of corners."""
    weights = np.zeros((len(crease), 5))
    weights[crease, 0], weights[crease, 3] = 4 / 6, 1 / 6
    weights[pinned, 0] = 1.0
    return weights


def limit_rows(rules: LimitRules, t: Topology, chosen: Rows | None = None) -> sp.csr_array:
    """Limit masks of the chosen vertices (all by default); those that wait are refined first with what surrounds them.

    Returns
    -------
    csr_array
        (chosen, n).
    """
    weights, ringed, waiting = rules.masks(t)
    matrix, ringed = mask_rows(t, weights), ringed & ~waiting
    if ringed.any():
        matrix = sp.csr_array(matrix + rules.ring_rows(Level.of(t), ringed))
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
    """The limit points (n, 3) that `limit_rows` makes of points, with rows only where a mask is not enough."""
    weights, ringed, waiting = rules.masks(t)
    found = mask_points(t, weights, points)
    rest = np.flatnonzero(ringed | waiting)
    if len(rest):
        piece, rows = _piece_round(t, rest)
        found[rest] = limit_rows(rules, piece.topology, rows) @ points[piece.vertices]
    return found


def _other_faces(t: Topology, corners: int) -> NDArray[np.int64]:
    """Number of faces at each vertex that have another number of corners."""
    other = np.diff(t.face_offsets)[t.face] != corners
    return np.bincount(t.face_vertices[other], minlength=t.vertex_count)


def _darts(rules: OneShapeLimits, level: Level, darts: Flags) -> sp.csr_array:
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
