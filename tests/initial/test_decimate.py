"""Laws of decimation: topology, curves and corners stay; the error is small; the result does not wander."""

import initial_laws as laws
import numpy as np
import pytest

from subdfit.errors import InputError
from subdfit.initial import decimate, fill_holes, keep_components
from subdfit.initial.decimate import Decimation

SMALL = {
    "tetrahedron": (laws.tetrahedron(), 4),
    "octahedron": (laws.octahedron(), 4),
    "sphere": (laws.sphere(3), 4),
    "annulus": (laws.annulus(4, 12), 6),
    "disc": (laws.fan(7), 3),
    "wide disc": (laws.fan(15), 3),
    "square": (laws.square(7), 3),
    "two triangles": (laws.two_triangles(), 3),
    "one triangle": ((np.eye(3), np.array([[0, 1, 2]])), 3),
}


def both(first, second):
    """Two meshes side by side as one."""
    (p, t), (q, s) = first, second
    return np.concatenate([p, q + 5.0]), np.concatenate([t, s + len(p)])


@pytest.mark.parametrize("name", SMALL)
def test_small_shapes_reach_the_least_count_their_topology_allows(name):
    (points, triangles), least = SMALL[name]
    before = laws.shape_of(len(points), triangles)
    result = decimate(points, triangles, 3)
    assert laws.shape_of(len(result.points), result.triangles) == before
    assert len(result.points) == least
    assert result.reached == (least == 3)
    assert (result.message is None) == result.reached


def test_torus_keeps_its_handle():
    points, triangles = laws.torus(24, 12)
    result = decimate(points, triangles, 3)
    assert laws.shape_of(len(result.points), result.triangles) == laws.Shape(1, 0, 0)
    assert 7 <= len(result.points) <= 12
    assert not result.reached
    assert str(len(result.points)) in result.message


def test_every_component_survives():
    points, triangles = both(both(laws.sphere(2), laws.torus(12, 8)), laws.square(6))
    before = laws.shape_of(len(points), triangles)
    result = decimate(points, triangles, 3)
    assert laws.shape_of(len(result.points), result.triangles) == before


@pytest.mark.parametrize("target", [500, 258, 257, 100, 33, 12, 5, 4])
def test_target_is_met_exactly(target):
    points, triangles = laws.sphere(3)
    result = decimate(points, triangles, target)
    assert result.reached
    assert result.message is None
    assert len(result.points) == min(target, len(points))


def test_target_above_the_count_leaves_the_mesh_alone():
    points, triangles = laws.torus(9, 7)
    result = decimate(points, triangles, 1000)
    np.testing.assert_allclose(result.points, points, atol=1e-14)
    np.testing.assert_array_equal(result.triangles, triangles)
    assert result.points.flags.c_contiguous


def test_error_on_a_sphere_falls_with_the_number_of_vertices():
    points, triangles = laws.sphere(5)
    errors = []
    for target in (32, 128, 512):
        result = decimate(points, triangles, target)
        a, b, c = (result.points[result.triangles[:, i]] for i in range(3))
        errors.append(np.abs(np.linalg.norm((a + b + c) / 3, axis=1) - 1).mean())
    rates = np.log(np.divide(errors[:-1], errors[1:])) / np.log(4)
    assert (rates > 0.9).all(), rates
    assert (rates < 1.25).all(), rates


def test_weights_of_eight_leave_twice_the_vertices():
    points, triangles = laws.sphere(5)
    upper = points[:, 2] > 0
    even, uneven = (decimate(points, triangles, 600, weights=np.where(upper, w, 1.0)) for w in (1.0, 8.0))
    shares = [np.mean(result.points[:, 2] > 0) for result in (even, uneven)]
    assert shares[0] == pytest.approx(1 / 2, abs=0.03)
    assert shares[1] == pytest.approx(2 / 3, abs=0.03)


def test_faces_point_outwards_still():
    points, triangles = laws.sphere(4)
    for target in (400, 60, 8):
        result = decimate(points, triangles, target)
        centres = result.points[result.triangles].mean(axis=1)
        assert (np.sum(laws.normals(result.points, result.triangles) * centres, axis=1) > 0).all()


def test_planar_mesh_keeps_its_plane_outline_and_orientation():
    points, triangles = laws.square(25)
    corners = np.array([0, 24, 600, 624])
    result = decimate(points, triangles, 40, corners=corners)
    assert result.reached
    np.testing.assert_array_equal(result.points[:, 2], 0)
    np.testing.assert_allclose(result.points[result.corners], points[corners], atol=1e-14)
    areas = laws.normals(result.points, result.triangles)[:, 2]
    assert (np.sign(areas) == np.sign(laws.normals(points, triangles)[0, 2])).all()
    assert abs(areas.sum()) == pytest.approx(2 * (24 / 25) ** 2, rel=1e-7)


def test_valence_stays_within_the_limit():
    points, triangles = laws.sphere(4)
    for most in (7, 8, 10):
        result = decimate(points, triangles, 150, max_valence=most)
        assert result.reached
        assert np.bincount(result.triangles.ravel()).max() <= most


def test_scale_and_place_do_not_matter():
    points, triangles = laws.torus(24, 12)
    result = decimate(points, triangles, 60)
    for factor, shift in ((2.0**-40, 0.0), (2.0**40, 0.0), (1024.0, 2.0**20)):
        moved = decimate(points * factor + shift, triangles, 60)
        assert laws.shape_of(60, moved.triangles) == laws.Shape(1, 0, 0)
        if shift == 0.0:
            np.testing.assert_array_equal(moved.triangles, result.triangles)
            np.testing.assert_allclose(moved.points / factor, result.points, rtol=1e-12, atol=1e-14)


def test_input_is_not_touched_and_result_is_the_same_twice():
    points, triangles = laws.torus(24, 12)
    kept = points.copy(), triangles.copy()
    first = decimate(points, triangles.astype(np.int32), 70)
    second = decimate(points, triangles, 70)
    np.testing.assert_array_equal(points, kept[0])
    np.testing.assert_array_equal(triangles, kept[1])
    np.testing.assert_array_equal(first.points, second.points)
    np.testing.assert_array_equal(first.triangles, second.triangles)


@pytest.mark.parametrize("target", [300, 60, 3])
def test_closed_crease_and_dart_survive(target):
    points, triangles = laws.sphere(3)
    equator = np.flatnonzero(np.abs(points[:, 2]) < 1e-12)
    order = equator[np.argsort(np.arctan2(points[equator, 1], points[equator, 0]))]
    dart = np.flatnonzero((np.abs(points[:, 0]) < 1e-12) & (points[:, 1] > 0.1) & (points[:, 2] > 0.1))
    dart = dart[np.argsort(points[dart, 2])]
    creases = np.concatenate([np.stack([order, np.roll(order, 1)], axis=1), np.stack([dart[:-1], dart[1:]], axis=1)])
    before = laws.chains(points, triangles, creases)
    result = decimate(points, triangles, target, crease_edges=creases)
    assert laws.chains(result.points, result.triangles, result.crease_edges) == before
    assert laws.shape_of(len(result.points), result.triangles) == laws.Shape(1, 0, 2)
    on_equator = np.abs(result.points[np.unique(result.crease_edges), 2]) < 0.05
    assert on_equator.sum() >= 3


def test_crease_that_meets_the_boundary_holds_its_ends():
    points, triangles = laws.square(15)
    middle = 7 * 15 + np.arange(15)
    creases = np.stack([middle[:-1], middle[1:]], axis=1)
    result = decimate(points, triangles, 5, crease_edges=creases)
    joined, cycles = laws.chains(result.points, result.triangles, result.crease_edges)
    assert (joined, cycles) == laws.chains(points, triangles, creases)
    assert sum(joined.values()) == 2, "one chain, walked from either end"
    np.testing.assert_allclose(result.points[np.unique(result.crease_edges), 0], points[middle[0], 0], atol=1e-9)


def test_corners_stay_in_place_even_where_that_misses_the_target():
    points, triangles = laws.sphere(3)
    corners = np.arange(0, len(points), 7)
    result = decimate(points, triangles, 4, corners=corners)
    assert not result.reached
    assert len(result.points) >= len(corners)
    np.testing.assert_allclose(result.points[result.corners], points[corners], atol=1e-13)


@pytest.mark.parametrize("name", ["bunny", "holes", "plane_holes", "blade", "casting", "mech-holes-shark"])
def test_real_models_keep_their_topology(meshes, name):
    points, triangles = laws.read(meshes, name)
    before = laws.shape_of(len(points), triangles)
    for target in (len(points) // 20, 3):
        result = decimate(points, triangles, target)
        assert laws.shape_of(len(result.points), result.triangles) == before
        if before.loops:
            assert laws.loop_lengths(result.triangles)[0] >= 3
        if target > 3:
            assert result.reached
            assert np.bincount(result.triangles.ravel()).max() <= max(10, np.bincount(triangles.ravel()).max())


def test_creases_of_the_fandisk_are_carried_over(meshes):
    points, triangles = laws.read(meshes, "fandisk")
    creases = laws.sharp_edges(points, triangles, 40)
    before = laws.chains(points, triangles, creases)
    for target in (600, 130, 3):
        result = decimate(points, triangles, target, crease_edges=creases)
        assert laws.shape_of(len(result.points), result.triangles) == laws.Shape(1, 0, 2)
        assert laws.chains(result.points, result.triangles, result.crease_edges) == before


def test_dragon_is_cleaned_and_decimated(meshes):
    kept = keep_components(*laws.read(meshes, "dragon"), 1)
    filled = fill_holes(kept.points, kept.triangles, 50)
    result = decimate(filled.points, filled.triangles, 4091)
    assert len(result.points) == 4091
    assert laws.shape_of(4091, result.triangles) == laws.Shape(1, filled.left, -90 - filled.left)


def test_surface_stays_as_close_as_the_reference_decimation(meshes):
    igl = pytest.importorskip("igl")
    for name in ("bunny", "rocker-arm", "fandisk"):
        points, triangles = laws.read(meshes, name)
        result = decimate(points, triangles, len(points) // 50)
        reference, faces, _, _ = igl.qslim(points, triangles.astype(np.int32), len(result.triangles))
        assert len(faces) <= len(result.triangles)
        ours, _, _ = igl.point_mesh_squared_distance(points, result.points, result.triangles)
        theirs, _, _ = igl.point_mesh_squared_distance(
            points, np.ascontiguousarray(reference), np.ascontiguousarray(faces)
        )
        assert np.sqrt(ours.mean()) <= 1.1 * np.sqrt(theirs.mean()), name


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"target": 2}, "at least 3"),
        ({"max_valence": 5}, "max_valence"),
        ({"corners": [99]}, "corner"),
        ({"weights": [1.0, 2.0]}, "6 positive numbers"),
        ({"weights": [1, 1, 1, 1, 1, 0]}, "6 positive numbers"),
        ({"crease_edges": [[0, 5]]}, "crease"),
        ({"points": np.full((6, 3), np.nan)}, "not finite"),
        ({"points": np.zeros((6, 2))}, "shape"),
        ({"triangles": [[0, 1, 2], [0, 1, 5]]}, "edge"),
    ],
)
def test_bad_input_is_refused_in_one_line(change, words):
    points, triangles = laws.octahedron()
    change = {"points": points, "triangles": triangles, "target": 5} | change
    if "crease_edges" in change:
        change["crease_edges"] = [[0, 3]]
    with pytest.raises(InputError, match=words) as caught:
        decimate(**change)
    assert "\n" not in str(caught.value)


def test_a_decimation_that_stops_on_the_way_ends_as_one_that_does_not():
    points, triangles = laws.sphere(4)
    points = points * (1 + 0.1 * np.sin(7 * points[:, :1]))
    decimation = Decimation(points, triangles)
    half = decimation.down_to(1000)
    end, straight = decimation.down_to(100), decimate(points, triangles, 100)
    assert len(half.points) == 1000
    np.testing.assert_array_equal(end.points, straight.points)
    np.testing.assert_array_equal(end.triangles, straight.triangles)
