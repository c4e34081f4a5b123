"""Fair interpolation (Halstead, Kass and DeRose 1993): the surface of least thin-plate energy through the data.

After one refinement there are more control points than data, and so a choice among surfaces.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.interpolate.energy import thin_plate
from subdfit.limit.surface import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.schemes.scheme import Scheme

Floats = NDArray[np.float64]

_ENOUGH = 1e-8
"""Share of the gradient's norm at which the energy is least for all purposes; the data are met exactly in any case."""
_MOST_STEPS = 2000


@dataclass(frozen=True, eq=False)
class Fair:
    """A fair surface through the data.

    Attributes
    ----------
    control_mesh : once refined; the first vertices are those of the given mesh, in its order.
    distances : (n,) of the data from the limit points of those.
    before, after : thin-plate energy of the plain interpolation and of this one.
    """

    control_mesh: ControlMesh
    distances: Floats
    before: float
    after: float


def fair_interpolation(scheme: Scheme, data: ControlMesh, plain: Floats) -> Fair:
    """Minimise the energy over the limit surface of the data's own mesh, which is smooth and near.

    Parameters
    ----------
    data
        The mesh whose vertices are to be met, in normalised coordinates.
    plain
        (n, 3), control points that interpolate them, or nearly.
    """
    step = scheme.refine(data.topology)
    n = data.topology.vertex_count
    if not np.array_equal(step.vertex_row, np.arange(n)):
        raise InputError(f"{scheme.name}: refining does not keep vertices, as fair interpolation needs; leave it out")
    constraint = _Constraint.of(sp.csr_array(scheme.limit_rows(step.child)[:n]), n)
    reference = LimitSurface(ControlMesh(step.child, step.matrix @ data.points), scheme)
    energy = thin_plate(reference)
    start = constraint.met(step.matrix @ plain, data.points)
    points = constraint.met(start + _lowering(energy, constraint, start), data.points)
    mesh = ControlMesh(step.child, points, scheme.name)
    distances = np.linalg.norm(constraint.rows @ points - data.points, axis=1)
    return Fair(mesh, distances, _value(energy, start), _value(energy, points))


@dataclass(frozen=True, eq=False)
class _Constraint:
    """Limit points of old vertices after refinement: each depends on its own control point and on new ones only.

    Attributes
    ----------
    rows : (n, m) limit rows; own : (n,) weights of the old vertices, others : (n, m - n) of the new ones.
    """

    rows: sp.csr_array
    own: Floats
    others: sp.csr_array

    @classmethod
    def of(cls, rows: sp.csr_array, n: int) -> "_Constraint":
        return cls(rows, rows.diagonal(), sp.csr_array(rows[:, n:]))

    def met(self, points: Floats, data: Floats) -> Floats:
        """Points with the old vertices moved so that the limit points are the data."""
        n = len(self.own)
        old = (data - self.others @ points[n:]) / self.own[:, None]
        return np.concatenate([old, points[n:]])

    def spread(self, free: Floats) -> Floats:
        """A change of the new vertices, and the change of the old ones that keeps the limit points."""
        return np.concatenate([-(self.others @ free) / self.own[:, None], free])

    def gathered(self, forces: Floats) -> Floats:
        """The transpose of `spread`."""
        n = len(self.own)
        return np.asarray(forces[n:] - self.others.T @ (forces[:n] / self.own[:, None]))


def _lowering(energy: sp.csr_array, constraint: _Constraint, start: Floats) -> Floats:
    """The change that makes the energy least while the limit points stay: conjugate gradients on the new vertices."""
    inverse = 1 / _diagonal(energy, constraint)[:, None]
    residual = -constraint.gathered(energy @ start)
    change = np.zeros_like(residual)
    direction = inverse * residual
    rho = float(np.vdot(residual, direction))
    bound = _ENOUGH**2 * rho
    for _ in range(_MOST_STEPS):
        if rho <= bound or rho <= 0:
            break
        image = constraint.gathered(energy @ constraint.spread(direction))
        length = rho / float(np.vdot(direction, image))
        change += length * direction
        residual -= length * image
        scaled = inverse * residual
        rho, last = float(np.vdot(residual, scaled)), rho
        direction = scaled + (rho / last) * direction
    return constraint.spread(change)


def _diagonal(energy: sp.csr_array, constraint: _Constraint) -> Floats:
    """Diagonal of the energy as a form of the new vertices, but for what couples several old ones, (m - n,)."""
    n = len(constraint.own)
    diagonal = energy.diagonal()
    slope = sp.csr_array(sp.diags_array(-1 / constraint.own) @ constraint.others)
    mixed = energy[:n, n:].multiply(slope).sum(axis=0)
    pulled = sp.csr_array(slope.multiply(slope)).T @ diagonal[:n]
    found = diagonal[n:] + 2 * mixed + pulled
    largest = found.max()
    return np.maximum(found, 1e-3 * largest) if largest > 0 else np.ones_like(found)


def _value(energy: sp.csr_array, points: Floats) -> float:
    return float(np.vdot(points, energy @ points))
