"""Bicubic patches over quads: their points, and the matrices of their types.

The step towards an irregular corner is read off the scheme itself: a fan of quads round the corner is refined, and the
patches of its children are listed as any others are.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from subdfit.mesh.topology import Topology
from subdfit.schemes import _quad_kernels as kernels
from subdfit.schemes._corner_type import CornerType
from subdfit.schemes._irregular import limit_mask, towards_corner
from subdfit.schemes._level import Level
from subdfit.schemes._one_shape import REGULAR, OneShapePatches
from subdfit.schemes._tangents import limit_tangents
from subdfit.schemes.patch_table import STRIDE
from subdfit.schemes.scheme import Refinement

Indices = NDArray[np.int32]
Rows = NDArray[np.int64]
Matrix = NDArray[np.float64]

OUTER = 8
"""Points of a patch beside the corner's ring: the corner itself, and seven round the other three."""
GRID = [(0, 0), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)]
GRID += [(2, -1), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (-1, 2)]
"""Where the points of a regular patch lie, in their order."""


@dataclass(frozen=True)
class QuadPatches(OneShapePatches):
    """Patches of a scheme that is Catmull-Clark's around these quads; `refine` is the scheme's own."""

    refine: Callable[[Topology], Refinement]
    corners: int = 4
    regular_size: int = len(GRID)

    def sizes(self, faces: Rows, edges: Rows) -> Rows:
        """The corner's ring, the corner, and seven points round the other three."""
        return faces + edges + OUTER

    def points(self, level: Level, chosen: Rows, corner: Rows, start: Rows, offsets: Rows) -> tuple[Indices, Indices]:
        """List the points of patches and the mirror points they use."""
        t = level.topology
        places = 2 * len(t.face_vertices)
        mirror_of = np.full(places, -1, np.int32)
        mirror_corners = np.empty((2 * np.count_nonzero(level.sharp), 3), np.int32)
        used = np.zeros(1, np.int64)
        points = kernels.patch_points(
            t.face_offsets[chosen] + corner,
            start,
            offsets,
            t.face_vertices,
            t.following,
            level.preceding,
            t.twin,
            level.sharp_count,
            level.first,
            level.faces,
            level.position,
            mirror_of,
            mirror_corners,
            used,
        )
        return points, mirror_corners[: used[0]]

    def matrices(self, kind: CornerType) -> Matrix:
        """The matrices of a type."""
        return bicubic_basis().T.ravel() if kind == REGULAR else _irregular_matrices(self, kind)

    def limit_mask(self, kind: CornerType) -> Matrix:
        """Weights of the corner and its ring for its limit point, (1 + faces + edges,)."""
        ring = 1 + kind.faces + kind.edges
        return limit_mask(self.step(kind)[0][:ring, :ring])

    def step(self, kind: CornerType) -> tuple[Matrix, list[Matrix]]:
        """One step towards a corner, from the patch's points.

        Returns
        -------
        smaller : (n, n), the points of the child at the corner.
        regular : three (16, n), those of the regular children beside the second corner, beside the last, and between.
        """
        fan = quad_fan(kind)
        refinement = self.refine(fan)
        face = 4 * kind.position
        whole = self._list(fan, np.array([face]), 0)
        column = np.full(fan.vertex_count, -1)
        real = whole[:, 1] < 0
        column[whole[real, 0]] = np.flatnonzero(real)
        child = 4 * face + np.array([0, 1, 3, 2])
        found = []
        for chosen, corner in zip(child, (0, 3, 1, 2), strict=True):
            points = self._list(refinement.child, np.array([chosen]), corner)
            fine = refinement.matrix.toarray()
            rows = fine[points[:, 0]].copy()
            mirrored = points[:, 1] >= 0
            rows[mirrored] += fine[points[mirrored, 1]] - fine[points[mirrored, 2]]
            assert not rows[:, column < 0].any()
            matrix = np.zeros((len(rows), len(whole)))
            matrix[:, column[column >= 0]] = rows[:, column >= 0]
            found.append(matrix)
        return found[0], found[1:]

    def _list(self, t: Topology, face: Rows, corner: int) -> Indices:
        """The points of one patch as vertices a, b, c for a + b - c, those of plain vertices with -1 for b and c."""
        level = Level.of(t)
        h = t.face_offsets[face] + corner
        size = self.regular_size
        if not level.regular[h[0]]:
            v = t.face_vertices[h]
            faces = level.faces[h].astype(np.int64)
            size = int(self.sizes(faces, faces + (level.sharp_count[v] > 1))[0])
        points, mirrors = self.points(
            level, face, np.array([corner]), np.array([0, size]), np.array([0, t.vertex_count])
        )
        out = np.full((size, 3), -1, np.int32)
        plain = points < t.vertex_count
        out[plain, 0] = points[plain]
        out[~plain] = mirrors[points[~plain] - t.vertex_count]
        return out


@cache
def _irregular_matrices(rules: QuadPatches, kind: CornerType) -> Matrix:
    smaller, children = rules.step(kind)
    ring = 1 + kind.faces + kind.edges
    mask, tangents = np.zeros(len(smaller)), np.zeros((2, len(smaller)))
    mask[:ring] = limit_mask(smaller[:ring, :ring])
    tangents[:, :ring] = limit_tangents(smaller[:ring, :ring], kind, 1 + 2 * np.arange(kind.edges))
    return towards_corner(smaller, [bicubic_basis() @ child for child in children], mask, tangents, (4, 1))


def bicubic_basis() -> Matrix:
    """The uniform bicubic B-spline's polynomials for a regular patch's points, as coefficients, (STRIDE, 16)."""
    cubic = np.array([[1, -3, 3, -1], [4, 0, -6, 3], [1, 3, 3, -3], [0, 0, 0, 1]]) / 6
    return np.array([np.outer(cubic[x + 1], cubic[y + 1]).ravel() for x, y in GRID]).T.reshape(STRIDE, len(GRID))


def quad_fan(kind: CornerType) -> Topology:
    """Two rings of quads round a corner: vertex 0, and four faces for each face of its sector, the one at it first."""
    row = {(0, 0, 0): 0}

    def vertex(wedge: int, x: int, y: int) -> int:
        if x == 0:
            wedge, x, y = wedge + 1, y, 0
        wedge = wedge % kind.faces if kind.closed else wedge
        key = (wedge, x, y) if x or y else (0, 0, 0)
        return row.setdefault(key, len(row))

    corners = [
        vertex(wedge, x + i, y + j)
        for wedge in range(kind.faces)
        for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))
        for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))
    ]
    return Topology.from_faces(
        np.arange(0, len(corners) + 1, 4),
        corners,
        len(row),
        crease_edges=[[0, row[0, 1, 0]], [row[0, 1, 0], row[0, 2, 0]]] if kind.dart else None,
        corner_vertices=[0] if kind.pinned else None,
    )
