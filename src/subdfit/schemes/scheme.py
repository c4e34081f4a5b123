"""What a subdivision scheme is: the protocol that everything above works with."""

from dataclasses import dataclass
from typing import Literal, Protocol, runtime_checkable

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.mesh.topology import Topology
from subdfit.schemes.domain import Domain
from subdfit.schemes.patch_table import PatchTable

Faces = Literal["triangles", "polygons", "mixed"]
"""Faces a scheme takes: triangles alone; polygons of any kind, quads for choice; triangles and quads."""


class Rows(Protocol):
    """What refinement does to points: a sparse matrix, or the same without making one."""

    @property
    def matrix(self) -> sp.csr_array:
        """(child vertices, vertices) sparse; its rows sum to one."""
        ...

    def apply(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """New positions (child vertices, 3) from points (n, 3)."""
        ...


@dataclass(frozen=True, eq=False)
class MatrixRows:
    """Refinement by a matrix that is there."""

    matrix: sp.csr_array

    def apply(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """New positions (child vertices, 3) from points (n, 3)."""
        return np.asarray(self.matrix @ points)


@dataclass(frozen=True, eq=False)
class Refinement:
    """One step of subdivision.

    Attributes
    ----------
    child : the refined connectivity.
    rows : what becomes of points.
    vertex_row : (n,) int64, the child vertex that each vertex becomes; -1 in dual schemes, where it is a face.
    edge_row : (e,) int64, the child vertex that stands for each edge; -1 likewise.
    """

    child: Topology
    rows: Rows
    vertex_row: NDArray[np.int64]
    edge_row: NDArray[np.int64]

    @property
    def matrix(self) -> sp.csr_array:
        """(child vertices, vertices) sparse; its rows sum to one."""
        return self.rows.matrix

    def refined(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """New positions (child vertices, 3) from points (n, 3), without the matrix where the scheme can."""
        return self.rows.apply(points)


@runtime_checkable
class Scheme(Protocol):
    """A subdivision scheme: rules that depend on connectivity alone, linear in the control points."""

    @property
    def name(self) -> str:
        """The name users and files know it by."""
        ...

    @property
    def faces(self) -> Faces:
        """The faces it takes, and so those of the first control mesh of a fit."""
        ...

    @property
    def whole_curves(self) -> bool:
        """Whether its masks beside a sharp curve depend on the whole curve, rather than on the faces round a vertex."""
        ...

    def validate(self, topology: Topology) -> None:
        """Raise InputError where the scheme cannot take this connectivity."""
        ...

    def domain(self, topology: Topology) -> Domain:
        """Return the parametric faces."""
        ...

    def refine(self, topology: Topology) -> Refinement:
        """Return one step of subdivision."""
        ...

    def limit_rows(self, topology: Topology) -> sp.csr_array:
        """Return the (n, n) sparse matrix from control points to their limit points."""
        ...

    def limit_points(self, topology: Topology, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the limit points (n, 3) of control points, without that matrix where the scheme can."""
        ...

    def patches(self, topology: Topology) -> PatchTable:
        """Return the topology compiled for exact evaluation."""
        ...
