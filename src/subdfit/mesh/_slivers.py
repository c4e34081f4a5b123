"""Faces without area taken out of a surface, without tearing it where that can be helped.

A face with two corners at one place is closed by collapsing the edge between them, which must leave one fan
round the vertex (the link condition: Dey, Edelsbrunner, Guha, Nekhayev, "Topology preserving edge contraction",
1999). A face whose corners lie on a line is given to the neighbour across its longest edge: a triangle takes it in by
a flip, a polygon as one more corner. What allows neither is dropped.
"""

from collections import defaultdict
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from subdfit.mesh._polygons import Indices, Polygons

_ROUNDS = 12
_FLATNESS = 16 * np.finfo(np.float64).eps
"""Height of a face without area, over the largest coordinate of its corners: what rounding alone can cause."""


def without_area(faces: Polygons, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Mark the faces, (m,), that are no higher over their longest edge than coordinates can resolve.

    A polygon is judged by the triangles of its fan from its first corner.
    """
    unit = points / max(float(np.abs(points).max()), np.finfo(np.float64).tiny)
    x, y, z = np.ascontiguousarray(unit.T)
    reach = np.maximum(np.maximum(np.abs(x), np.abs(y)), np.abs(z))
    flat = np.zeros(faces.count, np.bool_)
    for rows, corners in faces.by_size():
        level = np.ones(len(rows), np.bool_)
        for i in range(1, corners.shape[1] - 1):
            a, b, c = corners[:, 0], corners[:, i], corners[:, i + 1]
            u, v = [axis[b] - axis[a] for axis in (x, y, z)], [axis[c] - axis[a] for axis in (x, y, z)]
            w = [q - p for p, q in zip(u, v, strict=True)]
            longest = np.maximum(np.maximum(_square(u), _square(v)), _square(w))
            area = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
            height = _FLATNESS * np.maximum(np.maximum(reach[a], reach[b]), reach[c])
            level &= _square(area) <= height * height * longest
        flat[rows] = level
    return flat


def _square(vector: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    x, y, z = vector
    return x * x + y * y + z * z


def remove_slivers(
    faces: Polygons, points: NDArray[np.float64], flat: NDArray[np.bool_]
) -> tuple[Polygons, Indices, tuple[int, int, int]]:
    """Take out the `flat` faces, and those that this makes, a few rounds long; then drop what is left.

    Returns
    -------
    faces : no face without area is left.
    merged : (n,) the vertex that each vertex was collapsed into, itself as a rule.
    counts : edges collapsed, faces given to a neighbour, faces dropped.
    """
    merged = np.arange(len(points))
    collapsed = given = 0
    for _ in range(_ROUNDS):
        patch = _cut_out(faces, points, flat)
        for face in np.flatnonzero(flat).tolist():
            patch.close(face)
        if not patch.touched:
            break
        for gone, into in patch.collapses.items():
            merged[gone] = into
        collapsed, given = collapsed + len(patch.collapses), given + patch.given
        faces = _paste(faces, patch)
        flat = without_area(faces, points)
        if not flat.any():
            break
    while (merged != merged[merged]).any():
        merged = merged[merged]
    return faces.select(~flat), merged, (collapsed, given, int(np.count_nonzero(flat)))


@dataclass
class _Patch:
    """The faces round the corners of flat ones, open to edits.

    `around` is complete for the corners of flat faces alone; edits ask it about no other vertex.
    """

    faces: dict[int, list[int]]
    around: dict[int, set[int]]
    positions: dict[int, NDArray[np.float64]]
    fresh: int
    touched: set[int] = field(default_factory=set)
    collapses: dict[int, int] = field(default_factory=dict)
    given: int = 0

    def close(self, face: int) -> None:
        """Take out one flat face by the gentlest edit that works, or leave it."""
        corners = self.faces.get(face)
        if corners is None:
            return
        sides = list(pairwise([*corners, corners[0]]))
        lengths = [float(np.linalg.norm(self.positions[a] - self.positions[b])) for a, b in sides]
        scale = max(float(np.abs(self.positions[v]).max()) for v in corners)
        for length, (a, b) in sorted(zip(lengths, sides, strict=True)):
            if length > _FLATNESS * scale or self._collapse(min(a, b), max(a, b)):
                break
        if face not in self.faces or self.faces[face] is not corners:
            return
        if len(corners) > 3:
            self._cut_to_triangles(face)
        elif min(lengths) > _FLATNESS * scale:
            a, b = sides[lengths.index(max(lengths))]
            self._give(face, a, b, sum(corners) - a - b)

    def _collapse(self, kept: int, gone: int) -> bool:
        """Close the edge between two vertices unless that joins or pinches sheets."""
        changed = {f: _without_repeats([kept if v == gone else v for v in self.faces[f]]) for f in self.around[gone]}
        if any(len(set(corners)) < len(corners) for corners in changed.values()):
            return False
        fans = [_fan_count([self.faces[f] for f in self.around[v]], v) for v in (kept, gone)]
        left = {f: corners for f, corners in changed.items() if len(corners) > 2}
        after = _fan_count([*left.values(), *(self.faces[f] for f in self.around[kept] - changed.keys())], kept)
        if min(*fans, after) < 0 or after > sum(fans) - 1:
            return False
        for f, corners in changed.items():
            self._replace(f, [corners] if len(corners) > 2 else [])
        self.collapses[gone] = kept
        return True

    def _give(self, face: int, a: int, b: int, middle: int) -> bool:
        """Let the face across edge a b take in a flat triangle as the corner `middle`."""
        takers = [f for f in self.around[a] & self.around[b] if f != face and {a, b} in _sides(self.faces[f])]
        if len(takers) > 1 or any(middle in self.faces[f] for f in takers):
            return False
        result: list[list[int]] = []
        if takers:
            corners = self.faces[takers[0]]
            at = next(i for i, side in enumerate(_sides(corners)) if side == {a, b}) + 1
            corners = [middle, *corners[at:], *corners[:at]]
            result = [corners]
            if len(corners) == 4:
                apex = corners[2]
                if any({middle, apex} in _sides(self.faces[f]) for f in self.around[middle]):
                    return False
                result = [[middle, corners[1], apex], [middle, apex, corners[3]]]
            self._replace(takers[0], result)
        self._replace(face, [])
        self.given += 1
        return True

    def _cut_to_triangles(self, face: int) -> None:
        """Cut a flat polygon into the triangles of a fan whose diagonals are no edges yet."""
        corners = self.faces[face]
        present = {side for v in corners for f in self.around[v] for side in _sides(self.faces[f])}
        for apex in range(len(corners)):
            turned = [*corners[apex:], *corners[:apex]]
            if not any(frozenset((turned[0], v)) in present for v in turned[2:-1]):
                self._replace(face, [[turned[0], b, c] for b, c in pairwise(turned[1:])])
                return

    def _replace(self, face: int, by: list[list[int]]) -> None:
        for v in self.faces.pop(face):
            self.around[v].discard(face)
        self.touched.add(face)
        for corners in by:
            self.faces[self.fresh] = corners
            for v in corners:
                self.around[v].add(self.fresh)
            self.touched.add(self.fresh)
            self.fresh += 1


def _cut_out(faces: Polygons, points: NDArray[np.float64], flat: NDArray[np.bool_]) -> _Patch:
    inner = np.zeros(len(points), np.bool_)
    inner[faces.corners[flat[faces.face]]] = True
    near = np.zeros(faces.count, np.bool_)
    near[faces.face[inner[faces.corners]]] = True
    cut = {f: faces.corners[faces.offsets[f] : faces.offsets[f + 1]].tolist() for f in np.flatnonzero(near).tolist()}
    around = defaultdict[int, set[int]](set)
    for f, corners in cut.items():
        for v in corners:
            around[v].add(f)
    return _Patch(cut, around, {v: points[v] for v in around}, faces.count)


def _paste(faces: Polygons, patch: _Patch) -> Polygons:
    kept = np.ones(faces.count, np.bool_)
    kept[[f for f in patch.touched if f < faces.count]] = False
    return faces.select(kept).extend([patch.faces[f] for f in sorted(patch.touched & patch.faces.keys())])


def _sides(corners: list[int]) -> list[frozenset[int]]:
    return [frozenset((a, b)) for a, b in pairwise([*corners, corners[0]])]


def _without_repeats(corners: list[int]) -> list[int]:
    return [v for v, before in zip(corners, [corners[-1], *corners[:-1]], strict=True) if v != before]


def _fan_count(polygons: list[list[int]], vertex: int) -> int:
    """Count the fans of faces round a vertex; -1 where an edge has a third face or two faces coincide."""
    links = defaultdict[int, list[int]](list)
    for corners in polygons:
        at = corners.index(vertex)
        before, after = corners[at - 1], corners[(at + 1) % len(corners)]
        links[before].append(after)
        links[after].append(before)
    if any(len(others) > 2 or len(set(others)) < len(others) for others in links.values()):
        return -1
    fans, seen = 0, set[int]()
    for start in links:
        fans += start not in seen
        waiting = [start]
        while waiting:
            v = waiting.pop()
            if v not in seen:
                seen.add(v)
                waiting += links[v]
    return fans
