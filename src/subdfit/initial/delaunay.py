"""Facets of the Delaunay tetrahedralisation of a cloud, with the smallest empty sphere of each."""

from dataclasses import dataclass
from itertools import chain, pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay, cKDTree

from subdfit.initial import _delaunay_kernels as kernels
from subdfit.parallel import map_chunks

Floats = NDArray[np.float64]

FAR = 2.0
"""Distance of the four outer points from the centre: their tetrahedron contains a ball of radius 2/3."""

FILLERS = 1 / 32
"""Points put into empty space, for each point."""

JITTER = 0.3
"""Share of their distance by which they leave their lattice, whose points would be cospherical."""

NEIGHBOURS = 6
"""The spacing at a point is the distance to this nearest neighbour: where the sampling is regular, the first ring."""

LEAST_SLAB = 1 << 14
"""Points that are worth a slab of their own."""

MOST_OVERLAP = 0.25
"""Share of the points up to which slabs may overlap."""


@dataclass(frozen=True, eq=False)
class Facets:
    """Triangles of Delaunay's tetrahedralisation that small empty spheres pass through.

    Attributes
    ----------
    points : (n, 3) float64.
    corners : (k, 3) int32, rows of `points`, ascending; facets are in the order of their first corners.
    radii : (k,) float64, of the smallest sphere through each that is empty of points.
    offsets, at : (n + 1,) and (3 k,) int32, the facets at point p are ``at[offsets[p] : offsets[p + 1]]``.
    """

    points: Floats
    corners: NDArray[np.int32]
    radii: Floats
    offsets: NDArray[np.int32]
    at: NDArray[np.int32]


def small_facets(points: Floats, largest: Floats) -> Facets:
    """Find the Delaunay facets of points in the normalised frame, (n, 3), ascending by x and no two the same.

    A sphere of a facet may be as large as `largest`, (n,), at one of its corners. So a facet depends on nothing farther
    off than twice that radius: it is found in a slab of points that reaches so far beyond its first corner.
    """
    slabs = _slabs(points[:, 0], 2 * largest)

    def found_in(slab: int, _: int) -> tuple[NDArray[np.int32], Floats]:
        low, begin, end, high = slabs[slab]
        corners, radii = _facets_of(points[low:high], largest[low:high], begin - low, end - low)
        return corners + np.int32(low), radii

    corners, radii = (np.concatenate(parts) for parts in zip(*map_chunks(found_in, len(slabs), 1), strict=True))
    order = np.argsort(corners[:, 0], kind="stable")
    corners, radii = corners[order], radii[order]
    number = np.bincount(corners.ravel(), minlength=len(points))
    offsets, at = np.concatenate([[0], np.cumsum(number)]).astype(np.int32), np.empty(corners.size, np.int32)
    kernels.facets_at(corners, offsets, at)
    return Facets(points, corners, radii, offsets, at)


def _slabs(x: Floats, reach: Floats) -> list[tuple[int, int, int, int]]:
    """Rows low, begin, end, high of slabs of points at ascending x.

    Points begin..end - 1 are in one slab only; low..high - 1 are those within reach of them, by the largest `reach`,
    (n,), of the points that they are within reach of. There are as many slabs as can be without much overlap.
    """
    best = [(0, 0, len(x), len(x))]
    for count in range(2, len(x) // LEAST_SLAB + 1):
        bounds = (np.arange(count + 1) * len(x) // count).tolist()
        slabs = [_slab(x, reach, begin, end) for begin, end in pairwise(bounds)]
        if sum(high - low for low, _, _, high in slabs) > (1 + MOST_OVERLAP) * len(x):
            break
        best = slabs
    return best


def _slab(x: Floats, reach: Floats, begin: int, end: int) -> tuple[int, int, int, int]:
    first, last = x[begin], x[end - 1]
    most = reach[(x + reach >= first) & (x - reach <= last)].max()
    return int(np.searchsorted(x, first - most)), begin, end, int(np.searchsorted(x, last + most, "right"))


def _facets_of(points: Floats, largest: Floats, begin: int, end: int) -> tuple[NDArray[np.int32], Floats]:
    """Facets with their first corner in begin..end - 1: rows of points (k, 3), ascending, and radii (k,).

    Four far points are added, lest a flat cloud have no tetrahedra, and the hull's facets only one side. Qhull leaves
    cells without volume between points on one sphere, which do no harm: a point in a facet's plane bounds no sphere.
    """
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    more = [_fillers(points, 2 * largest), FAR / np.sqrt(3) * corners]
    space = Delaunay(np.concatenate([points, *more]), qhull_options="Qbb Qc Q12")
    cells, beyond = np.ascontiguousarray(space.simplices), np.ascontiguousarray(space.neighbors)
    rows, radii = np.empty((2 * len(cells), 3), np.int32), np.empty(2 * len(cells))
    count = kernels.small_facets(space.points, cells, beyond, np.ascontiguousarray(largest), begin, end, rows, radii)
    return rows[:count].copy(), radii[:count].copy()


def _fillers(points: Floats, reach: Floats) -> Floats:
    """Points spread evenly through the space that is farther from all points than their `reach`, (n,), two radii.

    No sphere that is small enough holds one of them, so that they change neither the facets nor their radii. But the
    tubes and cylinders of machines have many points on each of many large empty spheres, and without fillers Qhull
    takes ten times as long to join them.
    """
    if not np.isfinite(reach).all():
        return np.empty((0, 3))
    size = np.maximum(np.ptp(points, axis=0), np.median(reach))
    number = np.maximum(np.round(size * np.cbrt(FILLERS * len(points) / size.prod())), 1).astype(np.int64)
    lattice = np.indices(number.tolist()).reshape(3, -1).T
    moved = lattice + 0.5 + JITTER * (np.random.default_rng(0).random(lattice.shape) - 0.5)
    places = points.min(axis=0) + moved * size / number
    near = cKDTree(places).query_ball_point(points, reach)
    return np.delete(places, np.unique(np.fromiter(chain.from_iterable(near), np.int64)), axis=0)


def spacing(points: Floats) -> Floats:
    """Distance of each of (n, 3) points from its sixth nearest neighbour, or from the last there is, (n,)."""
    count = min(NEIGHBOURS + 1, len(points))
    distance, _ = cKDTree(points).query(points, [count])
    return np.asarray(distance, np.float64).ravel()
