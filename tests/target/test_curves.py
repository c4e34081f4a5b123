"""Chaining edges to curves."""

import numpy as np
import pytest
import trimesh

from shapes import grids
from subdfit.target.curves import boundary_corners, boundary_edges, boundary_loops, curves, directions, zigzag
from subdfit.target.features import crease_edges


def as_set(edges):
    return {tuple(sorted(pair)) for pair in np.asarray(edges).tolist()}


def test_a_ring_is_one_closed_curve_in_its_edges_direction():
    ring = np.array([[3, 1], [1, 4], [4, 0], [0, 3]])
    (curve,) = curves(ring[[2, 0, 3, 1]])
    assert curve.closed
    assert curve.vertices.tolist() == [0, 3, 1, 4]
    assert as_set(curve.edges) == as_set(ring)


def test_a_chain_is_one_open_curve_in_its_edges_direction():
    (curve,) = curves([[5, 2], [9, 5], [2, 7]])
    assert not curve.closed
    assert curve.vertices.tolist() == [9, 5, 2, 7]


def test_mixed_directions_still_make_one_curve():
    (curve,) = curves([[0, 1], [2, 1], [2, 3], [4, 3]])
    assert curve.vertices.tolist() == [0, 1, 2, 3, 4]


def test_curves_split_where_three_meet_and_every_edge_is_used_once():
    edges = [[0, 1], [1, 2], [2, 3], [2, 4], [4, 5], [5, 2]]
    found = curves(edges)
    assert sorted(len(curve.vertices) for curve in found) == [2, 3, 4]
    assert not any(curve.closed for curve in found)
    assert as_set(np.concatenate([curve.edges for curve in found])) == as_set(edges)
    assert sum(len(curve.edges) for curve in found) == len(edges)


def test_directions_are_those_of_the_curve_and_unknown_where_it_turns_back():
    angle = np.linspace(0, 2 * np.pi, 90, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(90)])
    edges = np.column_stack([np.arange(90), np.roll(np.arange(90), -1)])
    assert np.allclose(directions(ring, edges), np.cross([0, 0, 1], ring))
    spike = np.array([[0, 0, 0], [1, 0.1, 0], [0, 0.2, 0], [5, 5, 5]], float)
    assert np.array_equal(np.linalg.norm(directions(spike, np.array([[0, 1], [1, 2]])), axis=1).round(9), [1, 0, 1, 0])


def test_box_creases_are_twelve_curves():
    mesh = trimesh.creation.box().subdivide().subdivide()
    found = curves(crease_edges(mesh.vertices, mesh.faces, 45.0))
    assert len(found) == 12
    assert all(len(curve.edges) == 4 for curve in found)


def test_boundary_of_a_tube_is_two_loops_with_the_faces_on_the_left():
    sections = 12
    rim = np.arange(sections)
    after = np.roll(rim, -1)
    faces = np.concatenate(
        [np.stack([rim, after, after + sections], 1), np.stack([rim, after + sections, rim + sections], 1)]
    )
    loops = boundary_loops(faces)
    assert [curve.closed for curve in loops] == [True, True]
    assert loops[0].vertices.tolist() == rim.tolist()
    assert loops[1].vertices.tolist() == [sections, *range(2 * sections - 1, sections, -1)]
    sides = {tuple(pair) for face in faces.tolist() for pair in zip(face, np.roll(face, -1).tolist(), strict=True)}
    assert {tuple(pair) for pair in boundary_edges(faces).tolist()} <= sides


def test_closed_surfaces_and_no_edges_have_no_curves():
    assert boundary_loops(trimesh.creation.icosphere(1).faces) == []
    assert curves(np.empty((0, 2), int)) == []


@pytest.mark.parametrize(("name", "count"), [("holes", 7), ("plane_holes", 27), ("bunny", 5)])
def test_loops_of_real_models(meshes, name, count):
    mesh = trimesh.load(meshes / f"{name}.ply", process=False)
    loops = boundary_loops(mesh.faces)
    assert len(loops) == count
    assert all(curve.closed for curve in loops)


def ring(count):
    here = np.arange(count)
    return np.column_stack([here, np.roll(here, -1)])


def polygon(corners, parts):
    """A closed polygon whose sides are cut into parts."""
    corners = np.asarray(corners, float)
    t = np.arange(parts)[:, None] / parts
    sides = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    return np.concatenate([a + t * (b - a) for a, b in sides])


@pytest.mark.parametrize("noise", [0.0, 0.003])
@pytest.mark.parametrize(
    "corners", [[(0, 0), (3, 0), (3, 2), (0, 2)], [(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (0, 1)]]
)
def test_corners_of_a_boundary_are_found_and_no_more(corners, noise):
    flat = polygon(corners, 12)
    points = np.column_stack([flat, np.zeros(len(flat))])
    points += noise * np.random.default_rng(3).standard_normal(points.shape)
    for edges in (ring(len(points)), ring(len(points))[:, ::-1]):
        assert boundary_corners(points, edges).tolist() == list(range(0, len(points), 12))


@pytest.mark.parametrize("count", [3, 4, 5, 8, 40])
def test_a_coarse_circle_has_no_corners(count):
    angle = 2 * np.pi * np.arange(count) / count
    points = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)])
    assert len(boundary_corners(points, ring(count))) == 0


def test_a_ragged_boundary_has_no_corners():
    """Of a grid, with cells left out at random."""
    kept = np.random.default_rng(5).random(900) < 0.85
    edges = boundary_edges(grids.cut(grids.quads_of(grids.vertices(31, 31))[kept]))
    points = np.column_stack([*divmod(np.arange(31 * 31), 31), np.zeros(31 * 31)]).astype(float)
    assert len(edges) > 300
    assert len(boundary_corners(points, edges)) == 0


def saw(teeth):
    """A polygon with a row of teeth along its upper side, right to left, between two straight ends."""
    x = np.arange(2 * teeth, -1, -1.0)
    tips = np.column_stack([x, 3 + np.arange(len(x)) % 2])
    return np.concatenate([[(0, 0), (2 * teeth, 0)], tips])


def test_a_zigzag_is_found_where_three_turns_to_each_side_belong_to_it():
    for flat in (saw(8), saw(8)[::-1]):
        points = np.column_stack([flat, np.sin(flat[:, 0] / 9)])
        inner = (flat[:, 1] >= 3) & (np.minimum(flat[:, 0], 16 - flat[:, 0]) >= 4)
        assert zigzag(points, ring(len(points))).tolist() == np.flatnonzero(inner).tolist()


COMB = [(0, 0), (7, 0), *((x, y) for k in (6, 4, 2, 0) for x, y in ((k + 1, 1), (k + 1, 3), (k, 3), (k, 1)))]


@pytest.mark.parametrize("parts", [1, 2, 5])
@pytest.mark.parametrize("corners", [COMB, [(0, 0), (4, 0), (4, 1), (1, 1), (1, 4), (0, 4)]])
def test_corners_of_faces_are_no_zigzag(corners, parts):
    flat = polygon(corners, parts)
    assert len(zigzag(np.column_stack([flat, np.zeros(len(flat))]), ring(len(flat)))) == 0
