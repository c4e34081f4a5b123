"""Patches of the quad-triangle scheme as they are compiled: which faces are patches, and the types of their kinds."""

from collections.abc import Hashable
from typing import cast

import numpy as np
from numpy.typing import NDArray

from subdfit.mesh.topology import Topology
from subdfit.schemes._compile import Listed
from subdfit.schemes._irregular import towards_corner
from subdfit.schemes._level import Level
from subdfit.schemes._quad_triangle_kinds import Corner, Kind, Regular, Strip, groups
from subdfit.schemes._quad_triangle_parts import Part, parts, polynomials
from subdfit.schemes._quad_triangle_patches import list_points, patch_size
from subdfit.schemes._quad_triangle_rules import refine
from subdfit.schemes._quad_triangle_sectors import edge_tangents, limit_mask
from subdfit.schemes._quad_triangle_strips import STRIPS, exponents, part_numbers, relative, strips
from subdfit.schemes._type_store import Arena, PlacedType, Types, TypeStore
from subdfit.schemes.patch_table import LEVELS, STRIDE, Strips
from subdfit.schemes.scheme import Refinement

Rows = NDArray[np.int64]
Matrix = NDArray[np.float64]


class MixedPatches:
    """Patches over triangles and quads: polynomials, corners, strips."""

    @property
    def strips(self) -> Strips:
        """The strips beside regular seams."""
        return strips()

    def refine(self, topology: Topology) -> Refinement:
        """One step of the scheme."""
        return refine(topology)

    def listed(self, level: Level, faces: Rows, offsets: Rows) -> Listed:
        """List the faces that are patches as they are."""
        found = groups(level, faces)
        kinds = [group.kind for group in found]
        rows = np.concatenate([np.empty(0, np.int64), *(group.rows for group in found)])
        half_edges = np.concatenate([np.empty(0, np.int64), *(group.half_edges for group in found)])
        which = np.repeat(np.arange(len(found)), [len(group.rows) for group in found])
        start, points = list_points(level, kinds, which, half_edges)
        mirrored = points[:, 1] >= 0
        mirrors, number = np.unique(points[mirrored], axis=0, return_inverse=True)
        out = (points[:, 0] + offsets[0]).astype(np.int32)
        out[mirrored] = offsets[1] + number.ravel()
        corner = half_edges - level.topology.face_offsets[faces[rows]]
        return Listed(rows, list[Hashable](kinds), which, corner, np.diff(start), out, mirrors)

    def types(self, kinds: list[Hashable]) -> Types:
        """The types of kinds."""
        return _STORE.types(cast(list[Kind], kinds))


def _types(kinds: list[Kind], arena: Arena) -> list[PlacedType]:
    corners = [kind for kind in kinds if isinstance(kind, Corner)]
    found = dict(zip(corners, _corner_types(corners, arena), strict=True)) if corners else {}
    return [found[kind] if isinstance(kind, Corner) else _smooth_type(kind, arena) for kind in kinds]


_STORE = TypeStore(_types)


def _smooth_type(kind: Regular | Strip, arena: Arena) -> PlacedType:
    """The type of a patch without an irregular corner."""
    if isinstance(kind, Regular):
        matrix, strip = polynomials(kind.size), -1
    else:
        matrix, strip = relative(np.eye(patch_size(kind))), STRIPS.index((kind, 0))
    begin, place = arena.room(matrix.size)
    place[:] = matrix.T.ravel()
    return PlacedType(matrix.shape[1], 0, (strip, -1, -1), begin)


def _corner_types(kinds: list[Corner], arena: Arena) -> list[PlacedType]:
    """The types of irregular corners; those of one shape and size are made together."""
    found = parts(kinds)
    shapes = np.array([(kind.size, len(quarters[0].matrix)) for kind, quarters in zip(kinds, found, strict=True)])
    out: dict[int, PlacedType] = {}
    for shape in np.unique(shapes.reshape(-1, 2), axis=0):
        alike = np.flatnonzero((shapes == shape).all(axis=1))
        out |= zip(alike.tolist(), _alike([kinds[i] for i in alike], [found[i] for i in alike], arena), strict=True)
    return [out[i] for i in range(len(kinds))]


def _alike(kinds: list[Corner], quarters: list[list[Part]], arena: Arena) -> list[PlacedType]:
    """The types of irregular corners of faces of one shape, whose patches have the same number of points."""
    chosen, powers = ((1, 3, 2) if kinds[0].size == 4 else (1, 2, 3)), exponents(kinds[0].size)
    numbers = [[part_numbers(own[i]) for i in chosen] for own in quarters]
    smaller = np.array([own[0].matrix for own in quarters])
    mask, tangents = np.zeros(smaller.shape[:2]), np.zeros((len(kinds), 2, smaller.shape[1]))
    for i, kind in enumerate(kinds):
        limit, edges = limit_mask(kind.sector), edge_tangents(kind.sector)
        mask[i, : len(limit)] = limit
        tangents[i, :, : len(limit)] = edges[[kind.position, (kind.position + 1) % len(edges)]]
    each = (3 * LEVELS + 1) * smaller.shape[1] * STRIDE
    begin, place = arena.room(len(kinds) * each)
    towards_corner(
        smaller,
        np.array([[matrix for _, matrix in own] for own in numbers]),
        mask,
        tangents,
        (powers.index((1, 0)), powers.index((0, 1))),
        place,
    )
    return [
        PlacedType(smaller.shape[1], LEVELS, (own[0][0], own[1][0], own[2][0]), begin + i * each)
        for i, own in enumerate(numbers)
    ]
