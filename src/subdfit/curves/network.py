"""A network of curves with control points: every arc is fitted once, and shared by the patches on both sides."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.curves.fitting import fit_curve, fit_with
from subdfit.curves.polyline import Polyline
from subdfit.curves.subdivision_curve import SubdivisionCurve
from subdfit.target.curves import curves
from subdfit.target.network import Arc

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_AHEAD = 3
"""Edges from which the direction in which an arc leaves a node is taken."""
_STRAIGHT = np.cos(np.radians(40.0))
"""Arcs that turn by less where they meet go on straight."""
_EDGES = 4
"""Edges of the mesh a control segment, at least: more control points would follow the tessellation."""
_FEWEST_ROUND = 3
"""Segments of an arc that is closed, or ends where it begins."""


@dataclass(frozen=True)
class ControlNetwork:
    """Control points of all arcs of a network.

    Attributes
    ----------
    points, limits : (n, 3) float64, the control points and where they go in the limit of their curves.
    chains : of each arc the rows of its control points, first to last; a closed arc does not repeat its first.
    places : of each arc the lengths along it, as shares of the whole, at which its control points' limits lie.
    nodes : (k,) int64, the vertices at which arcs end: their control points are the first k.
    """

    points: Floats
    limits: Floats
    chains: tuple[Indices, ...]
    places: tuple[Floats, ...]
    nodes: Indices


def sharp_vertices(points: Floats, edges: Indices) -> Indices:
    """Vertices at which chains of edges turn sharply."""
    found = [np.empty(0, np.int64)]
    for curve in curves(edges):
        chain = Polyline(points[curve.vertices], curve.closed)
        found.append(curve.vertices[chain.sharp_points()])
    return np.unique(np.concatenate(found))


def bent_nodes(points: Floats, arcs: Sequence[Arc]) -> Indices:
    """Nodes at which two sharp arcs meet, and no more, in a corner: what goes on straight there may stay smooth."""
    ways: dict[int, list[Floats]] = {}
    for arc in arcs:
        if arc.sharp and not arc.closed:
            for chain in (arc.vertices, arc.vertices[::-1]):
                way = points[chain[min(_AHEAD, len(chain) - 1)]] - points[chain[0]]
                ways.setdefault(int(chain[0]), []).append(way / max(float(np.linalg.norm(way)), 1e-300))
    pairs = {node: met for node, met in ways.items() if len(met) == 2}
    return np.array([node for node, (one, other) in sorted(pairs.items()) if one @ other > -_STRAIGHT], np.int64)


def fit_network(points: Floats, arcs: Sequence[Arc], tolerance: float) -> ControlNetwork:
    """Fit every arc by the fewest control points that meet a tolerance; nodes stay where they are.

    Parameters
    ----------
    points : of the mesh.
    arcs : of a network. Those that are not exact run along edges of the mesh, in steps, and are fitted no closer than
        these are long.
    tolerance : largest distance, in the points' unit.
    """
    ends = [arc.vertices[[0, -1]] for arc in arcs if not arc.closed]
    nodes = np.unique(np.concatenate([np.empty(0, np.int64), *ends]))
    positions, limits, chains, places = [points[nodes]], [points[nodes]], [], []
    joined: set[tuple[int, int]] = set()
    count = len(nodes)
    for arc in arcs:
        tips = np.searchsorted(nodes, arc.vertices[[0, -1]]) if not arc.closed else np.empty(0, np.int64)
        curve, shares = _fit(points, arc, tolerance, _fewest(tips, joined))
        inner = slice(None) if arc.closed else slice(1, -1)
        fresh = count + np.arange(len(curve.points[inner]))
        count += len(fresh)
        chains.append(np.concatenate([tips[:1], fresh, tips[1:]]))
        if len(chains[-1]) == 2:
            joined.add(_pair(tips))
        positions.append(curve.points[inner])
        limits.append(curve.limit_points()[inner])
        places.append(shares)
    return ControlNetwork(np.concatenate(positions), np.concatenate(limits), tuple(chains), tuple(places), nodes)


def _fit(points: Floats, arc: Arc, tolerance: float, fewest: int) -> tuple[SubdivisionCurve, Floats]:
    """The curve of an arc, and where its control points' limits lie along the arc."""
    target = Polyline(points[arc.vertices], arc.closed)
    bound = tolerance if arc.exact else max(tolerance, float(np.median(target.lengths)))
    most = max(len(target.points) // _EDGES, 4)
    curve = fit_curve(target, bound, most=most, quick=True).curve
    return _placed(target, curve if len(curve.points) >= fewest else fit_with(target, fewest).curve)


def _fewest(tips: Indices, joined: set[tuple[int, int]]) -> int:
    """Control points that an arc between two nodes needs so that no two control edges join the same points."""
    if len(tips) == 0:
        return _FEWEST_ROUND
    if tips[0] == tips[1]:
        return _FEWEST_ROUND + 1
    return 3 if _pair(tips) in joined else 2


def _pair(tips: Indices) -> tuple[int, int]:
    return int(tips.min()), int(tips.max())


def _placed(target: Polyline, curve: SubdivisionCurve) -> tuple[SubdivisionCurve, Floats]:
    """Shares of the arc at which limits lie, in order; a closed curve is turned to begin with the least."""
    shares = target.closest(curve.limit_points())[0] / max(target.total, 1e-300)
    if curve.closed:
        first = int(np.argmin(shares))
        curve, shares = SubdivisionCurve(np.roll(curve.points, -first, axis=0), True), np.roll(shares, -first)
    else:
        shares[0], shares[-1] = 0.0, 1.0
    return curve, np.maximum.accumulate(shares)
