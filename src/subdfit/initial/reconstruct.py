"""A triangle mesh through unorganised points: greedy reconstruction from Delaunay facets."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from subdfit.initial._reconstruct_kernels import grow
from subdfit.initial.cloud_checks import check_extent, check_joined, check_surface, tell
from subdfit.initial.delaunay import small_facets, spacing
from subdfit.initial.distinct import distinct, normalised
from subdfit.initial.holes import fill_holes
from subdfit.initial.normals import known_normals
from subdfit.initial.orient import components_of, oriented_outward
from subdfit.initial.reconstruct_cgal import cgal_triangles

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

GAP = 2.0
"""Voids wider than so many spacings are holes. The largest empty circle among a million random points measures about
1.3 spacings, so that no uniform sampling is torn, however irregular."""

SPARSEST = 5.0
"""No surface begins at triangles of more than so many median spacings: a few outliers may form one by chance."""

SMALL_HOLE = 8
"""Edges of the longest hole that is closed afterwards: far below what `GAP` would leave open."""


@dataclass(frozen=True, eq=False)
class Reconstructed:
    """A manifold triangle mesh whose vertices are points of a cloud.

    Attributes
    ----------
    points : (k, 3) float64, the points on the surface, in the cloud's order and unit.
    triangles : (m, 3) int64, rows of `points`; each component is oriented outward.
    point_rows : (k,) int64, the cloud's row of each of `points`.
    left_out : (l,) int64, rows of the cloud that are not on the surface; repeats of points on it do not count.
    repeated : number of points that repeat another's position.
    """

    points: Floats
    triangles: Rows
    point_rows: Rows
    left_out: Rows
    repeated: int


def greedy_triangles(points: Floats, gap: float) -> Rows:
    """Choose triangles among distinct normalised points (n, 3), ascending by x: own engine.

    The result is an oriented manifold, (m, 3) int64.
    """
    distance = spacing(points)
    facets = small_facets(points, gap * distance)
    seeds = np.flatnonzero(facets.radii <= SPARSEST * np.median(distance))
    seeds = seeds[np.argsort(facets.radii[seeds], kind="stable")]
    triangles = np.empty((len(facets.radii), 3), np.int64)
    state = np.zeros(len(points), np.int8)
    count = grow(seeds, facets.points, facets.corners, facets.offsets, facets.at, facets.radii, state, triangles)
    return _dense(points, triangles[:count], SPARSEST * float(np.median(distance)))


def _dense(points: Floats, triangles: Rows, longest: float) -> Rows:
    """Leave out the components of which most triangles are longer than that: they join outliers."""
    component, count = components_of(triangles, len(points))
    corners = points[triangles]
    length = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    long = np.bincount(component, length > longest, count) > 0.5 * np.bincount(component, minlength=count)
    return triangles[~long[component]].copy()


ENGINES: dict[str, Callable[[Floats, float], Rows]] = {"greedy": greedy_triangles, "cgal": cgal_triangles}
"""From distinct normalised points, ascending by x, and a gap to oriented manifold triangles."""


def reconstruct(
    points: ArrayLike,
    normals: ArrayLike | None = None,
    *,
    gap: float = GAP,
    small_hole: int = SMALL_HOLE,
    engine: str = "greedy",
    name: str = "points",
) -> Reconstructed:
    """Join points to a surface through them.

    Triangles are chosen among the facets of the Delaunay tetrahedralisation, the most plausible first: those with
    small empty spheres that continue the surface smoothly. The result is an oriented manifold by construction; where
    nothing continues it, it has a boundary. Points that fit nowhere (noise, outliers) are left out.

    Parameters
    ----------
    points : (n, 3)
        Positions, in any unit, order and place; repeats count once.
    normals : (n, 3), optional
        Decide which side is outside; zero rows where unknown.
    gap : float
        Voids wider than so many spacings are holes; infinity leaves the decision to the angles, as the paper does.
    small_hole : int
        Holes of at most so many edges are closed afterwards.
    engine : str
        ``greedy``, or ``cgal`` for that library's implementation (an extra; it knows no `gap`).
    name : str
        What messages call the cloud.

    Raises
    ------
    InputError
        Too few points, or no clean surface through them.

    References
    ----------
    Cohen-Steiner and Da, A greedy Delaunay-based surface reconstruction algorithm, The Visual Computer 20, 2004.
    """
    positions = np.array(points, np.float64, order="C").reshape(-1, 3)
    inside = normalised(positions, name)
    first = distinct(inside)
    check_extent(inside[first], len(positions), name)
    triangles = ENGINES[engine](inside[first], gap)
    check_joined(inside[first], triangles, name)
    used, triangles = _compact(first[triangles], len(positions))
    triangles = _closed(inside[used], triangles, small_hole)
    check_surface(inside[used], triangles, name)
    known = None if normals is None else known_normals(normals, name)[used]
    left_out, repeated = np.setdiff1d(first, used), len(positions) - len(first)
    tell(len(left_out), repeated, len(positions), name)
    return Reconstructed(
        points=positions[used],
        triangles=oriented_outward(inside[used], triangles, known),
        point_rows=used,
        left_out=left_out,
        repeated=repeated,
    )


def _compact(triangles: Rows, points: int) -> tuple[Rows, Rows]:
    """The rows that occur, ascending, and the triangles in terms of them."""
    occurs = np.zeros(points, np.bool_)
    occurs[triangles] = True
    return np.flatnonzero(occurs), (np.cumsum(occurs) - 1)[triangles]


def _closed(points: Floats, triangles: Rows, small_hole: int) -> Rows:
    """Close small holes without new points."""
    filled = fill_holes(points, triangles, small_hole)
    return filled.triangles[(filled.triangles < len(points)).all(axis=1)]
