"""Enrichment of a control mesh where the error is (Lavoué et al. 2007, section 5.2)."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from subdfit.errors import InputError
from subdfit.initial.lavoue_fan import fan, ring_sides
from subdfit.mesh.checks import finite_points, numbers, row_numbers, row_pairs
from subdfit.mesh.face_rings import Edge, FaceRings, Ring

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

SIGNIFICANT = 0.5
"""Share of the largest error from which a sample, or a face, belongs to the error field."""
_NEAR, _DIFFUSE = 0.8, 0.5
"""A field is diffuse when this share of its samples exceeds so much of the largest error."""
_MOST_CORNERS = 5
"""Corners that a face may have from which a vertex was taken out: little of its data holds one of more."""


def principal_error_field(distances: Floats, edges: NDArray[np.integer]) -> Flags:
    """Samples of significant error that are connected with the largest, (k,).

    Parameters
    ----------
    distances : (k,) float64, of samples of the surface from the target.
    edges : (e, 2) int, neighbouring samples.

    Raises
    ------
    InputError
        Distances that are none, or an edge that names no sample.
    """
    distances = _checked_distances(distances)
    edges = row_pairs(edges, len(distances), "edges")
    significant = distances >= SIGNIFICANT * distances.max()
    joined = edges[significant[edges].all(axis=1)]
    links = sp.coo_array((np.ones(len(joined), np.int8), joined.T), shape=(len(distances),) * 2)
    group = connected_components(links, directed=False)[1]
    return np.asarray(significant & (group == group[np.argmax(distances)]))


def is_diffuse(distances: Floats, field: Flags) -> bool:
    """Whether a field has no centre: half of its samples and more come near the largest error.

    Raises
    ------
    InputError
        Distances that are none, a field without a sample, or not one flag each.
    """
    distances, field = _checked_distances(distances), np.asarray(field)
    if field.shape != distances.shape or field.dtype != np.bool_ or not field.any():
        raise InputError(
            f"the field is {field.dtype} of the shape {field.shape} for {len(distances)} samples; "
            "give one bool each, one or more of them true"
        )
    return float(np.mean(distances[field] >= _NEAR * distances.max())) >= _DIFFUSE


def _checked_distances(given: Floats) -> Floats:
    distances = numbers(given, "distances")
    if distances.ndim != 1 or len(distances) == 0:
        raise InputError(f"distances have the shape {distances.shape}; give (k,), one or more")
    if not (np.isfinite(distances) & (distances >= 0)).all():
        raise InputError("a distance is negative or not finite; give finite ones from 0")
    return distances


class Faces(FaceRings):
    """Faces open to enrichment; what names no face or vertex raises InputError."""

    def merge_and_insert(self, chosen: list[int], place: Floats) -> bool:
        """The local case: faces become one, with a new vertex that is joined to its neighbours.

        Nothing is done, and False returned, where the faces do not form a disk, or a crease runs between them.
        """
        loop, place = self._outline(self._numbers(chosen)), finite_points([place], "new vertex")[0]
        if not loop:
            return False
        self.points.append(place)
        self._replace(chosen, fan(loop, len(self.points) - 1, self._left_bare(loop, chosen)))
        return True

    def take_out(self, vertex: int) -> bool:
        """The inverse of the local case: the faces round a vertex become one.

        Nothing is done, and False returned, where they do not form a disk round it, a crease runs between them, or the
        face would have too many corners.
        """
        row_numbers([vertex], len(self.points), "vertices")
        chosen = [k for k, ring in enumerate(self.rings) if vertex in ring]
        loop = self._outline(chosen)
        if not loop or vertex in loop:
            return False
        bare = self._left_bare(loop, chosen)
        if not 3 <= len(loop) - len(bare) <= _MOST_CORNERS:
            return False
        self._replace(chosen, [loop])
        self.rings = [[v for v in ring if v not in bare] for ring in self.rings]
        return min(map(len, self.rings)) >= 3

    def _left_bare(self, loop: Ring, chosen: list[int]) -> set[int]:
        """Inner vertices of a ring round faces that keep one other face only: without a spoke, their valence were 2."""
        sides = {side for ring in self.rings for side in ring_sides(ring)}
        rim = {v for side in sides if side[::-1] not in sides for v in side}
        left = [v for k, ring in enumerate(self.rings) if k not in chosen for v in ring]
        return {v for v in loop if v not in rim and left.count(v) == 1}

    def enrich_each(self, chosen: list[int]) -> None:
        """The diffuse case: each face gets a vertex at its middle, and sides between two of them are cut.

        Both halves of a crease are as sharp as it was.
        """
        chosen = self._numbers(chosen)
        owner = {(a, b): k for k in chosen for a, b in ring_sides(self.rings[k])}
        middle: dict[Edge, int] = {}
        for a, b in sorted(side for side in owner if side[::-1] in owner and side[0] < side[1]):
            self.points.append((self.points[a] + self.points[b]) / 2)
            middle[frozenset((a, b))] = len(self.points) - 1
        for edge in middle.keys() & self.creases.keys():
            sharpness = self.creases.pop(edge)
            self.creases |= {frozenset((end, middle[edge])): sharpness for end in edge}
        # A middle without a spoke from either side would be a vertex of two faces.
        cuts, fresh = set(middle.values()), list[Ring]()
        for k in chosen:
            loop: Ring = []
            for a, b in ring_sides(self.rings[k]):
                loop += [a, *([middle[frozenset((a, b))]] if frozenset((a, b)) in middle else [])]
            self.points.append(np.mean([self.points[v] for v in self.rings[k]], axis=0))
            fresh += fan(loop, len(self.points) - 1, cuts & set(loop))
        self._replace(chosen, fresh)

    def _numbers(self, chosen: list[int]) -> list[int]:
        rows: list[int] = row_numbers(chosen, len(self.rings), "faces").tolist()
        if len(set(rows)) < len(rows):
            raise InputError(f"faces {rows} are not all different; name each once")
        return rows

    def _replace(self, gone: list[int], by: list[Ring]) -> None:
        self.rings = [ring for k, ring in enumerate(self.rings) if k not in set(gone)] + by

    def _outline(self, chosen: list[int]) -> Ring:
        """The ring round some faces; empty unless they form a disk in which no crease runs."""
        sides = {side for k in chosen for side in ring_sides(self.rings[k])}
        if any(side[::-1] in sides and frozenset(side) in self.creases for side in sides):
            return []
        outer = dict(side for side in sides if side[::-1] not in sides)
        if len(outer) != sum(side[::-1] not in sides for side in sides):
            return []
        if not outer:
            return []
        begin = min(outer)
        loop = [begin]
        while outer[loop[-1]] != begin:
            loop.append(outer[loop[-1]])
        inside = {v for k in chosen for v in self.rings[k]} - set(loop)
        euler = len(loop) + len(inside) - (len(sides) + len(outer)) // 2 + len(chosen)
        return loop if len(loop) == len(outer) and euler == 1 else []
