"""Samples of a limit surface, from which the reverse side is measured, and the peaks between them.

All cells are sampled alike, but large ones more finely. From the farthest sample of a cell a search goes on to where
the surface is farthest off: near extraordinary vertices and creases it may bulge in a small part of a cell.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subdfit.limit.surface import LimitSurface
from subdfit.limit.tessellate import Lattice, cut, grid_nodes, lattice
from subdfit.schemes.domain import QUAD, TRIANGLE, Domain

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Rows = NDArray[np.int64]
Grid = tuple[NDArray[np.int32], Floats, NDArray[np.int32]]

SAMPLES, MOST_SAMPLES, MANY_SAMPLES = 16, 64, 200_000
"""Samples of the surface a control vertex, at least; as many as the second where that does not make more in all than
the third."""

SPACING, MOST_SEGMENTS, MOST_IN_ALL = 0.01, 64, 1_000_000
"""Cells in which these lie farther apart, as a share of the diagonal, have as many times the segments, up to so many,
and about so many samples in all: between few data large cells bulge, and the bulge must not fall between the samples.
"""

STEPS = np.array([1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64])
"""The factors that are used: cells that are cut alike are sampled together."""

ROUNDS = 6
"""So often a search for a peak halves its step, which is at first that from sample to sample."""
AROUND = np.array([(i, j) for i in (-1.0, 0.0, 1.0) for j in (-1.0, 0.0, 1.0) if i or j])


class SurfaceSamples(NamedTuple):
    """Samples of a surface, joined to triangles cell by cell.

    Attributes
    ----------
    face, uv, position : (n,) int32, (n, 2) and (n, 3).
    triangles : (t, 3) int32.
    """

    face: NDArray[np.int32]
    uv: Floats
    position: Floats
    triangles: NDArray[np.int32]


def surface_samples(surface: LimitSurface, some: Flags | None = None, segments: int = 0) -> SurfaceSamples:
    """Sample the cells of a surface in the normalised frame, or the flagged ones (c,).

    Parameters
    ----------
    surface
        The limit surface.
    some
        Cells to sample; None takes all. What samples a cell has depends on it alone, and on `segments`.
    segments
        Segments a cell's side where cells are small; 0 takes `reverse_segments`.
    """
    domain = surface.domain
    segments = segments or reverse_segments(domain)
    wanted = np.ones(domain.face_count, np.bool_) if some is None else some
    grid = lattice(domain, segments, wanted)
    position = surface.evaluate(grid.face, grid.uv).position
    times = _times(position, grid, segments)
    if times.max(initial=1) == 1:
        return SurfaceSamples(grid.face, grid.uv, position, grid.triangles)
    factors = np.unique(times[times > 1])
    large = [_cut_apart(domain, segments * n, np.flatnonzero(wanted & (times == n))) for n in factors]
    face, uv, triangles = _joined([lattice(domain, segments, wanted & (times == 1))[:3], *large])
    return SurfaceSamples(face, uv, surface.evaluate(face, uv).position, triangles)


def peaks(
    surface: LimitSurface,
    face: NDArray[np.int32],
    uv: Floats,
    gap: Floats,
    gap_at: Callable[[Floats, Rows], Floats],
    least: float,
    segments: int = 0,
) -> tuple[NDArray[np.int32], Floats]:
    """Where the cells of some samples are farthest off the target, as a search from the farthest sample of each finds.

    Parameters
    ----------
    surface
        The limit surface.
    face, uv, gap
        Samples, (n,), (n, 2), and how far off they are, (n,).
    gap_at
        How far off positions are, (k, 3) and the rows of the samples from which they came to (k,).
    least
        How far off a peak must be to matter: where none so far can be expected the search ends.
    segments
        The samples' segments a cell's side where cells are small; 0 takes `reverse_segments`.

    Returns
    -------
    Cells and parameters, (c,) and (c, 2), in the order of the cells.
    """
    order = np.lexsort((-gap, face))
    rows = order[np.flatnonzero(np.diff(face[order], prepend=-1))]
    face, uv, gap = face[rows], uv[rows], gap[rows]
    going, step = np.arange(len(face)), 1.0 / (segments or reverse_segments(surface.domain))
    for _ in range(ROUNDS):
        if len(going) == 0:
            break
        step /= 2
        around = np.repeat(face[going], len(AROUND))
        tried = _inside(surface.domain, around, (uv[going, None] + step * AROUND).reshape(-1, 2))
        gaps = gap_at(surface.evaluate(around, tried).position, np.repeat(rows[going], len(AROUND)))
        gaps = gaps.reshape(-1, len(AROUND))
        best, each = gaps.argmax(axis=1), np.arange(len(going))
        better = gaps[each, best] > gap[going]
        uv[going[better]] = tried.reshape(-1, len(AROUND), 2)[each, best][better]
        lowest = np.minimum(gaps.min(axis=1), gap[going])
        gap[going] = np.maximum(gaps[each, best], gap[going])
        # Of a quadratic function the highest of a grid lacks half of what it exceeds a neighbour by at most.
        going = going[gap[going] + (gap[going] - lowest) / 2 >= least]
    return face, uv


def _inside(domain: Domain, face: NDArray[np.int32], uv: Floats) -> Floats:
    """Parameters drawn back into their cells."""
    uv = np.clip(uv, 0.0, 1.0)
    beyond = np.where(domain.shape[face] == TRIANGLE, np.maximum(uv.sum(axis=1), 1.0), 1.0)
    return np.asarray(uv / beyond[:, None])


def reverse_segments(domain: Domain) -> int:
    """Segments a cell side for samples of the surface: more where cells are few.

    A mesh has about half as many vertices as triangles, and as many as quads.
    """
    quads = float(np.where(domain.shape == QUAD, 1.0, 0.5).sum())
    vertices = quads / 4 if domain.parts else quads
    wanted = min(max(MANY_SAMPLES, SAMPLES * vertices), MOST_SAMPLES * vertices)
    return max(int(np.sqrt(wanted / max(quads, 1.0))), 1)


def _times(position: Floats, grid: Lattice, segments: int) -> NDArray[np.int64]:
    """How many times the segments each cell, (c,), needs for samples that lie near enough."""
    a, b, c = (position[grid.triangles[:, k]] for k in range(3))
    squares = np.max([np.einsum("td,td->t", side, side) for side in (b - a, c - b, a - c)], axis=0)
    sampled = np.flatnonzero(np.diff(grid.begin))
    longest = np.zeros(len(grid.begin) - 1)
    longest[sampled] = np.sqrt(np.maximum.reduceat(squares, grid.begin[sampled])) if len(sampled) else 0.0
    most = max(MOST_SEGMENTS // segments, 1)
    times = np.clip(np.ceil(longest / SPACING), 1, most)
    excess = np.sum((times * segments) ** 2) / MOST_IN_ALL
    if excess > 1:
        times = np.clip(np.ceil(times / np.sqrt(excess)), 1, most)
    return np.asarray(STEPS[np.searchsorted(STEPS, times)])


def _cut_apart(domain: Domain, segments: int, cells: NDArray[np.int64]) -> Grid:
    """Cells cut like those of a `lattice`, but each with vertices of its own."""
    grids: list[Grid] = []
    for shape in (TRIANGLE, QUAD):
        some = cells[domain.shape[cells] == shape]
        nodes, cuts = np.array(grid_nodes(shape, segments)), cut(shape, segments)
        rows = np.arange(len(some))[:, None, None] * len(nodes) + cuts
        face = np.repeat(some, len(nodes)).astype(np.int32)
        grids.append((face, np.tile(nodes / segments, (len(some), 1)), rows.reshape(-1, 3).astype(np.int32)))
    return _joined(grids)


def _joined(grids: list[Grid]) -> Grid:
    begin = np.cumsum([0] + [len(face) for face, _, _ in grids[:-1]], dtype=np.int32)
    triangles = [triangles + first for (_, _, triangles), first in zip(grids, begin, strict=True)]
    face, uv = (np.concatenate([grid[k] for grid in grids]) for k in (0, 1))
    return face, uv, np.concatenate(triangles)
