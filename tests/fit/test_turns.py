"""Control edges turn to follow lines of curvature, only where the data come nearer by it."""

import numpy as np
import pytest

from shapes import grids
from subdfit.fit.data import FitData
from subdfit.fit.settings import FitSettings
from subdfit.fit.state import FitState
from subdfit.fit.thinning_apart import Apart
from subdfit.fit.thinning_changes import Polygons
from subdfit.fit.thinning_hold import Hold
from subdfit.fit.thinning_turns import Alignment, Turn
from subdfit.limit.surface import LimitSurface
from subdfit.measure import Tolerance
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.polygon_edits import PolygonEdits
from subdfit.mesh.topology import Topology
from subdfit.target.frame import Frame
from subdfit.target.target import Target, mesh_target

Floats = np.ndarray


def grid(across: int, along: int, arc: float, height: float = 2.0) -> tuple[Floats, Floats]:
    """Points on a part of a cylinder of radius one about the y axis, and its triangles."""
    ends = height / 2
    s, t = (a.ravel() for a in np.meshgrid(np.linspace(-arc, arc, across + 1), np.linspace(-ends, ends, along + 1)))
    triangles = grids.triangles_of(grids.vertices(along + 1, across + 1).T)
    return np.column_stack([np.sin(s), t, np.cos(s)]), triangles


def target_of(points: Floats, triangles: Floats, creases: float | str = "none") -> Target:
    found = mesh_target(points, triangles, creases=creases)
    return found.normalised(Frame.of(found.points))


@pytest.mark.parametrize("angle", [0, 20, 45, 70, 90])
def test_chords_on_a_cylinder(angle: float) -> None:
    """The lines of curvature run along the axis and round it: what matters is the nearer of both."""
    lines = Alignment.of(target_of(*grid(40, 24, 0.5)))
    way = 0.02 * np.array([[np.sin(np.radians(angle)), np.cos(np.radians(angle)), 0.0]])
    middle = lines.target.points[[np.argmin(np.linalg.norm(lines.target.points - [0, 0, 1], axis=1))]]
    assert lines.degrees(middle - way, middle + way) == pytest.approx(min(angle, 90 - angle), abs=2.0)


def test_no_direction_counts_where_the_target_is_flat() -> None:
    points, triangles = grid(10, 10, 0.5)
    lines = Alignment.of(target_of(points * [1, 1, 0], triangles))
    begin, end = lines.target.points[[30, 30, 30]], lines.target.points[[32, 52, 54]]
    np.testing.assert_array_equal(lines.degrees(begin, end), 45.0)


@pytest.mark.parametrize(("creases", "known"), [(30.0, True), ("none", False)])
def test_lines_beside_a_crease_are_those_of_the_same_side(creases: float | str, known: bool) -> None:
    """A cylinder that is cut obliquely, and a wall that stands on the cut: across it lines would turn along the cut."""
    across, along = 40, 24
    points, triangles = grid(across, along, 0.5)
    points[:, 1] += points[:, 0]
    rim = np.arange(across + 1)
    wall = points[rim] + np.array([0.1, 0.2, 0.3, 0.4])[:, None, None] * [0.0, 0.0, 1.0]
    levels = np.concatenate([rim[None], len(points) + np.arange(4 * (across + 1)).reshape(4, -1)])
    all_points = np.concatenate([points, wall.reshape(-1, 3)])
    lines = Alignment.of(
        target_of(all_points, np.concatenate([triangles, grids.triangles_of(levels[::-1].T)]), creases)
    )
    near = Frame.of(all_points).inside(points[rim[5:-5] + across + 1])
    axis = np.array([0.0, 0.005, 0.0])
    assert (lines.degrees(near - axis, near + axis).max() < 3) == known


LOW = 0.6
"""Height of the cylinder that follows."""


def skewed(scheme: str) -> LimitSurface:
    """Six quads in two rows on a low cylinder, an edge between the rows gone round by one."""
    points, _ = grid(3, 2, 0.5, LOW)
    quads = [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [4, 5, 9, 8], [5, 6, 10, 9], [6, 7, 11, 10]]
    frame = Frame.of(grid(40, 24, 0.5, LOW)[0])
    topology = Topology.from_faces(4 * np.arange(7), np.ravel(quads), 12)
    edits = PolygonEdits(ControlMesh(topology, frame.inside(points), scheme))
    edits.turn(5, 6, True)
    return LimitSurface(edits.frozen()[0], scheme)


@pytest.mark.parametrize("scheme", ["catmull-clark", "quad-triangle"])
def test_a_skewed_edge_turns_back(scheme: str) -> None:
    target = target_of(*grid(40, 24, 0.5, LOW))
    surface = skewed(scheme)
    lines, edits = Alignment.of(target), PolygonEdits(surface.control_mesh)
    polygons = Polygons.of(surface.topology, edits, surface.vertex_limits())
    found = [turn for v in range(12) for turn in lines.turns(polygons, v, set())]
    assert found
    for turn in found:
        assert isinstance(turn, Turn)
        assert turn.cost < -10
    best = min(found, key=lambda turn: turn.cost)
    best.make(edits)
    assert 6 in edits.neighbours(5)
    again = LimitSurface(edits.frozen()[0], scheme)
    polygons = Polygons.of(again.topology, edits, again.vertex_limits())
    assert not [turn for v in range(12) for turn in lines.turns(polygons, v, set())]


def test_a_turn_is_kept_only_where_the_data_come_nearer() -> None:
    """An edge may turn back to the lines of curvature; away from them the data would be farther off."""
    target = target_of(*grid(40, 24, 0.5, LOW))
    settings = FitSettings(scheme="catmull-clark", tolerance=Tolerance(max=0.2))
    trials = Apart(Hold(settings))
    data = FitData.of(target, settings.sample_spacing)
    skew = FitState.start(data, skewed("catmull-clark"))
    edits = PolygonEdits(skew.surface.control_mesh)
    (back,) = (turn for turn in (Turn(1, 10, 0.0, way) for way in (True, False)) if 6 in new_ends(edits, turn))
    kept = trials.kept(skew, [back])
    assert kept is not None
    assert kept.state.errors.mean < skew.errors.mean
    edits = PolygonEdits(kept.state.surface.control_mesh)
    assert trials.kept(kept.state, [Turn(5, 6, 0.0, True)]) is None


def new_ends(edits: PolygonEdits, turn: Turn) -> tuple[int, int]:
    """The vertices that a turned edge joins."""
    ring, _ = edits.turned(turn.first, turn.second, turn.forward)
    return ring[0], ring[-1]
