"""Needles turned away: triangles too low to have a normal, given to the neighbour across their longest side."""

import heapq

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_LOW = 0.02
"""Height over the longest side below which a triangle's normal means nothing."""


def without_needles(points: Floats, triangles: NDArray[np.integer]) -> NDArray[np.int32]:
    """The same surface to within the height of its needles, whose longest sides have been flipped.

    A flip is done where it makes the lower of the two triangles higher in proportion, so that the work ends; needles
    that no flip mends stay. Row f of the result lies where row f lay, or beside it.

    Parameters
    ----------
    points : (n, 3) float64.
    triangles : (m, 3) int, rows of `points`, oriented alike, at most two an edge.
    """
    corners = np.array(triangles, np.int32)
    shape = _shapes(points[corners])
    low = np.flatnonzero(shape < _LOW)
    if len(low) == 0:
        return corners
    sides = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2).tolist()
    face_of = {(a, b): side // 3 for side, (a, b) in enumerate(sides)}
    queue = [(float(shape[f]), int(f)) for f in low]
    heapq.heapify(queue)
    while queue:
        known, f = heapq.heappop(queue)
        if known != float(_shapes(points[corners[f]][None])[0]):
            continue
        for changed in _flip(points, corners, face_of, f):
            now = float(_shapes(points[corners[changed]][None])[0])
            if now < _LOW:
                heapq.heappush(queue, (now, changed))
    return corners


def _shapes(corners: Floats) -> Floats:
    """Height over the longest side of triangles (k, 3, 3), (k,)."""
    longest = np.sum((corners - np.roll(corners, 1, axis=1)) ** 2, axis=2).max(axis=1)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return np.asarray(area / np.maximum(longest, np.finfo(float).tiny))


def _flip(
    points: Floats, corners: NDArray[np.int32], face_of: dict[tuple[int, int], int], f: int
) -> tuple[int, int] | tuple[()]:
    """Flip the longest side of a triangle if that helps; return the two triangles changed."""
    triangle = corners[f].tolist()
    lengths = [float(np.sum((points[triangle[k]] - points[triangle[k - 2]]) ** 2)) for k in range(3)]
    k = lengths.index(max(lengths))
    a, b, c = triangle[k], triangle[k - 2], triangle[k - 1]
    g = face_of.get((b, a), -1)
    if g < 0:
        return ()
    d = sum(corners[g].tolist()) - a - b
    after = np.array([[c, a, d], [d, b, c]])
    before = _shapes(points[corners[[f, g]]]).min()
    if (c, d) in face_of or (d, c) in face_of or _shapes(points[after]).min() <= before:
        return ()
    del face_of[a, b], face_of[b, a]
    for face, (x, y, z) in zip((f, g), after.tolist(), strict=True):
        corners[face] = x, y, z
        face_of[x, y] = face_of[y, z] = face_of[z, x] = face
    return f, g
