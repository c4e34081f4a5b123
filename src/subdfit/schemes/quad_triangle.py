"""Quad-triangle subdivision of meshes of triangles and quads (Stam and Loop 2003): Loop's scheme among triangles,
Catmull and Clark's among quads, smooth across the seams between them. Larger faces become quads.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.mesh.topology import Topology
from subdfit.schemes._cells import face_cells
from subdfit.schemes._compile import compile_patches
from subdfit.schemes._limits import limit_points, limit_rows
from subdfit.schemes._quad_triangle_limits import MixedLimits
from subdfit.schemes._quad_triangle_rules import QUADS_FROM, refine
from subdfit.schemes._quad_triangle_types import MixedPatches
from subdfit.schemes._split import split
from subdfit.schemes.domain import Domain
from subdfit.schemes.patch_table import PatchTable
from subdfit.schemes.scheme import Faces, Refinement


@dataclass(frozen=True)
class QuadTriangle:
    """Stam and Loop's scheme, with boundaries, creases, darts and corners as in Loop's.

    Boundary edges are sharp; vertices with three or more sharp edges and tagged ones are corners. Inner vertices where
    triangles meet quads in other ways than along a regular seam are corrected so that their curvature stays bounded, or
    as near to it as their faces allow (Stam and Loop 2003, section 5).
    """

    name: str = "quad-triangle"
    faces: Faces = "mixed"
    whole_curves: bool = False

    def validate(self, topology: Topology) -> None:
        """Raise InputError unless all inner valences are 3 or more."""
        thin = np.flatnonzero(~topology.boundary_vertices & (topology.valence < 3))
        if len(thin):
            raise InputError(f"inner vertex {thin[0]} has valence 2; merge its two faces into one")

    def domain(self, topology: Topology) -> Domain:
        """One cell a face, its corners in the face's order; where a face is larger than a quad, one cell a child.

        Then every face is represented by its children in `refine`: four triangles, or a quad a corner.
        """
        if _small(topology):
            return face_cells(topology)
        return face_cells(split(topology, QUADS_FROM), topology.vertex_count)

    def refine(self, topology: Topology) -> Refinement:
        """Split a triangle into four (at its corners, then in its middle), any other face into a quad a corner.

        Vertices keep their rows; the new vertex of edge e is row n + e; the centroids of the faces that are no
        triangles follow in the faces' order. Triangles' children are those of Loop's scheme; a quad begins at its
        corner and runs along the corner's half-edge.
        """
        return refine(topology)

    def limit_rows(self, topology: Topology) -> sp.csr_array:
        """Limit masks of all vertices; those at larger faces, and semi-sharp ones, by refining first."""
        return limit_rows(MixedLimits(refine), topology)

    def limit_points(self, topology: Topology, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Limit points of control points."""
        return limit_points(MixedLimits(refine), topology, points)

    def patches(self, topology: Topology) -> PatchTable:
        """Compile for evaluation: exact but in strips beside seams, which are refined until they are negligible."""
        self.validate(topology)
        if _small(topology):
            return compile_patches(MixedPatches(), topology)
        step = refine(topology)
        return compile_patches(MixedPatches(), step.child, step.matrix)


def _small(t: Topology) -> bool:
    """Whether no face has more than four corners."""
    return bool(np.diff(t.face_offsets).max(initial=0) <= 4)
