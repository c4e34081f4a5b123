"""One level of refinement as the patch kernels take it: its sectors, and which of its points are which rows."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.mesh.topology import Creases, Topology
from subdfit.schemes import _sector_kernels as kernels

Indices = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Level:
    """A mesh with the sectors at its face corners.

    Attributes
    ----------
    topology : the mesh.
    preceding : (h,) int32, the half-edge before each in its face.
    sharp : (h,) bool, half-edges that are sharp for ever; semi-sharp ones are smooth here.
    sharp_count : (n,) edges round each vertex that are; pinned : (n,) bool, corner vertices.
    first, faces, position, regular : (h,), see `kernels.corner_sectors`.
    semi_sharp : (n,) bool, vertices whose rule changes within some levels.
    """

    topology: Topology
    preceding: Indices
    sharp: NDArray[np.bool_]
    sharp_count: NDArray[np.int64]
    pinned: NDArray[np.bool_]
    first: Indices
    faces: Indices
    position: Indices
    regular: NDArray[np.bool_]

    @classmethod
    def of(cls, t: Topology) -> "Level":
        """Describe a mesh."""
        sharp = np.ascontiguousarray(np.isinf(t.sharpness)[t.edge])
        count = sharp_edges_round(t, sharp)
        pinned = np.isinf(t.corner_sharpness) | (count >= 3)
        before = preceding(t)
        sectors = kernels.corner_sectors(
            t.face_offsets, t.face_vertices, t.following, before, t.face, t.twin, sharp, count, pinned
        )
        return cls(t, before, sharp, count, pinned, *sectors)

    @property
    def semi_sharp(self) -> NDArray[np.bool_]:
        """See `semi_sharp`."""
        return semi_sharp(self.topology)


def semi_sharp(t: Topology) -> NDArray[np.bool_]:
    """Vertices whose rules change within some levels: a tag of finite sharpness is there or on an edge there."""
    flags = (t.corner_sharpness > 0) & np.isfinite(t.corner_sharpness)
    edges = np.flatnonzero((t.sharpness > 0) & np.isfinite(t.sharpness))
    flags[t.ends(edges)] = True
    return np.asarray(flags)


def preceding(t: Topology) -> Indices:
    """The half-edge before each in its face, (h,) int32."""
    before = np.empty_like(t.following)
    before[t.following] = np.arange(len(before), dtype=np.int32)
    return before


def sharp_edges_round(t: Topology, sharp: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Sharp edges at each vertex: those that leave it, and one of the boundary that arrives."""
    leaving = np.bincount(t.face_vertices[sharp], minlength=t.vertex_count)
    arriving = np.bincount(t.face_vertices[t.following[t.twin < 0]], minlength=t.vertex_count)
    return leaving + arriving


@dataclass(frozen=True, eq=False)
class Piece:
    """Part of a mesh: chosen faces, first and in their order, with two rings of faces round them.

    Attributes
    ----------
    topology : the piece.
    vertices : (n,) int32, which vertex each of its was; where the cut leaves separate fans, one is several.
    """

    topology: Topology
    vertices: Indices

    @classmethod
    def round(cls, t: Topology, chosen: NDArray[np.int64]) -> "Piece":
        """Cut out the chosen faces; refined positions of their own rings are the whole mesh's."""
        faces, corners, twins, vertices, half_edges = kernels.cut_faces(
            chosen,
            t.face_offsets,
            t.face_vertices,
            t.following,
            preceding(t),
            t.face,
            t.twin,
            t.outgoing,
            t.vertex_count,
        )
        offsets = np.concatenate([[0], np.cumsum(np.diff(t.face_offsets)[faces])]).astype(np.int32)
        inside = np.flatnonzero(twins >= 0)
        creases = Creases.of(inside, t.sharpness[t.edge[half_edges[inside]]])
        piece = Topology.from_twins(offsets, corners, twins, len(vertices), creases)
        piece.corner_sharpness[:] = t.corner_sharpness[vertices]
        return cls(piece, vertices)

    def rows(self, matrix: sp.csr_array) -> sp.csr_array:
        """The piece's vertices as combinations of what `matrix` combines."""
        return sp.csr_array(matrix[self.vertices])
