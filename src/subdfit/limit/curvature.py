"""Principal curvatures: from shape operators, and from a surface's first and second derivatives."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_ROUND = 0.1
"""Share of the larger principal curvature by which the other differs at least where directions mean something."""
_FLAT = 0.3
"""Curvature times diagonal below which a difference of principal curvatures says nothing."""


@dataclass(frozen=True)
class PrincipalCurvature:
    """Principal curvatures at k places of a surface.

    Attributes
    ----------
    minimum, maximum : (k,) float64, one over the unit of the points; signed, positive where the surface
        bends away from its normal (a ball with outward normals), and ``minimum <= maximum``.
    minimum_direction, maximum_direction : (k, 3) float64, unit tangent vectors; their sign means nothing.
    normal : (k, 3) float64, unit vectors, to which the directions are orthogonal.
    """

    minimum: Floats
    maximum: Floats
    minimum_direction: Floats
    maximum_direction: Floats
    normal: Floats

    def isotropic(self, diagonal: float = np.inf) -> NDArray[np.bool_]:
        """Tell where the directions carry no information: planes and spheres, (k,) bool.

        Parameters
        ----------
        diagonal : of the surface's bounding box: curvatures that differ by little against one over it count as alike.
        """
        size = np.maximum(np.abs(self.minimum), np.abs(self.maximum))
        return np.asarray(self.maximum - self.minimum <= np.maximum(_ROUND * size, _FLAT / diagonal))


def principal_curvature(tensors: Floats, normals: Floats) -> PrincipalCurvature:
    """Principal values and directions of shape operators (k, 3, 3) in the planes across normals (k, 3)."""
    normals = unit(normals)
    e1 = unit(np.cross(normals, np.eye(3)[np.argmin(np.abs(normals), axis=1)]))
    e2 = np.cross(normals, e1)
    a, b, c = (np.einsum("ki,kij,kj->k", s, tensors, t) for s, t in ((e1, e1), (e1, e2), (e2, e2)))
    mean, gap = (a + c) / 2, np.hypot((a - c) / 2, b)
    turn = 0.5 * np.arctan2(2 * b, a - c)[:, None]
    maximum_direction = np.cos(turn) * e1 + np.sin(turn) * e2
    return PrincipalCurvature(mean - gap, mean + gap, np.cross(normals, maximum_direction), maximum_direction, normals)


def curvature_of_derivatives(first: Floats, second: Floats) -> PrincipalCurvature:
    """Principal curvatures from derivatives by u, v (k, 2, 3) and by uu, uv, vv (k, 3, 3).

    The shape operator is ``-sum(L_ij a^i a^j)`` with the second fundamental form L and the tangents' dual basis a^i.
    Where the tangents are parallel all but the normal, which is zero, is nan.
    """
    normal = np.cross(first[:, 0], first[:, 1])
    area = np.einsum("kx,kx->k", normal, normal)[:, None]
    flat = area[:, 0] <= 0
    with np.errstate(divide="ignore", invalid="ignore"):
        dual = np.stack([np.cross(first[:, 1], normal), np.cross(normal, first[:, 0])], axis=1) / area[:, None]
    form = np.einsum("kdx,kx->kd", second, unit(normal))[:, [0, 1, 1, 2]].reshape(-1, 2, 2)
    found = principal_curvature(-np.einsum("kij,kix,kjy->kxy", form, dual, dual), normal)
    return undefined(found, flat)


def undefined(found: PrincipalCurvature, where: NDArray[np.bool_]) -> PrincipalCurvature:
    """The same with nan for curvatures and directions in some rows."""
    low, high = (np.where(where, np.nan, value) for value in (found.minimum, found.maximum))
    across, along = (
        np.where(where[:, None], np.nan, direction) for direction in (found.minimum_direction, found.maximum_direction)
    )
    return PrincipalCurvature(low, high, across, along, found.normal)


def unit(vectors: Floats) -> Floats:
    """Vectors (k, 3) of length one; zero ones stay."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))
