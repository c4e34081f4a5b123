"""Pieces of the method lavoue, called alone: where the guide says they are, and what they refuse."""

import importlib
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from subdfit import InputError
from subdfit.curves.fitting import fit_curve, knots_removed
from subdfit.curves.loops import fit_loop
from subdfit.curves.polyline import Polyline
from subdfit.fit.lavoue_enrichment import Faces, is_diffuse, principal_error_field
from subdfit.fit.lavoue_lightening import lightened
from subdfit.fit.lavoue_open import OpenFit, fit_open
from subdfit.fit.lavoue_optimisation import optimise
from subdfit.fit.lavoue_whole import cut_part, whole_start
from subdfit.initial.lavoue import BoundaryPolygon, boundary_start
from subdfit.initial.lavoue_contour import topologic_contour
from subdfit.initial.lavoue_convex import convex_parts
from subdfit.initial.lavoue_scores import ScoredSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.target.curvature import curvature_field
from subdfit.target.curves import boundary_loops
from subdfit.target.target import mesh_target

GUIDE = Path(__file__).parents[2] / "docs" / "user-guide.md"


@pytest.fixture(scope="module")
def given(sheet, sphere):
    """An open sheet and a closed ball, and what the pieces make of them."""
    points, triangles = sheet
    field, target = curvature_field(*sheet), mesh_target(*sheet)
    quad = Topology.from_faces([0, 4], [0, 1, 2, 3], 4, corner_vertices=[0, 1, 2, 3])
    mesh = ControlMesh(quad, points[[0, 600, 624, 24]], "catmull-clark")
    tetrahedron = Topology.from_triangles([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], 4)
    return SimpleNamespace(
        points=points,
        triangles=triangles,
        field=field,
        target=target,
        surface=ScoredSurface(points, triangles, field),
        rim=boundary_loops(triangles)[0].vertices[::12],
        mesh=mesh,
        found=OpenFit(mesh, 0.0, 0.0, True, []),
        ball=mesh_target(*sphere),
        ball_field=curvature_field(*sphere),
        closed=ControlMesh(tetrahedron, np.vstack([np.zeros(3), np.eye(3)]), "catmull-clark"),
        part=cut_part(mesh_target(*sphere)),
    )


def chain(points=None):
    """A chain of 20 points along an arc."""
    angle = np.linspace(0, 3, 20)
    return Polyline(np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]) if points is None else points)


def spoiled(points, row=3):
    """The points with one that is not finite."""
    return np.where(np.arange(len(points))[:, None] == row, np.nan, points)


MESHES = {
    "no points": (lambda p, t: (np.empty((0, 3)), t), "three coordinates"),
    "points in the plane": (lambda p, t: (p[:, :2], t), "three coordinates"),
    "points that are text": (lambda p, t: ("x", t), "no array of numbers"),
    "a point that is not finite": (lambda p, t: (spoiled(p), t), "point 3 of the .* is not finite"),
    "no triangles": (lambda p, t: (p, t[:0]), "no triangles"),
    "quads": (lambda p, t: (p, t[:, [0, 1, 2, 0]]), r"shape \(1152, 4\)"),
    "triangles that are text": (lambda p, t: (p, "y"), "not whole numbers"),
    "halves": (lambda p, t: (p, t + 0.5), "not whole numbers"),
    "rows beyond": (lambda p, t: (p, t + 1), r"name 625 in row \d+, outside 0\.\.624"),
    "negative rows": (lambda p, t: (p, t - 1), r"name -1 in row 0, outside 0\.\.624"),
}
TAKERS = {
    "curvature_field": lambda g, p, t: curvature_field(p, t),
    "mesh_target": lambda g, p, t: mesh_target(p, t),
    "boundary_start": lambda g, p, t: boundary_start(p, t, []),
    "ScoredSurface": lambda g, p, t: ScoredSurface(p, t, g.field),
}


@pytest.mark.parametrize(("spoil", "what"), MESHES.values(), ids=MESHES)
@pytest.mark.parametrize("take", TAKERS.values(), ids=TAKERS)
def test_arrays_that_are_no_mesh_are_refused(given, take, spoil, what):
    with pytest.raises(InputError, match=what):
        take(given, *spoil(given.points, given.triangles))


NO_LENGTHS = [0, -1.0, np.nan, "0.1%", None]
TOLERANT = {
    "fit_curve": lambda g, tolerance: fit_curve(chain(), tolerance),
    "fit_loop": lambda g, tolerance: fit_loop(Polyline(chain().points, closed=True), tolerance),
    "knots_removed": lambda g, tolerance: knots_removed(chain(), tolerance, begin=4),
    "fit_open": lambda g, tolerance: fit_open(g.mesh, g.target, g.field, tolerance=tolerance),
    "lightened": lambda g, tolerance: lightened(g.found, g.target, g.field, tolerance),
    "whole_start": lambda g, tolerance: whole_start(g.part, tolerance),
}


@pytest.mark.parametrize("take", TOLERANT.values(), ids=TOLERANT)
def test_tolerances_are_positive_lengths(given, take):
    # None is a tolerance of fit_open: the paper's.
    for tolerance in NO_LENGTHS[: -1 if take is TOLERANT["fit_open"] else None]:
        with pytest.raises(InputError, match=f"tolerance of .* is {tolerance}; give a positive length"):
            take(given, tolerance)


CALLS = [
    ("radius", lambda g: curvature_field(g.points, g.triangles, "2%"), "radii are no array of numbers"),
    ("radii", lambda g: curvature_field(g.points, g.triangles, [1.0, 2.0]), r"shape \(2,\) for 625 points"),
    ("triangle beyond", lambda g: g.field.at([1152], [[0.1, 0.1]]), r"outside 0\.\.1151"),
    ("negative triangle", lambda g: g.field.at([-1], [[0.1, 0.1]]), r"outside 0\.\.1151"),
    ("too few parameters", lambda g: g.field.at([0, 1], [[0.1, 0.1]]), "for 2 triangles; give one pair"),
    ("parameters outside", lambda g: g.field.at([0, 1], [[0.5, 0.5], [0.6, 0.5]]), "row 1: .* outside the triangle"),
    ("parameters not finite", lambda g: g.field.at([0], [[np.nan, 0.1]]), "outside the triangle"),
    ("chain in the plane", lambda g: chain(np.ones((9, 2))), "three coordinates"),
    ("chain not finite", lambda g: chain(spoiled(chain().points)), "point 3 of the chain is not finite"),
    ("chain of one", lambda g: chain(np.ones((1, 3))), "2 or more"),
    ("fit of one place", lambda g: fit_curve(chain(np.ones((9, 3))), 0.1), "coincide"),
    ("loop of one place", lambda g: fit_loop(Polyline(np.ones((9, 3)), closed=True), 0.1), "coincide"),
    ("knots of one place", lambda g: knots_removed(chain(np.ones((9, 3))), 0.1, begin=4), "coincide"),
    ("too few knots", lambda g: knots_removed(chain(), 0.1, begin=1), "begins with 1 control point"),
    ("another's curvature", lambda g: ScoredSurface(g.points, g.triangles, g.ball_field), "curvature of 642 vertices"),
    (
        "curvature of other triangles",
        lambda g: ScoredSurface(g.points, g.triangles[::-1], g.field),
        "curvature is that of other triangles",
    ),
    ("unknown paths", lambda g: ScoredSurface(g.points, g.triangles, g.field, paths="straight"), "choose geodesic or"),
    ("unknown paths asked", lambda g: g.surface.find([[0, 9]], "straight"), "choose geodesic or"),
    # The library that straightens paths walks for ever from a vertex before the first.
    ("path from nowhere", lambda g: g.surface.find([[-1, 3]]), "pairs name -1"),
    ("path to nowhere", lambda g: g.surface.find([[0, 10**6]]), "pairs name 1000000"),
    ("path to itself", lambda g: g.surface.find([[5, 5]]), "no path joins vertices 5 and 5"),
    ("path along edges to itself", lambda g: g.surface.find([[5, 5]], "dijkstra"), "no path joins vertices 5 and 5"),
    ("no pairs", lambda g: g.surface.find([1, 2, 3]), "give 2 vertices a row"),
    ("scores of pairs", lambda g: g.surface.scores([[0, 1]]), "three coordinates"),
    ("scores of a place", lambda g: g.surface.scores([np.zeros((1, 3))]), "2 or more"),
    ("anchors of no boundary", lambda g: topologic_contour(g.surface, g.rim, [0]), "1 boundaries for"),
    ("no anchors", lambda g: topologic_contour(g.surface, [], []), "0 anchors"),
    ("anchor beyond", lambda g: topologic_contour(g.surface, [0, 625], [0, 0]), "anchors name 625"),
    ("anchor inside", lambda g: topologic_contour(g.surface, [0, 301], [0, 0]), "anchor 301 lies inside"),
    ("anchor twice", lambda g: topologic_contour(g.surface, [0, 0, 1], [0, 0, 0]), "the same vertex"),
    ("boundary beyond", lambda g: topologic_contour(g.surface, g.rim, 0 * g.rim + 1), r"outside 0\.\.0"),
    ("negative boundary", lambda g: topologic_contour(g.surface, g.rim, 0 * g.rim - 1), r"outside 0\.\.0"),
    ("place beyond", lambda g: convex_parts([[0, 1, 2], [0, 2, 4]], np.eye(4, 3), range(4)), "ring 1 name 4"),
    ("negative place", lambda g: convex_parts([[-1, 0, 1]], np.eye(4, 3), range(4)), "ring 0 name -1"),
    ("ring of two", lambda g: convex_parts([[0, 1]], np.eye(4, 3), range(4)), "three places or more"),
    ("place twice", lambda g: convex_parts([[0, 0, 1]], np.eye(4, 3), range(4)), "all different"),
    ("too few names", lambda g: convex_parts([[0, 1, 2]], np.eye(4, 3), [0]), "give one each"),
    ("empty polygon", lambda g: BoundaryPolygon(np.empty((0, 3)), [], np.empty((0, 3))), "three coordinates"),
    ("polygon of two", lambda g: BoundaryPolygon(np.eye(2, 3), [True] * 2, np.eye(2, 3)), "3 or more"),
    ("polygon not finite", lambda g: BoundaryPolygon(spoiled(np.eye(4, 3)), [True] * 4, np.eye(4, 3)), "not finite"),
    ("too few corners", lambda g: BoundaryPolygon(np.eye(4, 3), [True] * 3, np.eye(4, 3)), "one bool each"),
    ("corners by number", lambda g: BoundaryPolygon(np.eye(4, 3), [0, 1, 2, 3], np.eye(4, 3)), "one bool each"),
    ("too few limits", lambda g: BoundaryPolygon(np.eye(4, 3), [True] * 4, np.eye(3)), "give one each"),
    ("open on closed", lambda g: optimise(g.mesh, g.ball, g.ball_field), "mesh is open and the target closed"),
    ("closed on open", lambda g: optimise(g.closed, g.target, g.field), "mesh is closed and the target open"),
    ("open fit on closed", lambda g: fit_open(g.mesh, g.ball, g.ball_field), "mesh is open and the target closed"),
    ("closed fit on open", lambda g: fit_open(g.closed, g.target, g.field), "mesh is closed and the target open"),
    ("another's", lambda g: lightened(g.found, g.target, g.ball_field, 0.1), "curvature of 642 vertices"),
    ("no distances", lambda g: principal_error_field([], [[0, 1]]), r"shape \(0,\)"),
    ("distances in rows", lambda g: principal_error_field([[1.0], [2.0]], [[0, 1]]), r"shape \(2, 1\)"),
    ("distance not finite", lambda g: principal_error_field([1.0, np.nan], [[0, 1]]), "not finite"),
    ("negative distance", lambda g: principal_error_field([1.0, -1.0], [[0, 1]]), "negative"),
    ("edge beyond", lambda g: principal_error_field([1.0, 2.0], [[0, 2]]), "edges name 2"),
    ("no edges", lambda g: principal_error_field([1.0, 2.0], [0, 1, 1]), "give 2 vertices a row"),
    ("field by number", lambda g: is_diffuse([1.0, 2.0], [0, 1]), "one bool each"),
    ("too short a field", lambda g: is_diffuse([1.0, 2.0], [True]), "one bool each"),
    ("empty field", lambda g: is_diffuse([1.0, 2.0], [False, False]), "true"),
    ("negative vertex", lambda g: Faces.of(g.mesh).take_out(-1), "vertices name -1"),
    ("vertex beyond", lambda g: Faces.of(g.mesh).take_out(4), "vertices name 4"),
    ("negative face", lambda g: Faces.of(g.mesh).enrich_each([-1]), "faces name -1"),
    ("face beyond", lambda g: Faces.of(g.mesh).enrich_each([1]), "faces name 1"),
    ("face twice", lambda g: Faces.of(g.mesh).enrich_each([0, 0]), "all different"),
    ("no face", lambda g: Faces.of(g.mesh).merge_and_insert([0.5], np.zeros(3)), "not whole numbers"),
    ("no place", lambda g: Faces.of(g.mesh).merge_and_insert([0], np.zeros(2)), "three coordinates"),
]


@pytest.mark.parametrize(("call", "what"), [row[1:] for row in CALLS], ids=[row[0] for row in CALLS])
def test_bad_calls_are_refused(given, call, what):
    with pytest.raises(InputError, match=what) as caught:
        call(given)
    assert "\n" not in str(caught.value)


def test_lists_are_as_good_as_arrays(given):
    points, triangles = given.points.tolist(), given.triangles.tolist()
    field = curvature_field(points, triangles)
    np.testing.assert_array_equal(field.tensors, given.field.tensors)
    at, same = field.at([0, 5], [[0.1, 0.2], [0.3, 0.4]]), np.array([[0.1, 0.2], [0.3, 0.4]])
    np.testing.assert_array_equal(at.maximum, field.at(np.array([0, 5]), same).maximum)
    paths = ScoredSurface(points, triangles, field).find([[0, 300]])
    np.testing.assert_array_equal(paths[0], given.surface.find([(0, 300)])[0])
    corners, square = [True] * 4, given.points[given.rim[[0, 2, 4, 6]]].tolist()
    start = boundary_start(points, triangles, [BoundaryPolygon(square, corners, square)])
    np.testing.assert_array_equal(start.points, square)


def test_nothing_has_no_scores(given):
    assert [len(values) for values in given.surface.scores([])] == [0, 0]


def test_no_faces_are_not_merged(given):
    assert not Faces.of(given.mesh).merge_and_insert([], np.zeros(3))


def test_pieces_are_where_the_guide_says():
    table = GUIDE.read_text(encoding="utf-8").split("### Pieces of the method lavoue")[1].split("## ")[0]
    rows = re.findall(r"^\| [^|]* \| `(subdfit[\w.]*)` \| (.*?) \|", table, re.MULTILINE)
    assert len(rows) == 18
    for module, calls in rows:
        for name in re.findall(r"`(\w+)", calls):
            assert hasattr(importlib.import_module(module), name)
