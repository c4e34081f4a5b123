"""Corners that are wider than a straight angle: a crease within parts them.

The surface between two sharp curves that meet in a corner has their tangents there, or is drawn towards their sum.
Where it is to fill more than a straight angle it folds over to the other side. Biermann, Levin and Zorin 2000 have
rules of their own for such corners, which other programs would not know. One more sharp edge within leaves two corners
that the common rules can fill; on a plane face nothing else shows of it. The notches of a boundary that runs in a
zigzag are wide as well, but no corners of a face: a crease from every one would cut what is smooth beyond into strips.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.face_rings import FaceRings, Ring

Pairs = NDArray[np.int64]

WIDE = np.radians(200.0)
"""The angle of a corner from which it is parted: clearly more than a straight one, which meshes give or take some
degrees."""
ALIKE = np.radians(15.0)
"""Ways to part a corner count as alike to the best whose larger angles exceed its by no more."""
CORNER, INSIDE, ON_CURVE = range(3)
"""Ends of a crease within, the best first."""


@dataclass(frozen=True)
class Spoke:
    """A control edge at a corner: its far end, whether it is sharp, and the angle from it to the next."""

    end: int
    sharp: bool
    angle: float


def part_wide_corners(mesh: ControlMesh, whole: Iterable[int] = ()) -> tuple[ControlMesh, Pairs]:
    """The control mesh with creases within corners that are wider than a straight angle, and the ends of these, (k, 2).

    Such a crease runs along a control edge, to another corner or to a vertex inside the surface; an edge that leads to
    a smooth place of a curve is cut in its middle first, since a third sharp edge would make that place a corner.
    Vertices that are to stay `whole` are not parted. Where no other corner is so wide the mesh itself comes back.
    """
    parting = _Parting(mesh)
    for v in sorted(parting.corners().difference(whole)):
        while (end := parting.way_within(v)) is not None:
            parting.sharpen(v, end)
    within = np.array(parting.within, np.int64).reshape(-1, 2)
    return (parting.rings.frozen(mesh) if len(within) else mesh), within


class _Parting:
    """A control mesh on its way: its faces, the sharp neighbours of each vertex, the faces round each."""

    def __init__(self, mesh: ControlMesh) -> None:
        t = mesh.topology
        self.rings = FaceRings.of(mesh)
        self.within: list[tuple[int, int]] = []
        self._tagged = set(np.flatnonzero(np.isinf(t.corner_sharpness)).tolist())
        self._sharp: dict[int, set[int]] = {}
        for a, b in t.ends(np.flatnonzero(np.isinf(t.sharpness))).tolist():
            self._sharp.setdefault(a, set()).add(b)
            self._sharp.setdefault(b, set()).add(a)
        self._faces: dict[int, set[int]] = {v: set() for v in range(t.vertex_count)}
        for k, ring in enumerate(self.rings.rings):
            for v in ring:
                self._faces[v].add(k)

    def corners(self) -> set[int]:
        """Corners of curves."""
        return {v for v in self._sharp if self._kind(v) == CORNER}

    def _kind(self, v: int) -> int:
        count = len(self._sharp.get(v, ()))
        if count > 2 or (count and v in self._tagged):
            return CORNER
        return ON_CURVE if count else INSIDE

    def way_within(self, v: int) -> int | None:
        """The far end of the control edge that parts the first too wide sector of a corner best, None without any.

        Best is the way with the least larger angle; of those alike the one with the best end.
        """
        for sector in self._sectors(v):
            ahead = np.cumsum([spoke.angle for spoke in sector])
            if ahead[-1] > WIDE and len(sector) > 1:
                larger = np.maximum(ahead[:-1], ahead[-1] - ahead[:-1])
                alike = np.flatnonzero(larger <= larger.min() + ALIKE)
                ways = [(larger[k], sector[k + 1].end) for k in alike]
                return min((self._kind(end), angle, end) for angle, end in ways)[2]
        return None

    def _sectors(self, v: int) -> list[list[Spoke]]:
        """The spokes of a vertex counter-clockwise, in sectors that begin with a sharp one."""
        following = {}
        for k in self._faces[v]:
            ring = self.rings.rings[k]
            at = ring.index(v)
            following[ring[(at + 1) % len(ring)]] = ring[at - 1]
        open_ends = following.keys() - set(following.values())
        end = min(open_ends or self._sharp[v] & following.keys())
        sectors: list[list[Spoke]] = []
        for _ in range(len(following)):
            spoke = Spoke(end, end in self._sharp[v], self._angle(v, end, following[end]))
            if spoke.sharp:
                sectors.append([])
            sectors[-1].append(spoke)
            end = following[end]
        return sectors

    def _angle(self, v: int, a: int, b: int) -> float:
        one, other = (self.rings.points[u] - self.rings.points[v] for u in (a, b))
        return float(np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other))

    def sharpen(self, v: int, end: int) -> None:
        """Make the control edge from a corner a crease; the near half of it where it ends on a curve."""
        if self._kind(end) == ON_CURVE:
            end = self._cut(v, end)
        self.rings.creases[frozenset((v, end))] = np.inf
        self._sharp[v].add(end)
        self._sharp.setdefault(end, set()).add(v)
        self.within.append((v, end))

    def _cut(self, v: int, end: int) -> int:
        """Put a vertex at the middle of an edge; faces beside it become a triangle at the far end and the rest."""
        points = self.rings.points
        points.append((points[v] + points[end]) / 2)
        middle = len(points) - 1
        self._faces[middle] = set()
        for k in self._faces[v] & self._faces[end]:
            ring = self.rings.rings[k]
            at = ring.index(v)
            ring = ring[at:] + ring[:at]
            if ring[1] == end:
                self._replace(k, [v, middle, *ring[2:]], [middle, end, ring[2]])
            else:
                self._replace(k, [v, *ring[1:-1], middle], [middle, ring[-2], end])
        return middle

    def _replace(self, k: int, *by: Ring) -> None:
        for u in self.rings.rings[k]:
            self._faces[u].discard(k)
        self.rings.rings[k] = by[0]
        self.rings.rings += by[1:]
        for number, ring in zip((k, len(self.rings.rings) - 1), by, strict=True):
            for u in ring:
                self._faces[u].add(number)
