"""Closest points on triangles and on polylines, by a bounding-volume hierarchy."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.parallel import map_chunks
from subdfit.target import _bvh_build_kernels as building
from subdfit.target import _bvh_kernels as kernels

S = TypeVar("S", bound=np.generic)

_CHUNK = 4096
_PACK_CHUNK = 65536


@dataclass(frozen=True)
class Closest:
    """Closest points of q queries on a set of triangles.

    Attributes
    ----------
    triangle : (q,) int32, row of the triangle.
    uv : (q, 2) float64; the closest point is ``(1 - u - v) a + u b + v c``.
    distance : (q,) float64, in the unit of the points.
    """

    triangle: NDArray[np.int32]
    uv: NDArray[np.float64]
    distance: NDArray[np.float64]


@dataclass(frozen=True)
class ClosestOnSegments:
    """Closest points of q queries on a set of segments.

    Attributes
    ----------
    segment : (q,) int32, row of the segment.
    parameter : (q,) float64 in [0, 1]; the closest point is ``(1 - t) a + t b``.
    distance : (q,) float64, in the unit of the points.
    """

    segment: NDArray[np.int32]
    parameter: NDArray[np.float64]
    distance: NDArray[np.float64]


def _require(array: NDArray[Any] | Sequence[Any], dtype: type[S]) -> NDArray[S]:
    """Return the array as kernels want it: contiguous and writeable, or they would be compiled once more."""
    return np.require(array, dtype, ["C", "W", "A", "E"])


def _finite(points: NDArray[np.float64], what: str) -> NDArray[np.float64]:
    """Points (n, 3) fit for a kernel; beyond 1e70 the squares of areas would overflow."""
    points = _require(points, np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"a {what} needs three coordinates; got an array of shape {points.shape}")
    good = np.abs(points) < 1e70
    if not np.all(good):
        row = int(np.argmin(good.all(axis=1)))
        raise InputError(f"{what} {row} has a coordinate that is not finite or too large; remove it or rescale")
    return points


class TriangleTree:
    """Bounding-volume hierarchy over triangles in space.

    Built top-down by the surface-area heuristic over bins (Wald 2007) in O(m log m); the same input gives
    the same tree. Kernels that search inside their own loops take the arrays `boxes`, `children`,
    `corners`, `rows`, `slots` and `inflation` as described in ``_bvh_build_kernels.py``.

    Parameters
    ----------
    points : (n, 3) float64, finite.
    triangles : (m, 3) int, rows of `points`; m >= 1. Triangles without area are allowed.
    inflation : (m,) float64, optional
        The true surface lies within this distance of its triangle; boxes grow by it. Default 0.

    Raises
    ------
    InputError
        No triangle, a row that is no point, or a coordinate that is not finite.
    """

    def __init__(
        self,
        points: NDArray[np.float64],
        triangles: NDArray[np.integer],
        *,
        inflation: NDArray[np.float64] | None = None,
    ) -> None:
        count = len(triangles)
        if count == 0:
            raise InputError("closest points need at least one triangle; got none")
        self.triangles = _require(triangles, np.int32)
        points = self._checked(points)
        self.inflation = np.zeros(count) if inflation is None else self._one_each(inflation)
        self.rows = np.arange(count, dtype=np.int32)
        boxes = np.empty((max(count - 1, 1), 2, 6))
        children = np.empty((max(count - 1, 1), 2), np.int32)
        nodes = building.build(self._triangle_boxes(points), self.rows, boxes, children)
        self.boxes, self.children = boxes[:nodes].copy(), children[:nodes].copy()
        self.corners = np.empty((count, 9))
        self._pack(points)
        self.slots = np.empty(count, np.int32)
        self.slots[self.rows] = np.arange(count, dtype=np.int32)

    def _checked(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        points = _finite(points, "point")
        if self.triangles.min() < 0 or self.triangles.max() >= len(points):
            raise InputError(f"a triangle refers to a point outside 0..{len(points) - 1}; check the faces")
        return points

    def _one_each(self, inflation: NDArray[np.float64]) -> NDArray[np.float64]:
        if np.shape(inflation) != (len(self.triangles),):
            raise InputError(f"{np.size(inflation)} inflations for {len(self.triangles)} triangles; give one each")
        return _require(inflation, np.float64)

    def _triangle_boxes(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        boxes = np.empty((len(self.rows), 6))

        def job(start: int, stop: int) -> None:
            building.triangle_boxes(points, self.triangles, self.inflation, start, stop, boxes)

        map_chunks(job, len(self.rows), _PACK_CHUNK)
        return boxes

    def _pack(self, points: NDArray[np.float64]) -> None:
        """Write the corners in leaf order."""

        def job(start: int, stop: int) -> None:
            building.pack_corners(points, self.triangles, self.rows, start, stop, self.corners)

        map_chunks(job, len(self.rows), _PACK_CHUNK)

    def refit(self, points: NDArray[np.float64], *, inflation: NDArray[np.float64] | None = None) -> None:
        """Move the triangles to new points, (n, 3) float64, in linear time; the tree's shape stays.

        Searches stay exact but slow down as the points leave the places for which the tree was built.
        """
        if inflation is not None:
            self.inflation = self._one_each(inflation)
        self._pack(self._checked(points))
        building.refit(self.children, self.corners, self.rows, self.inflation, self.boxes)

    def closest(
        self, queries: NDArray[np.float64], *, start: NDArray[np.int32] | None = None, enough: float = 0.0
    ) -> Closest:
        """Closest points on the triangles.

        Parameters
        ----------
        queries : (q, 3) float64, in any order.
        start : (q,) int32, optional
            A triangle likely to be near each query, -1 for none; it saves time and changes nothing but
            which of several equally near triangles is named.
        enough : float
            The search for a query ends at a triangle found within this distance, though another may be nearer still.
        """
        queries = _finite(queries, "query")
        guess = np.full(len(queries), -1, np.int32) if start is None else _require(start, np.int32)
        if guess.shape != (len(queries),) or guess.max(initial=-1) >= len(self.triangles):
            raise InputError(f"start must name one of the {len(self.triangles)} triangles for each query, or -1")
        order = self._coherent_order(queries)
        triangle = np.empty(len(queries), np.int32)
        uv = np.empty((len(queries), 2))
        distance = np.empty(len(queries))

        def job(first: int, last: int) -> None:
            kernels.nearest_of_many(
                self.boxes, self.children, self.corners, self.rows, self.slots,
                queries, order[first:last], guess, enough, triangle, uv, distance,
            )  # fmt: skip

        map_chunks(job, len(queries), _CHUNK)
        return Closest(triangle, uv, distance)

    def _coherent_order(self, queries: NDArray[np.float64]) -> NDArray[np.int64]:
        """Order in which neighbours in space follow one another, so that the nodes they visit are cached."""
        if len(queries) == 0:
            return np.empty(0, np.int64)
        low, high = self.boxes[0, :, :3].min(axis=0), self.boxes[0, :, 3:].max(axis=0)
        extent = float(np.max(high - low))
        scale = 1024.0 / extent if extent > 1e-150 else 0.0
        codes = np.empty(len(queries), np.uint32)

        def job(first: int, last: int) -> None:
            kernels.morton_codes(queries, low, scale, first, last, codes)

        map_chunks(job, len(queries), _PACK_CHUNK)
        order: NDArray[np.int64] = np.argsort(codes)
        return order

    def within(
        self, queries: NDArray[np.float64], radii: NDArray[np.float64]
    ) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float64]]:
        """All triangles whose inflated surface may come within a radius of each query.

        Parameters
        ----------
        queries : (q, 3) float64.
        radii : (q,) float64.

        Returns
        -------
        offsets : (q + 1,) int64; query q owns the entries ``offsets[q]`` to ``offsets[q + 1]`` below.
        triangle : int32, those with ``distance - inflation <= radius``, in no particular order.
        bound : float64, their ``distance - inflation``.
        """
        queries, radii = _finite(queries, "query"), _require(radii, np.float64)
        if radii.shape != (len(queries),):
            raise InputError(f"{radii.size} radii for {len(queries)} queries; give one each")
        offsets = np.zeros(len(queries) + 1, np.int64)
        counts = self._collect(queries, radii, offsets, np.empty(0, np.int32), np.empty(0))
        np.cumsum(counts, out=offsets[1:])
        found, bounds = np.empty(offsets[-1], np.int32), np.empty(offsets[-1])
        self._collect(queries, radii, offsets, found, bounds)
        return offsets, found, bounds

    def _collect(
        self,
        queries: NDArray[np.float64],
        radii: NDArray[np.float64],
        offsets: NDArray[np.int64],
        found: NDArray[np.int32],
        bounds: NDArray[np.float64],
    ) -> NDArray[np.int64]:
        def job(start: int, stop: int) -> NDArray[np.int64]:
            counts: NDArray[np.int64] = kernels.collect_for_many(
                self.boxes, self.children, self.corners, self.rows, self.inflation,
                queries, radii, start, stop, offsets, found, bounds,
            )  # fmt: skip
            return counts

        return np.concatenate([np.empty(0, np.int64), *map_chunks(job, len(queries), _CHUNK)])


class SegmentTree:
    """The same over segments, kept as triangles ``(a, b, b)``.

    Parameters
    ----------
    points : (n, 3) float64, finite.
    edges : (e, 2) int, rows of `points`; e >= 1.

    Raises
    ------
    InputError
        No segment, a row that is no point, or a coordinate that is not finite.
    """

    def __init__(self, points: NDArray[np.float64], edges: NDArray[np.integer]) -> None:
        if len(edges) == 0:
            raise InputError("closest points need at least one segment; got none")
        self.tree = TriangleTree(points, np.asarray(edges)[:, [0, 1, 1]])
        self._ends = np.asarray(points)[np.asarray(edges)]

    def closest(self, queries: NDArray[np.float64]) -> ClosestOnSegments:
        """Closest points on the segments for `queries`, (q, 3) float64."""
        found = self.tree.closest(queries)
        return ClosestOnSegments(found.triangle, np.minimum(found.uv.sum(axis=1), 1.0), found.distance)

    def on_segments(self, found: ClosestOnSegments) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The closest points, (q, 3), and the directions of their segments, (q, 3) unit vectors."""
        begin, end = self._ends[found.segment, 0], self._ends[found.segment, 1]
        along = end - begin
        length = np.linalg.norm(along, axis=1, keepdims=True)
        along = np.divide(along, length, out=np.zeros_like(along), where=length > 0)
        return begin + found.parameter[:, None] * (end - begin), along
