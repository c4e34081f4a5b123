"""A region of a surface lies as the whole does, whatever its faces, and moves as it does; its rim is no boundary."""

import numpy as np
import pytest

from shapes.parameters import SOME, finer, inside
from subdfit.closest.curves import SurfaceCurves
from subdfit.closest.projection import Projector
from subdfit.fit.changes import faces_at, ring
from subdfit.fit.places import Places
from subdfit.fit.regions import Region, regions


def assert_alike(whole, part, cells, inner):
    """Corresponding cells, in their order, are the same surface."""
    names, counterparts = np.flatnonzero(cells), np.flatnonzero(inner)
    assert len(names) == len(counterparts)
    cell, uv = inside(whole.domain, per_cell=2)
    row = np.full(len(cells), -1)
    row[names] = counterparts
    there = cells[cell]
    ours = part.evaluate(row[cell[there]], uv[there], 1)
    theirs = whole.evaluate(cell[there], uv[there], 1)
    np.testing.assert_allclose(ours.position, theirs.position, atol=1e-13)
    np.testing.assert_allclose(ours.first, theirs.first, atol=1e-10 * np.abs(theirs.first).max())


@pytest.mark.parametrize(("scheme", "name"), SOME)
def test_a_region_of_scattered_faces_lies_as_the_whole(scheme, name):
    """Scattered faces have rims that touch at vertices."""
    surface = finer(scheme, name)
    faces = np.random.default_rng(0).random(surface.topology.face_count) < 0.05
    faces[0] = True
    region = Region.of(surface, faces)
    assert_alike(surface, region.surface, faces[Places(surface).face], region.inner)


@pytest.mark.parametrize(("scheme", "name"), SOME)
def test_regions_move_as_the_whole_and_apart_from_one_another(scheme, name):
    surface = finer(scheme, name)
    rng = np.random.default_rng(1)
    moving = np.zeros(surface.topology.vertex_count, bool)
    moving[rng.integers(0, len(moving), 3)] = True
    points = surface.control_mesh.points + 0.1 * rng.normal(size=(len(moving), 3)) * moving[:, None]
    moved = surface.with_points(points)
    claimed, free = np.zeros(surface.domain.face_count, int), np.zeros(len(moving), int)
    for region, cells in regions(surface, moving):
        claimed += cells
        free[region.vertices[region.own]] += 1
        assert_alike(moved, region.surface.with_points(points[region.vertices]), cells, region.inner)
    assert claimed.max() == 1
    assert free.max() == 1
    assert free[moving].all()
    reached = faces_at(surface.topology, ring(surface.topology, moving))
    assert np.array_equal(claimed > 0, reached[Places(surface).face])


@pytest.mark.parametrize(("scheme", "name"), SOME)
def test_the_rim_is_no_boundary(scheme, name):
    """The boundary of a region is what it has of the whole's."""
    surface = finer(scheme, name)
    faces = np.arange(surface.topology.face_count) < 3
    region = Region.of(surface, faces)
    whole, part = SurfaceCurves(surface, inner=False), SurfaceCurves(region.surface, inner=False)
    cells = faces[Places(surface).face]
    assert np.count_nonzero(cells[whole.cell]) == np.count_nonzero(region.inner[part.cell])
    within = np.flatnonzero(region.inner[part.cell])
    if len(within):
        position = region.surface.evaluate(*part.locate(within, np.full(len(within), 0.5))).position
        assert whole.closest(position).distance.max() < 1e-12


@pytest.mark.parametrize(("scheme", "name"), SOME)
def test_footpoints_stay_on_the_region(scheme, name):
    """Those of points elsewhere lie on the rim."""
    surface = finer(scheme, name)
    region = Region.of(surface, np.arange(surface.topology.face_count) < 3)
    points = surface.vertex_limits()
    found = Projector(region.surface).nearest(points)
    assert found.face.min() >= 0
    position = region.surface.evaluate(found.face, found.uv).position
    np.testing.assert_allclose(np.linalg.norm(position - points, axis=1), found.distance, atol=1e-12)
