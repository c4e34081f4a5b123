"""Where the errors of a state lie on the control mesh, and which sides to halve there."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.fit import _kernels as kernels
from subdfit.fit.places import Places
from subdfit.fit.state import FitState
from subdfit.mesh.polygon_refinement import Sides, faces_by_sides, flat_corners
from subdfit.mesh.topology import Topology

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Rows = NDArray[np.int64]

FLAT = 0.4
"""Share of a side's length that counts as bend: faces are cut across longer sides, unless others bend far more."""
INDUCED = 3
"""Vertices more that it costs to halve a side which is half of the neighbour's: that is then cut as well."""


@dataclass(frozen=True, eq=False)
class Faults:
    """Where a state's errors lie on the control mesh.

    Attributes
    ----------
    maximum : (faces,) the largest excess of the points on each face.
    sums, squares : (faces,) the sums of distances and of squared distances.
    count : (faces,) points.
    """

    maximum: Floats
    sums: Floats
    squares: Floats
    count: Rows

    @classmethod
    def of(cls, state: FitState) -> "Faults":
        """Gather the errors of all points by face."""
        count = state.surface.topology.face_count
        face = Places(state.surface).face[state.face]
        maximum = np.zeros(count)
        kernels.group_maximum(face, state.excess, maximum)
        sums = np.bincount(face, state.distance, minlength=count).astype(np.float64)
        squares = np.bincount(face, state.distance**2, minlength=count).astype(np.float64)
        return cls(maximum, sums, squares, np.bincount(face, minlength=count))


def curve_sides(state: FitState, tolerance: float) -> Flags:
    """Sides, (h,), whose boundary or crease points lie farther from the curve than `tolerance`."""
    marks = np.zeros(len(state.surface.topology.twin), np.bool_)
    for found, curves in zip(state.held, state.curves, strict=True):
        if found is None or curves is None:
            continue
        worst = np.zeros(len(curves))
        np.maximum.at(worst, found.side, found.distance)
        far = np.flatnonzero(worst > tolerance)
        marks[Places(state.surface).side[curves.cell[far], curves.side[far]]] = True
    return marks


def all_sides(state: FitState, faces: Rows) -> Flags:
    """All sides of the given faces, (h,)."""
    t = state.surface.topology
    chosen = np.zeros(t.face_count, np.bool_)
    chosen[faces] = True
    return np.asarray(chosen[t.face])


def cutting_sides(state: FitState, faces: Rows) -> Flags:
    """Sides, (h,), that cut each given face in two across its greater extent.

    A triangle's longest side; the two opposite sides of a quad that bend the most, or the one opposite to a side that
    is halved already. Other polygons, and triangles among them, are cut at all sides.
    """
    surface, t = state.surface, state.surface.topology
    marks = np.zeros(len(t.twin), np.bool_)
    chosen = np.zeros(t.face_count, np.bool_)
    chosen[faces] = True
    flat = flat_corners(surface.control_mesh)
    for group in faces_by_sides(t, flat):
        rows = chosen[group.faces]
        part = Sides(group.faces[rows], group.first[rows], group.second[rows])
        if group.count == 3 and surface.scheme.faces != "polygons":
            marks[_longest(state, part)] = True
        elif group.count == 4:
            marks[_across(state, part, flat | flat[t.following])] = True
        else:
            marks[part.first[part.second < 0]] = True
    return marks


def within_budget(state: FitState, marks: Flags, faces: Rows, budget: int | None) -> Flags:
    """Drop marks of sides, (h,), all but those of the first of the faces, where they exceed the budget of vertices."""
    if budget is None:
        return marks
    topology = state.surface.topology
    room = budget - topology.vertex_count
    if room <= 0:
        return np.zeros_like(marks)
    if np.count_nonzero(marks) <= room:
        return marks
    cost = np.bincount(topology.face, marks, minlength=topology.face_count)
    return marks & all_sides(state, faces[np.cumsum(cost[faces]) <= room])


def _longest(state: FitState, part: Sides) -> Rows:
    corners = Places(state.surface).vertices()[state.surface.topology.face_vertices[part.first]]
    length = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    return np.asarray(part.first[np.arange(len(length)), length.argmax(axis=1)])


def _across(state: FitState, part: Sides, half: Flags) -> Rows:
    """The opposite sides of each quad that bend most for the vertices they cost; `half` says which are half a side."""
    places, t = Places(state.surface), state.surface.topology
    corners = places.vertices()[t.face_vertices[part.first]]
    ahead = np.roll(corners, -1, axis=1)
    middle = places.middles(part.first.ravel()).reshape(-1, 4, 3)
    bend = np.linalg.norm(middle - (corners + ahead) / 2, axis=2) + FLAT * np.linalg.norm(ahead - corners, axis=2)
    twin = t.twin[part.first]
    cost = 1 + INDUCED * ((twin >= 0) & half[twin])
    gain = (bend + np.roll(bend, 2, axis=1)) / (cost + np.roll(cost, 2, axis=1))
    halved = part.halved
    opposite, best = np.roll(halved, 2, axis=1), gain >= np.roll(gain, 1, axis=1)
    wanted: Flags = np.where(np.any(halved, axis=1, keepdims=True), opposite, best)
    return part.first[wanted & ~halved]


def large_enough(state: FitState, faces: Rows) -> Rows:
    """Those of the given faces whose longest side exceeds the data's own spacing: finer ones would follow nothing."""
    return np.asarray(faces[_longest_edge(state.surface.topology, state)[faces] > state.data.spacing])


def _longest_edge(t: Topology, state: FitState) -> Floats:
    points = state.surface.control_mesh.points
    length = np.linalg.norm(points[t.face_vertices[t.following]] - points[t.face_vertices], axis=1)
    return np.asarray(np.maximum.reduceat(length, t.face_offsets[:-1]))
