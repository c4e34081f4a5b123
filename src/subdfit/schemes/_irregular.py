"""Matrices of an irregular type: the patch is subdivided towards its corner, for ever (Stam 1998)."""

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
    smaller: Matrix, polynomials: list[Matrix], mask: Matrix, tangents: Matrix, slots: tuple[int, int]
) -> Matrix:
    """All matrices of an irregular type, in the order that `PatchTable.matrices` documents.

    Parameters
    ----------
    smaller
        (n, n), one step of subdivision: the points of the child at the corner, a patch of the same type.
    polynomials
        Three (STRIDE, n), the coefficients of the regular children after one step.
    mask, tangents
        (n,) and (2, n), limit point and limit tangents at the corner.
    slots
        Which coefficients are those of u and v.
    """
    # Powers of the deflated matrix keep the digits of coefficients that shrink level by level.
    power, deflated = np.eye(len(mask)), smaller - mask
    blocks = []
    for level in range(LEVELS):
        for polynomial in polynomials:
            if level == 0:
                block = polynomial.copy()
            else:
                block = polynomial @ power
                block[0] += mask
            blocks.append(block.T.ravel())
        power = deflated @ power
    corner = np.zeros((STRIDE, len(mask)))
    corner[0] = mask
    corner[list(slots)] = tangents
    blocks.append(corner.T.ravel())
    return np.concatenate(blocks)
