"""Sharp curves of a mesh as Doo-Sabin subdivision sees them, and what they make of faces.

Curves that meet are *plain* if on each side every vertex joins two faces, or one at a corner, and every face has one
edge on them or two that meet in a corner, and four corners or more. A crease may end inside the surface, in a *tip*: a
curve is plain there if the tip joins three faces, of which the one opposite to the crease meets no other curve. Along
plain curves faces are halves and quarters
(see `_doo_sabin_masks`). Along other curves faces are whole; the first step lays a strip of quads beside the curve,
which by that is plain from then on.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from subdfit.mesh.topology import Topology
from subdfit.schemes import _sector_kernels as kernels
from subdfit.schemes._doo_sabin_masks import Face
from subdfit.schemes._level import preceding, sharp_edges_round

Flags = NDArray[np.bool_]
Rows = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class Curves:
    """A mesh with its sharp curves.

    Attributes
    ----------
    topology : the mesh; what is sharp is sharp for ever.
    sharp : (h,) bool.
    sharp_count : (n,) int64, sharp edges at each vertex.
    corner : (n,) bool, where curves stop: tagged vertices on them, ends of three or more sharp edges, and vertices
        with a single face between two sharp edges.
    """

    topology: Topology
    sharp: Flags
    sharp_count: Rows
    corner: Flags

    @classmethod
    def of(cls, t: Topology) -> "Curves":
        """Find the curves of a mesh."""
        sharp = (t.sharpness > 0)[t.edge]
        count = sharp_edges_round(t, sharp)
        corner = (t.corner_sharpness > 0) | (count >= 3)
        ends = np.flatnonzero(sharp)
        after = t.following[ends]
        corner[t.face_vertices[after[sharp[after]]]] = True
        return cls(t, sharp, count, corner & (count > 0))

    @cached_property
    def preceding(self) -> NDArray[np.int32]:
        """The half-edge before each in its face, (h,) int32."""
        return preceding(self.topology)

    def before(self, half_edges: Rows) -> Rows:
        """The half-edges before those given in their faces."""
        offsets, face = self.topology.face_offsets, self.topology.face[half_edges]
        return np.where(half_edges == offsets[face], offsets[face + 1], half_edges) - 1

    @cached_property
    def polygons(self) -> Rows:
        """The sectors that refinement makes polygons of, each by its first outgoing half-edge, ascending.

        A sector consists of the faces round a vertex between two sharp edges, counter-clockwise, or of all of them.
        """
        begins = self.sharp & ~self.plain
        begins[self.topology.outgoing[self.sharp_count == 0]] = True
        return np.flatnonzero(begins)

    @property
    def _sector_faces(self) -> NDArray[np.int32]:
        """How many faces the sector has that each face corner is in, (h,)."""
        t = self.topology
        _, size, _, _ = kernels.corner_sectors(
            t.face_offsets,
            t.face_vertices,
            t.following,
            self.preceding,
            t.face,
            t.twin,
            self.sharp,
            self.sharp_count,
            np.zeros(t.vertex_count, np.bool_),
        )
        return np.asarray(size)

    @cached_property
    def sides(self) -> Rows:
        """Corners of each face, (f,)."""
        return np.diff(self.topology.face_offsets).astype(np.int64)

    @cached_property
    def on_curve(self) -> Flags:
        """Vertices on curves, (n,)."""
        return self.sharp_count > 0

    @cached_property
    def _opposite(self) -> Rows:
        """Face corners opposite to the creases that end in them, where the curve may be plain."""
        t, sharp = self.topology, np.flatnonzero(self.sharp)
        vertex = t.face_vertices[sharp]
        single = (self.sharp_count[vertex] == 1) & ~self.corner[vertex] & (t.valence[vertex] == 3)
        opposite = t.twin[self.before(sharp[single])]
        free = np.bincount(t.face[opposite], minlength=len(self.sides)) == 1
        free[t.face[sharp]] = False
        return np.asarray(opposite[free[t.face[opposite]]])

    @cached_property
    def tips(self) -> Rows:
        """Face corners opposite to the plain creases that end in them, one a tip."""
        t = self.topology
        return np.asarray(self._opposite[self.plain[t.following[t.twin[self._opposite]]]])

    @cached_property
    def plain(self) -> Flags:
        """Half-edges on plain curves, (h,)."""
        if not self.sharp.any():
            return self.sharp
        t, vertex = self.topology, self.topology.face_vertices
        ends = t.ends(np.flatnonzero(t.sharpness > 0))
        shape = (t.vertex_count, t.vertex_count)
        joined = sp.coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=shape)
        _, curve = connected_components(joined, directed=False)
        spoilt, ends = np.zeros(t.vertex_count, np.bool_), np.zeros(t.vertex_count, np.bool_)
        ends[vertex[self._opposite]] = True
        crowded = self.on_curve[vertex] & ~ends[vertex] & (self._sector_faces != np.where(self.corner[vertex], 1, 2))
        spoilt[curve[vertex[crowded | (self.sharp & ~self._fits[t.face])]]] = True
        return np.asarray(self.sharp & ~spoilt[curve[vertex]])

    @property
    def _fits(self) -> Flags:
        """Faces that may be halves or quarters, (f,)."""
        face = self.topology.face
        ends = np.flatnonzero(self.sharp)
        number = np.bincount(face[ends], minlength=len(self.sides))
        bent = np.bincount(face[ends[self.sharp[self.topology.following[ends]]]], minlength=len(self.sides))
        return np.asarray((self.sides >= 4) & ((number == 1) | ((number == 2) & (bent == 1))))

    @cached_property
    def kind(self) -> NDArray[np.int64]:
        """A `Face` for each face, (f,)."""
        return np.bincount(self.topology.face[self.plain], minlength=len(self.sides))

    @cached_property
    def start(self) -> Rows:
        """The half-edge with which masks begin, (f,): A to B of a half, V to B of a quarter, any of a whole face."""
        start = self.topology.face_offsets[:-1].astype(np.int64)
        begins = np.flatnonzero(self.plain)
        quarter = self.kind[self.topology.face[begins]] == Face.QUARTER
        begins = begins[~quarter | self.plain[self.before(begins)]]
        start[self.topology.face[begins]] = begins
        return start

    @cached_property
    def inner(self) -> Flags:
        """Face corners whose new vertex lies inside the surface, (h,): all but those on plain curves."""
        on_curve = self.plain.copy()
        on_curve[self.topology.following[np.flatnonzero(self.plain)]] = True
        on_curve[self.tips] = True
        return ~on_curve

    def corners(self, face: Rows, sides: int) -> Rows:
        """Half-edges of faces of so many sides, (k, sides), in the order of their masks."""
        begin = self.topology.face_offsets[face][:, None].astype(np.int64)
        return np.asarray(begin + (self.start[face][:, None] - begin + np.arange(sides)) % sides)
