"""Fair interpolation (Halstead, Kass and DeRose 1993): the surface of least thin-plate energy through the data.

After one refinement there are more control points than data, and so a choice among surfaces.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from subdfit.errors import InputError
from subdfit.interpolate.energy import thin_plate
from subdfit.limit.surface import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.schemes.domain import CORNERS
from subdfit.schemes.scheme import Refinement, Scheme

Floats = NDArray[np.float64]

_ENOUGH = 1e-8
"""Share of the gradient's norm at which the energy is least for all purposes; the data are met exactly in any case."""
_MOST_STEPS = 2000
_ROUNDING = 1e-14
"""Weights below are zeros."""
_SAME = 1e-8
"""Distance, for control points of size 1, below which two points are one."""


@dataclass(frozen=True, eq=False)
class Fair:
    """A fair surface through the data.

    Attributes
    ----------
    control_mesh : once refined; where the scheme keeps vertices, those of the given mesh come first, in its order.
    limit_rows : (n, m), limit points at the data from the control points.
    distances : (n,) of the data from these.
    before, after : thin-plate energy of the plain interpolation and of this one.
    """

    control_mesh: ControlMesh
    limit_rows: sp.csr_array
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
    reference = LimitSurface(ControlMesh(step.child, step.refined(data.points)), scheme)
    rows = old_limit_rows(reference, step, scheme.limit_rows(data.topology))
    constraint = _Constraint.of(rows)
    energy = thin_plate(reference)
    start = constraint.met(step.refined(plain), data.points)
    points = constraint.met(start + _lowering(energy, constraint, start), data.points)
    distances = np.linalg.norm(rows @ points - data.points, axis=1)
    mesh = ControlMesh(step.child, points, scheme.name)
    return Fair(mesh, rows, distances, _value(energy, start), _value(energy, points))


def old_limit_rows(surface: LimitSurface, step: Refinement, limits: sp.csr_array) -> sp.csr_array:
    """Limit points of the vertices of a mesh, (n, m), from the control points of its refinement.

    A vertex that is kept has the limit of what it became. The others lie at corners of the refined surface's cells, and
    are found there by their positions for random control points.

    Parameters
    ----------
    surface
        Any surface over the refined mesh.
    limits
        (n, n), the limit rows of the mesh itself.
    """
    if np.all(step.vertex_row >= 0):
        return sp.csr_array(surface.scheme.limit_rows(step.child)[step.vertex_row])
    random = np.random.default_rng(0).standard_normal((limits.shape[0], 3))
    domain = surface.domain
    cell, corner = np.nonzero(domain.present)
    uv = CORNERS[domain.shape[cell], corner]
    places = surface.with_points(step.refined(random)).evaluate(cell, uv).position
    found, nearest = cKDTree(places).query(limits @ random)
    distance = np.asarray(found)
    if distance.max() > _SAME:
        raise InputError(f"{surface.scheme.name}: vertex {distance.argmax()} is at no corner of a refined cell")
    rows = surface.weights(cell[nearest], uv[nearest])
    rows.data[np.abs(rows.data) < _ROUNDING] = 0.0
    rows.eliminate_zeros()
    return rows


@dataclass(frozen=True, eq=False)
class _Constraint:
    """Limit points at the data: each fixes one control point, its own, in terms of others.

    Attributes
    ----------
    pivot, weight : (n,), the control point that each datum fixes, and its weight there.
    others : (n, m), the limit rows without these entries.
    """

    pivot: NDArray[np.int64]
    weight: Floats
    others: sp.csr_array

    @classmethod
    def of(cls, rows: sp.csr_array) -> "_Constraint":
        """Choose for each row the largest entry in a column that no other row uses."""
        entries = rows.tocoo()
        alone = np.bincount(entries.col, entries.data != 0, rows.shape[1])[entries.col] == 1
        order = np.lexsort((entries.data, alone, entries.row))
        last = order[np.flatnonzero(np.diff(entries.row[order], append=rows.shape[0]))]
        if len(last) < rows.shape[0] or not alone[last].all():
            raise InputError("some vertices share all their control points with others; leave the fair surface out")
        pivot = entries.col[last].astype(np.int64)
        free = np.ones(rows.shape[1])
        free[pivot] = 0.0
        return cls(pivot, entries.data[last], sp.csr_array(rows @ sp.diags_array(free)))

    def met(self, points: Floats, data: Floats) -> Floats:
        """Points with the fixed ones where they make the limit points the data."""
        out = points.copy()
        out[self.pivot] = (data - self.others @ points) / self.weight[:, None]
        return out

    def spread(self, change: Floats) -> Floats:
        """A change of free control points, and that of the fixed ones which keeps the limit points."""
        return self.met(change, np.zeros((len(self.pivot), 3)))

    def gathered(self, forces: Floats) -> Floats:
        """Forces on the free control points (0 on the others) from those on all: the transpose of `spread`."""
        out = forces - self.others.T @ (forces[self.pivot] / self.weight[:, None])
        out[self.pivot] = 0.0
        return np.asarray(out)


def _lowering(energy: sp.csr_array, constraint: _Constraint, start: Floats) -> Floats:
    """The change that makes the energy least while the limit points stay: conjugate gradients on the free points."""
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
    """Diagonal of the energy as a form of the free points, but for what couples several fixed ones, (m,)."""
    diagonal = energy.diagonal()
    slope = sp.csr_array(sp.diags_array(-1 / constraint.weight) @ constraint.others)
    mixed = energy[constraint.pivot].multiply(slope).sum(axis=0)
    pulled = sp.csr_array(slope.multiply(slope)).T @ diagonal[constraint.pivot]
    found = diagonal + 2 * mixed + pulled
    largest = found.max()
    return np.maximum(found, 1e-3 * largest) if largest > 0 else np.ones_like(found)


def _value(energy: sp.csr_array, points: Floats) -> float:
    """The energy, 0 where its terms cancel but for rounding, as those of flat faces between creases."""
    value, terms = float(np.vdot(points, energy @ points)), float(np.vdot(abs(points), abs(energy) @ abs(points)))
    return value if value > _ROUNDING * terms else 0.0
