"""Cells of a Doo-Sabin surface: one for each new vertex inside the surface, between the middles of its four faces.

A cell is cut in four by the next step: its parts are the cells of the new vertices that it gets, one a face.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from subdfit.schemes._doo_sabin_child import child_topology
from subdfit.schemes._doo_sabin_curves import Curves
from subdfit.schemes._doo_sabin_masks import Face
from subdfit.schemes._doo_sabin_refine import Numbers
from subdfit.schemes.domain import QUAD, Domain

Rows = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class Cells:
    """The cells of a mesh that is refined.

    Attributes
    ----------
    parent, numbers : the mesh, and its new vertices; the first are the cells, in their order.
    child : the refined mesh.
    vertex_faces : its first face that stands for a vertex of the mesh.
    """

    parent: Curves
    numbers: Numbers
    child: Curves
    vertex_faces: int

    @classmethod
    def of(cls, parent: Curves) -> "Cells":
        """Refine a mesh."""
        numbers = Numbers(parent)
        child, vertex_faces = child_topology(parent, numbers)
        return cls(parent, numbers, Curves.of(child), vertex_faces)

    @property
    def count(self) -> int:
        """Number of cells."""
        return self.numbers.inner_count

    @cached_property
    def ring(self) -> Rows:
        """Face corners (half-edges) of the refined mesh at each cell's new vertex, (f, 4), counter-clockwise.

        The first is that of the face of a vertex: it is the cell's corner at that vertex. The third is that of a face.
        """
        t, before = self.child.topology, self.child.preceding
        first = np.flatnonzero((t.face >= self.vertex_faces) & (t.face_vertices < self.count))
        ring = np.empty((self.count, 4), np.int64)
        ring[t.face_vertices[first], 0] = first
        for i in range(3):
            ring[:, i + 1] = t.twin[before[ring[:, i]]]
        return ring

    @cached_property
    def slot(self) -> NDArray[np.int8]:
        """Which corner of its cell each face corner of the refined mesh is, (h,)."""
        slot = np.full(len(self.child.sharp), -1, np.int8)
        slot[self.ring] = np.arange(4)
        return slot

    def domain(self) -> Domain:
        """How the cells join. Side i, from corner i on, lies across the edge with which ring[i + 1] begins."""
        t = self.child.topology
        leaving = np.roll(self.ring, -1, axis=1)
        head = t.face_vertices[t.following[leaving]]
        smooth = head < self.count
        arriving = np.where(smooth, t.twin[leaving], self._across(leaving))
        there = np.where(arriving >= 0, arriving, 0)
        neighbour = np.where(arriving >= 0, t.face_vertices[there], -1)
        side = np.where(arriving >= 0, (self.slot[there] - 1) % 4, 0)
        vertex = self._vertex_of_face()[t.face[self.ring]]
        shape = np.full(self.count, QUAD, np.int8)
        half_edge = np.flatnonzero(self.parent.inner).astype(np.int32)
        return Domain(
            shape,
            neighbour.astype(np.int32),
            side.astype(np.int8),
            ~smooth,
            vertex.astype(np.int32),
            half_edge,
            parts=True,
        )

    def _across(self, leaving: Rows) -> Rows:
        """The edge from the cell beyond a curve to the vertex on it where the given edges arrive; -1 at the boundary.

        The curve leaves that vertex within the same face, and beyond it lies the face whose next edge is ours. In the
        face opposite to the tip of a crease, the edge that leaves the tip is ours.
        """
        t = self.child.topology
        after = t.following[leaving]
        beyond = t.twin[after]
        found = np.where(self.child.sharp[after], t.twin[t.following[beyond]], beyond)
        return np.where(beyond < 0, -1, found)

    def _vertex_of_face(self) -> Rows:
        """The control vertex in whose limit each face of the refined mesh ends, -1 for none."""
        parent, t = self.parent, self.parent.topology
        found = np.full(self.child.topology.face_count, -1, np.int64)
        quarters = np.flatnonzero(parent.kind == Face.QUARTER)
        found[quarters] = t.face_vertices[parent.start[quarters]]
        edges = np.flatnonzero(~parent.sharp & (np.arange(len(t.twin)) < t.twin))
        for h in (edges, t.twin[edges]):
            # An edge from a vertex on a plain curve ends there.
            ends = ~parent.inner[h]
            found[t.face_count + np.flatnonzero(ends)] = t.face_vertices[h[ends]]
        found[self.vertex_faces :] = t.face_vertices[parent.polygons]
        return found
