"""One step of Doo-Sabin subdivision: the refined connectivity, and its points with or without a matrix.

New vertices are, in this order: one for each face corner inside the surface, in the order of half-edges; two for each
sharp edge, one for where a plain curve ends in a corner; the corners of curves.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.mesh._topology_kernels import pair_half_edges
from subdfit.mesh.topology import Topology
from subdfit.schemes import _doo_sabin_kernels as kernels
from subdfit.schemes._doo_sabin_curves import Curves
from subdfit.schemes._doo_sabin_masks import Face, averaging_mask, half_mask, original_mask, quarter_mask

Floats = NDArray[np.float64]
Rows = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class Numbers:
    """Rows of the new vertices.

    Attributes
    ----------
    curves : the mesh that is refined.
    """

    curves: Curves

    @cached_property
    def inner_count(self) -> int:
        """How many new vertices lie inside the surface; they are the first."""
        return int(np.count_nonzero(self.curves.inner))

    @cached_property
    def ends(self) -> Rows:
        """Sharp half-edges that have a new vertex near their origin, in the order of these vertices."""
        c, t = self.curves, self.curves.topology
        return np.flatnonzero(c.sharp & ~(c.plain & c.corner[t.face_vertices]))

    @cached_property
    def boundary_ends(self) -> Rows:
        """Half-edges of the boundary that have one near their target, from which no half-edge comes back."""
        c, t = self.curves, self.curves.topology
        target = t.face_vertices[t.following]
        return np.flatnonzero((t.twin < 0) & ~(c.plain & c.corner[target]))

    @cached_property
    def corners(self) -> Rows:
        """Vertices that are corners, in the order of the new ones."""
        return np.flatnonzero(self.curves.corner)

    @cached_property
    def vertex_count(self) -> int:
        """Number of new vertices."""
        return self.inner_count + len(self.ends) + len(self.boundary_ends) + len(self.corners)

    @cached_property
    def origin(self) -> NDArray[np.int32]:
        """The new vertex on the curve near each half-edge's origin, (h,), -1 for none."""
        found = np.full(len(self.curves.sharp), -1, np.int32)
        found[self.ends] = self.inner_count + np.arange(len(self.ends))
        return found

    @cached_property
    def target(self) -> NDArray[np.int32]:
        """The new vertex on the curve near each half-edge's target, (h,), -1 for none."""
        twin = self.curves.topology.twin
        found = np.where(twin < 0, np.int32(-1), self.origin[twin])
        found[self.boundary_ends] = self.inner_count + len(self.ends) + np.arange(len(self.boundary_ends))
        return found

    @cached_property
    def corner(self) -> NDArray[np.int32]:
        """The new vertex of each vertex that is a corner, (n,), -1 for others."""
        found = np.full(len(self.curves.corner), -1, np.int32)
        found[self.corners] = self.vertex_count - len(self.corners) + np.arange(len(self.corners))
        return found

    @cached_property
    def of_face_corner(self) -> NDArray[np.int32]:
        """The new vertex at each face corner, (h,)."""
        c = self.curves
        before = c.preceding
        found = np.where(c.plain, self.origin, self.target[before])
        bent = c.plain & c.plain[before]
        found[bent] = self.corner[c.topology.face_vertices[bent]]
        found[c.inner] = np.arange(self.inner_count, dtype=np.int32)
        return found

    @property
    def vertices(self) -> tuple[NDArray[np.int32], NDArray[np.bool_]]:
        """The vertex that each new vertex is nearest to, and whether that vertex's limit depends on it.

        What is inside the surface has no say in the limits of vertices on curves, nor these in those of corners.
        """
        c, t = self.curves, self.curves.topology
        inner = t.face_vertices[c.inner]
        ends = np.concatenate([t.face_vertices[self.ends], t.face_vertices[t.following[self.boundary_ends]]])
        vertices = np.concatenate([inner, ends, self.corners.astype(np.int32)])
        stands = np.concatenate([~c.on_curve[inner], ~c.corner[ends], np.ones(len(self.corners), np.bool_)])
        return vertices, stands


def child_topology(curves: Curves, numbers: Numbers) -> tuple[Topology, int]:
    """The refined connectivity, and its first face that stands for a vertex.

    A face for each face; a quad for each smooth edge; along curves that are not plain a quad for each side of an edge;
    for each vertex off plain curves a polygon between its sharp edges, which has the new vertices on these besides.
    """
    t, at = curves.topology, numbers.of_face_corner
    edges, strips = _edge_quads(curves, at), _strip_quads(curves, numbers)
    sizes, polygons = kernels.vertex_polygons(
        t.face_vertices,
        t.twin,
        curves.preceding,
        curves.sharp,
        curves.plain,
        curves.sector,
        curves.sector_size,
        at,
        numbers.origin,
        numbers.target,
        numbers.corner,
    )
    lengths = np.concatenate([curves.sides, np.full(len(edges) + len(strips), 4), sizes])
    offsets = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int32)
    corners = np.concatenate([at, edges.ravel(), strips.ravel(), polygons])
    twin, *_ = pair_half_edges(offsets, corners, numbers.vertex_count)
    child = Topology.from_twins(offsets, corners, twin, numbers.vertex_count)
    if len(numbers.ends):
        # No smooth edge joins two vertices on curves.
        child.sharpness[(child.edge_vertices >= numbers.inner_count).all(axis=1)] = np.inf
    child.corner_sharpness[numbers.corner[numbers.corners]] = t.corner_sharpness[numbers.corners]
    return child, t.face_count + len(edges) + len(strips)


def _edge_quads(curves: Curves, at: NDArray[np.int32]) -> NDArray[np.int32]:
    t = curves.topology
    h = np.flatnonzero(~curves.sharp & (np.arange(len(t.twin)) < t.twin))
    beyond = t.twin[h]
    return np.column_stack([at[t.following[h]], at[h], at[t.following[beyond]], at[beyond]])


def _strip_quads(curves: Curves, numbers: Numbers) -> NDArray[np.int32]:
    at = numbers.of_face_corner
    h = np.flatnonzero(curves.sharp & ~curves.plain)
    following = curves.topology.following[h]
    return np.column_stack([at[following], at[h], numbers.origin[h], numbers.target[h]])


class _Group(NamedTuple):
    """Faces of one kind and size: their half-edges (k, m), rows of the new vertices (k, j), and their mask (j, m)."""

    half_edges: Rows
    rows: Rows
    mask: Floats


@dataclass(frozen=True, eq=False)
class DualRows:
    """What one step does to points.

    Attributes
    ----------
    curves, numbers : the mesh and its new vertices.
    averaging : whether whole faces take the averaging mask, not the original one.
    """

    curves: Curves
    numbers: Numbers
    averaging: bool

    def apply(self, points: Floats) -> Floats:
        """New positions (child vertices, 3) from points (n, 3)."""
        vertices = self.curves.topology.face_vertices
        new = np.empty((self.numbers.vertex_count, points.shape[1]))
        for group in self._groups():
            new[group.rows] = group.mask @ points[vertices[group.half_edges]]
        begin = self.numbers.inner_count
        columns, values = self._curve_rows()
        new[begin : begin + len(columns)] = np.einsum("ki,kix->kx", values, points[columns])
        new[begin + len(columns) :] = points[self.numbers.corners]
        return new

    @cached_property
    def matrix(self) -> sp.csr_array:
        """The same as a sparse matrix."""
        t, numbers = self.curves.topology, self.numbers
        columns, values = self._curve_rows()
        lengths = np.concatenate(
            [
                self.curves.sides[t.face[self.curves.inner]],
                np.full(len(columns), 2),
                np.ones(len(numbers.corners), np.int64),
            ]
        )
        offsets = np.concatenate([[0], np.cumsum(lengths)])
        indices, data = np.empty(offsets[-1], np.int32), np.empty(offsets[-1])
        for group in self._groups():
            place = offsets[group.rows][:, :, None] + np.arange(group.mask.shape[1])
            indices[place] = t.face_vertices[group.half_edges][:, None]
            data[place] = group.mask
        tail = offsets[numbers.inner_count]
        indices[tail:] = np.concatenate([columns.ravel(), numbers.corners])
        data[tail:] = np.concatenate([values.ravel(), np.ones(len(numbers.corners))])
        return sp.csr_array((data, indices, offsets), shape=(numbers.vertex_count, t.vertex_count))

    def _groups(self) -> Iterator[_Group]:
        curves, at = self.curves, self.numbers.of_face_corner
        keys, member = np.unique(len(Face) * curves.sides + curves.kind, return_inverse=True)
        for number, key in enumerate(keys):
            m, kind = int(key) // len(Face), Face(int(key) % len(Face))
            half_edges = curves.corners(np.flatnonzero(member == number), m)
            inner = INNER[kind]
            yield _Group(half_edges, at[half_edges[:, inner]], self._mask(kind, m)[inner])

    def _mask(self, kind: Face, m: int) -> Floats:
        if kind == Face.WHOLE:
            return averaging_mask(m) if self.averaging else original_mask(m)
        return half_mask(m) if kind == Face.HALF else quarter_mask(m)

    def _curve_rows(self) -> tuple[Rows, Floats]:
        """Chaikin's rule at the vertices on curves, and its clamped form next to corners of plain ones: (k, 2) each."""
        curves, numbers = self.curves, self.numbers
        vertex, following = curves.topology.face_vertices, curves.topology.following
        here = numbers.vertices[0][numbers.inner_count : numbers.vertex_count - len(numbers.corners)]
        there = np.concatenate([vertex[following[numbers.ends]], vertex[numbers.boundary_ends]])
        plain = np.concatenate([curves.plain[numbers.ends], curves.plain[numbers.boundary_ends]])
        share = np.where(plain & curves.corner[there], 1 / 2, 1 / 4)
        return np.column_stack([here, there]).astype(np.int64), np.column_stack([1 - share, share])


INNER = {Face.WHOLE: slice(None), Face.HALF: slice(2, None), Face.QUARTER: slice(2, -1)}
"""Which rows of a face's mask are of corners inside the surface."""
