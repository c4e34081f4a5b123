"""Decimation by quadric error metrics that keeps the surface, its boundary and its creases what they are."""

import logging
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from subdfit.errors import InputError
from subdfit.initial._decimate_kernels import CORNER, CURVE, SMOOTH, collapse_edges, queue_edges
from subdfit.initial._quadric_kernels import vertex_quadrics
from subdfit.mesh.topology import Topology
from subdfit.wording import counted

logger = logging.getLogger(__name__)

CREASE, BOUNDARY = 1, 2

NO_LIMIT = np.iinfo(np.int32).max

LEAST_QUALITY = 0.05
"""Triangles flatter than this (1 is equilateral) are refused as long as there is another way."""

LEAST_TURN = 0.3
"""Cosine of the angle, about 73 degrees, by which one collapse may turn a face as long as there is another way."""

LEAST_TURN_EVER = 0.1
"""Cosine of the angle, about 84 degrees, by which one collapse may turn a face at the very most."""

LEAST_QUALITY_EVER = 1e-3
"""Triangles flatter than this are never made of better ones."""


@dataclass(frozen=True, eq=False)
class Decimated:
    """A triangle mesh with fewer vertices.

    Attributes
    ----------
    points : (k, 3) float64, in the input's unit.
    triangles : (t, 3) int64, oriented as the input.
    crease_edges : (e, 2) int64, rows of `points`, each pair ascending; the chains of the input with fewer links.
    corners : (c,) int64, rows of `points`: the corners given, in their order.
    reached : whether `points` has no more rows than asked for.
    message : one line that says why not; None where it was reached.
    point_rows : (k,) int64, the input's rows of a subset; None where points were placed freely.
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.int64]
    crease_edges: NDArray[np.int64]
    corners: NDArray[np.int64]
    reached: bool
    message: str | None
    point_rows: NDArray[np.int64] | None = None


@dataclass(eq=False)
class _Mesh:
    """The arrays that the kernel works on, in place."""

    points: NDArray[np.float64]
    vertices: NDArray[np.int32]
    twin: NDArray[np.int32]
    mark: NDArray[np.int8]
    outgoing: NDArray[np.int32]
    valence: NDArray[np.int32]
    kind: NDArray[np.int8]


class _Queue(NamedTuple):
    """The edges that may be collapsed, as the kernel keeps them; see `collapse_edges`."""

    keys: NDArray[np.float64]
    edges: NDArray[np.int32]
    sizes: NDArray[np.int64]
    state: NDArray[np.int8]
    seen: NDArray[np.int32]
    highest: NDArray[np.float64]

    @classmethod
    def of(cls, m: _Mesh, quadrics: NDArray[np.float64], subset: bool) -> "_Queue":
        """The queue of all edges of a mesh."""
        room = len(m.vertices)
        queue = cls(
            np.empty((2, room)),
            np.empty((2, room), np.int32),
            np.zeros(2, np.int64),
            np.zeros(room, np.int8),
            np.zeros(len(m.points), np.int32),
            np.array([-1.0]),
        )
        queue_edges(m.points, quadrics, m.vertices, m.twin, m.mark, m.valence, m.kind, subset, *queue[:4])
        return queue


class Decimation:
    """Edge collapses, least quadric error first, that stop on the way and go on; arguments as those of `decimate`."""

    def __init__(
        self,
        points: ArrayLike,
        triangles: ArrayLike,
        *,
        crease_edges: ArrayLike | None = None,
        corners: ArrayLike | None = None,
        max_valence: int = 10,
        subset: bool = False,
        weights: ArrayLike | None = None,
    ) -> None:
        positions = np.array(points, np.float64, order="C")
        _check(positions, max_valence)
        topology = Topology.from_triangles(triangles, len(positions), crease_edges=crease_edges)
        self._fixed = _corner_rows(corners, len(positions))
        self._middle = 0.5 * (positions.min(axis=0) + positions.max(axis=0))
        self._size = float(np.linalg.norm(positions.max(axis=0) - positions.min(axis=0))) or 1.0
        self._mesh = _prepare(topology, (positions - self._middle) / self._size, self._fixed)
        self._quadrics = vertex_quadrics(self._mesh.points, self._mesh.vertices, self._mesh.mark)
        if weights is not None:
            self._quadrics *= _weights(weights, len(positions))[:, None]
        self._positions, self._subset = positions, subset
        self._left = len(positions)
        # Given up is only what is desirable, one thing after the other, until the target is reached.
        self._limits = [
            (max_valence, LEAST_QUALITY, LEAST_TURN),
            (max_valence, LEAST_QUALITY_EVER, LEAST_TURN_EVER),
            (NO_LIMIT, LEAST_QUALITY_EVER, LEAST_TURN_EVER),
        ]
        self._queue: _Queue | None = None

    def down_to(self, target: int) -> Decimated:
        """The mesh with `target` vertices, or with those that are left where these are fewer or no more can go."""
        while self._left > target:
            before = self._left
            self._collapse(target)
            if self._left > target:
                self._queue = None
            if self._left == before:
                if len(self._limits) == 1:
                    break
                del self._limits[0]
        found = _harvest(self._mesh, self._fixed, self._middle, self._size, _shortfall(self._left, target))
        return _at_their_rows(found, self._positions) if self._subset else found

    def _collapse(self, target: int) -> None:
        """Collapse edges until the target is reached or the queue, which is made anew if there is none, is empty."""
        m = self._mesh
        self._queue = self._queue or _Queue.of(m, self._quadrics, self._subset)
        arrays = (m.points, self._quadrics, m.vertices, m.twin, m.mark, m.outgoing, m.valence, m.kind)
        self._left = int(collapse_edges(*arrays, self._left, target, *self._limits[0], self._subset, *self._queue))


def decimate(
    points: ArrayLike,
    triangles: ArrayLike,
    target: int,
    *,
    crease_edges: ArrayLike | None = None,
    corners: ArrayLike | None = None,
    max_valence: int = 10,
    subset: bool = False,
    weights: ArrayLike | None = None,
) -> Decimated:
    """Collapse edges, least quadric error first, until `target` vertices are left.

    The result has the same components, genus, boundary loops and crease graph as the input. Vertices of a
    boundary or crease stay on it; corners (given, or where other than two such edges meet, or where a crease
    meets the boundary) stay where they are. One collapse turns no face by more than 84 degrees.

    Parameters
    ----------
    points : (n, 3)
        Positions, in any unit and place.
    triangles : (m, 3)
        An oriented manifold in which every point is used, open or closed, with any number of components.
    target : int
        Number of vertices wanted, at least 3.
    crease_edges : (e, 2), optional
        Edges inside the surface to keep sharp; a boundary edge among them counts as boundary only.
    corners : (c,), optional
        Vertices to leave in place.
    max_valence : int
        Most edges that a collapse may leave at a vertex, unless the target is out of reach otherwise.
    subset : bool
        Whether the vertices left are some of the points, where they were; else they are where the error is least.
    weights : (n,), optional
        What an error at each point counts: eight times as much leaves about twice as many vertices there. Default 1.

    Returns
    -------
    Decimated
        With exactly `target` vertices (all, if there are fewer), or with the fewest within reach and a message.

    Raises
    ------
    InputError
        The triangles are no oriented manifold, a tag names no edge or vertex, or a number is out of range.

    References
    ----------
    Garland and Heckbert, Surface simplification using quadric error metrics, SIGGRAPH 1997.
    Dey, Edelsbrunner, Guha and Nekhayev, Topology preserving edge contraction, 1999.
    """
    if target < 3:
        raise InputError(f"target is {target}; ask for at least 3 vertices")
    return Decimation(
        points,
        triangles,
        crease_edges=crease_edges,
        corners=corners,
        max_valence=max_valence,
        subset=subset,
        weights=weights,
    ).down_to(target)


def _shortfall(left: int, target: int) -> str | None:
    """Why the target was not reached; None where it was."""
    if left <= target:
        return None
    message = (
        f"stopped at {counted(left, 'vertex')}, not {target}: fewer would fold faces or change the topology, "
        "a boundary loop, a crease or a corner"
    )
    logger.info(message)
    return message


def _check(points: NDArray[np.float64], max_valence: int) -> None:
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise InputError(f"points have shape {points.shape}; give (n, 3) with n > 0")
    if not np.isfinite(points).all():
        row = int(np.flatnonzero(~np.isfinite(points).all(axis=1))[0])
        raise InputError(f"point {row} is not finite; remove it and its faces")
    if max_valence < 6:
        raise InputError(f"max_valence is {max_valence}; the mean is 6, so allow at least that")


def _corner_rows(corners: ArrayLike | None, count: int) -> NDArray[np.int64]:
    rows = np.empty(0, np.int64) if corners is None else np.asarray(corners, np.int64).ravel()
    if len(rows) and (rows.min() < 0 or rows.max() >= count):
        raise InputError(f"a corner lies outside 0..{count - 1}; mend the corner list")
    return rows


def _prepare(topology: Topology, points: NDArray[np.float64], fixed: NDArray[np.int64]) -> _Mesh:
    """Mark edges and sort vertices into smooth, curve and corner."""
    edge_mark = np.zeros(topology.edge_count, np.int8)
    edge_mark[topology.crease_edges] = CREASE
    edge_mark[topology.boundary_edges] = BOUNDARY
    count = topology.vertex_count
    ends = topology.edge_vertices
    creases = np.bincount(ends[edge_mark == CREASE].ravel(), minlength=count)
    boundary = np.bincount(ends[edge_mark == BOUNDARY].ravel(), minlength=count)
    kind = np.full(count, CORNER, np.int8)
    kind[(creases == 2) & (boundary == 0) | (creases == 0) & (boundary == 2)] = CURVE
    kind[(creases == 0) & (boundary == 0)] = SMOOTH
    kind[fixed] = CORNER
    return _Mesh(
        points=np.ascontiguousarray(points),
        vertices=topology.face_vertices.copy(),
        twin=topology.twin.copy(),
        mark=edge_mark[topology.edge],
        outgoing=topology.outgoing.copy(),
        valence=(topology.valence + (boundary > 0)).astype(np.int32),
        kind=kind,
    )


def _weights(weights: ArrayLike, count: int) -> NDArray[np.float64]:
    found = np.asarray(weights, np.float64)
    if found.shape != (count,) or not np.all((found > 0) & np.isfinite(found)):
        raise InputError(f"the weights must be {count} positive numbers, one for each point")
    return found


def _at_their_rows(found: Decimated, points: NDArray[np.float64]) -> Decimated:
    """Name the points of a subset, which moved by rounding on their way through normalised coordinates."""
    _, rows = cKDTree(points).query(found.points)
    rows = np.asarray(rows, np.int64)
    return replace(found, points=points[rows], point_rows=rows)


def _harvest(
    mesh: _Mesh,
    fixed: NDArray[np.int64],
    middle: NDArray[np.float64],
    size: float,
    message: str | None,
) -> Decimated:
    """Number the survivors afresh and go back to the caller's unit and place."""
    survives = mesh.outgoing >= 0
    row = np.cumsum(survives) - 1
    triangles = mesh.vertices.reshape(-1, 3)
    triangles = triangles[triangles[:, 0] >= 0]
    crease = np.flatnonzero((mesh.mark == CREASE) & (mesh.vertices >= 0) & (np.arange(len(mesh.twin)) > mesh.twin))
    heads = np.where(crease % 3 == 2, crease - 2, crease + 1)
    ends = row[np.stack([mesh.vertices[crease], mesh.vertices[heads]], axis=1)]
    return Decimated(
        points=np.ascontiguousarray(mesh.points[survives] * size + middle),
        triangles=np.ascontiguousarray(row[triangles], np.int64),
        crease_edges=np.sort(ends, axis=1).astype(np.int64),
        corners=row[fixed].astype(np.int64),
        reached=message is None,
        message=message,
    )
