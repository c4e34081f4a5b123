"""What the method auto takes for a target: the part's own faces and edges where it bends mostly at its creases."""

import numpy as np
import pytest
import trimesh

import subdfit
from shapes.drilled import drilled_block
from subdfit.api.triangulate import triangles_of
from subdfit.fit.choice import MOSTLY, suits_lavoue
from subdfit.fit.driver import METHODS, fit_target
from subdfit.fit.lavoue import CURVES, Lavoue
from subdfit.fit.settings import FitSettings
from subdfit.fit.starts import UNCERTIFIED
from subdfit.measure import Tolerance
from subdfit.target.features import crease_edges, sharp_share
from subdfit.target.target import cloud_target, mesh_target


@pytest.fixture(scope="module")
def drilled():
    return drilled_block(0.125)


def whole(path):
    data = subdfit.read(path)
    return data.points, triangles_of(data)


def fitted(target, method="auto", scheme="quad-triangle", bound=5e-3, **options):
    return fit_target(mesh_target(*target), FitSettings(scheme, method, Tolerance(max=bound), **options))


@pytest.mark.parametrize(("radius", "height"), [(1.0, 0.2), (1.0, 3.0), (0.3, 5.0)])
@pytest.mark.parametrize("size", [0.1, 0.4])
def test_the_share_of_a_cylinder_is_that_of_its_rims(radius, height, size):
    """Of the two rims, a right angle along each circumference; of its side, a full turn along the height."""
    shape = trimesh.creation.cylinder(radius, height, sections=96).subdivide_to_size(size)
    points, triangles = np.asarray(shape.vertices), np.asarray(shape.faces)
    share = sharp_share(points, triangles, crease_edges(points, triangles, 60.0))
    assert share == pytest.approx(np.pi * radius / (np.pi * radius + height), rel=1e-3)


def test_nothing_bends_in_a_plane_or_is_sharp_on_a_ball():
    ball = trimesh.creation.icosphere(3)
    assert sharp_share(np.asarray(ball.vertices), ball.faces, np.empty((0, 2), np.int64)) == 0
    plane = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]])
    assert sharp_share(*plane, np.array([[0, 2]])) == 0


@pytest.mark.parametrize("scheme", ["quad-triangle", "catmull-clark"])
def test_a_part_with_many_sharp_edges_begins_with_its_own_faces(drilled, scheme):
    chosen, asked = fitted(drilled, scheme=scheme), fitted(drilled, "lavoue", scheme)
    assert chosen.certified
    assert chosen.settings.method == chosen.to_dict()["method"] == "lavoue"
    np.testing.assert_array_equal(chosen.control_mesh.points, asked.control_mesh.points)
    other = fitted(drilled, "tangent", scheme)
    assert other.certified
    assert other.settings.method == "tangent"
    assert chosen.control_mesh.topology.vertex_count < other.control_mesh.topology.vertex_count


def test_noise_does_not_bend_a_part(drilled):
    points, triangles = drilled
    shaken = points + 0.002 * np.linalg.norm(np.ptp(points, axis=0)) * np.random.default_rng(0).normal(
        size=points.shape
    )
    target = mesh_target(shaken, triangles)
    assert sharp_share(shaken, triangles, target.crease_edges) < MOSTLY
    assert suits_lavoue(target, FitSettings("quad-triangle"))


@pytest.mark.parametrize("name", ["fandisk", "block", "casting", "mechpart"])
def test_machined_parts_suit_it(meshes, name):
    points, triangles = whole(meshes / f"{name}.ply")
    assert suits_lavoue(mesh_target(points, triangles), FitSettings("quad-triangle"))


@pytest.mark.parametrize("name", ["bunny", "rocker-arm", "club", "beethoven", "lucy_50k"])
def test_scans_and_blended_shapes_do_not(meshes, name):
    points, triangles = whole(meshes / f"{name}.ply")
    assert not suits_lavoue(mesh_target(points, triangles), FitSettings("quad-triangle"))


def test_neither_do_clouds_other_schemes_and_chosen_beginnings(drilled):
    target = mesh_target(*drilled)
    assert suits_lavoue(target, FitSettings("quad-triangle"))
    assert not suits_lavoue(target, FitSettings("loop"))
    assert not suits_lavoue(target, FitSettings("doo-sabin"))
    assert not suits_lavoue(target, FitSettings("quad-triangle", control_vertices=50))
    assert not suits_lavoue(mesh_target(*drilled, creases="none"), FitSettings("quad-triangle"))
    assert not suits_lavoue(cloud_target(*drilled, creases=40.0), FitSettings("quad-triangle"))


def same_as_tangent(found, target, **options):
    tangent = fitted(target, "tangent", **options)
    assert found.settings.method == "auto"
    np.testing.assert_array_equal(found.control_mesh.points, tangent.control_mesh.points)
    return tangent


def test_where_they_are_more_than_the_budget_its_mesh_is_decimated(drilled):
    assert len(fitted(drilled, "lavoue").control_mesh.points) > 14
    same_as_tangent(fitted(drilled, max_control_vertices=14), drilled, max_control_vertices=14)


@pytest.fixture
def idle(monkeypatch):
    """The method lavoue does not get beyond its start, which is coarse; a tolerance that it misses."""
    monkeypatch.setattr(Lavoue, "advance", lambda self, state: state)
    monkeypatch.setitem(CURVES, "max", 5.0)
    return 5e-4


def test_where_they_give_no_certified_fit_its_mesh_is_decimated(drilled, idle):
    assert not fitted(drilled, "lavoue", bound=idle).certified
    assert same_as_tangent(fitted(drilled, bound=idle), drilled, bound=idle).certified


@pytest.fixture
def idle_at_first(monkeypatch):
    """The same of the first fit by lavoue alone."""
    first, advance = [], Lavoue.advance

    def advanced(self, state):
        first.append(self)
        return state if self is first[0] else advance(self, state)

    monkeypatch.setattr(Lavoue, "advance", advanced)
    monkeypatch.setitem(CURVES, "max", 50.0)
    return 5e-4


def test_lavoue_itself_begins_again_with_its_mesh_decimated(drilled, idle_at_first, caplog):
    found = fitted(drilled, "lavoue", bound=idle_at_first)
    assert UNCERTIFIED in caplog.text
    assert found.certified
    assert found.settings.method == "lavoue"


def test_of_two_fits_without_a_certificate_the_nearer_is_kept(drilled, idle):
    """Neither gets beyond its start, from the part's own curves or from its mesh, with which `tangent` begins."""
    found, decimated = fitted(drilled, "lavoue", bound=idle), fitted(drilled, "tangent", bound=idle).history[0]
    assert not found.certified
    assert found.measurement.max < decimated.max
    assert found.history[0].control_vertices < decimated.control_vertices


def pipe(thickness):
    shape = trimesh.creation.annulus(1 - thickness, 1.0, 2.0, sections=48).subdivide_to_size(0.3)
    return np.asarray(shape.vertices), np.asarray(shape.faces)


def test_where_sheets_would_be_mixed_up_its_mesh_is_decimated():
    """Walls so thin that the first surface's inner side lies outside the outer one."""
    assert suits_lavoue(mesh_target(*pipe(0.02)), FitSettings("quad-triangle"))
    assert same_as_tangent(fitted(pipe(0.02)), pipe(0.02)).certified


def test_the_other_face_at_a_rim_is_no_other_sheet():
    """The nearest triangle beside a rim may be one at a right angle: a pipe begins with four points a rim, and five."""
    found = fitted(pipe(0.1))
    assert found.certified
    assert found.settings.method == "lavoue"
    assert found.control_mesh.topology.vertex_count <= 20


def test_ctrl_c_in_the_second_fit_keeps_the_first(drilled, idle, monkeypatch):
    def stopped(settings):
        raise KeyboardInterrupt

    monkeypatch.setitem(METHODS, "auto", stopped)
    found = fitted(drilled, bound=idle)
    assert found.status == "interrupted"
    assert not found.certified
    np.testing.assert_array_equal(found.control_mesh.points, fitted(drilled, "lavoue", bound=idle).control_mesh.points)
