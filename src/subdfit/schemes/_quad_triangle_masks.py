"""Masks round one vertex of the quad-triangle scheme, by the cyclic order of its faces (Stam and Loop 2003).

An order is a string such as "TTTQQ", a letter a face, counter-clockwise; a face that is no triangle is a "Q". Edge i
is where face i begins. Stam and Loop average a linearly split mesh; here their two steps are one.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from subdfit.schemes._stencils import VertexMask

Matrix = NDArray[np.float64]
Counts = NDArray[np.signedinteger]


def smooth_mask(faces: Counts, quads: Counts, correction: Matrix) -> VertexMask:
    """Return the vertex rule, each array of the arguments' shape; the edges share one weight, and so do the quads.

    After the split, the averaging weighs the vertex itself, its edge neighbours and the far corners of its quads by
    2 alpha - 1, 2 (1 - alpha) / n and 0 among triangles (Loop), by 1 - 3/n, 2/n^2 and 1/n^2 among quads
    (Catmull-Clark), and else by a, a/2 and a/4 with a = 1 / (1 + faces/2 + quads/4) (Stam and Loop 2003, section 3).
    The step that this makes is multiplied by 1 + `correction`.
    """
    n = np.asarray(faces, np.float64)
    alpha = _alpha(faces)
    weight = 1 / (1 + n / 2 + quads / 4)
    kinds = [np.equal(quads, 0), np.equal(quads, faces)]
    edge = np.select(kinds, [(1 - alpha) / n, 1 / n**2], weight / 4) * (1 + correction)
    centroid = np.select(kinds, [0 * n, 1 / n**2], weight / 4) * (1 + correction)
    return VertexMask(1 - n * edge - quads * centroid, edge, centroid)


def pure_limit_mask(faces: Counts, quads: Counts) -> VertexMask:
    """Return the limit mask of smooth vertices among quads alone (Catmull-Clark) or triangles alone (Loop).

    It holds where the neighbours are not such vertices, too. Faces have four corners at most.
    """
    n = np.asarray(faces, np.float64)
    among_quads = np.equal(quads, faces)
    beta = 3 / (11 - 8 * _alpha(faces))
    own = np.where(among_quads, (n - 1) / (n + 5), beta)
    edge = np.where(among_quads, 2 / (n * (n + 5)), (1 - beta) / n)
    return VertexMask(own, edge, np.where(among_quads, 4 / (n * (n + 5)), 0.0))


def _alpha(faces: Counts) -> Matrix:
    """Loop's weight of a vertex itself (1987)."""
    n = np.maximum(np.arange(np.max(faces, initial=0) + 1), 1)
    return np.asarray(((3 / 8 + np.cos(2 * np.pi / n) / 4) ** 2 + 3 / 8)[faces])


def ring_matrix(
    order: str, correction: float = 0.0, dart: bool = False, closed: bool = True, pinned: bool = False
) -> Matrix:
    """One step of subdivision of a vertex and its ring, (k, k).

    The points are the vertex, its neighbours by edge, then the far corners of its quads; faces have four corners at
    most. A `dart`'s sharp edge is edge 0; a sector that is not `closed` has one more edge than faces, and its first and
    last are sharp; a `pinned` vertex stays.
    """
    n, quads, edges = len(order), order.count("Q"), len(order) + (not closed)
    x = np.eye(1 + edges + quads)
    v, e = x[0], x[1 : edges + 1]
    corners = iter(x[edges + 1 :])
    centroid = {i: (v + e[i] + e[(i + 1) % edges] + next(corners)) / 4 for i in range(n) if order[i] == "Q"}
    mask = smooth_mask(np.array(n), np.array(quads), np.array(correction))
    if pinned:
        new_v = v
    elif not closed:
        new_v = (6 * v + e[0] + e[-1]) / 8
    else:
        new_v = mask.own * v + mask.edge * e.sum(axis=0) + mask.centroid * sum(centroid.values(), np.zeros(len(x)))

    def share(i: int, face: int, other: int) -> Matrix:
        """What a face beside edge i adds to its new point: 1/4 in all."""
        added: Matrix = centroid[face] / 4 if face in centroid else (v + e[i] + 2 * e[other]) / 16
        return added

    def middle(i: int) -> Matrix:
        """The new point of edge i."""
        if (dart and i == 0) or (not closed and i in (0, n)):
            return np.asarray((v + e[i]) / 2)
        return np.asarray((v + e[i]) / 4 + share(i, i, (i + 1) % edges) + share(i, (i - 1) % n, (i - 1) % n))

    return np.array([new_v, *map(middle, range(edges)), *centroid.values()])


def correction(order: str) -> float:
    """Return eta: the new place p of an inner vertex becomes p + eta (p - p_split), p_split being where it was.

    The aim is lambda_3 = lambda_1^2, which bounds the curvature (Stam and Loop 2003, section 5). It is met by all
    mixed orders of four faces and those of five but QQQTT, QQTQT and QQQQT. With three faces it is out of reach: there
    eta is as large as leaves no eigenvalue negative. From the other orders of five on, eta hardly moves lambda_3, as
    that belongs to the vertex's bending, and is 0. The regular seam, TTTQQ, needs none.
    """
    return _correction(min(order[i:] + order[:i] for i in range(len(order))))


@cache
def _correction(order: str) -> float:
    if order.count("Q") in (0, len(order)) or _excess(0.0, order) < 1e-6:
        return 0.0
    if len(order) == 3:
        return _largest_correction(order)
    largest = _largest_correction(order)
    if _excess(largest, order) >= 0:
        return 0.0
    from scipy.optimize import brentq  # takes a tenth of all that is loaded at the start, and is needed here alone

    return float(brentq(_excess, 0.0, largest, args=(order,), xtol=1e-15))


def _excess(eta: float, order: str) -> float:
    """How far lambda_3 exceeds lambda_1^2."""
    values = np.sort(np.abs(np.linalg.eigvals(ring_matrix(order, eta))))
    return float(values[-4] - values[-2] ** 2)


def _largest_correction(order: str) -> float:
    """The eta at which the matrix becomes singular.

    With S its value at eta = 0, r its first row and e the first unit vector, it is S + eta e (r - e)^T, whose
    determinant is det S (1 + eta (r - e)^T S^-1 e) = det S (1 + eta (1 - (S^-1)_00)).
    """
    step = ring_matrix(order)
    return float(1 / (np.linalg.solve(step, np.eye(len(step))[0])[0] - 1))
