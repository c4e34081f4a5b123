"""Matrices of irregular types: patches are subdivided towards their corners, for ever (Stam 1998)."""

import numpy as np
from numpy.typing import NDArray

from subdfit.schemes.patch_table import LEVELS, STRIDE

Matrix = NDArray[np.float64]


def limit_mask(step: Matrix) -> Matrix:
    """Left eigenvector of eigenvalue one of a step towards a corner (n, n), its sum one."""
    system = np.vstack([step.T - np.eye(len(step)), np.ones(len(step))])
    mask: Matrix = np.linalg.lstsq(system, np.r_[np.zeros(len(step)), 1.0], rcond=None)[0]
    return mask


def towards_corner(
    smaller: Matrix,
    polynomials: Matrix | list[Matrix],
    mask: Matrix,
    tangents: Matrix,
    slots: tuple[int, int],
    place: Matrix | None = None,
) -> Matrix:
    """All matrices of irregular types of one size, in the order that `PatchTable.matrices` documents.

    Parameters
    ----------
    smaller
        (..., n, n), one step of subdivision: the points of the child at the corner, a patch of the same type.
    polynomials
        (..., 3, STRIDE, n), the coefficients of the regular children after one step.
    mask, tangents
        (..., n) and (..., 2, n), limit point and limit tangents at the corner.
    slots
        Which coefficients are those of u and v.
    place
        Where to write the result; None makes a new array.

    Returns
    -------
    ndarray
        (..., numbers of a type).
    """
    # Everything is transposed, as matrices are stored point by point.
    children = np.swapaxes(np.asarray(polynomials), -1, -2)
    shape = (*mask.shape[:-1], 3 * LEVELS + 1, mask.shape[-1], STRIDE)
    out = np.empty(shape) if place is None else place.reshape(shape)
    out[..., :3, :, :] = children
    # Powers of the deflated matrix keep the digits of coefficients that shrink level by level.
    deflated = np.ascontiguousarray(np.swapaxes(smaller - mask[..., None, :], -1, -2))
    power = deflated
    for level in range(1, LEVELS):
        block = out[..., 3 * level : 3 * level + 3, :, :]
        np.matmul(power[..., None, :, :], children, out=block)
        block[..., 0] += mask[..., None, :]
        power = power @ deflated
    out[..., -1, :, :] = 0.0
    out[..., -1, :, 0] = mask
    out[..., -1, :, list(slots)] = np.moveaxis(tangents, -2, 0)
    return out.reshape(*mask.shape[:-1], -1)
