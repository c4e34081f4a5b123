"""Regions of a surface as surfaces of their own: what moves only there costs no more than they do."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from subdfit.closest.projection import Projector
from subdfit.fit.changes import faces_at, ring
from subdfit.fit.places import Places
from subdfit.fit.state import FitState
from subdfit.limit.surface import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Creases, Topology

Flags = NDArray[np.bool_]
Rows = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Region:
    """Some faces of a surface, with as many round them as it takes for the same limit surface there.

    Attributes
    ----------
    surface : of these faces; its rim, where the whole goes on, counts as no boundary.
    inner : (cells,) bool, the cells of `surface` that lie as the whole's do.
    vertices : (n,), the whole's control vertices that are those of `surface`.
    own : (n,) bool, those of the faces themselves; the others belong to what lies round them, other regions perhaps.
    cell : (cells of the whole,), the cell of `surface` that each is, -1 where it is none.
    """

    surface: LimitSurface
    inner: Flags
    vertices: Rows
    own: Flags
    cell: Rows

    @classmethod
    def of(cls, surface: LimitSurface, faces: Flags) -> "Region":
        """The region of the flagged faces, (f,), of a surface."""
        whole = surface.topology
        own = np.zeros(whole.vertex_count, np.bool_)
        own[whole.face_vertices[faces[whole.face]]] = True
        corners = own
        if surface.scheme.whole_curves:
            corners = ring(whole, _along_curves(whole, ring(whole, corners)))
        kept = faces_at(whole, corners)
        topology, vertices = _part(whole, kept)
        points = surface.control_mesh.points[vertices]
        part = LimitSurface(ControlMesh(topology, points, surface.scheme.name), surface.scheme)
        inner = faces[np.flatnonzero(kept)][Places(part).face]
        cell = _cells(surface, part, kept)
        return cls(_without_rim(part, kept, whole), np.asarray(inner), vertices, own[vertices], cell)

    def state(self, whole: FitState, cells: Flags) -> FitState:
        """The state of the data that lie in the flagged cells, (c,), of the whole, each on its own sheet."""
        rows = whole.rows_in(cells)
        data, face, uv = whole.data.subset(rows), self.cell[whole.face[rows]].astype(np.int32), whole.uv[rows]
        lost = face < 0
        if lost.any():
            face[lost], uv[lost] = Projector(self.surface).start(data.points[lost])
        return FitState.follow(data, self.surface, face, uv)


def regions(surface: LimitSurface, moving: Flags) -> Iterator[tuple[Region, Flags]]:
    """The regions that the flagged control vertices, (n,), move, each with the flags of its cells in the whole.

    No two have a vertex of their faces in common.
    """
    topology, place = surface.topology, Places(surface).face
    moved = faces_at(topology, ring(topology, moving))
    rows = np.flatnonzero(moved[topology.face])
    shape = (topology.face_count, topology.vertex_count)
    touching = sp.csr_array((np.ones(len(rows)), (topology.face[rows], topology.face_vertices[rows])), shape=shape)
    _, label = connected_components(touching @ touching.T, directed=False)
    for spot in np.unique(label[moved]):
        faces = moved & (label == spot)
        yield Region.of(surface, faces), faces[place]


def _part(whole: Topology, kept: Flags) -> tuple[Topology, Rows]:
    """The flagged faces alone, and their vertices; one where separate fans of faces meet is several."""
    half_edges = np.flatnonzero(kept[whole.face])
    number = np.full(len(whole.twin) + 1, -1, np.int32)
    number[half_edges] = np.arange(len(half_edges))
    twin, following = number[whole.twin[half_edges]], number[whole.following[half_edges]]
    joined = np.flatnonzero(twin >= 0)
    shape = (len(half_edges), len(half_edges))
    fans = sp.coo_array((np.ones(len(joined)), (joined, following[twin[joined]])), shape=shape)
    count, vertex = connected_components(fans, directed=False)
    vertices = np.empty(count, np.int64)
    vertices[vertex] = whole.face_vertices[half_edges]
    offsets = np.concatenate([[0], np.cumsum(np.diff(whole.face_offsets)[kept])]).astype(np.int32)
    creases = Creases.of(joined, whole.sharpness[whole.edge[half_edges[joined]]])
    part = Topology.from_twins(offsets, vertex.astype(np.int32), twin, count, creases)
    part.corner_sharpness[:] = whole.corner_sharpness[vertices]
    return part, vertices


def _cells(whole: LimitSurface, part: LimitSurface, kept: Flags) -> Rows:
    """The cell of the part, of the flagged faces, that each of the whole's cells is; -1 where it is none, (cells,)."""
    half_edges = np.flatnonzero(kept[whole.topology.face])
    at = np.full(len(whole.topology.twin), -1)
    at[half_edges[part.domain.half_edge]] = np.arange(part.domain.face_count)
    return at[whole.domain.half_edge]


def _along_curves(topology: Topology, vertices: Flags) -> Flags:
    """The flagged vertices, (n,), and all that sharp edges join to them."""
    ends = topology.ends(np.flatnonzero(topology.sharpness > 0))
    shape = (topology.vertex_count, topology.vertex_count)
    joined = sp.coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=shape)
    count, curve = connected_components(joined, directed=False)
    touched = np.zeros(count, np.bool_)
    touched[curve[vertices]] = True
    return touched[curve]


def _without_rim(part: LimitSurface, kept: Flags, whole: Topology) -> LimitSurface:
    """The same surface, whose sides on the rim are not sharp."""
    half_edges = np.flatnonzero(kept[whole.face])
    rim = (part.topology.twin < 0) & (whole.twin[half_edges] >= 0)
    side, domain = Places(part).side, part.domain
    sharp = domain.sharp & ~(rim[np.minimum(side, len(rim) - 1)] & (domain.neighbour < 0))
    return part.with_domain(replace(domain, sharp=sharp))
