"""Catmull-Clark subdivision of polygon meshes, with boundaries, creases, darts and corners, semi-sharp ones too
(Catmull and Clark 1978; DeRose, Kass and Truong 1998).
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.mesh.topology import Topology
from subdfit.schemes._cells import face_cells
from subdfit.schemes._compile import compile_patches
from subdfit.schemes._limits import OneShapeLimits, limit_points, limit_rows
from subdfit.schemes._quad_patches import QuadPatches
from subdfit.schemes._split import split
from subdfit.schemes._stencils import BESIDE_POLYGON, SmoothRules, Stencils, VertexMask
from subdfit.schemes.domain import Domain
from subdfit.schemes.patch_table import PatchTable
from subdfit.schemes.scheme import Faces, Refinement

QUADS_FROM = 3
"""Corners from which on faces are cut in quads."""


@dataclass(frozen=True)
class CatmullClark:
    """Catmull and Clark's scheme; boundary edges are sharp, vertices with three or more sharp edges are corners."""

    name: str = "catmull-clark"
    faces: Faces = "polygons"
    whole_curves: bool = False

    def validate(self, topology: Topology) -> None:
        """Take every mesh; an inner vertex of two faces is a point of the surface without a tangent plane."""

    def domain(self, topology: Topology) -> Domain:
        """One quad a face where all faces are quads; else a quad for every corner of a face, in `refine`'s order."""
        if _quads_only(topology):
            return face_cells(topology)
        return face_cells(split(topology, QUADS_FROM), topology.vertex_count)

    def refine(self, topology: Topology) -> Refinement:
        """Cut every face in a quad a corner, half-edge h's child being face h, which begins at that corner.

        Vertices keep their rows; the new vertex of edge e is row n + e, the centroid of face f row n + edges + f.
        """
        t = topology
        rows = np.arange(t.vertex_count + t.edge_count)
        return Refinement(split(t, QUADS_FROM), Stencils(t, _RULES), rows[: t.vertex_count], rows[t.vertex_count :])

    def limit_rows(self, topology: Topology) -> sp.csr_array:
        """Limit masks of all vertices: smooth, crease and boundary, dart, corner; semi-sharp ones by refining first."""
        return limit_rows(self._limits, topology)

    def limit_points(self, topology: Topology, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Limit points of control points."""
        return limit_points(self._limits, topology, points)

    @property
    def _limits(self) -> OneShapeLimits:
        return OneShapeLimits(_limit_mask, QuadPatches(self.refine).limit_mask, 4, self.refine)

    def patches(self, topology: Topology) -> PatchTable:
        """Compile for exact evaluation: one bicubic patch a cell, several where rules or irregular corners part it."""
        if _quads_only(topology):
            return compile_patches(QuadPatches(self.refine), topology)
        step = self.refine(topology)
        return compile_patches(QuadPatches(self.refine), step.child, step.matrix)


def _quads_only(t: Topology) -> bool:
    return bool(np.all(np.diff(t.face_offsets) == 4))


def _vertex_mask(t: Topology) -> VertexMask:
    """Catmull and Clark's vertex rule: (n - 2) / n itself, 1 / n^2 each neighbour and each face's centroid."""
    n = t.valence.astype(np.float64)
    return VertexMask((n - 2) / n, 1 / n**2, 1 / n**2)


def _limit_mask(t: Topology) -> VertexMask:
    """Limit of an inner vertex among any polygons: (n (n - 1) V + 2 sum E + 4 sum C) / (n (n + 5)).

    E are its neighbours, C the centroids of its faces (Halstead, Kass and DeRose 1993, for the mesh once refined).
    """
    n = t.valence.astype(np.float64)
    return VertexMask((n - 1) / (n + 5), 2 / (n * (n + 5)), 4 / (n * (n + 5)))


_RULES = SmoothRules(_vertex_mask, BESIDE_POLYGON, BESIDE_POLYGON, centroids_from=QUADS_FROM)
