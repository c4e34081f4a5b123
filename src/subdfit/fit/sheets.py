"""Whether a surface keeps the sheets of thin parts apart: where it does not, it faces the wrong way."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.fitter import Fitter
from subdfit.fit.state import FitState
from subdfit.initial.reach import within_reach
from subdfit.limit.tessellate import lattice

SEGMENTS = 2
"""Segments a cell side into which the surface is cut to see where it faces."""
MIXED = 0.0005
"""Share of the surface that faces the wrong way from which, if it does after a round of a fit as well, the control mesh
is too coarse there to part the sheets. Of nine models, sound starts left so much at most, and those whose fits could
not be certified .002 and more."""
AGAINST = -0.25
"""Cosine between normals below which a place faces the wrong way: beside a sharp edge the other face, at a right angle,
may be the nearest.
"""
REACH = 3.0
"""Within how many cell sides of such places it is made finer: the sheets on both sides, and what leads up to them."""


@dataclass(frozen=True, eq=False)
class Mixed:
    """Where a surface faces against the target's nearest face.

    Attributes
    ----------
    share : of the surface's area.
    places : (k, 3), points there.
    reach : (k,), how far round each more control vertices are needed to keep the sheets apart.
    """

    share: float
    places: NDArray[np.float64]
    reach: NDArray[np.float64]

    def near(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which of some points, (n, 3), lie within reach."""
        return within_reach(points, self.places, self.reach)


def mixed(state: FitState) -> Mixed:
    """Find where the surface faces the wrong way; nowhere for a cloud."""
    target, surface = state.data.target, state.surface
    if target.cloud:
        return Mixed(0.0, np.empty((0, 3)), np.empty(0))
    grid = lattice(surface.domain, SEGMENTS)
    corners = surface.evaluate(grid.face, grid.uv).position[grid.triangles]
    middle = corners.mean(axis=1)
    nearest = target.tree.closest(middle).triangle
    own, other = (
        np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]) for p in (corners, target.points[target.triangles[nearest]])
    )
    area = np.linalg.norm(own, axis=1)
    wrong = np.sum(own * other, axis=1) < AGAINST * area * np.linalg.norm(other, axis=1)
    reach = REACH * SEGMENTS * np.sqrt(area[wrong])
    return Mixed(float(area[wrong].sum() / max(area.sum(), 1e-300)), middle[wrong], reach)


def mixed_sheets(state: FitState, fitter: Fitter) -> tuple[Mixed | None, FitState | None]:
    """Where the surface mixes sheets up and the first round of a fitter does not mend it.

    Returns
    -------
    mixed : None where it mixes none up, or the round mends it.
    advanced : the state after that round, None where none was needed.
    """
    if mixed(state).share <= MIXED:
        return None, None
    advanced = fitter.advance(state)
    found = mixed(advanced)
    return (found if found.share > MIXED else None), advanced
