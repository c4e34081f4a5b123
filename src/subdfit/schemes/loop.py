"""Loop subdivision of triangle meshes, with boundaries, creases, darts and corners (Loop 1987; Hoppe et al. 1994)."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.mesh.topology import Topology
from subdfit.schemes._cells import face_cells
from subdfit.schemes._compile import compile_patches
from subdfit.schemes._limits import OneShapeLimits, limit_points, limit_rows
from subdfit.schemes._loop_types import limit_mask as dart_mask
from subdfit.schemes._loop_types import vertex_alpha
from subdfit.schemes._split import split
from subdfit.schemes._stencils import BESIDE_TRIANGLE, SmoothRules, Stencils, VertexMask
from subdfit.schemes._triangle_patches import TrianglePatches
from subdfit.schemes.domain import Domain
from subdfit.schemes.patch_table import PatchTable
from subdfit.schemes.scheme import Faces, Refinement

NO_QUADS = 4
"""More corners than any face has: all are triangles."""


@dataclass(frozen=True)
class Loop:
    """Loop's scheme; boundary edges are sharp, vertices with three or more sharp edges and tagged ones are corners."""

    name: str = "loop"
    faces: Faces = "triangles"
    whole_curves: bool = False

    def validate(self, topology: Topology) -> None:
        """Raise InputError unless all faces are triangles and all inner valences 3 or more."""
        if not topology.triangles_only:
            raise InputError("Loop subdivision takes triangles only; triangulate the mesh or choose another scheme")
        thin = np.flatnonzero(~topology.boundary_vertices & (topology.valence < 3))
        if len(thin):
            raise InputError(
                f"inner vertex {thin[0]} has valence 2; collapse one of its edges, or leave its component out"
            )

    def domain(self, topology: Topology) -> Domain:
        """One triangle a face, its corners in the face's order."""
        return face_cells(topology)

    def refine(self, topology: Topology) -> Refinement:
        """Split each triangle into four: children of face f are 4 f to 4 f + 3, the last in its middle.

        Vertices keep their rows; the new vertex of edge e is row n + e.
        """
        t = topology
        rows = np.arange(t.vertex_count + t.edge_count)
        return Refinement(split(t, NO_QUADS), Stencils(t, _RULES), rows[: t.vertex_count], rows[t.vertex_count :])

    def limit_rows(self, topology: Topology) -> sp.csr_array:
        """Limit masks of all vertices: smooth, crease and boundary, dart, corner; semi-sharp ones by refining first."""
        return limit_rows(self._limits, topology)

    def limit_points(self, topology: Topology, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Limit points of control points."""
        return limit_points(self._limits, topology, points)

    @property
    def _limits(self) -> OneShapeLimits:
        return OneShapeLimits(_limit_mask, dart_mask, 3, self.refine)

    def patches(self, topology: Topology) -> PatchTable:
        """Compile for exact evaluation: one patch a face, several where rules or irregular corners part it."""
        self.validate(topology)
        return compile_patches(TrianglePatches(self.refine), topology)


def _by_valence(t: Topology, table: Callable[[int], float]) -> NDArray[np.float64]:
    values = np.array([1.0, *(table(n) for n in range(1, int(t.valence.max(initial=1)) + 1))])
    return values[t.valence]


def _vertex_mask(t: Topology) -> VertexMask:
    """Loop's vertex rule: alpha itself, the rest shared by the neighbours."""
    own = _by_valence(t, vertex_alpha)
    return VertexMask(own, (1 - own) / t.valence, np.zeros(t.vertex_count))


def _limit_mask(t: Topology) -> VertexMask:
    """Limit of an inner vertex: beta = 3 / (11 - 8 alpha) itself, the rest shared by the neighbours."""
    own = 3 / (11 - 8 * _by_valence(t, vertex_alpha))
    return VertexMask(own, (1 - own) / t.valence, np.zeros(t.vertex_count))


_RULES = SmoothRules(_vertex_mask, BESIDE_TRIANGLE, BESIDE_TRIANGLE, centroids_from=0)
