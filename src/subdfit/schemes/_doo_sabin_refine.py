"""One step of Doo-Sabin subdivision: the new vertices, and their positions with or without a matrix.

New vertices are, in this order: one for each face corner inside the surface, in the order of half-edges; two for each
sharp edge, one for where a plain curve ends in a corner; one for each tip of a plain crease; the corners of curves.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

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
        sharp = np.flatnonzero(c.sharp)
        return sharp[~(c.plain[sharp] & c.corner[t.face_vertices[sharp]])]

    @cached_property
    def boundary_ends(self) -> Rows:
        """Half-edges of the boundary that have one near their target, from which no half-edge comes back."""
        c, t = self.curves, self.curves.topology
        boundary = np.flatnonzero(t.twin < 0)
        target = t.face_vertices[t.following[boundary]]
        return boundary[~(c.plain[boundary] & c.corner[target])]

    @cached_property
    def corners(self) -> Rows:
        """Vertices that are corners, in the order of the new ones."""
        return np.flatnonzero(self.curves.corner)

    @cached_property
    def vertex_count(self) -> int:
        """Number of new vertices."""
        return self.tips_begin + len(self.curves.tips) + len(self.corners)

    @cached_property
    def tips_begin(self) -> int:
        """The first new vertex that a plain crease ends in."""
        return self.inner_count + len(self.ends) + len(self.boundary_ends)

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
        found = np.full(len(twin), -1, np.int32)
        inside = np.flatnonzero(self.curves.sharp & (twin >= 0))
        found[inside] = self.origin[twin[inside]]
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
        found = np.cumsum(c.inner, dtype=np.int32)
        found -= 1
        beside = np.flatnonzero(~c.inner)
        before = c.before(beside)
        found[beside] = np.where(c.plain[beside], self.origin[beside], self.target[before])
        bent = beside[c.plain[beside] & c.plain[before]]
        found[bent] = self.corner[c.topology.face_vertices[bent]]
        found[c.tips] = self.tips_begin + np.arange(len(c.tips))
        return found

    @property
    def end_vertices(self) -> NDArray[np.int32]:
        """The vertex that each new vertex on a curve, but for those of tips and corners, is nearest to."""
        t = self.curves.topology
        return np.concatenate([t.face_vertices[self.ends], t.face_vertices[t.following[self.boundary_ends]]])

    @property
    def means(self) -> sp.csr_array:
        """Limits of the vertices: means of the new ones that stand for them, (n, new); see `DualRows.limits`."""
        c, ends = self.curves, self.end_vertices
        inner, tips = c.topology.face_vertices[c.inner], c.topology.face_vertices[c.tips]
        vertex = np.concatenate([inner, ends, tips, self.corners.astype(np.int32)])
        last = np.ones(len(tips) + len(self.corners), np.bool_)
        stands = np.concatenate([c.sharp_count[inner] < 2, ~c.corner[ends], last])
        new = np.flatnonzero(stands).astype(np.int32)
        count = np.bincount(vertex[new], minlength=len(c.corner))
        shape = (len(count), self.vertex_count)
        return sp.csr_array((1 / count[vertex[new]], (vertex[new], new)), shape=shape)


GROUP = 1 << 16
"""Most faces whose rows are made at a time."""


class _Group(NamedTuple):
    """Some faces of one kind and size: half-edges (k, m), rows of their new vertices (k, j), and their mask (j, m)."""

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
        numbers = self.numbers
        new = self._summed(numbers.of_face_corner, numbers.vertex_count, points)
        begin = numbers.inner_count
        columns, values = self._curve_rows()
        new[begin : begin + len(columns)] = np.einsum("ki,kix->kx", values, points[columns])
        new[numbers.vertex_count - len(numbers.corners) :] = points[numbers.corners]
        return new

    def limits(self, points: Floats) -> Floats:
        """Limits of vertices from points (n, 3): the means of the new ones that stand for them.

        What is inside the surface has no say in the limits of vertices on curves, but for those where creases end, nor
        have vertices on curves in those of corners.
        """
        c, t, corners = self.curves, self.curves.topology, self.numbers.corners
        out = self._summed(t.face_vertices, t.vertex_count, points)
        count = t.valence.copy()
        count[t.face_vertices[c.tips]] = 1
        out[c.sharp_count > 1] = count[c.sharp_count > 1] = 0
        columns, values = self._curve_rows()
        np.add.at(out, columns[:, 0], np.einsum("ki,kix->kx", values, points[columns]))
        np.add.at(count, columns[:, 0], 1)
        out /= np.maximum(count, 1)[:, None]
        out[corners] = points[corners]
        return out

    def _summed(self, target: NDArray[np.int32], count: int, points: Floats) -> Floats:
        """Sums (count, 3) of the new points inside the surface that share a row, (h,) by face corner, of `target`."""
        curves, t = self.curves, self.curves.topology
        out, given = np.zeros((count, 3)), np.ascontiguousarray(points, np.float64)
        for m, kind, faces in self._alike():
            mask, inner = np.ascontiguousarray(self._mask(kind, m)), np.arange(m)[INNER[kind]]
            kernels.add_face_points(
                faces, curves.start, t.face_offsets, t.face_vertices, mask, inner, target, given, out
            )
        return out

    @cached_property
    def matrix(self) -> sp.csr_array:
        """The same as a sparse matrix."""
        t, numbers = self.curves.topology, self.numbers
        columns, values = self._curve_rows()
        lengths: list[Rows] = [
            np.zeros(1, np.int32),
            self.curves.sides[t.face[self.curves.inner]],
            np.full(len(columns), 2),
            self.curves.sides[t.face[self.curves.tips]],
            np.ones(len(numbers.corners), np.int32),
        ]
        offsets = np.cumsum(np.concatenate(lengths), dtype=np.int32)
        indices, data = np.empty(offsets[-1], np.int32), np.empty(offsets[-1])
        for group in self._groups():
            place = offsets[group.rows][:, :, None] + np.arange(group.mask.shape[1])
            indices[place] = t.face_vertices[group.half_edges][:, None]
            data[place] = group.mask
        ends = slice(offsets[numbers.inner_count], offsets[numbers.tips_begin])
        indices[ends], data[ends] = columns.ravel(), values.ravel()
        corners = slice(offsets[numbers.vertex_count - len(numbers.corners)], None)
        indices[corners], data[corners] = numbers.corners, 1.0
        return sp.csr_array((data, indices, offsets), shape=(numbers.vertex_count, t.vertex_count))

    def _groups(self) -> Iterator[_Group]:
        at = self.numbers.of_face_corner
        for m, kind, faces in self._alike():
            inner = INNER[kind]
            for begin in range(0, len(faces), GROUP):
                half_edges = self.curves.corners(faces[begin : begin + GROUP], m)
                yield _Group(half_edges, at[half_edges[:, inner]], self._mask(kind, m)[inner])

    def _alike(self) -> Iterator[tuple[int, Face, Rows]]:
        """Corners and kinds of faces, and the faces that have them."""
        keys = len(Face) * self.curves.sides + self.curves.kind
        for key in np.flatnonzero(np.bincount(keys)):
            yield int(key) // len(Face), Face(int(key) % len(Face)), np.flatnonzero(keys == key)

    def _mask(self, kind: Face, m: int) -> Floats:
        if kind == Face.WHOLE:
            return averaging_mask(m) if self.averaging else original_mask(m)
        return half_mask(m) if kind == Face.HALF else quarter_mask(m)

    def _curve_rows(self) -> tuple[Rows, Floats]:
        """Chaikin's rule at the vertices on curves, and its clamped form next to corners of plain ones: (k, 2) each."""
        curves, numbers = self.curves, self.numbers
        vertex, following = curves.topology.face_vertices, curves.topology.following
        here = numbers.end_vertices
        there = np.concatenate([vertex[following[numbers.ends]], vertex[numbers.boundary_ends]])
        plain = np.concatenate([curves.plain[numbers.ends], curves.plain[numbers.boundary_ends]])
        share = np.where(plain & curves.corner[there], 1 / 2, 1 / 4)
        return np.column_stack([here, there]).astype(np.int64), np.column_stack([1 - share, share])


INNER = {Face.WHOLE: slice(None), Face.HALF: slice(2, None), Face.QUARTER: slice(2, -1)}
"""Which rows of a face's mask are of corners inside the surface."""
