"""Loop subdivision of triangle meshes, with boundaries, creases, darts and corners (Loop 1987; Hoppe et al. 1994)."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.mesh.topology import Topology
from subdfit.schemes import _loop_kernels as kernels
from subdfit.schemes._compile import compile_patches
from subdfit.schemes._corner_type import CornerType
from subdfit.schemes._level import Level
from subdfit.schemes._loop_types import limit_mask, vertex_alpha
from subdfit.schemes._triangle_patches import TrianglePatches
from subdfit.schemes.domain import TRIANGLE, Domain
from subdfit.schemes.patch_table import PatchTable
from subdfit.schemes.scheme import Faces, Refinement


@dataclass(frozen=True)
class Loop:
    """Loop's scheme; boundary edges are sharp, vertices with three or more sharp edges and tagged ones are corners."""

    name: str = "loop"
    faces: Faces = "triangles"

    def validate(self, topology: Topology) -> None:
        """Raise InputError unless all faces are triangles, all inner valences 3 or more, and no tag is semi-sharp."""
        if not topology.triangles_only:
            raise InputError("Loop subdivision takes triangles only; triangulate the mesh or choose another scheme")
        interior = ~_on_boundary(topology)
        if np.any(interior & (topology.valence < 3)):
            vertex = int(np.flatnonzero(interior & (topology.valence < 3))[0])
            raise InputError(f"inner vertex {vertex} has valence 2; collapse one of its edges")
        tags = np.concatenate([topology.sharpness, topology.corner_sharpness])
        if np.any((tags > 0) & np.isfinite(tags)):
            raise InputError("Loop subdivision takes creases and corners that are sharp for ever; give sharpness 10")

    def domain(self, topology: Topology) -> Domain:
        """One triangle a face, its corners in the face's order."""
        t = topology
        count = t.face_count
        twin = t.twin.reshape(-1, 3)
        neighbour = np.full((count, 4), -1, np.int32)
        side = np.zeros((count, 4), np.int8)
        neighbour[:, :3] = np.where(twin < 0, -1, twin // 3)
        side[:, :3] = np.where(twin < 0, 0, twin % 3)
        sharp = np.zeros((count, 4), np.bool_)
        sharp[:, :3] = _sharp_half_edges(t).reshape(-1, 3)
        vertex = np.full((count, 4), -1, np.int32)
        vertex[:, :3] = t.triangles
        return Domain(np.full(count, TRIANGLE, np.int8), neighbour, side, sharp, vertex)

    def refine(self, topology: Topology) -> Refinement:
        """Split each triangle into four: children of face f are 4 f to 4 f + 3, the last in its middle.

        Vertices keep their rows; the new vertex of edge e is row n + e.
        """
        t = topology
        corners, twin = kernels.split_triangles(t.face_vertices, t.twin, t.edge, t.vertex_count)
        offsets = np.arange(0, len(corners) + 1, 3, dtype=np.int32)
        child = Topology.from_twins(offsets, corners, twin, t.vertex_count + t.edge_count)
        child.sharpness[child.edge[::4]] = t.sharpness[t.edge]
        child.corner_sharpness[: t.vertex_count] = t.corner_sharpness
        matrix = sp.csr_array(sp.vstack([_vertex_rows(t), _edge_rows(t)], format="csr"))
        return Refinement(child, matrix, np.arange(t.vertex_count), t.vertex_count + np.arange(t.edge_count))

    def limit_rows(self, topology: Topology) -> sp.csr_array:
        """Limit masks of all vertices: smooth, crease and boundary, dart, corner."""
        t = topology
        own, ring, neighbour = np.empty(t.vertex_count), np.empty(t.vertex_count), _neighbours(t)
        smooth, crease, dart, pinned = _vertex_kinds(t)
        alpha = _alpha(t)
        own[smooth] = 3 / (11 - 8 * alpha[smooth])
        ring[smooth] = (1 - own[smooth]) / t.valence[smooth]
        own[crease], ring[crease] = 4 / 6, 1 / 6
        own[pinned], ring[pinned] = 1, 0
        own[dart], ring[dart] = 0, 0
        matrix = _own_and_ring(t, own, ring, smooth, crease, neighbour)
        return sp.csr_array(matrix + _dart_limits(t, np.flatnonzero(dart)))

    def patches(self, topology: Topology) -> PatchTable:
        """Compile for exact evaluation: one patch a face, four where more than one corner is irregular."""
        self.validate(topology)
        return compile_patches(TrianglePatches(self.refine), topology)


def _sharp_half_edges(t: Topology) -> NDArray[np.bool_]:
    return np.ascontiguousarray(t.sharpness[t.edge] > 0)


def _on_boundary(t: Topology) -> NDArray[np.bool_]:
    flags = np.zeros(t.vertex_count, np.bool_)
    flags[t.edge_vertices[t.boundary_edges]] = True
    return flags


def _sharp_count(t: Topology) -> NDArray[np.int64]:
    """Sharp edges at each vertex: those that leave it, and one of the boundary that arrives."""
    sharp = _sharp_half_edges(t)
    leaving = np.bincount(t.face_vertices[sharp], minlength=t.vertex_count)
    arriving = np.bincount(t.face_vertices[t.following[t.twin < 0]], minlength=t.vertex_count)
    return leaving + arriving


def _vertex_kinds(t: Topology) -> tuple[NDArray[np.bool_], ...]:
    """Masks of smooth, crease (boundary too), dart and pinned vertices."""
    count = _sharp_count(t)
    pinned = (t.corner_sharpness > 0) | (count >= 3)
    return ~pinned & (count == 0), ~pinned & (count == 2), ~pinned & (count == 1), pinned


def _alpha(t: Topology) -> NDArray[np.float64]:
    """Own weight of the smooth vertex rule by valence, (n,)."""
    table = np.array([1.0, *(vertex_alpha(n) for n in range(1, int(t.valence.max(initial=1)) + 1))])
    return table[t.valence]


def _neighbours(t: Topology) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.bool_]]:
    """Directed edges: from, to, and whether sharp."""
    a, b = t.edge_vertices.T
    sharp = t.sharpness > 0
    return np.concatenate([a, b]), np.concatenate([b, a]), np.concatenate([sharp, sharp])


def _own_and_ring(
    t: Topology,
    own: NDArray[np.float64],
    ring: NDArray[np.float64],
    smooth: NDArray[np.bool_],
    crease: NDArray[np.bool_],
    neighbours: tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.bool_]],
) -> sp.csr_array:
    """Matrix with `own` on the diagonal and `ring` at all neighbours (smooth) or the sharp ones (crease)."""
    start, end, sharp = neighbours
    used = smooth[start] | (crease[start] & sharp)
    rows = np.concatenate([np.arange(t.vertex_count), start[used]])
    columns = np.concatenate([np.arange(t.vertex_count), end[used]])
    values = np.concatenate([own, ring[start[used]]])
    return sp.csr_array((values, (rows, columns)), shape=(t.vertex_count, t.vertex_count))


def _vertex_rows(t: Topology) -> sp.csr_array:
    """Vertex rule: a dart keeps the smooth one; creases 1/8, 6/8, 1/8; corners stay."""
    smooth, crease, dart, pinned = _vertex_kinds(t)
    own = _alpha(t)
    ring = (1 - own) / t.valence
    own[crease], ring[crease] = 6 / 8, 1 / 8
    own[pinned], ring[pinned] = 1, 0
    return _own_and_ring(t, own, ring, smooth | dart, crease, _neighbours(t))


def _edge_rows(t: Topology) -> sp.csr_array:
    """Edge rule 3/8, 3/8, 1/8, 1/8; sharp edges their midpoint."""
    smooth = t.sharpness == 0
    ends = np.where(smooth, 3 / 8, 1 / 2)
    across = np.flatnonzero(smooth[t.edge])
    apex = t.face_vertices[t.following[t.following[across]]]
    rows = np.concatenate([np.arange(t.edge_count), np.arange(t.edge_count), t.edge[across]])
    columns = np.concatenate([t.edge_vertices[:, 0], t.edge_vertices[:, 1], apex])
    values = np.concatenate([ends, ends, np.full(len(across), 1 / 8)])
    return sp.csr_array((values, (rows, columns)), shape=(t.edge_count, t.vertex_count))


def _dart_limits(t: Topology, darts: NDArray[np.int64]) -> sp.csr_array:
    """Limit rows of darts, whose mask is not the smooth one because their sharp edge takes its midpoint."""
    shape = (t.vertex_count, t.vertex_count)
    if not len(darts):
        return sp.csr_array(shape)
    first = Level.of(t).first
    rows: list[NDArray[np.int64]] = []
    columns: list[list[int]] = []
    values: list[NDArray[np.float64]] = []
    for v in darts:
        h = first[t.outgoing[v]]
        ring = [int(v)]
        for _ in range(int(t.valence[v])):
            ring.append(int(t.face_vertices[t.following[h]]))
            h = t.twin[t.following[t.following[h]]]
        columns.append(ring)
        rows.append(np.full(len(ring), v))
        values.append(limit_mask(CornerType(len(ring) - 1, 0, closed=True, dart=True, pinned=False)))
    return sp.csr_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=shape)
