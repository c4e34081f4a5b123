"""Doo-Sabin masks of a face: what its new corners are made of, inside the surface and where the face meets a curve.

Inside, two masks: Doo and Sabin's own (1978), and the one that averages a corner, the midpoints of its two edges and
the face's centroid (Cheng et al. 2009). They agree on quads.

A face with one edge on a sharp curve is half of a polygon, whose other half is its mirror image: with the original mask
over the whole polygon, the corners on the curve follow Chaikin's rule, quads give the clamped tensor product, and the
limit has a tangent plane, that of the whole polygon. A face with two edges that meet in a corner is a quarter.
"""

from enum import IntEnum
from functools import cache

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]


class Face(IntEnum):
    """How a face meets sharp curves: not at all, with one edge, with two edges at a corner."""

    WHOLE = 0
    HALF = 1
    QUARTER = 2


@cache
def original_mask(m: int) -> Matrix:
    """Doo and Sabin's mask (m, m): (m + 5) / 4m a corner itself, (3 + 2 cos(2 pi j / m)) / 4m the one j on.

    Its eigenvalues are 1, 1/2, 1/2 and 1/4.
    """
    return _circulant((3 + 2 * np.cos(2 * np.pi * np.arange(m) / m)) / (4 * m), own=(m + 5) / (4 * m))


@cache
def averaging_mask(m: int) -> Matrix:
    """The averaging mask (m, m): 1/2 + 1/4m a corner itself, 1/8 + 1/4m its neighbours, 1/4m the others.

    Its eigenvalues are 1 and 1/2 + cos(2 pi k / m) / 4.
    """
    row = np.full(m, 1 / (4 * m))
    row[[1, -1]] += 1 / 8
    return _circulant(row, own=1 / 2 + 1 / (4 * m))


def _circulant(row: Matrix, own: float) -> Matrix:
    row[0] = own
    places = np.arange(len(row))
    mask: Matrix = row[(places - places[:, None]) % len(row)]
    return mask


@cache
def mirrored_polygon(m: int) -> Matrix:
    """The polygon of 2 (m - 2) corners whose half a face A, B, y_1 .. y_r with the sharp edge AB is, from its corners.

    It runs y_1 .. y_r, then their images y_r' .. y_1', y_i + y_i' = 2 c_i. The c_i lie on AB as the projections of a
    regular polygon's corners on its axis do, scaled so that those next to B and A are B and A. These are, less their
    middle, an eigenvector of `original_mask` of eigenvalue 1/2, the factor by which Chaikin's rule shrinks AB.
    """
    r = m - 2
    cosine = np.cos(np.pi * (2 * np.arange(r) + 1) / (2 * r))
    towards_b = (1 + cosine / cosine[0]) / 2
    inner = np.eye(m)[2:]
    centre = np.zeros((r, m))
    centre[:, 0], centre[:, 1] = 1 - towards_b, towards_b
    return np.vstack([inner, (2 * centre - inner)[::-1]])


@cache
def half_mask(m: int) -> Matrix:
    """New corners (m, m) of a face A, B, y_1 .. y_r, r >= 2, with one sharp edge AB."""
    mask = np.zeros((m, m))
    mask[:2, :2] = [[3 / 4, 1 / 4], [1 / 4, 3 / 4]]
    mask[2:] = (original_mask(2 * (m - 2)) @ mirrored_polygon(m))[: m - 2]
    return mask


@cache
def quarter_mask(m: int) -> Matrix:
    """New corners (m, m) of a face V, B, y_1 .. y_r, A with sharp edges AV and VB that meet in a corner V.

    A quad gives the tensor product. In larger faces everything halves its distance from V: the surface is a cone
    there, and no corner, however wide, makes it fold.
    """
    mask = np.eye(m) / 2
    mask[:, 0] += 1 / 2
    if m == 4:
        mask[2] = 1 / 4
    return mask


QUAD_CORNER_IMAGE = np.array([4.0, -2.0, 1.0, -2.0])
"""Image of the inner corner y of a quad V, B, y, A in both its sharp edges."""
