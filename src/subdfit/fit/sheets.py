"""Whether a surface keeps the sheets of thin parts apart: where it does not, it faces the wrong way."""

import numpy as np

from subdfit.fit.fitter import Fitter
from subdfit.fit.state import FitState
from subdfit.limit.tessellate import lattice

SEGMENTS = 2
"""Segments a cell side into which the surface is cut to see where it faces."""
DOUBTFUL, MIXED = 0.0005, 0.001
"""Shares of the surface that face the wrong way: from the first on one round of a fit shows whether they come right,
and if more than the second is left, the control mesh is too coarse to part the sheets. Of nine models, sound starts
left .0005 at most, and those whose fits could not be certified .002 and more."""


def mixed_share(state: FitState) -> float:
    """Share of the surface's area that faces against the target's nearest face; 0 for a cloud."""
    target, surface = state.data.target, state.surface
    if target.cloud:
        return 0.0
    grid = lattice(surface.domain, SEGMENTS)
    corners = surface.evaluate(grid.face, grid.uv).position[grid.triangles]
    nearest = target.tree.closest(corners.mean(axis=1)).triangle
    own, other = (
        np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]) for p in (corners, target.points[target.triangles[nearest]])
    )
    area = np.linalg.norm(own, axis=1)
    return float(area[np.sum(own * other, axis=1) < 0].sum() / max(area.sum(), 1e-300))


def mixes_sheets(state: FitState, fitter: Fitter) -> bool:
    """Whether the surface mixes sheets up, and a round by a fitter, made for this, does not mend it."""
    return mixed_share(state) > DOUBTFUL and mixed_share(fitter.advance(state)) > MIXED
