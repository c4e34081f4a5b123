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
    def _corner_of(self) -> tuple[Rows, Rows]:
        """For each half-edge a cell and its corner at the half-edge's origin."""
        half_edge = self.surface.domain.half_edge
        cell, corner = np.nonzero(half_edge >= 0)
        place = np.empty((2, len(cell)), np.int64)
        place[:, half_edge[cell, corner]] = cell, corner
        return place[0], place[1]

    @cached_property
    def whole(self) -> NDArray[np.bool_]:
        """Whether each cell is a whole face, (cells,)."""
        domain = self.surface.domain
        return np.asarray((domain.half_edge >= 0).sum(axis=1) == domain.shape)

    @cached_property
    def face(self) -> Rows:
        """The face of each cell, (cells,)."""
        return np.asarray(self.surface.topology.face[self.surface.domain.half_edge.max(axis=1)], np.int64)

    @cached_property
    def side(self) -> Rows:
        """The half-edge of the control mesh on which each cell's side lies, (cells, 4); -1 inside a face."""
        t, half_edge = self.surface.topology, self.surface.domain.half_edge
        before = np.empty(len(t.following), np.int64)
        before[t.following] = np.arange(len(t.following))
        entering = np.roll(half_edge, -1, axis=1)
        arrives = np.where(entering >= 0, before[entering], -1)
        return np.where(half_edge >= 0, half_edge, np.where(self.whole[:, None], -1, arrives))

    def vertices(self) -> Floats:
        """Points of the surface at the control vertices, (n, 3)."""
        return self._at(*self._at_vertices)

    def normals(self) -> Floats:
        """Unit normals of the surface there, (n, 3), each from one cell."""
        return self.surface.normals(*self._at_vertices)

    @cached_property
    def _at_vertices(self) -> tuple[Rows, Floats]:
        cell, corner = (place[self.surface.topology.outgoing] for place in self._corner_of)
        return cell, CORNERS[self.surface.domain.shape[cell], corner]

    def middles(self, half_edges: Rows) -> Floats:
        """Points of the surface in the middle of sides, (k, 3)."""
        cell, corner = (place[half_edges] for place in self._corner_of)
        share = np.where(self.whole[cell], 0.5, 1.0)
        return self._at(cell, self.surface.domain.along(cell, corner, share))

    def centres(self, faces: Rows) -> Floats:
        """Points of the surface in the middle of faces, (k, 3)."""
        cell, corner = (place[self.surface.topology.face_offsets[faces]] for place in self._corner_of)
        shape = self.surface.domain.shape[cell]
        inside = np.where((shape == TRIANGLE)[:, None], 1 / 3, 0.5)
        opposite = CORNERS[shape, (corner + 2) % 4]
        return self._at(cell, np.where(self.whole[cell][:, None], inside, opposite))

    @cached_property
    def corner_shares(self) -> sp.csr_array:
        """What each control vertex counts at the points at cells' corners, (points, n): its rows sum to one.

        A vertex counts for itself, both ends of a side in its middle, all corners of a face in its.
        """
        domain, t = self.surface.domain, self.surface.topology
        vertices = np.arange(t.vertex_count)
        part = np.flatnonzero(~self.whole)
        half_edge = domain.half_edge[part].max(axis=1)
        corner = domain.half_edge[part].argmax(axis=1)
        middle, centre = np.empty(t.edge_count, np.int64), np.empty(t.face_count, np.int64)
        middle[t.edge[half_edge]] = domain.points[part, (corner + 1) % QUAD]
        centre[t.face[half_edge]] = domain.points[part, (corner + 2) % QUAD]
        sizes = np.diff(t.face_offsets)
        rows: list[NDArray[np.integer]] = [vertices]
        columns: list[NDArray[np.integer]] = [vertices]
        values = [np.ones(len(vertices))]
        if len(part):
            rows += [np.repeat(middle, 2), centre[t.face]]
            columns += [t.edge_vertices.ravel(), t.face_vertices]
            values += [np.full(2 * t.edge_count, 0.5), 1 / sizes[t.face]]
        shape = (max(t.vertex_count, int(domain.points.max()) + 1), t.vertex_count)
        return sp.csr_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=shape)

    def _at(self, cell: Rows, uv: Floats) -> Floats:
        return self.surface.evaluate(cell, uv).position
