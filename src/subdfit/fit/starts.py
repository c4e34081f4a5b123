"""The first state of a fit, and another where it would mix up the sheets of thin parts."""

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.fitter import Fitter
from subdfit.fit.lavoue import lavoue_start
from subdfit.fit.settings import FitSettings
from subdfit.fit.sheets import MIXED, mixed, mixed_sheets
from subdfit.fit.state import FitState
from subdfit.fit.stop import error_between_data
from subdfit.initial.start import DOUBLING, LARGEST_SHARE, REFININGS, start_mesh
from subdfit.initial.wide_corners import part_wide_corners
from subdfit.limit.surface import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.schemes import scheme_named
from subdfit.target.curves import zigzag
from subdfit.target.target import Target

logger = logging.getLogger(__name__)

LOST = 0.01
"""Share of the surface that faces the wrong way after the first round from a part's own curves, from which no later
round unfolds it: of parts whose fits were certified it was .0087 at most, of others .016 and more."""
DECIMATED = "between the part's own curves alone its sheets would be mixed up; the fit begins with its mesh decimated"
MANY = "the part's faces and edges take %d control vertices for %d allowed; the fit begins with its mesh decimated"
UNCERTIFIED = "from the part's own curves the fit is not certified; it begins again with its mesh decimated"


def started(target: Target, settings: FitSettings) -> tuple[Target, ControlMesh]:
    """The target as its method sees it, and the first control mesh."""
    if settings.method == "lavoue":
        return _parted_corners(*lavoue_start(target, settings))
    return _decimated(target, settings, settings.control_vertices)


@dataclass(frozen=True, eq=False)
class Start:
    """Where a fit begins.

    Attributes
    ----------
    state : the first state.
    fitter : the method, ready for its first round, or for its second where the first is known.
    advanced : the state after the first round; None where that was not looked at.
    own : its control mesh lies between the part's own curves.
    """

    state: FitState
    fitter: Fitter
    advanced: FitState | None = None
    own: bool = False


def parted(state: FitState, settings: FitSettings, fitter: Callable[[], Fitter]) -> Start:
    """The first state, or one of another control mesh where it would mix up the sheets of thin parts.

    The first round of a new `fitter` shows whether they stay mixed up.
    """
    if settings.control_vertices is not None:
        return Start(state, fitter())
    if settings.method != "lavoue":
        return _parted_by_more(state, settings, fitter)
    start = own_start(state, settings, fitter())
    if start is not None:
        return start
    count, most = state.surface.topology.vertex_count, settings.max_control_vertices
    logger.warning("%s", MANY % (count, most) if _too_many(state, settings) else DECIMATED)
    return _from_mesh(state, settings, fitter)


def own_start(state: FitState, settings: FitSettings, fitter: Fitter) -> Start | None:
    """The first state between a part's own curves; None where it is too large, or mixes up sheets for good."""
    if _too_many(state, settings):
        return None
    found, advanced = mixed_sheets(state, fitter)
    return Start(state, fitter, advanced, own=True) if found is None or found.share <= LOST else None


def _too_many(state: FitState, settings: FitSettings) -> bool:
    """Whether a state has more control vertices than the fit may have."""
    return state.surface.topology.vertex_count > (settings.max_control_vertices or np.inf)


def second_start(start: Start, best: FitState, settings: FitSettings, fitter: Callable[[], Fitter]) -> Start | None:
    """Where to begin again after a fit without a certificate.

    With the part's mesh decimated, where it began between the part's own curves; with less decimated where its sheets
    fell together.

    Parameters
    ----------
    start : where that fit began.
    best : where it ended.
    settings : what is asked.
    fitter : makes the method, ready for its first round.

    Returns
    -------
    None where neither is the case, or the control vertices to keep the sheets apart would be too many.
    """
    if start.own:
        logger.warning("%s", UNCERTIFIED)
        return _from_mesh(best, settings, fitter)
    target, mesh, found = best.data.target, best.surface.control_mesh, mixed(best)
    if settings.control_vertices is not None or found.share <= MIXED:
        return None
    wanted = len(mesh.points) + int(found.near(mesh.points).sum())
    if wanted > _most(target, settings):
        return None
    logger.info("sheets fell together; the fit begins again with more control vertices there")
    weights = np.where(found.near(target.points), DOUBLING, 1.0)
    return Start(_begun_again(best, settings, *_decimated(target, settings, wanted, weights)), fitter())


def _from_mesh(state: FitState, settings: FitSettings, fitter: Callable[[], Fitter]) -> Start:
    """The start from the mesh of a state's part, decimated."""
    again = _begun_again(state, settings, *_decimated(state.data.target, settings, None))
    return _parted_by_more(again, settings, fitter)


def _most(target: Target, settings: FitSettings) -> float:
    """Control vertices of a start at most."""
    return min(LARGEST_SHARE * len(target.used), settings.max_control_vertices or np.inf)


def _parted_by_more(state: FitState, settings: FitSettings, fitter: Callable[[], Fitter]) -> Start:
    """The state with more control vertices, and again, where sheets are mixed up."""
    target = state.data.target
    weights = np.ones(len(target.points))
    for _ in range(REFININGS):
        trial = fitter()
        found, advanced = mixed_sheets(state, trial)
        if found is None:
            return Start(state, trial, advanced)
        mesh = state.surface.control_mesh
        wanted = len(mesh.points) + int(found.near(mesh.points).sum())
        if wanted > _most(target, settings):
            return Start(state, trial, advanced)
        weights[found.near(target.points)] *= DOUBLING
        state = _begun_again(state, settings, *_decimated(target, settings, wanted, weights))
    return Start(state, fitter())


def _decimated(
    target: Target, settings: FitSettings, count: int | None, weights: NDArray[np.float64] | None = None
) -> tuple[Target, ControlMesh]:
    """The target, and its own mesh with fewer vertices; see `start_mesh` for the count and the weights."""
    scale = error_between_data(settings.tolerance)
    budget, faces = settings.max_control_vertices, scheme_named(settings.scheme).faces
    return _parted_corners(target, start_mesh(target, count, scale, budget, faces, weights))


def _parted_corners(target: Target, mesh: ControlMesh) -> tuple[Target, ControlMesh]:
    """The mesh with creases within wide corners, and the target with what they follow; a zigzag has no such corners."""
    # Corners of a start are the target's own points.
    teeth = set(map(tuple, target.points[zigzag(target.points, target.boundary_edges)].tolist()))
    whole = [v for v, point in enumerate(mesh.points.tolist()) if tuple(point) in teeth]
    mesh, within = part_wide_corners(mesh, whole)
    return target.creased_within(mesh.points[within]), mesh


def _begun_again(state: FitState, settings: FitSettings, target: Target, mesh: ControlMesh) -> FitState:
    """The state of another first control mesh."""
    data = replace(state.data, target=target)
    return _excused(FitState.start(data, LimitSurface(mesh, settings.scheme)), settings)


def _excused(state: FitState, settings: FitSettings) -> FitState:
    """The state with its outliers left out, where that is allowed."""
    return state.excusing(settings.robust, settings.tolerance.max)
