"""Doo-Sabin subdivision of polygon meshes (Doo and Sabin 1978), with boundaries, creases and corners.

The limit is biquadratic over regular parts. New vertices stand for the corners of faces: the scheme is dual.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.mesh.topology import Topology
from subdfit.schemes._doo_sabin_cells import Cells
from subdfit.schemes._doo_sabin_child import child_topology
from subdfit.schemes._doo_sabin_curves import Curves
from subdfit.schemes._doo_sabin_patches import compile_dual
from subdfit.schemes._doo_sabin_refine import DualRows, Numbers
from subdfit.schemes._doo_sabin_thin import without_thin_vertices
from subdfit.schemes.domain import Domain
from subdfit.schemes.patch_table import PatchTable
from subdfit.schemes.scheme import Faces, MatrixRows, Refinement, Rows


@dataclass(frozen=True)
class DooSabin:
    """Doo and Sabin's scheme; boundary edges are sharp, and sharp curves bound what is smooth.

    Curves are quadratic B-splines of their control polygons. They end in corners: tagged vertices on them, ends of
    three or more sharp edges, and vertices with a single face between two sharp edges.

    Attributes
    ----------
    name : the scheme's name.
    averaging : take the mask that averages (Cheng et al. 2009) in place of Doo and Sabin's own.
    """

    name: str = "doo-sabin"
    averaging: bool = False
    faces: Faces = "polygons"
    whole_curves: bool = True

    def validate(self, topology: Topology) -> None:
        """Raise InputError for semi-sharp tags, and for corners on no curve or where creases end inside the surface."""
        t = topology
        tags = np.concatenate([t.sharpness, t.corner_sharpness])
        if np.any((tags > 0) & np.isfinite(tags)):
            raise InputError(
                "Doo-Sabin subdivision takes creases and corners that are sharp for ever; give sharpness 10"
            )
        curves = Curves.of(t)
        tagged = t.corner_sharpness > 0
        _refuse(
            tagged & (curves.sharp_count == 1),
            "is tagged a corner where a crease ends inside the surface; remove the tag",
        )
        _refuse(tagged & ~curves.on_curve, "is tagged a corner but lies on no crease or boundary; remove the tag")

    def domain(self, topology: Topology) -> Domain:
        """One quad a face corner, from the corner's vertex over the middle of its edge to the middle of its face.

        A corner on a plain curve (see `_doo_sabin_curves`) has none: the cells beside it reach to the curve. A face
        with an inner vertex of two faces counts as the triangles into which it is cut at its centroid.
        """
        domain = Cells.of(Curves.of(without_thin_vertices(topology)[0])).domain()
        return replace(domain, vertex=np.where(domain.vertex < topology.vertex_count, domain.vertex, np.int32(-1)))

    def refine(self, topology: Topology) -> Refinement:
        """Make a face of each face, a quad of each smooth edge, and a polygon of each vertex, in this order.

        New vertices stand for face corners, those inside the surface first, in the order of half-edges; along curves
        see `_doo_sabin_child.child_topology`. No new vertex stands for a vertex or an edge.
        """
        whole, matrix = without_thin_vertices(topology)
        curves = Curves.of(whole)
        numbers = Numbers(curves)
        child, _ = child_topology(curves, numbers)
        rows: Rows = DualRows(curves, numbers, self.averaging)
        if matrix is not None:
            rows = MatrixRows(sp.csr_array(rows.matrix @ matrix))
        return Refinement(child, rows, np.full(topology.vertex_count, -1), np.full(topology.edge_count, -1))

    def limit_rows(self, topology: Topology) -> sp.csr_array:
        """Limit of each vertex: the mean of the new vertices that stand for it, inside or on its curve."""
        whole, matrix = without_thin_vertices(topology)
        curves = Curves.of(whole)
        numbers = Numbers(curves)
        limits = numbers.means @ DualRows(curves, numbers, self.averaging).matrix
        limits = limits if matrix is None else limits @ matrix
        return sp.csr_array(limits[: topology.vertex_count])

    def limit_points(self, topology: Topology, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Limit points of control points."""
        whole, matrix = without_thin_vertices(topology)
        curves = Curves.of(whole)
        rows = DualRows(curves, Numbers(curves), self.averaging)
        return rows.limits(points if matrix is None else np.asarray(matrix @ points))[: topology.vertex_count]

    def patches(self, topology: Topology) -> PatchTable:
        """Compile for exact evaluation: one biquadratic patch a cell, four where both its ends are irregular."""
        self.validate(topology)
        whole, matrix = without_thin_vertices(topology)
        return compile_dual(Cells.of(Curves.of(whole)), self.averaging, matrix)


def _refuse(bad: np.ndarray[tuple[int], np.dtype[np.bool_]], why: str) -> None:
    if bad.any():
        raise InputError(f"vertex {np.argmax(bad)} {why}")
