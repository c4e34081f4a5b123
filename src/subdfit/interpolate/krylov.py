"""Krylov solvers for B x = data: conjugate gradients where a diagonal makes B symmetric, BiCGStab where none does.

B is block triangular: corners stay where they are, curves depend on their own vertices, smooth vertices on all. So the
rows of curves are solved first, by elimination. After that the error vanishes on curves, and so does every direction of
the iteration: it concerns the smooth vertices alone, though no submatrix is made.
"""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl
from numpy.typing import NDArray

from subdfit.interpolate import _kernels as kernels
from subdfit.interpolate.operator import CHUNK, LimitOperator
from subdfit.interpolate.progressive import Step
from subdfit.parallel import map_chunks

Floats = NDArray[np.float64]


def krylov(B: LimitOperator, data: Floats, x: Floats) -> Iterator[Step]:
    """From x: the curves solved, then conjugate gradients, or BiCGStab, on the smooth vertices.

    The errors given are those of the recurrence; in the end rounding lets the true ones stay behind.
    """
    curves = np.flatnonzero(B.on_curves)
    residual = data - B.times(x)
    x = x.copy()
    if len(curves):
        yield x, _longest(residual)
        x[curves] = solve_curves(B, curves, data)
        residual = data - B.times(x)
        residual[curves] = 0.0
    if B.weights is None:
        yield from bicgstab(B.times, x, residual)
    else:
        yield from conjugate_gradients(B, B.weights, x, residual)


def solve_curves(B: LimitOperator, rows: NDArray[np.int64], data: Floats) -> Floats:
    """Control points on curves, (k, 3): tridiagonal and cyclic systems, factorised without fill."""
    if not len(rows):
        return np.empty((0, 3))
    return np.asarray(spl.splu(sp.csc_array(B.matrix[rows][:, rows])).solve(data[rows]))


def conjugate_gradients(B: LimitOperator, weight: Floats, x: Floats, residual: Floats) -> Iterator[Step]:
    """Iterate in the inner product u^T D v, in which B is symmetric: the residual is the error of the limit points.

    All three coordinates share their factors, as one system of three equal blocks. `x` and `residual` are overwritten.
    """
    direction, image = residual.copy(), np.empty_like(residual)
    rho = float(weight @ np.einsum("nd,nd->n", residual, residual))
    yield x, _longest(residual)
    while rho > 0:
        step = rho / B.energy(weight, direction, image)
        parts = map_chunks(partial(kernels.advance, step, direction, image, weight, x, residual), B.size, CHUNK)
        last, rho = rho, float(sum(part[0] for part in parts))
        yield x, float(np.sqrt(max(part[1] for part in parts)))
        map_chunks(partial(kernels.turn, rho / last, residual, direction), B.size, CHUNK)


def bicgstab(times: Callable[[Floats], Floats], x: Floats, residual: Floats) -> Iterator[Step]:
    """Iterate without symmetry (van der Vorst 1992), all three coordinates as one system; ends at a breakdown."""
    yield x, _longest(residual)
    shadow = direction = residual
    rho = float(np.vdot(shadow, residual))
    while rho != 0:
        image = times(direction)
        across = float(np.vdot(shadow, image))
        if across == 0:
            return
        step = rho / across
        half = residual - step * image
        turned = times(half)
        length = float(np.vdot(turned, turned))
        smooth = float(np.vdot(turned, half)) / length if length > 0 else 0.0
        x = x + step * direction + smooth * half
        residual = half - smooth * turned
        yield x, _longest(residual)
        last, rho = rho, float(np.vdot(shadow, residual))
        if smooth == 0:
            return
        direction = residual + (rho / last) * (step / smooth) * (direction - smooth * image)


def _longest(vectors: Floats) -> float:
    """Length of the longest row."""
    return float(np.sqrt(np.einsum("nd,nd->n", vectors, vectors).max()))
