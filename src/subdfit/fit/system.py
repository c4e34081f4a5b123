"""The linear system of one fitting step: weighted least squares on displacements, solved by conjugate gradients.

``sum_k (e_k - W_k d)^T D_k (e_k - W_k d) + ...`` is never assembled: products go through the rows of W for patch points
and the few rows that make local points from control points.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.fit import _kernels as kernels
from subdfit.fit.places import Places
from subdfit.limit.surface import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.parallel import map_chunks

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

SMOOTHINGS = 20
"""Steps that smooth a spot: enough to unfold a few rings of vertices."""
PART = 24576
"""Rows whose sum is taken at one go; parts are added in their order, whatever the number of threads."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Sparse rows over patch points, with their metric and residual: one term of the energy.

    Attributes
    ----------
    offsets, columns, values : the rows, in CSR form.
    metric : (k, 6), the symmetric D_k: xx, xy, xz, yy, yz, zz.
    residual : (k, 3), e_k.
    """

    offsets: NDArray[np.int64]
    columns: NDArray[np.int32]
    values: Floats
    metric: Floats
    residual: Floats

    def product(self, x: Floats) -> Floats:
        """W^T D W x."""
        return self._summed(
            lambda start, stop, out: kernels.normal_product(
                self.offsets, self.columns, self.values, self.metric, x, start, stop, out
            ),
            x.shape,
        )

    def transposed(self, vectors: Floats, points: int) -> Floats:
        """W^T times (k, c) vectors."""
        return self._summed(
            lambda start, stop, out: kernels.transposed_product(
                self.offsets, self.columns, self.values, vectors, start, stop, out
            ),
            (points, vectors.shape[1]),
        )

    def _summed(self, job, shape: tuple[int, ...]) -> Floats:  # type: ignore[no-untyped-def]
        count = len(self.metric)

        def part(start: int, stop: int) -> Floats:
            out = np.zeros(shape)
            job(start, stop, out)
            return out

        # At most four parts: each needs room for all points.
        parts = map_chunks(part, count, max(PART, -(-count // 4)))
        total = parts[0] if parts else np.zeros(shape)
        for other in parts[1:]:
            total += other
        return total

    @classmethod
    def joined(cls, terms: "list[Rows]") -> "Rows":
        """All rows of several terms as one."""
        ends = np.cumsum([0, *(term.offsets[-1] for term in terms)])
        offsets = [np.zeros(1, np.int64), *(term.offsets[1:] + end for term, end in zip(terms, ends, strict=False))]
        return cls(
            np.concatenate(offsets),
            np.concatenate([term.columns for term in terms]),
            np.concatenate([term.values for term in terms]),
            np.concatenate([term.metric for term in terms]),
            np.concatenate([term.residual for term in terms]),
        )


class System:
    """Normal equations of all terms for the displacement of the control points, (n, 3), zero where these are held."""

    def __init__(
        self,
        surface: LimitSurface,
        rows: list[Rows],
        fairness: float,
        relaxation: float,
        free: Flags,
    ) -> None:
        self.rows = Rows.joined(rows)
        self._local = surface.compiled.local_matrix
        self._local_t = surface.compiled.local_matrix_transposed
        self._points = surface.compiled.table.point_matrix.shape[0]
        self._count = surface.topology.vertex_count
        self._lumped = self._to_control(self.rows.transposed(self.rows.metric, self._points))
        self._trace = self._lumped[:, [0, 3, 5]].sum(axis=1)
        self._mean = float(self._trace[free].mean()) / 3 if free.any() else 0.0
        self._fairness = fairness * self._mean
        self._relaxation = relaxation * self._mean
        t = surface.topology
        self._laplacian = umbrella(t.edge_vertices, t.sharpness > 0, t.vertex_count)
        self._laplacian_t = self._laplacian.T.tocsr()
        self._normals = Places(surface).normals()
        self._control = surface.control_mesh.points
        self._free = free

    def _to_control(self, values: Floats) -> Floats:
        return np.asarray(values[: self._count] + self._local_t @ values[self._count :])

    def _preconditioner(self, damping: Floats) -> Floats:
        """Inverse of the lumped 3 x 3 blocks, zero for vertices that are held."""
        blocks = self._lumped[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3)
        diagonal = damping + 1.2 * (self._fairness + self._relaxation)
        inverse = np.asarray(np.linalg.inv(blocks + diagonal[:, :, None] * np.eye(3)), np.float64)
        inverse[~self._free] = 0.0
        return inverse

    def product(self, x: Floats, damping: Floats) -> Floats:
        """The system's matrix times (n, 3)."""
        everywhere = np.concatenate([x, self._local @ x])
        out = damping * x + self._to_control(self.rows.product(everywhere))
        bent = self._laplacian @ x
        out += self._laplacian_t @ (self._fairness * bent + self._relaxation * self._along(bent))
        return np.asarray(out)

    def _along(self, vectors: Floats) -> Floats:
        """Their part in the surface's tangent planes at the vertices."""
        normal = self._normals
        return np.asarray(vectors - np.einsum("nd,nd->n", vectors, normal)[:, None] * normal)

    @cached_property
    def right_side(self) -> Floats:
        """W^T D e of all terms."""
        m, e = self.rows.metric, self.rows.residual
        vectors = np.column_stack(
            [
                m[:, 0] * e[:, 0] + m[:, 1] * e[:, 1] + m[:, 2] * e[:, 2],
                m[:, 1] * e[:, 0] + m[:, 3] * e[:, 1] + m[:, 4] * e[:, 2],
                m[:, 2] * e[:, 0] + m[:, 4] * e[:, 1] + m[:, 5] * e[:, 2],
            ]
        )
        out = self._to_control(self.rows.transposed(vectors, self._points))
        out -= self._relaxation * (self._laplacian_t @ self._along(self._laplacian @ self._control))
        return out

    def solve(self, damping: float, tolerance: float = 5e-2, iterations: int = 30) -> Floats:
        """Displacements by preconditioned conjugate gradients, to a relative residual of `tolerance`.

        `damping` is Levenberg's, against each control vertex's own weight.
        """
        damped: Floats = damping * self._trace[:, None] / 3 + 1e-9 * self._mean
        inverse = self._preconditioner(damped)
        x = np.zeros((self._count, 3))
        residual = self.right_side
        z = np.einsum("nij,nj->ni", inverse, residual)
        direction, rho = z, float(np.sum(residual * z))
        bound = tolerance**2 * rho
        for _ in range(iterations):
            if rho <= bound or rho <= 0:
                break
            image = self.product(direction, damped)
            step = rho / float(np.sum(direction * image))
            x = x + step * direction
            residual = residual - step * image
            z = np.einsum("nij,nj->ni", inverse, residual)
            rho, before = float(np.sum(residual * z)), rho
            direction = z + (rho / before) * direction
        return x


def umbrella(edges: NDArray[np.int32], sharp: NDArray[np.bool_], count: int) -> sp.csr_array:
    """Uniform Laplacian: each vertex less the mean of its neighbours, along the curve for vertices on one.

    Vertices with one or with more than two sharp edges have an empty row.
    """
    start = np.concatenate([edges[:, 0], edges[:, 1]])
    end = np.concatenate([edges[:, 1], edges[:, 0]])
    curve = np.concatenate([sharp, sharp])
    degree = np.bincount(start[curve], minlength=count)
    used = np.where(curve, degree[start] == 2, degree[start] == 0)
    start, end = start[used], end[used]
    valence = np.bincount(start, minlength=count)
    rows = np.concatenate([np.flatnonzero(valence), start])
    columns = np.concatenate([np.flatnonzero(valence), end])
    values = np.concatenate([np.ones(np.count_nonzero(valence)), -1.0 / valence[start]])
    return sp.csr_array((values, (rows, columns)), shape=(count, count))


def smoothed(mesh: ControlMesh, moving: Flags) -> Floats:
    """Control points, (n, 3), where the flagged ones have been drawn to the middle of their neighbours many times."""
    t, points = mesh.topology, mesh.points.copy()
    laplacian = umbrella(t.edge_vertices, t.sharpness > 0, t.vertex_count)
    for _ in range(SMOOTHINGS):
        points[moving] -= 0.5 * (laplacian @ points)[moving]
    return points
