"""Patches over triangles and quads: their points, and which of their surroundings these are.

The points of kinds of patches are read off examples: small meshes that hold one patch each, side by side.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subdfit.mesh.topology import Topology
from subdfit.schemes import _quad_triangle_kernels as kernels
from subdfit.schemes._level import Level
from subdfit.schemes._quad_triangle_kinds import Corner, Kind, Regular, Strip, groups, larger_faces
from subdfit.schemes._quad_triangle_rules import refine
from subdfit.schemes._type_store import Kept

Indices = NDArray[np.int32]
Rows = NDArray[np.int64]

KINDS = 2**13
"""Kinds whose selections are kept."""


class Points(NamedTuple):
    """Points of patches, ragged.

    Attributes
    ----------
    start : (k + 1,) where each patch's begin.
    corners : (p, 3) int32, vertices a, b, c for the point a + b - c; b and c are -1 for the vertex a.
    """

    start: Rows
    corners: Indices


def list_points(level: Level, kinds: Sequence[Kind], which: Rows, half_edges: Rows) -> Points:
    """Points of patches, given by the half-edges (k,) that leave their first corners, and rows (k,) of their kinds.

    The first corner comes first, then its ring, which begins with the face's other corners where it goes all round,
    then what the rings of the other corners add.
    """
    found = _surroundings(level, half_edges)
    selections = _SELECTIONS.of(kinds)
    length = np.array([len(chosen) for chosen in selections], np.int64)
    sizes = length[which]
    start = np.concatenate([[0], np.cumsum(sizes)])
    within = np.arange(start[-1]) - np.repeat(start[:-1], sizes)
    chosen = np.concatenate([np.empty(0, np.int64), *selections])
    place = chosen[np.repeat((np.cumsum(length) - length)[which], sizes) + within]
    return Points(start, found.corners[np.repeat(found.start[:-1], sizes) + place])


def _surroundings(level: Level, half_edges: Rows) -> Points:
    """First corners of patches and the rings of all corners, one after the other."""
    t = level.topology
    at = [half_edges]
    for _ in range(3):
        at.append(t.following[at[-1]].astype(np.int64))
    heads = np.stack(at, axis=1)
    sizes = np.ones((len(heads), 5), np.int64)
    sizes[:, 1:] = ring_sizes(level)[heads]
    sizes[heads[:, 3] == half_edges, 4] = 0
    ends = np.cumsum(sizes)
    begin = ends.reshape(sizes.shape) - sizes
    present = sizes[:, 1:] > 0
    corners = rings(level, heads[present], begin[:, 1:][present], sizes[:, 1:][present], int(sizes.sum()))
    corners[begin[:, 0], 0] = t.face_vertices[half_edges]
    return Points(np.append(begin[:, 0], len(corners)), corners)


def ring_sizes(level: Level) -> Rows:
    """Points of the rings round the origins of half-edges, (h,)."""
    t = level.topology
    larger = larger_faces(t)
    quads = np.bincount(level.first, larger, len(level.first)).astype(np.int64)[level.first]
    sizes = level.faces + quads + (level.sharp_count[t.face_vertices] > 1)
    return np.where(level.regular, np.where(larger, 8, 6), sizes)


def rings(level: Level, half_edges: Rows, begin: Rows, sizes: Rows, total: int) -> Indices:
    """Rings round the origins of half-edges (k,) at rows `begin` (k,) of an array (total, 3); see `kernels.rings`."""
    t = level.topology
    found: Indices = kernels.rings(
        half_edges,
        begin,
        sizes,
        total,
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
    return found


def _selections(kinds: list[Kind]) -> list[Rows]:
    """Which of the surroundings of patches of each kind are its points.

    Each point counts once; beside an irregular corner there are no mirror points.
    """
    level, half_edges = examples(kinds)
    found = _surroundings(level, half_edges)
    first = np.zeros(len(found.corners), np.bool_)
    first[np.unique(found.corners, axis=0, return_index=True)[1]] = True
    corner = np.array([isinstance(kind, Corner) for kind in kinds])
    first &= (found.corners[:, 1] < 0) | ~np.repeat(corner, np.diff(found.start))
    return [np.flatnonzero(first[begin:end]) for begin, end in pairwise(found.start)]


_SELECTIONS = Kept(_selections, KINDS)


def patch_size(kind: Kind) -> int:
    """Points of a patch."""
    return len(_SELECTIONS.of([kind])[0])


class Examples(NamedTuple):
    """Patches side by side, each in a small mesh of its own: the half-edges (k,) that leave their first corners."""

    level: Level
    half_edges: Rows


class _Mesh(NamedTuple):
    """Faces; a crease and a corner vertex, if any; the face that is a patch of a kind once the mesh is refined."""

    faces: list[list[int]]
    crease: list[list[int]]
    corner: list[int]
    patch: int


def examples(kinds: Sequence[Kind]) -> Examples:
    """A patch of each kind."""
    faces: list[list[int]] = []
    creases: list[list[int]] = []
    corners: list[int] = []
    patches, count = [], 0
    for kind in kinds:
        mesh = _example_mesh(kind)
        patches.append(4 * len(faces) + mesh.patch)
        faces += [[count + v for v in face] for face in mesh.faces]
        creases += [[count + v for v in edge] for edge in mesh.crease]
        corners += [count + v for v in mesh.corner]
        count += 1 + max(map(max, mesh.faces))
    topology = Topology.from_faces(
        np.cumsum([0, *map(len, faces)]), np.concatenate(faces), count, creases or None, corner_vertices=corners or None
    )
    level = Level.of(refine(topology).child)
    half_edges = np.full(len(kinds), -1, np.int64)
    for group in groups(level, np.array(patches)):
        assert all(kinds[row] == group.kind for row in group.rows)
        half_edges[group.rows] = group.half_edges
    assert (half_edges >= 0).all()
    return Examples(level, half_edges)


def _example_mesh(kind: Kind) -> _Mesh:
    match kind:
        case Corner():
            return _fan(kind)
        case Regular():
            order = "TTTTTT" if kind.size == 3 else "QQQQ"
        case Strip(3, touching) if touching:
            return _beside_triangle(touching)
        case _:
            order = "TTTQQ" if kind.size == 3 else "QQTTT"
    return _fan(Corner(order, 0, closed=True, dart=False, pinned=False))


def _fan(kind: Corner) -> _Mesh:
    """Faces round vertex 0 with its tags; edge i of them ends in vertex 1 + i."""
    edges = len(kind.order) + (not kind.closed)
    faces, count = [], 1 + edges
    for i, letter in enumerate(kind.order):
        first, last = 1 + i, 1 + (i + 1) % edges
        faces.append([0, first, last] if letter == "T" else [0, first, count, last])
        count += letter == "Q"
    return _Mesh(faces, [[0, 1]] if kind.dart else [], [0] if kind.pinned else [], 4 * kind.position)


def _beside_triangle(quads: int) -> _Mesh:
    """A triangle with quads beyond its first sides, triangles beyond the others; its middle child is the patch."""
    faces, count = [[0, 1, 2]], 3
    for side in range(3):
        new = 2 if side < quads else 1
        faces.append([(side + 1) % 3, side, *range(count, count + new)])
        count += new
    return _Mesh(faces, [], [], 3)
