"""Thin-plate energy of a limit surface as a quadratic form of its control points.

The energy is taken over a reference surface S of the same connectivity: for X over S, the integral of the squared
second covariant derivatives of X by the metric of S. It does not depend on the parameters. In these, second derivatives
would grow without bound towards extraordinary vertices of high valence, and faces of all sizes would count alike.
"""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from subdfit.limit.surface import LimitSurface
from subdfit.schemes.domain import QUAD, TRIANGLE

Floats = NDArray[np.float64]

_CELLS = 8192
"""Cells that are integrated at a time."""
_COLLAPSED = 1e-12
"""Squared sine of the angle between the parameter directions below which a point of the reference has no metric."""

_GAUSS, _GAUSS_SHARES = np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)]) / 2 + 0.5, np.array([5.0, 8.0, 5.0]) / 18
_NEAR_SIDES, _NEAR_CORNERS = 0.445948490915965, 0.091576213509771
_RULES = {
    TRIANGLE: (
        np.array(
            [[1 - 2 * a, a] for a in (_NEAR_SIDES, _NEAR_CORNERS)]
            + [[a, 1 - 2 * a] for a in (_NEAR_SIDES, _NEAR_CORNERS)]
            + [[a, a] for a in (_NEAR_SIDES, _NEAR_CORNERS)]
        ),
        np.tile([0.223381589678011, 0.109951743655322], 3) / 2,
    ),
    QUAD: (
        np.stack(np.meshgrid(_GAUSS, _GAUSS), axis=-1).reshape(-1, 2),
        np.outer(_GAUSS_SHARES, _GAUSS_SHARES).ravel(),
    ),
}
"""Points and weights of quadrature for cells of each shape, exact to degree 4 (Dunavant 1985) and 5: squares of second
derivatives of quartics have degree 4. Rules of lower degree miss most of the energy near extraordinary vertices."""


def thin_plate(reference: LimitSurface) -> sp.csr_array:
    """Return the symmetric (n, n) matrix K: the energy of control points X is the trace of X^T K X."""
    n = reference.topology.vertex_count
    total = sp.csr_array((n, n))
    for shape, (uv, weights) in _RULES.items():
        cells = np.flatnonzero(reference.domain.shape == shape).astype(np.int32)
        for start in range(0, len(cells), _CELLS):
            part = cells[start : start + _CELLS]
            places = np.tile(uv, (len(part), 1))
            rows = _hessian_rows(reference, np.repeat(part, len(uv)), places, np.tile(weights, len(part)))
            total = total + rows.T @ rows
    return sp.csr_array(total)


def _hessian_rows(reference: LimitSurface, cell: NDArray[np.int32], uv: Floats, weight: Floats) -> sp.csr_array:
    """Rows, three a point, whose squares sum to the integrand times its share of the area.

    They are the components 11, 12 (times the root of 2) and 22 of the second covariant derivative in an orthonormal
    frame.
    """
    _, first, second = reference.evaluate(cell, uv, 2)
    assert first is not None
    assert second is not None
    coefficients = _frame_components(first, second, weight)
    offsets, columns, _ = reference.patch_weights(cell, uv)
    length = np.diff(offsets)
    values = np.zeros((3, len(columns)))
    for derivative in range(1, 6):
        part = reference.patch_weights(cell, uv, derivative)[2]
        values += np.repeat(coefficients[:, derivative - 1], length, axis=1) * part
    matrix = reference.compiled.table.point_matrix
    shape = (len(cell), matrix.shape[0])
    return sp.csr_array(sp.vstack([sp.csr_array((row, columns, offsets), shape=shape) @ matrix for row in values]))


def _frame_components(first: Floats, second: Floats, weight: Floats) -> Floats:
    """Coefficients (3, 5, k) of the derivatives u, v, uu, uv, vv in the three components of `_hessian_rows`."""
    u, v = first[:, 0], first[:, 1]
    E, F, G = (np.einsum("kd,kd->k", a, b) for a, b in ((u, u), (u, v), (v, v)))
    square = E * G - F * F
    fine = square > _COLLAPSED * E * G
    E, F, G, square = (np.where(fine, x, y) for x, y in ((E, 1.0), (F, 0.0), (G, 1.0), (square, 1.0)))
    # Christoffel symbols (2, 3, k): the part of uu, uv and vv along u and v.
    by_u, by_v = (np.einsum("kcd,kd->ck", second, a) for a in (u, v))
    symbols = np.stack([(G * by_u - F * by_v) / square, (E * by_v - F * by_u) / square])
    # The frame e = u / a, f = (v - (F / E) u) / c, with a = |u| and c = the height of v over u.
    a, c, shear = np.sqrt(E), np.sqrt(square / E), F / E
    one, none = np.ones_like(a), np.zeros_like(a)
    bends = np.stack(
        [
            np.stack([one, none, none]) / a**2,
            np.sqrt(2) * np.stack([-shear, one, none]) / (a * c),
            np.stack([shear**2, -2 * shear, one]) / c**2,
        ]
    )
    slopes = -np.einsum("ick,jck->ijk", bends, symbols)
    scale = np.where(fine, np.sqrt(weight * np.sqrt(square)), 0.0)
    return np.asarray(np.concatenate([slopes, bends], axis=1) * scale)
