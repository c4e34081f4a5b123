"""Subdivision curves: their laws, and fits against curves that are known."""

import numpy as np
import pytest
import trimesh

import subdfit
from shapes.chains import circle, clothoid, damped_wave, ellipse, outline
from subdfit.curves.fitting import fit_curve, fit_with, knots_removed, minimise, placed_by_curvature, two_sided_error
from subdfit.curves.geometric import displacements, fit_geometric, inserted
from subdfit.curves.loops import fit_loop
from subdfit.curves.polyline import Polyline
from subdfit.curves.squared_distance import tangential_weights
from subdfit.curves.subdivision_curve import SubdivisionCurve
from subdfit.errors import InputError
from subdfit.target.curves import boundary_loops

RANDOM = np.random.default_rng(4)
CURVES = [SubdivisionCurve(RANDOM.normal(size=(n, 3)), closed) for n in (3, 4, 7) for closed in (False, True)]


@pytest.mark.parametrize("curve", CURVES, ids=lambda c: f"{len(c.points)}{'closed' if c.closed else 'open'}")
def test_refinement_keeps_the_curve(curve):
    t = np.linspace(0, curve.length, 33)[:-1]
    np.testing.assert_allclose(curve.refined().evaluate(2 * t), curve.evaluate(t), atol=1e-14)
    np.testing.assert_allclose(curve.weights(t).sum(axis=1), 1, atol=1e-14)


@pytest.mark.parametrize("curve", CURVES, ids=lambda c: f"{len(c.points)}{'closed' if c.closed else 'open'}")
def test_derivatives_agree_with_differences(curve):
    t = np.linspace(0.05, curve.length - 0.05, 40) + 1e-3
    t = t[np.abs(t - np.round(t)) > 0.01]
    for order in (0, 1, 2):
        difference = (curve.evaluate(t + 1e-5, order) - curve.evaluate(t - 1e-5, order)) / 2e-5
        np.testing.assert_allclose(curve.evaluate(t, order + 1), difference, atol=1e-8)


def test_limit_mask_is_that_of_the_cubic_spline():
    curve = CURVES[5]
    neighbours = np.roll(curve.points, 1, axis=0) + np.roll(curve.points, -1, axis=0)
    np.testing.assert_allclose(curve.limit_points(), (4 * curve.points + neighbours) / 6, atol=1e-15)
    open_ = CURVES[4]
    np.testing.assert_allclose(open_.limit_points()[[0, -1]], open_.points[[0, -1]], atol=1e-15)


def test_the_boundary_of_a_loop_surface_is_this_curve():
    n = 7
    rim = np.random.default_rng(0).normal(size=(n, 3))
    fan = [[n, k, (k + 1) % n] for k in range(n)]
    surface = subdfit.LimitSurface(subdfit.ControlMesh.from_triangles(np.vstack([rim, [[0, 0, 0]]]), fan))
    t = np.linspace(0, 1, 9)
    for k in range(n):  # the side from corner 1 to corner 2 of face k
        found = surface.evaluate(np.full(9, k), np.stack([1 - t, t], 1)).position
        np.testing.assert_allclose(found, SubdivisionCurve(rim, closed=True).evaluate(k + t), atol=1e-12)


def test_weights_of_the_squared_distance_to_a_circle():
    """Second differences of the true squared distance, inside, outside and far outside, against eq. 1 corrected."""
    rho = 2.0
    for d in (-1.5, -0.5, 0.7, 3.0):  # towards the centre is positive
        radial, h = rho - d, 1e-4
        squared = [(np.hypot(radial, x) - rho) ** 2 for x in (-h, 0, h)]
        true = (squared[0] - 2 * squared[1] + squared[2]) / (2 * h * h)
        signed = tangential_weights(d, rho, signed=True)
        assert signed == pytest.approx(np.clip(d / (d - rho), 0, 1))
        if d < 0:
            assert signed == pytest.approx(true, rel=1e-3)
            assert tangential_weights(d, rho) == pytest.approx(true, rel=1e-3)
    assert tangential_weights(1.0, np.inf) == 0.0
    assert tangential_weights(1.0, 0.0) == tangential_weights(0.0, 0.0) == 1.0
    assert tangential_weights(1.0, 1.0, signed=True) == 1.0


def test_curvature_and_arc_length_of_a_circle():
    target = circle(400, 2.0)
    s = np.linspace(0, target.total, 50)
    bend, tangent = target.curvature(s, 0.5)
    np.testing.assert_allclose(np.linalg.norm(bend, axis=1), 0.5, rtol=0.01)
    np.testing.assert_allclose(np.sum(bend * target.at(s), axis=1), -1.0, rtol=0.01)
    np.testing.assert_allclose(np.sum(bend * tangent, axis=1), 0, atol=1e-2)
    arcs, distances = target.closest(1.5 * target.at(s[:-1]))
    np.testing.assert_allclose(np.mod(arcs - s[:-1] + 1, target.total), 1, atol=0.02)
    np.testing.assert_allclose(distances, 1.0, atol=1e-3)


def test_sharp_points_are_the_corners_and_only_they():
    target = outline()
    known = np.array([(0, 0), (2, 0), (3, 0), (2, 2), (2, 3), (0, 3)], float)
    found = target.points[target.sharp_points()][:, :2]
    np.testing.assert_allclose(found[np.lexsort(found.T)], known[np.lexsort(known.T)], atol=1e-12)
    assert len(circle(8).sharp_points()) == 0
    square = Polyline(np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0]], float))
    np.testing.assert_array_equal(square.sharp_points(), [1])


@pytest.mark.parametrize("signed", [False, True])
@pytest.mark.parametrize("closed", [False, True])
def test_a_known_curve_is_found_again(closed, signed):
    rng = np.random.default_rng(1)
    angle = (2 if closed else 1) * np.pi * np.arange(8) / 8
    points = np.stack([np.cos(angle), np.sin(angle), 0.2 * np.sin(3 * angle)], 1) * rng.uniform(0.9, 1.1, (8, 1))
    curve = SubdivisionCurve(points, closed)
    target = Polyline(curve.polyline(64), closed)
    near = SubdivisionCurve(points.copy(), closed)
    near.points[slice(None) if closed else slice(1, -1)] += 0.02 * rng.normal(size=(8 if closed else 6, 3))
    begin = two_sided_error(target, near)
    found = minimise(target, near, signed=signed)
    assert begin > 0.01
    assert found.error < 5e-4  # what chords of a sixteenth of a segment are off


@pytest.mark.parametrize("target", [circle(100), ellipse(), damped_wave()], ids=["circle", "ellipse", "wave"])
def test_error_falls_by_the_order_of_cubic_splines(target):
    """By 2^3 at the least as control points double (fourth order in the limit)."""
    few, many = fit_with(target, 6 + target.closed), fit_with(target, 12 + target.closed)
    assert many.error < few.error / 8 + 5e-4 * target.total / 4


@pytest.mark.parametrize(
    ("target", "share"),
    [(circle(60), 5e-4), (ellipse(40), 5e-4), (damped_wave(40), 5e-4), (clothoid(), 2.4e-3)],
    ids=["circle", "ellipse", "wave", "clothoid"],
)
def test_no_more_control_points_than_knot_removal_leaves(target, share):
    tolerance = share * target.total
    found = fit_curve(target, tolerance)
    assert found.error <= tolerance
    assert len(found.curve.points) <= len(knots_removed(target, tolerance, begin=9).curve.points)


def test_bends_that_the_curvature_hardly_shows_get_control_points_too(meshes):
    """The outline of holes, 136 points: placed by its curvature alone 34 are needed, removal of knots leaves 17."""
    data = subdfit.read(meshes / "holes.ply")
    outline = boundary_loops(data.face_vertices.reshape(-1, 3))[0]
    diagonal = np.linalg.norm(np.ptp(data.points, axis=0))
    found = fit_curve(Polyline(data.points[outline.vertices], closed=True), 5e-3 * diagonal)
    assert found.error <= 5e-3 * diagonal
    assert len(found.curve.points) <= 18


@pytest.mark.parametrize("target", [circle(100), ellipse(), damped_wave()], ids=["circle", "ellipse", "wave"])
def test_the_geometric_algorithm_fits_curves(target):
    begin, tolerance = np.linspace(0, target.total, 6), 5e-4 * target.total
    found = fit_geometric(target, SubdivisionCurve(target.at(begin[: 6 - target.closed]), target.closed), tolerance)
    assert found.error <= 3 * tolerance  # samples of the curve between the target's points lie off its chords
    assert found.iterations < 60
    assert len(found.curve.points) < len(target.points) / 4


@pytest.mark.parametrize("closed", [False, True])
def test_geometric_displacements_are_means_by_linear_coordinates(closed):
    curve = SubdivisionCurve(np.arange(15.0).reshape(5, 3), closed)
    errors = np.array([[1.0, 0, 0], [0, 3, 0]])
    moved = displacements(curve, np.array([1.25, 1.75]), errors)
    np.testing.assert_allclose(moved[1], 0.75 * errors[0] + 0.25 * errors[1])
    np.testing.assert_allclose(moved[2], 0.25 * errors[0] + 0.75 * errors[1])
    assert not moved[[0, 3, 4]].any()


@pytest.mark.parametrize("curve", CURVES, ids=lambda c: f"{len(c.points)}{'closed' if c.closed else 'open'}")
def test_halving_all_segments_is_subdivision(curve):
    np.testing.assert_allclose(inserted(curve, np.arange(curve.length)).points, curve.refined().points)


def test_a_straight_line_needs_its_ends_only():
    line = Polyline(np.linspace([0, 0, 0], [1, 2, 3], 30))
    assert len(fit_curve(line, 1e-9).curve.points) == 2


def test_control_points_lie_densest_where_the_target_bends():
    target = ellipse(400)
    arcs = placed_by_curvature(target, 12)
    gaps = np.diff(np.append(arcs, target.total))
    ends = np.abs(target.at(arcs + gaps / 2)[:, 0]) > 2
    assert gaps[ends].max() < gaps[~ends].min()


def test_figure_3(meshes):
    """Sharp points become tagged control points, straight parts need none between, round parts a few."""
    loop = fit_loop(outline(), 0.01)
    assert loop.corners.sum() == 6
    assert loop.error <= 0.01
    assert len(loop.points) <= 18
    mesh = trimesh.load(meshes / "holes.ply", process=False)
    diagonal = np.linalg.norm(np.ptp(mesh.vertices, axis=0))
    for curve in boundary_loops(mesh.faces)[1:4]:
        target = Polyline(np.asarray(mesh.vertices)[curve.vertices], closed=True)
        loop = fit_loop(target, 5e-3 * diagonal)
        assert loop.error <= 5e-3 * diagonal
        assert 3 <= len(loop.points) <= 0.25 * len(target.points)


def test_bad_curves_are_refused():
    with pytest.raises(InputError, match="control points"):
        SubdivisionCurve(np.zeros((2, 3)), closed=True)
    with pytest.raises(InputError, match="tolerance"):
        fit_curve(circle(9), 0.0)
    with pytest.raises(InputError, match="point 4 of the chain is not finite"):
        fit_curve(Polyline(np.where(np.arange(9)[:, None] == 4, np.nan, circle(9).points)), 0.1)
    with pytest.raises(InputError, match="2 or more"):
        fit_curve(Polyline(circle(9).points[:1]), 0.1)
    with pytest.raises(InputError, match="open"):
        fit_loop(Polyline(circle(9).points, closed=False), 0.1)
