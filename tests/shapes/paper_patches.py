"""Three open surfaces by formula with the vertex and face counts of Lavoué et al. 2007, Table 1.

A disk with h holes meshed by V vertices and F triangles has 2V - F - 2 + 2h boundary edges, so the topology tells how
many of the vertices lie inside. Topologies and shapes are choices of ours: the paper shows its own in pictures.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay, cKDTree

Floats = NDArray[np.float64]
Mesh = tuple[Floats, NDArray[np.int64]]
Lift = Callable[[Floats], Floats]

_CANDIDATES = 240
"""Candidates for inner points along the longer side of a domain."""


def cushion() -> Mesh:
    """A bent strip with a flat-topped bulge, like Figure 12a: 950 vertices, 1,734 triangles, a disk."""
    length, width, height = 2.0, 0.4, 0.06

    def lift(q: Floats) -> Floats:
        radius = 1 + height * (1 - (2 * q[:, 0] / length) ** 8) * (1 - (2 * q[:, 1] / width) ** 4)
        return np.stack([radius * np.sin(q[:, 0]), q[:, 1], radius * np.cos(q[:, 0])], 1)

    rings = [_rectangle(length, width, 68, 14)]
    return _meshed(rings, lift, _scattered(rings, lift, 786))


def boss() -> Mesh:
    """An arched plate with two round holes and a dome between them, like Figure 12b: 324 vertices, 491 triangles."""

    def lift(q: Floats) -> Floats:
        dome = 0.2 * np.exp(-np.sum(q**2, axis=1) / 0.25**2)
        return np.column_stack([q, dome - 0.2 * q[:, 0] ** 2])

    aside = np.array([0.5, 0.0])
    holes = [_circle(0.22, 31)[::-1] - aside, _circle(0.18, 26)[::-1] + aside]
    rings = [_rectangle(1.6, 1.0, 31, 20), *holes]
    return _meshed(rings, lift, _scattered(rings, lift, 165))


def tube() -> Mesh:
    """A cylinder as high as wide, like Figure 12c: 168 vertices on four circles, 248 triangles, an annulus."""

    def lift(q: Floats) -> Floats:
        radius = np.hypot(*q.T)
        return np.column_stack([q / radius[:, None], -np.log(radius)])

    inner = np.concatenate([_circle(np.exp(height), 40) for height in (1 / 3, -1 / 3)])
    return _meshed([_circle(np.e, 44), _circle(1 / np.e, 44)[::-1]], lift, inner)


def _rectangle(length: float, width: float, along: int, across: int) -> Floats:
    """A rectangle round the origin, counter-clockwise, its sides cut in so many parts."""
    x, y = np.linspace(-0.5, 0.5, along, endpoint=False), np.linspace(-0.5, 0.5, across, endpoint=False)
    sides = [[x, 0 * x - 0.5], [0 * y + 0.5, y], [-x, 0 * x + 0.5], [0 * y - 0.5, -y]]
    return np.concatenate([np.stack(side, 1) for side in sides]) * [length, width]


def _circle(radius: float, count: int) -> Floats:
    angle = 2 * np.pi * np.arange(count) / count
    return radius * np.stack([np.cos(angle), np.sin(angle)], 1)


def _scattered(rings: Sequence[Floats], lift: Lift, count: int) -> Floats:
    """Points between some rings, which have them on their left: each as far from all others as it can, once lifted."""
    rim = np.concatenate(rings)
    step = np.ptp(rim, axis=0).max() / _CANDIDATES
    axes = (np.arange(low, high, step) for low, high in zip(rim.min(axis=0), rim.max(axis=0), strict=True))
    inner = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 2)
    inner = inner[_between(inner, rings)]
    lifted = lift(inner)
    far = cKDTree(lift(rim)).query(lifted)[0]
    chosen: list[int] = []
    for _ in range(count):
        chosen.append(int(np.argmax(far)))
        far = np.minimum(far, np.linalg.norm(lifted - lifted[chosen[-1]], axis=1))
    return inner[chosen]


def _meshed(rings: Sequence[Floats], lift: Lift, inner: Floats) -> Mesh:
    """Delaunay's triangles between some rings, lifted."""
    flat = np.concatenate([*rings, inner])
    triangles = Delaunay(flat).simplices.astype(np.int64)
    a, b, c = np.moveaxis(flat[triangles], 1, 0)
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles = np.where((area > 0)[:, None], triangles, triangles[:, ::-1])
    return lift(flat), triangles[_between((a + b + c) / 3, rings) & (np.abs(area) > 1e-9)]


def _between(q: Floats, rings: Sequence[Floats]) -> NDArray[np.bool_]:
    """Which points lie between the rings: a ray along x crosses them an odd number of times."""
    crossings = np.zeros(len(q), np.int64)
    for ring in rings:
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            between = (a[1] <= q[:, 1]) != (b[1] <= q[:, 1])
            if a[1] != b[1]:
                crossings += between & (q[:, 0] < a[0] + (q[:, 1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1]))
    return crossings % 2 == 1
