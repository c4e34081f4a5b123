"""The squared distance to a curve or a surface, to second order (Pottmann and Leopoldseder 2003)."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def tangential_weights(distance: Floats, radius: Floats, *, signed: bool = False) -> Floats:
    """Weights of squared tangential displacements in the second-order model of the squared distance.

    At signed distance d from a curve or surface whose centre of curvature lies at signed distance rho on the same
    axis, the true coefficient is ``d / (d - rho)``. Equation 1 of Lavoué et al. 2007 has ``d / (d + rho)``, which holds
    for the opposite sign of rho only.

    Parameters
    ----------
    distance : d; its sign counts only if `signed`.
    radius : rho; infinite where flat.
    signed
        Take ``max(0, d / (d - rho))``, which is exact where it is positive; else ``|d| / (|d| + |rho|)``, which is
        exact where point and centre lie on opposite sides and never exceeds one.

    Returns
    -------
    Weights from 0 (flat, or on the surface) to 1 (a centre of curvature on the surface: a corner); a signed weight may
    be larger between the surface and the centre, where it is held to 1.
    """
    d, rho = np.broadcast_arrays(np.asarray(distance, np.float64), np.asarray(radius, np.float64))
    if not signed:
        d, rho = np.abs(d), -np.abs(rho)
    corner = (rho == 0) & np.isfinite(d)
    below = np.where(corner | (d == rho) | np.isinf(rho), 1.0, d - rho)
    weight = np.where(np.isinf(rho), 0.0, d / below)
    weight = np.where(corner | ((d == rho) & (d != 0)), 1.0, weight)
    return np.clip(weight, 0.0, 1.0)
