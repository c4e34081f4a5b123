"""Merging of regions over their adjacency graph, the least different pair first.

The graph and its greedy reduction are those of Lavoué, Dupont and Baskurt 2005. How much two regions differ is here an
angle: the difference of their curvatures times the width of the thinner one, by which that one turns away from where
the other would go on. It does not depend on the part's size, and is small for the thin steps that classes make of a
gradual change as well as for wide regions that are nearly alike.
"""

import heapq
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.target.segmentation_facets import Facets, Labels

Floats = NDArray[np.float64]


@dataclass
class _Border:
    """What two regions share: its length, and the sum of length times difference of curvature along it."""

    length: float
    jump: float


class Adjacency:
    """Regions, their sizes and curvatures, and the borders between them; regions are merged in place.

    Parameters
    ----------
    facets : the mesh.
    labels : (m,) int, 0 to r - 1.
    curvatures : (m, 2) float64, principal curvatures of the triangles.
    over_sharp : whether regions that meet at sharp edges only are neighbours too.
    """

    def __init__(self, facets: Facets, labels: Labels, curvatures: Floats, over_sharp: bool = False) -> None:
        count = int(labels.max()) + 1
        self.owner = np.arange(count)
        # Plain numbers, since a mesh of many regions is compared a million times, one pair at a time.
        self.area: list[float] = np.bincount(labels, facets.areas, count).tolist()
        self.bend = np.stack([np.bincount(labels, facets.areas * k, count) for k in curvatures.T], axis=1).tolist()
        border = facets.borders(labels)
        perimeter = np.zeros(count)
        for side in range(2):
            rim = (border | (facets.edges.valence == 1)) & (facets.edges.faces[:, side] >= 0)
            perimeter += np.bincount(labels[facets.edges.faces[rim, side]], facets.lengths[rim], count)
        self.perimeter: list[float] = perimeter.tolist()
        self.borders: list[dict[int, _Border]] = [{} for _ in range(count)]
        shared = np.flatnonzero(border if over_sharp else border & ~facets.sharp)
        beside = facets.edges.faces[shared]
        jumps = facets.lengths[shared] * np.linalg.norm(curvatures[beside[:, 0]] - curvatures[beside[:, 1]], axis=1)
        pairs, place = np.unique(np.sort(labels[beside], axis=1), axis=0, return_inverse=True)
        length = np.bincount(place.ravel(), facets.lengths[shared], len(pairs))
        jump = np.bincount(place.ravel(), jumps, len(pairs))
        for (a, b), share, total in zip(pairs.tolist(), length.tolist(), jump.tolist(), strict=True):
            self.borders[a][b] = self.borders[b][a] = _Border(share, total)

    def thickness(self, region: int) -> float:
        """Width of the strip that has the region's area and perimeter."""
        return 2.0 * self.area[region] / max(self.perimeter[region], 1e-300)

    def area_if_open(self, region: int) -> float:
        """Area of a region that meets others along most of its rim; infinite where sharp edges part it from them."""
        shared = sum(border.length for border in self.borders[region].values())
        return self.area[region] if 2 * shared > self.perimeter[region] else np.inf

    def turn_of_means(self, a: int, b: int) -> float:
        """Degrees by which the mean curvatures of two regions let the thinner one turn away from the other."""
        least, most = (x / self.area[a] - y / self.area[b] for x, y in zip(self.bend[a], self.bend[b], strict=True))
        return self._turn(a, b, math.sqrt(least * least + most * most))

    def turn_at_border(self, a: int, b: int) -> float:
        """The same from the curvatures on both sides of the border only."""
        border = self.borders[a][b]
        return self._turn(a, b, border.jump / max(border.length, 1e-300))

    def _turn(self, a: int, b: int, difference: float) -> float:
        return math.degrees(difference * min(self.thickness(a), self.thickness(b)))

    def merge(self, kept: int, gone: int) -> None:
        """Let one region take in another."""
        self.owner[self.owner == gone] = kept
        self.area[kept] += self.area[gone]
        self.bend[kept] = [x + y for x, y in zip(self.bend[kept], self.bend[gone], strict=True)]
        self.perimeter[kept] += self.perimeter[gone] - 2 * self.borders[kept][gone].length
        for other, border in self.borders[gone].items():
            del self.borders[other][gone]
            if other == kept:
                continue
            known = self.borders[kept].setdefault(other, _Border(0.0, 0.0))
            self.borders[other][kept] = known
            known.length += border.length
            known.jump += border.jump
        self.borders[gone] = {}


Difference = Callable[[Adjacency, int, int], float]
Size = Callable[[Adjacency, int], float]


def merge_regions(facets: Facets, labels: Labels, curvatures: Floats, difference: Difference, least: float) -> Labels:
    """Merge neighbours that differ by less than an angle, the least different first; nothing merges over sharp edges.

    Parameters
    ----------
    facets, labels, curvatures : as in `Adjacency`.
    difference : `Adjacency.turn_of_means` or `Adjacency.turn_at_border`.
    least : degrees by which regions that stay apart differ at least.
    """
    graph = Adjacency(facets, labels, curvatures)
    queue = [(difference(graph, a, b), a, b) for a, borders in enumerate(graph.borders) for b in borders if a < b]
    heapq.heapify(queue)
    while queue:
        score, a, b = heapq.heappop(queue)
        if score >= least:
            break
        if b not in graph.borders[a] or difference(graph, a, b) != score:
            continue
        graph.merge(a, b)
        for other in sorted(graph.borders[a]):
            low, high = min(a, other), max(a, other)
            heapq.heappush(queue, (difference(graph, low, high), low, high))
    return renumbered(graph.owner[labels])


def absorb(facets: Facets, labels: Labels, size: Size, least: float, *, over_sharp: bool = False) -> Labels:
    """Merge remnants into the neighbour with which they share most, the smallest first.

    Parameters
    ----------
    facets, labels, over_sharp : as in `Adjacency`.
    size : `Adjacency.thickness` or `Adjacency.area_if_open`.
    least : the size below which a region is a remnant.
    """
    labels = renumbered(labels)
    graph = Adjacency(facets, labels, np.zeros((len(labels), 2)), over_sharp)
    queue = [(size(graph, region), region) for region in range(len(graph.area))]
    heapq.heapify(queue)
    while queue:
        known, region = heapq.heappop(queue)
        if known >= least:
            break
        if graph.owner[region] != region or known != size(graph, region) or not graph.borders[region]:
            continue
        into = max(graph.borders[region], key=lambda b: (graph.borders[region][b].length, -b))
        graph.merge(into, region)
        heapq.heappush(queue, (size(graph, into), into))
    return renumbered(graph.owner[labels])


def renumbered(labels: Labels) -> Labels:
    """Labels from 0, in the order in which they first occur."""
    _, first, place = np.unique(labels, return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[place.ravel()]
