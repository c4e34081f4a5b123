"""Parts of the data and samples of the surface: what takes part in a round of ``auto``."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from shapes import grids
from subdfit.closest.curves import SurfaceCurves
from subdfit.fit.adapt import refined
from subdfit.fit.changes import cells_moved_by, changed_cells
from subdfit.fit.data import FitData
from subdfit.fit.regions import regions
from subdfit.fit.reverse import DRAWN, CurveSamples, Samples, even_samples, inner_samples, strays
from subdfit.fit.settings import FitSettings
from subdfit.fit.spots import Spot
from subdfit.fit.state import FOOTPOINT_TOLERANCE, FitState
from subdfit.fit.strays import Strays
from subdfit.fit.tangent import TangentSettings
from subdfit.fit.tangential import Tangential
from subdfit.limit import LimitSurface
from subdfit.measure import Tolerance, reverse_segments
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.target.frame import Frame
from subdfit.target.target import Target, mesh_target


@pytest.fixture(scope="module")
def state(dome: Target) -> FitState:
    """A coarse dome under a dense one."""
    from subdfit.initial.start import start_mesh

    inside = dome.normalised(Frame.of(dome.points))
    mesh = start_mesh(inside, 60, 1e-3)
    return FitState.start(FitData.of(inside, 0.1), LimitSurface(mesh, "loop"))


def test_thinning_keeps_so_many_a_cell_and_every_curve_point(state: FitState) -> None:
    some, rows = state.thinned(4)
    count = np.bincount(state.face, minlength=state.surface.domain.face_count)
    inner = state.data.surface_rows
    kept = np.bincount(state.face[rows][inner[rows]], minlength=len(count))
    assert np.all(kept <= 4)
    assert np.all(kept[(np.bincount(state.face[~inner], minlength=len(count)) == 0) & (count >= 4)] == 4)
    assert np.array_equal(rows[some.data.boundary], state.data.boundary)
    assert np.array_equal(some.data.points, state.data.points[rows])
    assert np.array_equal(some.distance, state.distance[rows])
    everything, all_rows = state.thinned(10**6)
    assert everything.data is state.data
    assert np.array_equal(all_rows, np.arange(len(state.face)))


def test_following_a_part_gives_what_following_all_gives(state: FitState) -> None:
    points = 1.001 * state.surface.control_mesh.points
    some, rows = state.thinned(4)
    together, alone = state.followed(some.moved(points), rows), state.moved(points)
    np.testing.assert_allclose(together.distance, alone.distance, atol=1e-7)


def test_gaps_are_distances_beyond_the_allowance(state: FitState) -> None:
    target = state.data.target
    samples = inner_samples(state.surface, target, np.arange(state.surface.domain.face_count))
    place = state.surface.evaluate(samples.face, samples.uv).position
    found = target.tree.closest(place)
    beyond = np.maximum(found.distance - target.sagitta(found.triangle, found.uv), 0.0)
    np.testing.assert_allclose(samples.gap, beyond, atol=1e-12)


def test_samples_point_at_the_target(state: FitState) -> None:
    target = state.data.target
    samples = inner_samples(state.surface, target, np.arange(state.surface.domain.face_count))
    far = samples.gap > 1e-4
    place = state.surface.evaluate(samples.face, samples.uv).position[far]
    allowed = target.tree.closest(place).distance - samples.gap[far]
    ahead = place + (samples.gap[far] + allowed)[:, None] * samples.normal[far]
    assert far.any()
    assert target.tree.closest(ahead).distance.max() < 1e-12


def places_of(samples: Samples, surface: LimitSurface) -> cKDTree:
    return cKDTree(surface.evaluate(samples.face, samples.uv).position)


def test_samples_of_some_cells_are_those_of_all(state: FitState) -> None:
    """Those on the sides of these cells too, which others share."""
    cells = np.arange(state.surface.domain.face_count) % 3 == 0
    some, others, everywhere = (strays(state.surface, state.data.target, 1e-4, kept) for kept in (cells, ~cells, None))
    assert np.all(cells[some.face])
    assert not np.any(cells[others.face])
    parts, whole = places_of(some.joined(others), state.surface), places_of(everywhere, state.surface)
    assert parts.query(whole.data)[0].max() < 1e-12
    assert whole.query(parts.data)[0].max() < 1e-12
    assert len(some) + len(others) >= len(everywhere)


def test_strays_are_all_that_stray(state: FitState) -> None:
    bound = 1e-3
    found = strays(state.surface, state.data.target, bound)
    assert len(found)
    assert np.all(found.gap > bound)
    assert len(strays(state.surface, state.data.target, 1.0)) == 0


def test_a_cloud_has_no_reverse_side() -> None:
    from subdfit.target.target import point_target

    points = np.random.default_rng(0).normal(size=(50, 3))
    mesh = ControlMesh.from_triangles(np.eye(4, 3), [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    assert len(strays(LimitSurface(mesh, "loop"), point_target(points), 1e-3)) == 0


def grid(segments: int) -> tuple[np.ndarray, np.ndarray]:
    """Triangles of a square, from 0 to 1."""
    side = np.linspace(0, 1, segments + 1)
    points = np.column_stack([*(a.ravel() for a in np.meshgrid(side, side)), np.zeros((segments + 1) ** 2)])
    return points, grids.triangles_of(grids.vertices(segments + 1, segments + 1).T)


def test_a_boundary_with_fewer_data_than_control_points_lies_on_the_targets() -> None:
    """Between its data a wavy boundary would stay so: the waves lie on the target's face, or off it for no point."""
    points, triangles = grid(2)
    target = mesh_target(points - [0.5, 0.5, 0], triangles, creases="none")
    data = FitData.of(target.normalised(Frame.of(target.points)), 1.0)
    points, triangles = grid(16)
    points -= [0.5, 0.5, 0]
    points[:, :2] *= 1 + 0.05 * np.cos(5 * np.arctan2(points[:, 1], points[:, 0]))[:, None]
    mesh = ControlMesh.from_triangles(points / target.diagonal, triangles)
    state = FitState.start(data, LimitSurface(mesh, "loop"))
    boundary = data.target.boundary_tree
    assert boundary is not None

    def wave(state: FitState) -> float:
        curves = SurfaceCurves(state.surface, inner=False)
        samples = CurveSamples.of(curves, np.arange(len(curves)), boundary)
        return float(np.linalg.norm(samples.gaps(state.surface), axis=1).max())

    method = Tangential(FitSettings(tolerance=Tolerance(max=1e-2), max_control_vertices=len(points)))
    before = wave(state)
    for _ in range(4):
        state = method.advance(state)
    assert before > 0.01
    assert wave(state) < 0.1 * before


def test_a_region_has_the_footpoints_of_the_whole(state: FitState) -> None:
    moving = np.arange(state.surface.topology.vertex_count) == 20
    ((region, cells),) = regions(state.surface, moving)
    rows = state.rows_in(cells)
    assert 0 < len(rows) < len(state.face)
    part = region.state(state, cells)
    np.testing.assert_allclose(part.distance, state.distance[rows], atol=1e-7)
    assert part.boundary is not None
    assert state.boundary is not None
    there = np.isin(state.data.boundary, rows)
    np.testing.assert_allclose(part.boundary.distance, state.boundary.distance[there], atol=1e-9)


def test_points_out_of_reach_keep_their_footpoints(state: FitState) -> None:
    """Those of the part that moves are found as all would be."""
    cells = cells_moved_by(state.surface, np.arange(state.surface.topology.vertex_count) == 20)
    points = state.surface.control_mesh.points.copy()
    points[20] *= 1.02
    moved = state.surface.with_points(points)
    whole, part = state.moved(points), state.onto(moved, state.face, state.uv)
    np.testing.assert_allclose(part.distance, whole.distance, atol=1e-7)
    outside = np.setdiff1d(np.arange(len(state.face)), state.rows_in(cells))
    np.testing.assert_array_equal(part.distance[outside], state.distance[outside])
    assert part.boundary is not None
    assert whole.boundary is not None
    np.testing.assert_allclose(part.boundary.distance, whole.boundary.distance, atol=1e-9)


def test_strays_are_carried_where_nothing_changed(state: FitState) -> None:
    watch = Strays(1e-3)
    before = watch.samples(state)
    points = state.surface.control_mesh.points.copy()
    points[20] *= 1.02
    moved = state.moved(points)
    carried, anew = watch.samples(moved), strays(moved.surface, state.data.target, 1e-3, share=DRAWN)
    changed = changed_cells(state.surface, moved.surface)
    kept, old = carried.face[~changed[carried.face]], before.face[~changed[before.face]]
    assert np.array_equal(kept[: len(old)], old)
    assert places_of(carried, moved.surface).query(places_of(anew, moved.surface).data)[0].max() < 1e-12
    assert places_of(anew, moved.surface).query(places_of(carried, moved.surface).data)[0].max() < 1e-12
    assert carried.gap.max() == pytest.approx(anew.gap.max(), rel=1e-12)


def test_faces_without_data_are_refined() -> None:
    points, triangles = grid(2)
    target = mesh_target(points, triangles, creases="none")
    data = FitData.of(target.normalised(Frame.of(target.points)), 1.0)
    points, _ = grid(8)
    low = (np.arange(8)[:, None] * 9 + np.arange(8)).ravel()
    quads = np.column_stack([low, low + 1, low + 10, low + 9])
    topology = Topology.from_faces(np.arange(0, 4 * len(quads) + 1, 4), quads.ravel(), len(points))
    mesh = ControlMesh(topology, data.target.points.min(axis=0) + points / target.diagonal)
    state = FitState.start(data, LimitSurface(mesh, "catmull-clark"))
    # The third face of the third row: neither it nor its neighbours have any of the nine points.
    finer = refined(state, topology.face == 18)
    assert finer.surface.topology.face_count > topology.face_count
    np.testing.assert_allclose(finer.distance, state.distance, atol=FOOTPOINT_TOLERANCE)


def test_a_spot_without_data_is_drawn_to_the_target(state: FitState) -> None:
    """Where it goes on straying it begins anew, too."""
    moving = np.arange(state.surface.topology.vertex_count) == 20
    ((region, _),) = regions(state.surface, moving)
    free = moving[region.vertices]
    none = FitState.start(state.data.subset(np.empty(0, np.int64)), region.surface)
    points = Spot(none, region.inner, free, 3, TangentSettings(), 1e-9).moved(insistence=8.0)
    before = region.surface.control_mesh.points
    assert np.array_equal(points[~free], before[~free])
    assert not np.array_equal(points[free], before[free])


@pytest.mark.parametrize(("share", "drawn"), [(0.01, False), (0.95, True)])
def test_what_strays_is_drawn_once_few_faces_are_too_far_off(state: FitState, share: float, drawn: bool) -> None:
    bound = share * state.errors.max
    fitter = Tangential(FitSettings(tolerance=Tolerance(max=bound)))
    even = even_samples(state.surface, state.data.target, reverse_segments(state.surface.domain))
    straying = even[even.gap > bound / 2]
    taken = places_of(fitter._samples(state), state.surface)
    assert len(straying)
    assert (taken.query(places_of(straying, state.surface).data)[0].max() < 1e-12) == drawn


def test_the_data_of_a_coarse_part_are_as_dense_as_its_samples() -> None:
    """Faces of the control mesh are cut down to that, and a part of few large triangles needs small ones at corners."""
    box = trimesh.creation.box(extents=np.ones(3) / np.sqrt(3))
    coarse, dense = (mesh_target(mesh.vertices, mesh.faces) for mesh in (box, box.subdivide_to_size(0.02)))
    assert FitData.of(coarse, 0.05).spacing == pytest.approx(0.05)
    sides = dense.points[dense.triangles] - dense.points[np.roll(dense.triangles, 1, axis=1)]
    assert FitData.of(dense, 0.05).spacing == pytest.approx(np.linalg.norm(sides, axis=2).mean())
