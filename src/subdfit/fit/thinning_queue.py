"""Changes of one kind that may be tried, found anew only where the control mesh has changed."""

from collections import defaultdict
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.places import Places
from subdfit.fit.thinning_changes import Change, Polygons
from subdfit.limit.surface import LimitSurface
from subdfit.mesh.polygon_edits import PolygonEdits

Find = Callable[[Polygons, int, set[int]], list[Change]]
"""From a mesh, a vertex, and those to which it was tried: changes at the vertex."""


class Queue:
    """Changes by vertex; vertices go by their rows in the first mesh.

    Parameters
    ----------
    find
        Finds changes at a vertex.
    count
        Vertices of the first mesh.
    """

    def __init__(self, find: Find, count: int) -> None:
        self._find = find
        self._names = np.arange(count)
        self._known: dict[int, list[Change]] = {}
        self._tried: defaultdict[int, set[int]] = defaultdict(set)

    def cheapest(self, surface: LimitSurface, edits: PolygonEdits) -> list[Change]:
        """All changes of the mesh of a surface as it is now, cheapest first."""
        row = np.full(self._names.max(initial=0) + 1, -1)
        row[self._names] = np.arange(len(self._names))
        polygons = Polygons.of(surface.topology, edits, Places(surface).vertices())
        for v, name in enumerate(self._names.tolist()):
            if name not in self._known:
                tried = {int(row[w]) for w in self._tried[name] if w < len(row)} - {-1}
                self._known[name] = [change.named(self._names) for change in self._find(polygons, v, tried)]
        found = [change.named(row) for name in self._names.tolist() for change in self._known[name]]
        return sorted(found, key=lambda change: change.cost)

    def tried(self, changes: list[Change]) -> None:
        """These are not to be found again."""
        for change in changes:
            named = change.named(self._names)
            self._tried[named.first].add(named.second)
            del self._known[named.first]

    def changed(self, rows: NDArray[np.int64], near: NDArray[np.bool_]) -> None:
        """Of the vertices these `rows` are left; changes at those flagged, (n,), before are to be found anew."""
        for name in self._names[near].tolist():
            self._known.pop(name, None)
        self._names = self._names[rows]
