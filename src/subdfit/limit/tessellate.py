"""Triangles on the limit surface: every cell cut alike, vertices shared along common sides."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from subdfit.errors import InputError
from subdfit.schemes.domain import QUAD, TRIANGLE, Domain

Nodes = NDArray[np.int64]

REMEMBERED = 64
"""Lattices of a cell that are remembered: surfaces are sampled again and again by the same few."""


class Lattice(NamedTuple):
    """A triangulation of the parametric faces.

    Attributes
    ----------
    face, uv : (n,) int32 and (n, 2) float64, where each vertex lies.
    triangles : (t, 3) int32; those of cell c are rows ``begin[c]`` to ``begin[c + 1]``, in the order of `cut`.
    begin : (f + 1,) int64.
    """

    face: NDArray[np.int32]
    uv: NDArray[np.float64]
    triangles: NDArray[np.int32]
    begin: NDArray[np.int64]


class _Nodes(NamedTuple):
    """The nodes of cells' lattices, cell by cell.

    Attributes
    ----------
    face, uv : (k,) int64 and (k, 2) float64, where each lies.
    number : (k,) int64, the same where cells share a point.
    triangles, begin : as of a `Lattice`, in rows of the nodes.
    """

    face: Nodes
    uv: NDArray[np.float64]
    number: Nodes
    triangles: Nodes
    begin: Nodes


def lattice(domain: Domain, segments: int, some: NDArray[np.bool_] | None = None) -> Lattice:
    """Cut the sides of all cells, or of the flagged ones (f,), into `segments` parts.

    Raises InputError unless that is 1 or more.
    """
    wanted = np.ones(domain.face_count, np.bool_) if some is None else some
    nodes = _nodes(domain, segments, wanted)
    return _welded(nodes, nodes.number)


def lattice_apart(domain: Domain, segments: int) -> Lattice:
    """The lattice of all cells with a vertex for each side of a crease.

    Cells have a vertex in common where smooth sides lead from one to the other. Raises InputError as `lattice` does.
    """
    nodes = _nodes(domain, segments, np.ones(domain.face_count, np.bool_))
    links = _smooth_links(domain, nodes, segments)
    graph = sp.coo_array((np.ones(len(links), np.int8), links.T), shape=(len(nodes.face),) * 2)
    return _welded(nodes, connected_components(graph, directed=False)[1])


def _nodes(domain: Domain, segments: int, wanted: NDArray[np.bool_]) -> _Nodes:
    """The nodes of the flagged cells' lattices, triangles' before quads'."""
    if segments < 1:
        raise InputError(f"a tessellation needs 1 or more segments a side, not {segments}")
    begin = _begin(domain, segments, wanted)
    triangles = np.empty((begin[-1], 3), np.int64)
    face, uv = np.empty(0, np.int64), np.empty((0, 2))
    numbers = np.empty(0, np.int64)
    inner = int(domain.points.max(initial=-1)) + 1 + 4 * domain.face_count * (segments - 1)
    for shape in (TRIANGLE, QUAD):
        cells = np.flatnonzero(wanted & (domain.shape == shape))
        nodes, cuts = grid_nodes(shape, segments), cut(shape, segments)
        rows = len(face) + np.arange(len(cells) * len(nodes)).reshape(len(cells), len(nodes))
        place = begin[cells][:, None] + np.arange(len(cuts))
        triangles[place.ravel()] = rows[:, cuts].reshape(-1, 3)
        numbers = np.concatenate([numbers, _weld(domain, cells, nodes, segments, inner).ravel()])
        inner += len(cells) * len(nodes)
        face = np.concatenate([face, np.repeat(cells, len(nodes))])
        uv = np.concatenate([uv, np.tile(nodes / segments, (len(cells), 1))])
    return _Nodes(face, uv, numbers, triangles, begin)


def _begin(domain: Domain, segments: int, wanted: NDArray[np.bool_]) -> Nodes:
    """The first row of each flagged cell's triangles in a lattice, and the number of all, (f + 1,)."""
    return np.concatenate([[0], np.cumsum(np.where(domain.shape == QUAD, 2, 1) * segments**2 * wanted)])


def _welded(nodes: _Nodes, number: NDArray[np.integer]) -> Lattice:
    """One vertex for all nodes of a number, (k,), where the first of them lies."""
    first = np.full(int(number.max(initial=-1)) + 1, -1, np.int64)
    first[number[::-1]] = np.arange(len(number))[::-1]
    used = first >= 0
    renumber = np.cumsum(used, dtype=np.int32) - np.int32(1)
    triangles = renumber[number[nodes.triangles]]
    return Lattice(nodes.face[first[used]].astype(np.int32), nodes.uv[first[used]], triangles, nodes.begin)


def _smooth_links(domain: Domain, nodes: _Nodes, segments: int) -> Nodes:
    """Pairs of nodes, (p, 2), that are one point seen from both sides of a side that is not sharp."""
    across = (domain.neighbour >= 0) & ~domain.sharp
    at = np.round(nodes.uv * segments).astype(np.int64)
    numbers = int(nodes.number.max(initial=0)) + 1
    key = nodes.face * numbers + nodes.number
    order = np.argsort(key, kind="stable")
    found = [np.empty((0, 2), np.int64)]
    for shape in (TRIANGLE, QUAD):
        for side, flags in enumerate(_on_sides(shape, at, segments)):
            own = np.flatnonzero(flags & (domain.shape[nodes.face] == shape) & across[nodes.face, side])
            beyond = domain.neighbour[nodes.face[own], side].astype(np.int64)
            wanted = beyond * numbers + nodes.number[own]
            found.append(np.column_stack([own, order[np.searchsorted(key, wanted, sorter=order)]]))
    return np.concatenate(found)


def _on_sides(shape: int, at: Nodes, segments: int) -> list[NDArray[np.bool_]]:
    """Which nodes (i, j), (k, 2), lie on each side of a cell."""
    i, j = at.T
    if shape == QUAD:
        return [j == 0, i == segments, j == segments, i == 0]
    return [j == 0, i + j == segments, i == 0]


def manifold_triangles(domain: Domain, segments: int, grid: Lattice) -> NDArray[np.int32]:
    """The triangles of a lattice, so that they are a manifold round inner vertices of two cells, too.

    Where two quads share two sides in sequence, both may cut off the same triangle at the vertex between these. One
    of them is then cut through the vertex instead.
    """
    triangles = grid.triangles.copy()
    cells, corner = np.nonzero(_shares_two_sides(domain))
    upper = np.where(corner == 0, 0, segments**2 - 1)
    for rows in np.unique(grid.begin[cells] + upper):
        other = rows + segments**2
        (a, b, d), c = triangles[rows], triangles[other, 1]
        triangles[rows], triangles[other] = (a, b, c), (a, c, d)
    return triangles


def triangles_at(
    domain: Domain, segments: int, face: NDArray[np.integer], uv: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Rows of the triangles of a lattice of all cells in which places lie, (k,); on a common side, one of the two."""
    begin = _begin(domain, segments, np.ones(domain.face_count, np.bool_))
    found = np.empty(len(face), np.int64)
    for shape in (TRIANGLE, QUAD):
        some = np.flatnonzero(domain.shape[face] == shape)
        at = uv[some] * segments
        i = np.minimum(at[:, 0].astype(np.int64), segments - 1)
        j = np.minimum(at[:, 1].astype(np.int64), segments - 1 - (i if shape == TRIANGLE else 0))
        lower, upper = _halves(shape, segments)
        beyond = (at.sum(axis=1) > i + j + 1) & (upper[i, j] >= 0)
        found[some] = begin[face[some]] + np.where(beyond, upper[i, j], lower[i, j])
    return found


def _halves(shape: int, segments: int) -> Nodes:
    """Rows of `cut` of the lower and the upper half of each square (i, j), (2, segments, segments); -1 for none."""
    corners = grid_nodes(shape, segments)[cut(shape, segments)]
    i, j = corners.min(axis=1).T
    upper = (corners.sum(axis=(1, 2)) > 3 * (i + j) + 2).astype(np.int64)
    rows = np.full((2, segments, segments), -1)
    rows[upper, i, j] = np.arange(len(corners))
    return rows


def _shares_two_sides(domain: Domain) -> NDArray[np.bool_]:
    """Corners 0 and 2 of quads, (f, 4), where one other cell, a later one, cuts off the same triangle."""
    before = np.roll(domain.neighbour, 1, axis=1), np.roll(domain.neighbour_side, 1, axis=1)
    last = (domain.neighbour_side + 1) % QUAD
    found = (domain.neighbour == before[0]) & (last == before[1]) & (last % 2 == 0)
    found &= domain.neighbour > np.arange(domain.face_count)[:, None]
    found[:, 1::2] = False
    found[domain.shape != QUAD] = False
    return np.asarray(found)


@lru_cache(REMEMBERED)
def grid_nodes(shape: int, segments: int) -> Nodes:
    """The nodes (i, j) of a cell's lattice, (k, 2), at parameters i / segments and j / segments."""
    j, i = np.mgrid[: segments + 1, : segments + 1].reshape(2, -1)
    nodes = np.column_stack([i, j])[(shape == QUAD) | (i + j <= segments)]
    nodes.setflags(write=False)
    return nodes


@lru_cache(REMEMBERED)
def cut(shape: int, segments: int) -> NDArray[np.int64]:
    """Triangles of a cell's lattice as rows of its nodes, (t, 3).

    The lower left halves of all squares come first, row by row, then the upper right ones.
    """
    nodes = grid_nodes(shape, segments)
    row = np.full((segments + 2, segments + 2), -1)
    row[nodes[:, 0], nodes[:, 1]] = np.arange(len(nodes))
    here, right, above, beyond = (row[nodes[:, 0] + i, nodes[:, 1] + j] for i, j in ((0, 0), (1, 0), (0, 1), (1, 1)))
    lower, upper = (right >= 0) & (above >= 0), beyond >= 0
    up = np.column_stack([here, right, above])[lower]
    triangles = np.concatenate([up, np.column_stack([right, beyond, above])[upper]])
    triangles.setflags(write=False)
    return triangles


def _weld(domain: Domain, cells: NDArray[np.int64], nodes: Nodes, segments: int, inner: int) -> NDArray[np.int64]:
    """Number the lattice nodes of `cells`, all of one shape: the same number where cells share a point.

    Numbers from `inner` on are free for the nodes inside cells.
    """
    sides_begin = int(domain.points.max(initial=-1)) + 1
    number, forward = _side_numbers(domain)
    shape = int(domain.shape[cells[0]]) if len(cells) else TRIANGLE
    rows = np.empty((len(cells), len(nodes)), np.int64)
    for k, (i, j) in enumerate(nodes.tolist()):
        corner, side, along = _place(shape, (i, j), segments)
        if corner >= 0:
            rows[:, k] = domain.points[cells, corner]
        elif side >= 0:
            step = np.where(forward[cells, side], along, segments - along) - 1
            rows[:, k] = sides_begin + number[cells, side] * (segments - 1) + step
        else:
            rows[:, k] = inner + k * len(cells) + np.arange(len(cells))
    return rows


def _place(shape: int, node: tuple[int, int], segments: int) -> tuple[int, int, int]:
    """The corner on which a node lies, or the side and how far along it; -1 for none."""
    i, j = node
    if shape == QUAD:
        ends = [(0, 0), (segments, 0), (segments, segments), (0, segments)]
        sides = [(j == 0, i), (i == segments, j), (j == segments, segments - i), (i == 0, segments - j)]
    else:
        ends = [(0, 0), (segments, 0), (0, segments)]
        sides = [(j == 0, i), (i + j == segments, j), (i == 0, segments - j)]
    if node in ends:
        return ends.index(node), -1, 0
    for side, (on, along) in enumerate(sides):
        if on:
            return -1, side, along
    return -1, -1, 0


def _side_numbers(domain: Domain) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """A number for each cell side, shared by both cells, and whether the cell runs along it forwards, (f, 4)."""
    own = 4 * np.arange(domain.face_count)[:, None] + np.arange(4)
    neighbour = domain.neighbour.astype(np.int64)
    beyond = np.where(neighbour < 0, own, 4 * neighbour + domain.neighbour_side)
    return np.minimum(own, beyond), own <= beyond
