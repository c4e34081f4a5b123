"""Few convex faces from many: diagonals that are not needed are removed (Hertel and Mehlhorn 1983)."""

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.initial.lavoue_fan import ring_sides
from subdfit.mesh.checks import finite_points, row_numbers

Floats = NDArray[np.float64]
Ring = list[int]

_PLANE = 0.02
"""Distance from the mean plane, as a share of the extent, up to which a ring is plane."""
_STRAIGHT = np.cos(np.radians(178.0))
"""A corner of 178 degrees and more is no corner."""


def normal_of(corners: Floats) -> Floats:
    """Newell's normal of a ring of points (k, 3), not normalised."""
    after = np.roll(corners, -1, axis=0)
    return np.asarray(np.cross(corners, after).sum(axis=0))


def is_plane(corners: Floats) -> bool:
    """Whether a ring of points (k, 3) lies near its mean plane."""
    centred = corners - corners.mean(axis=0)
    extent = np.linalg.svd(centred, compute_uv=False)
    return bool(extent[-1] <= _PLANE * extent[0])


def is_convex(corners: Floats) -> bool:
    """Whether every corner of a ring (k, 3), seen along its normal, turns left by at least two degrees."""
    normal = normal_of(corners)
    size = np.linalg.norm(normal)
    if size == 0:
        return False
    back, on = np.roll(corners, 1, axis=0) - corners, np.roll(corners, -1, axis=0) - corners
    left = np.cross(on, back) @ (normal / size)
    straight = np.sum(on * back, axis=1)
    return bool(np.all(left > 0) and np.all(straight > _STRAIGHT * np.hypot(left, straight)))


def convex_parts(rings: list[Ring], points: Floats, names: NDArray[np.int64], most_corners: int = 4) -> list[Ring]:
    """Remove sides between plane rings while what is left is convex.

    Parameters
    ----------
    rings : places of a common outline, counter-clockwise; neighbours share a side run both ways.
    points : (k, 3) float64, the places.
    names : (k,) int64; no ring may have two places of one name.
    most_corners : that a ring may have.

    Returns
    -------
    The rings that are left. Convex parts of a triangulated plane outline number at most four times the fewest possible
    (with as many corners as they like).

    Raises
    ------
    InputError
        A ring names no place, or has fewer than three, or not every place has a name.
    """
    points, names = finite_points(points, "outline"), np.asarray(names)
    rings = [row_numbers(ring, len(points), f"places of ring {k}").tolist() for k, ring in enumerate(rings)]
    for k, ring in enumerate(rings):
        if len(set(ring)) < max(len(ring), 3):
            raise InputError(f"ring {k} is {ring}; give three places or more, all different")
    if names.shape != (len(points),):
        raise InputError(f"names of the shape {names.shape} for {len(points)} places; give one each")
    while True:
        side_of = {(a, b): k for k, ring in enumerate(rings) for a, b in ring_sides(ring)}
        shared = sorted((a, b) for a, b in side_of if a < b and (b, a) in side_of)
        shared.sort(key=lambda side: -float(np.linalg.norm(points[side[0]] - points[side[1]])))
        for a, b in shared:
            one, other = side_of[a, b], side_of[b, a]
            joined = _joined(rings[one], rings[other], a, b)
            fits = len(joined) <= most_corners and len(set(names[joined].tolist())) == len(joined)
            if one != other and fits and is_plane(points[joined]) and is_convex(points[joined]):
                rings[one] = joined
                del rings[other]
                break
        else:
            return rings


def _joined(one: Ring, other: Ring, a: int, b: int) -> Ring:
    """The ring round two that share the side from a to b of the first."""
    i, j = one.index(a), other.index(b)
    first = [*one[i + 1 :], *one[: i + 1]]  # from b round to a
    second = [*other[j + 1 :], *other[: j + 1]]  # from a round to b
    return first + second[1:-1]
