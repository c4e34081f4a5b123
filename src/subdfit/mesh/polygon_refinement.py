"""Local refinement of polygon meshes: sides are halved, and the faces beside them cut so that quads stay quads.

A vertex that halves a side of a quad makes it a pentagon. When that pentagon is cut itself it counts as the quad it
was, with a side that is halved already. So a face is cut according to which of its sides, corner to corner, are halved:

| sides | halved | becomes |
|---|---|---|
| 4 | 1 | a pentagon |
| 4 | 2 opposite | 2 quads |
| 4 | 2 adjacent | 3 quads round a new vertex |
| 4 | 3 | a quad and a pentagon |
| 4 | 4 | 4 quads round a new vertex |
| 3 | 1, 2, 3 | 2 triangles; a triangle and a quad; 3 quads round a new vertex |
| n | all | n quads round a new vertex |

For schemes that take triangles and quads alone, pentagons become a triangle and a quad, and a triangle four.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from subdfit.errors import InputError
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]
Flags = NDArray[np.bool_]
Slots = tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Refined:
    """A control mesh some of whose faces were cut.

    Old vertices keep their rows; those that halve edges follow, then those in the middle of faces. The new faces stand
    in the order of the old ones they are parts of.

    Attributes
    ----------
    mesh : the finer mesh; new vertices lie in the middle of their edge's ends or their face's corners.
    halved : (k,) int64, one half-edge of the old mesh for each new vertex on an edge.
    centred : (c,) int64, the old face of each new vertex inside one.
    parent : (f,) int64, the old face that each new one is a part of.
    """

    mesh: ControlMesh
    halved: Rows
    centred: Rows
    parent: Rows


@dataclass(frozen=True, eq=False)
class Sides:
    """Faces with the same number k of sides, corner to corner.

    Attributes
    ----------
    faces : (m,); first (m, k) the half-edge at which each side begins; second (m, k) the half-edge from the vertex that
        halves it already, -1 for none.
    """

    faces: Rows
    first: Rows
    second: Rows

    @property
    def count(self) -> int:
        """Sides of each face."""
        return int(self.first.shape[1])

    @property
    def halved(self) -> Flags:
        """Sides that are halved already, (m, k)."""
        return np.asarray(self.second >= 0)

    def split(self, marked: Flags) -> Flags:
        """Sides that are halved now or are to be, (m, k)."""
        return np.asarray(self.halved | marked[self.first])


def refine_polygons(mesh: ControlMesh, marked: ArrayLike, polygons: bool = True) -> Refined:
    """Halve marked sides, and what else is needed, and cut the faces beside them.

    No vertex is set into half a side of a face that stays whole: such a face is cut to the opposite side first. From
    the middle of every edge inside the mesh a cut begins on one side at least, so that no inner vertex has two faces.
    Faces of five sides or more are cut at all of them.

    Parameters
    ----------
    mesh
        Any polygons.
    marked
        (h,) bool, half-edges to halve; an edge is halved if one of its two is marked.
    polygons
        Whether faces may have more than four corners; else all are triangles and quads.

    Raises
    ------
    InputError
        Marks that do not fit the mesh, or a face of five corners and more where there may be none.
    """
    t = mesh.topology
    chosen = np.asarray(marked)
    if chosen.dtype != np.bool_ or chosen.shape != t.face_vertices.shape:
        raise InputError(f"marks come in shape {chosen.shape}; give one bool for each of {len(t.twin)} half-edges")
    sizes = np.diff(t.face_offsets)
    if not polygons and np.any(sizes > 4):
        face = int(np.argmax(sizes > 4))
        raise InputError(f"face {face} has {sizes[face]} corners; cut it into triangles and quads first")
    groups = list(faces_by_sides(t, flat_corners(mesh)))
    halves = _balanced(t, groups, chosen, polygons)
    halved = np.flatnonzero(halves & ((t.twin < 0) | (np.arange(len(t.twin)) < t.twin)))
    middle = np.full(len(t.twin), -1, np.int64)
    middle[halved] = t.vertex_count + np.arange(len(halved))
    inside = halved[t.twin[halved] >= 0]
    middle[t.twin[inside]] = middle[inside]
    return _assembled(mesh, groups, halves, middle, halved, polygons)


def flat_corners(mesh: ControlMesh) -> Flags:
    """Face corners within a side, (h,): in faces of five and more the flattest, no two in a row, until four stay.

    No edge is half a side on both sides of it: then one of its faces keeps all of its corners.
    """
    t = mesh.topology
    sizes = np.diff(t.face_offsets)
    flat = np.zeros(len(t.twin), np.bool_)
    for size in np.unique(sizes[sizes > 4]):
        corner = t.face_offsets[:-1][sizes == size][:, None] + np.arange(size)
        angle = corner_angles(mesh.points[t.face_vertices[corner]])
        for _ in range(size - 4):
            rows, best = np.arange(len(angle)), angle.argmax(axis=1)
            flat[corner[rows, best]] |= angle[rows, best] > 0
            for near in (-1, 0, 1):
                angle[rows, (best + near) % size] = -1.0
    half = flat | flat[t.following]
    doubtful = half & (t.twin >= 0) & half[t.twin] & (np.arange(len(half)) < t.twin)
    return flat & ~np.isin(t.face, t.face[doubtful])


def corner_angles(ring: Floats) -> Floats:
    """Angles of polygons (m, n, 3) at their corners."""
    ahead, behind = np.roll(ring, -1, axis=1) - ring, np.roll(ring, 1, axis=1) - ring
    area = np.linalg.norm(np.cross(ahead, behind), axis=2)
    return np.asarray(np.arctan2(area, np.einsum("mnd,mnd->mn", ahead, behind)))


def faces_by_sides(t: Topology, flat: Flags) -> Iterator[Sides]:
    """Faces grouped by how many sides they have, corner to corner."""
    corner = np.flatnonzero(~flat)
    count = np.bincount(t.face[corner], minlength=t.face_count)
    for sides in np.unique(count):
        faces = np.flatnonzero(count == sides)
        first = corner[count[t.face[corner]] == sides].reshape(-1, sides)
        following = t.following[first].astype(np.int64)
        yield Sides(faces, first, np.where(flat[following], following, -1))


def _balanced(t: Topology, groups: list[Sides], chosen: Flags, polygons: bool) -> Flags:
    """Both half-edges of all edges to halve."""
    marked, before = chosen.copy(), -1
    while (count := int(np.count_nonzero(marked))) != before:
        before = count
        marked[t.twin[marked & (t.twin >= 0)]] = True
        loose = _loose(t, groups, marked) if polygons else np.zeros_like(marked)
        for group in groups:
            marked[group.first[_needed(group, marked, loose)]] = True
    return marked


def _loose(t: Topology, groups: list[Sides], marked: Flags) -> Flags:
    """Half-edges whose middle would join two edges only, no cut beginning there on either side; one of each edge."""
    uncut, deep = np.zeros(len(marked), np.bool_), np.zeros(len(marked), np.bool_)
    for group in groups:
        halved, split = group.halved, group.split(marked)
        deep[group.first[halved]] = deep[group.second[halved]] = True
        if group.count == 4:
            count = split.sum(axis=1)[:, None]
            uncut[group.first[split & ((count == 1) | ((count == 3) & np.roll(~split, 2, axis=1)))]] = True
    uncut |= deep
    both = marked & uncut & (t.twin >= 0) & uncut[t.twin]
    return both & ~deep & (deep[t.twin] | (np.arange(len(marked)) < t.twin))


def _needed(group: Sides, marked: Flags, loose: Flags) -> Flags:
    """Further sides to halve, (m, k).

    Where half a side is to be halved, the face must be cut at that side; and at a side whose middle is loose.
    """
    halved, split = group.halved, group.split(marked)
    deep = halved & (marked[group.first] | marked[group.second])
    count = np.sum(split, axis=1, keepdims=True)
    if group.count == 4:
        must = deep | (loose[group.first] & ~halved)
        opposite = np.roll(must, 2, axis=1) & (count == 1)
        wanted = opposite | (np.any(must, axis=1, keepdims=True) & (count == 3))
    else:
        touched = np.any(deep | (split & ~halved), axis=1, keepdims=True) & (group.count > 4)
        wanted = np.broadcast_to(touched, split.shape)
    return np.asarray(wanted & ~halved)


def _assembled(
    mesh: ControlMesh, groups: list[Sides], marked: Flags, middle: Rows, halved: Rows, polygons: bool
) -> Refined:
    t = mesh.topology
    cuts = [(group, *cut) for group in groups for cut in _cuts(group, marked, polygons)]
    with_centre = [group.faces[rows] for group, rows, parts in cuts if any(2 * group.count in p for p in parts)]
    centred = np.sort(np.concatenate([np.empty(0, np.int64), *with_centre]))
    centre = np.full(t.face_count, -1, np.int64)
    centre[centred] = t.vertex_count + len(halved) + np.arange(len(centred))
    face: list[Rows] = []
    corners: list[Rows] = []
    width = 4 * int(np.diff(t.face_offsets).max(initial=0)) + 2
    for group, rows, parts in cuts:
        for part in parts:
            ring = _ring(t, group, rows, part, middle, centre)
            face.append(group.faces[rows])
            corners.append(np.pad(ring, ((0, 0), (0, width - ring.shape[1])), constant_values=-1))
    parent = np.concatenate(face)
    order = np.argsort(parent, kind="stable")
    rows = np.concatenate(corners)[order]
    offsets = np.concatenate([[0], np.cumsum((rows >= 0).sum(axis=1))])
    finer = _tagged(mesh, halved, centred, groups, offsets, rows[rows >= 0])
    return Refined(finer, halved, centred, parent[order])


def _cuts(group: Sides, marked: Flags, polygons: bool) -> Iterator[tuple[Rows, list[Slots]]]:
    """Rows of the group that are cut alike, and how."""
    split = group.split(marked)
    patterns, which = np.unique(split, axis=0, return_inverse=True)
    for k, pattern in enumerate(patterns):
        yield np.flatnonzero(which == k), template(tuple(pattern.tolist()), polygons)


def template(split: tuple[bool, ...], polygons: bool) -> list[Slots]:
    """How a face is cut whose sides are halved where `split` says.

    Parts are listed by slots: ``2 i`` is corner i, ``2 i + 1`` the middle of the side after it, ``2 k`` the centre.
    """
    k = len(split)
    ring = tuple(s for s in range(2 * k) if s % 2 == 0 or split[s // 2])
    cut = [2 * i + 1 for i in range(k) if split[i]]
    count = len(cut)
    whole = count == 0 or (polygons and k == 4 and count == 1) or (k > 4 and count < k)
    if whole:
        return [ring]
    if count == k and (polygons or k > 3):
        return _fan(ring, 2 * k, cut)
    if k == 3:
        return _triangle_cut(ring, cut)
    return _quad_cut(ring, cut, polygons)


def _triangle_cut(ring: Slots, cut: list[int]) -> list[Slots]:
    if len(cut) == 1:
        return _chord(ring, cut[0], (cut[0] + 3) % 6)
    if len(cut) == 2:
        return _chord(ring, cut[0], cut[1])
    return [(1, 2, 3), (3, 4, 5), (5, 0, 1), (1, 3, 5)]


def _quad_cut(ring: Slots, cut: list[int], polygons: bool) -> list[Slots]:
    if len(cut) == 1:
        return _chord(ring, cut[0], (cut[0] + 3) % 8)
    if len(cut) == 2:
        if (cut[1] - cut[0]) == 4:
            return _chord(ring, cut[0], cut[1])
        before = cut[0] if (cut[1] - cut[0]) == 2 else cut[1]
        return _fan(ring, 8, [before, (before + 2) % 8, (before + 5) % 8])
    free = next(s for s in (1, 3, 5, 7) if s not in cut)
    first, second, third = ((free + d) % 8 for d in (2, 4, 6))
    quad, pentagon = _chord(ring, third, first)
    return [quad, pentagon] if polygons else [quad, *_chord(pentagon, first, second)]


def _arc(ring: Slots, start: int, stop: int) -> Slots:
    """The part of a ring from one slot to another."""
    i, j = ring.index(start), ring.index(stop)
    return ring[i : j + 1] if i < j else ring[i:] + ring[: j + 1]


def _chord(ring: Slots, a: int, b: int) -> list[Slots]:
    return [_arc(ring, a, b), _arc(ring, b, a)]


def _fan(ring: Slots, centre: int, spokes: list[int]) -> list[Slots]:
    return [(centre, *_arc(ring, a, b)) for a, b in zip(spokes, spokes[1:] + spokes[:1], strict=True)]


def _ring(t: Topology, group: Sides, rows: Rows, part: Slots, middle: Rows, centre: Rows) -> Rows:
    """Vertices of one part, (r, 2 len(part)): after each the one that halves its side again, or -1."""
    first, second = group.first[rows], group.second[rows]
    halved = second >= 0
    count = 2 * group.count
    slot = np.empty((len(rows), count + 1), np.int64)
    slot[:, 0:count:2] = t.face_vertices[first]
    slot[:, 1:count:2] = np.where(halved, t.face_vertices[second], middle[first])
    slot[:, count] = centre[group.faces[rows]]
    deep = np.full((len(rows), count), -1, np.int64)
    deep[:, 0::2] = np.where(halved, middle[first], -1)
    deep[:, 1::2] = np.where(halved, middle[second], -1)
    out = np.full((len(rows), len(part), 2), -1, np.int64)
    for i, s in enumerate(part):
        out[:, i, 0] = slot[:, s]
        if s < count and part[(i + 1) % len(part)] == (s + 1) % count:
            out[:, i, 1] = deep[:, s]
    return out.reshape(len(rows), -1)


def _tagged(
    mesh: ControlMesh, halved: Rows, centred: Rows, groups: list[Sides], offsets: Rows, vertices: Rows
) -> ControlMesh:
    """The finer mesh with creases on both halves of their edges."""
    t, data = mesh.topology, mesh.to_data()
    ends = np.column_stack([t.face_vertices[halved], t.face_vertices[t.following[halved]]])
    new = t.vertex_count + np.arange(len(halved))
    at = np.full(t.edge_count, -1, np.int64)
    at[t.edge[halved]] = new
    cut = at[t.crease_edges]
    a, b = data.crease_edges.T
    pieces = [np.column_stack([a, np.where(cut < 0, b, cut)]), np.column_stack([cut, b])[cut >= 0]]
    centres = np.empty((t.face_count, 3))
    for group in groups:
        centres[group.faces] = mesh.points[t.face_vertices[group.first]].mean(axis=1)
    return ControlMesh.from_data(
        replace(
            data,
            points=np.concatenate([mesh.points, mesh.points[ends].mean(axis=1), centres[centred]]),
            face_offsets=offsets,
            face_vertices=vertices,
            crease_edges=np.concatenate(pieces),
            crease_sharpness=np.concatenate([data.crease_sharpness, data.crease_sharpness[cut >= 0]]),
        )
    )
