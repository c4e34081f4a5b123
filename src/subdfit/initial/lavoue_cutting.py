"""Recursive cutting of the topologic contour into faces (Lavoué et al. 2007, Figure 7)."""

from collections.abc import Set
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from subdfit.initial.lavoue_contour import Contour
from subdfit.initial.lavoue_convex import convex_parts, is_convex
from subdfit.initial.lavoue_facing import Facing
from subdfit.initial.lavoue_scores import DIGITS

Floats = NDArray[np.float64]
Ring = list[int]

_THIN = 0.15
"""Height of what a chord cuts off, as a share of the chord, from which it is more than a sliver along a curve."""
_LOST = 0.1
"""Share of the area over the surface that all chords together may cost for the sake of their scores."""
_LOOKED_AT = 24
"""Chords of a contour, the best by Dijkstra's paths, whose geodesics are looked at."""


@dataclass
class Cutting:
    """A contour on its way to faces; rings list places of the contour, counter-clockwise.

    Attributes
    ----------
    contour : the contour.
    points, limits : (k, 3) float64, the control points at its places and their limits.
    most_corners : of a face.
    taken : pairs of control points that no chord may join any more.
    stuck : rings that no chord cuts and that are no faces.
    """

    contour: Contour
    points: Floats
    limits: Floats
    most_corners: int = 4
    taken: Set[frozenset[int]] = frozenset()
    stuck: list[Ring] = field(default_factory=list)
    _rough: dict[tuple[int, int], tuple[float, float]] = field(default_factory=dict)
    _fine: dict[tuple[int, int], tuple[float, float]] = field(default_factory=dict)
    _edges: set[frozenset[int]] = field(default_factory=set)
    _facing: Facing | None = None
    _spare: float = 0.0

    def faces(self) -> list[Ring]:
        """Cut until every ring is a face: a triangle, a convex quad, or a plane ring cut into convex parts.

        Rings for which there is no chord are left in `stuck`.
        """
        controls = self.contour.controls
        count = len(controls)
        self._edges = {frozenset((int(controls[k - 1]), int(controls[k]))) for k in range(count)} | self.taken
        self._score_all()
        done: list[Ring] = []
        waiting: list[Ring] = [list(range(count))]
        while waiting:
            ring = waiting.pop()
            if self._is_face(ring):
                done.append(ring)
                continue
            chord = self._best_chord(ring)
            if chord is None:
                self.stuck.append(ring)
                continue
            i, j = chord
            self._edges.add(frozenset((int(controls[ring[i]]), int(controls[ring[j]]))))
            waiting += [ring[i : j + 1], ring[j:] + ring[: i + 1]]
        return convex_parts(done, self.limits, controls, self.most_corners)

    def _is_face(self, ring: Ring) -> bool:
        if len({int(self.contour.controls[k]) for k in ring}) < len(ring):
            return False
        if len(ring) == 3:
            return True
        convex = len(ring) <= self.most_corners and is_convex(self.limits[ring])
        return convex and (self._facing is None or self._facing.fits(ring))

    def _score_all(self) -> None:
        """Scores of all chords along edges of the mesh; those across faces are found when they are needed."""
        count, surface = len(self.contour.vertices), self.contour.surface
        pairs = [(i, j) for i in range(count) for j in range(i + 1, count)]
        ends = [(int(self.contour.vertices[i]), int(self.contour.vertices[j])) for i, j in pairs]
        paths = surface.find(ends, "dijkstra")
        score, length = surface.scores(paths)
        self._rough = dict(zip(pairs, zip(np.round(score, DIGITS).tolist(), length.tolist(), strict=True), strict=True))
        normals, possible = np.zeros((count, count, 3)), np.zeros((count, count), np.bool_)
        rows, columns = np.array(pairs).T
        normals[rows, columns] = normals[columns, rows] = surface.mean_normals(paths)
        possible[rows, columns] = possible[columns, rows] = [self._possible(i, j) for i, j in pairs]
        self._facing = Facing.of(self.points, normals, possible, surface.area)
        self._spare = _LOST * surface.area

    def _possible(self, i: int, j: int) -> bool:
        a, b = (int(self.contour.controls[k]) for k in (i, j))
        return a != b and frozenset((a, b)) not in self._edges

    def _best_chord(self, ring: Ring) -> tuple[int, int] | None:
        """Places within a ring between which to cut; None where there are none.

        Of the chords that leave no area facing away that could face the right way, and that lose little of the area
        over the surface, the best scored.
        """
        n = len(ring)
        chords = [(i, j) for i in range(n) for j in range(i + 2, n - (i == 0)) if self._possible(ring[i], ring[j])]
        chords = [chord for chord in chords if self._leaves_faces(ring, *chord)]
        if not chords:
            return None
        if self._facing is None:
            return self._best_scored(ring, chords)
        costs = dict(zip(chords, self._facing.costs(ring, chords).tolist(), strict=True))
        best = self._best_scored(ring, [chord for chord in chords if costs[chord] <= self._spare])
        self._spare -= costs[best]
        return best

    def _best_scored(self, ring: Ring, chords: list[tuple[int, int]]) -> tuple[int, int]:
        """Of chords the one of least score, then the shortest, that cuts off no sliver if there is such a one."""
        height = _heights(self.limits[ring])
        chords = [chord for chord in chords if min(height[chord], height[chord[::-1]]) > _THIN] or chords
        key = {chord: (min(ring[chord[0]], ring[chord[1]]), max(ring[chord[0]], ring[chord[1]])) for chord in chords}
        chords.sort(key=lambda chord: (self._rough[key[chord]], chord))
        if self.contour.surface.paths == "dijkstra":
            return chords[0]
        likely = chords[:_LOOKED_AT]
        self._refine([key[chord] for chord in likely])
        return min(likely, key=lambda chord: (self._fine[key[chord]], chord))

    def _leaves_faces(self, ring: Ring, i: int, j: int) -> bool:
        """Whether both sides of a chord have three control points at least, and no triangle has one twice."""
        for side in (ring[i : j + 1], ring[j:] + ring[: i + 1]):
            if len({int(self.contour.controls[k]) for k in side}) < 3:
                return False
        return True

    def _refine(self, pairs: list[tuple[int, int]]) -> None:
        fresh = [pair for pair in pairs if pair not in self._fine]
        if not fresh:
            return
        surface = self.contour.surface
        ends = [(int(self.contour.vertices[i]), int(self.contour.vertices[j])) for i, j in fresh]
        score, length = surface.scores(surface.find(ends))
        self._fine.update(zip(fresh, zip(np.round(score, DIGITS).tolist(), length.tolist(), strict=True), strict=True))


def _heights(points: Floats) -> Floats:
    """How far what lies between two places of a ring, from the first on, is off their chord at most, in chords, (n, n).

    Points along a curve make slivers: their chord follows the line of curvature that the curve is, or leaves the
    surface on the curve's hollow side.
    """
    n = len(points)
    found = np.zeros((n, n))
    for i in range(n):
        ahead = np.roll(points, -i, axis=0) - points[i]
        length = np.maximum(np.linalg.norm(ahead, axis=1), 1e-300)
        off = np.linalg.norm(np.cross(ahead[:, None], ahead[None]), axis=2) / length[None]
        off[np.arange(n)[:, None] > np.arange(n)[None]] = 0.0
        found[i] = np.roll(off.max(axis=0) / length, i)
    return found
