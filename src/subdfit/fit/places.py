"""Where the control mesh's faces, sides and vertices lie on the surface's cells, whole faces or parts of them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.limit.surface import LimitSurface
from subdfit.schemes.domain import CORNERS, QUAD, TRIANGLE

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Places:
    """The control mesh on its surface."""

    surface: LimitSurface

    @cached_property
    def face(self) -> Rows:
        """The face of each cell, (cells,)."""
        return np.asarray(self.surface.topology.face[self.surface.domain.half_edge], np.int64)

    @cached_property
    def _before(self) -> Rows:
        """The half-edge before each in its face, (h,)."""
        following = self.surface.topology.following
        before = np.empty(len(following), np.int64)
        before[following] = np.arange(len(following))
        return before

    @cached_property
    def side(self) -> Rows:
        """The half-edge of the control mesh on which each cell's side lies, (cells, 4), if on any."""
        first = self.surface.domain.half_edge.astype(np.int64)
        if not self.surface.domain.parts:
            return np.asarray(first[:, None] + np.arange(QUAD))
        before = self._before[first]
        return np.column_stack([first, self.surface.topology.following[first], self._before[before], before])

    @cached_property
    def _place(self) -> tuple[Rows, Rows]:
        """For each half-edge a cell and its corner at the half-edge's origin, (h,); -1 where there is none."""
        domain, count = self.surface.domain, len(self.surface.topology.twin)
        cell = np.full(count, -1, np.int64)
        cell[domain.half_edge] = np.arange(domain.face_count)
        if domain.parts:
            return cell, np.zeros(count, np.int64)
        first = self.surface.topology.face_offsets[self.surface.topology.face]
        return cell[first], np.arange(count) - first

    def vertices(self) -> Floats:
        """Points of the surface at the control vertices, (n, 3)."""
        return self.surface.vertex_limits()

    def normals(self) -> Floats:
        """Unit normals of the surface there, (n, 3), each from one cell; zero at vertices of no cell."""
        domain = self.surface.domain
        named, slot = np.nonzero(domain.vertex >= 0)
        cell, corner = np.full((2, self.surface.topology.vertex_count), -1)
        cell[domain.vertex[named, slot]], corner[domain.vertex[named, slot]] = named, slot
        normal = np.zeros((len(cell), 3))
        there = cell >= 0
        normal[there] = self.surface.normals(cell[there], CORNERS[domain.shape[cell], corner][there])
        return normal

    def middles(self, half_edges: Rows) -> Floats:
        """Points of the surface in the middle of sides, (k, 3); where no part ends there, between those at the ends."""
        t, domain = self.surface.topology, self.surface.domain
        cell, corner = (place[half_edges] for place in self._place)
        if not domain.parts:
            return self.surface.evaluate(cell, domain.along(cell, corner, np.full(len(cell), 0.5))).position
        after = self._place[0][t.following[half_edges]]
        here = self._free(cell, 1)
        found = np.where(here, cell, np.where(self._free(after, 3), after, -1))
        ends = self.vertices()[np.column_stack([t.face_vertices, t.face_vertices[t.following]])[half_edges]]
        return self._where(found, CORNERS[QUAD, np.where(here, 1, 3)], ends.mean(axis=1))

    def centres(self, faces: Rows) -> Floats:
        """Points of the surface in the middle of faces, (k, 3); where no part ends there, between their vertices'."""
        t, domain = self.surface.topology, self.surface.domain
        first = np.full(t.face_count, -1, np.int64)
        first[self.face] = np.arange(domain.face_count)
        cell = first[faces]
        if not domain.parts:
            middle = np.where(domain.shape[cell] == TRIANGLE, 1 / 3, 0.5)
            return self.surface.evaluate(cell, np.column_stack([middle, middle])).position
        sums = np.zeros((t.face_count, 3))
        np.add.at(sums, t.face, self.vertices()[t.face_vertices])
        between = sums[faces] / np.diff(t.face_offsets)[faces, None]
        return self._where(np.where(self._free(cell, 2), cell, -1), np.tile(CORNERS[QUAD, 2], (len(cell), 1)), between)

    def _free(self, cell: Rows, slot: int) -> NDArray[np.bool_]:
        """Whether there is a cell whose corner `slot` is where it lies inside the surface, (k,)."""
        domain = self.surface.domain
        reaches = domain.vertex[cell, slot] >= 0
        if slot == 2:
            reaches = domain.sharp[cell, 1] | domain.sharp[cell, 2]
        return np.asarray((cell >= 0) & ~reaches)

    def _where(self, cell: Rows, uv: Floats, otherwise: Floats) -> Floats:
        """Points of the surface where there are cells."""
        there = cell >= 0
        otherwise[there] = self.surface.evaluate(cell[there], uv[there]).position
        return otherwise

    @cached_property
    def corner_shares(self) -> sp.csr_array:
        """What each control vertex counts at the points at cells' corners, (points, n): rows sum to one.

        A vertex counts for itself, both ends of a side in its middle, all corners of a face in its.
        """
        domain, t = self.surface.domain, self.surface.topology
        if not domain.parts:
            return sp.csr_array(sp.eye_array(t.vertex_count))
        point, half_edge, face = self._unnamed_corners()
        half, whole = np.flatnonzero(half_edge >= 0), np.flatnonzero(half_edge < 0)
        ends = np.column_stack([t.face_vertices, t.face_vertices[t.following]])[half_edge[half]]
        size = np.diff(t.face_offsets)[face[whole]]
        place = np.arange(size.sum()) - np.repeat(np.cumsum(size) - size - t.face_offsets[face[whole]], size)
        vertex = np.arange(t.vertex_count)
        rows = np.concatenate([vertex, np.repeat(point[half], 2), np.repeat(point[whole], size)])
        columns = np.concatenate([vertex, ends.ravel(), t.face_vertices[place]])
        values = np.concatenate([np.ones(len(vertex)), np.full(2 * len(half), 0.5), np.repeat(1 / size, size)])
        shape = (int(domain.points.max()) + 1, t.vertex_count)
        return sp.csr_array((values, (rows, columns)), shape=shape)

    def _unnamed_corners(self) -> tuple[Rows, Rows, Rows]:
        """Points at cells' corners but control vertices': the side in whose middle each lies, or -1, and a face.

        The third corner of a part that reaches to a curve lies on that.
        """
        domain, side = self.surface.domain, self.side
        none = np.full(domain.face_count, -1)
        on_curve = np.where(domain.sharp[:, 1], side[:, 1], np.where(domain.sharp[:, 2], side[:, 2], none))
        half_edge = np.column_stack([none, side[:, 0], on_curve, side[:, 3]])
        cell, slot = np.nonzero(domain.vertex < 0)
        point, first = np.unique(domain.points[cell, slot], return_index=True)
        cell, slot = cell[first], slot[first]
        return point, half_edge[cell, slot], self.face[cell]
