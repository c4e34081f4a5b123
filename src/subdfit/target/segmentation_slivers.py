"""Needles and folds turned away, as Boolean operations leave them: triangles without a normal, or with a wrong one."""

import heapq
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subdfit.target.features import mesh_edges

Floats = NDArray[np.float64]
_Sides = dict[tuple[int, int], int]

_LOW = 0.02
"""Height over the longest side below which a triangle's normal means nothing."""
_BEVEL = 45.0
"""Degrees by which a triangle made by a flip may face away from both together: a sharp edge beside it stays."""
_TURNS = 16
"""Most rounds of unfolding, which leave fewer folded triangles each."""
FOLDED = 150.0
"""Degrees to a neighbour from which a triangle is folded back over it."""


class _Flip(NamedTuple):
    """The triangle beyond a side, and the two triangles (2, 3) that take both places."""

    beyond: int
    after: NDArray[np.int64]


def without_slivers(points: Floats, triangles: NDArray[np.integer]) -> NDArray[np.int32]:
    """The same surface to within the height of its needles, without needles and triangles folded over their neighbours.

    Needles are given to the neighbour across their longest side, folded triangles are turned over with a neighbour that
    holds them; those that no flip mends stay. Row f of the result lies where row f lay, or beside it.

    Parameters
    ----------
    points : (n, 3) float64.
    triangles : (m, 3) int, rows of `points`, oriented alike, at most two an edge.
    """
    corners = np.array(triangles, np.int32)
    if _shapes(points[corners]).min() >= _LOW and len(_folded(points, corners)) == 0:
        return corners
    sides = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2).tolist()
    face_of = {(a, b): side // 3 for side, (a, b) in enumerate(sides)}
    for _ in range(_TURNS):
        _flip_needles(points, corners, face_of)
        if not _unfold(points, corners, face_of):
            break
    return corners


def _flip_needles(points: Floats, corners: NDArray[np.int32], face_of: _Sides) -> None:
    """Flip the longest sides of needles where that makes the lower of two triangles higher in proportion."""
    shape = _shapes(points[corners])
    queue = [(float(shape[f]), int(f)) for f in np.flatnonzero(shape < _LOW)]
    heapq.heapify(queue)
    while queue:
        known, f = heapq.heappop(queue)
        if known != float(_shapes(points[corners[f]][None])[0]):
            continue
        ends = points[corners[f]]
        flip = _flipped(points, corners, face_of, f, int(np.argmax(_squares(ends))))
        if flip is None or _shapes(points[flip.after]).min() <= _shapes(points[corners[[f, flip.beyond]]]).min():
            continue
        _replace(corners, face_of, f, flip)
        for changed in (f, flip.beyond):
            now = float(_shapes(points[corners[changed]][None])[0])
            if now < _LOW:
                heapq.heappush(queue, (now, changed))


def _unfold(points: Floats, corners: NDArray[np.int32], face_of: _Sides) -> bool:
    """Flip a side of each triangle that is folded over all its neighbours, where one allows; whether any did."""
    before = corners.copy()
    for f in _folded(points, corners).tolist():
        flips = (_flipped(points, corners, face_of, f, side) for side in range(3))
        flip = next((flip for flip in flips if flip is not None), None)
        if flip is not None and np.array_equal(corners[[f, flip.beyond]], before[[f, flip.beyond]]):
            _replace(corners, face_of, f, flip)
    return not np.array_equal(corners, before)


def _folded(points: Floats, corners: NDArray[np.int32]) -> NDArray[np.int64]:
    """Triangles folded over all their neighbours, (k,)."""
    edges = mesh_edges(points, corners)
    return np.flatnonzero((edges.angle[edges.of_face] > FOLDED).all(axis=1))


def _shapes(corners: Floats) -> Floats:
    """Height over the longest side of triangles (k, 3, 3), (k,)."""
    longest = _squares(corners).max(axis=1)
    area = np.linalg.norm(_areas(corners), axis=1)
    return np.asarray(area / np.maximum(longest, np.finfo(float).tiny))


def _squares(corners: Floats) -> Floats:
    """Squared lengths of the sides of triangles (..., 3, 3), from each corner to the next, (..., 3)."""
    return np.asarray(np.sum((corners - np.roll(corners, -1, axis=-2)) ** 2, axis=-1))


def _areas(corners: Floats) -> Floats:
    """Normals of triangles (k, 3, 3), twice as long as their areas, (k, 3)."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _flipped(points: Floats, corners: NDArray[np.int32], face_of: _Sides, f: int, side: int) -> _Flip | None:
    """What a flip of a triangle's side makes of it and of its neighbour; None where that would bend the surface."""
    a, b, c = np.roll(corners[f], -side).tolist()
    g = face_of.get((b, a), -1)
    if g < 0:
        return None
    d = sum(corners[g].tolist()) - a - b
    after = np.array([[c, a, d], [d, b, c]])
    # The sum of both areas, as vectors, is the same before and after: it tells where they face.
    faces, areas = _areas(points[corners[[f, g]]]).sum(axis=0), _areas(points[after])
    least = np.cos(np.radians(_BEVEL)) * np.linalg.norm(areas, axis=1) * np.linalg.norm(faces)
    if (c, d) in face_of or (d, c) in face_of or np.any(areas @ faces <= least):
        return None
    return _Flip(g, after)


def _replace(corners: NDArray[np.int32], face_of: _Sides, f: int, flip: _Flip) -> None:
    (_, a, _), (_, b, _) = flip.after.tolist()
    del face_of[a, b], face_of[b, a]
    for face, (x, y, z) in zip((f, flip.beyond), flip.after.tolist(), strict=True):
        corners[face] = x, y, z
        face_of[x, y] = face_of[y, z] = face_of[z, x] = face
