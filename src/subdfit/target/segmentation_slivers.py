"""Needles and folds turned away, as Boolean operations leave them: triangles without a normal, or with a wrong one."""

import heapq
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.target.features import automatic_creases, edges_among, mesh_edges
from subdfit.target.segmentation_facets import Facets

Floats = NDArray[np.float64]
Creases = NDArray[np.int64]

_LOW = 0.02
"""Height over the longest side below which a triangle's normal means nothing."""
_BEVEL = 45.0
"""Degrees by which a triangle made by a flip may face away from both together: a sharp edge beside it stays."""
_MOST = 1e-3
"""Diagonals of the box by which flips may move the surface: less than a plate's rim, more than coordinates err."""
_PIECE = 1.0
"""Degrees across edges within a flat piece, by which a needle's normal is known to be right."""
_TURNS = 16
"""Most rounds of unfolding, which leave fewer folded triangles each."""
FOLDED = 150.0
"""Degrees to a neighbour from which a triangle is folded back over it."""


@dataclass(frozen=True)
class _Flip:
    """The triangle beyond a side, the two triangles (2, 3) that take both places, and how far they lie off at most."""

    beyond: int
    after: NDArray[np.int64]
    moved: float


@dataclass(frozen=True)
class _Surface:
    """A mesh whose sides are flipped in place.

    Attributes
    ----------
    points : (n, 3) float64.
    corners : (m, 3) int32, the triangles.
    face_of : the triangle that has a side, from one vertex to the next.
    kept : sides that stay, in both directions.
    moved : (m,) float64, how far each triangle lies off the surface as it was, at most.
    most : how far one may.
    """

    points: Floats
    corners: NDArray[np.int32]
    face_of: dict[tuple[int, int], int]
    kept: set[tuple[int, int]]
    moved: Floats
    most: float


def without_slivers(
    points: Floats, triangles: NDArray[np.integer], creases: Creases, *, found: bool = False
) -> tuple[NDArray[np.int32], Creases]:
    """The same surface to within the height of its needles, without needles and triangles folded over their neighbours.

    Needles are given to the neighbour across their longest side, folded triangles are turned over with a neighbour that
    holds them; those that no flip mends stay, and so do those whose flip would move the surface by more than a
    thousandth of the box's diagonal.

    Parameters
    ----------
    points : (n, 3) float64.
    triangles : (m, 3) int, rows of `points`, oriented alike, at most two an edge.
    creases : (c, 2) int64, edges that no flip takes away.
    found : whether these are `automatic_creases`, which needles feign and hide: then flips may take away those beside a
        needle that no flat piece shows to be right, and all are found anew.

    Returns
    -------
    triangles : (m, 3) int32; row f lies where row f lay, or beside it.
    creases : (c, 2) int64.
    """
    corners = np.array(triangles, np.int32)
    if _shapes(points[corners]).min() >= _LOW and len(_folded(points, corners)) == 0:
        return corners, creases
    sides = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2).tolist()
    face_of = {(a, b): side // 3 for side, (a, b) in enumerate(sides)}
    most = _MOST * float(np.linalg.norm(np.ptp(points[corners.ravel()], axis=0)))
    kept = _sure(points, corners, creases, most) if found else creases
    both = {(a, b) for a, b in np.concatenate([kept, kept[:, ::-1]]).tolist()}
    surface = _Surface(points, corners, face_of, both, np.zeros(len(corners)), most)
    for _ in range(_TURNS):
        _flip_needles(surface)
        if not _unfold(surface):
            break
    if not found or np.array_equal(corners, triangles):
        return corners, creases
    return corners, automatic_creases(points, corners)


def _sure(points: Floats, corners: NDArray[np.int32], creases: Creases, width: float) -> Creases:
    """Creases, (k, 2), between flat pieces that are wider than flips may move the surface."""
    edges = mesh_edges(points, corners)
    sharp = edges_among(edges.vertices, creases)
    facets = Facets(points, corners, edges, sharp, width)
    piece = facets.connected((edges.angle < _PIECE) & ~sharp)
    longest = np.zeros(int(piece.max()) + 1)
    np.maximum.at(longest, piece, np.sqrt(_squares(points[corners]).max(axis=1)))
    wide = 2 * np.bincount(piece, facets.areas) > width * longest
    return edges.vertices[sharp & wide[piece[edges.faces]].all(axis=1)]


def _flip_needles(surface: _Surface) -> None:
    """Flip the longest sides of needles where that makes the lower of two triangles higher in proportion."""
    points, corners = surface.points, surface.corners
    shape = _shapes(points[corners])
    queue = [(float(shape[f]), int(f)) for f in np.flatnonzero(shape < _LOW)]
    heapq.heapify(queue)
    while queue:
        known, f = heapq.heappop(queue)
        if known != float(_shapes(points[corners[f]][None])[0]):
            continue
        ends = points[corners[f]]
        flip = _flipped(surface, f, int(np.argmax(_squares(ends))))
        if flip is None or _shapes(points[flip.after]).min() <= _shapes(points[corners[[f, flip.beyond]]]).min():
            continue
        _replace(surface, f, flip)
        for changed in (f, flip.beyond):
            now = float(_shapes(points[corners[changed]][None])[0])
            if now < _LOW:
                heapq.heappush(queue, (now, changed))


def _unfold(surface: _Surface) -> bool:
    """Flip a side of each triangle that is folded over all its neighbours, where one allows; whether any did."""
    corners, before = surface.corners, surface.corners.copy()
    for f in _folded(surface.points, corners).tolist():
        flips = (_flipped(surface, f, side) for side in range(3))
        flip = next((flip for flip in flips if flip is not None), None)
        if flip is not None and np.array_equal(corners[[f, flip.beyond]], before[[f, flip.beyond]]):
            _replace(surface, f, flip)
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


def _flipped(surface: _Surface, f: int, side: int) -> _Flip | None:
    """What a flip of a triangle's side makes of it and of its neighbour; None where that would bend the surface."""
    points, corners, face_of = surface.points, surface.corners, surface.face_of
    a, b, c = np.roll(corners[f], -side).tolist()
    g = face_of.get((b, a), -1)
    if g < 0 or (a, b) in surface.kept:
        return None
    d = sum(corners[g].tolist()) - a - b
    after = np.array([[c, a, d], [d, b, c]])
    # The sum of both areas, as vectors, is the same before and after: it tells where they face, square to both sides.
    faces, areas = _areas(points[corners[[f, g]]]).sum(axis=0), _areas(points[after])
    size = float(np.linalg.norm(faces))
    least = np.cos(np.radians(_BEVEL)) * np.linalg.norm(areas, axis=1) * size
    if (c, d) in face_of or (d, c) in face_of or np.any(areas @ faces <= least):
        return None
    # The surface moves where the two sides cross, seen from there: by the distance between them.
    moved = surface.moved[[f, g]].max() + abs((points[c] - points[a]) @ faces) / size
    return _Flip(g, after, moved) if moved <= surface.most else None


def _replace(surface: _Surface, f: int, flip: _Flip) -> None:
    (_, a, _), (_, b, _) = flip.after.tolist()
    del surface.face_of[a, b], surface.face_of[b, a]
    for face, (x, y, z) in zip((f, flip.beyond), flip.after.tolist(), strict=True):
        surface.corners[face] = x, y, z
        surface.moved[face] = flip.moved
        surface.face_of[x, y] = surface.face_of[y, z] = surface.face_of[z, x] = face
