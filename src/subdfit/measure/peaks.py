"""Peaks between samples of a surface: near extraordinary vertices and creases it bulges in a small part of a cell."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subdfit.limit.surface import LimitSurface
from subdfit.limit.tessellate import grid_nodes
from subdfit.measure.samples import Block, SurfaceSamples
from subdfit.parallel import map_chunks
from subdfit.schemes.domain import TRIANGLE, Domain

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

PEAK = 0.25
"""Searches begin from samples that are as far off as this share of what matters."""
ROUNDS, PATIENCE = 24, 6
"""Most rounds of a search, and how often it halves its step, which is at first that from sample to sample."""


def _circle(directions: int) -> Floats:
    angle = 2 * np.pi * np.arange(directions) / directions
    return np.column_stack([np.cos(angle), np.sin(angle)])


COARSE, FIRST, NEXT = 3, _circle(8), _circle(32) * np.where(np.arange(32) % 2, 2, 1)[:, None]
"""So many rounds, which most searches do not survive, look round in steps of the first kind, others in steps of the
second. The distance from the target has ridges, where two of its triangles are equally near: in fewer directions the
way along one would be missed."""


AT_ONCE = 2048
"""So many searches go on side by side: more would take memory for nothing."""


class Peaks(NamedTuple):
    """Where searches end, those as well that were given up.

    Attributes
    ----------
    face, uv : (k,) int32 and (k, 2).
    gap : (k,), how far off the surface is there.
    row : (k,) int64, the samples at which they began.
    """

    face: NDArray[np.int32]
    uv: Floats
    gap: Floats
    row: Rows


def peaks(
    surface: LimitSurface,
    samples: SurfaceSamples,
    gap: Floats,
    gap_at: Callable[[Floats, Rows], Floats],
    least: float,
) -> Peaks:
    """Where a surface is farthest off the target, as searches from the highest samples of each cell find.

    Parameters
    ----------
    surface
        The limit surface.
    samples, gap
        Its samples, and how far off each of them is, (n,).
    gap_at
        How far off positions are, (k, 3) and the rows of the samples from which they came to (k,).
    least
        How far off a peak must be to matter: where none so far can be expected the search ends.
    """
    found = [_highest(block, block.nodes(samples.triangles), gap, PEAK * least) for block in samples.blocks]
    face, uv, row, step = (np.concatenate(parts) for parts in zip(*found, strict=True))

    def searched(begin: int, end: int) -> Peaks:
        some = slice(begin, end)
        starts = Peaks(face[some], uv[some], gap[row[some]], row[some])
        return _searched(surface, starts, step[some], gap_at, least)

    ends = map_chunks(searched, len(face), AT_ONCE) or [Peaks(face, uv, gap[row], row)]
    return Peaks(*(np.concatenate(parts) for parts in zip(*ends, strict=True)))


def _searched(
    surface: LimitSurface, starts: Peaks, first: Floats, gap_at: Callable[[Floats, Rows], Floats], least: float
) -> Peaks:
    """Where searches from some starts end; their `first` steps, (k,), are halved where they lead no higher."""
    face, uv, gap, row = starts
    step, going = first.copy(), np.arange(len(face))
    for past in range(ROUNDS):
        if len(going) == 0:
            break
        if past == COARSE:
            step[going] = first[going] / 2
        around = FIRST if past < COARSE else NEXT
        cells = np.repeat(face[going], len(around))
        tried = _inside(surface.domain, cells, (uv[going, None] + step[going, None, None] * around).reshape(-1, 2))
        gaps = gap_at(surface.evaluate(cells, tried).position, np.repeat(row[going], len(around)))
        gaps = gaps.reshape(-1, len(around))
        best, each = gaps.argmax(axis=1), np.arange(len(going))
        better = gaps[each, best] > gap[going]
        uv[going[better]] = tried.reshape(-1, len(around), 2)[each, best][better]
        lowest = np.minimum(gaps.min(axis=1), gap[going])
        gap[going] = np.maximum(gaps[each, best], gap[going])
        step[going[~better]] /= 2
        # A quadratic function rises above the highest of a grid by half of what that exceeds its neighbours by at most,
        # one with ridges by more.
        hopeful = gap[going] + (gap[going] - lowest) >= least
        going = going[hopeful & (step[going] > first[going] / 2**PATIENCE)]
    return Peaks(face, uv, gap, row)


def _highest(
    block: Block, nodes: NDArray[np.int32], gap: Floats, least: float
) -> tuple[NDArray[np.int32], Floats, Rows, Floats]:
    """The samples of each cell than which none beside them in it is higher, where that is at least so high.

    Of equal ones beside each other the first.

    Returns
    -------
    Their cells, parameters and rows, and how far parameters are apart there.
    """
    some = np.flatnonzero(np.max(gap[nodes], axis=1, initial=-np.inf) >= least)
    n, (i, j) = block.segments, grid_nodes(block.shape, block.segments).T
    grid = np.full((len(some), n + 3, n + 3), -np.inf)
    grid[:, j + 1, i + 1] = gap[nodes[some]]
    here = grid[:, 1:-1, 1:-1]
    highest = here >= least
    for down in range(3):
        for right in range(3):
            beside = grid[:, down : down + n + 1, right : right + n + 1]
            highest &= here > beside if (down, right) < (1, 1) else here >= beside
    cell, node = np.nonzero(highest[:, j, i])
    uv = np.column_stack([i[node], j[node]]) / n
    face, row = block.cells[some[cell]].astype(np.int32), nodes[some[cell], node].astype(np.int64)
    return face, uv, row, np.full(len(face), 1 / n)


def _inside(domain: Domain, face: NDArray[np.int32], uv: Floats) -> Floats:
    """Parameters drawn back into their cells."""
    uv = np.clip(uv, 0.0, 1.0)
    beyond = np.where(domain.shape[face] == TRIANGLE, np.maximum(uv.sum(axis=1), 1.0), 1.0)
    return np.asarray(uv / beyond[:, None])
