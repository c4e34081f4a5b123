"""Surfaces with the counts of Lavoué et al. 2007, Table 1, and the nested loop on them."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from tests.shapes.paper_patches import boss, cushion, tube

from subdfit.curves.loops import fit_loop
from subdfit.curves.polyline import Polyline
from subdfit.fit import lavoue_open
from subdfit.fit.lavoue_enrichment import is_diffuse, principal_error_field
from subdfit.fit.lavoue_lightening import lightened
from subdfit.fit.lavoue_open import concerned, enriched, fit_open
from subdfit.fit.lavoue_optimisation import optimise
from subdfit.initial.lavoue import BoundaryPolygon, boundary_start
from subdfit.limit.surface import LimitSurface
from subdfit.limit.tessellate import lattice
from subdfit.target.curvature import curvature_field
from subdfit.target.curves import boundary_loops
from subdfit.target.features import mesh_edges
from subdfit.target.target import mesh_target

COUNTS = {cushion: (950, 1734), boss: (324, 491), tube: (168, 248)}


def start_of(points, triangles):
    side = np.ptp(points, axis=0).max()
    fits = [fit_loop(Polyline(points[c.vertices], closed=True), 5e-3 * side) for c in boundary_loops(triangles)]
    return boundary_start(points, triangles, [BoundaryPolygon(f.points, f.corners, f.limits) for f in fits])


@pytest.mark.parametrize(("make", "holes"), [(cushion, 0), (boss, 2), (tube, 1)])
def test_counts_are_the_papers(make, holes):
    points, triangles = make()
    assert (len(points), len(triangles)) == COUNTS[make]
    np.testing.assert_array_equal(np.unique(triangles), np.arange(len(points)))
    mesh = trimesh.Trimesh(points, triangles, process=False)
    assert mesh.is_winding_consistent
    assert mesh.euler_number == 1 - holes
    assert len(boundary_loops(triangles)) == holes + 1


def test_points_lie_on_the_formulas():
    points, triangles = tube()
    np.testing.assert_allclose(np.hypot(*points[:, :2].T), 1.0)
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    assert np.sum(np.cross(b - a, c - a) * (a + b + c) * [1, 1, 0], axis=1).min() > 0  # faces look outwards
    points, _ = cushion()
    radius = np.hypot(points[:, 0], points[:, 2])
    assert radius.min() == pytest.approx(1.0)
    assert 1.05 < radius.max() <= 1.06


@pytest.mark.parametrize("scheme", ["quad-triangle", "catmull-clark"])
@pytest.mark.parametrize(("make", "diffuse"), [(cushion, True), (boss, False)])
def test_the_first_error_field_is_as_in_figure_11(make, diffuse, scheme):
    points, triangles = make()
    surface = LimitSurface(replace(start_of(points, triangles), scheme=scheme))
    grid = lattice(surface.domain, 12)
    samples = surface.evaluate(grid.face, grid.uv).position
    distances = mesh_target(points, triangles).tree.closest(samples).distance
    field = principal_error_field(distances, mesh_edges(samples, grid.triangles).vertices)
    assert is_diffuse(distances, field) is diffuse


@pytest.mark.parametrize("scheme", ["quad-triangle", "catmull-clark"])
@pytest.mark.parametrize(("make", "most"), [(cushion, 20), (boss, 16), (tube, 10)])
def test_no_more_control_vertices_than_the_papers(make, most, scheme):
    points, triangles = make()
    start = replace(start_of(points, triangles), scheme=scheme)
    found = fit_open(start, mesh_target(points, triangles), curvature_field(points, triangles))
    assert found.within
    assert len(found.mesh.points) <= most
    assert found.mean <= 5e-3 * np.ptp(points, axis=0).max()


@pytest.mark.parametrize("scheme", ["quad-triangle", "catmull-clark"])
@pytest.mark.parametrize(("make", "asked", "most"), [(cushion, 2.69e-3, 17), (boss, 2.06e-3, 22)])
def test_at_the_papers_errors_vertices_go_and_the_tolerance_holds(make, asked, most, scheme):
    points, triangles = make()
    side = np.ptp(points, axis=0).max()
    target, field, tolerance = mesh_target(points, triangles), curvature_field(points, triangles), asked * side
    start = replace(start_of(points, triangles), scheme=scheme)
    nested = fit_open(start, target, field, tolerance=tolerance)
    found = lightened(nested, target, field, tolerance)
    assert nested.within
    assert found.within
    assert found.mean <= tolerance
    assert found.away <= nested.away
    assert len(found.mesh.points) < len(nested.mesh.points)
    assert len(found.mesh.points) <= most
    again = lightened(found, target, field, tolerance)
    np.testing.assert_array_equal(again.mesh.points, found.mesh.points)


def test_what_begins_to_fold_is_not_built_upon(monkeypatch):
    """Every control mesh that a vertex was put into is made to fold: the next has no more than a refined one before."""
    points, triangles = boss()
    bases, honest = [], lavoue_open.enriched

    def noted(mesh, target, *, diffuse=False):
        bases.append((len(mesh.points), diffuse))
        return honest(mesh, target, diffuse=diffuse)

    def folding(mesh, *how):
        found = optimised(mesh, *how)
        last_was_put_in = bases and not bases[-1][1]
        return replace(found, away=0.5 if last_was_put_in else 0.0, within=False)

    optimised = lavoue_open.optimised
    monkeypatch.setattr(lavoue_open, "enriched", noted)
    monkeypatch.setattr(lavoue_open, "optimised", folding)
    start = start_of(points, triangles)
    found = fit_open(start, mesh_target(points, triangles), curvature_field(points, triangles), most_vertices=40)
    assert not found.within
    assert bases[:2] == [(len(start.points), False), (len(start.points), True)]
    assert found.away == 0.0


def test_faces_that_a_field_only_touches_are_not_concerned():
    """Two triangles with the side 1-2 between them, each cut in three at its middle: 6 and 7 lie inside."""
    triangles = np.array([[0, 1, 6], [0, 6, 2], [1, 2, 6], [1, 5, 7], [5, 2, 7], [2, 1, 7]], np.int32)
    face = np.array([0, 0, 0, 1, 1, 1])
    for field, faces in (([1, 6], [0]), ([1, 2, 7], [1]), ([6, 7], [0, 1]), ([1], [0, 1])):
        assert concerned(np.isin(np.arange(8), field), triangles, face) == faces


def test_one_face_with_a_local_error_gets_its_vertex_where_the_error_is():
    points, triangles = boss()
    start = start_of(points, triangles)
    found = enriched(start, mesh_target(points, triangles))
    assert len(found.points) == len(start.points) + 1
    np.testing.assert_allclose(found.points[-1], [0, 0, 0.2], atol=0.1)  # an edge of the target
    refined = enriched(start, mesh_target(points, triangles), diffuse=True)
    assert len(refined.points) > len(start.points)
    assert refined.points[len(start.points) :, 2].max() < 0.1  # on the faces as they were


def test_rounds_are_run_before_vertices_are_added():
    """The optimisation's few samples are within a tolerance that more samples are not, until it has gone on."""
    points, triangles = boss()
    target, field = mesh_target(points, triangles), curvature_field(points, triangles)
    start = enriched(start_of(points, triangles), target)
    tolerance = 1.05 * optimise(start, target, field, rounds=0, data=True).mean[0]
    surface = LimitSurface(start)
    grid = lattice(surface.domain, 16)
    assert target.tree.closest(surface.evaluate(grid.face, grid.uv).position).distance.mean() > tolerance
    found = fit_open(start, target, field, tolerance=tolerance)
    assert found.within
    assert len(found.mesh.points) == len(start.points)
