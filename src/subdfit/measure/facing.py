"""Whether a surface faces where its target does: sheets of a thin part may fall together within the tolerance."""

import numpy as np
from numpy.typing import NDArray

from subdfit.parallel import map_chunks
from subdfit.target.normals import face_normals
from subdfit.target.target import Target

Floats = NDArray[np.float64]

AWAY = -0.3
"""Cosine below which a triangle faces away from the target: across sharp edges 0 is met by chance."""
MOST_AWAY = 0.02
"""Share of the area from which a surface is no longer the target's. In sound fits .002 at most faces away, in those of
thin disks and lenses whose sheets had fallen together .047 and more."""

CHUNK = 65536
"""Triangles that are judged at one go: more would take memory for nothing."""

AS_NEAR = 1e-6
"""Share of the diagonal by which faces may be farther than the nearest and count as near: the two sides of a sheet."""


def share_facing_away(
    samples: Floats, triangles: NDArray[np.int32], target: Target, nearest: NDArray[np.int32]
) -> float:
    """Share of a surface's area that faces against the target at all three corners, and not at a sheet with two sides.

    Parameters
    ----------
    samples, triangles : the surface's triangulation.
    target : a mesh, of which the trees and triangles are used; of a cloud nothing faces away.
    nearest : (len(samples),), the target's triangle that each sample meets.

    Returns
    -------
    At most a half: a surface that is inside out as a whole faces the right way.
    """
    if target.cloud or not target.is_mesh:
        return 0.0
    facing = face_normals(target.points, target.triangles)

    def judged(start: int, stop: int) -> tuple[Floats, NDArray[np.bool_]]:
        some = triangles[start:stop]
        a, b, c = (samples[corner] for corner in some.T)
        normal = np.cross(b - a, c - a)
        area = np.linalg.norm(normal, axis=1)
        away = np.all(np.einsum("kd,kcd->kc", normal, facing[nearest[some]]) < AWAY * area[:, None], axis=1)
        rows = np.flatnonzero(away)
        away[rows] = ~_meets_both_sides((a + b + c)[rows] / 3, normal[rows], target, facing)
        return area, away

    area, away = (np.concatenate(parts) for parts in zip(*map_chunks(judged, len(triangles), CHUNK), strict=True))
    share = float(area[away].sum() / max(area.sum(), 1e-300))
    return min(share, 1 - share)


def _meets_both_sides(places: Floats, normal: Floats, target: Target, facing: Floats) -> NDArray[np.bool_]:
    """Whether a face that faces where a place does, (k,), is as near as the nearest: the target is a sheet there."""
    radii = target.tree.closest(places).distance + AS_NEAR * target.diagonal
    begin, found, _ = target.tree.within(places, radii)
    place = np.repeat(np.arange(len(places)), np.diff(begin))
    alike = np.einsum("kd,kd->k", normal[place], facing[found]) > 0
    return np.bincount(place[alike], minlength=len(places)) > 0
