"""Samples of a limit surface, from which the reverse side is measured: all cells alike, but large ones more finely."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subdfit.limit.surface import LimitSurface
from subdfit.limit.tessellate import Lattice, cut, grid_nodes, lattice
from subdfit.parallel import map_chunks
from subdfit.schemes.domain import QUAD, TRIANGLE, Domain

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Rows = NDArray[np.int64]

SAMPLES, MOST_SAMPLES, MANY_SAMPLES = 16, 64, 200_000
"""Samples of the surface a control vertex, at least; as many as the second where that does not make more in all than
the third."""

SPACING, MOST_SEGMENTS, MOST_IN_ALL = 0.01, 64, 1_000_000
"""Cells in which these lie farther apart, as a share of the diagonal, have as many times the segments, up to so many,
and about so many samples in all: between few data large cells bulge, and the bulge must not fall between the samples.
"""

CHUNK = 65536
"""Triangles whose sides are measured at one go: more would take memory for nothing."""

STEPS = np.array([1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64])
"""The factors that are used: cells that are cut alike are sampled together."""


class Block(NamedTuple):
    """Cells of one shape that are cut alike.

    Attributes
    ----------
    cells, first : (c,) int64, and the first of each cell's rows of triangles, which are in the order of `cut`.
    shape, segments : of each cell, and parts of each of its sides.
    """

    cells: Rows
    first: Rows
    shape: int
    segments: int

    def nodes(self, triangles: NDArray[np.int32]) -> NDArray[np.int32]:
        """The vertices at each cell's `grid_nodes`, (c, k), those on its sides, which other cells share, as well."""
        cuts = cut(self.shape, self.segments)
        corners = triangles[self.first[:, None] + np.arange(len(cuts))].reshape(len(self.cells), cuts.size)
        _, once = np.unique(cuts, return_index=True)
        return np.asarray(corners[:, once])


class SurfaceSamples(NamedTuple):
    """Samples of a surface, joined to triangles cell by cell.

    Attributes
    ----------
    face, uv, position : (n,) int32, (n, 2) and (n, 3).
    triangles : (t, 3) int32.
    blocks : all cells with samples, by how they are cut.
    """

    face: NDArray[np.int32]
    uv: Floats
    position: Floats
    triangles: NDArray[np.int32]
    blocks: tuple[Block, ...]


def surface_samples(surface: LimitSurface, some: Flags | None = None, segments: int = 0) -> SurfaceSamples:
    """Sample the cells of a surface in the normalised frame, or the flagged ones (c,).

    Parameters
    ----------
    surface
        The limit surface.
    some
        Cells to sample; None takes all. What samples a cell has depends on it and `segments` alone, up
        to `MOST_IN_ALL`.
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
        return SurfaceSamples(grid.face, grid.uv, position, grid.triangles, _blocks(domain, segments, wanted, grid))
    small = wanted & (times == 1)
    grid = lattice(domain, segments, small)
    cuts = [_Cut(grid.face, grid.uv, grid.triangles, _blocks(domain, segments, small, grid))]
    for factor in np.unique(times[times > 1]):
        for shape in (TRIANGLE, QUAD):
            cells = np.flatnonzero(wanted & (times == factor) & (domain.shape == shape))
            cuts.append(_cut_apart(cells, shape, int(segments * factor)))
    face, uv, triangles, blocks = _joined(cuts)
    return SurfaceSamples(face, uv, surface.evaluate(face, uv).position, triangles, blocks)


class _Cut(NamedTuple):
    face: NDArray[np.int32]
    uv: Floats
    triangles: NDArray[np.int32]
    blocks: tuple[Block, ...]


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

    def longest_sides(start: int, stop: int) -> Floats:
        a, b, c = (position[corner] for corner in grid.triangles[start:stop].T)
        return np.asarray(np.max([np.einsum("td,td->t", side, side) for side in (b - a, c - b, a - c)], axis=0))

    squares = np.concatenate([np.empty(0), *map_chunks(longest_sides, len(grid.triangles), CHUNK)])
    sampled = np.flatnonzero(np.diff(grid.begin))
    longest = np.zeros(len(grid.begin) - 1)
    longest[sampled] = np.sqrt(np.maximum.reduceat(squares, grid.begin[sampled])) if len(sampled) else 0.0
    most = max(MOST_SEGMENTS // segments, 1)
    times = np.clip(np.ceil(longest / SPACING), 1, most)
    excess = np.sum((times * segments) ** 2) / MOST_IN_ALL
    if excess > 1:
        times = np.clip(np.ceil(times / np.sqrt(excess)), 1, most)
    return np.asarray(STEPS[np.searchsorted(STEPS, times)])


def _blocks(domain: Domain, segments: int, wanted: Flags, grid: Lattice) -> tuple[Block, ...]:
    """The cells of a lattice, by their shape."""
    cells = [np.flatnonzero(wanted & (domain.shape == shape)) for shape in (TRIANGLE, QUAD)]
    return tuple(
        Block(some, grid.begin[some], shape, segments) for some, shape in zip(cells, (TRIANGLE, QUAD), strict=True)
    )


def _cut_apart(cells: Rows, shape: int, segments: int) -> _Cut:
    """Cells cut like those of a `lattice`, but each with vertices of its own."""
    nodes, cuts = grid_nodes(shape, segments), cut(shape, segments)
    each = np.arange(len(cells))
    rows = each[:, None, None] * len(nodes) + cuts
    face, uv = np.repeat(cells, len(nodes)).astype(np.int32), np.tile(nodes / segments, (len(cells), 1))
    return _Cut(face, uv, rows.reshape(-1, 3).astype(np.int32), (Block(cells, each * len(cuts), shape, segments),))


def _joined(cuts: list[_Cut]) -> _Cut:
    vertices = np.cumsum([0] + [len(part.face) for part in cuts[:-1]], dtype=np.int32)
    rows = np.cumsum([0] + [len(part.triangles) for part in cuts[:-1]])
    return _Cut(
        np.concatenate([part.face for part in cuts]),
        np.concatenate([part.uv for part in cuts]),
        np.concatenate([part.triangles + begin for part, begin in zip(cuts, vertices, strict=True)]),
        tuple(
            block._replace(first=block.first + begin)
            for part, begin in zip(cuts, rows, strict=True)
            for block in part.blocks
        ),
    )
