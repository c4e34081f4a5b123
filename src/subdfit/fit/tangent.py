"""Tangent-distance minimisation with Levenberg-style damping: the step of the method ``tangent``.

Each data point pulls its footpoint along the surface normal, weakly along the tangent plane (Blake and Isard 1998;
Pottmann and Leopoldseder 2003); points on curves pull across the curve. A step is kept only if the true errors, with
new footpoints, are smaller.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.closest.curves import CurveProjection
from subdfit.fit import _kernels as kernels
from subdfit.fit.reverse import TOUCHING, CurveSamples, Samples
from subdfit.fit.state import FitState
from subdfit.fit.system import Rows, System

Floats = NDArray[np.float64]

MOST_PULL = 300.0
"""A sample far off weighs at most this many times one that is near."""

ENDED = 0.5
"""Share of a gap along the curve from which the curve is taken to end there."""

INNER = 0.99
"""A point nearer to the surface than this share of its distance from the boundary curve lies inside the curve."""


@dataclass(frozen=True)
class TangentSettings:
    """Weights of the step.

    Attributes
    ----------
    tangential : share of a point's pull that acts along the tangent plane.
    curve_weight : weight of a point on a curve against one on the surface.
    enclosed : share of that weight for a point at a cloud's ragged boundary that lies on the surface already.
    fairness : weight of the displacement's Laplacian, against the mean weight of a control vertex.
    relaxation : weight that draws vertices within the tangent plane to the middle of their neighbours: without it they
        slide until the surface folds.
    robust : distance beyond which a point's pull grows no more (Huber 1964).
    reverse_weight : weight of the samples of faces with few data points, drawn to the target.
    curve_reverse : weight of the samples of curves with few data points, drawn to the target's curves.
    damping : the first Levenberg damping, against each control vertex's own weight.
    """

    tangential: float = 0.01
    curve_weight: float = 4.0
    enclosed: float = 0.02
    fairness: float = 1e-3
    relaxation: float = 1e-3
    robust: float = np.inf
    reverse_weight: float = 0.03
    curve_reverse: float = 1.0
    damping: float = 1e-3


def tangent_system(state: FitState, settings: TangentSettings, reverse: list[Rows], free: NDArray[np.bool_]) -> System:
    """The system of one step from `state`.

    The `reverse` terms are added to those of the data; vertices that are not `free`, (n,), stay.
    """
    rows = [surface_rows(state, settings), *curve_rows(state, settings), *reverse]
    return System(state.surface, rows, settings.fairness, settings.relaxation, free)


def surface_rows(state: FitState, settings: TangentSettings) -> Rows:
    """Rows of the points inside the surface, sorted by face."""
    keep = np.flatnonzero(state.data.surface_rows)
    order = keep[np.argsort(state.face[keep], kind="stable")]
    face, uv = np.ascontiguousarray(state.face[order]), np.ascontiguousarray(state.uv[order])
    value = state.surface.evaluate(face, uv, 2)
    assert value.first is not None
    assert value.second is not None
    metric = np.empty((len(order), 6))
    residual = state.data.points[order] - value.position
    distance = np.linalg.norm(residual, axis=1)
    # A sample inside a face pulls by what exceeds its allowance: the facet is not the surface.
    beyond = np.maximum(distance - state.data.allowance[order], 0.0)
    residual *= np.divide(beyond, distance, out=np.zeros_like(distance), where=distance > 0)[:, None]
    kernels.squared_distance_metric(value.first, value.second, distance, settings.tangential, metric)
    if settings.robust < np.inf:
        metric *= (settings.robust / np.maximum(beyond, settings.robust))[:, None]
    return Rows(*state.surface.patch_weights(face, uv), metric, residual)


def curve_rows(state: FitState, settings: TangentSettings) -> list[Rows]:
    """Rows of the points on boundary and crease curves."""
    found = []
    for curve, rows in ((state.boundary, state.data.boundary), (state.crease, state.data.crease)):
        if curve is not None:
            found.append(_curve_rows(state, curve, rows, settings))
    return found


def reverse_rows(state: FitState, settings: TangentSettings, samples: Samples, bound: float, insistence: float) -> Rows:
    """Rows that draw samples of the surface to what the target's faceting allows."""
    weight = insistence * pull(samples.gap, settings, bound)
    metric = _direction_metric(samples.normal, weight, settings.tangential)
    residual = samples.gap[:, None] * samples.normal
    return Rows(*state.surface.patch_weights(samples.face, samples.uv), metric, residual)


def curve_reverse_rows(state: FitState, settings: TangentSettings, samples: CurveSamples) -> Rows:
    """Rows that draw samples of the surface's curves to the target's."""
    metric = _direction_metric(samples.along, settings.curve_reverse * settings.tangential, 1 / settings.tangential)
    return Rows(*state.surface.patch_weights(samples.face, samples.uv), metric, samples.gaps(state.surface))


def pull(gaps: Floats, settings: TangentSettings, bound: float) -> Floats:
    """Weight of each sample: it rises steeply, a barrier, from gaps of half of `bound` on, up to `MOST_PULL` times."""
    return np.asarray(settings.reverse_weight * np.clip((2 * gaps / bound) ** 4, 1.0, MOST_PULL))


def _direction_metric(d: Floats, along: Floats | float, across: float) -> Floats:
    """Quadratic forms ``along`` d d^T + ``along across`` (I - d d^T) of unit vectors d (k, 3), as (k, 6)."""
    weight = np.broadcast_to(along, len(d))[:, None]
    metric = weight * (1 - across) * np.column_stack([d[:, :1] * d, d[:, 1:2] * d[:, 1:], d[:, 2:] * d[:, 2:]])
    metric[:, [0, 3, 5]] += weight * across
    return metric


def _curve_rows(state: FitState, curve: CurveProjection, rows: NDArray[np.int64], settings: TangentSettings) -> Rows:
    residual = state.data.points[rows] - curve.position
    metric = _direction_metric(curve.tangent, settings.tangential, 1 / settings.tangential)
    # Only where a curve ends does a gap run along it: the end is to follow, in all directions.
    along = np.abs(np.einsum("kd,kd->k", residual, curve.tangent))
    metric[along > ENDED * np.maximum(curve.distance, TOUCHING)] = [1, 0, 0, 1, 0, 1]
    metric *= curve_weights(state, curve, rows, settings)[:, None]
    return Rows(*state.surface.patch_weights(curve.face, curve.uv), metric, residual)


def huber(distance: Floats, scale: float) -> Floats:
    """Squares of distances up to a scale, and beyond it lines that go on from them (Huber 1964)."""
    near = np.minimum(distance, scale)
    return np.asarray(near * (2 * distance - near))


def curve_weights(
    state: FitState, curve: CurveProjection, rows: NDArray[np.int64], settings: TangentSettings
) -> Floats:
    """Weight of each point on a curve: the surface is to enclose the ragged boundary of a cloud, not to halve it."""
    weight = np.full(len(rows), settings.curve_weight)
    if state.data.target.cloud and curve is state.boundary:
        weight[state.distance[rows] < INNER * curve.distance] *= settings.enclosed
    return weight


def merit(
    state: FitState,
    samples: Samples,
    on_curves: list[CurveSamples],
    settings: TangentSettings,
    bound: float,
    insistence: float,
) -> float:
    """The energy that decides whether a step is kept: weighted squares of all distances, footpoints being new."""
    inside = huber(np.maximum(state.excess[state.data.surface_rows], 0.0), settings.robust)
    curves = sum(
        np.sum(curve_weights(state, curve, rows, settings) * curve.distance**2)
        for curve, rows in ((state.boundary, state.data.boundary), (state.crease, state.data.crease))
        if curve is not None
    )
    between = sum(settings.curve_reverse * float(np.sum(found.gaps(state.surface) ** 2)) for found in on_curves)
    strayed = insistence * np.sum(pull(samples.gap, settings, bound) * samples.gap**2)
    return float(np.sum(inside) + curves + between + strayed)
