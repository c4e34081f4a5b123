"""Whether a surface keeps the sheets of thin parts apart: where it does not, it faces the wrong way."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.fitter import Fitter
from subdfit.fit.reverse import inner_places
from subdfit.fit.state import FitState
from subdfit.initial.reach import within_reach
from subdfit.schemes.domain import QUAD
from subdfit.target.normals import face_normals
from subdfit.target.target import Target

MIXED = 0.0005
"""Share of the surface that faces the wrong way from which, if it does after a round of a fit as well, the control mesh
is too coarse there to part the sheets. Of nine models, judged by chords across quarters of cells, sound starts left so
much at most, and those whose fits could not be certified .002 and more."""
AGAINST = -0.25
"""Cosine between normals below which a place faces the wrong way: beside a sharp edge the other face, at a right angle,
may be the nearest."""
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
    face, uv = inner_places(surface.domain, np.arange(surface.domain.face_count))
    found = surface.evaluate(face, uv, 1)
    assert found.first is not None
    normal = np.cross(found.first[:, 0], found.first[:, 1])
    area = np.linalg.norm(normal, axis=1)
    nearest = target.tree.closest(found.position).triangle
    cosine = np.sum(normal * _facing(target, nearest), axis=1)
    wrong = cosine < AGAINST * area
    # Samples of a cell stand for equal parts of it, and the area is that of a quad of its sides.
    shape = surface.domain.shape[face]
    part = area / np.where(shape == QUAD, 1.0, 2.0) / (shape + 1)
    return Mixed(
        float(part[wrong].sum() / max(part.sum(), 1e-300)), found.position[wrong], REACH * np.sqrt(area[wrong])
    )


def _facing(target: Target, triangle: NDArray[np.integer]) -> NDArray[np.float64]:
    """Where triangles (k,) of a target face, (k, 3): as their corners do where noise turned them upside down."""
    corners = target.triangles[triangle]
    own, around = face_normals(target.points, corners), target.normals[corners].mean(axis=1)
    return np.where(np.sum(own * around, axis=1, keepdims=True) < 0, around, own)


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
