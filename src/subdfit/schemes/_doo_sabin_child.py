"""The connectivity of a mesh after one step of Doo-Sabin subdivision."""

import numpy as np
from numpy.typing import NDArray

from subdfit.mesh.topology import Topology
from subdfit.schemes import _doo_sabin_kernels as kernels
from subdfit.schemes._doo_sabin_curves import Curves
from subdfit.schemes._doo_sabin_refine import Numbers

Indices = NDArray[np.int32]


def child_topology(curves: Curves, numbers: Numbers) -> tuple[Topology, int]:
    """The refined connectivity, and its first face that stands for a vertex.

    A face for each face; a quad for each smooth edge; along curves that are not plain a quad for each side of an edge;
    for each vertex off plain curves a polygon between its sharp edges, which has the new vertices on these besides.
    """
    t, at = curves.topology, numbers.of_face_corner
    count = len(t.twin)
    strips = _strip_quads(curves, numbers)
    quads = (count - int(np.count_nonzero(curves.sharp))) // 2 + len(strips)
    first = count + 4 * quads
    # A polygon has at most three corners that are no face corners, on its sharp edges; what is not used is cut off.
    begins = curves.polygons
    corners = np.empty(first + count + 3 * int(np.count_nonzero(curves.sharp[begins])), np.int32)
    corners[:count], corners[first - strips.size : first] = at, strips.ravel()
    sizes, place = np.empty(len(begins), np.int32), np.full(count, -1, np.int32)
    mesh = (t.face_offsets, t.face, t.twin, t.face_vertices, curves.sharp)
    new = (at, numbers.origin, numbers.target, numbers.corner)
    used = kernels.vertex_polygons(begins, *mesh, *new, sizes, corners[first:], place)
    corners = corners[: first + used]
    twin = np.full(len(corners), -1, np.int32)
    kernels.edge_quads(t.following, t.twin, curves.sharp, at, place, first, corners, twin)
    offsets = _offsets(t.face_offsets, quads, sizes)
    if curves.sharp.any():
        _pair(twin, offsets, corners)
    child = Topology.from_twins(offsets, corners, twin, numbers.vertex_count)
    if len(numbers.ends):
        # No smooth edge joins two vertices on curves.
        on_curves = np.all(child.edge_vertices >= numbers.inner_count, axis=1)
        child = child.with_sharpness(np.where(on_curves, np.inf, 0.0))
    child.corner_sharpness[numbers.corner[numbers.corners]] = t.corner_sharpness[numbers.corners]
    return child, t.face_count + quads


def _offsets(faces: Indices, quads: int, sizes: Indices) -> Indices:
    """Offsets of some faces, of so many quads, and of polygons of given sizes, one after the other."""
    offsets = np.empty(len(faces) + quads + len(sizes), np.int32)
    offsets[: len(faces)] = faces
    first = len(faces) + quads
    offsets[len(faces) : first] = faces[-1] + 4 * np.arange(1, quads + 1, dtype=np.int32)
    np.cumsum(sizes, out=offsets[first:])
    offsets[first:] += offsets[first - 1]
    return offsets


def _strip_quads(curves: Curves, numbers: Numbers) -> Indices:
    at = numbers.of_face_corner
    h = np.flatnonzero(curves.sharp & ~curves.plain)
    following = curves.topology.following[h]
    return np.column_stack([at[following], at[h], numbers.origin[h], numbers.target[h]])


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
