"""A scan that nobody scanned: a sitting elephant, made by formula, as dense and noisy as a scanner's mesh."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

NOISE = 3e-5
"""Standard deviation of the noise along the normal, as a fraction of the diagonal."""

_LOW, _HIGH = np.array([-60.0, 0.0, -50.0]), np.array([60.0, 116.0, 84.0])
"""Corners of the box that is contoured, in millimetres; its floor cuts the plinth open."""

_VERTICES_AT_ONE = 55_500
"""Vertices of the contour at a spacing of one millimetre."""

_FEWEST = 10_000

_BLOCK = 4
"""Grid points along the side of a block that is judged as one where it is far from the surface."""

_HOLE_CENTRE, _HOLE_RADIUS = np.array([[4.0, 88.0, -14.0]]), 3.0
"""Where the scanner saw nothing: a small hole on the back of the head."""


def synthetic_scan(seed: int = 0, vertices: int = 40_000) -> tuple[Floats, Indices]:
    """Return a synthetic scan of a hand-sized figure: an elephant on a plinth, its trunk curled to its forehead.

    The trunk makes a handle, so that the genus is one; the open foot of the plinth and a small hole on the back of
    the head are its two boundaries. Skin and ears are smooth; blanket, trunk and plinth carry fine relief. The
    triangles are irregular, nearly Delaunay, manifold and oriented outwards, and every vertex has Gaussian noise of
    `NOISE` times the diagonal along the normal. The same arguments give the same mesh.

    Parameters
    ----------
    seed
        Of the random numbers for the irregularity and the noise.
    vertices
        Number of vertices wanted, 10,000 or more; kept to within a few per cent.

    Returns
    -------
    points : (n, 3) float64, in millimetres; y points up, the figure looks along z.
    triangles : (m, 3) int64, counter-clockwise seen from outside.

    Raises
    ------
    InputError
        Too few vertices for the figure's thin parts.
    """
    if vertices < _FEWEST:
        raise InputError(
            f"a synthetic scan of {vertices} vertices would lose its thin parts: ask for {_FEWEST} or more"
        )
    random = np.random.default_rng(seed)
    spacing = float(np.sqrt(_VERTICES_AT_ONE / vertices))
    points, triangles = _contour(spacing)
    points += random.uniform(-0.3, 0.3, points.shape) * spacing
    points = _on_figure(points, steps=3)
    fixed = _boundary_vertices(triangles, len(points))
    for _ in range(3):
        for _ in range(4):
            triangles = _flip(points, triangles)
        points = _on_figure(_relax(points, triangles, fixed), steps=2)
    points, triangles = _pierce(points, triangles)
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    noise = random.normal(0.0, NOISE * diagonal, (len(points), 1))
    return points + noise * _gradient(points)[1], triangles


# The figure: an approximate signed distance in millimetres, negative inside.


def figure(x: Floats, y: Floats, z: Floats) -> Floats:
    """Return an approximate signed distance to the figure, in millimetres, negative inside; any shape, any float."""
    side = np.abs(x)
    shape = _body(x, y, z)
    shape = _blend(shape, _capsule(side, y, z, (27, 17, -2), (24, 14, 24), 15.0, 11.0), 6.0)
    shape = _blend(shape, _ellipsoid(side, y, z, (24.5, 17.0, 30.5), (9.5, 11.0, 6.5)), 4.0)
    for across, up in ((-5.8, 4.6), (0.3, 7.4), (6.0, 4.0)):
        shape = _blend(shape, _ellipsoid(side, y, z, (24.5 + across, 17.5 + up, 34.9), (2.8, 2.6, 1.8)), 1.2)
    shape = _blend(shape, _capsule(side, y, z, (21, 60, 12), (10.5, 33, 31), 10.0, 7.5), 5.0)
    shape = _blend(shape, _capsule(x, y, z, (0, 30, -36), (14, 14, -40), 4.0, 2.8), 4.0)
    shape = _blend(shape, _head(x, y, z), 6.0)
    return _blend(shape, _plinth(x, y, z), 2.0)


def _body(x: Floats, y: Floats, z: Floats) -> Floats:
    """Return the trunk of the body with a quilted blanket on its back."""
    body = _ellipsoid(x, y, z, (0, 43, -5), (33, 40, 32))
    around, along = np.arctan2(x, y - 43.0), np.arctan2(z + 5.0, np.hypot(x, y - 43.0))
    edge = np.maximum(np.abs(around) / 1.9, np.abs(along + 0.22) / 0.68)
    cloth = _step((1.0 - edge) / 0.06)
    hem = _step((edge - 0.84) / 0.05)
    quilt = np.abs(np.sin(9.0 * (around + along)) * np.sin(9.0 * (around - along)))
    thickness: Floats = cloth * (0.7 + 0.6 * hem + 1.1 * (1.0 - hem) * np.sqrt(quilt + 0.01))
    return body - thickness


def _head(x: Floats, y: Floats, z: Floats) -> Floats:
    """Return head, ears, eyes, tusks and trunk, turned a little to one side."""
    turn = np.radians(-22.0)
    x, z = np.cos(turn) * x - np.sin(turn) * (z - 10.0), np.sin(turn) * x + np.cos(turn) * (z - 10.0)
    y = y - 84.0
    side = np.abs(x)
    head = _blend(_ellipsoid(x, y, z, (0, 0, 3), (24, 25, 24)), _ellipsoid(side, y, z, (9, 13, 1), (13, 12, 14)), 6.0)
    head = _blend(head, _ellipsoid(x, y, z, (0, -20, 18), (8, 5, 8)), 3.0)
    head = _blend(head, _ears(side, y, z), 3.5)
    head = _blend(head, _capsule(side, y, z, (10.5, -11, 21), (14.5, -17, 37), 4.6, 2.2), 2.0)
    head = _blend(head, _ellipsoid(side, y, z, (15.5, 4.5, 20.8), (3.0, 3.4, 2.6)), 0.8)
    return _blend(head, _trunk(x, y, z), 5.0)


def _ears(side: Floats, y: Floats, z: Floats) -> Floats:
    """Return the ears: bowed plates with a round rim that stand off the head."""
    flare = np.radians(28.0)
    out = np.cos(flare) * (side - 20.0) - np.sin(flare) * (z + 2.0)
    front = np.sin(flare) * (side - 20.0) + np.cos(flare) * (z + 2.0)
    bowed = front - 0.011 * ((out - 14.0) ** 2 + (y - 1.0) ** 2)
    beyond = np.maximum(_ellipsoid(out, y, 0.0 * z, (14, 0, 0), (16.5, 20.5, 1.0)), 0.0)
    middle: Floats = np.hypot(beyond, bowed)
    return middle - 2.6


def _trunk(x: Floats, y: Floats, z: Floats) -> Floats:
    """Return the trunk: a ring before the face, tapered and wrinkled, that comes to rest on the forehead."""
    up, fore = (y - 3.0) / 1.1, z - 41.0
    progress = np.arctan2(up, -fore) / (2.0 * np.pi)
    progress = np.where(progress > 0.0, 1.0 - progress, -progress)
    wrinkles = 0.45 * np.sin(90.0 * progress) * _step((progress - 0.28) / 0.1) * _step((0.86 - progress) / 0.1)
    radius = 4.6 + 5.6 * _step(progress / 0.25) * (1.0 - progress)
    ring = np.hypot(np.hypot(up, fore) - 18.5, x) - radius - wrinkles
    return _blend(ring, _capsule(x, y, z, (0, -5, 14), (0, -11, 28), 13.0, 9.0), 5.0)


def _plinth(x: Floats, y: Floats, z: Floats) -> Floats:
    """Return a round plinth with a roped edge; it goes on below the floor."""
    radius = np.hypot(x, z + 3.0)
    rope = 0.55 * np.sin(40.0 * np.arctan2(x, z + 3.0) + 1.0 * y) * _step((4.2 - np.abs(y - 4.6)) / 1.5)
    out, over = radius - 40.0, y - 6.0
    return np.hypot(np.maximum(out, 0.0), np.maximum(over, 0.0)) + np.minimum(np.maximum(out, over), 0.0) - 3.2 - rope


def _step(t: Floats) -> Floats:
    t = np.clip(t, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def _blend(a: Floats, b: Floats, width: float) -> Floats:
    """Return the union with a fillet (the polynomial smooth minimum of Quilez 2013)."""
    overlap = np.maximum(width - np.abs(a - b), 0.0)
    return np.minimum(a, b) - overlap * overlap / (4.0 * width)


Place = tuple[float, float, float]


def _ellipsoid(x: Floats, y: Floats, z: Floats, centre: Place, radii: Place) -> Floats:
    """Return an approximate distance to an ellipsoid, exact to first order on its surface."""
    u, v, w = ((c - m) / r for c, m, r in zip((x, y, z), centre, radii, strict=True))
    scaled = np.sqrt(u * u + v * v + w * w) + 1e-9
    slope = np.sqrt((u / radii[0]) ** 2 + (v / radii[1]) ** 2 + (w / radii[2]) ** 2) + 1e-9
    return scaled * (scaled - 1.0) / slope


def _capsule(x: Floats, y: Floats, z: Floats, a: Place, b: Place, start: float, end: float) -> Floats:
    """Return the distance to a rounded cone from `a` to `b` whose radius runs from `start` to `end`."""
    dx, dy, dz = (q - p for p, q in zip(a, b, strict=True))
    x, y, z = x - a[0], y - a[1], z - a[2]
    along = np.clip((x * dx + y * dy + z * dz) / (dx * dx + dy * dy + dz * dz), 0.0, 1.0)
    off = np.sqrt((x - along * dx) ** 2 + (y - along * dy) ** 2 + (z - along * dz) ** 2)
    return off - start - along * (end - start)


# The mesh.


def _contour(spacing: float) -> tuple[Floats, Indices]:
    """Return a mesh near the figure's surface: one vertex a crossed cell of a grid (surface nets, Gibson 1998)."""
    inside = _well_composed(_inside(spacing))
    cell = np.full(inside.shape, -1, np.int64)
    corners = sum(inside[_shifted(offset)].astype(np.int8) for offset in np.ndindex(2, 2, 2))
    crossed = (corners > 0) & (corners < 8)
    rows = np.argwhere(crossed)
    cell[:-1, :-1, :-1][crossed] = np.arange(len(rows))
    quads = np.concatenate([_quads(inside, cell, axis) for axis in range(3)])
    used, quads = np.unique(quads, return_inverse=True)
    quads = quads.reshape(-1, 4)
    points = _LOW + (rows[used] + 0.5) * spacing
    return points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def _inside(spacing: float) -> NDArray[np.bool_]:
    """Return which points of a grid lie inside the figure; blocks of points far from its surface are judged as one."""
    counts = np.ceil((_HIGH - _LOW) / (_BLOCK * spacing)).astype(np.int64)
    middles = [
        low + (_BLOCK * np.arange(n) + 0.5 * (_BLOCK - 1)) * spacing for low, n in zip(_LOW, counts, strict=True)
    ]
    coarse = figure(*np.meshgrid(*middles, indexing="ij", sparse=True))
    inside, near = coarse < 0.0, np.abs(coarse) < _BLOCK * 1.2 * spacing
    for axis in range(3):
        inside, near = np.repeat(inside, _BLOCK, axis), np.repeat(near, _BLOCK, axis)
    inside[near] = figure(*(_LOW + np.argwhere(near) * spacing).T) < 0.0
    return inside


def _well_composed(inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Fill grid points in until no two that agree touch by a diagonal alone, which would make the mesh non-manifold.

    On a square, such are opposite corners that differ from the two others; in a cube, opposite corners that differ
    from the six others (Latecki, Eckhardt and Rosenfeld 1995, "Well-composed sets").
    """
    inside = inside.copy()
    before = -1
    while int(np.count_nonzero(inside)) != before:
        before = int(np.count_nonzero(inside))
        for axis in range(3):
            grid = np.moveaxis(inside, axis, 0)
            a, b, c, d = grid[:, :-1, :-1], grid[:, 1:, :-1], grid[:, :-1, 1:], grid[:, 1:, 1:]
            bad = (a == d) & (b == c) & (a != b)
            for corner in (a, b, c, d):
                corner |= bad
        corners = [inside[_shifted(offset)] for offset in np.ndindex(2, 2, 2)]
        count = sum(corner.astype(np.int8) for corner in corners)
        for near, far in zip(corners[:4], corners[:3:-1], strict=True):
            bad = (near == far) & np.where(near, count == 2, count == 6)
            near |= bad
            far |= bad
    return inside


def _shifted(offset: tuple[int, ...]) -> tuple[slice, ...]:
    return tuple(slice(1, None) if o else slice(None, -1) for o in offset)


def _quads(inside: NDArray[np.bool_], cell: Indices, axis: int) -> Indices:
    """Return the four cells around each grid edge along `axis` whose ends lie on different sides."""
    ahead = np.take(inside, range(1, inside.shape[axis]), axis)
    here = np.take(inside, range(inside.shape[axis] - 1), axis)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    at = np.argwhere(here != ahead)
    at = at[(at[:, first] > 0) & (at[:, second] > 0)]
    around = np.repeat(at[:, None, :], 4, axis=1)
    around[:, [1, 2], first] -= 1
    around[:, [2, 3], second] -= 1
    quads = cell[around[..., 0], around[..., 1], around[..., 2]]
    leaves = inside[at[:, 0], at[:, 1], at[:, 2]]
    quads = np.where(leaves[:, None], quads, quads[:, ::-1])
    return quads[np.all(quads >= 0, axis=1)]


def _gradient(points: Floats) -> tuple[Floats, Floats]:
    """Return the figure's values over its slope (n, 1), and unit normals (n, 3), by forward differences."""
    step = 1e-4
    here = figure(*points.T)
    slopes = np.stack([(figure(*(points + shift).T) - here) / step for shift in step * np.eye(3)], axis=1)
    size = np.linalg.norm(slopes, axis=1, keepdims=True)
    return here[:, None] / size, slopes / size


def _on_figure(points: Floats, steps: int) -> Floats:
    """Move points to the figure's surface by Newton steps along its normals."""
    for _ in range(steps):
        distance, normals = _gradient(points)
        points = points - np.clip(distance, -1.0, 1.0) * normals
    return points


class _Edges(NamedTuple):
    """Edges with two triangles: their ends (e, 2), those triangles (e, 2), the corners opposite (e, 2), all keys."""

    ends: Indices
    faces: Indices
    opposite: Indices
    keys: Indices


def _edges(triangles: Indices, count: int) -> _Edges:
    tail, head, apex = (np.roll(triangles, -k, axis=1).ravel() for k in range(3))
    key = np.minimum(tail, head) * count + np.maximum(tail, head)
    order = np.argsort(key, kind="stable")
    twins = np.flatnonzero(key[order][1:] == key[order][:-1])
    pair = np.stack([order[twins], order[twins + 1]], axis=1)
    return _Edges(np.stack([tail, head], 1)[pair[:, 0]], pair // 3, apex[pair], key[order])


def _boundary_vertices(triangles: Indices, count: int) -> NDArray[np.bool_]:
    sides = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    key, uses = np.unique(sides.min(axis=1) * count + sides.max(axis=1), return_counts=True)
    on_boundary = np.zeros(count, bool)
    on_boundary[key[uses == 1] // count] = True
    on_boundary[key[uses == 1] % count] = True
    return on_boundary


def _flip(points: Floats, triangles: Indices) -> Indices:
    """Flip edges that are not Delaunay (opposite angles of more than 180 degrees), at most one a triangle."""
    count = len(points)
    edges = _edges(triangles, count)
    (a, b), (c, d) = edges.ends.T, edges.opposite.T
    excess = _cotangent(points, c, a, b) + _cotangent(points, d, a, b)
    new_key = np.minimum(c, d) * count + np.maximum(c, d)
    known = edges.keys[np.minimum(np.searchsorted(edges.keys, new_key), len(edges.keys) - 1)] == new_key
    flat = _agree(points, (a, b, c), (b, a, d)) & _agree(points, (c, d, b), (d, c, a))
    candidates = np.flatnonzero((excess < -1e-9) & ~known & flat)
    candidates = candidates[np.argsort(excess[candidates], kind="stable")]
    candidates = candidates[np.sort(np.unique(new_key[candidates], return_index=True)[1])]
    best = np.full(len(triangles), len(candidates))
    rank = np.arange(len(candidates))
    for beside in range(2):
        np.minimum.at(best, edges.faces[candidates, beside], rank)
    chosen = candidates[np.all(best[edges.faces[candidates]] == rank[:, None], axis=1)]
    flipped = triangles.copy()
    flipped[edges.faces[chosen, 0]] = np.stack([c, a, d], axis=1)[chosen]
    flipped[edges.faces[chosen, 1]] = np.stack([d, b, c], axis=1)[chosen]
    return flipped


def _cotangent(points: Floats, apex: Indices, a: Indices, b: Indices) -> Floats:
    """Return the cotangent of the angle at `apex` in the triangles (apex, a, b)."""
    u, v = points[a] - points[apex], points[b] - points[apex]
    areas: Floats = np.linalg.norm(np.cross(u, v), axis=1) + 1e-12
    return np.asarray(np.einsum("ij,ij->i", u, v) / areas)


def _agree(points: Floats, one: tuple[Indices, ...], other: tuple[Indices, ...]) -> NDArray[np.bool_]:
    """Return whether two triangles look the same way to within 60 degrees."""
    n, m = (np.cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]) for t in (one, other))
    sizes = np.linalg.norm(n, axis=1) * np.linalg.norm(m, axis=1)
    return np.asarray(np.einsum("ij,ij->i", n, m) > 0.5 * sizes)


def _relax(points: Floats, triangles: Indices, fixed: NDArray[np.bool_]) -> Floats:
    """Move free vertices half way to the mean of their neighbours."""
    count = len(points)
    tail, head = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    valence = np.maximum(np.bincount(tail, minlength=count), 1)
    sums = np.stack([np.bincount(tail, points[head, axis], minlength=count) for axis in range(3)], axis=1)
    return np.where(fixed[:, None], points, 0.5 * (points + sums / valence[:, None]))


def _pierce(points: Floats, triangles: Indices) -> tuple[Floats, Indices]:
    """Leave out the triangles around the hole's centre, those on the way that hang by one corner, and lone vertices."""
    near = np.linalg.norm(points - _on_figure(_HOLE_CENTRE, steps=8), axis=1) < _HOLE_RADIUS
    kept = triangles[~near[triangles].any(axis=1)]
    while True:
        sides = np.stack([kept, np.roll(kept, -1, axis=1)], axis=2).reshape(-1, 2)
        key, uses = np.unique(sides.min(axis=1) * len(points) + sides.max(axis=1), return_counts=True)
        open_sides = key[uses == 1]
        ends = np.bincount(np.concatenate([open_sides // len(points), open_sides % len(points)]))
        if ends.max() <= 2:
            break
        kept = kept[~np.isin(kept, np.flatnonzero(ends > 2)).any(axis=1)]
    used, rows = np.unique(kept, return_inverse=True)
    return points[used], rows.reshape(-1, 3)
