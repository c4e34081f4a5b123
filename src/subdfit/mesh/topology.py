"""Connectivity of a polygon mesh: half-edges over ragged faces, creases and corners. Immutable."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from subdfit.errors import InputError
from subdfit.mesh._topology_kernels import outgoing_half_edges, pair_half_edges
from subdfit.mesh.data import SHARP_FOR_EVER

Indices = NDArray[np.int32]
Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Topology:
    """An oriented manifold polygon mesh without positions.

    A half-edge is a face corner: half-edge ``h`` starts at ``face_vertices[h]`` and runs round its face
    counter-clockwise.

    Attributes
    ----------
    vertex_count : number of vertices.
    face_offsets : (m + 1,) int32.
    face_vertices : (h,) int32, the origin of each half-edge.
    following, face, twin, edge : (h,) int32; `twin` is -1 on the boundary.
    outgoing : (n,) int32, one half-edge that leaves the vertex (the first counter-clockwise on a boundary).
    valence : (n,) int32, number of faces round the vertex.
    sharpness : (e,) float64, an edge's crease sharpness; ``inf`` on the boundary and for creases of
        sharpness 10 and more.
    corner_sharpness : (n,) float64, likewise for corner vertices.
    """

    vertex_count: int
    face_offsets: Indices
    face_vertices: Indices
    following: Indices
    face: Indices
    twin: Indices
    edge: Indices
    outgoing: Indices
    valence: Indices
    sharpness: Floats
    corner_sharpness: Floats

    @classmethod
    def from_faces(
        cls,
        face_offsets: ArrayLike,
        face_vertices: ArrayLike,
        vertex_count: int,
        crease_edges: ArrayLike | None = None,
        crease_sharpness: ArrayLike | None = None,
        corner_vertices: ArrayLike | None = None,
        corner_sharpness: ArrayLike | None = None,
    ) -> "Topology":
        """Build the half-edges of an oriented manifold mesh.

        Parameters
        ----------
        face_offsets, face_vertices
            Ragged faces, as in `MeshData`.
        vertex_count
            Number of vertices; vertices without a face are refused.
        crease_edges, crease_sharpness
            (e, 2) vertex pairs and (e,) sharpness (default: sharp for ever).
        corner_vertices, corner_sharpness
            (c,) vertices and (c,) sharpness (default: sharp for ever).

        Raises
        ------
        InputError
            The faces are not an oriented manifold, or a tag names an edge that does not exist.
        """
        offsets = np.ascontiguousarray(face_offsets, np.int32)
        corners = np.ascontiguousarray(face_vertices, np.int32)
        if len(corners) and (corners.min() < 0 or corners.max() >= vertex_count):
            raise InputError(f"a face names a vertex outside 0..{vertex_count - 1}; mend the face list")
        following, face, twin, edge, edge_count, bad = pair_half_edges(offsets, corners, vertex_count)
        if bad >= 0:
            ends = corners[bad], corners[following[bad]]
            raise InputError(
                f"edge ({ends[0]}, {ends[1]}) has more than two faces or two that disagree in orientation; repair the mesh"
            )
        outgoing, valence, bad = outgoing_half_edges(offsets, corners, face, following, twin, vertex_count)
        if bad >= 0:
            raise InputError(f"vertex {bad} joins separate fans of faces; split it into one vertex a fan")
        if vertex_count and valence.min() == 0:
            raise InputError(f"vertex {int(np.argmin(valence))} belongs to no face; remove isolated vertices")
        sharpness = np.zeros(edge_count)
        if crease_edges is not None and len(np.atleast_1d(crease_edges)):
            rows = np.asarray(crease_edges, np.int64).reshape(-1, 2)
            tags = _tags(crease_sharpness, len(rows))
            sharpness[_find_edges(corners, following, edge, vertex_count, rows)] = tags
        sharpness[edge[twin < 0]] = np.inf
        corner_tags = np.zeros(vertex_count)
        if corner_vertices is not None:
            vertices = np.asarray(corner_vertices, np.int64)
            corner_tags[vertices] = _tags(corner_sharpness, len(vertices))
        return cls(
            vertex_count,
            offsets,
            corners,
            following,
            face,
            twin,
            edge,
            outgoing,
            valence,
            sharpness,
            corner_tags,
        )

    @classmethod
    def from_triangles(cls, triangles: ArrayLike, vertex_count: int, **tags: ArrayLike | None) -> "Topology":
        """Build from a (m, 3) array of triangles; `tags` as in `from_faces`."""
        rows = np.asarray(triangles, np.int32).reshape(-1, 3)
        return cls.from_faces(np.arange(0, 3 * len(rows) + 1, 3), rows.ravel(), vertex_count, **tags)

    @property
    def face_count(self) -> int:
        """Number of faces."""
        return len(self.face_offsets) - 1

    @property
    def edge_count(self) -> int:
        """Number of edges."""
        return len(self.sharpness)

    @cached_property
    def triangles_only(self) -> bool:
        """Whether every face is a triangle."""
        return bool(np.all(np.diff(self.face_offsets) == 3))

    @property
    def triangles(self) -> Indices:
        """The faces of a triangle mesh as (m, 3) int32."""
        if not self.triangles_only:
            raise InputError("the mesh has faces that are not triangles; triangulate it or choose a polygon scheme")
        return self.face_vertices.reshape(-1, 3)

    @cached_property
    def edge_vertices(self) -> Indices:
        """Ends of each edge, (e, 2) int32, as its first half-edge runs."""
        ends = np.empty((self.edge_count, 2), np.int32)
        first = np.flatnonzero((self.twin < 0) | (np.arange(len(self.twin)) < self.twin))
        ends[self.edge[first], 0] = self.face_vertices[first]
        ends[self.edge[first], 1] = self.face_vertices[self.following[first]]
        return ends

    @cached_property
    def boundary_edges(self) -> NDArray[np.bool_]:
        """Whether each edge has one face only, (e,)."""
        flags = np.zeros(self.edge_count, np.bool_)
        flags[self.edge[self.twin < 0]] = True
        return flags

    @cached_property
    def crease_edges(self) -> NDArray[np.int64]:
        """Edges inside the surface that carry sharpness: row numbers, ascending."""
        return np.flatnonzero((self.sharpness > 0) & ~self.boundary_edges)


def _tags(sharpness: ArrayLike | None, count: int) -> Floats:
    """Sharpness as we keep it: ``inf`` from `SHARP_FOR_EVER` on, and where none is given."""
    if sharpness is None:
        return np.full(count, np.inf)
    values = np.asarray(sharpness, np.float64)
    return np.where(values >= SHARP_FOR_EVER, np.inf, values)


def _find_edges(
    corners: Indices, following: Indices, edge: Indices, vertex_count: int, pairs: NDArray[np.int64]
) -> NDArray[np.int64]:
    origin = corners.astype(np.int64)
    target = origin[following]
    keys = np.minimum(origin, target) * vertex_count + np.maximum(origin, target)
    order = np.argsort(keys, kind="stable")
    wanted = pairs.min(axis=1) * vertex_count + pairs.max(axis=1)
    slots = np.searchsorted(keys[order], wanted)
    found = slots < len(keys)
    found[found] = keys[order[slots[found]]] == wanted[found]
    if not found.all():
        first = pairs[np.flatnonzero(~found)[0]]
        raise InputError(
            f"crease ({first[0]}, {first[1]}) is not an edge of the mesh; remove the tag or mend the faces"
        )
    return edge[order[slots]].astype(np.int64)
