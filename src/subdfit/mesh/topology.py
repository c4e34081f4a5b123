"""Connectivity of a polygon mesh: half-edges over ragged faces, creases and corners. Immutable."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from subdfit.errors import InputError
from subdfit.mesh._topology_kernels import (
    find_edges,
    link_half_edges,
    outgoing_half_edges,
    pair_half_edges,
    repeated_vertex,
    separate_fans,
)
from subdfit.mesh.checks import whole_numbers, whole_rows
from subdfit.mesh.data import SHARP_FOR_EVER

Indices = NDArray[np.int32]
Whole = NDArray[Any]
Floats = NDArray[np.float64]


class Creases(NamedTuple):
    """Both half-edges of each sharp edge inside the surface, (k,), and their edges' sharpness, (k,) float64."""

    half_edges: NDArray[np.integer]
    sharpness: Floats

    @classmethod
    def of(cls, half_edges: NDArray[np.integer], sharpness: Floats) -> "Creases":
        """The sharp ones among half-edges inside the surface."""
        sharp = sharpness > 0
        return cls(half_edges[sharp], sharpness[sharp])


NO_CREASES = Creases(np.empty(0, np.int32), np.empty(0))


class _Links(NamedTuple):
    following: Indices
    face: Indices
    edge: Indices


class _Stars(NamedTuple):
    outgoing: Indices
    valence: Indices


@dataclass(frozen=True, eq=False)
class Topology:
    """An oriented manifold polygon mesh without positions.

    A half-edge is a face corner: half-edge ``h`` starts at ``face_vertices[h]`` and runs round its face
    counter-clockwise. What follows from faces and twins is made when it is first asked for: the last level of a
    refinement may never need it, and is the largest.

    Attributes
    ----------
    vertex_count : number of vertices.
    face_offsets : (m + 1,) int32.
    face_vertices : (h,) int32, the origin of each half-edge.
    twin : (h,) int32, the half-edge back, of the next face; -1 on the boundary.
    corner_sharpness : (n,) float64, as `sharpness`, for corner vertices.
    creases : the edges inside that are sharp.
    """

    vertex_count: int
    face_offsets: Indices
    face_vertices: Indices
    twin: Indices
    corner_sharpness: Floats
    creases: Creases = NO_CREASES

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
            Offsets that do not fit the faces, indices that are out of range or no whole numbers, a face of fewer than
            three corners or with a vertex twice; faces that are no oriented manifold; a tag on an edge or a vertex
            that does not exist, or whose sharpness is missing, negative or no number.
        """
        offsets, corners = _faces(face_offsets, face_vertices, vertex_count)
        twin, *bad = pair_half_edges(offsets, corners, vertex_count)
        if bad[0] >= 0:
            what = "more than two faces or two that disagree in orientation"
            raise InputError(f"edge ({bad[0]}, {bad[1]}) has {what}; repair the mesh")
        topology = cls.from_twins(offsets, corners, twin, vertex_count)
        fans = separate_fans(offsets, topology.face, twin, topology.outgoing, topology.valence)
        if fans >= 0:
            raise InputError(f"vertex {fans} joins separate fans of faces; split it into one vertex a fan")
        if vertex_count and topology.valence.min() == 0:
            vertex = int(np.argmin(topology.valence))
            raise InputError(f"vertex {vertex} belongs to no face; remove isolated vertices")
        edges = topology._edges_between(whole_rows([] if crease_edges is None else crease_edges, 2, "crease edges"))
        sharpness = topology.sharpness.copy()
        sharpness[edges] = _tags(crease_sharpness, len(edges), "crease")
        tagged = _corner_vertices([] if corner_vertices is None else corner_vertices, vertex_count)
        topology.corner_sharpness[tagged] = _tags(corner_sharpness, len(tagged), "corner")
        return topology.with_sharpness(sharpness) if len(edges) else topology

    def with_sharpness(self, sharpness: Floats) -> "Topology":
        """The same mesh with other sharpness of its edges, (e,); nothing softens the boundary."""
        inside = np.flatnonzero(self.twin >= 0)
        return replace(self, creases=Creases.of(inside, sharpness[self.edge[inside]]))

    @classmethod
    def from_twins(
        cls,
        face_offsets: Indices,
        face_vertices: Indices,
        twin: Indices,
        vertex_count: int,
        creases: Creases = NO_CREASES,
    ) -> "Topology":
        """Build from a sound manifold's faces, whose half-edges are paired already; no vertex is a corner."""
        return cls(vertex_count, face_offsets, face_vertices, twin, np.zeros(vertex_count), creases)

    @classmethod
    def from_triangles(cls, triangles: ArrayLike, vertex_count: int, **tags: ArrayLike | None) -> "Topology":
        """Build from a (m, 3) array of triangles; `tags` as in `from_faces`."""
        rows = whole_rows(triangles, 3, "faces")
        return cls.from_faces(np.arange(0, 3 * len(rows) + 1, 3), rows.ravel(), vertex_count, **tags)

    @property
    def face_count(self) -> int:
        """Number of faces."""
        return len(self.face_offsets) - 1

    @cached_property
    def edge_count(self) -> int:
        """Number of edges."""
        return (len(self.twin) + int(np.count_nonzero(self.twin < 0))) // 2

    @cached_property
    def _links(self) -> _Links:
        links = _Links(*(np.empty(len(self.twin), np.int32) for _ in range(3)))
        link_half_edges(self.face_offsets, self.twin, *links)
        return links

    @property
    def following(self) -> Indices:
        """The next half-edge of the same face, (h,) int32."""
        return self._links.following

    @property
    def face(self) -> Indices:
        """The face of each half-edge, (h,) int32."""
        return self._links.face

    @property
    def edge(self) -> Indices:
        """The edge of each half-edge, (h,) int32: numbered as half-edges first meet them."""
        return self._links.edge

    @cached_property
    def _stars(self) -> _Stars:
        stars = _Stars(np.full(self.vertex_count, -1, np.int32), np.zeros(self.vertex_count, np.int32))
        outgoing_half_edges(self.face_vertices, self.twin, *stars)
        return stars

    @property
    def outgoing(self) -> Indices:
        """One half-edge that leaves each vertex, (n,) int32: the first counter-clockwise on a boundary."""
        return self._stars.outgoing

    @property
    def valence(self) -> Indices:
        """Number of faces round each vertex, (n,) int32."""
        return self._stars.valence

    @cached_property
    def sharpness(self) -> Floats:
        """Crease sharpness of each edge, (e,) float64: ``inf`` on the boundary, and from 10 on."""
        sharpness, boundary = np.zeros(self.edge_count), self.twin < 0
        for half_edges, values in (self.creases, (np.flatnonzero(boundary), np.inf)):
            if len(half_edges):
                sharpness[self.edge[half_edges]] = values
        return sharpness

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
        first = np.flatnonzero((self.twin < 0) | (np.arange(len(self.twin), dtype=np.int32) < self.twin))
        ends[self.edge[first], 0] = self.face_vertices[first]
        ends[self.edge[first], 1] = self.face_vertices[self.following[first]]
        return ends

    def ends(self, edges: NDArray[np.integer]) -> Indices:
        """Ends (k, 2) of some edges, (k,); where there are none, `edge_vertices` need not be made."""
        return self.edge_vertices[edges] if len(edges) else np.empty((0, 2), np.int32)

    @cached_property
    def boundary_edges(self) -> NDArray[np.bool_]:
        """Whether each edge has one face only, (e,)."""
        flags, boundary = np.zeros(self.edge_count, np.bool_), np.flatnonzero(self.twin < 0)
        if len(boundary):
            flags[self.edge[boundary]] = True
        return flags

    @cached_property
    def boundary_vertices(self) -> NDArray[np.bool_]:
        """Whether each vertex lies on the boundary, (n,)."""
        flags = np.zeros(self.vertex_count, np.bool_)
        flags[self.ends(np.flatnonzero(self.boundary_edges))] = True
        return flags

    @cached_property
    def crease_edges(self) -> NDArray[np.int64]:
        """Edges inside the surface that carry sharpness: row numbers, ascending."""
        sharp = self.creases.half_edges
        return np.unique(self.edge[sharp]).astype(np.int64) if len(sharp) else np.empty(0, np.int64)

    def _edges_between(self, pairs: Whole) -> Indices:
        """Edges by their ends, either way round, (e, 2)."""
        inside = ((pairs >= 0) & (pairs < self.vertex_count)).all(axis=1)
        edges = np.full(len(pairs), -1, np.int32)
        edges[inside] = find_edges(
            pairs[inside].astype(np.int32),
            self.outgoing,
            self.face_offsets,
            self.face_vertices,
            self.following,
            self.face,
            self.twin,
            self.edge,
        )
        bad = np.flatnonzero(edges < 0)
        if len(bad):
            ends = pairs[bad[0]]
            raise InputError(
                f"crease ({ends[0]}, {ends[1]}) is not an edge of the mesh; remove the tag or mend the faces"
            )
        return edges


def _faces(face_offsets: ArrayLike, face_vertices: ArrayLike, vertex_count: int) -> tuple[Indices, Indices]:
    """Ragged faces that kernels may walk: every index in range, three corners or more a face and no vertex twice."""
    corners = whole_numbers(face_vertices, "face vertices").ravel()
    offsets = _offsets(face_offsets, len(corners))
    if len(corners) and (corners.min() < 0 or corners.max() >= vertex_count):
        first = int(np.argmax((corners < 0) | (corners >= vertex_count)))
        face = int(np.searchsorted(offsets, first, side="right")) - 1
        raise InputError(
            f"face {face} names vertex {corners[first]}, outside 0..{vertex_count - 1}; mend the face list"
        )
    corners = np.ascontiguousarray(corners, np.int32)
    face, vertex = repeated_vertex(offsets, corners, vertex_count)
    if face >= 0:
        raise InputError(f"face {face} has vertex {vertex} more than once; remove the face or cut it there")
    return offsets, corners


def _offsets(face_offsets: ArrayLike, corner_count: int) -> Indices:
    offsets = whole_numbers(face_offsets, "face offsets").ravel()
    if not len(offsets) or offsets[0] != 0:
        raise InputError("the offset of face 0 is not 0; give one offset a face, from 0 on, and the number of corners")
    # In floating point no difference wraps round.
    short = np.flatnonzero(np.diff(offsets.astype(np.float64)) < 3)
    if len(short):
        begin, end = offsets[short[0] : short[0] + 2]
        raise InputError(f"face {short[0]} has corners {begin} up to {end}; a face takes three or more")
    if offsets[-1] != corner_count:
        raise InputError(
            f"the last of {len(offsets) - 1} faces ends at corner {offsets[-1]} of {corner_count}; mend the offsets"
        )
    return np.ascontiguousarray(offsets, np.int32)


def _corner_vertices(values: ArrayLike, vertex_count: int) -> NDArray[np.intp]:
    vertices = whole_numbers(values, "corner vertices").ravel()
    bad = np.flatnonzero((vertices < 0) | (vertices >= vertex_count))
    if len(bad):
        raise InputError(f"corner vertex {vertices[bad[0]]} is outside 0..{vertex_count - 1}; remove the tag")
    return vertices.astype(np.intp)


def _tags(sharpness: ArrayLike | None, count: int, what: str) -> Floats:
    """Sharpness as we keep it: ``inf`` from `SHARP_FOR_EVER` on, and where none is given."""
    if sharpness is None:
        return np.full(count, np.inf)
    values = np.asarray(sharpness, np.float64)
    if values.shape != (count,):
        raise InputError(f"{what} sharpness comes in shape {values.shape} for {count} tags; give one value a tag")
    bad = np.flatnonzero(~(values >= 0))
    if len(bad):
        raise InputError(f"{what} {bad[0]} has sharpness {values[bad[0]]}; give 0 or more, 10 for sharp for ever")
    return np.where(values >= SHARP_FOR_EVER, np.inf, values)
