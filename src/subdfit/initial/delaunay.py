"""Facets of the Delaunay tetrahedralisation of a cloud, with the smallest empty sphere of each."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay, cKDTree

from subdfit.initial import _delaunay_kernels as kernels
from subdfit.parallel import map_chunks

Floats = NDArray[np.float64]

FAR = 2.0
"""Distance of the four outer points from the centre: their tetrahedron contains a ball of radius 2/3."""

NEIGHBOURS = 6
"""The spacing at a point is the distance to this nearest neighbour: where the sampling is regular, the first ring."""

LEAST_SLAB = 1 << 14
"""Points that are worth a slab of their own."""

MOST_OVERLAP = 0.2
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

    A sphere of a facet may be as large as `largest`, (n,), at one of its corners. So facets depend on nothing farther
    off than twice the largest radius: each is found in a slab of points that reaches so far beyond its first corner.
    """
    slabs = _slabs(points[:, 0], 2 * float(largest.max()))

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


def _slabs(x: Floats, reach: float) -> NDArray[np.int64]:
    """Rows low, begin, end, high of slabs (s, 4) of points at ascending x.

    Points begin..end - 1 are in one slab only, low..high - 1 are what is within reach of them. There are as many slabs
    as can be without much overlap.
    """
    for count in range(len(x) // LEAST_SLAB, 1, -1):
        bounds = np.arange(count + 1) * len(x) // count
        begin, end = bounds[:-1], bounds[1:]
        low, high = np.searchsorted(x, x[begin] - reach), np.searchsorted(x, x[end - 1] + reach, "right")
        if np.sum(high - low) <= (1 + MOST_OVERLAP) * len(x):
            return np.stack([low, begin, end, high], axis=1)
    return np.array([[0, 0, len(x), len(x)]])


def _facets_of(points: Floats, largest: Floats, begin: int, end: int) -> tuple[NDArray[np.int32], Floats]:
    """Facets with their first corner in begin..end - 1: rows of points (k, 3), ascending, and radii (k,).

    Four far points are added, lest a flat cloud have no tetrahedra, and the hull's facets only one side. Qhull leaves
    cells without volume between points on one sphere, which do no harm: a point in a facet's plane bounds no sphere.
    """
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    space = Delaunay(np.concatenate([points, FAR / np.sqrt(3) * corners]), qhull_options="Qbb Qc Q12")
    cells, beyond = np.ascontiguousarray(space.simplices), np.ascontiguousarray(space.neighbors)
    rows, radii = np.empty((2 * len(cells), 3), np.int32), np.empty(2 * len(cells))
    count = kernels.small_facets(space.points, cells, beyond, np.ascontiguousarray(largest), begin, end, rows, radii)
    return rows[:count].copy(), radii[:count].copy()


def spacing(points: Floats) -> Floats:
    """Distance of each of (n, 3) points from its sixth nearest neighbour, or from the last there is, (n,)."""
    count = min(NEIGHBOURS + 1, len(points))
    distance, _ = cKDTree(points).query(points, [count])
    return np.asarray(distance, np.float64).ravel()
