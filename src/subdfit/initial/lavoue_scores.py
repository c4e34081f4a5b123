"""How well a possible control edge follows the lines of curvature (Lavoué et al. 2007, section 4.3)."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, get_args

import numpy as np
import potpourri3d
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from subdfit.errors import InputError
from subdfit.limit.curvature import unit
from subdfit.mesh.checks import finite_points, row_pairs, triangle_rows
from subdfit.target.bvh import SegmentTree, TriangleTree
from subdfit.target.curvature import CurvatureField
from subdfit.target.curves import boundary_edges

Floats = NDArray[np.float64]
Paths = Literal["geodesic", "dijkstra"]

_NO_DIRECTION, _BLOCKED = 45.0, 90.0
"""Degrees that count where the tensor is isotropic, and where a path runs along the boundary."""
_SAMPLES = 16
"""Places at which a path is compared with the lines of curvature, between its ends."""
_TOUCHING = 1e-6
"""Distance from the boundary, as a share of the diagonal, at which a path runs along it."""
_BESIDE = 20.0
"""An edge as far from a path as this path is long counts so many times as long, beside its own length."""
DIGITS = 6
"""Decimals to which scores are compared: what differs less is level, and rounding decides nothing."""


@dataclass(frozen=True)
class ScoredSurface:
    """A surface with lines of curvature, on which paths are found and compared with them.

    Attributes
    ----------
    points, triangles : the mesh, (n, 3) and (m, 3).
    field : curvature of the vertices.
    paths : ``geodesic`` straightens paths across faces (Sharp and Crane, You can find geodesic paths in triangle meshes
        by just flipping edges, 2020), which does not depend on the tessellation; ``dijkstra`` keeps them on edges, as
        printed in the paper.

    Raises
    ------
    InputError
        A row that is no point, a point that is not finite, the curvature another mesh's, or no such paths.
    """

    points: Floats
    triangles: NDArray[np.integer]
    field: CurvatureField
    paths: Paths = "geodesic"

    def __post_init__(self) -> None:
        require_paths(self.paths)
        points = finite_points(self.points, "mesh")
        triangles = triangle_rows(self.triangles, len(points))
        self.field.require_mesh(points, triangles)
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "triangles", triangles)

    @cached_property
    def diagonal(self) -> float:
        """Diagonal of the bounding box."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))

    @cached_property
    def area(self) -> float:
        """Of all triangles."""
        a, b, c = np.moveaxis(self.points[self.triangles], 1, 0)
        return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)

    @cached_property
    def boundary(self) -> NDArray[np.bool_]:
        """Vertices of the boundary, (n,)."""
        flags = np.zeros(len(self.points), np.bool_)
        flags[boundary_edges(self.triangles)] = True
        return flags

    @cached_property
    def _tree(self) -> TriangleTree:
        return TriangleTree(self.points, self.triangles)

    @cached_property
    def _rim(self) -> SegmentTree:
        return SegmentTree(self.points, boundary_edges(self.triangles))

    @cached_property
    def graph(self) -> csr_array:
        """Lengths of edges between vertices, symmetric."""
        ends = np.sort(self.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).astype(np.int64), axis=1)
        ends = np.unique(ends, axis=0)
        length = np.linalg.norm(self.points[ends[:, 1]] - self.points[ends[:, 0]], axis=1)
        both = np.concatenate([ends, ends[:, ::-1]])
        shape = (len(self.points), len(self.points))
        return csr_array((np.tile(np.maximum(length, 1e-300), 2), (both[:, 0], both[:, 1])), shape=shape)

    def edge_path(
        self, sources: int | NDArray[np.int64], targets: int | NDArray[np.int64], beside: Floats | None = None
    ) -> NDArray[np.int64]:
        """Vertices of the shortest path along edges from one of some vertices to one of others.

        It meets no boundary between its ends; empty if there is none. Edges count as longer the farther they lie from
        the path `beside`, points (k, 3), so that both go round the same holes.
        """
        sources, targets = np.atleast_1d(sources), np.atleast_1d(targets)
        allowed = ~self.boundary
        allowed[sources] = allowed[targets] = True
        rows = np.repeat(np.arange(len(self.points)), np.diff(self.graph.indptr))
        kept = allowed[rows] & allowed[self.graph.indices]
        rows, columns, length = rows[kept], self.graph.indices[kept], self.graph.data[kept]
        if beside is not None:
            off = SegmentTree(beside, np.stack([np.arange(len(beside) - 1), np.arange(1, len(beside))], axis=1))
            span = np.linalg.norm(np.diff(beside, axis=0), axis=1).sum()
            middles = (self.points[rows] + self.points[columns]) / 2
            length = length * (1.0 + _BESIDE * off.closest(middles).distance / span)
        graph = csr_array((length, (rows, columns)), shape=self.graph.shape)
        total, before, _ = dijkstra(graph, indices=sources, return_predecessors=True, min_only=True)
        target = int(targets[np.argmin(total[targets])])
        return _trace(before, target) if np.isfinite(total[target]) else np.empty(0, np.int64)

    def find(self, pairs: Sequence[tuple[int, int]], paths: Paths | None = None) -> list[Floats]:
        """Shortest paths between pairs of vertices, as points (k, 3).

        Raises
        ------
        InputError
            A pair names no vertex, or no path joins its two.
        """
        pairs = row_pairs(pairs, len(self.points), "pairs").tolist()
        require_paths(paths or self.paths)
        if (paths or self.paths) == "geodesic":
            return [self._geodesic(a, b) for a, b in pairs]
        sources = sorted({a for a, _ in pairs})
        place = {a: row for row, a in enumerate(sources)}
        _, before = dijkstra(self.graph, indices=sources, return_predecessors=True)
        found = [_trace(before[place[a]], b) for a, b in pairs]
        for (a, b), path in zip(pairs, found, strict=True):
            if len(path) < 2:
                raise _unjoined(a, b)
        return [self.points[path] for path in found]

    @cached_property
    def _flipper(self) -> "potpourri3d.EdgeFlipGeodesicSolver":
        return potpourri3d.EdgeFlipGeodesicSolver(self.points, np.asarray(self.triangles, np.int64))

    def _geodesic(self, a: int, b: int) -> Floats:
        try:
            return np.asarray(self._flipper.find_geodesic_path(a, b), np.float64)
        except RuntimeError:
            raise _unjoined(a, b) from None

    def scores(self, paths: Sequence[Floats]) -> tuple[Floats, Floats]:
        """Coherency scores (equation 4) of paths, in degrees from 0 (best) to 90, and the paths' lengths.

        At even distances along a path, so that the tessellation does not matter, the angles between the two principal
        directions and the chord from the path's first to its last point are folded into 0 to 90; the better of the two
        sums over the path, over the number of places, is the score. Places where the tensor is isotropic count 45,
        places on the boundary 90.

        Parameters
        ----------
        paths : points (k, 3) each, k >= 2.

        Raises
        ------
        InputError
            A path of fewer than two points, or of one that has not three finite coordinates.
        """
        paths = [finite_points(path, "path") for path in paths]
        if not paths:
            return np.empty(0), np.empty(0)
        if min(map(len, paths)) < 2:
            raise InputError("a path of 1 point has no direction; give 2 or more")
        owner = np.repeat(np.arange(len(paths)), _SAMPLES)
        at = np.concatenate([_between(path) for path in paths])
        chord = np.array([path[-1] - path[0] for path in paths])
        chord /= np.maximum(np.linalg.norm(chord, axis=1, keepdims=True), 1e-300)
        nearest = self._tree.closest(at)
        found = self.field.at(nearest.triangle, nearest.uv)
        smallest, largest = (
            np.degrees(np.arccos(np.clip(np.abs(np.sum(direction * chord[owner], axis=1)), 0, 1)))
            for direction in (found.minimum_direction, found.maximum_direction)
        )
        plain = found.isotropic(self.diagonal)
        blocked = self._rim.closest(at).distance <= _TOUCHING * self.diagonal
        sums = []
        for angle in (smallest, largest):
            angle[plain] = _NO_DIRECTION
            angle[blocked] = _BLOCKED
            sums.append(np.bincount(owner, angle, len(paths)) / _SAMPLES)
        length = np.array([np.linalg.norm(np.diff(path, axis=0), axis=1).sum() for path in paths])
        return np.minimum(*sums), length

    def mean_normals(self, paths: Sequence[Floats]) -> Floats:
        """Unit normals of the surface along paths, averaged at even distances, (k, 3)."""
        nearest = self._tree.closest(np.concatenate([_between(path) for path in paths]))
        found = self.field.at(nearest.triangle, nearest.uv).normal
        return unit(found.reshape(len(paths), _SAMPLES, 3).sum(axis=1))


def require_paths(paths: str) -> None:
    """Raise InputError unless there are such paths."""
    if paths not in get_args(Paths):
        raise InputError(f"paths is '{paths}'; choose {' or '.join(get_args(Paths))}")


def _unjoined(a: int, b: int) -> InputError:
    return InputError(f"no path joins vertices {a} and {b}; give two different ones of one piece of a manifold mesh")


def _trace(before: NDArray[np.int32], target: int) -> NDArray[np.int64]:
    path = [target]
    while before[path[-1]] >= 0:
        path.append(int(before[path[-1]]))
    return np.array(path[::-1], np.int64)


def _between(path: Floats) -> Floats:
    """Places at even distances along a path, without its ends."""
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    steps = (np.arange(_SAMPLES) + 0.5) / _SAMPLES * arc[-1]
    return np.stack([np.interp(steps, arc, column) for column in path.T], axis=1)
