"""Exact evaluation of Loop patches: the matrices from a patch's points to polynomial coefficients.

A patch with one irregular corner V is subdivided towards V: three of its four children are regular, the fourth is a
patch of the same type (Stam 1998). Here the step is written once for every kind of corner, interior, crease, boundary,
dart or pinned; only V's own rule and the sharp edges of its ring differ.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from subdfit.schemes._corner_type import CornerType
from subdfit.schemes._irregular import limit_mask as fixed_mask
from subdfit.schemes._irregular import towards_corner
from subdfit.schemes.patch_table import STRIDE

Matrix = NDArray[np.float64]

OUTER = 6
"""Points of a patch beside the corner's ring: the corner itself, and five round the other two."""


def monomials() -> list[tuple[int, int]]:
    """Exponents (i, j) of u^i v^j in the order of the coefficients."""
    return [(i, j) for i in range(5) for j in range(5 - i)]


@cache
def box_spline() -> Matrix:
    """The twelve quartic box-spline polynomials (Stam 1998, appendix A) as coefficients, (16, 12).

    Columns follow a patch's points for valence six: V, its ring from a, then o, a1, a2, b1, b2.
    """
    a, b, c = (
        _polynomial({(0, 0): 1, (1, 0): -1, (0, 1): -1}),
        _polynomial({(1, 0): 1}),
        _polynomial({(0, 1): 1}),
    )
    near = [
        (6, 4, 0, 0),
        (24, 3, 0, 1),
        (24, 2, 0, 2),
        (8, 1, 0, 3),
        (1, 0, 0, 4),
        (24, 3, 1, 0),
        (60, 2, 1, 1),
    ]
    near += [
        (36, 1, 1, 2),
        (6, 0, 1, 3),
        (24, 2, 2, 0),
        (36, 1, 2, 1),
        (12, 0, 2, 2),
        (8, 1, 3, 0),
        (6, 0, 3, 1),
    ]
    near += [(1, 0, 4, 0)]
    across = [
        (1, 4, 0, 0),
        (2, 3, 0, 1),
        (6, 3, 1, 0),
        (6, 2, 1, 1),
        (12, 2, 2, 0),
        (6, 1, 2, 1),
        (6, 1, 3, 0),
    ]
    across += [(2, 0, 3, 1), (1, 0, 4, 0)]
    far = [(1, 4, 0, 0), (2, 3, 1, 0)]
    columns = [
        _terms(near, a, b, c),
        _terms(near, b, c, a),
        _terms(near, c, a, b),
        _terms(across, c, a, b),
        _terms(far, a, c, b),
        _terms(far, a, b, c),
        _terms(across, a, b, c),
        _terms(across, b, c, a),
        _terms(far, b, c, a),
        _terms(far, b, a, c),
        _terms(far, c, b, a),
        _terms(far, c, a, b),
    ]
    rows = np.zeros((STRIDE, 12))
    for row, (i, j) in enumerate(monomials()):
        rows[row] = [column[i, j] / 12 for column in columns]
    return rows


def _polynomial(terms: dict[tuple[int, int], float]) -> Matrix:
    table = np.zeros((5, 5))
    for (i, j), value in terms.items():
        table[i, j] = value
    return table


def _product(p: Matrix, q: Matrix) -> Matrix:
    out = np.zeros((5, 5))
    for i, j in zip(*np.nonzero(p), strict=True):
        out[i:, j:] += p[i, j] * q[: 5 - i, : 5 - j]
    return out


def _terms(terms: list[tuple[int, int, int, int]], a: Matrix, b: Matrix, c: Matrix) -> Matrix:
    total = np.zeros((5, 5))
    for factor, *powers in terms:
        term = _polynomial({(0, 0): factor})
        for base, power in zip((a, b, c), powers, strict=True):
            for _ in range(power):
                term = _product(term, base)
        total += term
    return total


def vertex_alpha(valence: int) -> float:
    """Weight of a smooth vertex itself in its new position (Loop 1987; Nishiyama et al. 2008, section 4)."""
    return float((3 / 8 + np.cos(2 * np.pi / valence) / 4) ** 2 + 3 / 8)


def subdivide(kind: CornerType) -> tuple[Matrix, list[Matrix]]:
    """One step towards the corner.

    Returns
    -------
    smaller : (n, n), the points of the child at V, a patch of the same type.
    regular : three (12, n), the points of the regular children beside a, beside b, and between.
    """
    ring = kind.edges
    n = ring + OUTER
    x = np.eye(n)
    v, r = x[0], x[1 : ring + 1]
    o, a1, a2, b1, b2 = x[ring + 1 :]
    i, j = kind.position, (kind.position + 1) % ring
    a, b = r[i], r[j]
    # Beyond a sharp edge stands the mirror of the face itself.
    left = v + a - b if kind.sharp(i) else r[i - 1]
    right = v + b - a if kind.sharp(j) else r[(j + 1) % ring]

    new_v = vertex_rule(kind) @ x[: ring + 1]
    edges = np.array([_ring_edge(kind, v, r, k) for k in range(ring)])
    new_a = 5 / 8 * a + (v + left + a2 + a1 + o + b) / 16
    new_b = 5 / 8 * b + (v + a + o + b1 + b2 + right) / 16
    middle = _edge(a, b, v, o)
    p1, p2, p3, p4 = _edge(a, left, v, a2), _edge(a, a2, left, a1), _edge(a, a1, a2, o), _edge(a, o, a1, b)
    q1, q2, q3, q4 = _edge(b, right, v, b2), _edge(b, b2, right, b1), _edge(b, b1, b2, o), _edge(b, o, b1, a)
    edge_a, edge_b = edges[i], edges[j]
    beside_a = new_v + edge_a - edge_b if kind.sharp(i) else edges[i - 1]
    beside_b = new_v + edge_b - edge_a if kind.sharp(j) else edges[(j + 1) % ring]

    smaller = np.array([new_v, *edges, middle, new_a, p1, new_b, q1])
    at_a = [edge_a, new_a, middle, edge_b, new_v, beside_a, p1, p4, p3, p2, q4, new_b]
    at_b = [edge_b, middle, new_b, q1, beside_b, new_v, edge_a, q4, p4, new_a, q3, q2]
    between = [middle, edge_b, edge_a, new_a, p4, q4, new_b, new_v, beside_b, q1, beside_a, p1]
    return smaller, [np.array(at_a), np.array(at_b), np.array(between)]


def vertex_rule(kind: CornerType) -> Matrix:
    """Weights of V and its ring for V's new position, (ring + 1,)."""
    rule = np.zeros(kind.edges + 1)
    if kind.pinned:
        rule[0] = 1.0
    elif kind.closed:
        rule[0] = vertex_alpha(kind.faces)
        rule[1:] = (1 - rule[0]) / kind.faces
    else:
        rule[[0, 1, -1]] = 6 / 8, 1 / 8, 1 / 8
    return rule


def _edge(start: Matrix, end: Matrix, left: Matrix, right: Matrix) -> Matrix:
    return 3 / 8 * (start + end) + (left + right) / 8


def _ring_edge(kind: CornerType, v: Matrix, r: Matrix, k: int) -> Matrix:
    rule: Matrix = (v + r[k]) / 2 if kind.sharp(k) else _edge(v, r[k], r[k - 1], r[(k + 1) % kind.edges])
    return rule


@cache
def limit_mask(kind: CornerType) -> Matrix:
    """Weights of V and its ring for V's limit point: the left eigenvector of eigenvalue one, (ring + 1,)."""
    ring = kind.edges + 1
    return fixed_mask(subdivide(kind)[0][:ring, :ring])


def tangent_masks(kind: CornerType) -> Matrix:
    """Weights of V and its ring for two limit tangents, along the edges to a and to b, (2, ring + 1).

    They span the tangent plane where there is one, keep the direction of a crease's or the boundary's curve, and at a
    regular corner equal the derivatives by u and v.
    """
    if kind.pinned and (kind.closed or kind.faces > 2):
        tangents = _edges(kind)
    elif kind.closed or kind.pinned or kind.faces == 1:
        tangents = _projected_edges(kind)
    else:
        tangents = _crease_tangents(kind.faces)
    return tangents[[kind.position, (kind.position + 1) % kind.edges]]


def _edges(kind: CornerType) -> Matrix:
    """The ring's edges themselves, r_i - V: a corner vertex stays, and its sharp edges keep their directions.

    The eigenvalues of smooth edges, 3/8 + cos(pi m / k) / 4 between sharp ones and 3/8 + cos(2 pi m / k) / 4 all round,
    reach 1/2 here: the surface is a cone or a spike, and no plane touches it (Biermann et al. 2000).
    """
    unit = np.eye(kind.edges + 1)
    edges: Matrix = unit[1:] - unit[0]
    return edges


def _crease_tangents(faces: int) -> Matrix:
    """Tangents along the edges of a crease vertex's sector of two or more faces, (faces + 1, faces + 2).

    They stand at equal angles over a half-plane, t_i = cos(pi i / k) along + sin(pi i / k) across, whose axis along is
    the curve's tangent: the cubic B-spline's (r_0 - r_k) / 2, with eigenvalue 1/2.
    """
    angle = np.pi * np.arange(faces + 1) / faces
    along = np.zeros(faces + 2)
    along[[1, -1]] = 1 / 2, -1 / 2
    tangents: Matrix = np.outer(np.cos(angle), along) + np.outer(np.sin(angle), _across_crease(faces))
    return tangents


def _across_crease(faces: int) -> Matrix:
    """Tangent mask across a crease: the left eigenvector l of lambda = 3/8 + cos(pi/k) / 4, (faces + 2,).

    Smooth edges see only each other through the matrix tridiag(1/8, 3/8, 1/8), so l_i = sin(pi i / k) inside the
    sector. The entries at V and at both ends follow from the zero sum of a tangent mask and from column r_0 of
    l S = lambda l: with l_0 = l_k,

        lambda l_0 = l_0 / 2 + (l_V + l_1) / 8,    l_V = -2 l_0 - sum l_i.

    The scale makes it one on the right eigenvector r_i = sin(pi i / k). For k = 3 it is the mask (-2; -1, 2, 2, -1) of
    Hoppe et al. 1994.
    """
    angle = np.pi / faces
    inner = np.sin(angle * np.arange(1, faces))
    end = (inner[0] - inner.sum()) / (1 + 2 * np.cos(angle))
    return np.array([-2 * end - inner.sum(), end, *inner, end]) * 2 / faces


def _projected_edges(kind: CornerType) -> Matrix:
    """What is left of the edges after projection onto two subdominant eigenvectors, (ring, ring + 1)."""
    ring = kind.edges + 1
    deflated = subdivide(kind)[0][:ring, :ring] - limit_mask(kind)
    right = _subdominant(deflated)
    left = _subdominant(deflated.T)
    masks: Matrix = (right[1:] - right[0]) @ np.linalg.solve(left.T @ right, left.T)
    return masks


def _subdominant(matrix: Matrix) -> Matrix:
    values, vectors = np.linalg.eig(matrix)
    order = np.argsort(-np.abs(values), kind="stable")[:2]
    return np.ascontiguousarray(vectors[:, order].real)


@cache
def regular_matrix() -> Matrix:
    """The regular type's matrix, point by point, (12 * STRIDE,)."""
    return np.ascontiguousarray(box_spline().T).ravel()


@cache
def irregular_matrices(kind: CornerType) -> Matrix:
    """All matrices of an irregular type, in the order that `PatchTable.matrices` documents."""
    smaller, regular = subdivide(kind)
    ring = kind.edges + 1
    mask, tangents = np.zeros(len(smaller)), np.zeros((2, len(smaller)))
    mask[:ring], tangents[:, :ring] = limit_mask(kind), tangent_masks(kind)
    slots = monomials().index((1, 0)), monomials().index((0, 1))
    return towards_corner(smaller, [box_spline() @ child for child in regular], mask, tangents, slots)
