"""A boundary that is held: its curve is fitted to the data's boundary alone, whatever the surface inside may want.

The curve depends on the boundary's control vertices only. Before anything else they are moved, what lies inside
following, and sides halved until the curve is within tolerance. Then they stay; where a side has gained a vertex, the
curve is looked at again.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.adapt import refined
from subdfit.fit.descent import Descent, Part
from subdfit.fit.faults import curve_sides
from subdfit.fit.places import Places
from subdfit.fit.reverse import Samples, sparse_curve_samples
from subdfit.fit.settings import FitSettings
from subdfit.fit.state import FitState
from subdfit.fit.stop import CURVE_FACTOR, error_that_matters
from subdfit.fit.tangent import TangentSettings

Flags = NDArray[np.bool_]

STEPS, GAIN = 6, 0.99
"""Most steps between two cuts, which end when one leaves more than this share of the energy."""
SEGMENTS = 4
"""Segments of a side between whose ends its curve is compared with the target."""
ROUNDS = 12
"""Most rounds of steps: halved so many times, a side has no data left."""


def boundary_held(state: FitState, settings: FitSettings) -> FitState:
    """The state with the boundary's curve within tolerance of the data's; itself where it is, or is a cloud's.

    Parameters
    ----------
    state
        Any, such as the first, or one whose boundary has gained vertices.
    settings
        The tolerance and the budget of control vertices.
    """
    bound = CURVE_FACTOR * error_that_matters(settings.tolerance)
    budget = settings.max_control_vertices or np.inf
    far = _far_sides(state, bound)
    for _ in range(ROUNDS):
        if not far.any():
            break
        state = _moved(state, bound)
        far = _far_sides(state, bound)
        if state.surface.topology.vertex_count + np.count_nonzero(far) > budget:
            break
        if far.any():
            state = refined(state, far)
    return state


def _moved(state: FitState, bound: float) -> FitState:
    """Steps in which the points on the data's curves alone pull; fairness takes what lies inside along."""
    some, rows = state.thinned(0)
    surface = state.surface
    cells, free = (np.ones(count, np.bool_) for count in (surface.domain.face_count, surface.topology.vertex_count))
    weights = TangentSettings(relaxation=0.0)
    part = Part(some, Samples.none(), sparse_curve_samples(state, cells), free, STEPS, GAIN)
    return state.followed(Descent(weights, bound, weights.damping).moved(part), rows)


def _far_sides(state: FitState, bound: float) -> Flags:
    """Sides of the boundary, (h,), too far from the data there, or whose curve strays from the target between them."""
    far = curve_sides(replace(state, crease=None), bound)
    curves = state.curves[0]
    if state.held[0] is None or curves is None:
        return far
    side = np.repeat(np.arange(len(curves)), SEGMENTS + 1)
    places = np.tile(np.linspace(0, 1, SEGMENTS + 1), len(curves))
    samples = Samples.of(state.surface, state.data.target, *curves.locate(side, places))
    stray = np.unique(side[samples.gap > bound])
    far[Places(state.surface).side[curves.cell[stray], curves.side[stray]]] = True
    return far
