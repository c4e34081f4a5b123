"""Refinement rules of schemes whose vertices stay: weights of neighbours and of face centroids, sharp or smooth.

Semi-sharp tags follow OpenSubdiv's uniform rule: sharpness counts down by one a level; an edge of less than one blends
the crease rule and the smooth rule; a vertex blends the rules before and after what expires in this step, by the mean
sharpness of what does.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.mesh.topology import Topology
from subdfit.schemes import _stencil_kernels as kernels

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


class VertexMask(NamedTuple):
    """A smooth vertex rule, (n,) each: weights of the vertex itself, of each neighbour, of each face's centroid."""

    own: Floats
    edge: Floats
    centroid: Floats


class SideWeights(NamedTuple):
    """What a face adds to the new point of a smooth edge: of each end, and of the face's centroid."""

    end: float
    centroid: float


BESIDE_TRIANGLE = SideWeights(1 / 16, 3 / 8)
"""Two of them make Loop's edge rule 3/8, 3/8, 1/8, 1/8."""
BESIDE_POLYGON = SideWeights(1 / 8, 1 / 4)
"""Two of them make Catmull and Clark's edge rule, the mean of both ends and both centroids."""


@dataclass(frozen=True)
class SmoothRules:
    """The smooth rules of a scheme.

    Attributes
    ----------
    vertex : makes the vertex rule of all vertices of a mesh.
    triangle, polygon : what triangles and larger faces add to their edges' points.
    centroids_from : corners from which on a face's centroid becomes a point and counts for vertices; 0 for none.
    """

    vertex: Callable[[Topology], VertexMask]
    triangle: SideWeights
    polygon: SideWeights
    centroids_from: int

    def has_centroid(self, t: Topology) -> Flags:
        """Which faces' centroids become points, (f,)."""
        size = np.diff(t.face_offsets)
        return np.asarray((self.centroids_from > 0) & (size >= self.centroids_from))


@dataclass(frozen=True, eq=False)
class Stencils:
    """One step of refinement of a mesh: `matrix`, or `apply` without one."""

    topology: Topology
    rules: SmoothRules

    @cached_property
    def weights(self) -> Floats:
        """Vertex rules, (n, 5).

        Columns: the vertex itself; each neighbour; each face's centroid; besides, each neighbour along an edge that is
        sharp in this step, and each along one that is sharp in the next too.
        """
        t = self.topology
        smooth = self.rules.vertex(t)
        out = _kind_weights(smooth, _Kinds.of(t, 0.0), 3)
        share = _expiring(t)
        if np.any(share < 1):
            out *= share[:, None]
            out += (1 - share)[:, None] * _kind_weights(smooth, _Kinds.of(t, 1.0), 4)
        return out

    def apply(self, points: Floats) -> Floats:
        """New positions from points (n, 3): vertices, middles of edges, and centroids of faces if they get points."""
        rules = self.rules
        sides = np.array([rules.triangle, rules.polygon])
        return _masked(self.topology, self.weights, rules.has_centroid(self.topology), sides, False, points)

    @cached_property
    def matrix(self) -> sp.csr_array:
        """The same as a sparse matrix; its rows sum to one."""
        centroids = centroid_rows(self.topology)
        points = self.rules.has_centroid(self.topology)
        masks = mask_rows(self.topology, self.weights, points)
        blocks = [masks, self._edge_rows(centroids), centroids[np.flatnonzero(points)]]
        return sp.csr_array(sp.vstack(blocks, format="csr"))

    def _edge_rows(self, centroids: sp.csr_array) -> sp.csr_array:
        t, rules = self.topology, self.rules
        crease = np.minimum(t.sharpness, 1.0)
        triangle = np.diff(t.face_offsets)[t.face] == 3
        side = np.where(triangle[:, None], rules.triangle, rules.polygon)
        ends = (1 - crease) * np.bincount(t.edge, side[:, 0], t.edge_count) + crease / 2
        edges = np.arange(t.edge_count)
        shape = (t.edge_count, t.vertex_count)
        near = sp.csr_array((np.repeat(ends, 2), (np.repeat(edges, 2), t.edge_vertices.ravel())), shape=shape)
        smooth = np.flatnonzero(crease[t.edge] < 1)
        values = (1 - crease[t.edge[smooth]]) * side[smooth, 1]
        beside = sp.csr_array((values, (t.edge[smooth], t.face[smooth])), shape=(t.edge_count, t.face_count))
        return sp.csr_array(near + beside @ centroids)


@dataclass(frozen=True, eq=False)
class _Kinds:
    """Which rule vertices take, (n,) each: smooth (darts too), crease, corner."""

    smooth: Flags
    crease: Flags
    corner: Flags

    @classmethod
    def of(cls, t: Topology, levels: float) -> "_Kinds":
        """The rules after some levels, while the mesh's own edges are concerned."""
        sharp = t.ends(np.flatnonzero(t.sharpness > levels))
        count = np.bincount(sharp.ravel(), minlength=t.vertex_count)
        corner = (t.corner_sharpness > levels) | (count >= 3)
        crease = ~corner & (count == 2)
        return cls(~corner & ~crease, crease, corner)


def _kind_weights(smooth: VertexMask, kinds: _Kinds, ring: int) -> Floats:
    """The vertex rules of given kinds, (n, 5), a crease's neighbours in column `ring`."""
    out = np.zeros((len(kinds.smooth), 5))
    for column, weight in enumerate(smooth):
        np.copyto(out[:, column], weight, where=kinds.smooth)
    out[kinds.crease, 0], out[kinds.crease, ring] = 6 / 8, 1 / 8
    out[kinds.corner, 0] = 1.0
    return out


def _expiring(t: Topology) -> Floats:
    """Share of the present rule at each vertex, (n,): the mean sharpness of the tags that expire in this step."""
    total, count = np.zeros(t.vertex_count), np.zeros(t.vertex_count)
    edges = np.flatnonzero((t.sharpness > 0) & (t.sharpness <= 1))
    np.add.at(total, t.ends(edges), t.sharpness[edges, None])
    np.add.at(count, t.ends(edges), 1)
    corners = np.flatnonzero((t.corner_sharpness > 0) & (t.corner_sharpness <= 1))
    total[corners] += t.corner_sharpness[corners]
    count[corners] += 1
    return np.divide(total, count, out=np.ones(t.vertex_count), where=count > 0)


def later(sharpness: Floats) -> Floats:
    """Sharpness one level later."""
    return np.maximum(sharpness - 1.0, 0.0)


def centroid_rows(t: Topology) -> sp.csr_array:
    """Centroids of the faces, (f, n) sparse."""
    size = np.diff(t.face_offsets)
    shape = (t.face_count, t.vertex_count)
    return sp.csr_array((1 / np.repeat(size, size), t.face_vertices, t.face_offsets), shape=shape)


def mask_rows(t: Topology, weights: Floats, has_centroid: Flags | None = None) -> sp.csr_array:
    """Rows of vertex masks, (n, n), from the weights (n, 5) that `Stencils.weights` describes.

    The centroids of the given faces count, (f,); None stands for all.
    """
    counted = np.ones(t.face_count, np.bool_) if has_centroid is None else has_centroid
    offsets, columns, values = kernels.mask_rows(
        t.face_offsets, t.face_vertices, t.edge_vertices, t.sharpness, weights, counted
    )
    return sp.csr_array((values, columns, offsets), shape=(t.vertex_count, t.vertex_count))


def mask_points(t: Topology, weights: Floats, points: Floats) -> Floats:
    """What `mask_rows`, with all centroids, makes of points (n, 3), without the rows."""
    return _masked(t, weights, np.ones(t.face_count, np.bool_), np.zeros((2, 2)), True, points)


def _masked(
    t: Topology, weights: Floats, has_centroid: Flags, sides: Floats, vertices_only: bool, points: Floats
) -> Floats:
    given = np.ascontiguousarray(points, np.float64)
    mesh = (t.face_offsets, t.face_vertices, t.following, t.twin, t.edge, t.sharpness)
    count = t.vertex_count
    if not vertices_only:
        count += t.edge_count + int(np.count_nonzero(has_centroid))
    out = np.zeros((count, 3))
    kernels.refined_points(*mesh, weights, has_centroid, sides, vertices_only, given, out)
    return out
