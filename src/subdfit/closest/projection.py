"""Closest points on a limit surface: found globally by a tree, made exact by Newton's method."""

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from subdfit.closest import _kernels as kernels
from subdfit.limit._kernels import order_by_cell
from subdfit.limit.surface import LimitSurface
from subdfit.limit.tessellate import Lattice, cut, grid_nodes, lattice
from subdfit.parallel import map_chunks
from subdfit.schemes.domain import CORNERS, QUAD, TRIANGLE
from subdfit.target.bvh import TriangleTree

Floats = NDArray[np.float64]

CHUNK = 4096
SEGMENTS, SEGMENTS_OF_PARTS = 3, 2
"""Segments a cell side in the tree's triangles, where cells are whole faces and where they are parts of them."""
AT_CORNER, NEAR_CORNER = 1e-6, 0.8
"""Footpoints this close to a vertex, of weight 1 at it, and beyond this weight near one with kinks, are tried again."""
ROUND = 0.1
"""How far along the sides of a corner places to try lie."""


@dataclass(frozen=True, eq=False)
class Projection:
    """Footpoints of data points.

    Attributes
    ----------
    face : (k,) int32 and uv (k, 2) float64, where they lie.
    distance : (k,) float64, in the control points' unit.
    converged : (k,) bool.
    """

    face: NDArray[np.int32]
    uv: Floats
    distance: Floats
    converged: NDArray[np.bool_]


class Projector:
    """Finds footpoints on one limit surface.

    Parameters
    ----------
    surface
        The surface.
    tolerance
        A footpoint is settled when its next step on the surface is shorter than this, in the control points' unit;
        None takes 1e-8 of the control mesh's extent.
    second_order
        Use second derivatives (Newton's method); without them the tangent-plane iteration of Nishiyama et al. 2008.
    """

    def __init__(self, surface: LimitSurface, tolerance: float | None = None, second_order: bool = True) -> None:
        self.surface = surface
        extent = float(np.linalg.norm(np.ptp(surface.control_mesh.points, axis=0)))
        self.tolerance = 1e-8 * extent if tolerance is None else tolerance
        self.second_order = second_order
        domain = surface.domain
        ends = domain.sharp | (domain.neighbour < 0)
        self._cells = kernels.Cells(domain.shape, domain.neighbour, domain.neighbour_side, ends)

    def refine(
        self,
        points: Floats,
        face: NDArray[np.int32],
        uv: Floats,
        rows: NDArray[np.int64] | None = None,
        iterations: int = 20,
    ) -> Projection:
        """Move footpoints from where they stand to the nearest point reachable downhill.

        Parameters
        ----------
        points
            (k, 3) data.
        face, uv
            (k,) and (k, 2): where to start; not changed.
        rows
            The rows to treat, best sorted by face; None treats all.
        iterations
            Most Newton steps a point.
        """
        cell, parameter = np.array(face, np.int32), np.array(uv, np.float64)
        squared = np.zeros(len(cell))
        converged = np.ones(len(cell), np.bool_)
        order = self.order(cell) if rows is None else rows

        def job(start: int, stop: int) -> None:
            kernels.project(
                self.surface.patches,
                self._cells,
                points,
                order,
                start,
                stop,
                self.tolerance,
                iterations,
                self.second_order,
                cell,
                parameter,
                squared,
                converged,
            )

        map_chunks(job, len(order), CHUNK)
        return Projection(cell, parameter, np.sqrt(squared), converged)

    def order(self, face: NDArray[np.int32]) -> NDArray[np.int64]:
        """Order of points by face, in which evaluation is fastest."""
        ordered: NDArray[np.int64] = order_by_cell(face, self.surface.domain.face_count)
        return ordered

    def start(self, points: Floats) -> tuple[NDArray[np.int32], Floats]:
        """Nearest points on a triangulation of the surface: faces (k,) and parameters (k, 2)."""
        found = self._tree.closest(points)
        return self._on_surface(found.triangle, found.uv)

    def nearest(self, points: ArrayLike) -> Projection:
        """Find footpoints from nothing: the nearest triangle, then Newton's method."""
        data = np.ascontiguousarray(points, np.float64)
        return self.refine(data, *self.start(data))

    def certain(self, points: ArrayLike) -> Projection:
        """Find footpoints as `nearest` does, then try every part of the surface that may come nearer still.

        Parts are ruled out by how far the surface strays from the tree's triangles (estimated with a safety factor).
        """
        data = np.ascontiguousarray(points, np.float64)
        best = self.nearest(data)
        offsets, triangle, _ = self._inflated_tree.within(data, best.distance - self.tolerance)
        point = np.repeat(np.arange(len(data)), np.diff(offsets))
        other = triangle != self._triangle_under(best.face, best.uv)[point]
        face, uv = self._on_surface(triangle[other], np.full((np.count_nonzero(other), 2), 1 / 3))
        self._try(data, best, point[other], face, uv)
        self._try(data, best, *self._kinks_nearer(data, best))
        self._try(data, best, *self._round_corners(best))
        return best

    def _try(
        self, data: Floats, best: Projection, point: NDArray[np.int64], face: NDArray[np.int32], uv: Floats
    ) -> None:
        """Start anew from given places, several a point, and keep what is nearer than `best`."""
        if len(point) == 0:
            return
        tried = self.refine(data[point], face, uv, iterations=100)
        order = np.lexsort((tried.distance, point))
        first = order[np.r_[True, point[order][1:] != point[order][:-1]]]
        better = first[tried.distance[first] < best.distance[point[first]]]
        rows = point[better]
        best.face[rows], best.uv[rows] = tried.face[better], tried.uv[better]
        best.distance[rows], best.converged[rows] = tried.distance[better], tried.converged[better]

    def _kinks_nearer(self, data: Floats, best: Projection) -> tuple[NDArray[np.int64], NDArray[np.int32], Floats]:
        """Vertices with kinks that are nearer than the footpoints: from elsewhere descent may pass them by."""
        kinked = np.flatnonzero(self._kinked)
        if len(kinked) == 0:
            return np.empty(0, np.int64), np.empty(0, np.int32), np.empty((0, 2))
        start, cells, corners = self._fans
        cell, corner = cells[start[kinked]].astype(np.int32), corners[start[kinked]]
        at = CORNERS[self.surface.domain.shape[cell], corner]
        limits = self.surface.evaluate(cell, at).position
        distance, which = cKDTree(limits).query(data)
        point, which = np.flatnonzero(distance < best.distance), np.asarray(which, np.int64)
        return point, cell[which[point]], at[which[point]]

    def _round_corners(self, best: Projection) -> tuple[NDArray[np.int64], NDArray[np.int32], Floats]:
        """Places to try for footpoints near a vertex with kinks, or stuck at one: that vertex, and round it."""
        domain = self.surface.domain
        weights = corner_weights(domain.shape[best.face], best.uv)
        corner = weights.argmax(axis=1)
        largest = weights[np.arange(len(corner)), corner]
        vertex = domain.points[best.face, corner]
        doubtful = ~best.converged | (largest > 1 - AT_CORNER) | (self._kinked[vertex] & (largest > NEAR_CORNER))
        point = np.flatnonzero(doubtful)
        start, cells, corners = self._fans
        count = start[vertex[point] + 1] - start[vertex[point]]
        rows = (
            np.repeat(start[vertex[point]], count) + np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        )
        tries = self._round(cells[rows], corners[rows])
        faces = np.repeat(cells[rows], tries.shape[1]).astype(np.int32)
        return np.repeat(np.repeat(point, count), tries.shape[1]), faces, tries.reshape(-1, 2).copy()

    def _round(self, cell: NDArray[np.int64], corner: NDArray[np.int64]) -> Floats:
        """A corner of each cell, and places on the two sides there, (k, 3, 2)."""
        domain = self.surface.domain
        at = CORNERS[domain.shape[cell], corner]
        ahead = CORNERS[domain.shape[cell], domain.next_corner(cell, corner)]
        behind = CORNERS[domain.shape[cell], (corner - 1) % domain.shape[cell]]
        return np.stack([at, at + ROUND * (ahead - at), at + ROUND * (behind - at)], axis=1)

    @cached_property
    def _kinked(self) -> NDArray[np.bool_]:
        """Corner points of cells on creases and boundaries, and tagged corners."""
        domain, topology = self.surface.domain, self.surface.topology
        flags = np.zeros(len(self._fans[0]) - 1, np.bool_)
        flags[: topology.vertex_count] = topology.corner_sharpness > 0
        cell, side = np.nonzero(domain.sharp & domain.present)
        flags[domain.points[cell, side]] = True
        flags[domain.points[cell, domain.next_corner(cell, side)]] = True
        # A tagged vertex may be no corner of any cell.
        return np.asarray(flags & (np.diff(self._fans[0]) > 0))

    @cached_property
    def _fans(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """For each corner point the cells round it and which of their corners it is, as offsets and two lists."""
        domain = self.surface.domain
        cell, corner = np.nonzero(domain.present)
        at = domain.points[cell, corner]
        order = np.argsort(at, kind="stable")
        count = np.bincount(at, minlength=self.surface.topology.vertex_count)
        return np.concatenate([[0], np.cumsum(count)]), cell[order], corner[order]

    def _on_surface(self, triangle: NDArray[np.int32], uv: Floats) -> tuple[NDArray[np.int32], Floats]:
        cell = self._cell_under[triangle]
        corners = _tree_triangles(self._segments)[self.surface.domain.shape[cell], triangle - self._grid.begin[cell]]
        weights = np.column_stack([1 - uv.sum(axis=1), uv])
        return cell, np.clip(np.einsum("ki,kid->kd", weights, corners), 0, 1)

    def _triangle_under(self, face: NDArray[np.int32], uv: Floats) -> NDArray[np.int64]:
        """The tree's triangle that holds each surface point, (k,): rows as `tessellate.cut` counts them."""
        quad, segments = self.surface.domain.shape[face] == QUAD, self._segments
        scaled = uv * segments
        low = np.minimum(scaled.astype(np.int64), segments - 1)
        low[:, 1] = np.where(quad, low[:, 1], np.minimum(low[:, 1], segments - 1 - low[:, 0]))
        i, j = low.T
        down = (scaled - low).sum(axis=1) > 1
        missing = np.where(quad, 0, j * (j - 1) // 2)
        up_row = j * segments - missing + i
        below = np.where(quad, segments * segments, segments * (segments + 1) // 2)
        down_row = below + j * np.where(quad, segments, segments - 1) - missing + i
        return np.asarray(self._grid.begin[face] + np.where(down, down_row, up_row), np.int64)

    @property
    def _segments(self) -> int:
        return SEGMENTS_OF_PARTS if self.surface.domain.parts else SEGMENTS

    @cached_property
    def _grid(self) -> Lattice:
        return lattice(self.surface.domain, self._segments)

    @cached_property
    def _cell_under(self) -> NDArray[np.int32]:
        """The cell of each of the tree's triangles."""
        return np.repeat(np.arange(self.surface.domain.face_count, dtype=np.int32), np.diff(self._grid.begin))

    @cached_property
    def _tree(self) -> TriangleTree:
        return TriangleTree(self._grid_points, self._grid.triangles)

    @cached_property
    def _inflated_tree(self) -> TriangleTree:
        """The tree whose triangles know how far the surface may stray from them, by how far it does in their middle."""
        grid = self._grid
        rows = np.arange(len(grid.triangles), dtype=np.int32)
        middle = self._on_surface(rows, np.full((len(rows), 2), 1 / 3))
        stray = self.surface.evaluate(*middle).position - self._grid_points[grid.triangles].mean(axis=1)
        return TriangleTree(self._grid_points, grid.triangles, inflation=2.0 * np.linalg.norm(stray, axis=1))

    @cached_property
    def _grid_points(self) -> Floats:
        return self.surface.evaluate(self._grid.face, self._grid.uv).position


def corner_weights(shape: NDArray[np.int8], uv: Floats) -> Floats:
    """Linear weights of a triangle's corners, bilinear ones of a quad's, (k, 4)."""
    u, v = uv.T
    bilinear = np.column_stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v])
    linear = np.column_stack([1 - u - v, u, v, np.full(len(u), -1.0)])
    return np.where((shape == QUAD)[:, None], bilinear, linear)


@cache
def _tree_triangles(segments: int) -> Floats:
    """Parameters of the corners of a cell's triangles in the tree, by shape, (5, 2 segments^2, 3, 2)."""
    table = np.zeros((QUAD + 1, 2 * segments**2, 3, 2))
    for shape in (TRIANGLE, QUAD):
        rows = cut(shape, segments)
        table[shape, : len(rows)] = np.array(grid_nodes(shape, segments))[rows] / segments
    return table
