"""Closest points on a limit surface: found globally by a tree, made exact by Newton's method."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from subdfit.closest import _kernels as kernels
from subdfit.limit.surface import LimitSurface
from subdfit.limit.tessellate import lattice
from subdfit.parallel import map_chunks
from subdfit.target.bvh import TriangleTree

Floats = NDArray[np.float64]

CHUNK = 4096
SEGMENTS = 3
"""Segments a cell side in the tree's triangles."""


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
        Use second derivatives (Newton's method); without them it is the tangent-plane iteration of Nishiyama et al. 2008.
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
        from subdfit.limit._kernels import order_by_cell

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
        centre = np.full((len(triangle), 2), 1 / 3)
        face, uv = self._on_surface(triangle, centre)
        other = triangle != self._triangle_under(best.face, best.uv)[point]
        if not other.any():
            return best
        point, face, uv = point[other], face[other], uv[other]
        tried = self.refine(data[point], face, uv)
        order = np.lexsort((tried.distance, point))
        first = order[np.r_[True, point[order][1:] != point[order][:-1]]]
        better = first[tried.distance[first] < best.distance[point[first]]]
        rows = point[better]
        for mine, theirs in zip(
            (best.face, best.uv, best.distance, best.converged),
            (tried.face, tried.uv, tried.distance, tried.converged),
            strict=True,
        ):
            mine[rows] = theirs[better]
        return best

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
        return face.astype(np.int64) * SEGMENTS**2 + np.where(down, down_row, up_row)

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
