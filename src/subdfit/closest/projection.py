"""Closest points on a limit surface: found globally by a tree, made exact by Newton's method."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from subdfit.closest import _kernels as kernels
from subdfit.limit._kernels import order_by_cell
from subdfit.limit.surface import LimitSurface
from subdfit.limit.tessellate import lattice
from subdfit.parallel import map_chunks
from subdfit.target.bvh import TriangleTree

Floats = NDArray[np.float64]

CHUNK = 4096
SEGMENTS = 3
"""Segments a cell side in the tree's triangles."""
AT_CORNER, NEAR_CORNER = 1e-6, 0.8
"""Footpoints this close to a vertex, of weight 1 at it, and beyond this weight near one with kinks, are tried again."""
_ROUND = np.array(
    [
        [[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]],
        [[1.0, 0.0], [0.9, 0.1], [0.9, 0.0]],
        [[0.0, 1.0], [0.0, 0.9], [0.1, 0.9]],
    ]
)
"""For each corner of a cell: the corner itself, and places on its two sides."""


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
        self._cells = kernels.Cells(domain.neighbour, domain.neighbour_side, domain.sharp)

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
        offsets, triangle, _ = self._tree.within(data, best.distance - self.tolerance)
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
        limits = self.surface.evaluate(cell, _ROUND[corner, 0]).position
        distance, which = cKDTree(limits).query(data)
        point, which = np.flatnonzero(distance < best.distance), np.asarray(which, np.int64)
        return point, cell[which[point]], _ROUND[corner[which[point]], 0]

    def _round_corners(self, best: Projection) -> tuple[NDArray[np.int64], NDArray[np.int32], Floats]:
        """Places to try for footpoints near a vertex with kinks, or stuck at one: that vertex, and round it."""
        domain = self.surface.domain
        weights = np.column_stack([1 - best.uv.sum(axis=1), best.uv])
        corner = weights.argmax(axis=1)
        largest = weights[np.arange(len(corner)), corner]
        vertex = domain.vertex[best.face, corner]
        doubtful = ~best.converged | (largest > 1 - AT_CORNER) | (self._kinked[vertex] & (largest > NEAR_CORNER))
        point = np.flatnonzero(doubtful)
        start, cells, corners = self._fans
        count = start[vertex[point] + 1] - start[vertex[point]]
        rows = (
            np.repeat(start[vertex[point]], count) + np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        )
        tries = _ROUND[corners[rows]]
        faces = np.repeat(cells[rows], tries.shape[1]).astype(np.int32)
        return np.repeat(np.repeat(point, count), tries.shape[1]), faces, tries.reshape(-1, 2).copy()

    @cached_property
    def _kinked(self) -> NDArray[np.bool_]:
        """Vertices on creases and boundaries, and tagged corners."""
        domain, topology = self.surface.domain, self.surface.topology
        flags = topology.corner_sharpness > 0
        cell, side = np.nonzero(domain.sharp[:, :3])
        flags[domain.vertex[cell, side]] = True
        flags[domain.vertex[cell, (side + 1) % 3]] = True
        return np.asarray(flags)

    @cached_property
    def _fans(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """For each vertex the cells round it and which of their corners it is, as offsets and two lists."""
        at = self.surface.domain.vertex[:, :3].ravel()
        order = np.argsort(at, kind="stable")
        count = np.bincount(at, minlength=self.surface.topology.vertex_count)
        return np.concatenate([[0], np.cumsum(count)]), order // 3, order % 3

    def _on_surface(self, triangle: NDArray[np.int32], uv: Floats) -> tuple[NDArray[np.int32], Floats]:
        corners = self._corner_uv[triangle % (SEGMENTS * SEGMENTS)]
        weights = np.column_stack([1 - uv.sum(axis=1), uv])
        inside = np.clip(np.einsum("ki,kid->kd", weights, corners), 0, 1)
        return (triangle // (SEGMENTS * SEGMENTS)).astype(np.int32), inside

    def _triangle_under(self, face: NDArray[np.int32], uv: Floats) -> NDArray[np.int64]:
        """The tree's triangle that holds each surface point, (k,)."""
        scaled = uv * SEGMENTS
        low = np.minimum(scaled.astype(np.int64), SEGMENTS - 1)
        low[:, 1] = np.minimum(low[:, 1], SEGMENTS - 1 - low[:, 0])
        i, j = low.T
        down = (scaled - low).sum(axis=1) > 1
        up_row = j * SEGMENTS - j * (j - 1) // 2 + i
        down_row = SEGMENTS * (SEGMENTS + 1) // 2 + j * (SEGMENTS - 1) - j * (j - 1) // 2 + i
        return np.asarray(face.astype(np.int64) * SEGMENTS**2 + np.where(down, down_row, up_row), np.int64)

    @cached_property
    def _corner_uv(self) -> Floats:
        """Parameters of the corners of a cell's triangles, (SEGMENTS^2, 3, 2)."""
        nodes = [(i, j) for j in range(SEGMENTS + 1) for i in range(SEGMENTS + 1 - j)]
        up = [((i, j), (i + 1, j), (i, j + 1)) for i, j in nodes if i + j < SEGMENTS]
        down = [((i + 1, j), (i + 1, j + 1), (i, j + 1)) for i, j in nodes if i + j < SEGMENTS - 1]
        return np.array(up + down) / SEGMENTS

    @cached_property
    def _tree(self) -> TriangleTree:
        grid = lattice(self.surface.domain, SEGMENTS)
        vertices = self.surface.evaluate(grid.face, grid.uv).position
        cells = np.repeat(np.arange(self.surface.domain.face_count), SEGMENTS * SEGMENTS)
        middle = np.tile(self._corner_uv.mean(axis=1), (self.surface.domain.face_count, 1))
        stray = self.surface.evaluate(cells, middle).position - vertices[grid.triangles].mean(axis=1)
        return TriangleTree(vertices, grid.triangles, inflation=2.0 * np.linalg.norm(stray, axis=1))
