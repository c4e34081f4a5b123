"""Polygons become triangles that cover them and nothing else."""

import numpy as np
import pytest

from shapes.zoo import euler
from subdfit.api.sources import source_of
from subdfit.api.triangulate import triangles_of
from subdfit.mesh.topology import Topology


def cut(points, faces):
    return triangles_of(source_of((np.array(points, float), faces)).data)


def areas(points, triangles):
    a, b, c = np.asarray(points, float)[triangles].transpose(1, 0, 2)
    return np.cross(b - a, c - a)[:, 2] / 2


def test_a_quad_is_cut_along_its_shorter_diagonal():
    triangles = cut([[0, 0, 0], [3, 0, 0], [4, 1, 0], [1, 1, 0]], [[0, 1, 2, 3]])
    assert all({1, 3} <= set(row) for row in triangles.tolist())


def test_a_concave_quad_is_cut_inside():
    points = [[0, 0, 0], [2, -1, 0], [0.5, 0, 0], [2, 1, 0]]
    found = areas(points, cut(points, [[0, 1, 2, 3]]))
    assert (found > 0).all()
    assert found.sum() == pytest.approx(0.5)


@pytest.mark.parametrize("turned", [False, True])
def test_a_comb_is_covered_once(turned):
    outline = [(0, 0), (7, 0), (7, 5), (6, 5), (6, 1), (4, 1), (4, 5), (3, 5), (3, 1), (1, 1), (1, 5), (0, 5)]
    points = [(x, y, 0) for x, y in (outline[::-1] if turned else outline)]
    found = areas(points, cut(points, [list(range(len(points)))])) * (-1 if turned else 1)
    assert len(found) == 10
    assert (found > 0).all()
    assert found.sum() == pytest.approx(7 * 1 + 3 * 4)


def test_a_cap_of_thousands_of_corners_is_covered_once():
    """A gear of 2,500 corners: looking at every corner for each ear of every step would take minutes."""
    angle = 2 * np.pi * np.arange(2500) / 2500
    radius = 1 + 0.2 * np.cos(31 * angle)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle])
    found = areas(points, cut(points, [list(range(2500))]))
    assert len(found) == 2498
    assert (found > 0).all()
    following = np.roll(points, -1, axis=0)
    assert found.sum() == pytest.approx(np.cross(points, following)[:, 2].sum() / 2, rel=1e-12)


def test_corners_on_a_straight_side_give_no_triangle_without_area():
    """Thirds are rounded, but alike on the diagonal, where any three corners are on one line in floats too."""
    outline = [(k / 3, k / 3) for k in range(10)] + [(0, 6), (-3, 3)]
    points = [(x, y, 0) for x, y in outline]
    assert (areas(points, cut(points, [list(range(len(points)))])) > 1e-6).all()


def test_a_closed_polyhedron_stays_a_closed_manifold(sphere):
    angles = 2 * np.pi * np.arange(9) / 9
    ring = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    points = np.concatenate([ring, ring + np.array([0, 0, 1])])
    sides = [[i, (i + 1) % 9, 9 + (i + 1) % 9, 9 + i] for i in range(9)]
    triangles = cut(points, [list(range(8, -1, -1)), list(range(9, 18)), *sides])
    topology = Topology.from_triangles(triangles, 18)
    assert (topology.twin >= 0).all()
    assert euler(topology) == 2


def test_no_diagonal_doubles_an_edge():
    """Two quads over the same corners: their shorter diagonal can be used once only."""
    points = [[0, 0, 0], [3, 0, 0], [4, 1, 0], [1, 1, 0]]
    triangles = cut(points, [[0, 1, 2, 3], [3, 2, 1, 0]])
    topology = Topology.from_triangles(triangles, 4)
    assert (topology.face_count, topology.edge_count) == (4, 6)


def test_triangles_stay_as_they_are(sphere):
    np.testing.assert_array_equal(cut(*sphere), sphere[1])
