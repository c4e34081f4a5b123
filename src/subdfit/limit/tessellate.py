"""Triangles on the limit surface: every cell cut alike, vertices shared along common sides."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.schemes.domain import QUAD, Domain


class Lattice(NamedTuple):
    """A triangulation of the parametric faces.

    Attributes
    ----------
    face, uv : (n,) int32 and (n, 2) float64, where each vertex lies.
    triangles : (t, 3) int32; the triangles of cell c are rows ``c s^2`` to ``(c + 1) s^2`` (s segments a side).
    """

    face: NDArray[np.int32]
    uv: NDArray[np.float64]
    triangles: NDArray[np.int32]


def lattice(domain: Domain, segments: int) -> Lattice:
    """Cut every cell's sides into `segments` parts; raises InputError unless that is 1 or more."""
    if segments < 1:
        raise InputError(f"a tessellation needs 1 or more segments a side, not {segments}")
    if np.any(domain.shape == QUAD):
        raise InputError("tessellating quadrilateral cells is not supported by this scheme")
    count = domain.face_count
    nodes = [(i, j) for j in range(segments + 1) for i in range(segments + 1 - j)]
    row = {node: k for k, node in enumerate(nodes)}
    uv = np.array(nodes) / segments
    rows = _weld(domain, nodes, segments)
    up = [(row[i, j], row[i + 1, j], row[i, j + 1]) for i, j in nodes if i + j < segments]
    down = [(row[i + 1, j], row[i + 1, j + 1], row[i, j + 1]) for i, j in nodes if i + j < segments - 1]
    triangles = rows[:, np.array(up + down)].reshape(-1, 3)
    used, first, inverse = np.unique(rows.ravel(), return_index=True, return_inverse=True)
    face = (first // len(nodes)).astype(np.int32)
    renumber = np.full(int(used.max(initial=-1)) + 1, -1, np.int32)
    renumber[used] = np.arange(len(used))
    assert len(inverse) == count * len(nodes)
    return Lattice(face, uv[first % len(nodes)], renumber[triangles])


def _weld(domain: Domain, nodes: list[tuple[int, int]], segments: int) -> NDArray[np.int64]:
    """Number the lattice nodes of all cells, (f, nodes): the same number where cells share a point."""
    count = domain.face_count
    corner_count = int(domain.vertex.max(initial=-1)) + 1
    side = _side_numbers(domain)
    rows = np.empty((count, len(nodes)), np.int64)
    inner_begin = corner_count + 3 * count * (segments - 1)
    inner = 0
    for k, (i, j) in enumerate(nodes):
        barycentric = (segments - i - j, i, j)
        zeros = [b for b in range(3) if barycentric[b] == 0]
        if len(zeros) == 2:
            rows[:, k] = domain.vertex[:, barycentric.index(segments)]
        elif len(zeros) == 1:
            s = (zeros[0] + 1) % 3
            along = barycentric[(s + 1) % 3]
            number, forward = side[0][:, s], side[1][:, s]
            rows[:, k] = corner_count + number * (segments - 1) + np.where(forward, along, segments - along) - 1
        else:
            rows[:, k] = inner_begin + inner * count + np.arange(count)
            inner += 1
    return rows


def _side_numbers(domain: Domain) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """A number for each cell side, shared by both cells, and whether the cell runs along it forwards."""
    count = domain.face_count
    own = 3 * np.arange(count)[:, None] + np.arange(3)
    neighbour = domain.neighbour[:, :3].astype(np.int64)
    beyond = np.where(neighbour < 0, own, 3 * neighbour + domain.neighbour_side[:, :3])
    return np.minimum(own, beyond), own <= beyond
