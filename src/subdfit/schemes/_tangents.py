"""Limit tangents at the irregular corners of quads, from the step of subdivision round the corner."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import schur

from subdfit.schemes._corner_type import CornerType
from subdfit.schemes._irregular import limit_mask

Matrix = NDArray[np.float64]


def limit_tangents(step: Matrix, kind: CornerType, edge: NDArray[np.int64]) -> Matrix:
    """Weights of V and its ring for the two `edge_tangents` along the edges of the patch at V, (2, r)."""
    return edge_tangents(step, kind, edge)[[kind.position, (kind.position + 1) % kind.edges]]


def edge_tangents(step: Matrix, kind: CornerType, edge: NDArray[np.int64]) -> Matrix:
    """Weights of V and its ring for limit tangents along all edges of V's sector, whatever the corner's position in it.

    They span the tangent plane where there is one, keep the direction of a crease's or the boundary's curve, and at a
    regular corner equal the derivatives by u and v.

    Parameters
    ----------
    step
        (r, r) subdivision of V and its ring.
    kind
        The corner.
    edge
        Which of these points V's neighbours along edges are, counter-clockwise through the sector.

    Returns
    -------
    ndarray
        (edges, r).
    """
    if kind.pinned and not kind.closed and _sharp_edges_span(step):
        tangents = _projected(step, edge)
    elif kind.pinned or (kind.faces == 1 and not kind.closed):
        # A corner's sharp edges keep their directions; a single face's span its plane (k 4^-k beats 4^-k).
        tangents = np.eye(len(step))[edge] - np.eye(len(step))[0]
    elif kind.closed and kind.faces == 2 and not kind.dart:
        # No tangent plane: both faces fold flat along their two edges' common line, and 1/4, 1/4 and -1/4 lead.
        tangents = (np.eye(len(step))[edge] - np.eye(len(step))[edge[::-1]]) / 2
    elif kind.closed:
        tangents = _projected(step, edge)
    else:
        tangents = _beside_crease(step, edge)
    return np.asarray(tangents)


def _sharp_edges_span(step: Matrix) -> bool:
    """Whether a corner's two sharp edges, with their eigenvalues 1/2, outlive all else in the sector."""
    size = np.sort(np.abs(np.linalg.eigvals(step)))[::-1]
    return bool(size[1] < 1 / 2 + 1e-9 and (len(size) == 3 or size[3] < 1 / 2 - 1e-9))


def _projected(step: Matrix, edge: NDArray[np.int64]) -> Matrix:
    """What is left of the edges after projection onto the two subdominant eigenvectors, (edges, r)."""
    deflated = step - limit_mask(step)
    right, left = _subdominant(deflated), _subdominant(deflated.T)
    masks: Matrix = (right[edge] - right[0]) @ np.linalg.solve(left.T @ right, left.T)
    return masks


def _subdominant(matrix: Matrix) -> Matrix:
    """A real basis of the invariant subspace of the two largest eigenvalues, (r, 2)."""
    size = np.sort(np.abs(np.linalg.eigvals(matrix)))
    bound = (size[-2] + size[-3]) / 2
    basis: Matrix = schur(matrix, sort=lambda re, im: np.hypot(re, im) > bound)[1][:, :2]
    return basis


def _beside_crease(step: Matrix, edge: NDArray[np.int64]) -> Matrix:
    """Tangents at equal angles over a half-plane: cos along the curve, sin across it, (edges, r).

    Along is the cubic B-spline's mask. Across is the left eigenvector l of the largest eigenvalue that the points
    inside the sector have among themselves; its entries on the curve follow from l S = lambda l. It is scaled to be one
    on the right eigenvector whose edges are sin(pi i / k).
    """
    faces = len(edge) - 1
    curve = np.array([0, edge[0], edge[-1]])
    inner = np.setdiff1d(np.arange(len(step)), curve)
    values, vectors = np.linalg.eig(step[np.ix_(inner, inner)].T)
    best = np.argmax(values.real)
    across = np.zeros(len(step))
    across[inner] = vectors[:, best].real
    among = step[np.ix_(curve, curve)].T - values[best].real * np.eye(3)
    from_inner = -step[np.ix_(inner, curve)].T @ across[inner]
    # A tangent mask has zero sum; where lambda is an eigenvalue of the curve too, symmetry leaves the choice to it.
    system = np.vstack([among, np.ones(3)])
    across[curve] = np.linalg.lstsq(system, np.r_[from_inner, -across[inner].sum()], rcond=None)[0]
    right = np.zeros(len(step))
    values, vectors = np.linalg.eig(step[np.ix_(inner, inner)])
    right[inner] = vectors[:, np.argmax(values.real)].real
    angle = np.pi * np.arange(faces + 1) / faces
    right *= np.sin(angle[1]) / right[edge[1]]
    along = np.zeros(len(step))
    along[edge[[0, -1]]] = 1 / 2, -1 / 2
    tangents: Matrix = np.outer(np.cos(angle), along) + np.outer(np.sin(angle), across / (across @ right))
    return tangents
