"""A milled plate: bores, bosses, pockets, a chamfer and a fillet, and to which of its faces each triangle belongs.

Seen from above it is a plan of regions, each with a height; walls stand wherever heights differ.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay

Floats = NDArray[np.float64]

LENGTH, WIDTH, THICKNESS = 6.0, 4.0, 1.0
BORES = ((1.0, 0.6), (5.2, 0.6), (1.0, 3.4), (5.2, 3.4))
BOSSES = ((2.1, 1.1), (2.1, 2.9))
RING, BLIND = (4.3, 2.0), (3.1, 3.2)
POCKET = (2.6, 1.6, 3.4, 2.4)
EDGE = 0.4
"""Width of the chamfer, which is as high, and radius of the fillet."""
FACES = 26
"""Bottom, top and four sides; chamfer and fillet; four bores; a wall and an end of two bosses and a blind bore; a wall,
an end and a bore of the ring; four walls and a floor of the pocket."""


class Milled(NamedTuple):
    """Points, triangles, and the face of each triangle."""

    points: Floats
    triangles: NDArray[np.int64]
    faces: NDArray[np.int64]


def milled_plate(step: tuple[float, float] = (0.1, 0.1), inside: bool = True) -> Milled:
    """The plate, 6 by 4 by 1.

    Parameters
    ----------
    step : spacing of the points along x and along y.
    inside : whether faces have points inside; without, they are fans of slivers as CAD systems write them.
    """
    plan = _plan(step, inside)
    cells = Delaunay(plan, qhull_options="QJ Pp").simplices.astype(np.int64)
    double = np.linalg.det(plan[cells[:, 1:]] - plan[cells[:, :1]])
    cells[double < 0] = cells[double < 0][:, ::-1]
    cells = cells[np.abs(double) > 1e-7]
    region = _region(plan[cells].mean(axis=1))
    return _raised(plan, cells[region >= 0], region[region >= 0], min(step))


def _plan(step: tuple[float, float], inside: bool) -> Floats:
    """Points of the plan (k, 2): circles, and a grid or what of it bounds regions."""
    across = np.linspace(EDGE, LENGTH - EDGE, round((LENGTH - 2 * EDGE) / step[0]) + 1)
    bend = EDGE * (1 - np.cos(np.linspace(0, np.pi / 2, 8)))[:-1]
    ramp = np.linspace(LENGTH - EDGE, LENGTH, max(2, round(EDGE / step[0]) + 1))[1:]
    y = np.linspace(0, WIDTH, round(WIDTH / step[1]) + 1)
    grid = np.stack(np.meshgrid(np.concatenate([bend, across, ramp]), y, indexing="ij"), -1).reshape(-1, 2)
    angle = 2 * np.pi * np.arange(40) / 40
    circle = np.stack([np.cos(angle), np.sin(angle)], 1)
    rings = [np.array(middle) + radius * circle for middle, radius in _circles()]
    off = [np.abs(np.linalg.norm(grid - middle, axis=1) - radius) for middle, radius in _circles()]
    grid = grid[np.min(off, axis=0) > 0.6 * min(*step, 0.1)]
    if not inside:
        u, v = grid.T
        outer = (u <= EDGE + 1e-9) | (u >= LENGTH - EDGE - 1e-9) | (v == 0) | (v == WIDTH)
        a, b, c, d = POCKET
        within = (u > a - 1e-9) & (u < c + 1e-9) & (v > b - 1e-9) & (v < d + 1e-9)
        grid = grid[outer | within & (np.min(np.abs([u - a, u - c, v - b, v - d]), axis=0) < 1e-9)]
    return np.concatenate([grid, *rings])


def _circles() -> Iterator[tuple[tuple[float, float], float]]:
    yield from ((middle, 0.3) for middle in (*BORES, BLIND, RING))
    yield from ((middle, 0.35) for middle in BOSSES)
    yield RING, 0.6


def _region(at: Floats) -> NDArray[np.int64]:
    """Regions of the plan, 0 for the top and -1 where there is nothing."""
    found = np.zeros(len(at), np.int64)
    found[at[:, 0] < EDGE] = 1
    found[at[:, 0] > LENGTH - EDGE] = 2
    a, b, c, d = POCKET
    found[(at[:, 0] > a) & (at[:, 1] > b) & (at[:, 0] < c) & (at[:, 1] < d)] = 3
    round_about = [(BLIND, 0.3, 4), (BOSSES[0], 0.35, 5), (BOSSES[1], 0.35, 6), (RING, 0.6, 7), (RING, 0.3, -1)]
    for middle, radius, region in (*round_about, *((bore, 0.3, -1) for bore in BORES)):
        found[np.linalg.norm(at - middle, axis=1) < radius] = region
    return found


def _height(plan: Floats, region: int) -> Floats:
    """Height of the surface of a region over points of the plan."""
    if region == 1:
        short = EDGE - np.minimum(plan[:, 0], EDGE)
        return np.asarray(THICKNESS - EDGE + np.sqrt(np.maximum(EDGE**2 - short**2, 0)))
    if region == 2:
        return np.asarray(THICKNESS - np.maximum(plan[:, 0] - LENGTH + EDGE, 0))
    return np.full(len(plan), {0: THICKNESS, 3: 0.5, 4: 0.5, 5: 1.6, 6: 1.6, 7: 1.4}[region])


def _raised(plan: Floats, cells: NDArray[np.int64], region: NDArray[np.int64], rise: float) -> Milled:
    """The solid over the cells of a plan, with walls whose rows are so high."""
    number: dict[tuple[int, float], int] = {}

    def vertex(v: int, z: float) -> int:
        return number.setdefault((v, round(z, 9)), len(number))

    heights = {k: _height(plan, k) for k in range(8)}
    triangles, names = [], list[tuple[object, ...]]()
    beside: dict[tuple[int, int], int] = {}
    for cell, k in zip(cells.tolist(), region.tolist(), strict=True):
        triangles += [[vertex(v, heights[k][v]) for v in cell], [vertex(v, 0.0) for v in cell[::-1]]]
        names += [("top", k), ("bottom",)]
        beside |= dict.fromkeys(zip(cell, cell[1:] + cell[:1], strict=True), k)
    for (a, b), k in beside.items():
        other = beside.get((b, a), -1)
        low = heights[other] if other >= 0 else np.zeros(len(plan))
        # Each wall once, from the higher of its two sides.
        if low[a] + low[b] >= heights[k][a] + heights[k][b] - 1e-9:
            continue
        columns = ([vertex(v, z) for z in _levels(float(low[v]), float(heights[k][v]), rise)] for v in (a, b))
        wall = _strip(*columns)
        triangles += wall
        names += [_wall(plan[[a, b]].mean(axis=0), k, other)] * len(wall)
    points = np.array([[*plan[v], z] for v, z in number])
    order = {name: k for k, name in enumerate(dict.fromkeys(names))}
    return Milled(points, np.array(triangles, np.int64), np.array([order[name] for name in names]))


def _levels(low: float, high: float, rise: float) -> list[float]:
    between = rise * np.arange(round(2 / rise))
    return [low, *between[(between > low + 0.3 * rise) & (between < high - 0.3 * rise)].tolist(), high]


def _strip(left: list[int], right: list[int]) -> list[list[int]]:
    """Triangles between two columns of vertices, from the bottom up, seen from outside."""
    found, i, j = list[list[int]](), 0, 0
    while i + j < len(left) + len(right) - 2:
        if j == len(right) - 1 or (i < len(left) - 1 and i * len(right) <= j * len(left)):
            found.append([left[i], right[j], left[i + 1]])
            i += 1
        else:
            found.append([left[i], right[j], right[j + 1]])
            j += 1
    return [face for face in found if len(set(face)) == 3]


def _wall(at: Floats, high: int, low: int) -> tuple[object, ...]:
    """The face to which a wall over some place of the plan belongs."""
    outline = [at[0] < 1e-6, at[0] > LENGTH - 1e-6, at[1] < 1e-6, at[1] > WIDTH - 1e-6]
    if any(outline):
        return "side", outline.index(True)
    if low == 3:
        return "pocket", int(np.argmin(np.abs(np.subtract(POCKET, [*at, *at]))))
    bore = min(BORES, key=lambda middle: float(np.linalg.norm(at - middle)))
    return ("bore", bore) if low < 0 and high == 0 else ("round", high, low)
