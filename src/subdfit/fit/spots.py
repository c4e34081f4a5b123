"""Spots where few faces are at fault: each moves as a surface of its own, and begins anew where it is stuck."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.aim import AimedSamples
from subdfit.fit.descent import FIRM, Descent, Part
from subdfit.fit.regions import Region, Rows, regions
from subdfit.fit.reverse import DRAWN, Samples, even_samples, sparse_curve_samples, strays
from subdfit.fit.state import FitState
from subdfit.fit.system import smoothed
from subdfit.fit.tangent import TangentSettings
from subdfit.measure import reverse_segments
from subdfit.parallel import map_items

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

STEPS, GAIN = 6, 0.99
"""Most steps of a spot, which ends when one leaves more than this share of the energy: few faces count for little."""
ENOUGH = 32
"""Points for each triangle of a face that take part."""
FARTHEST = 10.0
"""Samples are aimed at what lies within so many bounds."""
PERSISTENT = 4.0
"""A spot that strays though its samples are drawn harder than so many times begins anew."""


@dataclass(frozen=True, eq=False)
class Spot:
    """Control vertices that may move, and the region that they move.

    Attributes
    ----------
    state : the data of the region.
    inner : (cells,) bool, the cells of its surface that may move.
    moving : (n,) bool, its control vertices that may.
    segments : segments a cell's side for samples of the surface, where cells are small.
    weights : of the terms of the energy.
    bound : the error that matters, as a share of the diagonal.
    """

    state: FitState
    inner: Flags
    moving: Flags
    segments: int
    weights: TangentSettings
    bound: float

    def moved(self, insistence: float) -> Floats:
        """Control points, (n, 3), after steps that draw samples by so many times their weight.

        Where strays are left that can be aimed at what faces like the surface, they are. Where it has crumpled to meet
        the data, no pull smooths it: it begins anew, smooth, to be refined.
        """
        samples = self._samples(self.state)
        found = self._settled(self.state, samples, insistence)
        strayed = self._strayed_alone(found)
        if self.bound < strayed < np.inf:
            other = self._aimed(samples, insistence)
            left = self._strayed_alone(other) if other is not None else np.inf
            found, strayed = (other, left) if other is not None and left < strayed else (found, strayed)
        if insistence > PERSISTENT and self.bound < strayed < np.inf:
            mesh = self.state.surface.control_mesh
            anew = self.state.surface.with_points(smoothed(mesh, self.moving))
            begun = FitState.start(self.state.data, anew)
            smooth = self._settled(begun, self._samples(begun), insistence)
            found = smooth if self._strayed(smooth) <= self.bound else found
        return found.surface.control_mesh.points

    def _aimed(self, samples: Samples, insistence: float) -> FitState | None:
        """The state settled with samples aimed at what faces like the surface; None where that changes no stray."""
        state = self.state
        aimed = AimedSamples.aim(samples, state.surface, state.data.target, FARTHEST * self.bound)
        if not np.any((aimed.triangle != samples.triangle) & (samples.gap > self.bound)):
            return None
        return self._settled(state, aimed, insistence)

    def _samples(self, state: FitState) -> Samples:
        surface, target = state.surface, state.data.target
        even = even_samples(surface, target, self.segments, self.inner)
        return even.joined(strays(surface, target, self.bound, self.inner, self.segments, DRAWN))

    def _settled(self, state: FitState, samples: Samples, insistence: float) -> FitState:
        part = Part(state, samples, sparse_curve_samples(state, self.inner), self.moving, STEPS, GAIN)
        return Descent(self.weights, self.bound, FIRM).moved(part, insistence)

    def _strayed(self, state: FitState) -> float:
        """How far the surface strays at most; 0 within the bound."""
        found = strays(state.surface, state.data.target, self.bound, self.inner, self.segments)
        return float(found.gap.max(initial=0.0))

    def _strayed_alone(self, state: FitState) -> float:
        """The same, and endlessly where points are beyond the bound as well."""
        return np.inf if state.excess.max(initial=0.0) > self.bound else self._strayed(state)


def spots_moved(state: FitState, moving: Flags, weights: TangentSettings, bound: float, insistence: float) -> FitState:
    """The state after the flagged control vertices, (n,), have moved, those of each spot by themselves."""
    points = state.surface.control_mesh.points.copy()
    segments = reverse_segments(state.surface.domain)

    def moved(found: tuple[Region, Flags]) -> tuple[Rows, Floats]:
        region, cells = found
        free = moving[region.vertices] & region.own
        some, _ = region.state(state, cells).thinned(ENOUGH)
        spot = Spot(some, region.inner, free, segments, weights, bound)
        return region.vertices[free], spot.moved(insistence)[free]

    # The largest first: threads that are done with others then share its work.
    largest_first = sorted(regions(state.surface, moving), key=lambda found: -len(found[0].inner))
    for vertices, places in map_items(moved, largest_first):
        points[vertices] = places
    return state.onto(state.surface.with_points(points), state.face, state.uv)
