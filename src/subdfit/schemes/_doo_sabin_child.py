"""The connectivity of a mesh after one step of Doo-Sabin subdivision."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subdfit.mesh.topology import Topology
from subdfit.schemes import _doo_sabin_kernels as kernels
from subdfit.schemes._doo_sabin_curves import Curves
from subdfit.schemes._doo_sabin_refine import Numbers

Indices = NDArray[np.int32]
Rows = NDArray[np.integer]


class _Polygons(NamedTuple):
    """Polygons round vertices, see `kernels.vertex_polygons`."""

    sizes: Indices
    vertices: Indices
    place: Indices


def child_topology(curves: Curves, numbers: Numbers) -> tuple[Topology, int]:
    """The refined connectivity, and its first face that stands for a vertex.

    A face for each face; a quad for each smooth edge; along curves that are not plain a quad for each side of an edge;
    for each vertex off plain curves a polygon between its sharp edges, which has the new vertices on these besides.
    """
    t, at = curves.topology, numbers.of_face_corner
    smooth = np.flatnonzero(~curves.sharp & (np.arange(len(t.twin), dtype=np.int32) < t.twin))
    strips = _strip_quads(curves, numbers)
    polygons = _Polygons(
        *kernels.vertex_polygons(
            t.face_vertices,
            t.twin,
            curves.preceding,
            curves.sharp,
            curves.plain,
            *curves.sectors,
            at,
            numbers.origin,
            numbers.target,
            numbers.corner,
        )
    )
    quads = len(smooth) + len(strips)
    lengths = np.concatenate([curves.sides, np.full(quads, 4), polygons.sizes])
    offsets = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int32)
    corners = np.concatenate([at, _edge_quads(t, at, smooth).ravel(), strips.ravel(), polygons.vertices])
    first = len(t.twin) + 4 * quads
    in_polygon = np.where(polygons.place < 0, np.int32(-1), polygons.place + np.int32(first))
    twin = _twins(t, smooth, in_polygon, len(corners))
    _pair(twin, offsets, corners)
    child = Topology.from_twins(offsets, corners, twin, numbers.vertex_count)
    if len(numbers.ends):
        # No smooth edge joins two vertices on curves.
        child.sharpness[(child.edge_vertices >= numbers.inner_count).all(axis=1)] = np.inf
    child.corner_sharpness[numbers.corner[numbers.corners]] = t.corner_sharpness[numbers.corners]
    return child, t.face_count + quads


def _edge_quads(t: Topology, at: Indices, smooth: Rows) -> Indices:
    beyond = t.twin[smooth]
    return np.column_stack([at[t.following[smooth]], at[smooth], at[t.following[beyond]], at[beyond]])


def _strip_quads(curves: Curves, numbers: Numbers) -> Indices:
    at = numbers.of_face_corner
    h = np.flatnonzero(curves.sharp & ~curves.plain)
    following = curves.topology.following[h]
    return np.column_stack([at[following], at[h], numbers.origin[h], numbers.target[h]])


def _twins(t: Topology, smooth: Rows, in_polygon: Indices, count: int) -> Indices:
    """Twins (count,) of half-edges round the quads of smooth edges, -1 for others.

    Two sides of a quad border on the faces, whose half-edges keep their numbers; the others on the polygons of
    vertices, where `in_polygon` (h,) is the half-edge that leaves the new vertex of a face corner, -1 if there is none.
    """
    twin = np.full(count, -1, np.int32)
    side = len(t.twin) + 4 * np.arange(len(smooth), dtype=np.int32)
    here, there = smooth.astype(np.int32), t.twin[smooth]
    for first, own, other in ((side, here, there), (side + np.int32(2), there, here)):
        twin[first], twin[own] = own, first
        beside = in_polygon[t.following[other]]
        joined = beside >= 0
        twin[first[joined] + 1], twin[beside[joined]] = beside[joined], first[joined] + 1
    return twin


def _pair(twin: Indices, offsets: Indices, corners: Indices) -> None:
    """Pair the half-edges that have no twin yet by their ends: those along curves."""
    rest = np.flatnonzero(twin < 0)
    face = np.searchsorted(offsets, rest, side="right") - 1
    after = np.where(rest + 1 == offsets[face + 1], offsets[face], rest + 1)
    ends = np.sort(np.column_stack([corners[rest], corners[after]]).astype(np.int64), axis=1)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    alike = np.flatnonzero((ends[order[1:]] == ends[order[:-1]]).all(axis=1))
    one, other = rest[order[alike]], rest[order[alike + 1]]
    twin[one], twin[other] = other, one
