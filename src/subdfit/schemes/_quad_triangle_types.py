"""Patches of the quad-triangle scheme as they are compiled: which faces are patches, and the types of their kinds."""

from collections.abc import Hashable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from subdfit.mesh.topology import Topology
from subdfit.schemes._compile import Listed
from subdfit.schemes._corner_type import CornerType
from subdfit.schemes._irregular import limit_mask, towards_corner
from subdfit.schemes._level import Level
from subdfit.schemes._quad_triangle_kinds import Corner, Regular, Strip, groups
from subdfit.schemes._quad_triangle_patches import list_points, parts, polynomials
from subdfit.schemes._quad_triangle_rules import refine
from subdfit.schemes._quad_triangle_strips import STRIPS, exponents, part_numbers, relative, strips
from subdfit.schemes._tangents import limit_tangents
from subdfit.schemes.patch_table import LEVELS, PatchType, Strips
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
        points = [list_points(level, group.kind, group.half_edges) for group in found]
        rows = np.concatenate([np.empty(0, np.int64), *(group.rows for group in found)])
        half_edges = np.concatenate([np.empty(0, np.int64), *(group.half_edges for group in found)])
        flat = np.concatenate([np.empty((0, 3), np.int32), *(block.reshape(-1, 3) for block in points)])
        mirrored = flat[:, 1] >= 0
        mirrors, number = np.unique(flat[mirrored], axis=0, return_inverse=True)
        out = (flat[:, 0] + offsets[0]).astype(np.int32)
        out[mirrored] = offsets[1] + number.ravel()
        return Listed(
            rows,
            [group.kind for group in found],
            np.repeat(np.arange(len(found)), [len(group.rows) for group in found]),
            half_edges - level.topology.face_offsets[faces[rows]],
            np.repeat([block.shape[1] for block in points], [len(block) for block in points]),
            out,
            mirrors,
        )

    def type_of(self, kind: Hashable) -> PatchType:
        """The type of a kind."""
        match kind:
            case Regular():
                matrix = polynomials(kind.size)
                return PatchType(matrix.shape[1], 0, (-1, -1, -1), matrix.T.ravel())
            case Strip():
                size = parts(kind)[0].matrix.shape[1]
                return PatchType(size, 0, (STRIPS.index((kind, 0)), -1, -1), relative(np.eye(size)).T.ravel())
            case Corner():
                return corner_type(kind)
        raise TypeError(kind)


@cache
def corner_type(kind: Corner) -> PatchType:
    """The type of an irregular corner."""
    found = parts(kind)
    smaller = found[0].matrix
    chosen = (1, 3, 2) if kind.size == 4 else (1, 2, 3)
    numbers = [part_numbers(found[i]) for i in chosen]
    mask, tangents = np.zeros(len(smaller)), np.zeros((2, len(smaller)))
    ring = smaller[: ring_size(kind), : ring_size(kind)]
    mask[: len(ring)] = limit_mask(ring)
    tangents[:, : len(ring)] = corner_tangents(kind, ring)
    slots = exponents(kind.size).index((1, 0)), exponents(kind.size).index((0, 1))
    matrices = towards_corner(smaller, [matrix for _, matrix in numbers], mask, tangents, slots)
    beside, before, between = (strip for strip, _ in numbers)
    return PatchType(len(smaller), LEVELS, (beside, before, between), matrices)


def ring_size(kind: Corner) -> int:
    """Points of a corner and its ring."""
    return 1 + len(kind.order) + kind.order.count("Q") + (not kind.closed)


def corner_tangents(kind: Corner, ring: Matrix) -> Matrix:
    """Limit tangents along the edges of the patch at its corner, over the corner and its ring."""
    far = np.cumsum([0, *(letter == "Q" for letter in kind.order)])
    edges = 1 + np.arange(len(far)) + far
    corner = CornerType(len(kind.order), kind.position, kind.closed, kind.dart, kind.pinned)
    return limit_tangents(ring, corner, edges[: corner.edges])
