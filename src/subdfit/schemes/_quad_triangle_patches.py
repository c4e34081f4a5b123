"""Patches over triangles and quads: their points, and what one step of subdivision makes of them.

The step is read off the scheme itself: a small mesh that holds a patch of the kind is refined, and the patches of its
children are listed as any others are.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subdfit.mesh.topology import Topology
from subdfit.schemes import _quad_triangle_kernels as kernels
from subdfit.schemes._level import Level
from subdfit.schemes._loop_types import box_spline
from subdfit.schemes._quad_patches import bicubic_basis
from subdfit.schemes._quad_triangle_kinds import Corner, Kind, Regular, Strip, groups
from subdfit.schemes._quad_triangle_rules import refine
from subdfit.schemes.scheme import Refinement

Indices = NDArray[np.int32]
Rows = NDArray[np.int64]
Matrix = NDArray[np.float64]


class Example(NamedTuple):
    """A small mesh with a patch of one kind, and the half-edge that leaves the patch's first corner."""

    level: Level
    half_edge: int


class Part(NamedTuple):
    """A quarter of a patch after one step.

    `turn` is the corner of the quarter at which its own patch begins; `matrix` takes the patch's points to its points.
    """

    kind: Kind
    turn: int
    matrix: Matrix


def list_points(level: Level, kind: Kind, half_edges: Rows) -> Indices:
    """Points of patches of one kind, given by the half-edges (k,) that leave their first corners.

    The first corner comes first, then its ring, which begins with the face's other corners where it goes all round,
    then what the rings of the other corners add.

    Returns
    -------
    ndarray
        (k, size, 3): vertices a, b, c for the point a + b - c; b and c are -1 for the vertex a.
    """
    return _surroundings(level, kind.size, half_edges)[:, _selection(kind)]


def _surroundings(level: Level, corners: int, half_edges: Rows) -> Indices:
    """First corners and the rings of all corners, one after the other, (k, s, 3)."""
    t, h = level.topology, half_edges
    origin = np.full((len(h), 1, 3), -1, np.int32)
    origin[:, 0, 0] = t.face_vertices[h]
    found = [origin]
    for _ in range(corners):
        found.append(corner_rings(level, h))
        h = t.following[h].astype(np.int64)
    return np.concatenate(found, axis=1)


def corner_rings(level: Level, half_edges: Indices | Rows) -> Indices:
    """Rings round the origins of half-edges (k,) whose sectors are alike, (k, r, 3); see `kernels.rings`."""
    t = level.topology
    size = _ring_size(level, int(half_edges[0])) if len(half_edges) else 0
    found: Indices = kernels.rings(
        half_edges.astype(np.int64),
        size * np.arange(len(half_edges) + 1),
        t.face_offsets,
        t.face_vertices,
        t.following,
        level.preceding,
        t.face,
        t.twin,
        level.sharp_count,
        level.first,
        level.faces,
        level.position,
        level.regular,
    )
    return found.reshape(len(half_edges), size, 3)


def _ring_size(level: Level, half_edge: int) -> int:
    """Points of the ring round the origin of a half-edge."""
    t = level.topology
    if level.regular[half_edge]:
        return 8 if _corners(t, half_edge) == 4 else 6
    size, h = int(level.sharp_count[t.face_vertices[half_edge]] > 1), level.first[half_edge]
    for _ in range(level.faces[half_edge]):
        size += 1 if _corners(t, h) == 3 else 2
        h = t.twin[level.preceding[h]]
    return size


def _corners(t: Topology, half_edge: int) -> int:
    face = t.face[half_edge]
    return int(t.face_offsets[face + 1] - t.face_offsets[face])


@cache
def _selection(kind: Kind) -> Rows:
    """Which of a patch's surroundings are its points: each once; beside an irregular corner no mirror points."""
    level, half_edge = example(kind)
    points = _surroundings(level, kind.size, np.array([half_edge]))[0]
    chosen = np.sort(np.unique(points, axis=0, return_index=True)[1])
    return chosen[points[chosen, 1] < 0] if isinstance(kind, Corner) else chosen


@cache
def example(kind: Kind) -> Example:
    """A patch of a kind."""
    topology, face = _example_mesh(kind)
    level = Level.of(refine(topology).child)
    (found,) = groups(level, np.array([face]))
    assert found.kind == kind
    return Example(level, int(found.half_edges[0]))


def _example_mesh(kind: Kind) -> tuple[Topology, int]:
    """A mesh which, once refined, has a patch of a kind, and the face of the refined mesh that is it."""
    match kind:
        case Corner():
            return fan(kind), 4 * kind.position
        case Regular():
            order = "TTTTTT" if kind.size == 3 else "QQQQ"
        case Strip(3, touching) if touching:
            return _beside_triangle(touching), 3
        case _:
            order = "TTTQQ" if kind.size == 3 else "QQTTT"
    return fan(Corner(order, 0, closed=True, dart=False, pinned=False)), 0


def fan(kind: Corner) -> Topology:
    """Faces round vertex 0 with its tags; edge i of them ends in vertex 1 + i."""
    faces = len(kind.order)
    edges = faces if kind.closed else faces + 1
    far = 1 + edges + np.cumsum([letter == "Q" for letter in kind.order]) - 1
    corners = []
    for i, letter in enumerate(kind.order):
        ends = 1 + i, 1 + (i + 1) % edges
        corners.append([0, *ends] if letter == "T" else [0, ends[0], int(far[i]), ends[1]])
    return Topology.from_faces(
        np.cumsum([0, *map(len, corners)]),
        np.concatenate(corners),
        1 + edges + kind.order.count("Q"),
        crease_edges=[[0, 1]] if kind.dart else None,
        corner_vertices=[0] if kind.pinned else None,
    )


def _beside_triangle(quads: int) -> Topology:
    """A triangle with quads beyond its first sides, triangles beyond the others."""
    corners, count = [[0, 1, 2]], 3
    for side in range(3):
        new = 2 if side < quads else 1
        corners.append([(side + 1) % 3, side, *range(count, count + new)])
        count += new
    return Topology.from_faces(np.cumsum([0, *map(len, corners)]), np.concatenate(corners), count)


@cache
def parts(kind: Kind, turn: int = 0) -> list[Part]:
    """The quarters of a patch, in the order of the parts of its cell, at whose corner `turn` it begins."""
    level, half_edge = example(kind)
    points = list_points(level, kind, np.array([half_edge]))[0]
    step = refine(level.topology)
    fine, size = Level.of(step.child), kind.size
    weights = _rows(step, level.topology.vertex_count)
    face = int(level.topology.face[half_edge])
    corner = (half_edge - int(level.topology.face_offsets[face]) - turn) % size
    children = 4 * face + np.array([3 if i == 3 and size == 3 else (corner + i) % size for i in range(4)])
    found: dict[int, Part] = {}
    for group in groups(fine, children):
        for i, first in zip(group.rows, group.half_edges, strict=True):
            # Where the quarter's own parameters begin; a triangle's children keep its order.
            begin = int(fine.topology.face_offsets[children[i]]) + (corner if size == 3 else -i % size)
            # A regular patch may begin at any corner.
            half_edge = begin if isinstance(group.kind, Regular) else int(first)
            matrix = _part_matrix(fine, group.kind, half_edge, points[:, 0], weights)
            found[int(i)] = Part(group.kind, int(half_edge - begin) % size, matrix)
    return [found[i] for i in range(4)]


def _rows(step: Refinement, vertices: int) -> Matrix:
    """The matrix of a step, dense: what becomes of unit points, three columns at a time."""
    unit = np.eye(vertices, vertices + -vertices % 3)
    columns = [step.refined(unit[:, k : k + 3]) for k in range(0, unit.shape[1], 3)]
    return np.concatenate(columns, axis=1)[:, :vertices]


def _part_matrix(fine: Level, kind: Kind, half_edge: int, columns: Indices, weights: Matrix) -> Matrix:
    """Points of a patch of the refined mesh, from the vertices `columns` of the mesh."""
    a, b, c = list_points(fine, kind, np.array([half_edge]))[0].T
    rows = weights[a] + np.where(b >= 0, 1.0, 0.0)[:, None] * (weights[b] - weights[c])
    matrix: Matrix = rows[:, columns]
    assert np.allclose(matrix.sum(axis=1), 1), "a patch depends on its own points only"
    return matrix


@cache
def polynomials(size: int) -> Matrix:
    """Polynomials of a regular patch over a face of so many corners, (STRIDE, points)."""
    return bicubic_basis() if size == 4 else box_spline()[:, [*range(7), 9, 8, 7, 10, 11]]
